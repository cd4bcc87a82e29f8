//! One start of a search over continuous coordinates.

use rand::RngExt;
use rand_pcg::Pcg64;

use super::attempt::{Attempt, Refinement};
use super::bounded::{self, Objective as _, minimize};
use super::ending::IsOver;
use super::frame::{Frame, lattice};
use super::incumbents::Incumbents;
use super::polish::{self, Peaks, polish};
use super::settings::Effort;
use super::smooth::Smooth;
use crate::lattice::Lattice;
use crate::maximum::{highest, highest_as_judged};
use crate::measure::Measure;
use crate::shape::{Axis, BoxShape};
use crate::{Criterion, Forbidden};

/// A search over a box with continuous axes, or the continuous relaxation of a grid.
#[derive(Debug)]
pub(crate) struct Continuous<'a> {
    pub(crate) frame: &'a Frame,
    /// Continuous in every axis.
    pub(crate) shape: &'a BoxShape,
    /// Where predictions are asked for: the same, or a grid.
    pub(crate) judged: &'a BoxShape,
    pub(crate) lattice: &'a Lattice,
    pub(crate) effort: Effort,
}

/// Exponents of the smoothing, as powers of 2, and how far a start may be behind the best at each without being given up.
const STAGES: [(u32, f64); 4] = [(5, 0.12), (7, 0.06), (9, 0.03), (11, 0.02)];
/// Polishes of one design at most.
const MOST_CHECKS: usize = 12;
/// Exponent of the last smoothing of E, as a power of 2.
const LAST_LOG_Q: u32 = 12;
/// A design being refined may be this far behind the best, less and less so with every step.
const BEHIND_REFINED: f64 = 0.01;

impl Continuous<'_> {
    /// One start; `is_over` is asked between any two iterations.
    pub(crate) fn start(&self, generator: &mut Pcg64, incumbents: &Incumbents, is_over: IsOver<'_>) -> Attempt {
        let mut x = self.first_runs(generator, incumbents);
        let (lower, upper) = bounds(self.shape, &x);
        match self.frame.criterion {
            Criterion::G => self.descend_worst_case(generator, incumbents, &mut x, (&lower, &upper), is_over),
            _ => self.descend(&mut x, (&lower, &upper), is_over),
        }
    }

    fn descend(&self, x: &mut [f64], bounds: (&[f64], &[f64]), is_over: IsOver<'_>) -> Attempt {
        let stages: &[u32] =
            if self.frame.criterion == Criterion::E { &[3, 5, 7, 9, LAST_LOG_Q] } else { &[LAST_LOG_Q] };
        let mut smooth = Smooth::new(self.frame, 0);
        let mut value = f64::INFINITY;
        for &log_q in stages {
            smooth.set_log_q(log_q);
            let limits = bounded::Limits { iterations: 300, improvement: 1e-12 };
            value = minimize(&mut smooth, x, bounds, limits, is_over);
            if !value.is_finite() {
                return Attempt::Failed;
            }
            if is_over() {
                return Attempt::Cut { x: x.to_vec(), value };
            }
        }
        Attempt::Found { x: x.to_vec(), value, stages: Vec::new() }
    }

    fn descend_worst_case(
        &self,
        generator: &mut Pcg64,
        incumbents: &Incumbents,
        x: &mut [f64],
        bounds: (&[f64], &[f64]),
        is_over: IsOver<'_>,
    ) -> Attempt {
        let first: u32 = generator.random_range(2..=5);
        let mut smooth = Smooth::new(self.frame, first);
        let coarse = bounded::Limits { iterations: 60, improvement: 1e-4 };
        if !minimize(&mut smooth, x, bounds, coarse, is_over).is_finite() {
            return Attempt::Failed;
        }
        let mut stages = Vec::with_capacity(STAGES.len());
        let mut value = f64::INFINITY;
        for (stage, (log_q, behind)) in STAGES.into_iter().enumerate() {
            smooth.set_log_q(log_q);
            value = minimize(&mut smooth, x, bounds, bounded::Limits { iterations: 150, improvement: 1e-6 }, is_over);
            if !value.is_finite() {
                return Attempt::Failed;
            }
            if is_over() {
                return Attempt::Cut { x: x.to_vec(), value };
            }
            if value > incumbents.best_at_stage(stage) + behind {
                return Attempt::Abandoned;
            }
            stages.push(value);
        }
        Attempt::Found { x: x.to_vec(), value, stages }
    }

    /// The design of a start taken to its local optimum, or as far as it comes until `is_over`.
    pub(crate) fn refine(&self, mut x: Vec<f64>, incumbents: &Incumbents, is_over: IsOver<'_>) -> Refinement {
        if self.frame.criterion != Criterion::G {
            let mut smooth = Smooth::new(self.frame, LAST_LOG_Q);
            let mut gradient = vec![0.0; x.len()];
            let value = smooth.evaluate(&x, &mut gradient);
            return Refinement::of(value.is_finite().then_some((x, value)));
        }
        let best = incumbents.best_log_value();
        let (lower, upper) = bounds(self.shape, &x);
        let mut peaks = Peaks::new(self.frame, self.judged, self.lattice);
        let steps = if self.effort == Effort::Thorough { 150 } else { 15 };
        let is_checked = self.effort == Effort::Thorough;
        let limits = polish::Limits { steps, radius: 0.01, least_radius: 1e-8, is_checked };
        // The further it is, the closer to the best it must be to go on.
        let is_worth = |made: usize, value: f64| value.ln() < best + BEHIND_REFINED / (1.0 + made as f64).sqrt();
        let mut value = f64::INFINITY;
        for _ in 0..MOST_CHECKS {
            value = match polish(&mut peaks, &mut x, (&lower, &upper), limits, is_worth, is_over) {
                Some(value) if value.is_finite() => value,
                Some(_) => return Refinement::Failed,
                None if value.is_finite() => break,
                None => return Refinement::Unjudged,
            };
            // A finer lattice may know a higher maximum; then it takes part in a further polish. What would be the best is looked at as
            // it is judged in the end.
            peaks.look(&x);
            let (mut at, mut highest) = highest(peaks.variance(), self.judged, is_over);
            if is_checked && highest <= value * (1.0 + 1e-9) && value.ln() < best {
                (at, highest) = highest_as_judged(peaks.variance(), self.judged, is_over);
            }
            if highest <= value * (1.0 + 1e-9) {
                break;
            }
            value = highest;
            peaks.also(at);
            if is_over() {
                break;
            }
        }
        Refinement::Reached { x, value: value.ln() }
    }

    /// Any design taken to its local optimum; none if it is singular.
    pub(crate) fn taken_down(&self, mut x: Vec<f64>, is_over: IsOver<'_>) -> Option<(Vec<f64>, f64)> {
        if self.frame.criterion == Criterion::G {
            return match self.refine(x, &Incumbents::default(), is_over) {
                Refinement::Reached { x, value } => Some((x, value)),
                Refinement::Unjudged | Refinement::Failed => None,
            };
        }
        let (lower, upper) = bounds(self.shape, &x);
        match self.descend(&mut x, (&lower, &upper), is_over) {
            Attempt::Found { x, value, .. } => Some((x, value)),
            _ => None,
        }
    }

    /// A refined design with the coordinates of gridded axes on their levels and the others refined again.
    pub(crate) fn on_levels(&self, shape: &BoxShape, mut x: Vec<f64>, is_over: IsOver<'_>) -> Option<(Vec<f64>, f64)> {
        let k = self.frame.n_factors();
        for run in x.chunks_exact_mut(k) {
            let snapped = snapped(shape, run)?;
            run.copy_from_slice(&snapped);
        }
        let (lower, upper) = bounds(shape, &x);
        if self.frame.criterion == Criterion::G {
            // On the lattice of the continuous box most points are no points of this one.
            let lattice = lattice(shape, &self.frame.products);
            let mut peaks = Peaks::on_levels(self.frame, shape, &lattice);
            let is_checked = self.effort == Effort::Thorough;
            let limits = polish::Limits { steps: 60, radius: 0.02, least_radius: 1e-8, is_checked };
            let value = polish(&mut peaks, &mut x, (&lower, &upper), limits, |_, _| true, is_over)?;
            return value.is_finite().then(|| (x, value.ln()));
        }
        let mut smooth = Smooth::new(self.frame, LAST_LOG_Q);
        let limits = bounded::Limits { iterations: 300, improvement: 1e-12 };
        let value = minimize(&mut smooth, &mut x, (&lower, &upper), limits, is_over);
        value.is_finite().then_some((x, value))
    }

    /// Half of the starts, once there is something to start from, are changed copies of good designs; the others are
    /// random, in one of several ways, because a variety of starts finds what many of one kind miss.
    fn first_runs(&self, generator: &mut Pcg64, incumbents: &Incumbents) -> Vec<f64> {
        let k = self.frame.n_factors();
        let n = self.frame.multiplicities.len();
        if let Some(elite) = incumbents.pick(generator) {
            let mut x = elite.to_vec();
            if generator.random_range(0..3) == 0 {
                let size = [0.05, 0.15, 0.4][generator.random_range(0..3)];
                for value in &mut x {
                    *value = (*value + size * (2.0 * generator.random::<f64>() - 1.0)).clamp(-1.0, 1.0);
                }
            } else {
                let most = (n / 4).max(1);
                for _ in 0..generator.random_range(1..=most) {
                    let run = generator.random_range(0..n);
                    let point = self.random_point(generator, 0.5);
                    x[run * k..run * k + k].copy_from_slice(&point);
                }
            }
            if !self.shape.forbidden.is_empty() {
                let fix = |run: &[f64]| if self.shape.forbids(run) { None } else { Some(run.to_vec()) };
                let runs: Vec<Vec<f64>> = x
                    .chunks_exact(k)
                    .map(|run| fix(run).unwrap_or_else(|| self.random_point(generator, 0.0)))
                    .collect();
                x = runs.concat();
            }
            return x;
        }
        let snap = [0.0, 0.3, 0.7, 0.95][generator.random_range(0..4)];
        (0..n).flat_map(|_| self.random_point(generator, snap)).collect()
    }

    /// A random allowed point; each coordinate is put on −1, 0 or 1 with the chance `snap`.
    fn random_point(&self, generator: &mut Pcg64, snap: f64) -> Vec<f64> {
        if !self.shape.forbidden.is_empty() {
            return Measure::of(self.shape).sample(generator);
        }
        let coordinate = |generator: &mut Pcg64| {
            let x = 2.0 * generator.random::<f64>() - 1.0;
            if generator.random::<f64>() < snap { f64::from(generator.random_range(-1..=1)) } else { x }
        };
        (0..self.frame.n_factors()).map(|_| coordinate(generator)).collect()
    }
}

/// Levels of an axis that are tried for a run, at most.
const MOST_LEVELS: usize = 3;
/// And runs made of them.
const MOST_RUNS: usize = 243;

/// A run with its gridded coordinates on levels: of the levels next to it those nearest together that are not forbidden.
fn snapped(shape: &BoxShape, run: &[f64]) -> Option<Vec<f64>> {
    let mut nearest: Vec<(f64, Vec<f64>)> = vec![(0.0, Vec::with_capacity(run.len()))];
    for (axis, &at) in shape.axes.iter().zip(run) {
        let values = match axis {
            Axis::Continuous => vec![at],
            Axis::Levels(levels) => {
                let mut levels = levels.clone();
                levels.sort_by(|a, b| (a - at).abs().total_cmp(&(b - at).abs()));
                // Where nothing is forbidden the nearest is the one.
                levels.truncate(if shape.forbidden.is_empty() { 1 } else { MOST_LEVELS });
                levels
            }
        };
        let with = |(distance, begun): &(f64, Vec<f64>), value: f64| {
            (distance + (value - at) * (value - at), begun.iter().copied().chain([value]).collect::<Vec<f64>>())
        };
        nearest = nearest.iter().flat_map(|begun| values.iter().map(|&value| with(begun, value))).collect();
        nearest.sort_by(|a, b| a.0.total_cmp(&b.0));
        nearest.truncate(MOST_RUNS);
    }
    nearest.into_iter().map(|(_, run)| run).find(|run| !shape.forbids(run))
}

/// Bounds of every coordinate: the cube, or around each run a box without forbidden points, grown from the run axis by axis, each run
/// beginning with another axis. What is on a level stays there.
fn bounds(shape: &BoxShape, x: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let (mut lower, mut upper) = (x.to_vec(), x.to_vec());
    let k = shape.axes.len();
    for (run, point) in x.chunks_exact(k).enumerate() {
        let (lower, upper) = (&mut lower[run * k..run * k + k], &mut upper[run * k..run * k + k]);
        for axis in (0..k).map(|j| (j + run) % k).filter(|&axis| matches!(shape.axes[axis], Axis::Continuous)) {
            let [from, to] = free_range(shape, point, lower, upper, axis);
            lower[axis] = from;
            upper[axis] = to;
        }
    }
    (lower, upper)
}

/// How far a box may grow along an axis before it meets the inside of a forbidden box; a level at its side is within it.
fn free_range(shape: &BoxShape, point: &[f64], lower: &[f64], upper: &[f64], axis: usize) -> [f64; 2] {
    let meets = |forbidden: &&Forbidden| {
        (0..point.len()).filter(|&j| j != axis).all(|j| match shape.axes[j] {
            Axis::Levels(_) => shape.blocks(forbidden, j, point[j]),
            Axis::Continuous => {
                let [a, b] = forbidden.range(j);
                a < upper[j] && lower[j] < b || lower[j] >= upper[j] && a < lower[j] && lower[j] < b
            }
        })
    };
    let mut range = [-1.0, 1.0];
    for forbidden in shape.forbidden.iter().filter(meets) {
        let [a, b] = forbidden.range(axis);
        if b <= point[axis] {
            range[0] = f64::max(range[0], b);
        } else if a >= point[axis] {
            range[1] = f64::min(range[1], a);
        }
    }
    range
}

#[cfg(test)]
mod tests {
    use super::*;

    use rand::SeedableRng as _;

    use crate::search::problem::Problem;
    use crate::shape::Shape;
    use crate::{Model, Space};

    /// Only the worst prediction is smoothed in stages, at each of which a start that falls behind is given up.
    #[test]
    fn starts_for_the_worst_prediction_are_given_up_where_they_fall_behind() {
        let space = Space::cube(2).unwrap();
        let Shape::Box(shape) = space.shape() else { unreachable!("a cube is a box") };
        for (criterion, is_given_up) in [(Criterion::G, true), (Criterion::D, false)] {
            let problem = Problem::new(Model::quadratic(2).unwrap(), space.clone(), 8, criterion).unwrap();
            let frame = Frame::of(&problem, Some(shape), f64::NEG_INFINITY, &<[f64]>::to_vec).unwrap();
            let lattice = &lattice(shape, &frame.products);
            let search = Continuous { frame: &frame, shape, judged: shape, lattice, effort: Effort::Quick };
            let start = |known: &Incumbents| search.start(&mut Pcg64::seed_from_u64(2), known, &|| false);
            let mut known = Incumbents::default();
            let Attempt::Found { value, .. } = start(&known) else { panic!("a start without a design") };
            known.note(&[value - 1.0; 4], value - 1.0);
            assert_eq!(matches!(start(&known), Attempt::Abandoned), is_given_up, "{criterion}");
        }
    }
}
