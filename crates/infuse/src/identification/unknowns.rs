//! The numbers of a model that are sought.

use design_space::Region;
use serde::{Deserialize, Serialize};

use crate::Error;

/// Numbers of a model that are sought: names, units and bounds as a region, and where each is believed to be.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, try_from = "Fields")]
pub struct Unknowns {
    region: Region,
    start: Vec<f64>,
}

/// As they stand in a file, before they are checked.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Fields {
    region: Region,
    start: Vec<f64>,
}

impl TryFrom<Fields> for Unknowns {
    type Error = Error;

    fn try_from(Fields { region, start }: Fields) -> Result<Self, Error> {
        Self::new(region, start)
    }
}

impl Unknowns {
    /// These unknowns, believed to be at `start`, in their own units. Levels of the region's parameters are not used.
    ///
    /// # Errors
    ///
    /// [`Error::DesignSpace`] for a start that is outside the bounds, not finite, or of another length; bounds that are
    /// upside down and names that stand twice are refused by the region.
    pub fn new(region: Region, start: Vec<f64>) -> Result<Self, Error> {
        region.check(&start)?;
        Ok(Self { region, start })
    }

    /// Names, units and bounds.
    #[must_use]
    pub fn region(&self) -> &Region {
        &self.region
    }

    /// Where each is believed to be.
    #[must_use]
    pub fn start(&self) -> &[f64] {
        &self.start
    }

    /// How many there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.start.len()
    }

    /// Never: a region has at least one parameter.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.start.is_empty()
    }

    /// The start in shares of the ranges.
    pub(super) fn start_shares(&self) -> Vec<f64> {
        let both = self.region.parameters().iter().zip(&self.start);
        both.map(|(parameter, value)| ((value - parameter.lower()) / parameter.width()).clamp(0.0, 1.0)).collect()
    }

    /// Values at shares of the ranges, within the bounds whatever the rounding.
    pub(super) fn values(&self, shares: &[f64]) -> Vec<f64> {
        let both = self.region.parameters().iter().zip(shares);
        both.map(|(parameter, share)| {
            let value = parameter.lower() + share * parameter.width();
            value.clamp(parameter.lower(), parameter.upper())
        })
        .collect()
    }
}
