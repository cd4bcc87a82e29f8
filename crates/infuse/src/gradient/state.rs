//! The state of a campaign in a file, and what is checked when it is read.

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::checks::check_format;
use crate::gradient::campaign::{Loop, OpenIteration};
use crate::gradient::numerical::NumericalOptimum;
use crate::gradient::report::{Report, StopReason};
use crate::gradient::settings::Settings;
use crate::gradient::trial::{Trials, check_actual};
use crate::{CodesignProblem, Error};

const FORMAT: u32 = 1;

/// The fields of a saved campaign.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename = "Loop")]
struct State {
    format: u32,
    problem: CodesignProblem,
    settings: Settings,
    history: Vec<Report>,
    open: Option<OpenIteration>,
}

impl Serialize for Loop {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self { problem, settings, history, open } = self.clone();
        State { format: FORMAT, problem, settings, history, open }.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Loop {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        replayed(State::deserialize(deserializer)?).map_err(serde::de::Error::custom)
    }
}

/// Replays the campaign: every closed iteration must follow from its optimum and the outcomes of its trials, number for
/// number.
fn replayed(state: State) -> Result<Loop, Error> {
    check_format(state.format, FORMAT)?;
    let mut campaign = Loop::new(state.problem, state.settings)?;
    for report in state.history {
        let iteration = campaign.iteration();
        let saved =
            OpenIteration { numerical: report.numerical.clone(), trials: Trials::of_records(report.trials.clone()) };
        let open = checked(&campaign, saved)?;
        if !open.trials.is_complete() || campaign.finish(open) != report {
            let expected = "what follows from its optimum, the outcomes of all its trials and the settings";
            return Err(Error::State { field: "history", turn: iteration, expected });
        }
        campaign.history.push(report);
    }
    if let Some(saved) = state.open {
        let iteration = campaign.iteration();
        let open = checked(&campaign, saved)?;
        if open.trials.is_complete() {
            let expected = "at least one trial without an outcome";
            return Err(Error::State { field: "open", turn: iteration, expected });
        }
        campaign.open = Some(open);
    }
    Ok(campaign)
}

/// A saved iteration, if it can be the next of this campaign: its optimum, its trials, and their outcomes as if each
/// came in now.
pub(super) fn checked(campaign: &Loop, saved: OpenIteration) -> Result<OpenIteration, Error> {
    let iteration = campaign.iteration();
    check_may_go_on(campaign, iteration)?;
    check_numerical(campaign, &saved.numerical, iteration)?;
    let optimum = &saved.numerical.point;
    let handed_out = campaign.experiments_around(optimum);
    if !handed_out.trials().eq(saved.trials.trials()) {
        let expected = "the trials that were handed out around its optimum";
        return Err(Error::State { field: "trials", turn: iteration, expected });
    }
    let check = |trial: &_, actual: &f64| check_actual(trial, *actual, optimum, campaign.problem.region());
    let trials = handed_out.with_outcomes_of(&saved.trials, iteration, check)?;
    Ok(OpenIteration { numerical: saved.numerical, trials })
}

/// An iteration can follow only on a campaign that had not ended. The limit on iterations is left
/// out: it may be changed in the file.
fn check_may_go_on(campaign: &Loop, iteration: usize) -> Result<(), Error> {
    if matches!(campaign.stop(), Some(StopReason::Converged | StopReason::NoInformation)) {
        return Err(Error::State { field: "history", turn: iteration, expected: "none after the campaign had ended" });
    }
    Ok(())
}

fn check_numerical(campaign: &Loop, numerical: &NumericalOptimum, iteration: usize) -> Result<(), Error> {
    let wrong = |field, expected| Error::State { field, turn: iteration, expected };
    let n_parameters = campaign.problem().n_parameters();
    campaign.problem().region().check(&numerical.point)?;
    if numerical.model_gradient.len() != n_parameters {
        return Err(wrong("model_gradient", "one entry per parameter"));
    }
    let gradient = numerical.model_gradient.iter().flatten();
    if !gradient.copied().all(f64::is_finite) {
        return Err(wrong("model_gradient", "finite numbers"));
    }
    for failure in &numerical.failures {
        let is_point = failure.point.iter().all(|value| value.is_finite());
        if failure.point.len() != n_parameters || !is_point {
            return Err(wrong("failures", "points with one finite number per parameter"));
        }
    }
    let correction_value = campaign.correction().value_at(&numerical.point);
    let corrected_cost = numerical.model_cost + correction_value;
    let is_sum = same(numerical.correction_value, correction_value) && same(numerical.corrected_cost, corrected_cost);
    if !is_sum || !corrected_cost.is_finite() {
        return Err(wrong("numerical", "finite costs, the correction that was known and its sum with the model cost"));
    }
    Ok(())
}

fn same(a: f64, b: f64) -> bool {
    a.to_bits() == b.to_bits()
}
