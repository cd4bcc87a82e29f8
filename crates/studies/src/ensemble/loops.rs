//! Campaigns of all methods on one plant in one world, with equal numbers of experiments.

use anyhow::{Context as _, Result, bail};
use design_space::{Cell, Model};
use infuse::pooled::{Ask, Settings};
use infuse::{Outcome, global, gradient, pooled};
use surface::process::{Residual, SimulationUse, Structure};
use surface::{Confounded, Data, GridPoints, Regression, Surface as _};

use super::row::Method;
use crate::chapter4;
use crate::costs::Cost;
use crate::gridded::{CellCosts, Designs, Space};

/// What an experiment reads: the seed of the campaign, and experiments by number and design.
pub(super) type Read<'a> = dyn Fn(u64, &[(u64, Vec<f64>)]) -> Vec<Cost> + Sync + 'a;

/// A space with its model, its experiments and what may be spent.
pub(super) struct Task<'a> {
    pub(super) space: &'a Space,
    pub(super) model: &'a dyn CellCosts,
    pub(super) read: &'a Read<'a>,
    /// Experiments and simulations of a batch, and batches.
    pub(super) budget: [usize; 3],
}

/// What a method chose after a step, and what it knows of it.
#[derive(Clone, Debug)]
pub(super) struct Step {
    pub(super) method: Method,
    pub(super) seed: u64,
    pub(super) step: usize,
    pub(super) point: Vec<f64>,
    pub(super) share: f64,
    pub(super) spread: f64,
}

impl Step {
    pub(super) fn new(method: Method, seed: u64, step: usize, point: Vec<f64>) -> Self {
        Self { method, seed, step, point, share: f64::NAN, spread: f64::NAN }
    }
}

/// An experiment as it was read.
pub(super) type Measured = (Vec<f64>, f64);

/// The loop of Chapter 3 on interpolated simulations: its steps, and what it measured.
pub(super) fn gradient_loop(
    setup: &chapter4::Setup,
    mut simulate: impl FnMut(&[f64]) -> Result<f64, String>,
    read: &Read<'_>,
    seed: u64,
) -> Result<(Vec<Step>, Vec<Measured>)> {
    let variant = setup.file.variant.first().context("no variant")?;
    let mut campaign = gradient::Loop::new(setup.problem.clone(), setup.loop_settings(variant))?;
    while let gradient::Ask::Trials(trials) = campaign.ask(&mut simulate)? {
        let experiments: Vec<_> = trials.iter().map(|trial| (trial.id.number(), trial.point.clone())).collect();
        for (trial, cost) in trials.iter().zip(read(seed, &experiments)) {
            campaign.tell(trial.id, Outcome::from(cost))?;
        }
    }
    let step = |report: &gradient::Report| {
        Step::new(Method::Dissertation, seed, report.iteration, report.numerical.point.clone())
    };
    let measured = campaign.reports().iter().flat_map(|report| &report.trials).filter_map(|record| {
        let cost = record.outcome.as_ref()?.cost()?;
        Some((record.trial.point.clone(), cost))
    });
    Ok((campaign.reports().iter().map(step).collect(), measured.collect()))
}

/// The loop of Chapter 5.
pub(super) fn global_loop(
    task: &Task<'_>,
    settings: &global::Settings,
    designs: &Designs,
    seed: u64,
) -> Result<global::Loop> {
    let mut campaign = global::Loop::new(task.space.region(), settings.clone())?;
    while let Some(plan) = designs.next(&campaign)? {
        // All at once, so that those that nobody knows fly side by side.
        task.model.costs(&plan.simulations);
        let trials = campaign.open(&plan, &mut |cell, _| task.model.cost(cell))?;
        let experiments: Vec<_> = trials.iter().map(|trial| (trial.id.number(), trial.point.clone())).collect();
        for (trial, cost) in trials.iter().zip((task.read)(seed, &experiments)) {
            campaign.tell(trial.id, Outcome::from(cost))?;
        }
    }
    Ok(campaign)
}

/// The steps of such a campaign.
pub(super) fn steps_of(campaign: &global::Loop, space: &Space, seed: u64) -> Vec<Step> {
    let step = |report: &global::Report| {
        let screening = &report.screening;
        let step = Step::new(Method::Dissertation, seed, report.number, screening.optimum.clone());
        let share = screening.n_after as f64 / space.n_cells() as f64;
        Step { share, spread: screening.spread.s().unwrap_or(f64::NAN), ..step }
    };
    campaign.reports().iter().map(step).collect()
}

/// Its experiments.
pub(super) fn measured_by(campaign: &global::Loop) -> Vec<Measured> {
    let trials = campaign.reports().iter().flat_map(|report| &report.trials);
    trials.filter_map(|record| Some((record.trial.point.clone(), record.cost()?))).collect()
}

/// Where a regression on experiments alone is lowest.
pub(super) fn alone(space: &Space, model: &Model, measured: &[Measured], seed: u64, step: usize) -> Result<Step> {
    let region = space.region();
    let coded = measured.iter().map(|(point, _)| Ok(region.coded(point)?)).collect::<Result<Vec<_>>>()?.concat();
    let data = Data::new(region.n_parameters(), coded, measured.iter().map(|(_, cost)| *cost).collect())?;
    let surface = Regression::fit_with(model, &data, Confounded::Drop)?;
    let points = GridPoints::of_space(&doe::Space::of_region(region)?)?;
    let lowest = surface.minimum_over(&points)?.context("the regression is nowhere a number")?;
    Ok(Step::new(Method::Alone, seed, step, space.point(Cell::new(lowest.index))?))
}

/// The pooled loop with the budget of the other.
pub(super) fn pooled_loop(task: &Task<'_>, seed: u64) -> Result<Vec<Step>> {
    let [experiments, simulations, batches] = task.budget;
    let mut settings = Settings::new(experiments);
    (settings.max_batches, settings.seed) = (batches, seed);
    // The rows that are kept were run so, as the page says.
    settings.displaced = false;
    // A stand-in reads the same in every batch.
    settings.blocks = Some(false);
    // Of the first batch's simulations those at its experiments are a part.
    settings.simulations = Some(simulations.saturating_sub(experiments).max(2));
    let mut campaign = pooled::Loop::new(task.space.region(), settings.clone())?;
    settings.simulations = Some(simulations);
    let mut steps = Vec::new();
    while let Ask::Run { trials, simulations } = campaign.ask(None)? {
        let costs = task.model.costs(&simulations);
        for (cell, cost) in simulations.into_iter().zip(costs) {
            campaign.tell_simulation(cell, cost)?;
        }
        if trials.is_empty() {
            continue;
        }
        tell(&mut campaign, task, &trials, seed)?;
        let assessment = campaign.assess(None)?.context("no experiment gave a response")?;
        let point = task.space.point(assessment.recommended.cell)?;
        steps.push(Step::new(Method::Pooled, seed, steps.len() + 1, point));
        campaign.set_settings(settings.clone())?;
    }
    Ok(steps)
}

/// Makes experiments and tells what they read.
fn tell(campaign: &mut pooled::Loop, task: &Task<'_>, trials: &[pooled::Trial], seed: u64) -> Result<()> {
    let points = trials.iter().map(|trial| Ok((trial.id.number(), task.space.point(trial.cell)?)));
    let points = points.collect::<Result<Vec<_>>>()?;
    for (trial, cost) in trials.iter().zip((task.read)(seed, &points)) {
        campaign.tell(trial.id, cost.into())?;
    }
    Ok(())
}

/// All experiments at Sobol points, and a Gaussian process through them.
pub(super) fn process(task: &Task<'_>, seed: u64) -> Result<Step> {
    let [experiments, _, batches] = task.budget;
    let mut settings = Settings::new(experiments * batches);
    settings.seed = seed;
    settings.structures = vec![Structure { simulation: SimulationUse::Ignored, residual: Residual::Smooth }];
    let mut campaign = pooled::Loop::new(task.space.region(), settings)?;
    let cells = sobol_points(task.space, experiments * batches, seed as u32);
    let cells = cells.iter().map(|point| task.space.nearest(point)).collect::<Result<Vec<_>>>()?;
    let trials = campaign.hand_out(&cells)?;
    tell(&mut campaign, task, &trials, seed)?;
    let Some(assessment) = campaign.assess(None)? else { bail!("no experiment gave a response") };
    Ok(Step::new(Method::Process, seed, batches, task.space.point(assessment.recommended.cell)?))
}

/// The first points of a scrambled Sobol sequence over the box.
pub(super) fn sobol_points(space: &Space, count: usize, scramble: u32) -> Vec<Vec<f64>> {
    let parameters = space.region().parameters();
    let point = |index: u32| {
        let coordinate = |(axis, parameter): (u32, &design_space::Parameter)| {
            parameter.lower() + parameter.width() * f64::from(sobol_burley::sample(index, axis, scramble))
        };
        (0..).zip(parameters).map(coordinate).collect()
    };
    (0..count as u32).map(point).collect()
}
