//! A batch on its way: its designs, its simulations, and the experiments that wait for a person.

use std::collections::BTreeSet;

use design_space::{Cell, Region};
use serde::{Deserialize, Serialize};

use crate::global::batch::Batch;
use crate::global::cells::Cells;
use crate::global::report::SimulationRecord;
use crate::global::settings::Settings;
use crate::global::trial::{Trial, TrialUse, Trials};
use crate::ledger::{Ledger, ids_after};
use crate::traced::{Observations, TracedSurface};
use crate::{Error, Outcome};

/// A batch, its simulations, and the trials that wait for a person.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct OpenBatch {
    pub(crate) batch: Batch,
    pub(crate) simulations: Vec<SimulationRecord>,
    pub(crate) trials: Trials,
}

impl OpenBatch {
    /// Experiments with this use that gave a response, where they were really made.
    pub(crate) fn experiments(&self, used_for: TrialUse, region: &Region) -> Result<Observations, Error> {
        self.those(region, |trial| trial.used_for == used_for)
    }

    /// Those of these trials that gave a response, where they were really made.
    pub(crate) fn those(&self, region: &Region, are: impl Fn(&Trial) -> bool) -> Result<Observations, Error> {
        let mut observations = Observations::none(region.n_parameters());
        for record in self.trials.records().iter().filter(|record| are(&record.trial)) {
            if let Some(cost) = record.cost() {
                let point = region.coded(record.settings())?;
                observations.add_experiment(record.trial.id, &point, cost)?;
            }
        }
        Ok(observations)
    }

    /// Simulations that gave a response.
    pub(crate) fn simulations(&self, cells: &Cells) -> Result<Observations, Error> {
        let mut observations = Observations::none(cells.n_factors());
        for record in &self.simulations {
            if let Some(cost) = record.outcome.cost() {
                observations.add_simulation(&cells.coded(record.cell)?, cost)?;
            }
        }
        Ok(observations)
    }

    /// Where a simulation failed.
    pub(crate) fn failed_cells(&self) -> BTreeSet<Cell> {
        self.failed_simulations().map(|(record, _)| record.cell).collect()
    }

    /// Whether the simulations that succeeded determine their surface.
    pub(crate) fn check_simulations(&self, cells: &Cells, settings: &Settings) -> Result<(), Error> {
        let (n_simulations, n_failed) = (self.simulations.len(), self.failed_simulations().count());
        if n_failed == n_simulations {
            let first = self.failed_simulations().next();
            let first = first.map(|(record, reason)| (record.point.clone(), reason.to_owned()));
            let (first_point, first_reason) = first.unwrap_or_default();
            return Err(Error::EverySimulationFailed { n_simulations, first_point, first_reason });
        }
        let kind = settings.surfaces.simulation.with_model(&self.batch.model(settings)?);
        match TracedSurface::fit(&kind, &self.simulations(cells)?) {
            Err(Error::Surface(reason)) if n_failed > 0 => {
                Err(Error::TooFewSimulations { n_failed, n_simulations, reason })
            }
            result => result.map(|_| ()),
        }
    }

    fn failed_simulations(&self) -> impl Iterator<Item = (&SimulationRecord, &str)> {
        self.simulations.iter().filter_map(|record| match &record.outcome {
            Outcome::Failed { reason } => Some((record, reason.as_str())),
            Outcome::Value(_) => None,
        })
    }
}

/// A simulation by reference: the loop is compiled once, not for each simulation.
pub(crate) type Simulation<'a> = dyn FnMut(Cell, &[f64]) -> Result<f64, String> + 'a;

/// Runs the simulation at a cell; a failure is written down.
pub(crate) fn simulated(cell: Cell, cells: &Cells, simulation: &mut Simulation<'_>) -> Result<SimulationRecord, Error> {
    let point = cells.natural(cell)?;
    let outcome = match simulation(cell, &point) {
        Ok(cost) if !cost.is_finite() => Outcome::Failed { reason: format!("the simulation returned {cost}") },
        result => result.into(),
    };
    Ok(SimulationRecord { cell, point, outcome })
}

/// The trials of a batch, numbered on from the `n_asked` before.
pub(crate) fn trials(
    design: &[Cell],
    uses: &[TrialUse],
    cells: &Cells,
    batch: usize,
    n_asked: u64,
) -> Result<Trials, Error> {
    let trial = |(id, (&cell, &used_for))| {
        let point = cells.natural(cell)?;
        Ok(Trial { id, batch, used_for, cell, point })
    };
    let trials: Result<Vec<Trial>, Error> = ids_after(n_asked).zip(design.iter().zip(uses)).map(trial).collect();
    Ok(Ledger::of(trials?))
}
