//! Experiments that were made outside a campaign.

use design_space::Region;
use serde::{Deserialize, Serialize};

use crate::Error;
use crate::made::check_earlier;

/// An experiment that no batch asked for, see [`Loop::add_earlier`](crate::global::Loop::add_earlier).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EarlierExperiment {
    /// Its settings, natural; not necessarily on the grid.
    pub point: Vec<f64>,
    /// The response that it gave.
    pub cost: f64,
    /// Where it comes from, in the experimenter's own words.
    pub source: String,
    /// The first batch in which it counts.
    pub since: usize,
    /// The first batch in which it counts no longer; nothing if it was not withdrawn.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub until: Option<usize>,
}

impl EarlierExperiment {
    pub(crate) fn counts_in(&self, batch: usize) -> bool {
        self.since <= batch && self.until.is_none_or(|until| batch < until)
    }

    pub(crate) fn check(&self, region: &Region) -> Result<(), Error> {
        check_earlier(&self.point, region)?;
        if self.cost.abs() <= surface::Data::LARGEST {
            return Ok(());
        }
        let expected = "a response of an earlier experiment of at most 1e100 in magnitude";
        Err(Error::Setting { name: "cost", value: self.cost, expected })
    }
}
