#![doc = include_str!("../README.md")]

mod checks;
pub mod codesign;
pub mod convergence;
pub mod correction;
mod error;
#[cfg(feature = "global")]
pub mod global;
pub mod gradient;
#[cfg(feature = "identification")]
pub mod identification;
mod ledger;
#[cfg(feature = "global")]
pub mod pooled;
mod problem;
#[cfg(feature = "global")]
mod pure_error;
#[cfg(feature = "global")]
mod traced;
mod trial;

pub use error::Error;
pub use ledger::Record;
pub use problem::{CodesignProblem, Role};
pub use trial::{Outcome, TrialId};
