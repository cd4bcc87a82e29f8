//! What an iteration did and why a campaign ended.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::correction::Correction;
use crate::gradient::slope::slope;
use crate::gradient::trial::TrialRecord;
use crate::gradient::{Settings, TrialRole};
use crate::{CodesignStop, FailedSimulation, Outcome};

/// Why a campaign ended.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StopReason {
    /// No parameter of the optimum moved by more than its tolerance, after an iteration that had
    /// corrected every parameter; a parameter on a bound counts only if the experiments of the last
    /// iteration too got worse away from that bound.
    Converged,
    /// [`Settings::max_iterations`] were made.
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
    pub correction: Correction,
}

impl Report {
    /// Closes an iteration whose trials have all been told: gradient of the experiments, then
    /// the repaired (27), or (27) as printed.
    pub(crate) fn close(
        iteration: usize,
        numerical: NumericalOptimum,
        trials: Vec<TrialRecord>,
        correction_before: &Correction,
        settings: &Settings,
    ) -> Self {
        let optimum = &numerical.point;
        let with_role = |role| trials.iter().find(|record| record.trial.role == role);
        let center = with_role(TrialRole::Center).and_then(|record| record.outcome.as_ref());
        let experiment_cost = center.and_then(Outcome::cost);
        let side = |role| with_role(role).and_then(|record| record.side(optimum));
        let experiment_gradient: Vec<Option<f64>> = (0..optimum.len())
            .map(|index| {
                let (plus, minus) = (side(TrialRole::Plus(index)), side(TrialRole::Minus(index)));
                slope(experiment_cost, plus, minus)
            })
            .collect();
        let mut correction = correction_before.clone();
        let is_corrected = (0..optimum.len())
            .map(|index| {
                let change = settings.correction_form.slope_change(
                    settings.trust[index],
                    experiment_gradient[index],
                    numerical.model_gradient[index],
                );
                change.is_some_and(|change| correction.add(index, change, optimum[index]))
            })
            .collect();
        Self { iteration, numerical, trials, experiment_cost, experiment_gradient, is_corrected, correction }
    }

    /// Experiments of this iteration, failed ones included.
    #[must_use]
    pub fn n_experiments(&self) -> usize {
        self.trials.len()
    }

    /// The trials that were told as failed.
    pub fn failed_trials(&self) -> impl Iterator<Item = &TrialRecord> {
        let is_failed = |record: &&TrialRecord| matches!(record.outcome, Some(Outcome::Failed { .. }));
        self.trials.iter().filter(is_failed)
    }
}
