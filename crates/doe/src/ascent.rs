//! Ascent to a local maximum of the prediction variance.

use crate::matrix::{axpy, cholesky, dot, multiply};
use crate::same::SAME;
use crate::shape::{Axis, BoxShape};
use crate::{PredictionVariance, polynomial};

/// The allowed level with the largest value of the line, and that value; the first of equals.
pub(crate) fn best_level(
    shape: &BoxShape,
    point: &[f64],
    axis: usize,
    levels: &[f64],
    line: &[f64],
) -> Option<(f64, f64)> {
    let blocked = shape.blocked_along(point, axis);
    let allowed = |x: f64| !blocked.iter().any(|[a, b]| a - SAME <= x && x <= b + SAME);
    let values = levels.iter().filter(|&&x| allowed(x)).map(|&x| (x, polynomial::value(line, x)));
    values.reduce(|a, b| if b.1 > a.1 { b } else { a })
}

/// The maximum uphill on the line through a point along an axis, or the best level, among what the shape allows there.
fn best_on_line(shape: &BoxShape, point: &[f64], axis: usize, line: &[f64]) -> Option<(f64, f64)> {
    match &shape.axes[axis] {
        Axis::Levels(levels) => best_level(shape, point, axis, levels, line),
        Axis::Continuous => {
            let mut blocked = shape.blocked_along(point, axis);
            blocked.sort_by(|a, b| a[0].total_cmp(&b[0]));
            let mut free = Vec::with_capacity(blocked.len() + 1);
            let mut from = -1.0;
            for [a, b] in blocked {
                if a >= from {
                    free.push([from, a.min(1.0)]);
                }
                from = f64::max(from, b);
            }
            if from <= 1.0 {
                free.push([from, 1.0]);
            }
            let x = point[axis];
            let piece = free.into_iter().find(|[a, b]| *a <= x && x <= *b)?;
            // To the nearest maximum only: a jump to a higher one elsewhere would leave this one unseen.
            Some(polynomial::uphill(line, piece, x))
        }
    }
}

/// Ascent to a local maximum: coordinate by coordinate, each step to the maximum uphill on its line, and from where no
/// coordinate alone improves along the direction of largest curvature, if that is upward. The point and v there.
pub(crate) fn climb(variance: &PredictionVariance, shape: &BoxShape, start: &[f64]) -> (Vec<f64>, f64) {
    const MOST_ESCAPES: usize = 20;
    let mut point = start.to_vec();
    let mut value = variance.value(&point);
    for _ in 0..MOST_ESCAPES {
        climb_axes(variance, shape, &mut point, &mut value);
        finish(variance, shape, &mut point, &mut value);
        if !escape(variance, shape, &mut point, &mut value) {
            break;
        }
    }
    (point, value)
}

fn climb_axes(variance: &PredictionVariance, shape: &BoxShape, point: &mut [f64], value: &mut f64) {
    const MOST_SWEEPS: usize = 200;
    let mut line = vec![0.0; variance.largest_power() + 1];
    for _ in 0..MOST_SWEEPS {
        let before = *value;
        for axis in 0..point.len() {
            variance.along(point, axis, &mut line);
            if let Some((x, best)) = best_on_line(shape, point, axis, &line)
                && best > *value
            {
                point[axis] = x;
                *value = best;
            }
        }
        if *value - before <= 1e-13 * value.abs() {
            break;
        }
    }
}

/// Newton's steps in the free coordinates: along a ridge between the axes the ascent coordinate by coordinate is slow.
fn finish(variance: &PredictionVariance, shape: &BoxShape, point: &mut [f64], value: &mut f64) {
    const STEPS: usize = 6;
    for _ in 0..STEPS {
        let free = free_axes(shape, point);
        let n = free.len();
        let mut line = vec![0.0; variance.largest_power() + 1];
        let mut downward = vec![0.0; n * n];
        let mut step = vec![0.0; n];
        for (a, &i) in free.iter().enumerate() {
            variance.along(point, i, &mut line);
            step[a] = polynomial::slope(&line, point[i]);
            for (b, &j) in free.iter().enumerate() {
                downward[a * n + b] = -variance.second(point, i, j);
            }
        }
        if n == 0 || cholesky(&mut downward, n, 1e-14).is_none() {
            return;
        }
        for a in 0..n {
            let sum = dot(&downward[a * n..a * n + a], &step[..a]);
            step[a] = (step[a] - sum) / downward[a * n + a];
        }
        for a in (0..n).rev() {
            step[a] /= downward[a * n + a];
            let (earlier, rest) = step.split_at_mut(a);
            axpy(-rest[0], &downward[a * n..a * n + a], earlier);
        }
        let mut trial = point.to_vec();
        for (&j, d) in free.iter().zip(&step) {
            trial[j] = (trial[j] + d).clamp(-1.0, 1.0);
        }
        let height = variance.value(&trial);
        if height <= *value || shape.forbids(&trial) {
            return;
        }
        point.copy_from_slice(&trial);
        *value = height;
    }
}

/// Where every coordinate alone is at its best a saddle still rises between the axes: moves along the direction of the
/// largest curvature in the coordinates that are free, and says whether that helped.
fn escape(variance: &PredictionVariance, shape: &BoxShape, point: &mut [f64], value: &mut f64) -> bool {
    let free = free_axes(shape, point);
    if free.len() < 2 {
        return false;
    }
    let hessian = hessian(variance, point, &free);
    let Some((direction, rise)) = steepest(&hessian, free.len()) else {
        return false;
    };
    if rise <= 1e-9 * value.abs() {
        return false;
    }
    match highest_along(variance, shape, point, *value, (&free, &direction)) {
        Some((trial, height)) if height > *value * (1.0 + 1e-13) => {
            point.copy_from_slice(&trial);
            *value = height;
            true
        }
        _ => false,
    }
}

/// Continuous axes along which a point may move both ways.
fn free_axes(shape: &BoxShape, point: &[f64]) -> Vec<usize> {
    (0..point.len()).filter(|&j| shape.axes[j] == Axis::Continuous && point[j].abs() < 1.0).collect()
}

/// Second derivatives along the free axes.
fn hessian(variance: &PredictionVariance, point: &[f64], free: &[usize]) -> Vec<f64> {
    let n = free.len();
    let mut hessian = vec![0.0; n * n];
    for (a, &i) in free.iter().enumerate() {
        for (b, &j) in free.iter().enumerate().take(a + 1) {
            let curvature = variance.second(point, i, j);
            hessian[a * n + b] = curvature;
            hessian[b * n + a] = curvature;
        }
    }
    hessian
}

/// The direction of the largest curvature, of unit length, and that curvature; none if there is no curvature.
///
/// Power iteration, shifted so that the largest eigenvalue is also the largest in magnitude.
fn steepest(hessian: &[f64], n: usize) -> Option<(Vec<f64>, f64)> {
    let size = hessian.iter().map(|h| h * h).sum::<f64>().sqrt();
    let mut direction: Vec<f64> = (0..n).map(|i| 1.0 + 0.1 * i as f64).collect();
    let mut next = vec![0.0; n];
    let mut rise = 0.0;
    for _ in 0..60 {
        multiply(hessian, n, &direction, &mut next);
        let square: f64 = direction.iter().map(|d| d * d).sum();
        rise = dot(&direction, &next) / square;
        axpy(size, &direction, &mut next);
        let length = next.iter().map(|d| d * d).sum::<f64>().sqrt();
        if length <= 0.0 {
            return None;
        }
        direction.iter_mut().zip(&next).for_each(|(d, next)| *d = next / length);
    }
    Some((direction, rise))
}

/// The highest of some allowed points forward and backward along a direction, if one is higher than `value`.
fn highest_along(
    variance: &PredictionVariance,
    shape: &BoxShape,
    point: &[f64],
    value: f64,
    (free, direction): (&[usize], &[f64]),
) -> Option<(Vec<f64>, f64)> {
    let mut best: Option<(Vec<f64>, f64)> = None;
    for sign in [1.0, -1.0] {
        let room = |(&j, d): (&usize, &f64)| {
            if *d == 0.0 { f64::INFINITY } else { ((d * sign).signum() - point[j]) / (d * sign) }
        };
        let longest = free.iter().zip(direction).map(room).fold(f64::INFINITY, f64::min);
        for fraction in [1.0, 0.75, 0.5, 0.3, 0.2, 0.1, 0.05, 0.02, 0.01, 0.003, 0.001] {
            let mut trial = point.to_vec();
            for (&j, d) in free.iter().zip(direction) {
                trial[j] = (trial[j] + sign * fraction * longest * d).clamp(-1.0, 1.0);
            }
            let height = variance.value(&trial);
            if height > value.max(best.as_ref().map_or(value, |best| best.1)) && !shape.forbids(&trial) {
                best = Some((trial, height));
            }
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Design, Forbidden, Model};

    fn square() -> BoxShape {
        BoxShape { axes: vec![Axis::Continuous; 2], forbidden: Vec::new() }
    }

    /// Eight runs around the center, where the prediction variance has a maximum, and none of its axes is one of the factors.
    fn variance() -> PredictionVariance {
        let runs =
            [[-1.0, -1.0], [1.0, -0.9], [-0.8, 1.0], [1.0, 1.0], [0.2, -1.0], [-0.1, 1.0], [-1.0, 0.3], [1.0, 0.1]];
        PredictionVariance::of(&Model::quadratic(2).unwrap(), &Design::from_runs(&runs).unwrap()).unwrap()
    }

    #[test]
    fn best_level_is_the_highest_that_is_not_forbidden() {
        let levels = [-1.0, -0.5, 0.0, 0.5, 1.0];
        let corner = |range| Forbidden::new(vec![Some(range), Some([0.0, 1.0])]).unwrap();
        let shape = |range| BoxShape {
            axes: vec![Axis::Levels(levels.to_vec()), Axis::Continuous],
            forbidden: vec![corner(range)],
        };
        // Highest at the level -0.5, then at 0, then at -1.
        let line = [2.0, -0.8, -1.0];
        let best = |range, other: f64| best_level(&shape(range), &[1.0, other], 0, &levels, &line).map(|(x, _)| x);
        assert_eq!(best([-0.5, 0.3], -0.5), Some(-0.5), "nothing is forbidden there");
        assert_eq!(best([-0.5, -0.1], 0.5), Some(0.0));
        assert_eq!(best([-0.7, 0.0], 0.5), Some(-1.0));
        assert_eq!(best([-1.0, 0.5], 0.5), Some(1.0));
        assert_eq!(best([-1.0, 1.0], 0.5), None);
    }

    #[test]
    fn newtons_steps_end_where_no_slope_is_left() {
        let variance = variance();
        let mut point = Vec::new();
        let mut value = 0.0;
        for start in [[0.08, -0.11], [0.3, 0.1], [-0.3, -0.1], [0.2, -0.4], [-0.2, 0.3]] {
            point = start.to_vec();
            let before = variance.value(&point);
            value = before;
            finish(&variance, &square(), &mut point, &mut value);
            let slopes = variance.gradient(&point).unwrap();
            assert!(
                value > before && slopes.iter().all(|slope| slope.abs() < 1e-9),
                "{start:?} to {point:?}: {slopes:?}"
            );
        }
        let there = point.clone();
        assert!(!escape(&variance, &square(), &mut point, &mut value), "nothing rises from a maximum");
        assert_eq!(point, there);
    }

    #[test]
    fn highest_is_not_below_any_point_of_a_fine_lattice() {
        let variance = variance();
        let (at, value) = crate::maximum::highest(&variance, &square(), &|| false);
        assert!((variance.value(&at) - value).abs() < 1e-12 && square().contains(&at), "{at:?}");
        let axis = || (-20..=20).map(|step| f64::from(step) / 20.0);
        let most = axis().flat_map(|x| axis().map(move |y| [x, y])).map(|point| variance.value(&point));
        assert!(most.fold(0.0, f64::max) <= value * (1.0 + 1e-12), "{value} at {at:?}");
    }

    #[test]
    fn second_derivatives_are_the_slopes_of_the_gradient() {
        let (variance, point, h) = (variance(), [0.3, -0.6], 1e-5);
        let hessian = hessian(&variance, &point, &[0, 1]);
        for i in 0..2 {
            let at = |by: f64| {
                let mut moved = point;
                moved[i] += by;
                variance.gradient(&moved).unwrap()
            };
            let (above, below) = (at(h), at(-h));
            for j in 0..2 {
                let slope = (above[j] - below[j]) / (2.0 * h);
                assert!((hessian[2 * i + j] - slope).abs() < 1e-7 * slope.abs().max(1.0), "{i}, {j}: {slope}");
            }
        }
        assert_eq!(free_axes(&square(), &[0.2, -1.0]), [0], "at a bound there is one way only");
    }

    /// Of [2 1; 1 -3] the larger eigenvalue is (sqrt(29) - 1)/2.
    #[test]
    fn steepest_direction_is_the_eigenvector_of_the_largest_eigenvalue() {
        let (direction, rise) = steepest(&[2.0, 1.0, 1.0, -3.0], 2).unwrap();
        let expected = 0.5 * (29.0_f64.sqrt() - 1.0);
        assert!((rise - expected).abs() < 1e-9, "{rise}");
        assert!((direction[0].hypot(direction[1]) - 1.0).abs() < 1e-12, "{direction:?}");
        assert!((2.0 * direction[0] + direction[1] - rise * direction[0]).abs() < 1e-6, "{direction:?}");
        assert!(steepest(&[0.0; 4], 2).is_none(), "nothing is curved");
    }

    /// v = (1 + x² + y²)/4 of a factorial rises to the bound; forward x ends at 1, backward y at -1, which is lower.
    #[test]
    fn highest_point_along_a_direction_is_at_the_bound_of_a_cup() {
        let corners = Design::from_runs(&[[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]]).unwrap();
        let variance = PredictionVariance::of(&Model::linear(2).unwrap(), &corners).unwrap();
        let along = |direction: &[f64; 2]| {
            let start = variance.value(&[0.2, -0.1]);
            highest_along(&variance, &square(), &[0.2, -0.1], start, (&[0, 1], direction)).unwrap()
        };
        for direction in [[0.6, 0.8], [-0.6, -0.8]] {
            let (point, height) = along(&direction);
            assert!((point[0] - 1.0).abs() < 1e-12 && (point[1] - (0.8 * 0.8 / 0.6 - 0.1)).abs() < 1e-12, "{point:?}");
            assert!((height - 0.25 * (2.0 + point[1] * point[1])).abs() < 1e-12, "{height}");
        }
        assert!((along(&[0.0, 1.0]).0[1].abs() - 1.0).abs() < 1e-12, "along one axis alone");
    }
}
