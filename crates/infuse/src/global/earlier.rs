//! Experiments that were made outside a campaign.

use doe::Region;
use serde::{Deserialize, Serialize};

use crate::Error;
use crate::global::trial::{NEAR_THE_REGION, far_setting};

/// An experiment that no iteration asked for, see [`GlobalLoop::add_earlier`](crate::GlobalLoop::add_earlier).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EarlierExperiment {
    /// Its settings, natural; not necessarily on the grid.
    pub point: Vec<f64>,
    /// What it cost.
    pub cost: f64,
    /// Where it comes from, in the experimenter's own words.
    pub source: String,
    /// The first iteration in which it counts.
    pub since: usize,
}

impl EarlierExperiment {
    pub(crate) fn check(&self, region: &Region) -> Result<(), Error> {
        if let Some((parameter, value)) = far_setting(&self.point, region)? {
            return Err(Error::EarlierSetting { parameter, value, expected: NEAR_THE_REGION });
        }
        if self.cost.is_finite() {
            return Ok(());
        }
        Err(Error::Setting { name: "cost", value: self.cost, expected: "a finite cost of an earlier experiment" })
    }
}
