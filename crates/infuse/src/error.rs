//! What can be wrong with a problem, a setting, a reply or a saved state.

use crate::TrialId;
use crate::codesign::Strategy;

/// Every fault of this crate. A simulation or an experiment that fails is not among them: that is
/// data, and is reported.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// A point or a parameter that its region refuses.
    #[error(transparent)]
    DesignSpace(#[from] design_space::Error),
    /// A design that cannot be searched or evaluated.
    #[cfg(feature = "global")]
    #[error(transparent)]
    Design(#[from] doe::Error),
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
    /// Not one simulation of an optimization or of a batch gave a finite response.
    #[error("all {n_simulations} simulations failed, the first at {first_point:?}: {first_reason}")]
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
    /// An outcome to put right of a trial that has none yet.
    #[error("trial {id} has no outcome yet, expected one that has: tell it instead")]
    NothingToCorrect {
        /// The id given.
        id: TrialId,
    },
    /// A second reply to the same trial.
    #[error("trial {id} has an outcome already, and it stands")]
    SecondOutcome {
        /// The id given.
        id: TrialId,
    },
    /// A response that is NaN, infinite or beyond what can be squared. A trial without a usable response is reported as failed.
    #[error(
        "the outcome of trial {id} is {value:?}, expected a number of magnitude at most 1e100, or a failure with its reason"
    )]
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
    #[error("the saved state is not usable: `{field}` of turn {turn}, expected {expected}")]
    State {
        /// The field at fault.
        field: &'static str,
        /// The turn of the loop it belongs to, from 1.
        turn: usize,
        /// What is allowed.
        expected: &'static str,
    },
    /// A saved state that its own outcomes contradict.
    #[error(
        "the saved state does not follow from its outcomes and settings: `{field}` of turn {turn} is {saved}, \
         found {found}"
    )]
    StateDiffers {
        /// The field at fault.
        field: &'static str,
        /// The turn of the loop it belongs to, from 1.
        turn: usize,
        /// What the file says.
        saved: String,
        /// What follows from the outcomes.
        found: String,
    },
    /// A region from which every cell was dropped.
    #[error("the region has no cells, expected at least one")]
    EmptyRegion,
    /// A list with one entry too many or too few.
    #[error("`{name}` has {found} entries, expected {expected}: one per {per}")]
    WrongCount {
        /// Which list.
        name: &'static str,
        /// Number of entries given.
        found: usize,
        /// Number of entries expected.
        expected: usize,
        /// What an entry belongs to.
        per: &'static str,
    },
    /// An entry of a list that is out of range.
    #[error("`{name}` has {value:?} at index {index}, expected {expected}")]
    Entry {
        /// Which list.
        name: &'static str,
        /// Where, from 0.
        index: usize,
        /// The value given.
        value: f64,
        /// What is allowed.
        expected: &'static str,
    },
    /// The number of a cell that the region does not have.
    #[error("cell {cell_idx} does not exist, expected less than {n_cells}")]
    UnknownCell {
        /// The number given, from 0.
        cell_idx: usize,
        /// How many cells there are.
        n_cells: usize,
    },
    /// Data that a response surface refuses.
    #[cfg(feature = "global")]
    #[error(transparent)]
    Surface(#[from] surface::Error),
    /// A grid with more cells than the gridded loop can go through.
    #[error(
        "the grid has {n_cells} cells, and this loop goes through all of them: expected at most {most}, with fewer levels or \
         parameters; or the pooled loop, which goes through few"
    )]
    TooManyCells {
        /// Cells of the grid.
        n_cells: u64,
        /// The largest number allowed.
        most: u64,
    },
    /// Validation experiments that had entered the surface they were to validate.
    #[error(
        "the surface already rests on validation trials {}, expected one that has not seen them",
        trials.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
    )]
    ValidationLeak {
        /// The trials on both sides.
        trials: Vec<TrialId>,
    },
    /// Settings of an experiment that are too far outside the region.
    #[error("trial {id}: the actual setting of parameter `{parameter}` is {actual:?}, expected {expected}")]
    ActualSettingOf {
        /// The id given.
        id: TrialId,
        /// Name of the parameter.
        parameter: String,
        /// The setting given, in the parameter's unit.
        actual: f64,
        /// What is allowed.
        expected: &'static str,
    },
    /// So many simulations failed that the others do not determine their surface.
    #[cfg(feature = "global")]
    #[error("{n_failed} of {n_simulations} simulations failed, and the others determine no surface: {reason}")]
    TooFewSimulations {
        /// How many failed.
        n_failed: usize,
        /// How many were run.
        n_simulations: usize,
        /// Why the surface could not be fitted.
        reason: surface::Error,
    },
    /// Designs that the next batch of the dissertation's loop cannot be opened with.
    #[error("the plan of batch {batch} is not usable, expected {expected}")]
    Plan {
        /// The batch, from 1.
        batch: usize,
        /// What is allowed.
        expected: &'static str,
    },
    /// Settings of an earlier experiment that are too far outside the region.
    #[error("earlier experiment: parameter `{parameter}` is {value:?}, expected {expected}")]
    EarlierSetting {
        /// Name of the parameter.
        parameter: String,
        /// The setting given, in the parameter's unit.
        value: f64,
        /// What is allowed.
        expected: &'static str,
    },
    /// A surface that is a number at no retained cell.
    #[error("the {surface} surface of batch {batch} is a number at no retained cell")]
    NoMinimum {
        /// Which surface.
        surface: &'static str,
        /// The batch, from 1.
        batch: usize,
    },
    /// Names of measured responses that cannot be told apart.
    #[error("the measured response `{name}` is not usable, expected {expected}")]
    Responses {
        /// The name at fault.
        name: String,
        /// What is allowed.
        expected: &'static str,
    },
    /// A constraint that cannot be used.
    #[error("constraint `{constraint}`: `{field}` is {value}, expected {expected}")]
    Constraint {
        /// Its name, or number.
        constraint: String,
        /// The field at fault.
        field: &'static str,
        /// The value given.
        value: f64,
        /// What is allowed.
        expected: &'static str,
    },
    /// Two constraints that nobody can tell apart.
    #[error("constraint `{constraint}` is there {n_times} times, expected each name once")]
    SecondConstraint {
        /// The name.
        constraint: String,
        /// How many constraints have it.
        n_times: usize,
    },
    /// There is nothing left to ask for.
    #[error("all {n_refused} designs were refused, so that none is left to be run")]
    EveryDesignRefused {
        /// How many that are.
        n_refused: usize,
    },
    /// Constraints on the settings that no design keeps to.
    #[error(
        "no design was found that keeps to the linear constraints, {n_constraints} bounds in all; expected some that do"
    )]
    NoDesignAllowed {
        /// How many constraints there are.
        n_constraints: usize,
    },
    /// More constrained responses than there are constraints.
    #[error("{found} constrained responses, expected at most {most}: one per constraint")]
    TooManyConstrained {
        /// The number given.
        found: usize,
        /// How many constraints there are.
        most: usize,
    },
    /// A value of a constrained response that cannot be used.
    #[error("trial {id}: `{constraint}` is {value}, expected a number of at most 1e100 in magnitude")]
    ConstrainedValue {
        /// The trial.
        id: TrialId,
        /// The name of the constraint.
        constraint: String,
        /// The value given.
        value: f64,
    },
    /// Nothing to identify anything from.
    #[error(
        "there is no measurement (experiments that failed: {n_failed}), expected at least one experiment with readings"
    )]
    NoMeasurement {
        /// Experiments that had failed.
        n_failed: usize,
    },
    /// Noise that is to be estimated from readings that leave no degree of freedom.
    #[error(
        "{n_readings} readings of {n_unknowns} unknowns leave nothing to estimate the noise from, expected more readings, or \
         noise that is known"
    )]
    TooFewReadings {
        /// Readings of all experiments.
        n_readings: usize,
        /// Numbers that are sought.
        n_unknowns: usize,
    },
    /// A model without an answer where the search for unknowns begins.
    #[error(
        "the model fails at the start of the unknowns, {reason}; expected an answer at every design that was measured"
    )]
    FailsAtStart {
        /// Where and why, in the model's own words.
        reason: String,
    },
}
