//! One experiment of a batch, and what is told about it.

use design_space::Region;
use serde::{Deserialize, Serialize};

use crate::{Error, Outcome, TrialId};

/// What an experiment is used for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TrialUse {
    /// It enters the experiment surface and the combined one.
    Training,
    /// It enters the experiment surface; the combined one is compared with it.
    Validation,
}

/// An experiment to run, on a cell of the grid.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Trial {
    /// Number by which the outcome is told.
    pub id: TrialId,
    /// Iteration it belongs to, from 1.
    pub iteration: usize,
    /// What it is used for.
    pub used_for: TrialUse,
    /// The cell, by its index in the grid.
    pub cell: u64,
    /// Settings, natural coordinates.
    pub point: Vec<f64>,
}

/// A trial with what has been told about it so far.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrialRecord {
    /// What was asked.
    pub trial: Trial,
    /// The settings actually made, natural, if they were told.
    pub actual: Option<Vec<f64>>,
    /// What was told; nothing while the trial is outstanding.
    pub outcome: Option<Outcome>,
}

impl TrialRecord {
    /// Writes an outcome down, after checking it.
    pub(crate) fn tell(&mut self, actual: Option<Vec<f64>>, outcome: Outcome, region: &Region) -> Result<(), Error> {
        let id = self.trial.id;
        if self.outcome.is_some() {
            return Err(Error::AlreadyTold { id });
        }
        if let Some(value) = outcome.cost().filter(|cost| !cost.is_finite()) {
            return Err(Error::NonFiniteOutcome { id, value });
        }
        if let Some(actual) = &actual {
            check_actual(id, actual, region)?;
        }
        self.actual = actual;
        self.outcome = Some(outcome);
        Ok(())
    }

    /// The settings of the experiment: those made if they were told, otherwise those asked for; natural.
    #[must_use]
    pub fn settings(&self) -> &[f64] {
        self.actual.as_ref().unwrap_or(&self.trial.point)
    }
}

fn check_actual(id: TrialId, actual: &[f64], region: &Region) -> Result<(), Error> {
    let Some((parameter, actual)) = far_setting(actual, region)? else {
        return Ok(());
    };
    Err(Error::ActualSettingOf { id, parameter, actual, expected: NEAR_THE_REGION })
}

pub(crate) const NEAR_THE_REGION: &str = "within half the parameter's width of its bounds";

/// The first of these natural settings that is too far off. Settings may be off the grid and somewhat outside the box, as
/// rigs are; a coded coordinate beyond 2 is a slip.
pub(crate) fn far_setting(settings: &[f64], region: &Region) -> Result<Option<(String, f64)>, Error> {
    let coded = region.coded(settings)?;
    let mut far = region.parameters().iter().zip(settings.iter().zip(coded));
    let far = far.find(|(_, (_, coded))| coded.is_nan() || coded.abs() > 2.0);
    Ok(far.map(|(parameter, (&value, _))| (parameter.name().to_owned(), value)))
}
