//! One experiment of a batch, and the settings at which it was really made.

use design_space::Cell;
use serde::{Deserialize, Serialize};

use crate::TrialId;
use crate::ledger::{Ledger, Numbered, Record};

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
    /// Number under which its outcome is reported.
    pub id: TrialId,
    /// Batch it belongs to, from 1.
    #[serde(alias = "iteration")]
    pub batch: usize,
    /// What it is used for.
    pub used_for: TrialUse,
    /// The cell.
    pub cell: Cell,
    /// Settings, natural coordinates.
    pub point: Vec<f64>,
}

impl Numbered for Trial {
    fn id(&self) -> TrialId {
        self.id
    }
}

/// A trial of the dissertation's loop with what is known of it. `actual` holds the settings really made of all parameters, natural.
pub type TrialRecord = Record<Trial, Vec<f64>>;

/// The trials of a batch.
pub(crate) type Trials = Ledger<Trial, Vec<f64>>;

impl Record<Trial, Vec<f64>> {
    /// The settings of the experiment: those really made if they were reported, otherwise those asked for; natural.
    #[must_use]
    pub fn settings(&self) -> &[f64] {
        self.actual.as_ref().unwrap_or(&self.trial.point)
    }
}
