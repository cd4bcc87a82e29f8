//! Plant and controller optimized on a model: nested, simultaneous, sequential, iterative.

pub(crate) mod evaluator;
mod optimizer;
pub(crate) mod run;
mod search;
mod starts;
mod strategy;

pub use evaluator::FailedSimulation;
pub use optimizer::{CodesignStop, OptimizerSettings};
pub use run::{CodesignReport, codesign};
pub use strategy::Strategy;
