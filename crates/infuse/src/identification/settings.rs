//! What a person decides before a fit.

use serde::{Deserialize, Serialize};

use crate::Error;

/// What is known of the noise of the readings.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Noise {
    /// Standard deviations are those of the readings: σ = 1, intervals by the normal distribution.
    #[default]
    Known,
    /// Standard deviations are right up to one factor, which the residuals tell: σ² is their sum of squares over the
    /// degrees of freedom, intervals by Student's t.
    Estimated,
}

/// The settings of a fit.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// What is known of the noise. Default: its standard deviations.
    pub noise: Noise,
    /// Largest standard error of a direction that counts as determined, as a share of the range, 0 < e ≤ 1. Default 1/√12: that of a
    /// number of which no more is known than its range.
    pub largest_error: f64,
    /// Step of the differences, as a share of the range, 1e-9 to 0.1. Default 1e-5: for models that are smooth to 1e-10.
    pub difference_step: f64,
    /// The search ends when a step leaves more than 1 − `tolerance` of the sum of squares, 0 < tolerance < 1. Default 1e-10.
    pub tolerance: f64,
    /// Limit on the steps of a search. Default 100.
    pub max_steps: usize,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            noise: Noise::default(),
            largest_error: 1.0 / 12.0_f64.sqrt(),
            difference_step: 1e-5,
            tolerance: 1e-10,
            max_steps: 100,
        }
    }
}

impl Settings {
    /// Whether every number is usable.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`], [`Error::SettingCount`].
    pub fn validate(&self) -> Result<(), Error> {
        let check = |name, value: f64, is_usable: bool, expected| {
            if is_usable { Ok(()) } else { Err(Error::Setting { name, value, expected }) }
        };
        let Self { largest_error, difference_step, tolerance, max_steps, .. } = *self;
        check("largest_error", largest_error, largest_error > 0.0 && largest_error <= 1.0, "0 < e ≤ 1")?;
        check("difference_step", difference_step, (1e-9..=0.1).contains(&difference_step), "1e-9 to 0.1")?;
        check("tolerance", tolerance, tolerance > 0.0 && tolerance < 1.0, "0 < tolerance < 1")?;
        if max_steps == 0 {
            return Err(Error::SettingCount { name: "max_steps", value: 0, expected: "at least 1" });
        }
        Ok(())
    }
}
