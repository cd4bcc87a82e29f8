//! The loop of Chapter 3 and its Figure 3, in continuous parameters: optimize the corrected model, experiment around its
//! optimum, correct the slopes by (27), repeat.
//!
//! `turn` is one turn of the figure; [`Loop`] asks for its experiments and takes their outcomes.

mod ask_tell;
mod campaign;
mod numerical;
mod report;
mod settings;
mod slope;
mod state;
mod trial;
mod turn;

pub use ask_tell::Ask;
pub use campaign::Loop;
pub use numerical::NumericalOptimum;
pub use report::{Report, StopReason};
pub use settings::{BoundPolicy, Settings};
pub use trial::{Trial, TrialRecord, TrialRole};
