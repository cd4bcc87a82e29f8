//! An iteration on its way: what was asked, and what has been told.

use std::collections::BTreeSet;

use design_space::Region;
use serde::{Deserialize, Serialize};

use crate::global::batch::Batch;
use crate::global::cells::Cells;
use crate::global::observations::Observations;
use crate::global::report::SimulationRecord;
use crate::global::trial::{Trial, TrialRecord, TrialUse};
use crate::{Error, Outcome, TrialId};

/// A batch, its simulations, and the trials that wait for a person.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct OpenIteration {
    pub(crate) batch: Batch,
    pub(crate) simulations: Vec<SimulationRecord>,
    pub(crate) trials: Vec<TrialRecord>,
}

impl OpenIteration {
    pub(crate) fn is_complete(&self) -> bool {
        self.trials.iter().all(|record| record.outcome.is_some())
    }

    /// Experiments with this use that gave a cost, where they were really made.
    pub(crate) fn experiments(&self, used_for: TrialUse, region: &Region) -> Result<Observations, Error> {
        let mut observations = Observations::none(region.n_parameters());
        for record in self.trials.iter().filter(|record| record.trial.used_for == used_for) {
            if let Some(cost) = record.outcome.as_ref().and_then(Outcome::cost) {
                let point = region.coded(record.settings())?;
                observations.add_experiment(record.trial.id, &point, cost)?;
            }
        }
        Ok(observations)
    }

    /// Where a simulation failed.
    pub(crate) fn failed_cells(&self) -> BTreeSet<u64> {
        let failed = self.simulations.iter().filter(|record| record.outcome.cost().is_none());
        failed.map(|record| record.cell).collect()
    }

    pub(crate) fn simulations(&self, cells: &Cells) -> Result<Observations, Error> {
        simulated(&self.simulations, cells)
    }
}

/// Simulations that gave a cost.
pub(crate) fn simulated(records: &[SimulationRecord], cells: &Cells) -> Result<Observations, Error> {
    let mut observations = Observations::none(cells.n_factors());
    for record in records {
        if let Some(cost) = record.outcome.cost() {
            observations.add_simulation(&cells.coded(record.cell)?, cost)?;
        }
    }
    Ok(observations)
}

/// Runs the simulation at a cell; a failure is written down.
pub(crate) fn simulation_record(
    cell: u64,
    cells: &Cells,
    simulation: &mut impl FnMut(&[f64]) -> Result<f64, String>,
) -> Result<SimulationRecord, Error> {
    let point = cells.natural(cell)?;
    let outcome = match simulation(&point) {
        Ok(cost) if !cost.is_finite() => Outcome::Failed { reason: format!("the simulation returned {cost}") },
        result => result.into(),
    };
    Ok(SimulationRecord { cell, point, outcome })
}

/// The trials of an iteration, numbered on from those before.
pub(crate) fn trials(
    design: &[u64],
    uses: &[TrialUse],
    cells: &Cells,
    iteration: usize,
    n_before: u64,
) -> Result<Vec<TrialRecord>, Error> {
    let record = |(number, (&cell, &used_for)): (u64, (&u64, &TrialUse))| {
        let point = cells.natural(cell)?;
        let trial = Trial { id: TrialId::new(number), iteration, used_for, cell, point };
        Ok(TrialRecord { trial, actual: None, outcome: None })
    };
    (n_before + 1..).zip(design.iter().zip(uses)).map(record).collect()
}
