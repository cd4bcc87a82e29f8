#![doc = include_str!("../README.md")]

mod codesign;
mod convergence;
mod correction;
mod error;
mod evaluator;
mod global;
mod global_loop;
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
pub use convergence::{
    Amplification, AssumptionReport, Bound, Coefficients, CorrectedField, CorrectionLaw, CorrectionRule, ErrorLevels,
    Gain, Growth, ModelStage, Norm, NormOrder, NormScaling, RegretCertificate, coded_cell_measure, possible_optima,
};
pub use correction::{Correction, CorrectionForm};
pub use error::Error;
pub use evaluator::FailedSimulation;
pub use global::batch::{Batch, DroppedTerm};
pub use global::changes::SurfaceChanges;
pub use global::earlier::EarlierExperiment;
pub use global::observations::Observations;
pub use global::outlook::{ObservedErrors, Outlook};
pub use global::plan::GlobalPlan;
pub use global::pure_error::PureError;
pub use global::report::{GlobalReport, GlobalStopReason, SimulationRecord};
pub use global::retained::RetainedSet;
pub use global::screening::{Dropped, Screening, Spread, SpreadFault, quality_of_fit};
pub use global::settings::{GlobalSettings, SpreadFallback, SurfaceKind, SurfaceKinds};
pub use global::surfaces::IterationSurfaces;
pub use global::traced::TracedSurface;
pub use global::trial::{GlobalTrial, GlobalTrialRecord, TrialUse};
pub use global_loop::{GlobalAsk, GlobalLoop};
pub use gradient_loop::{Ask, GradientLoop};
pub use optimizer::{CodesignStop, OptimizerSettings, Strategy};
pub use problem::{CodesignProblem, Role};
pub use report::{IterationReport, NumericalOptimum, StopReason};
pub use settings::{BoundPolicy, LoopSettings};
pub use trial::{Outcome, Trial, TrialId, TrialRecord, TrialRole};
