//! What can be wrong with a problem, a setting, a reply or a saved state.

use crate::{Strategy, TrialId};

/// Every fault of this crate. A simulation or an experiment that fails is not among them: that is
/// data, and is reported.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// A point or a parameter that its region refuses.
    #[error(transparent)]
    Region(#[from] doe::Error),
    /// A list that should have one entry per parameter.
    #[error("`{name}` has {found} entries, expected {expected}: one per parameter")]
    WrongLength {
        /// Which list.
        name: &'static str,
        /// Number of parameters.
        expected: usize,
        /// Number of entries given.
        found: usize,
    },
    /// A strategy that tells plant and controller apart, and a problem that lacks one of them.
    #[error(
        "the {strategy} strategy needs plant and controller parameters, found {n_plant} and {n_controller}: \
         use the simultaneous strategy"
    )]
    NeedsPlantAndController {
        /// The strategy asked for.
        strategy: Strategy,
        /// Number of plant parameters.
        n_plant: usize,
        /// Number of controller parameters.
        n_controller: usize,
    },
    /// A number of the settings that is out of range.
    #[error("setting `{name}` is {value:?}, expected {expected}")]
    Setting {
        /// Name of the field.
        name: &'static str,
        /// The value given.
        value: f64,
        /// What is allowed.
        expected: &'static str,
    },
    /// A count of the settings that is out of range.
    #[error("setting `{name}` is {value}, expected {expected}")]
    SettingCount {
        /// Name of the field.
        name: &'static str,
        /// The value given.
        value: usize,
        /// What is allowed.
        expected: &'static str,
    },
    /// A number of the settings that belongs to one parameter and is out of range.
    #[error("setting `{name}` of parameter `{parameter}` is {value:?}, expected {expected}")]
    ParameterSetting {
        /// Name of the field.
        name: &'static str,
        /// Name of the parameter.
        parameter: String,
        /// The value given.
        value: f64,
        /// What is allowed.
        expected: &'static str,
    },
    /// Not one simulation of an optimization gave a finite cost.
    #[error("all {n_simulations} simulations of the optimization failed, the first at {first_point:?}: {first_reason}")]
    EverySimulationFailed {
        /// How many were tried.
        n_simulations: usize,
        /// The first point tried, natural.
        first_point: Vec<f64>,
        /// Why it failed.
        first_reason: String,
    },
    /// The optimizer could not be set up for this many parameters.
    #[error("the optimizer cannot be set up for {n_parameters} parameters with these settings")]
    OptimizerRefused {
        /// Number of parameters of the search.
        n_parameters: usize,
    },
    /// A reply to a trial that was never handed out.
    #[error("trial {id} was never handed out, expected one of the outstanding trials")]
    UnknownTrial {
        /// The id given.
        id: TrialId,
    },
    /// A second reply to the same trial.
    #[error("trial {id} has been told already; its first outcome stands")]
    AlreadyTold {
        /// The id given.
        id: TrialId,
    },
    /// A cost that is NaN or infinite. A trial without a usable cost is told as failed.
    #[error("trial {id} was told the value {value:?}, expected a finite cost, or a failure with its reason")]
    NonFiniteOutcome {
        /// The id given.
        id: TrialId,
        /// The value given.
        value: f64,
    },
    /// An actual setting that cannot be that of this trial.
    #[error("trial {id}: the actual setting is {actual:?}, expected {expected}")]
    ActualSetting {
        /// The id given.
        id: TrialId,
        /// The setting given, in the parameter's unit.
        actual: f64,
        /// What is allowed.
        expected: &'static str,
    },
    /// A saved state of another format.
    #[error("the saved state has format {found}, expected {supported}")]
    StateFormat {
        /// The format number found.
        found: u32,
        /// The one this version reads and writes.
        supported: u32,
    },
    /// A saved state with a number that no campaign can have produced.
    #[error("the saved state is not usable: `{field}` of iteration {iteration}, expected {expected}")]
    State {
        /// The field at fault.
        field: &'static str,
        /// The iteration it belongs to, from 1.
        iteration: usize,
        /// What is allowed.
        expected: &'static str,
    },
}
