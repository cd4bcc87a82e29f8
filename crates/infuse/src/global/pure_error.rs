//! The noise of the experiments, from those that were repeated.

use std::collections::BTreeMap;

use crate::GlobalLoop;
use crate::Outcome;
use crate::global::trial::GlobalTrialRecord;

/// Scatter of experiments at equal settings about their mean, pooled over the campaign.
///
/// ```text
/// s² = Σ_settings Σ (J − J̄)² / Σ_settings (n − 1)
/// ```
///
/// It knows nothing of the model, so it is the noise alone: what a response surface misses by more is lack of fit.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct PureError {
    /// s², in the squared unit of the cost.
    pub variance: f64,
    /// Σ (n − 1), at least 1.
    pub degrees_of_freedom: usize,
}

impl PureError {
    /// s, in the unit of the cost.
    #[must_use]
    pub fn standard_deviation(&self) -> f64 {
        self.variance.sqrt()
    }

    /// Of costs in groups of equal settings; none if no setting was repeated.
    #[must_use]
    pub fn of_groups<'a>(groups: impl IntoIterator<Item = &'a [f64]>) -> Option<Self> {
        let (mut squares, mut degrees_of_freedom) = (0.0, 0);
        for costs in groups {
            let mean = costs.iter().sum::<f64>() / costs.len() as f64;
            squares += costs.iter().map(|cost| (cost - mean).powi(2)).sum::<f64>();
            degrees_of_freedom += costs.len().saturating_sub(1);
        }
        (degrees_of_freedom > 0).then(|| Self { variance: squares / degrees_of_freedom as f64, degrees_of_freedom })
    }
}

impl GlobalLoop {
    /// The noise of the experiments told so far, open iteration included; none while no setting was made twice.
    #[must_use]
    pub fn pure_error(&self) -> Option<PureError> {
        let closed = self.history.iter().flat_map(|report| &report.trials);
        let records = closed.chain(self.open.iter().flat_map(|open| &open.trials));
        let mut groups: BTreeMap<Vec<u64>, Vec<f64>> = BTreeMap::new();
        for record in records {
            if let Some(cost) = record.outcome.as_ref().and_then(Outcome::cost) {
                groups.entry(key(record)).or_default().push(cost);
            }
        }
        PureError::of_groups(groups.values().map(Vec::as_slice))
    }
}

/// Equal for equal settings; the two zeros are one.
fn key(record: &GlobalTrialRecord) -> Vec<u64> {
    record.settings().iter().map(|setting| (setting + 0.0).to_bits()).collect()
}
