//! The experiments around an optimum, and what is known of them.

use design_space::Region;
use serde::{Deserialize, Serialize};

use crate::gradient::settings::BoundPolicy;
use crate::gradient::slope::Side;
use crate::{Error, Outcome, TrialId};

/// Place of a trial in the design around the optimum; parameters by their index in the region.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TrialRole {
    /// The numerical optimum p* itself.
    Center,
    /// p* with this parameter one experiment step higher.
    Plus(usize),
    /// p* with this parameter one experiment step lower.
    Minus(usize),
}

/// An experiment to run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Trial {
    /// Number by which the outcome is told.
    pub id: TrialId,
    /// Iteration it belongs to, from 1.
    pub iteration: usize,
    /// Place in the design.
    pub role: TrialRole,
    /// Settings, natural coordinates.
    pub point: Vec<f64>,
}

/// A trial with what has been told about it so far.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrialRecord {
    /// What was asked.
    pub trial: Trial,
    /// The setting actually made of the parameter that the trial varies, in its unit, if it was told.
    pub actual: Option<f64>,
    /// What was told; nothing while the trial is outstanding.
    pub outcome: Option<Outcome>,
}

impl TrialRecord {
    /// Writes an outcome down, after checking it against the trial and the center it belongs to.
    pub(crate) fn tell(&mut self, actual: Option<f64>, outcome: Outcome, optimum: &[f64]) -> Result<(), Error> {
        let id = self.trial.id;
        if self.outcome.is_some() {
            return Err(Error::AlreadyTold { id });
        }
        if let Some(value) = outcome.cost().filter(|cost| !cost.is_finite()) {
            return Err(Error::NonFiniteOutcome { id, value });
        }
        if let Some(actual) = actual {
            self.check_actual(actual, optimum)?;
        }
        self.actual = actual;
        self.outcome = Some(outcome);
        Ok(())
    }

    fn check_actual(&self, actual: f64, optimum: &[f64]) -> Result<(), Error> {
        let (is_usable, expected) = match self.trial.role {
            TrialRole::Center => (false, "none: the center varies no parameter"),
            TrialRole::Plus(index) => (actual > optimum[index], "a number above the center's"),
            TrialRole::Minus(index) => (actual < optimum[index], "a number below the center's"),
        };
        if is_usable && actual.is_finite() {
            return Ok(());
        }
        Err(Error::ActualSetting { id: self.trial.id, actual, expected })
    }

    /// Measured cost and distance from the center of a side trial.
    pub(crate) fn side(&self, optimum: &[f64]) -> Option<Side> {
        let (TrialRole::Plus(index) | TrialRole::Minus(index)) = self.trial.role else {
            return None;
        };
        let cost = self.outcome.as_ref()?.cost()?;
        let setting = self.actual.unwrap_or(self.trial.point[index]);
        let distance = (setting - optimum[index]).abs();
        Some(Side { distance, cost })
    }
}

/// The sides of the design around a point: two per parameter, except where a step would leave the
/// region and must not.
pub(crate) fn sides(point: &[f64], steps: &[f64], region: &Region, policy: BoundPolicy) -> Vec<(TrialRole, Vec<f64>)> {
    let mut sides = Vec::with_capacity(2 * point.len());
    for (index, (parameter, &step)) in region.parameters().iter().zip(steps).enumerate() {
        for (role, setting) in
            [(TrialRole::Plus(index), point[index] + step), (TrialRole::Minus(index), point[index] - step)]
        {
            if policy == BoundPolicy::StepOutside || parameter.contains(setting) {
                let mut side = point.to_vec();
                side[index] = setting;
                sides.push((role, side));
            }
        }
    }
    sides
}
