//! The largest prediction variance over a space.

use rayon::prelude::*;

use crate::polynomial;
use crate::space::{Axis, BoxShape, List, Shape};
use crate::{Over, PredictionVariance, Space};

/// The largest prediction variance, where it is, over which set and how it was found.
///
/// Over a continuous box v is a polynomial: every local maximum of a lattice is improved coordinate by coordinate,
/// each time to the maximum uphill of the polynomial of one variable, until nothing improves.
#[derive(Debug, Clone, PartialEq)]
pub struct Maximum {
    /// v there, for unit variance of a run.
    pub value: f64,
    /// The coded point.
    pub at: Vec<f64>,
    /// The set that was maximized over.
    pub over: Over,
    /// How.
    pub method: Method,
}

/// How a maximum was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// Every point was looked at.
    Scan {
        /// How many.
        n_points: u64,
    },
    /// By ascent from the local maxima of a lattice.
    Ascent {
        /// Number of lattice points looked at.
        n_lattice: usize,
        /// Number of ascents.
        n_starts: usize,
    },
}

impl Maximum {
    /// Grids up to this many points are looked at point by point.
    pub const MOST_SCANNED: u64 = 50_000_000;
}

/// Largest number of lattice points of a search for maxima.
const LATTICE: usize = 80_000;
/// Ascents start from lattice maxima above this fraction of the largest.
const PROMISING: f64 = 0.5;
/// And from this many at most.
const MOST_STARTS: usize = 400;

pub(crate) fn over(variance: &PredictionVariance, space: &Space) -> Maximum {
    let over = space.over();
    match space.shape() {
        Shape::List(list) => {
            let (at, value) = scan_list(variance, list);
            let method = Method::Scan { n_points: list.n_points() as u64 };
            Maximum { value, at: list.point(at).to_vec(), over, method }
        }
        Shape::Box(shape) => match space.n_points() {
            Some(n_points) if n_points <= Maximum::MOST_SCANNED => {
                let (at, value) = scan_grid(variance, shape);
                Maximum { value, at, over, method: Method::Scan { n_points } }
            }
            _ => {
                let (at, value, method) = ascents(variance, shape, LATTICE);
                Maximum { value, at, over, method }
            }
        },
    }
}

/// The highest maximum from a lattice of moderate size, for use within a search.
pub(crate) fn highest(variance: &PredictionVariance, shape: &BoxShape) -> (Vec<f64>, f64) {
    let (at, value, _) = ascents(variance, shape, LATTICE / 8);
    (at, value)
}

fn ascents(variance: &PredictionVariance, shape: &BoxShape, most: usize) -> (Vec<f64>, f64, Method) {
    let lattice = Lattice::of(shape, most);
    let values = lattice.values(variance);
    let starts = lattice.local_maxima(&values, PROMISING, MOST_STARTS);
    let method = Method::Ascent { n_lattice: lattice.n_points(), n_starts: starts.len() };
    let climbed = starts.par_iter().map(|&start| climb(variance, shape, &lattice.point(start)));
    let best = climbed.collect::<Vec<_>>().into_iter().reduce(|a, b| if b.1 > a.1 { b } else { a });
    let (at, value) = best.unwrap_or_else(|| (vec![f64::NAN; shape.axes.len()], f64::NAN));
    (at, value, method)
}

fn scan_list(variance: &PredictionVariance, list: &List) -> (usize, f64) {
    let value = |(index, point): (usize, &[f64])| (index, variance.value(point));
    let larger = |a: (usize, f64), b: (usize, f64)| if b.1 > a.1 || b.1 >= a.1 && b.0 < a.0 { b } else { a };
    list.coordinates
        .par_chunks_exact(list.n_factors)
        .enumerate()
        .with_min_len(1024)
        .map(value)
        .reduce(|| (0, f64::NEG_INFINITY), larger)
}

/// Line by line along the last axis, where v is a polynomial of one variable.
fn scan_grid(variance: &PredictionVariance, shape: &BoxShape) -> (Vec<f64>, f64) {
    let last = shape.axes.len() - 1;
    let lattice = Lattice { levels: shape.axes[..last].iter().map(level_values).collect(), allowed: None };
    let levels = level_values(&shape.axes[last]);
    let scan = |index: usize| {
        let mut point = lattice.point(index);
        point.push(0.0);
        let mut line = vec![0.0; variance.largest_power() + 1];
        variance.along(&point, last, &mut line);
        let best = best_level(shape, &point, last, &levels, &line);
        best.map_or((index, 0.0, f64::NEG_INFINITY), |(x, value)| (index, x, value))
    };
    let larger = |a: (usize, f64, f64), b: (usize, f64, f64)| if b.2 > a.2 || b.2 >= a.2 && b.0 < a.0 { b } else { a };
    let none = || (usize::MAX, 0.0, f64::NEG_INFINITY);
    let (index, x, value) = (0..lattice.n_points()).into_par_iter().with_min_len(64).map(scan).reduce(none, larger);
    let mut at = lattice.point(index);
    at.push(x);
    (at, value)
}

fn level_values(axis: &Axis) -> Vec<f64> {
    match axis {
        Axis::Levels(levels) => levels.clone(),
        Axis::Continuous => vec![-1.0, 1.0],
    }
}

/// The allowed level with the largest value of the line, and that value; the first of equals.
fn best_level(shape: &BoxShape, point: &[f64], axis: usize, levels: &[f64], line: &[f64]) -> Option<(f64, f64)> {
    let blocked = shape.blocked_along(point, axis);
    let allowed = |x: f64| !blocked.iter().any(|[a, b]| a - crate::space::SAME <= x && x <= b + crate::space::SAME);
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
        let free: Vec<usize> =
            (0..point.len()).filter(|&j| shape.axes[j] == Axis::Continuous && point[j].abs() < 1.0).collect();
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
        if n == 0 || crate::matrix::cholesky(&mut downward, n, 1e-14).is_none() {
            return;
        }
        for a in 0..n {
            let sum = crate::matrix::dot(&downward[a * n..a * n + a], &step[..a]);
            step[a] = (step[a] - sum) / downward[a * n + a];
        }
        for a in (0..n).rev() {
            step[a] /= downward[a * n + a];
            let (earlier, rest) = step.split_at_mut(a);
            crate::matrix::axpy(-rest[0], &downward[a * n..a * n + a], earlier);
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
    let is_free = |j: &usize| shape.axes[*j] == Axis::Continuous && point[*j].abs() < 1.0;
    let free: Vec<usize> = (0..point.len()).filter(is_free).collect();
    let n = free.len();
    if n < 2 {
        return false;
    }
    let mut hessian = vec![0.0; n * n];
    for (a, &i) in free.iter().enumerate() {
        for (b, &j) in free.iter().enumerate().take(a + 1) {
            let curvature = variance.second(point, i, j);
            hessian[a * n + b] = curvature;
            hessian[b * n + a] = curvature;
        }
    }
    // Power iteration, shifted so that the largest eigenvalue is also the largest in magnitude.
    let size = hessian.iter().map(|h| h * h).sum::<f64>().sqrt();
    let mut direction: Vec<f64> = (0..n).map(|i| 1.0 + 0.1 * i as f64).collect();
    let mut next = vec![0.0; n];
    let mut rise = 0.0;
    for _ in 0..60 {
        crate::matrix::multiply(&hessian, n, &direction, &mut next);
        let square: f64 = direction.iter().map(|d| d * d).sum();
        rise = crate::matrix::dot(&direction, &next) / square;
        crate::matrix::axpy(size, &direction, &mut next);
        let length = next.iter().map(|d| d * d).sum::<f64>().sqrt();
        if length <= 0.0 {
            return false;
        }
        direction.iter_mut().zip(&next).for_each(|(d, next)| *d = next / length);
    }
    if rise <= 1e-9 * value.abs() {
        return false;
    }
    let mut best: Option<(Vec<f64>, f64)> = None;
    for sign in [1.0, -1.0] {
        let room = |(&j, d): (&usize, &f64)| {
            if *d == 0.0 { f64::INFINITY } else { ((d * sign).signum() - point[j]) / (d * sign) }
        };
        let longest = free.iter().zip(&direction).map(room).fold(f64::INFINITY, f64::min);
        for fraction in [1.0, 0.75, 0.5, 0.3, 0.2, 0.1, 0.05, 0.02, 0.01, 0.003, 0.001] {
            let mut trial = point.to_vec();
            for (&j, d) in free.iter().zip(&direction) {
                trial[j] = (trial[j] + sign * fraction * longest * d).clamp(-1.0, 1.0);
            }
            let height = variance.value(&trial);
            if height > value.max(best.as_ref().map_or(*value, |best| best.1)) && !shape.forbids(&trial) {
                best = Some((trial, height));
            }
        }
    }
    match best {
        Some((trial, height)) if height > *value * (1.0 + 1e-13) => {
            point.copy_from_slice(&trial);
            *value = height;
            true
        }
        _ => false,
    }
}

/// A lattice of a box: levels per axis, the last varying fastest; forbidden points are skipped.
#[derive(Debug, Clone)]
pub(crate) struct Lattice {
    pub(crate) levels: Vec<Vec<f64>>,
    pub(crate) allowed: Option<Vec<bool>>,
}

impl Lattice {
    /// As many equally spaced levels per axis as `most` points allow, an odd number from 3 to 33, with the ends of
    /// forbidden boxes among them; levels of gridded axes, thinned if there are more.
    pub(crate) fn of(shape: &BoxShape, most: usize) -> Self {
        let n_factors = shape.axes.len() as f64;
        let root = (most as f64).powf(1.0 / n_factors).floor() as usize;
        Self::with_levels(shape, root.saturating_sub(1 - root % 2).clamp(3, 33))
    }

    /// About this many levels per axis.
    pub(crate) fn with_levels(shape: &BoxShape, count: usize) -> Self {
        let axis_levels = |(factor, axis): (usize, &Axis)| match axis {
            Axis::Levels(levels) => {
                let last = levels.len() - 1;
                let n = count.min(levels.len());
                (0..n).map(|i| levels[(i * last + (n - 1) / 2) / (n - 1)]).collect()
            }
            Axis::Continuous => {
                let last = (count - 1) as f64;
                let mut levels: Vec<f64> = (0..count).map(|i| (2.0 * i as f64 - last) / last).collect();
                levels.extend(shape.forbidden.iter().flat_map(|box_| box_.range(factor)).filter(|end| end.abs() < 1.0));
                levels.sort_by(f64::total_cmp);
                levels.dedup();
                levels
            }
        };
        let levels = shape.axes.iter().enumerate().map(axis_levels).collect();
        let mut lattice = Self { levels, allowed: None };
        if !shape.forbidden.is_empty() {
            let allowed = (0..lattice.n_points()).map(|index| !shape.forbids(&lattice.point(index))).collect();
            lattice.allowed = Some(allowed);
        }
        lattice
    }

    pub(crate) fn n_points(&self) -> usize {
        self.levels.iter().map(Vec::len).product()
    }

    pub(crate) fn point(&self, mut index: usize) -> Vec<f64> {
        let mut point = vec![0.0; self.levels.len()];
        for (x, levels) in point.iter_mut().zip(&self.levels).rev() {
            *x = levels[index % levels.len()];
            index /= levels.len();
        }
        point
    }

    /// Whether a lattice point is not forbidden.
    pub(crate) fn is_allowed(&self, index: usize) -> bool {
        self.allowed.as_ref().is_none_or(|allowed| allowed[index])
    }

    /// v at every point, line by line; forbidden points at minus infinity.
    pub(crate) fn values(&self, variance: &PredictionVariance) -> Vec<f64> {
        let last = self.levels.len() - 1;
        let levels = &self.levels[last];
        let mut values = vec![0.0; self.n_points()];
        values.par_chunks_exact_mut(levels.len()).enumerate().with_min_len(64).for_each(|(line_index, values)| {
            let point = self.point(line_index * levels.len());
            let mut line = vec![0.0; variance.largest_power() + 1];
            variance.along(&point, last, &mut line);
            for (offset, (value, &x)) in values.iter_mut().zip(levels).enumerate() {
                let allowed = self.is_allowed(line_index * levels.len() + offset);
                *value = if allowed { polynomial::value(&line, x) } else { f64::NEG_INFINITY };
            }
        });
        values
    }

    /// Points at least as high as their neighbors along every axis and above a fraction of the highest, the highest
    /// first.
    pub(crate) fn local_maxima(&self, values: &[f64], fraction: f64, most: usize) -> Vec<usize> {
        let highest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let threshold = fraction * highest;
        let mut found: Vec<usize> = Vec::new();
        for (index, &value) in values.iter().enumerate() {
            if value < threshold {
                continue;
            }
            let mut stride = 1;
            let mut is_maximum = true;
            for levels in self.levels.iter().rev() {
                let n = levels.len();
                let position = index / stride % n;
                is_maximum &= position == 0 || values[index - stride] <= value;
                is_maximum &= position + 1 == n || values[index + stride] <= value;
                stride *= n;
            }
            if is_maximum {
                found.push(index);
            }
        }
        found.sort_by(|&a, &b| values[b].total_cmp(&values[a]).then(a.cmp(&b)));
        found.truncate(most);
        found
    }
}
