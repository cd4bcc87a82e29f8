//! The noise of the experiments, from those that were repeated.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::Error;
use crate::checks::check_not_negative;

/// Scatter of experiments at equal settings about their mean, pooled over the campaign.
///
/// ```text
/// s² = Σ_settings Σ (J − J̄)² / Σ_settings (n − 1)
/// ```
///
/// It knows nothing of the model, so it is the noise alone: what a response surface misses by more is lack of fit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "UncheckedPureError")]
#[non_exhaustive]
pub struct PureError {
    /// s², in the squared unit of the response.
    pub variance: f64,
    /// Σ (n − 1), at least 1.
    pub degrees_of_freedom: usize,
}

/// Pure error as it stands in a file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename = "PureError")]
struct UncheckedPureError {
    variance: f64,
    degrees_of_freedom: usize,
}

impl TryFrom<UncheckedPureError> for PureError {
    type Error = Error;

    fn try_from(read: UncheckedPureError) -> Result<Self, Error> {
        let UncheckedPureError { variance, degrees_of_freedom } = read;
        check_not_negative("variance", variance)?;
        if degrees_of_freedom == 0 {
            let (name, expected) = ("degrees_of_freedom", "at least 1");
            return Err(Error::SettingCount { name, value: degrees_of_freedom, expected });
        }
        Ok(Self { variance, degrees_of_freedom })
    }
}

impl PureError {
    /// s, in the unit of the response.
    #[must_use]
    pub fn standard_deviation(&self) -> f64 {
        self.variance.sqrt()
    }

    /// Of responses with the settings at which they were read; none if no settings come twice. Equal is equal to the last bit,
    /// but for the sign of zero.
    #[must_use]
    pub fn of_readings(readings: impl IntoIterator<Item = (Vec<f64>, f64)>) -> Option<Self> {
        let mut groups: BTreeMap<Vec<u64>, Vec<f64>> = BTreeMap::new();
        for (settings, cost) in readings {
            let key = settings.iter().map(|setting| (setting + 0.0).to_bits()).collect();
            groups.entry(key).or_default().push(cost);
        }
        let (mut squares, mut degrees_of_freedom) = (0.0, 0);
        for costs in groups.values() {
            // From the first of them: equal ones differ by nothing, and not by what a mean is rounded.
            let from_first = || costs.iter().map(|cost| cost - costs[0]);
            let sum: f64 = from_first().sum();
            squares += (from_first().map(|d| d * d).sum::<f64>() - sum * sum / costs.len() as f64).max(0.0);
            degrees_of_freedom += costs.len() - 1;
        }
        (degrees_of_freedom > 0).then(|| Self { variance: squares / degrees_of_freedom as f64, degrees_of_freedom })
    }
}
