//! The methods that are compared: each runs a campaign and recommends a cell after every batch.

use std::time::Instant;

use anyhow::{Result, bail};
use design_space::{Cell, Model};
use infuse::pooled::Forecast;
use infuse::pooled::reported::Registration;
use infuse::{Outcome, global, pooled};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use surface::process::{Residual, SimulationUse, Structure};
use surface::{Data, GridPoints, Regression, Surface};

use super::families::Family;
use super::task::{BATCHES, LEVELS, Task, descend};

/// What a method recommends after a batch.
pub(super) struct Step {
    pub(super) recommended: Cell,
    /// What it promises at most to be missing, with 90 % probability.
    pub(super) bound: Option<f64>,
    /// The same without allowance.
    pub(super) quantile: Option<f64>,
    /// How the bound is expected to fall.
    pub(super) forecast: Option<Forecast>,
    /// The response that is expected at the recommended cell, and the standard deviation of that.
    pub(super) expected: Option<[f64; 2]>,
    /// How far the simulation is taken to be displaced, if it is.
    pub(super) registration: Option<Registration>,
    pub(super) ask_seconds: f64,
    pub(super) tell_seconds: f64,
}

impl Step {
    fn of(recommended: Cell) -> Self {
        let (bound, quantile, forecast, expected, registration) = (None, None, None, None, None);
        Self { recommended, bound, quantile, forecast, expected, registration, ask_seconds: 0.0, tell_seconds: 0.0 }
    }
}

/// A way to choose experiments, and a design.
pub(super) struct Method {
    /// In file names.
    pub(super) name: &'static str,
    pub(super) words: &'static str,
    pub(super) run: fn(&Task<'_>) -> Result<Vec<Step>>,
    /// The largest number of factors for which its batches suffice.
    most_factors: usize,
    /// Whether a campaign takes less than a few seconds.
    pub(super) is_quick: bool,
}

impl Method {
    pub(super) fn can(&self, family: &Family) -> bool {
        family.n_factors <= self.most_factors
    }
}

const fn method(name: &'static str, words: &'static str, run: fn(&Task<'_>) -> Result<Vec<Step>>) -> Method {
    Method { name, words, run, most_factors: usize::MAX, is_quick: true }
}

/// The pooled loop that is not told of the simulation, by the name of its rows: what a simulation is worth, and what it costs to
/// believe one that lies.
pub(super) const UNTOLD: &str = "pooled-untold";

/// Ours first, then those who know less.
pub(super) const METHODS: &[Method] = &[
    method("pooled", "pooled loop", pooled_loop),
    Method { most_factors: 4, is_quick: false, ..method("dissertation", "dissertation's loop", dissertation) },
    method("sobol-process", "Sobol points, Gaussian process", sobol_process),
    Method { most_factors: 4, ..method("sobol-quadratic", "Sobol points, one quadratic", sobol_quadratic) },
    method(UNTOLD, "pooled loop, no simulation", pooled_loop_untold),
    method("simulation", "simulation's own best", simulation_alone),
    method("center", "center of the box", center),
    method("random", "random design", random),
];

/// Where the simulation is displaced, and is run for every design or for few: the loop, and the same loop that takes a simulation as it
/// stands.
pub(super) const DISPLACED_METHODS: [Method; 4] = [
    method("pooled-displaced", "pooled loop", pooled_loop),
    method("pooled-in-place", "pooled loop, the simulation taken as it stands", pooled_loop_in_place),
    method("pooled-dear", "pooled loop", pooled_loop_dear),
    method("pooled-dear-in-place", "pooled loop, the simulation taken as it stands", pooled_loop_dear_in_place),
];

/// Simulations a parameter and batch where they are dear: as many as the shell runs of a program if nothing is said.
pub(super) const DEAR: usize = 15;

/// What a loop knows of the simulation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Told {
    Nothing,
    /// What it says of any design.
    All,
    /// What it says of a few.
    Few,
}

fn pooled_loop(task: &Task<'_>) -> Result<Vec<Step>> {
    pooled_campaign(task, pooled::Settings::new(task.n_experiments), Told::All)
}

fn pooled_loop_in_place(task: &Task<'_>) -> Result<Vec<Step>> {
    pooled_campaign(task, in_place(task), Told::All)
}

fn pooled_loop_dear(task: &Task<'_>) -> Result<Vec<Step>> {
    pooled_campaign(task, pooled::Settings::new(task.n_experiments), Told::Few)
}

fn pooled_loop_dear_in_place(task: &Task<'_>) -> Result<Vec<Step>> {
    pooled_campaign(task, in_place(task), Told::Few)
}

fn pooled_loop_untold(task: &Task<'_>) -> Result<Vec<Step>> {
    pooled_campaign(task, pooled::Settings::new(task.n_experiments), Told::Nothing)
}

fn in_place(task: &Task<'_>) -> pooled::Settings {
    let mut settings = pooled::Settings::new(task.n_experiments);
    settings.displaced = false;
    settings
}

fn pooled_campaign(task: &Task<'_>, mut settings: pooled::Settings, told: Told) -> Result<Vec<Step>> {
    (settings.max_batches, settings.seed) = (BATCHES, task.seed);
    settings.simulations = (told == Told::Few).then_some(DEAR * task.pair.n_factors);
    let mut campaign = pooled::Loop::new(&task.region, settings)?;
    let mut reading = task.readings();
    let mut simulate = |_: Cell, point: &[f64]| Ok((task.pair.simulation)(point));
    let mut steps: Vec<Step> = Vec::new();
    let mut ask_seconds = 0.0;
    while steps.len() < BATCHES {
        let start = Instant::now();
        let ask = campaign.ask(if told == Told::All { Some(&mut simulate) } else { None })?;
        ask_seconds += start.elapsed().as_secs_f64();
        let pooled::Ask::Run { trials, simulations } = ask else {
            bail!("the campaign ended before its last batch");
        };
        for cell in simulations {
            campaign.tell_simulation(cell, Ok((task.pair.simulation)(&task.grid.point(cell)?)))?;
        }
        // Where simulations are dear, some come ahead of all experiments.
        if trials.is_empty() {
            continue;
        }
        for trial in trials {
            campaign.tell(trial.id, Outcome::Value(reading(trial.cell)?))?;
        }
        let start = Instant::now();
        let Some(assessment) = campaign.assess(if told == Told::All { Some(&mut simulate) } else { None })? else {
            bail!("no response after a batch");
        };
        let tell_seconds = start.elapsed().as_secs_f64();
        let (bound, quantile) = (Some(assessment.certificate.bound), Some(assessment.certificate.quantile));
        let (standing, forecast) = (assessment.recommended, Some(assessment.forecast));
        let (recommended, expected) = (standing.cell, Some([standing.mean, standing.deviation]));
        let registration = assessment.registration.filter(Registration::is_sure);
        steps.push(Step { recommended, bound, quantile, forecast, expected, registration, ask_seconds, tell_seconds });
        ask_seconds = 0.0;
    }
    Ok(steps)
}

/// With the settings that the shell gives it: a fifth more experiments than terms would be too many for these budgets, so it has
/// the same number as the others, and twice as many simulations.
fn dissertation(task: &Task<'_>) -> Result<Vec<Step>> {
    let model = Model::quadratic(task.pair.n_factors)?;
    let mut settings = global::Settings::new(model, task.n_experiments, 2 * task.n_experiments);
    (settings.max_batches, settings.first_screening, settings.seed) = (BATCHES, 2, task.seed);
    let mut campaign = global::Loop::new(&task.region, settings)?;
    let mut reading = task.readings();
    let mut simulate = |_: Cell, point: &[f64]| Ok((task.pair.simulation)(point));
    let mut steps: Vec<Step> = Vec::new();
    for _ in 0..BATCHES {
        let start = Instant::now();
        let ask = campaign.ask(&mut simulate)?;
        let ask_seconds = start.elapsed().as_secs_f64();
        let global::Ask::Trials(trials) = ask else {
            // It has ended: its last recommendation stands.
            let last = steps.last().map(|step| step.recommended);
            steps.extend(last.map(Step::of));
            continue;
        };
        let start = Instant::now();
        for trial in trials {
            campaign.tell(trial.id, Outcome::Value(reading(trial.cell)?))?;
        }
        let tell_seconds = start.elapsed().as_secs_f64();
        let Some(report) = campaign.reports().last() else {
            bail!("no report after a batch");
        };
        steps.push(Step { ask_seconds, tell_seconds, ..Step::of(report.screening.optimum_cell) });
    }
    Ok(steps)
}

/// The surface of the pooled loop without its simulation, and without its choice of experiments.
fn sobol_process(task: &Task<'_>) -> Result<Vec<Step>> {
    let mut settings = pooled::Settings::new(task.n_experiments);
    settings.seed = task.seed;
    settings.structures = vec![Structure { simulation: SimulationUse::Ignored, residual: Residual::Smooth }];
    let mut campaign = pooled::Loop::new(&task.region, settings)?;
    let mut reading = task.readings();
    let cells = task.spread(BATCHES * task.n_experiments);
    let mut steps = Vec::new();
    for cells in cells.chunks(task.n_experiments) {
        for trial in campaign.hand_out(cells)? {
            campaign.tell(trial.id, Outcome::Value(reading(trial.cell)?))?;
        }
        let Some(assessment) = campaign.assess(None)? else {
            bail!("no response after a batch");
        };
        steps.push(Step::of(assessment.recommended.cell));
    }
    Ok(steps)
}

fn sobol_quadratic(task: &Task<'_>) -> Result<Vec<Step>> {
    let k = task.pair.n_factors;
    let model = Model::quadratic(k)?;
    let cells = task.spread(BATCHES * task.n_experiments);
    let axis: Vec<f64> = (0..LEVELS).map(|level| design_space::coded_level(level.into(), LEVELS.into())).collect();
    let all = GridPoints::new(vec![axis; k])?;
    let mut reading = task.readings();
    let (mut points, mut values, mut steps) = (Vec::new(), Vec::new(), Vec::new());
    for cells in cells.chunks(task.n_experiments) {
        for &cell in cells {
            points.extend(task.grid.coded(cell)?);
            values.push(reading(cell)?);
        }
        let data = Data::new(k, points.clone(), values.clone())?;
        // Fewer experiments than terms at first: then what can be told apart.
        let fit = Regression::fit_with(&model, &data, surface::Confounded::Drop)?;
        let Some(minimum) = fit.minimum_over(&all)? else {
            bail!("the quadratic is a number nowhere");
        };
        steps.push(Step::of(Cell::new(minimum.index)));
    }
    Ok(steps)
}

/// What is chosen without any experiment.
fn simulation_alone(task: &Task<'_>) -> Result<Vec<Step>> {
    let (grid, simulation) = (&task.grid, &task.pair.simulation);
    let at = |cell: Cell| Ok::<_, anyhow::Error>((simulation(&grid.point(cell)?), cell));
    let candidates: Vec<Cell> = if grid.n_cells() <= 400_000 { grid.cells().collect() } else { task.spread(50_000) };
    let values = candidates.into_iter().map(at).collect::<Result<Vec<_>>>()?;
    let Some(start) = values.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)) else {
        bail!("a grid without cells");
    };
    let (_, best) = descend(grid, simulation, start)?;
    Ok((0..BATCHES).map(|_| Step::of(best)).collect())
}

fn center(task: &Task<'_>) -> Result<Vec<Step>> {
    let cell = task.grid.nearest_clamped(&task.region.center())?;
    Ok((0..BATCHES).map(|_| Step::of(cell)).collect())
}

fn random(task: &Task<'_>) -> Result<Vec<Step>> {
    let mut rng = ChaCha8Rng::seed_from_u64(task.seed);
    rng.set_stream(2);
    Ok((0..BATCHES).map(|_| Step::of(Cell::new(rng.random_range(0..task.grid.n_cells())))).collect())
}
