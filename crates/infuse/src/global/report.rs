//! What a batch of the dissertation's loop did, and why a campaign ended.

use std::fmt;

use design_space::Cell;
use serde::{Deserialize, Serialize};

use crate::Outcome;
use crate::global::batch::Batch;
use crate::global::changes::SurfaceChanges;
use crate::global::screening::Screening;
use crate::global::settings::Settings;
use crate::global::trial::TrialRecord;

/// Why a global campaign ended.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StopReason {
    /// Fewer than two cells are left: nothing remains to be chosen.
    FewerThanTwoCells,
    /// [`Settings::max_batches`] were made.
    #[serde(alias = "iteration_limit")]
    BatchLimit,
    /// Every experiment of the last batch failed.
    NoInformation,
    /// The validation experiments of the last batch gave no spread S, and
    /// [`SpreadFallback::Stop`](crate::global::SpreadFallback::Stop) was set.
    NoSpread,
}

impl fmt::Display for StopReason {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::FewerThanTwoCells => "fewer than two cells are left",
            Self::BatchLimit => "the limit on the batches was reached",
            Self::NoInformation => "every experiment of the last batch failed",
            Self::NoSpread => "the validation experiments gave no spread",
        })
    }
}

/// One simulation of a batch.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SimulationRecord {
    /// The cell.
    pub cell: Cell,
    /// Its settings, natural.
    pub point: Vec<f64>,
    /// Cost, or why there is none.
    pub outcome: Outcome,
}

/// One closed batch of Figure 19.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Report {
    /// Number of the batch, from 1.
    #[serde(alias = "iteration")]
    pub number: usize,
    /// What was designed, and over what.
    pub batch: Batch,
    /// Every simulation, failed ones included.
    pub simulations: Vec<SimulationRecord>,
    /// Every experiment with its outcome.
    pub trials: Vec<TrialRecord>,
    /// How many [earlier experiments](crate::global::EarlierExperiment) counted in it.
    #[serde(default, skip_serializing_if = "crate::global::settings::is_zero")]
    pub n_earlier: usize,
    /// The optimum, the z-test and what it left.
    pub screening: Screening,
    /// Why the experiments could not be fitted, too many having failed: the correction is then that of the batch
    /// before. Nothing if it was updated.
    pub not_corrected: Option<String>,
    /// How the surfaces moved, largest magnitudes over the cells at the onset of the batch.
    pub changes: SurfaceChanges,
}

impl Report {
    /// The experiments that failed.
    pub fn failed_trials(&self) -> impl Iterator<Item = &TrialRecord> {
        self.trials.iter().filter(|record| record.is_failed())
    }

    /// The simulations that gave no response.
    pub fn failed_simulations(&self) -> impl Iterator<Item = &SimulationRecord> {
        self.simulations.iter().filter(|record| matches!(record.outcome, Outcome::Failed { .. }))
    }

    /// Why a campaign that has come this far ends here, if it does.
    pub(crate) fn stop(&self, settings: &Settings) -> Option<StopReason> {
        self.own_stop(settings).or_else(|| (self.number >= settings.max_batches).then_some(StopReason::BatchLimit))
    }

    /// The same, whatever the limit on the batches.
    pub(crate) fn own_stop(&self, settings: &Settings) -> Option<StopReason> {
        if self.trials.iter().all(|record| record.cost().is_none()) {
            Some(StopReason::NoInformation)
        } else if self.screening.ends_campaign(settings) {
            Some(StopReason::NoSpread)
        } else if self.screening.n_after < 2 {
            Some(StopReason::FewerThanTwoCells)
        } else {
            None
        }
    }
}
