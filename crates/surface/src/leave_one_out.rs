//! How well a surface predicts points that it has not seen.

use serde::{Deserialize, Serialize};

use crate::{Data, Error};

/// Leave-one-out residuals: each value minus the estimate at its point by the surface fitted to the other points.
///
/// A point of weight zero was never part of the fit; its residual is that of the whole surface, and counts nothing.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "UncheckedResiduals")]
pub struct LeaveOneOut {
    residuals: Vec<f64>,
    weights: Vec<f64>,
}

/// Residuals as they stand in a file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename = "LeaveOneOut")]
struct UncheckedResiduals {
    residuals: Vec<f64>,
    weights: Vec<f64>,
}

impl TryFrom<UncheckedResiduals> for LeaveOneOut {
    type Error = Error;

    fn try_from(UncheckedResiduals { residuals, weights }: UncheckedResiduals) -> Result<Self, Error> {
        let (expected, found) = (residuals.len(), weights.len());
        if found != expected {
            return Err(Error::Length { name: "weights", expected, found });
        }
        Ok(Self { residuals, weights })
    }
}

impl LeaveOneOut {
    pub(crate) fn new(residuals: Vec<f64>, weights: Vec<f64>) -> Self {
        Self { residuals, weights }
    }

    /// For a surface that is fitted by storing its data: `estimate(point, left_out)`.
    pub(crate) fn of_averages(data: &Data, estimate: impl Fn(&[f64], Option<usize>) -> f64) -> Result<Self, Error> {
        if data.n_used() < 2 {
            return Err(Error::TooFewSites { found: data.n_used(), least: 2, what: "leave one out" });
        }
        let numbers = data.points().zip(data.values()).enumerate();
        let residuals = numbers.map(|(index, (point, value))| value - estimate(point, Some(index))).collect();
        Ok(Self::new(residuals, data.weights().to_vec()))
    }

    /// One residual per point of the data, in order.
    #[must_use]
    pub fn residuals(&self) -> &[f64] {
        &self.residuals
    }

    /// The predicted residual sum of squares, Σ w e².
    #[must_use]
    pub fn press(&self) -> f64 {
        self.residuals.iter().zip(&self.weights).map(|(e, w)| w * e * e).sum()
    }

    /// Weighted root mean square, √(Σ w e² / Σ w): the error to expect at a point that was not measured.
    #[must_use]
    pub fn rms(&self) -> f64 {
        (self.press() / self.weights.iter().sum::<f64>()).sqrt()
    }
}
