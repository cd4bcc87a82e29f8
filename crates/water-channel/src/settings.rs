//! How a flight is computed, and what a slack line means for it.

use serde::{Deserialize, Serialize};

use crate::error::Error;

/// What a negative tension means.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SlackPolicy {
    /// The flight fails: the model does not hold with a slack line.
    #[default]
    Fail,
    /// The flight goes on and the first slack line is reported.
    Warn,
}

/// How a flight is computed.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FlightSettings {
    /// RK4 steps per sample: over the plants of the studies 2 keep the cost to about 6e-6, 1 to about 2e-5.
    pub steps_per_sample: usize,
    /// What a slack line means.
    pub slack: SlackPolicy,
}

impl Default for FlightSettings {
    fn default() -> Self {
        Self { steps_per_sample: 2, slack: SlackPolicy::Fail }
    }
}

impl FlightSettings {
    /// The default with `steps_per_sample` RK4 steps per sample.
    #[must_use]
    pub fn with_steps(steps_per_sample: usize) -> Self {
        Self { steps_per_sample, ..Self::default() }
    }

    /// # Errors
    /// [`Error::Argument`] for no step or more than 1000 steps per sample.
    pub fn validate(&self) -> Result<(), Error> {
        if (1..=1000).contains(&self.steps_per_sample) {
            return Ok(());
        }
        Err(Error::Argument {
            name: "steps per sample",
            value: self.steps_per_sample as f64,
            expected: "a whole number from 1 to 1000",
        })
    }
}
