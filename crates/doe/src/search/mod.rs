//! The search for a design.

mod bounded;
mod candidates;
mod continuous;
mod curvature;
#[cfg(test)]
mod cutting;
mod exchange;
mod minimax_step;
mod nested;
mod polish;
mod problem;
mod report;
mod runs;
mod settings;
mod smooth;
mod starts;
mod table;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use rand_pcg::Pcg64;

use problem::APART;
pub(crate) use problem::SAME_RUN;
pub use problem::{Problem, Replicates};
pub use report::{Found, Progress, Report, StopReason};
pub use settings::{Effort, Settings};

use crate::criterion::moment_matrix;
use crate::matrix::add_outer;
use crate::maximum::Lattice;
use crate::products::Products;
use crate::space::{Axis, BoxShape, List, Shape};
use crate::{Criterion, Design, Error, Forbidden, Space};
use candidates::Candidates;
use continuous::Continuous;
use exchange::Discrete;
use runs::Regressors;
use smooth::Frame;
use starts::{Attempt, Ending, Incumbents, IsOver};
use table::Table;

/// How a caller watches a search and ends it.
#[derive(Default)]
pub struct Watch<'a> {
    /// Once true no further start begins and those on their way are cut; the best design so far is the result.
    pub interrupt: Option<&'a AtomicBool>,
    /// Called now and then.
    pub progress: Option<&'a mut dyn FnMut(Progress)>,
}

impl std::fmt::Debug for Watch<'_> {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.debug_struct("Watch").field("interrupt", &self.interrupt).finish_non_exhaustive()
    }
}

/// The best design that the settings allow to find.
///
/// # Errors
///
/// [`Error::Setting`]; [`Error::NoDesign`] if no start led to a design that determines the model.
pub fn search(problem: &Problem, settings: &Settings) -> Result<Found, Error> {
    search_watched(problem, settings, Watch::default())
}

/// As [`search`], watched and interruptible.
///
/// # Errors
///
/// As [`search`].
pub fn search_watched(problem: &Problem, settings: &Settings, watch: Watch<'_>) -> Result<Found, Error> {
    let Watch { interrupt, mut progress } = watch;
    let is_interrupted = || interrupt.is_some_and(|flag| flag.load(Ordering::Relaxed));
    search_until(problem, settings, &is_interrupted, |state| {
        if let Some(progress) = progress.as_mut() {
            progress(state);
        }
    })
}

fn search_until(
    problem: &Problem,
    settings: &Settings,
    is_interrupted: IsOver<'_>,
    mut progress: impl FnMut(Progress),
) -> Result<Found, Error> {
    settings.validate()?;
    problem.validate()?;
    let began = Instant::now();
    let percent = |log_value: f64| percent(problem, log_value);
    let target = settings.target_percent.map(|target| log_value(problem, target));
    let progress = |starts: u64, value: f64| {
        progress(Progress { starts, best_value: value.exp(), best_percent: percent(value), elapsed: began.elapsed() });
    };
    let reference = match problem.criterion() {
        Criterion::T => Some(determinant_reference(problem, settings, is_interrupted)?),
        _ => None,
    };
    let least = |reference: &Found| -reference.efficiency.value + Criterion::T_LEAST_D.ln();
    let least_log_determinant = reference.as_ref().map_or(f64::NEG_INFINITY, least);
    let unfinished = reference.as_ref().map_or(0, |reference| reference.report.unfinished);
    let ending = Ending { began, time_limit: settings.time_limit, is_interrupted };
    let runner = Runner { settings, ending, target, least_log_determinant };
    let outcome = match problem.space().shape() {
        Shape::Box(shape) if shape.is_continuous() && problem.replicates() == Replicates::Allowed => {
            over_box(problem, shape, runner, progress)?
        }
        Shape::Box(shape) => over_grid(problem, shape, runner, progress)?,
        Shape::List(list) => over_list(problem, list, runner, progress)?,
    };
    let (design, best_start) = match (outcome.best, reference) {
        (Some((_, best_start, x)), _) => (problem.design(&x)?, best_start),
        // Cut before there was anything else: the D design has its whole determinant.
        (None, Some(reference)) => (reference.design, 0),
        (None, None) => return Err(Error::NoDesign { starts: outcome.starts }),
    };
    let efficiency = problem.criterion().efficiency(problem.model(), problem.space(), &design)?;
    let report = Report {
        stop: outcome.stop,
        starts: outcome.starts,
        best_start,
        times_found: outcome.times_found,
        abandoned: outcome.abandoned,
        failed: outcome.failed,
        unfinished: unfinished + outcome.unfinished,
        elapsed: began.elapsed(),
    };
    Ok(Found { design, efficiency, report })
}

/// A continuous box, replicates allowed.
fn over_box(
    problem: &Problem,
    shape: &BoxShape,
    runner: Runner<'_>,
    progress: impl FnMut(u64, f64),
) -> Result<starts::Outcome, Error> {
    let relaxed = shape.relaxed();
    let frame = frame(problem, Some(&relaxed), runner.least_log_determinant, <[f64]>::to_vec)?;
    let lattice = lattice(&relaxed);
    let effort = runner.settings.effort;
    let search = Continuous { frame: &frame, shape: &relaxed, lattice: &lattice, effort };
    let attempt = |generator: &mut Pcg64, incumbents: &Incumbents, is_over: IsOver<'_>| {
        search.start(generator, incumbents, is_over)
    };
    let refine =
        |x: Vec<f64>, _: f64, incumbents: &Incumbents, is_over: IsOver<'_>| search.refine(x, incumbents, is_over);
    Ok(runner.run(attempt, refine, progress))
}

/// A grid as it is; a box with a continuous axis and one with levels, or whose free runs must differ, on a fine grid, and
/// off it along the continuous axes as far as runs that must differ stay apart.
fn over_grid(
    problem: &Problem,
    shape: &BoxShape,
    runner: Runner<'_>,
    progress: impl FnMut(u64, f64),
) -> Result<starts::Outcome, Error> {
    let is_discrete = shape.is_discrete();
    let gridded = if is_discrete { thinned(shape) } else { gridded(shape)? };
    let is_distinct = problem.replicates() != Replicates::Allowed;
    let relaxed = shape.relaxed();
    let frame = frame(problem, Some(&relaxed), runner.least_log_determinant, <[f64]>::to_vec)?;
    let lattice = lattice(&relaxed);
    let continuous = Continuous { frame: &frame, shape: &relaxed, lattice: &lattice, effort: Effort::Quick };
    let polish = Continuous { frame: &frame, shape: &relaxed, lattice: &lattice, effort: runner.settings.effort };
    let candidates = Candidates::grid(&gridded, &frame.products);
    let fixed = problem.fixed().iter().flat_map(|fixed| Design::runs(fixed)).map(<[f64]>::to_vec).collect();
    let search = Discrete {
        frame: &frame,
        candidates: &candidates,
        relaxed: Some(continuous),
        is_distinct,
        apart: if is_discrete { SAME_RUN } else { APART },
        fixed,
    };
    let attempt = |generator: &mut Pcg64, incumbents: &Incumbents, is_over: IsOver<'_>| {
        search.start(generator, incumbents, is_over)
    };
    // The value on the grid is not that over the space: both designs are scored where they count.
    let score = |x: &[f64]| -> Option<f64> {
        let design = problem.design(x).ok()?;
        let efficiency = problem.criterion().efficiency(problem.model(), problem.space(), &design).ok()?;
        Some(log_value(problem, efficiency.percent))
    };
    let refine = |x: Vec<f64>, value: f64, incumbents: &Incumbents, is_over: IsOver<'_>| {
        if is_discrete {
            return Some((x, value));
        }
        let value = score(&x)?;
        let moved = if shape.is_continuous() {
            polish.refine(x.clone(), incumbents, is_over)
        } else {
            polish.on_levels(shape, x.clone(), is_over)
        };
        let moved = moved.map(|(moved, _)| moved).filter(|moved| problem.keeps_replicates(moved));
        match moved.and_then(|moved| Some((score(&moved)?, moved))) {
            Some((better, moved)) if better < value => Some((moved, better)),
            _ => Some((x, value)),
        }
    };
    Ok(runner.run(attempt, refine, progress))
}

/// Points of a grid that is searched as a whole, at most: a scan of it takes a fraction of a second.
const WHOLE_GRID_POINTS: f64 = 16_777_216.0;

/// The grid, or of a large one the part with fewer levels on its longest axes, evenly spread: both ends, and what lies
/// next to the end of a forbidden range, are among them.
fn thinned(shape: &BoxShape) -> BoxShape {
    let counts: Vec<usize> =
        shape.axes.iter().map(|axis| if let Axis::Levels(levels) = axis { levels.len() } else { 1 }).collect();
    let n_points = |most: usize| -> f64 { counts.iter().map(|&count| count.min(most) as f64).product() };
    if n_points(usize::MAX) <= WHOLE_GRID_POINTS {
        return shape.clone();
    }
    let longest = counts.iter().copied().max().unwrap_or(1);
    let (mut kept, mut too_many) = (2, longest);
    while too_many - kept > 1 {
        let middle = kept + (too_many - kept) / 2;
        if n_points(middle) <= GRID_POINTS { kept = middle } else { too_many = middle }
    }
    let axis = |(factor, axis): (usize, &Axis)| match axis {
        Axis::Levels(levels) if levels.len() > kept => {
            let last = levels.len() - 1;
            let mut indices: Vec<usize> = (0..kept).map(|i| (i * last + (kept - 1) / 2) / (kept - 1)).collect();
            for end in shape.forbidden.iter().flat_map(|forbidden| forbidden.range(factor)) {
                let above = levels.partition_point(|level| *level < end);
                indices.extend([above.saturating_sub(1), above.min(last)]);
            }
            indices.sort_unstable();
            indices.dedup();
            Axis::Levels(indices.into_iter().map(|index| levels[index]).collect())
        }
        axis => axis.clone(),
    };
    BoxShape { axes: shape.axes.iter().enumerate().map(axis).collect(), forbidden: shape.forbidden.clone() }
}

/// Points of a grid in place of a box with continuous axes, at most: as many as can be scanned quickly.
const GRID_POINTS: f64 = 4_194_304.0;
/// Levels of such a grid along a continuous axis, at most: a twentieth of half the axis apart.
const GRID_LEVELS: u32 = 41;

/// The box with levels along its continuous axes, an odd number so that ends and middle are among them.
fn gridded(shape: &BoxShape) -> Result<BoxShape, Error> {
    let given = |axis: &Axis| match axis {
        Axis::Continuous => None,
        Axis::Levels(levels) => Some(levels.len() as f64),
    };
    let n_continuous = shape.axes.iter().filter(|axis| given(axis).is_none()).count();
    let given: f64 = shape.axes.iter().filter_map(given).product();
    let most = (GRID_POINTS / given).powf(1.0 / n_continuous as f64);
    let levels = (3..=GRID_LEVELS).rev().step_by(2).find(|&levels| f64::from(levels) <= most).unwrap_or(3);
    let axis = |(factor, axis): (usize, &Axis)| match axis {
        Axis::Continuous => Ok(with_ends(Axis::equally_spaced(levels)?, shape, factor)),
        Axis::Levels(_) => Ok(axis.clone()),
    };
    let axes = shape.axes.iter().enumerate().map(axis).collect::<Result<Vec<_>, Error>>()?;
    let forbidden = shape.forbidden.iter().filter_map(|forbidden| opened(forbidden, shape));
    Ok(BoxShape { axes, forbidden: forbidden.collect() })
}

/// The levels of an axis with the ends of its forbidden ranges: the worst prediction is often there.
fn with_ends(axis: Axis, shape: &BoxShape, factor: usize) -> Axis {
    let Axis::Levels(mut levels) = axis else {
        return axis;
    };
    let ends = shape.forbidden.iter().flat_map(|forbidden| forbidden.range(factor));
    levels.extend(ends.filter(|end| end.abs() < 1.0));
    levels.sort_by(f64::total_cmp);
    levels.dedup_by(|a, b| (*a - *b).abs() <= SAME_RUN);
    Axis::Levels(levels)
}

/// A forbidden box whose ends along continuous axes are allowed though those axes now have levels; none if nothing is
/// left of it.
fn opened(forbidden: &Forbidden, shape: &BoxShape) -> Option<Forbidden> {
    const INWARD: f64 = 2.0 * crate::space::SAME;
    let range = |(range, axis): (&Option<[f64; 2]>, &Axis)| match (range, axis) {
        (&Some([lower, upper]), Axis::Continuous) => {
            let lower = if lower <= -1.0 { lower } else { lower + INWARD };
            Some([lower, if upper >= 1.0 { upper } else { upper - INWARD }])
        }
        (range, _) => *range,
    };
    Forbidden::new(forbidden.ranges().iter().zip(&shape.axes).map(range).collect()).ok()
}

/// A list of candidates, stretched to fill the cube where that does not change the problem, so that a list shrunken to
/// a small part of it is as well conditioned as any.
fn over_list(
    problem: &Problem,
    list: &List,
    runner: Runner<'_>,
    progress: impl FnMut(u64, f64),
) -> Result<starts::Outcome, Error> {
    let k = list.n_factors;
    let mut ends = vec![[f64::INFINITY, f64::NEG_INFINITY]; k];
    for point in list.points() {
        for ([lower, upper], &x) in ends.iter_mut().zip(point) {
            *lower = lower.min(x);
            *upper = upper.max(x);
        }
    }
    let is_invariant = matches!(problem.criterion(), Criterion::D | Criterion::G | Criterion::I);
    let fills = ends.iter().all(|[lower, upper]| *lower <= -1.0 && *upper >= 1.0);
    let stretches = is_invariant && problem.model().is_affine_closed() && ends.iter().all(|[a, b]| b - a > 1e-9);
    let stretch = |point: &[f64]| -> Vec<f64> {
        let stretched = |(x, [a, b]): (&f64, &[f64; 2])| ((x - a) - (b - x)) / (b - a);
        if stretches && !fills { point.iter().zip(&ends).map(stretched).collect() } else { point.to_vec() }
    };
    let stretched = List { n_factors: k, coordinates: list.points().flat_map(stretch).collect() };
    let cube = BoxShape { axes: vec![Axis::Continuous; k], forbidden: Vec::new() };
    let is_boxed = fills || stretches;
    let frame = frame(problem, is_boxed.then_some(&cube), runner.least_log_determinant, stretch)?;
    let lattice = lattice(&cube);
    let relaxed =
        is_boxed.then_some(Continuous { frame: &frame, shape: &cube, lattice: &lattice, effort: Effort::Quick });
    let candidates = Candidates::list(&stretched, &frame.regressors, &frame.products);
    let fixed = problem.fixed().iter().flat_map(|fixed| Design::runs(fixed)).map(stretch).collect();
    let is_distinct = problem.replicates() != Replicates::Allowed;
    let search = Discrete { frame: &frame, candidates: &candidates, relaxed, is_distinct, apart: SAME_RUN, fixed };
    let attempt = |generator: &mut Pcg64, incumbents: &Incumbents, is_over: IsOver<'_>| {
        search.start(generator, incumbents, is_over)
    };
    // What is found on the list needs no refinement.
    let refine = |x: Vec<f64>, value: f64, _: &Incumbents, _: IsOver<'_>| Some((x, value));
    let mut outcome = runner.run(attempt, refine, progress);
    if let Some((_, _, x)) = &mut outcome.best {
        // Back to the very candidates.
        let original = x.chunks_exact(k).flat_map(|run| list.point(stretched.nearest(run).0).to_vec());
        *x = original.collect();
    }
    Ok(outcome)
}

/// Levels per axis of the lattice on which the prediction variance is smoothed: enough to see its maxima, few enough to
/// be quick. With more factors nearly all maxima are on −1, 0, 1.
fn lattice_levels(n_factors: usize) -> usize {
    match n_factors {
        1 => 33,
        2 => 9,
        3 => 5,
        _ => 3,
    }
}

fn lattice(shape: &BoxShape) -> Lattice {
    Lattice::with_levels(shape, lattice_levels(shape.axes.len()))
}

/// What the search for a problem needs; the lattice of G is that of a continuous shape, if there is one.
fn frame(
    problem: &Problem,
    shape: Option<&BoxShape>,
    least_log_determinant: f64,
    map: impl Fn(&[f64]) -> Vec<f64>,
) -> Result<Frame, Error> {
    let (model, criterion) = (problem.model(), problem.criterion());
    let products = Arc::new(Products::of(model));
    let p = model.n_terms();
    let mut fixed = vec![0.0; p * p];
    for run in problem.fixed().iter().flat_map(|fixed| Design::runs(fixed)) {
        add_outer(&mut fixed, p, 1.0, &model.regressor(&map(run))?);
    }
    let moments = match (criterion, problem.space().shape()) {
        (Criterion::I, Shape::List(list)) => {
            let mapped = Space::list_unchecked(list.n_factors, list.points().flat_map(&map).collect());
            moment_matrix(model, &mapped)?
        }
        (Criterion::I, Shape::Box(_)) => moment_matrix(model, problem.space())?,
        _ => Vec::new(),
    };
    let table = shape.filter(|_| criterion == Criterion::G).map(|shape| Table::of(&products, &lattice(shape)));
    let regressors = Regressors::of(model);
    let multiplicities = problem.multiplicities();
    Ok(Frame { criterion, regressors, products, fixed, multiplicities, moments, least_log_determinant, table })
}

/// A good D design, of whose determinant a search for T keeps a share; of a time limit it takes half.
fn determinant_reference(problem: &Problem, settings: &Settings, is_interrupted: IsOver<'_>) -> Result<Found, Error> {
    let time_limit = settings.time_limit.map(|limit| limit / 2);
    let settings = Settings { starts: 16, time_limit, ..Settings::default() };
    search_until(&problem.clone().with_criterion(Criterion::D), &settings, is_interrupted, |_| ())
}

/// What runs the starts of any search.
struct Runner<'a> {
    settings: &'a Settings,
    ending: Ending<'a>,
    target: Option<f64>,
    /// For T.
    least_log_determinant: f64,
}

impl Runner<'_> {
    fn run(
        self,
        attempt: impl Fn(&mut Pcg64, &Incumbents, IsOver<'_>) -> Attempt + Sync,
        refine: impl Fn(Vec<f64>, f64, &Incumbents, IsOver<'_>) -> Option<(Vec<f64>, f64)> + Sync,
        progress: impl FnMut(u64, f64),
    ) -> starts::Outcome {
        starts::run(self.settings, self.ending, self.target, attempt, refine, progress)
    }
}

/// Efficiency of a logarithmic value, for progress and targets.
fn percent(problem: &Problem, log_value: f64) -> f64 {
    let (n, p) = (problem.n_runs() as f64, problem.model().n_terms() as f64);
    100.0
        * match problem.criterion() {
            Criterion::D => (-log_value).exp() / n,
            Criterion::A | Criterion::G | Criterion::I => p / (n * log_value.exp()),
            Criterion::E => (-log_value).exp() / n,
            Criterion::T => (-log_value).exp() / (n * p),
        }
}

/// The inverse of [`percent`].
fn log_value(problem: &Problem, percent: f64) -> f64 {
    let (n, p) = (problem.n_runs() as f64, problem.model().n_terms() as f64);
    let fraction = percent / 100.0;
    match problem.criterion() {
        Criterion::D | Criterion::E => -(fraction * n).ln(),
        Criterion::A | Criterion::G | Criterion::I => (p / (n * fraction)).ln(),
        Criterion::T => -(fraction * n * p).ln(),
    }
}
