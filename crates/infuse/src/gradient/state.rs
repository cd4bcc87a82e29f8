//! The state of a campaign in a file, and what is checked when it is read.

use serde::{Deserialize, Serialize};

use crate::gradient::ask_tell::OpenIteration;
use crate::gradient::{Loop, NumericalOptimum, Report, Settings, TrialRecord};
use crate::{CodesignProblem, Error};

const FORMAT: u32 = 1;

/// The fields of a saved campaign.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename = "Loop")]
pub(crate) struct State {
    format: u32,
    problem: CodesignProblem,
    settings: Settings,
    history: Vec<Report>,
    open: Option<OpenIteration>,
}

impl From<Loop> for State {
    fn from(campaign: Loop) -> Self {
        Self {
            format: FORMAT,
            problem: campaign.problem,
            settings: campaign.settings,
            history: campaign.history,
            open: campaign.open,
        }
    }
}

impl TryFrom<State> for Loop {
    type Error = Error;

    /// Replays the campaign: every closed iteration must follow from its optimum and the outcomes of
    /// its trials, number for number.
    fn try_from(state: State) -> Result<Self, Error> {
        if state.format != FORMAT {
            return Err(Error::StateFormat { found: state.format, supported: FORMAT });
        }
        let mut campaign = Self::new(state.problem, state.settings)?;
        for report in state.history {
            let iteration = campaign.reports().len() + 1;
            check_may_go_on(&campaign, iteration)?;
            check_numerical(&campaign, &report.numerical, iteration)?;
            let n_untold = check_trials(&campaign, &report.numerical, &report.trials, iteration)?;
            let replayed = Report::close(
                iteration,
                report.numerical.clone(),
                report.trials.clone(),
                &campaign.correction(),
                campaign.settings(),
            );
            if n_untold > 0 || replayed != report {
                return Err(Error::State {
                    field: "history",
                    iteration,
                    expected: "what follows from its optimum, the outcomes of all its trials and the settings",
                });
            }
            campaign.history.push(report);
        }
        if let Some(open) = state.open {
            let iteration = campaign.reports().len() + 1;
            check_may_go_on(&campaign, iteration)?;
            check_numerical(&campaign, &open.numerical, iteration)?;
            if check_trials(&campaign, &open.numerical, &open.trials, iteration)? == 0 {
                return Err(Error::State {
                    field: "open",
                    iteration,
                    expected: "at least one trial without an outcome",
                });
            }
            campaign.open = Some(open);
        }
        Ok(campaign)
    }
}

/// An iteration can follow only on a campaign that had not ended. The limit on iterations is left
/// out: it may be changed in the file.
fn check_may_go_on(campaign: &Loop, iteration: usize) -> Result<(), Error> {
    use crate::gradient::StopReason::{Converged, NoInformation};
    if matches!(campaign.stop(), Some(Converged | NoInformation)) {
        return Err(Error::State { field: "history", iteration, expected: "none after the campaign had ended" });
    }
    Ok(())
}

fn check_numerical(campaign: &Loop, numerical: &NumericalOptimum, iteration: usize) -> Result<(), Error> {
    let wrong = |field, expected| Error::State { field, iteration, expected };
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

/// Checks each trial against the design, and each outcome as if it were told now; how many are
/// untold.
fn check_trials(
    campaign: &Loop,
    numerical: &NumericalOptimum,
    trials: &[TrialRecord],
    iteration: usize,
) -> Result<usize, Error> {
    let optimum = &numerical.point;
    let mut design = campaign.design(optimum);
    if !design.iter().map(|record| &record.trial).eq(trials.iter().map(|record| &record.trial)) {
        return Err(Error::State {
            field: "trials",
            iteration,
            expected: "the trials that were handed out around its optimum",
        });
    }
    for (designed, record) in design.iter_mut().zip(trials) {
        match &record.outcome {
            Some(outcome) => designed.tell(record.actual, outcome.clone(), optimum)?,
            None if record.actual.is_some() => {
                return Err(Error::State {
                    field: "actual",
                    iteration,
                    expected: "nothing while the trial is outstanding",
                });
            }
            None => {}
        }
    }
    Ok(trials.iter().filter(|record| record.outcome.is_none()).count())
}

fn same(a: f64, b: f64) -> bool {
    a.to_bits() == b.to_bits()
}
