#![doc = include_str!("../README.md")]

mod codesign;
mod correction;
mod error;
mod evaluator;
mod gradient;
mod gradient_loop;
mod numerical;
mod optimizer;
mod problem;
mod report;
mod search;
mod settings;
mod starts;
mod state;
mod trial;

pub use codesign::{CodesignReport, codesign};
pub use correction::{Correction, CorrectionForm};
pub use error::Error;
pub use evaluator::FailedSimulation;
pub use gradient_loop::{Ask, GradientLoop};
pub use optimizer::{CodesignStop, OptimizerSettings, Strategy};
pub use problem::{CodesignProblem, Role};
pub use report::{IterationReport, NumericalOptimum, StopReason};
pub use settings::{BoundPolicy, LoopSettings};
pub use trial::{Outcome, Trial, TrialId, TrialRecord, TrialRole};
