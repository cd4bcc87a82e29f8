//! The number of an experiment, and what came of it.

use std::fmt;

use serde::{Deserialize, Serialize};

/// Number of a trial: from 1, increasing by one over the whole campaign.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct TrialId(u64);

impl TrialId {
    /// The id with this number, as a person reads it from a list of trials.
    #[must_use]
    pub fn new(number: u64) -> Self {
        Self(number)
    }

    /// The number.
    #[must_use]
    pub fn number(self) -> u64 {
        self.0
    }
}

impl fmt::Display for TrialId {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        self.0.fmt(formatter)
    }
}

/// What became of a trial.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// The cost that was measured, finite: what is to be made small, the response or its negative.
    Value(f64),
    /// None, and it shall not be tried again.
    Failed {
        /// Why, in the experimenter's own words.
        reason: String,
    },
}

impl Outcome {
    /// The cost, if there is one.
    #[must_use]
    pub fn cost(&self) -> Option<f64> {
        match self {
            Self::Value(cost) => Some(*cost),
            Self::Failed { .. } => None,
        }
    }
}

/// The largest magnitude of a response, that of a surface's data: what is larger was not measured.
pub(crate) const LARGEST: f64 = 1e100;
#[cfg(feature = "global")]
const _: () = assert!(LARGEST == surface::Data::LARGEST, "a response that is taken can be a datum");

/// An error is a failure, and so is a response that is not finite or beyond 1e100.
impl From<Result<f64, String>> for Outcome {
    fn from(result: Result<f64, String>) -> Self {
        match result {
            Ok(cost) if cost.abs() <= LARGEST => Self::Value(cost),
            Ok(cost) => Self::Failed { reason: format!("the experiment returned {cost}") },
            Err(reason) => Self::Failed { reason },
        }
    }
}
