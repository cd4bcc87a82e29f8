//! Quasi-Newton descent within bounds.

use std::collections::VecDeque;

use super::ending::IsOver;

/// A function to make small.
pub(crate) trait Objective {
    /// Value at x and, into `gradient`, its slopes; infinite where it is not defined.
    fn evaluate(&mut self, x: &[f64], gradient: &mut [f64]) -> f64;
}

/// When to stop.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Limits {
    pub(crate) iterations: usize,
    /// Least improvement per iteration, thrice in a row.
    pub(crate) improvement: f64,
}

const MEMORY: usize = 12;

/// Projected limited-memory BFGS: variables that press against a bound are held, the rest move along the
/// quasi-Newton direction, and the step is bent back into the bounds. x is improved in place, until `is_over` says so
/// between two evaluations; its value is returned.
pub(crate) fn minimize(
    objective: &mut impl Objective,
    x: &mut [f64],
    bounds: (&[f64], &[f64]),
    limits: Limits,
    is_over: IsOver<'_>,
) -> f64 {
    let (lower, upper) = bounds;
    let n = x.len();
    let mut gradient = vec![0.0; n];
    let mut value = objective.evaluate(x, &mut gradient);
    if !value.is_finite() {
        return f64::INFINITY;
    }
    let mut memory: VecDeque<(Vec<f64>, Vec<f64>, f64)> = VecDeque::with_capacity(MEMORY);
    let (mut trial, mut trial_gradient) = (vec![0.0; n], vec![0.0; n]);
    let mut small_improvements = 0;
    for _ in 0..limits.iterations {
        if is_over() {
            break;
        }
        let held = |i: usize| x[i] <= lower[i] && gradient[i] > 0.0 || x[i] >= upper[i] && gradient[i] < 0.0;
        let free: Vec<bool> = (0..n).map(|i| !held(i)).collect();
        let steepest: Vec<f64> = (0..n).map(|i| if free[i] { -gradient[i] } else { 0.0 }).collect();
        let largest = steepest.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
        if largest <= 1e-12 {
            break;
        }
        let mut direction = two_loops(&memory, &steepest);
        direction.iter_mut().zip(&free).for_each(|(d, &free)| *d = if free { *d } else { 0.0 });
        let descent: f64 = direction.iter().zip(&gradient).map(|(d, g)| d * g).sum();
        let mut step = 1.0;
        if memory.is_empty() || descent >= 0.0 || !descent.is_finite() {
            memory.clear();
            direction = steepest;
            step = 0.1 / largest;
        }
        // Backtracking on the bent path.
        let mut accepted = None;
        for tried in 0..20 {
            if tried > 0 && is_over() {
                return value;
            }
            for i in 0..n {
                trial[i] = (x[i] + step * direction[i]).clamp(lower[i], upper[i]);
            }
            let predicted: f64 = (0..n).map(|i| gradient[i] * (trial[i] - x[i])).sum();
            let reached = objective.evaluate(&trial, &mut trial_gradient);
            if reached <= value + 1e-4 * predicted && reached.is_finite() {
                accepted = Some(reached);
                break;
            }
            // The minimum of the parabola through both values, within a tenth and a half of the step.
            let parabola = -0.5 * predicted / (reached - value - predicted);
            step *= if parabola.is_finite() { parabola.clamp(0.1, 0.5) } else { 0.1 };
        }
        let Some(reached) = accepted else {
            if memory.is_empty() {
                break;
            }
            memory.clear();
            continue;
        };
        let s: Vec<f64> = (0..n).map(|i| trial[i] - x[i]).collect();
        let y: Vec<f64> = (0..n).map(|i| trial_gradient[i] - gradient[i]).collect();
        let curvature: f64 = s.iter().zip(&y).map(|(a, b)| a * b).sum();
        let length: f64 = y.iter().map(|b| b * b).sum();
        if curvature > 1e-10 * length.sqrt() * s.iter().map(|a| a * a).sum::<f64>().sqrt() {
            if memory.len() == MEMORY {
                memory.pop_front();
            }
            memory.push_back((s, y, curvature));
        }
        x.copy_from_slice(&trial);
        gradient.copy_from_slice(&trial_gradient);
        let improvement = value - reached;
        value = reached;
        small_improvements = if improvement < limits.improvement { small_improvements + 1 } else { 0 };
        if small_improvements == 3 {
            break;
        }
    }
    value
}

/// The inverse Hessian approximated by the memory, times a vector.
fn two_loops(memory: &VecDeque<(Vec<f64>, Vec<f64>, f64)>, vector: &[f64]) -> Vec<f64> {
    let mut q = vector.to_vec();
    let mut factors = Vec::with_capacity(memory.len());
    for (s, y, curvature) in memory.iter().rev() {
        let alpha = s.iter().zip(&q).map(|(a, b)| a * b).sum::<f64>() / curvature;
        q.iter_mut().zip(y).for_each(|(q, y)| *q -= alpha * y);
        factors.push(alpha);
    }
    if let Some((_, y, curvature)) = memory.back() {
        let scale = curvature / y.iter().map(|b| b * b).sum::<f64>();
        q.iter_mut().for_each(|q| *q *= scale);
    }
    for ((s, y, curvature), alpha) in memory.iter().zip(factors.iter().rev()) {
        let beta = y.iter().zip(&q).map(|(a, b)| a * b).sum::<f64>() / curvature;
        q.iter_mut().zip(s).for_each(|(q, s)| *q += (alpha - beta) * s);
    }
    q
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rosenbrock's valley.
    struct Valley;

    impl Objective for Valley {
        fn evaluate(&mut self, x: &[f64], gradient: &mut [f64]) -> f64 {
            let (a, b) = (1.0 - x[0], x[1] - x[0] * x[0]);
            gradient[0] = -2.0 * a - 400.0 * b * x[0];
            gradient[1] = 200.0 * b;
            a * a + 100.0 * b * b
        }
    }

    #[test]
    fn finds_the_end_of_a_valley() {
        let mut x = [-1.2, 1.0];
        let limits = Limits { iterations: 200, improvement: 1e-16 };
        minimize(&mut Valley, &mut x, (&[-2.0; 2], &[2.0; 2]), limits, &|| false);
        assert!((x[0] - 1.0).abs() < 1e-5 && (x[1] - 1.0).abs() < 1e-5, "{x:?}");
    }

    #[test]
    fn stops_at_a_bound_that_cuts_the_valley() {
        // With x₁ ≤ 1/2 the minimum is at x₂ = 1/4, value 1/4.
        let mut x = [-1.2, 1.0];
        let limits = Limits { iterations: 200, improvement: 1e-16 };
        let value = minimize(&mut Valley, &mut x, (&[-2.0; 2], &[0.5, 2.0]), limits, &|| false);
        assert!((value - 0.25).abs() < 1e-9 && (x[1] - 0.25).abs() < 1e-4, "{x:?}");
    }

    /// Rosenbrock's valley, and how often it was asked for.
    struct Counted(std::sync::atomic::AtomicUsize);

    impl Objective for &Counted {
        fn evaluate(&mut self, x: &[f64], gradient: &mut [f64]) -> f64 {
            self.0.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            Valley.evaluate(x, gradient)
        }
    }

    /// With many factors an evaluation is what takes long, and one iteration may need twenty.
    #[test]
    fn nothing_is_evaluated_once_it_is_over() {
        let limits = Limits { iterations: 200, improvement: 1e-16 };
        for last in 1..50 {
            let counted = Counted(0.into());
            let made = || counted.0.load(std::sync::atomic::Ordering::Relaxed);
            let mut x = [-1.2, 1.0];
            let value = minimize(&mut &counted, &mut x, (&[-2.0; 2], &[2.0; 2]), limits, &|| made() >= last);
            assert_eq!(made(), last, "evaluations");
            let at_x = Valley.evaluate(&x, &mut [0.0; 2]);
            assert_eq!(value.to_bits(), at_x.to_bits(), "the value is that at x after {last} evaluations");
        }
    }

    /// c/2 · (x − a)², and how often it was asked for.
    struct Parabola {
        curvature: f64,
        bottom: f64,
        asked: usize,
    }

    impl Objective for Parabola {
        fn evaluate(&mut self, x: &[f64], gradient: &mut [f64]) -> f64 {
            self.asked += 1;
            gradient[0] = self.curvature * (x[0] - self.bottom);
            0.5 * self.curvature * (x[0] - self.bottom).powi(2)
        }
    }

    /// Nothing is known of the curvature yet, so the first step is short whatever the slope is; one that overshoots ends at the
    /// bottom of the parabola through both values, which is that of a parabola.
    #[test]
    fn first_step_is_a_tenth_and_one_too_long_ends_at_the_bottom() {
        let once = Limits { iterations: 1, improvement: 0.0 };
        for curvature in [0.02, 7.0] {
            for (bottom, expected, asked) in [(0.9, 0.1, 2), (-0.9, -0.1, 2), (0.03, 0.03, 3), (-0.04, -0.04, 3)] {
                let (mut parabola, mut x) = (Parabola { curvature, bottom, asked: 0 }, [0.0]);
                let value = minimize(&mut parabola, &mut x, (&[-1.0], &[1.0]), once, &|| false);
                assert!((x[0] - expected).abs() < 1e-15, "{} for {expected}", x[0]);
                assert!((value - 0.5 * curvature * (x[0] - bottom).powi(2)).abs() < 1e-15, "{value}");
                assert_eq!(parabola.asked, asked, "bottom at {bottom}");
            }
        }
    }
}
