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
mod made;
#[cfg(feature = "global")]
pub mod pooled;
mod problem;
#[cfg(feature = "global")]
mod pure_error;
#[cfg(feature = "global")]
mod traced;
mod trial;

/// What regions and models are made of, from the crate `design-space`, for those who need no more of it.
#[doc(no_inline)]
pub use design_space::Error as DesignSpaceError;
#[doc(no_inline)]
pub use design_space::{Cell, Grid, Levels, Model, Parameter, Region, Term};
pub use error::Error;
pub use ledger::Record;
pub use problem::{CodesignProblem, Role};
pub use trial::{Outcome, TrialId};
