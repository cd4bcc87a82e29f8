//! What an iteration did and why a campaign ended.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::correction::Local;
use crate::gradient::numerical::NumericalOptimum;
use crate::gradient::trial::TrialRecord;

/// Why a campaign ended.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StopReason {
    /// No parameter of the optimum moved by more than its tolerance, after an iteration that had
    /// corrected every parameter; a parameter on a bound counts only if the experiments of the last
    /// iteration too got worse away from that bound.
    Converged,
    /// [`Settings::max_iterations`](crate::gradient::Settings::max_iterations) were made.
    IterationLimit,
    /// So many trials of the last iteration failed that no parameter could be corrected: another
    /// iteration would ask the same again.
    NoInformation,
}

impl fmt::Display for StopReason {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Converged => "converged",
            Self::IterationLimit => "the limit on the iterations was reached",
            Self::NoInformation => "too many trials of the last iteration failed",
        })
    }
}

/// One closed iteration: optimum, experiments and the correction learned from them.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Report {
    /// Number of the iteration, from 1.
    pub iteration: usize,
    /// The numerical optimum the experiments were made around.
    pub numerical: NumericalOptimum,
    /// Every trial with its outcome.
    pub trials: Vec<TrialRecord>,
    /// Measured cost at p*, the "experimental cost" of Table 3; unknown if that trial failed.
    pub experiment_cost: Option<f64>,
    /// Slope of the measured cost at p* per unit of each parameter, by differences; unknown where
    /// too many trials failed.
    pub experiment_gradient: Vec<Option<f64>>,
    /// Whether the correction of each parameter was updated. Where a gradient is unknown it stays
    /// as it was.
    pub is_corrected: Vec<bool>,
    /// The correction after this iteration.
    pub correction: Local,
}

impl Report {
    /// Experiments of this iteration, failed ones included.
    #[must_use]
    pub fn n_experiments(&self) -> usize {
        self.trials.len()
    }

    /// The trials that failed.
    pub fn failed_trials(&self) -> impl Iterator<Item = &TrialRecord> {
        self.trials.iter().filter(|record| record.is_failed())
    }
}
