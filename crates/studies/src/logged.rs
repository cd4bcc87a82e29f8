//! A design flown sample by sample.

use water_channel::{CostBreakdown, Flight, FlightLog, LogRow};

/// Samples per row of the logs that pages show: 0.1 s.
pub(crate) const LOG_EVERY: usize = 4;

/// What is read off a row of a log.
pub(crate) type Reading = fn(&LogRow) -> f64;

/// A flight of a reported design, with its cost and its log.
#[derive(Clone, Debug)]
pub(crate) struct Logged {
    pub(crate) cost: CostBreakdown,
    pub(crate) flight: Flight,
    pub(crate) log: FlightLog,
}

impl Logged {
    pub(crate) fn times(&self) -> Vec<f64> {
        self.values(|row| row.time_s)
    }

    /// A reading, row by row.
    pub(crate) fn values(&self, reading: impl Fn(&LogRow) -> f64) -> Vec<f64> {
        self.log.rows.iter().map(reading).collect()
    }

    /// Its mean over the test.
    pub(crate) fn mean(&self, reading: impl Fn(&LogRow) -> f64) -> f64 {
        self.log.rows.iter().map(reading).sum::<f64>() / self.log.rows.len() as f64
    }
}
