#![doc = include_str!("../README.md")]

mod checks;
mod codesign;
pub mod convergence;
pub mod correction;
mod error;
#[cfg(feature = "global")]
pub mod global;
pub mod gradient;
#[cfg(feature = "global")]
pub mod pooled;
mod ledger;
mod problem;
#[cfg(feature = "global")]
mod traced;
mod trial;

pub use codesign::{CodesignReport, CodesignStop, FailedSimulation, OptimizerSettings, Strategy, codesign};
pub use error::Error;
pub use ledger::Record;
pub use problem::{CodesignProblem, Role};
pub use trial::{Outcome, TrialId};
