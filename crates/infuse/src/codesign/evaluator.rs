//! The simulation as the searches see it: counted, corrected, its failures collected.

use design_space::Region;
use serde::{Deserialize, Serialize};

use crate::Error;
use crate::correction::Local;

/// A simulation that gave no finite cost.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FailedSimulation {
    /// Where, natural coordinates.
    pub point: Vec<f64>,
    /// Why, in the simulation's own words.
    pub reason: String,
}

/// The best point an evaluator has met.
#[derive(Debug, Clone)]
pub(crate) struct Best {
    pub(crate) point: Vec<f64>,
    pub(crate) model_cost: f64,
    pub(crate) correction_value: f64,
    pub(crate) corrected_cost: f64,
}

/// A simulation by reference: loops and searches are compiled once, not for each simulation.
pub(crate) type Simulation<'a> = dyn FnMut(&[f64]) -> Result<f64, String> + 'a;

/// Evaluates J + J_cor and remembers the best point, the failures and the count.
pub(crate) struct Evaluator<'a> {
    region: &'a Region,
    correction: &'a Local,
    simulation: &'a mut Simulation<'a>,
    max_simulations: usize,
    pub(crate) n_simulations: usize,
    pub(crate) failures: Vec<FailedSimulation>,
    pub(crate) best: Option<Best>,
    pub(crate) limit_was_reached: bool,
}

impl<'a> Evaluator<'a> {
    pub(crate) fn new(
        region: &'a Region,
        correction: &'a Local,
        simulation: &'a mut Simulation<'a>,
        max_simulations: usize,
    ) -> Self {
        Self {
            region,
            correction,
            simulation,
            max_simulations,
            n_simulations: 0,
            failures: Vec::new(),
            best: None,
            limit_was_reached: false,
        }
    }

    /// Corrected cost at a coded point; nothing if the simulation failed or the limit is reached.
    pub(crate) fn evaluate(&mut self, coded: &[f64]) -> Result<Option<f64>, Error> {
        if self.n_simulations >= self.max_simulations {
            self.limit_was_reached = true;
            return Ok(None);
        }
        let point = self.region.natural(coded)?;
        let Some(model_cost) = self.simulate(&point) else {
            return Ok(None);
        };
        let correction_value = self.correction.value_at(&point);
        let corrected_cost = model_cost + correction_value;
        let least = self.best.as_ref().map(|best| best.corrected_cost);
        if least.is_none_or(|least| corrected_cost < least) {
            self.best = Some(Best { point, model_cost, correction_value, corrected_cost });
        }
        Ok(Some(corrected_cost))
    }

    /// Cost J of the simulation alone at a natural point.
    pub(crate) fn simulate(&mut self, point: &[f64]) -> Option<f64> {
        self.n_simulations += 1;
        let reason = match (self.simulation)(point) {
            Ok(cost) if cost.is_finite() => return Some(cost),
            Ok(cost) => format!("the simulation returned {cost}"),
            Err(reason) => reason,
        };
        self.failures.push(FailedSimulation { point: point.to_vec(), reason });
        None
    }

    /// The best point, or why there is none.
    pub(crate) fn best(&self) -> Result<Best, Error> {
        self.best.clone().ok_or_else(|| {
            let first = self.failures.first();
            Error::EverySimulationFailed {
                n_simulations: self.n_simulations,
                first_point: first.map_or_else(Vec::new, |failure| failure.point.clone()),
                first_reason: first.map_or_else(String::new, |failure| failure.reason.clone()),
            }
        })
    }
}
