//! The four strategies of combined plant and controller optimization.

use serde::{Deserialize, Serialize};

use crate::codesign::evaluator::{Evaluator, FailedSimulation};
use crate::codesign::optimizer::{CodesignStop, OptimizerSettings};
use crate::codesign::search::{SearchSettings, search};
use crate::codesign::strategy::Strategy;
use crate::correction::Local;
use crate::{CodesignProblem, Error, Role};

/// What a numerical optimization found and what it took.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CodesignReport {
    /// The best point simulated, natural coordinates.
    pub point: Vec<f64>,
    /// Its cost.
    pub cost: f64,
    /// Simulations run, failed ones included.
    pub n_simulations: usize,
    /// Simulations that gave no finite cost, in the order they were run.
    pub failures: Vec<FailedSimulation>,
    /// Why the optimization ended.
    pub stop: CodesignStop,
}

impl CodesignReport {
    /// Whether the point is as good as the settings allow.
    #[must_use]
    pub fn is_converged(&self) -> bool {
        self.stop.is_converged()
    }
}

/// Minimizes the cost of a simulation over plant and controller parameters together, by the strategy
/// of the settings.
///
/// `start` is a natural point of the region: the warm start of every search, and the controller with
/// which the sequential and the iterative strategy begin. `simulation` maps a natural point to a cost
/// or to the reason why there is none. A failed simulation does not end the optimization: the search
/// meets a barrier there, and the report lists the point and the reason. The result is a point that
/// was simulated, never one of the barrier.
///
/// Every descent is BOBYQA in coded coordinates: it suits smooth costs, and can stop short of the
/// optimum on a kink. Only the nested strategy looks at the whole controller axis for each plant it
/// tries; what the others miss is shown at [`Strategy`].
///
/// # Errors
///
/// [`Error::DesignSpace`] for a start outside the region, [`Error::NeedsPlantAndController`],
/// [`Error::Setting`], [`Error::SettingCount`], [`Error::EverySimulationFailed`].
///
/// ```
/// use design_space::{Parameter, Region};
/// use infuse::codesign::{OptimizerSettings, codesign};
/// use infuse::{CodesignProblem, Role};
///
/// let region = Region::new(vec![
///     Parameter::continuous("mass", "kg", 0.0, 4.0)?,
///     Parameter::continuous("gain", "1", -1.0, 1.0)?,
/// ])?;
/// let problem = CodesignProblem::new(region, vec![Role::Plant, Role::Controller])?;
/// let mut cost = |p: &[f64]| Ok((p[0] - 3.0).powi(2) + (p[1] - 0.2 * p[0]).powi(2));
/// let report = codesign(&problem, &OptimizerSettings::default(), &[2.0, 0.0], &mut cost)?;
/// assert!((report.point[0] - 3.0).abs() < 0.01 && (report.point[1] - 0.6).abs() < 0.01);
/// # Ok::<(), infuse::Error>(())
/// ```
pub fn codesign(
    problem: &CodesignProblem,
    settings: &OptimizerSettings,
    start: &[f64],
    simulation: &mut impl FnMut(&[f64]) -> Result<f64, String>,
) -> Result<CodesignReport, Error> {
    settings.validate()?;
    let correction = Local::zero(problem.n_parameters());
    let mut evaluator = Evaluator::new(problem.region(), &correction, simulation, settings.max_simulations);
    let stop = optimize(problem, settings, start, &mut evaluator)?;
    let best = evaluator.best()?;
    Ok(CodesignReport {
        point: best.point,
        cost: best.corrected_cost,
        n_simulations: evaluator.n_simulations,
        failures: evaluator.failures,
        stop,
    })
}

/// Runs the strategy; the evaluator holds what it found.
pub(crate) fn optimize(
    problem: &CodesignProblem,
    settings: &OptimizerSettings,
    start: &[f64],
    evaluator: &mut Evaluator<'_>,
) -> Result<CodesignStop, Error> {
    problem.check_strategy(settings.strategy)?;
    problem.region().check(start)?;
    let mut blocks = Blocks {
        plant: problem.indices(Role::Plant),
        controller: problem.indices(Role::Controller),
        settings,
        current: problem.region().coded(start)?,
        evaluator,
    };
    let stop = match settings.strategy {
        Strategy::Nested => blocks.nested(),
        Strategy::Simultaneous => blocks.simultaneous(),
        Strategy::Sequential => blocks.sweep(),
        Strategy::Iterative => blocks.iterative(),
    }?;
    Ok(if evaluator.limit_was_reached { CodesignStop::SimulationLimit } else { stop })
}

/// The two blocks of coordinates and the coded point they are cut from.
struct Blocks<'a, 'b> {
    plant: Vec<usize>,
    controller: Vec<usize>,
    settings: &'a OptimizerSettings,
    current: Vec<f64>,
    evaluator: &'a mut Evaluator<'b>,
}

impl Blocks<'_, '_> {
    /// Searches the plant; each cost it sees is that of a complete controller search.
    fn nested(&mut self) -> Result<CodesignStop, Error> {
        let inner_settings = SearchSettings {
            final_radius: self.settings.inner_final_radius,
            ..self.search_settings(self.settings.n_controller_starts)
        };
        let mut inner_stop = CodesignStop::Converged;
        let mut controller = pick(&self.current, &self.controller);
        let outer =
            search(&pick(&self.current, &self.plant), &self.search_settings(self.settings.n_starts), &mut |plant| {
                put(&mut self.current, &self.plant, plant);
                let inner = search(&controller, &inner_settings, &mut |candidate| {
                    put(&mut self.current, &self.controller, candidate);
                    self.evaluator.evaluate(&self.current)
                })?;
                inner_stop = inner_stop.and(inner.stop);
                Ok(inner.best.map(|(coded, value)| {
                    controller = coded;
                    value
                }))
            })?;
        Ok(outer.stop.and(inner_stop))
    }

    fn simultaneous(&mut self) -> Result<CodesignStop, Error> {
        let every_index: Vec<usize> = (0..self.current.len()).collect();
        self.block(&every_index, self.settings.n_starts)
    }

    /// The plant at the current controller, then the controller on that plant.
    fn sweep(&mut self) -> Result<CodesignStop, Error> {
        let plant_stop = self.block(&self.plant.clone(), self.settings.n_starts)?;
        let n_starts = self.settings.n_controller_starts;
        let controller_stop = self.block(&self.controller.clone(), n_starts)?;
        Ok(plant_stop.and(controller_stop))
    }

    fn iterative(&mut self) -> Result<CodesignStop, Error> {
        for _ in 0..self.settings.max_sweeps {
            let before = self.current.clone();
            let stop = self.sweep()?;
            let mut moves = before.iter().zip(&self.current).map(|(a, b)| (a - b).abs());
            if moves.all(|step| step <= self.settings.final_radius) {
                return Ok(stop);
            }
        }
        Ok(CodesignStop::SweepLimit)
    }

    /// Optimizes the coordinates of one block, the others staying where they are.
    fn block(&mut self, indices: &[usize], n_starts: usize) -> Result<CodesignStop, Error> {
        let mut candidate = self.current.clone();
        let found = search(&pick(&self.current, indices), &self.search_settings(n_starts), &mut |block| {
            put(&mut candidate, indices, block);
            self.evaluator.evaluate(&candidate)
        })?;
        if let Some((block, _)) = found.best {
            put(&mut self.current, indices, &block);
        }
        Ok(found.stop)
    }

    fn search_settings(&self, n_starts: usize) -> SearchSettings {
        SearchSettings {
            n_starts,
            initial_radius: self.settings.initial_radius,
            final_radius: self.settings.final_radius,
            max_steps: self.settings.max_search_steps,
        }
    }
}

fn pick(point: &[f64], indices: &[usize]) -> Vec<f64> {
    indices.iter().map(|&index| point[index]).collect()
}

fn put(point: &mut [f64], indices: &[usize], block: &[f64]) {
    for (&index, &value) in indices.iter().zip(block) {
        point[index] = value;
    }
}
