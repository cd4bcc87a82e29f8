//! One loop of the controller: a proportional-derivative law behind a first-order filter.

use serde::{Deserialize, Serialize};

use crate::Error;
use crate::error::{check_finite, check_positive};

/// The gains of one loop, in continuous time.
///
/// ```text
/// G(s) = (k_d s + k_p) / (τ s + 1) = k_d/τ + (k_p − k_d/τ) / (τ s + 1)
/// ```
///
/// The unit of `proportional` is that of the output per unit of the error, that of `derivative` is the same times a second.
///
/// Source: (10), (11), (12).
///
/// ```
/// use tether_control::FilteredPd;
///
/// let pd = FilteredPd::new(2.0, 3.0, 0.5)?;
/// assert_eq!(pd.step_response(0.0), 6.0); // k_d / tau
/// assert!((pd.step_response(30.0) - 2.0).abs() < 1e-12); // k_p
/// # Ok::<(), tether_control::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "UncheckedPd", into = "UncheckedPd")]
pub struct FilteredPd {
    proportional: f64,
    derivative: f64,
    time_constant_s: f64,
}

impl FilteredPd {
    /// A loop with the gains k_p and k_d and the filter's time constant τ.
    ///
    /// The gains may have either sign; positive ones are stabilizing with the errors as the
    /// [`Controller`](crate::Controller) takes them.
    ///
    /// # Errors
    /// [`Error::NonFinite`] for a number that is not finite, also when k_d/τ overflows;
    /// [`Error::NotPositive`] for τ ≤ 0.
    pub fn new(proportional: f64, derivative: f64, time_constant_s: f64) -> Result<Self, Error> {
        check_finite("proportional", proportional)?;
        check_finite("derivative", derivative)?;
        check_positive("time_constant_s", time_constant_s)?;
        let initial_gain = derivative / time_constant_s;
        check_finite("derivative / time_constant_s", initial_gain)?;
        check_finite("proportional - derivative / time_constant_s", proportional - initial_gain)?;
        Ok(Self { proportional, derivative, time_constant_s })
    }

    /// k_p: the output for a unit error that has lasted long.
    #[must_use]
    pub fn proportional(&self) -> f64 {
        self.proportional
    }

    /// k_d: k_d/τ is the output for a unit error that has just come up.
    #[must_use]
    pub fn derivative(&self) -> f64 {
        self.derivative
    }

    /// τ, in seconds.
    #[must_use]
    pub fn time_constant_s(&self) -> f64 {
        self.time_constant_s
    }

    /// The output at a time in seconds after the error has stepped from 0 to 1, the filter at rest before.
    ///
    /// ```text
    /// y(t) = k_p + (k_d/τ − k_p) exp(−t/τ)
    /// ```
    ///
    /// 0 before the step.
    #[must_use]
    pub fn step_response(&self, time_s: f64) -> f64 {
        if time_s < 0.0 {
            return 0.0;
        }
        let initial = self.derivative / self.time_constant_s;
        let left = (-time_s / self.time_constant_s).exp();
        self.proportional + (initial - self.proportional) * left
    }

    /// The same loop for an error that is sampled and held.
    ///
    /// # Errors
    /// [`Error::NonFinite`] or [`Error::NotPositive`] for the sample time.
    pub fn sampled(&self, sample_time_s: f64) -> Result<SampledPd, Error> {
        check_positive("sample_time_s", sample_time_s)?;
        let initial_gain = self.derivative / self.time_constant_s;
        Ok(SampledPd {
            initial_gain,
            filtered_gain: self.proportional - initial_gain,
            // 1 − a without the cancellation when the sample time is a small part of τ.
            share_of_new: -(-sample_time_s / self.time_constant_s).exp_m1(),
        })
    }
}

/// A loop at one sample time, exact at the samples for an error held in between.
///
/// ```text
/// y_k     = (k_d/τ) e_k + (k_p − k_d/τ) s_k
/// s_{k+1} = a s_k + (1 − a) e_k,    a = exp(−T/τ),    s_0 = 0
/// ```
///
/// The split of G(s) is in [`FilteredPd`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampledPd {
    initial_gain: f64,
    filtered_gain: f64,
    share_of_new: f64,
}

impl SampledPd {
    /// The output y_k for the error e_k, after which the filter moves on by one sample.
    ///
    /// An error that is not finite makes this output and all later ones not finite.
    #[inline]
    pub fn output(&self, state: &mut PdState, error: f64) -> f64 {
        let output = self.initial_gain * error + self.filtered_gain * state.filtered_error;
        // a s + (1 − a) e, written so that a filter that has settled stays where it is.
        state.filtered_error += self.share_of_new * (error - state.filtered_error);
        output
    }
}

/// What one loop remembers from one sample to the next.
///
/// The default is the filter at rest; assigning it is the reset.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PdState {
    /// s_k: the error behind the first-order filter, in the unit of the error.
    pub filtered_error: f64,
}

/// The gains as a file holds them, before the constructor has seen them.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct UncheckedPd {
    proportional: f64,
    derivative: f64,
    time_constant_s: f64,
}

impl TryFrom<UncheckedPd> for FilteredPd {
    type Error = Error;

    fn try_from(read: UncheckedPd) -> Result<Self, Error> {
        Self::new(read.proportional, read.derivative, read.time_constant_s)
    }
}

impl From<FilteredPd> for UncheckedPd {
    fn from(pd: FilteredPd) -> Self {
        Self { proportional: pd.proportional, derivative: pd.derivative, time_constant_s: pd.time_constant_s }
    }
}
