//! How much of an observed difference a batch believes.

use serde::{Deserialize, Serialize};

use crate::Error;

/// The gain k_n of batch n, dimensionless. In files `{ constant = 0.4 }` or `"harmonic"`.
///
/// ```
/// use infuse::correction::Gain;
///
/// assert!(Gain::constant(0.4).is_ok());
/// let error = Gain::constant(2.0).unwrap_err();
/// assert_eq!(error.to_string(), "setting `gain` is 2.0, expected 0 < k < 2");
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "UncheckedGain", into = "UncheckedGain")]
pub struct Gain(UncheckedGain);

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum UncheckedGain {
    Constant(f64),
    Harmonic,
}

impl Gain {
    /// The same k in every batch, 0 < k < 2; 0 < k ≤ 1 recommended.
    ///
    /// A fraction |1 − k| of the initial gap survives each batch. Beyond 1 the correction
    /// overshoots, and errors are amplified as [`Bound::limit`](crate::convergence::Bound::limit) says.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`].
    pub fn constant(k: f64) -> Result<Self, Error> {
        if k > 0.0 && k < 2.0 {
            Ok(Self(UncheckedGain::Constant(k)))
        } else {
            Err(Error::Setting { name: "gain", value: k, expected: "0 < k < 2" })
        }
    }

    /// k_n = 1/n: the correction is the mean of all observed differences, so the initial gap is
    /// gone after the first batch and independent errors average out.
    #[must_use]
    pub fn harmonic() -> Self {
        Self(UncheckedGain::Harmonic)
    }

    /// k if it is the same in every batch.
    #[must_use]
    pub fn as_constant(self) -> Option<f64> {
        match self.0 {
            UncheckedGain::Constant(k) => Some(k),
            UncheckedGain::Harmonic => None,
        }
    }

    /// k_n, with n from 1.
    pub(crate) fn at(self, n: usize) -> f64 {
        debug_assert!(n > 0, "batches count from 1");
        match self.0 {
            UncheckedGain::Constant(k) => k,
            UncheckedGain::Harmonic => 1.0 / n as f64,
        }
    }
}

impl TryFrom<UncheckedGain> for Gain {
    type Error = Error;

    fn try_from(unchecked: UncheckedGain) -> Result<Self, Error> {
        match unchecked {
            UncheckedGain::Constant(k) => Self::constant(k),
            UncheckedGain::Harmonic => Ok(Self::harmonic()),
        }
    }
}

impl From<Gain> for UncheckedGain {
    fn from(gain: Gain) -> Self {
        gain.0
    }
}
