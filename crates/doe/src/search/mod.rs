//! The search for a design.

mod attempt;
mod bounded;
mod candidates;
mod continuous;
mod curvature;
mod ending;
mod exchange;
mod frame;
mod gridded;
mod incumbents;
mod minimax_step;
mod over_box;
mod over_grid;
mod over_list;
mod polish;
mod problem;
mod report;
mod round;
mod runs;
mod settings;
mod smooth;
mod starts;
mod table;

use std::time::{Duration, Instant};

pub use problem::{Problem, Replicates};
pub use report::{Found, Progress, Report, StopReason};
pub use settings::{Effort, Settings};

use crate::shape::Shape;
use crate::{Criterion, Error};
use ending::{Ending, IsOver};
use over_box::over_box;
pub use over_box::polished;
use over_grid::over_grid;
use over_list::over_list;
use starts::{Counts, Outcome, Runner};

/// How a caller watches a search and ends it.
#[derive(Default)]
pub struct Watch<'a> {
    /// Asked often, by every thread. Once true no further start begins and those on their way are cut; the best design so far is
    /// the result.
    pub is_interrupted: Option<&'a (dyn Fn() -> bool + Sync)>,
    /// Called now and then.
    pub progress: Option<&'a mut dyn FnMut(Progress)>,
}

impl std::fmt::Debug for Watch<'_> {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.debug_struct("Watch").finish_non_exhaustive()
    }
}

/// The best design that the settings allow to find.
///
/// # How G is searched
///
/// On the cube each start descends the L_q norm of the prediction variance on a lattice, q = 4 or so up to 2048, by a bounded quasi-Newton method; the best of every sixteen are then taken to their local optimum by sequential quadratic programs over all maxima of the variance, with exact second derivatives that include how the maxima move.
/// Every step of a thorough polish is checked on a finer lattice for maxima that it overlooks, and the polish begins anew with all maxima it has met, in turn by linear programs and by quadratic ones, until neither gains a part in ten million: sequential linear programs of another solver gain less than 1e-5 points from any of the designs in `fixtures/doe`.
/// Where the model is linear in a factor v is convex along it, and beyond six factors only the ends of such an axis are looked at.
/// Maxima are found by ascents from the local maxima of a lattice along the axes, where the variance is a polynomial of one variable, and along the direction of largest curvature where a saddle holds the axes back: without that the claims for a few designs were up to 0.07 points too high, which the independent check noticed.
/// On grids and lists a continuous solution, in a thorough search with three and more factors the best of eight, is rounded and improved by exchanges, scored by the L_q norm and then the maximum over a working set: the local maxima of the prediction variance along the axes, up to 250, and the 500 highest points, which a scan of all points renews after every second pass over the runs.
/// Where some axes are continuous and others have levels, a thorough start keeps the best of five designs on the fine grid, and up to four of a round are then moved off it.
/// An offered exchange is given up at the first block of the working set that shows it to be worse.
/// The scan fixes the coordinates axis by axis, which leaves a polynomial of one variable on each line of the grid: about four products and sums a point.
/// Of a grid of more than 16 million points the longest axes are searched with fewer levels, evenly spread, and above 50 million the worst prediction is found by ascent instead of a scan: what runs are chosen from changes, what an efficiency is over does not.
/// Lattices of many factors, of more than 33 million points times monomials, are computed axis by axis each time and not stored.
/// A list that fills at least an eighth of a grid of its own levels is scanned in the same way; any other one by the quadratic form at every point.
/// A time limit or an interrupt ends starts on their way, which are dropped unless there is nothing else, and refinements, which keep what they have reached; both ask for it before every evaluation and every ascent to a maximum.
///
/// # How fast, and how good
///
/// Time until 99 % of the designs in `fixtures/doe` is reached, median over 20 seeds on two cores, and as so many exact maxima over the cube of one design (`cargo bench -p infuse-doe`):
///
/// | K, N | time | maxima |
/// |---|---|---|
/// | 2, 8 | 4.9 ms | 70 |
/// | 3, 12 | 22 ms | 23 |
/// | 4, 18 | 190 ms | 69 |
/// | 5, 26 | 660 ms | 65 |
///
/// No single step bounds the way to 99 % at K = 4, N = 18 (a sampling profile of that bench): the largest are the second derivatives of the polish (9 %), the products that the smoothed criterion and its slopes are assembled from (7 % and 5 %), the quasi-Newton step (6 %) and the factorization in the quadratic program (5 %); ascents to the maxima take about 13 % together.
///
/// `fixtures/doe` keeps the best designs known to us for the full quadratic model on the cube, and `verified.csv` what a program that shares nothing with this one says of them; for up to three factors it also gives a bound that holds for certain.
/// `cargo run --release -p infuse-doe --example record_search -- 4 18 60 1` searches one, `--example list_search -- 5` the 331,776 points of 24 levels in four factors.
/// The second gives, with 5 s each on two busy cores, over the grid and over the list:
///
/// | runs | quadratic | additive quadratic |
/// |---|---|---|
/// | 18 | 77.77 and 77.77 % | 99.87 and 99.87 % |
/// | 36 | 92.74 and 92.74 % | 99.87 and 99.87 % |
///
/// With 24 levels no axis has a zero, so the additive model does not reach the 100 % of an orthogonal array here.
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
    let Watch { is_interrupted, mut progress } = watch;
    let is_interrupted = || is_interrupted.is_some_and(|is_interrupted| is_interrupted());
    search_until(problem, settings, &is_interrupted, &mut |state| {
        if let Some(progress) = progress.as_mut() {
            progress(state);
        }
    })
}

fn search_until(
    problem: &Problem,
    settings: &Settings,
    is_interrupted: IsOver<'_>,
    progress: &mut dyn FnMut(Progress),
) -> Result<Found, Error> {
    settings.validate()?;
    problem.validate()?;
    let began = Instant::now();
    let reference = match problem.criterion() {
        Criterion::T => Some(determinant_reference(problem, settings, is_interrupted)?),
        _ => None,
    };
    let least = |reference: &Found| -reference.efficiency.value + Criterion::T_LEAST_D.ln();
    let mut say = |starts: u64, value: f64| {
        let best_percent = problem.percent(value);
        progress(Progress { starts, best_value: value.exp(), best_percent, elapsed: began.elapsed() });
    };
    let runner = Runner {
        settings,
        ending: Ending { began, time_limit: settings.time_limit, is_interrupted },
        target: settings.target_percent.map(|target| problem.log_value(target)),
        least_log_determinant: reference.as_ref().map_or(f64::NEG_INFINITY, least),
        progress: &mut say,
    };
    let (outcome, chosen) = match problem.space().shape() {
        Shape::Box(shape) if problem.is_continuous() => (over_box(problem, shape, runner)?, Vec::new()),
        Shape::Box(shape) => (over_grid(problem, shape, runner)?, Vec::new()),
        Shape::List(list) => over_list(problem, list, runner)?,
    };
    found(problem, outcome, &chosen, reference, began)
}

/// The result of a search, its efficiency computed anew.
fn found(
    problem: &Problem,
    outcome: Outcome,
    chosen: &[usize],
    reference: Option<Found>,
    began: Instant,
) -> Result<Found, Error> {
    let Outcome { best, stop, times_found, counts } = outcome;
    let Counts { starts, abandoned, failed, unfinished } = counts;
    let unfinished = unfinished + reference.as_ref().map_or(0, |reference| reference.report.unfinished);
    let (design, candidates, best_start) = match (best, reference) {
        (Some(best), _) => (problem.design(&best.x)?, problem.candidates(chosen), best.start),
        // Cut before there was anything else: the D design has its whole determinant.
        (None, Some(reference)) => (reference.design, reference.candidates, 0),
        (None, None) => return Err(Error::NoDesign { starts }),
    };
    let cells = problem.cells(&design);
    let efficiency = problem.criterion().efficiency(problem.model(), problem.judged(), &design)?;
    let elapsed = began.elapsed();
    let report = Report { stop, starts, best_start, times_found, abandoned, failed, unfinished, elapsed };
    Ok(Found { design, candidates, cells, efficiency, report })
}

/// A good D design, of whose determinant a search for T keeps a share; of a time limit it takes half.
fn determinant_reference(problem: &Problem, settings: &Settings, is_interrupted: IsOver<'_>) -> Result<Found, Error> {
    let time_limit = settings.time_limit.map(|limit| (limit / 2).max(Duration::from_nanos(1)));
    let settings = Settings { starts: 16, time_limit, ..Settings::default() };
    search_until(&problem.clone().with_criterion(Criterion::D), &settings, is_interrupted, &mut |_| ())
}
