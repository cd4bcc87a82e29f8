//! One step of the minimax polish: least worst case of linear functions, plus a curvature, within bounds.

use std::ops::Range;

use super::ending::IsOver;
use crate::matrix::{axpy, cholesky_rows, dot};

/// min over d and t of t + d'Hd/2, with heights + slopes d ≤ t and lower ≤ d ≤ upper.
#[derive(Debug)]
pub(crate) struct MinimaxStep<'a> {
    /// One per function.
    pub(crate) heights: &'a [f64],
    /// One row of n slopes per function.
    pub(crate) slopes: &'a [f64],
    /// At most 0.
    pub(crate) lower: &'a [f64],
    /// At least 0.
    pub(crate) upper: &'a [f64],
    /// H, n × n and symmetric; empty for a linear program.
    pub(crate) curvature: &'a [f64],
}

/// A step with the multiplier of each function.
#[derive(Debug)]
pub(crate) struct Solution {
    pub(crate) step: Vec<f64>,
    pub(crate) multipliers: Vec<f64>,
}

/// Primal-dual interior point method with Mehrotra's predictor and corrector on dense n × n normal equations. A
/// curvature that is not convex enough is raised until it is.
///
/// The problems are small and dense, with about as many functions as variables; a general sparse solver would spend
/// its time on bookkeeping. None if it cannot be solved, or if `is_over` says so between two iterations.
pub(crate) fn solve(problem: &MinimaxStep<'_>, is_over: IsOver<'_>) -> Option<Solution> {
    let n = problem.lower.len();
    let size = problem.curvature.iter().step_by(n + 1).fold(0.0, |a: f64, b| a.max(b.abs()));
    let mut shift = 0.0;
    for _ in 0..8 {
        match solve_shifted(problem, shift, is_over) {
            Outcome::Solved(solution) => return Some(solution),
            Outcome::Cut => return None,
            Outcome::NotConvex => shift = f64::max(10.0 * shift, 1e-3 * size.max(1e-3)),
        }
    }
    None
}

enum Outcome {
    Solved(Solution),
    NotConvex,
    Cut,
}

fn solve_shifted(problem: &MinimaxStep<'_>, shift: f64, is_over: IsOver<'_>) -> Outcome {
    const MOST_ITERATIONS: usize = 40;
    const GAP: f64 = 1e-11;
    let (m, n) = (problem.heights.len(), problem.lower.len());
    let mut state = State::start(problem);
    let mut work = Work::new(m, n, shift);
    let mut iterations = 0;
    while iterations < MOST_ITERATIONS {
        if is_over() {
            return Outcome::Cut;
        }
        iterations += 1;
        let mu = state.mu();
        if mu * state.n_products() <= GAP * (1.0 + state.t.abs())
            && (1.0 - state.lambda.iter().sum::<f64>()).abs() < 1e-9
        {
            break;
        }
        if work.factor(problem, &state, is_over).is_none() {
            if is_over() {
                return Outcome::Cut;
            }
            // Near the solution rounding alone can spoil the factor: that is close enough.
            if mu > 1e-7 {
                return Outcome::NotConvex;
            }
            break;
        }
        // Predictor: as if all products could vanish at once.
        work.target_functions.fill(0.0);
        work.target_lower.fill(0.0);
        work.target_upper.fill(0.0);
        let affine = work.direction(problem, &state);
        let (primal, dual) = state.largest_steps(&affine);
        let ahead = state.mu_after(&affine, primal, dual);
        let left = ahead / mu;
        let centering = (left * left * left).min(1.0) * mu;
        // Corrector: back to the center, less the products that the predictor neglects.
        for j in 0..m {
            work.target_functions[j] = centering - affine.s[j] * affine.lambda[j];
        }
        for i in 0..n {
            work.target_lower[i] = centering - affine.d[i] * affine.lower[i];
            work.target_upper[i] = centering + affine.d[i] * affine.upper[i];
        }
        let step = work.direction(problem, &state);
        let (primal, dual) = state.largest_steps(&step);
        // With a curvature the dual equations mix both kinds of variables, so both go equally far.
        let both = primal.min(dual);
        let (primal, dual) = if problem.curvature.is_empty() { (primal, dual) } else { (both, both) };
        state.advance(&step, (0.99 * primal).min(1.0), (0.99 * dual).min(1.0));
    }
    let bounded = state.d.iter().zip(problem.lower.iter().zip(problem.upper)).map(|(d, (l, u))| d.clamp(*l, *u));
    let step: Vec<f64> = bounded.collect();
    if step.iter().all(|d| d.is_finite()) {
        Outcome::Solved(Solution { step, multipliers: state.lambda })
    } else {
        Outcome::NotConvex
    }
}

/// Step, level, slacks and multipliers; also used for their changes.
#[derive(Debug, Clone)]
struct State {
    d: Vec<f64>,
    t: f64,
    /// Slack of each function.
    s: Vec<f64>,
    /// Multiplier of each function.
    lambda: Vec<f64>,
    /// Multiplier of each lower bound.
    lower: Vec<f64>,
    /// Multiplier of each upper bound.
    upper: Vec<f64>,
    /// Distance to each lower bound.
    above: Vec<f64>,
    /// Distance to each upper bound.
    below: Vec<f64>,
}

impl State {
    fn start(problem: &MinimaxStep<'_>) -> Self {
        let (m, n) = (problem.heights.len(), problem.lower.len());
        // Zero, moved inside where it is a bound.
        let inside = |(l, u): (&f64, &f64)| 0.0_f64.clamp(l + 0.1 * (u - l), u - 0.1 * (u - l));
        let d: Vec<f64> = problem.lower.iter().zip(problem.upper).map(inside).collect();
        let reached: Vec<f64> =
            problem.heights.iter().zip(problem.slopes.chunks_exact(n)).map(|(h, row)| h + dot(row, &d)).collect();
        let highest = reached.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let lowest = reached.iter().copied().fold(f64::INFINITY, f64::min);
        let t = highest + 0.1 * (highest - lowest).max(1e-3);
        let s: Vec<f64> = reached.iter().map(|height| t - height).collect();
        let mu = s.iter().sum::<f64>() / (m * m) as f64;
        let above: Vec<f64> = d.iter().zip(problem.lower).map(|(d, l)| d - l).collect();
        let below: Vec<f64> = d.iter().zip(problem.upper).map(|(d, u)| u - d).collect();
        Self {
            t,
            lambda: vec![1.0 / m as f64; m],
            lower: above.iter().map(|gap| mu / gap).collect(),
            upper: below.iter().map(|gap| mu / gap).collect(),
            s,
            d,
            above,
            below,
        }
    }

    fn n_products(&self) -> f64 {
        (self.s.len() + 2 * self.d.len()) as f64
    }

    fn mu(&self) -> f64 {
        (dot(&self.s, &self.lambda) + dot(&self.above, &self.lower) + dot(&self.below, &self.upper)) / self.n_products()
    }

    fn mu_after(&self, step: &Self, primal: f64, dual: f64) -> f64 {
        let pairs = |a: &[f64], da: &[f64], b: &[f64], db: &[f64], sign: f64| -> f64 {
            (0..a.len()).map(|i| (a[i] + sign * primal * da[i]) * (b[i] + dual * db[i])).sum()
        };
        (pairs(&self.s, &step.s, &self.lambda, &step.lambda, 1.0)
            + pairs(&self.above, &step.d, &self.lower, &step.lower, 1.0)
            + pairs(&self.below, &step.d, &self.upper, &step.upper, -1.0))
            / self.n_products()
    }

    /// Largest primal and dual step, up to 1.01, that keep everything positive.
    fn largest_steps(&self, step: &Self) -> (f64, f64) {
        let ratio = |a: &[f64], da: &[f64], sign: f64| {
            let blocking = a.iter().zip(da).filter(|(_, da)| sign * **da < 0.0);
            blocking.map(|(a, da)| -a / (sign * da)).fold(1.01, f64::min)
        };
        let bounds = ratio(&self.above, &step.d, 1.0).min(ratio(&self.below, &step.d, -1.0));
        let multipliers = ratio(&self.lower, &step.lower, 1.0).min(ratio(&self.upper, &step.upper, 1.0));
        (ratio(&self.s, &step.s, 1.0).min(bounds), ratio(&self.lambda, &step.lambda, 1.0).min(multipliers))
    }

    fn advance(&mut self, step: &Self, primal: f64, dual: f64) {
        axpy(primal, &step.d, &mut self.d);
        axpy(primal, &step.d, &mut self.above);
        axpy(-primal, &step.d, &mut self.below);
        axpy(primal, &step.s, &mut self.s);
        self.t += primal * step.t;
        axpy(dual, &step.lambda, &mut self.lambda);
        axpy(dual, &step.lower, &mut self.lower);
        axpy(dual, &step.upper, &mut self.upper);
    }
}

/// The factored normal equations and the products that a direction aims at.
///
/// With W = diag(λ/s), ω = Σ W and ĝ = Gᵀ W 1 / ω the level t is eliminated by centering the slopes:
/// A = H + diag(z_l / (d − l) + z_u / (u − d)) + Σ W_j (g_j − ĝ)(g_j − ĝ)ᵀ.
struct Work {
    m: usize,
    n: usize,
    shift: f64,
    factor: Vec<f64>,
    mean: Vec<f64>,
    total: f64,
    /// Columns of √W (g − ĝ), variable by variable.
    centered: Vec<f64>,
    target_functions: Vec<f64>,
    target_lower: Vec<f64>,
    target_upper: Vec<f64>,
}

impl Work {
    fn new(m: usize, n: usize, shift: f64) -> Self {
        Self {
            m,
            n,
            shift,
            factor: vec![0.0; n * n],
            mean: vec![0.0; n],
            total: 0.0,
            centered: vec![0.0; m * n],
            target_functions: vec![0.0; m],
            target_lower: vec![0.0; n],
            target_upper: vec![0.0; n],
        }
    }

    /// None if the matrix is not positive definite, or `is_over` says so on the way.
    fn factor(&mut self, problem: &MinimaxStep<'_>, state: &State, is_over: IsOver<'_>) -> Option<()> {
        let (m, n) = (self.m, self.n);
        let weights: Vec<f64> = state.lambda.iter().zip(&state.s).map(|(lambda, s)| lambda / s).collect();
        self.total = weights.iter().sum();
        self.mean.fill(0.0);
        for (row, weight) in problem.slopes.chunks_exact(n).zip(&weights) {
            axpy(weight / self.total, row, &mut self.mean);
        }
        for (j, row) in problem.slopes.chunks_exact(n).enumerate() {
            let root = weights[j].sqrt();
            for (i, (slope, mean)) in row.iter().zip(&self.mean).enumerate() {
                self.centered[i * m + j] = root * (slope - mean);
            }
        }
        for first in (0..n).step_by(ROWS) {
            if first > 0 && is_over() {
                return None;
            }
            outer_products(&self.centered, m, first..n.min(first + ROWS), &mut self.factor);
        }
        for i in 0..n {
            let barrier = state.lower[i] / state.above[i] + state.upper[i] / state.below[i];
            let diagonal = &mut self.factor[i * n + i];
            *diagonal += barrier + self.shift + 1e-14 * *diagonal;
        }
        if !problem.curvature.is_empty() {
            self.factor.iter_mut().zip(problem.curvature).for_each(|(a, h)| *a += h);
        }
        for first in (0..n).step_by(ROWS) {
            if first > 0 && is_over() {
                return None;
            }
            factorize(&mut self.factor, n, first..n.min(first + ROWS))?;
        }
        Some(())
    }

    fn direction(&self, problem: &MinimaxStep<'_>, state: &State) -> State {
        let (m, n) = (self.m, self.n);
        // r₁ = −(H d + Gᵀ λ) + target/(d − l) − target/(u − d) − Gᵀ(target/s − λ), the two Gᵀ λ cancelling.
        let mut d: Vec<f64> = (0..n)
            .map(|i| {
                self.target_lower[i] / state.above[i] - self.target_upper[i] / state.below[i] - self.shift * state.d[i]
            })
            .collect();
        if !problem.curvature.is_empty() {
            d.iter_mut().zip(problem.curvature.chunks_exact(n)).for_each(|(r, row)| *r -= dot(row, &state.d));
        }
        let mut sum = 0.0;
        for (j, row) in problem.slopes.chunks_exact(n).enumerate() {
            let share = self.target_functions[j] / state.s[j];
            sum += share;
            axpy(-share, row, &mut d);
        }
        // Σ δλ = 1 − Σ λ gives ω δt = ω ĝ · δd − r₂ with r₂ = 1 − Σ target/s.
        let missing = 1.0 - sum;
        axpy(-missing, &self.mean, &mut d);
        self.solve(&mut d);
        let t = dot(&self.mean, &d) - missing / self.total;
        let s: Vec<f64> = problem.slopes.chunks_exact(n).map(|row| t - dot(row, &d)).collect();
        let lambda = (0..m)
            .map(|j| (self.target_functions[j] - state.lambda[j] * s[j]) / state.s[j] - state.lambda[j])
            .collect();
        let lower =
            (0..n).map(|i| (self.target_lower[i] - state.lower[i] * d[i]) / state.above[i] - state.lower[i]).collect();
        let upper =
            (0..n).map(|i| (self.target_upper[i] + state.upper[i] * d[i]) / state.below[i] - state.upper[i]).collect();
        State { d, t, s, lambda, lower, upper, above: Vec::new(), below: Vec::new() }
    }

    fn solve(&self, b: &mut [f64]) {
        let n = self.n;
        for j in 0..n {
            b[j] = (b[j] - dot(&self.factor[j * n..j * n + j], &b[..j])) / self.factor[j * n + j];
        }
        for j in (0..n).rev() {
            b[j] /= self.factor[j * n + j];
            let value = b[j];
            axpy(-value, &self.factor[j * n..j * n + j], &mut b[..j]);
        }
    }
}

/// Rows of a large matrix between two questions whether the search is over.
const ROWS: usize = 64;

/// Some rows of the lower triangle of X Xᵀ for rows of length m.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx+avx2"))]
fn outer_products(x: &[f64], m: usize, rows: Range<usize>, out: &mut [f64]) {
    let n = x.len() / m;
    for j in rows {
        let row = &x[j * m..j * m + m];
        for k in 0..=j {
            out[j * n + k] = dot(row, &x[k * m..k * m + m]);
        }
    }
}

#[multiversion::multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx+avx2"))]
fn factorize(a: &mut [f64], n: usize, rows: Range<usize>) -> Option<()> {
    cholesky_rows(a, n, rows, 0.0).map(|_| ())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meets_in_the_middle_of_two_slopes() {
        // max(1 + d, −d) is least at d = −1/2, where both are 1/2.
        let problem =
            MinimaxStep { heights: &[1.0, 0.0], slopes: &[1.0, -1.0], lower: &[-2.0], upper: &[2.0], curvature: &[] };
        let Solution { step, multipliers } = solve(&problem, &|| false).expect("solvable");
        assert!((step[0] + 0.5).abs() < 1e-7, "{step:?}");
        assert!(multipliers.iter().all(|lambda| (lambda - 0.5).abs() < 1e-7), "{multipliers:?}");
    }

    #[test]
    fn stops_at_the_bounds() {
        let (lower, upper) = ([-0.5, 0.0], [0.0, 0.25]);
        let problem =
            MinimaxStep { heights: &[1.0], slopes: &[1.0, -3.0], lower: &lower, upper: &upper, curvature: &[] };
        let step = solve(&problem, &|| false).expect("solvable").step;
        assert!((step[0] + 0.5).abs() < 1e-7 && (step[1] - 0.25).abs() < 1e-7, "{step:?}");
    }

    #[test]
    fn a_curvature_ends_the_step_before_the_bounds() {
        // d + d² is least at −1/2; with −d² instead the step goes to a bound.
        let step = |h: f64| {
            let problem =
                MinimaxStep { heights: &[0.0], slopes: &[1.0], lower: &[-2.0], upper: &[2.0], curvature: &[h] };
            solve(&problem, &|| false).expect("solvable").step[0]
        };
        assert!((step(2.0) + 0.5).abs() < 1e-6, "{}", step(2.0));
        assert!((step(-2.0) + 2.0).abs() < 1e-3, "{}", step(-2.0));
    }

    /// Functions and bounds at random, the same every time.
    fn random(m: usize, n: usize, seed: usize) -> [Vec<f64>; 4] {
        let number = |i: usize| ((i * i * 7919 + i * 31 + seed * 104_729) % 2003) as f64 / 1001.0 - 1.0;
        let at = |from: usize, count: usize| (from..from + count).map(number).collect::<Vec<f64>>();
        let lower = at(1000, n).iter().map(|x| -0.02 - 0.05 * x.abs()).collect();
        // Some bounds are tight.
        let upper = at(2000, n).iter().map(|x| if *x < 0.3 { 0.0 } else { 0.1 * x }).collect();
        [at(0, m).iter().map(|x| 1.0 - 0.1 * x.abs()).collect(), at(100, m * n), lower, upper]
    }

    /// Any multipliers give a bound from below: Σ λ_j h_j + Σ_i min(l_i c_i, u_i c_i) with c = Gᵀ λ. At the optimum it is met, in
    /// whatever unit the functions are.
    #[test]
    fn a_linear_step_meets_its_dual_bound_in_few_iterations() {
        for (m, n, seed, unit) in
            [(3, 2, 1, 1.0), (12, 8, 2, 1.0), (40, 24, 3, 1.0), (30, 40, 4, 1.0), (40, 24, 3, 1e4), (9, 9, 5, 1e4)]
        {
            let [mut heights, mut slopes, lower, upper] = random(m, n, seed);
            heights.iter_mut().chain(&mut slopes).for_each(|value| *value *= unit);
            let problem =
                MinimaxStep { heights: &heights, slopes: &slopes, lower: &lower, upper: &upper, curvature: &[] };
            let asked = std::sync::atomic::AtomicU32::new(0);
            let is_over = || {
                asked.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
                false
            };
            let Solution { step, multipliers } = solve(&problem, &is_over).expect("solvable");
            let reached = heights.iter().zip(slopes.chunks_exact(n)).map(|(h, row)| h + dot(row, &step));
            let reached = reached.fold(f64::NEG_INFINITY, f64::max);
            let mut c = vec![0.0; n];
            slopes.chunks_exact(n).zip(&multipliers).for_each(|(row, lambda)| axpy(*lambda, row, &mut c));
            let bounds = c.iter().zip(lower.iter().zip(&upper)).map(|(c, (l, u))| (l * c).min(u * c));
            let dual = dot(&heights, &multipliers) + bounds.sum::<f64>();
            assert!((multipliers.iter().sum::<f64>() - 1.0).abs() < 1e-8, "{m} {n}: {multipliers:?}");
            assert!(
                multipliers.iter().all(|lambda| *lambda >= 0.0)
                    && reached < heights.iter().copied().fold(0.0, f64::max)
            );
            assert!((reached - dual).abs() < 1e-9 * unit, "{m} functions of {n}: {reached} and {dual}");
            let asked = asked.into_inner();
            assert!(asked <= 15, "{asked} iterations for {m} functions of {n}");
        }
    }

    /// What is foreseen of a step is what it comes to, and the slacks stay those of the functions.
    #[test]
    fn a_step_leads_to_the_mean_product_that_was_foreseen() {
        let [heights, slopes, lower, upper] = random(7, 5, 6);
        let problem = MinimaxStep { heights: &heights, slopes: &slopes, lower: &lower, upper: &upper, curvature: &[] };
        let (mut state, mut work) = (State::start(&problem), Work::new(7, 5, 0.0));
        for (primal, dual) in [(0.3, 0.3), (0.2, 0.05), (0.1, 0.4)] {
            work.factor(&problem, &state, &|| false).expect("positive definite");
            let step = work.direction(&problem, &state);
            let foreseen = state.mu_after(&step, primal, dual);
            state.advance(&step, primal, dual);
            assert!((state.mu() - foreseen).abs() < 1e-12 * foreseen.abs(), "{} is not {foreseen}", state.mu());
            let slack = |(height, row): (&f64, &[f64])| state.t - height - dot(row, &state.d);
            for (s, expected) in state.s.iter().zip(heights.iter().zip(slopes.chunks_exact(5)).map(slack)) {
                assert!((s - expected).abs() < 1e-12, "{s} is not {expected}");
            }
        }
    }
}
