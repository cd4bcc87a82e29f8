//! The loop of Chapter 3 and its Figure 3: optimize the corrected model, ask for experiments around the optimum, correct
//! the slopes, repeat.

mod ask_tell;
mod numerical;
mod report;
mod settings;
mod slope;
mod state;
mod trial;

pub use ask_tell::{Ask, Loop};
pub use report::{NumericalOptimum, Report, StopReason};
pub use settings::{BoundPolicy, Settings};
pub use trial::{Trial, TrialRecord, TrialRole};
