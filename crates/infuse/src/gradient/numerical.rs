//! The numerical half of an iteration: the optimum of the corrected model and its slope there.

use design_space::{Parameter, Region};
use serde::{Deserialize, Serialize};

use crate::codesign::evaluator::{Evaluator, Simulation};
use crate::codesign::run::optimize;
use crate::codesign::{CodesignStop, FailedSimulation};
use crate::correction::Local;
use crate::gradient::settings::{BoundPolicy, Settings};
use crate::gradient::slope::{Side, slope, slope_away};
use crate::{CodesignProblem, Error};

/// The numerical half of an iteration: the optimum p* of J + J_cor with the correction known then.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NumericalOptimum {
    /// p*, natural coordinates.
    pub point: Vec<f64>,
    /// J(p*), the simulation alone.
    pub model_cost: f64,
    /// J_cor(p*).
    pub correction_value: f64,
    /// J(p*) + J_cor(p*): the "numerical cost (corrected)" of Table 3.
    pub corrected_cost: f64,
    /// Slope of J + J_cor at p* per unit of each parameter, by differences of the simulation: close
    /// to zero unless a bound is active; unknown where too many simulations failed.
    pub model_gradient: Vec<Option<f64>>,
    /// Simulations run for the optimum and the gradient, failed ones included.
    pub n_simulations: usize,
    /// Simulations that gave no finite cost.
    pub failures: Vec<FailedSimulation>,
    /// Why the optimization ended.
    pub stop: CodesignStop,
}

/// Optimizes J + J_cor, starting from the last optimum if there is one, and takes its gradient there:
/// central differences, or second-order one-sided ones where a side is out of bounds or fails, so that
/// a bound nearby does not bias what an interior optimum should find to be zero.
pub(crate) fn numerical_optimum(
    problem: &CodesignProblem,
    settings: &Settings,
    last_optimum: Option<&[f64]>,
    correction: &Local,
    simulation: &mut Simulation<'_>,
) -> Result<NumericalOptimum, Error> {
    let region = problem.region();
    let (start, in_reach) = match (last_optimum, &settings.start) {
        (Some(last), _) => (last.to_vec(), problem_in_reach(problem, settings, last)?),
        (None, Some(start)) => (start.clone(), problem.clone()),
        (None, None) => (region.center(), problem.clone()),
    };
    let limit = settings.optimizer.max_simulations;
    let mut evaluator = Evaluator::new(in_reach.region(), correction, simulation, limit);
    let stop = optimize(&in_reach, &settings.optimizer, &start, &mut evaluator)?;
    let best = evaluator.best()?;

    let slopes = slopes(region, settings, &best.point, best.model_cost, &mut |point| evaluator.simulate(point));
    let with_correction = slopes.into_iter().zip(correction.slope());
    let model_gradient = with_correction.map(|(slope, own)| slope.map(|slope| slope + own)).collect();
    Ok(NumericalOptimum {
        point: best.point,
        model_cost: best.model_cost,
        correction_value: best.correction_value,
        corrected_cost: best.corrected_cost,
        model_gradient,
        n_simulations: evaluator.n_simulations,
        failures: evaluator.failures,
        stop,
    })
}

/// Slopes of the simulation at a point with the cost `center`, by the steps for the model; unknown where too many simulations
/// fail.
pub(crate) fn slopes(
    region: &Region,
    settings: &Settings,
    point: &[f64],
    center: f64,
    simulate: &mut dyn FnMut(&[f64]) -> Option<f64>,
) -> Vec<Option<f64>> {
    let may_leave = settings.bound_policy == BoundPolicy::StepOutside;
    let steps = settings.model_steps().into_iter().enumerate();
    steps
        .map(|(index, step)| {
            let mut side = |offset: f64| {
                let mut moved = point.to_vec();
                moved[index] += offset;
                let distance = (moved[index] - point[index]).abs();
                if !may_leave && !region.parameters()[index].contains(moved[index]) {
                    return None;
                }
                simulate(&moved).map(|cost| Side { distance, cost })
            };
            match (side(step), side(-step)) {
                (plus, None) => slope_away(center, plus, side(2.0 * step)),
                (None, minus) => slope_away(center, minus, side(-2.0 * step)).map(|slope| -slope),
                (plus, minus) => slope(Some(center), plus, minus),
            }
        })
        .collect()
}

/// The problem on that part of its region which the move limits allow from the last optimum.
fn problem_in_reach(problem: &CodesignProblem, settings: &Settings, last: &[f64]) -> Result<CodesignProblem, Error> {
    let Some(limits) = &settings.move_limits else {
        return Ok(problem.clone());
    };
    let parameters = problem.region().parameters().iter();
    let in_reach = parameters.zip(last.iter().zip(limits)).map(|(parameter, (here, limit))| {
        let lower = parameter.lower().max(here - limit);
        let upper = parameter.upper().min(here + limit);
        Parameter::continuous(parameter.name(), parameter.unit(), lower, upper)
    });
    let region = Region::new(in_reach.collect::<Result<_, _>>()?)?;
    CodesignProblem::new(region, problem.roles().to_vec())
}
