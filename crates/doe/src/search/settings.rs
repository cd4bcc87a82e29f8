//! How long and from where to search.

use std::time::Duration;

use crate::Error;

/// Settings of a search.
///
/// ```
/// let mut settings = doe::Settings::default();
/// settings.seed = 7;
/// settings.starts = 100;
/// settings.time_limit = Some(std::time::Duration::from_secs(5));
/// ```
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Everything random follows from this: the same seed and number of starts give the same design, whatever the
    /// number of threads.
    pub seed: u64,
    /// The largest number of starts.
    pub starts: u64,
    /// No further start begins after this time, which must not be 0, and what is on its way is cut; only a first design
    /// is waited for, if only as far as it determines the model: it may be a bad one, and [`Report::starts`](crate::Report::starts) is 0.
    /// Then the efficiency of the design is computed, which no limit cuts: for twelve factors a fraction of a second. How many starts that allows depends on the machine: the
    /// [`Report`](crate::Report) says how many there were and whether the same number without a limit repeats the search.
    pub time_limit: Option<Duration>,
    /// Stop as soon as the efficiency reaches this many per cent.
    pub target_percent: Option<f64>,
    /// How far each start is taken.
    pub effort: Effort,
}

/// How far each start is taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Effort {
    /// To within about 0.1 % of its best: for many starts in little time.
    Quick,
    /// To the last digits.
    #[default]
    Thorough,
}

impl Default for Settings {
    /// Seed 1, 200 starts, no other limit, thorough.
    fn default() -> Self {
        Self { seed: 1, starts: 200, time_limit: None, target_percent: None, effort: Effort::Thorough }
    }
}

impl Settings {
    /// Nothing if a search can use these settings.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] for no starts, no time, or a target that is not above 0.
    pub fn validate(&self) -> Result<(), Error> {
        if self.starts == 0 {
            return Err(Error::Setting { name: "starts", value: 0.0, expected: "at least 1" });
        }
        if self.time_limit.is_some_and(|limit| limit.is_zero()) {
            return Err(Error::Setting { name: "time_limit", value: 0.0, expected: "above 0" });
        }
        match self.target_percent {
            Some(value) if value.is_nan() || value <= 0.0 => {
                Err(Error::Setting { name: "target_percent", value, expected: "above 0" })
            }
            _ => Ok(()),
        }
    }
}
