//! The state of a campaign on a model with unknowns in a file, and what is checked when it is read.

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::checks::check_format;
use crate::correction::Local;
use crate::gradient::campaign::{Loop, OpenIteration};
use crate::gradient::identifying::{IdentifyingLoop, Mechanism, Now, Turn};
use crate::gradient::settings::Settings;
use crate::gradient::state::checked;
use crate::gradient::trial::Trials;
use crate::identification::{self, Identification, Measurements, Unknowns};
use crate::{CodesignProblem, Error};

const FORMAT: u32 = 1;

/// The fields of a saved campaign.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename = "IdentifyingLoop")]
struct State {
    format: u32,
    problem: CodesignProblem,
    settings: Settings,
    mechanism: Mechanism,
    unknowns: Unknowns,
    fit: identification::Settings,
    measurements: Measurements,
    turns: Vec<Turn>,
    /// After each turn, with the slopes of the model as it is now.
    corrections: Vec<Local>,
    now: Now,
    open: Option<OpenIteration>,
}

impl Serialize for IdentifyingLoop {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self { inner, mechanism, unknowns, fit, measurements, now, turns } = self.clone();
        let Loop { problem, settings, history, open } = inner;
        let corrections = history.into_iter().map(|report| report.correction).collect();
        let format = FORMAT;
        State { format, problem, settings, mechanism, unknowns, fit, measurements, turns, corrections, now, open }
            .serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for IdentifyingLoop {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        replayed(State::deserialize(deserializer)?).map_err(serde::de::Error::custom)
    }
}

/// Replays the campaign: every turn must follow from its optimum, what it carried and the outcomes of its trials, number for
/// number. What the model said, fits and slopes, is taken as it stands: the model is not here.
fn replayed(state: State) -> Result<IdentifyingLoop, Error> {
    check_format(state.format, FORMAT)?;
    let mut campaign = begun(&state)?;
    for turn in &state.turns {
        check_model(&campaign, &turn.unknowns, turn.identification.as_ref(), &turn.carried)?;
        let numerical = turn.report.numerical.clone();
        let saved = OpenIteration { numerical, trials: Trials::of_records(turn.report.trials.clone()) };
        let open = reopened(&mut campaign, &turn.carried, saved)?;
        if !open.trials.is_complete() || campaign.inner.finish(open) != turn.report {
            let expected = "what follows from its optimum, the outcomes of all its trials and the settings";
            return Err(wrong(&campaign, "turns", expected));
        }
        campaign.inner.history.push(turn.report.clone());
        campaign.turns.push(turn.clone());
    }
    check_model(&campaign, &state.now.unknowns, state.now.identification.as_ref(), &state.now.carried)?;
    if let Some(saved) = state.open {
        let open = reopened(&mut campaign, &state.now.carried, saved)?;
        if open.trials.is_complete() {
            return Err(wrong(&campaign, "open", "at least one trial without an outcome"));
        }
        campaign.inner.open = Some(open);
    }
    learn(&mut campaign, state.corrections, &state.now.carried)?;
    check_measurements(&campaign, &state.measurements)?;
    Ok(IdentifyingLoop { measurements: state.measurements, now: state.now, ..campaign })
}

fn wrong(campaign: &IdentifyingLoop, field: &'static str, expected: &'static str) -> Error {
    Error::State { field, turn: campaign.inner.iteration(), expected }
}

/// The same campaign before its first turn.
fn begun(state: &State) -> Result<IdentifyingLoop, Error> {
    let State { problem, mechanism, unknowns, fit, measurements, .. } = state;
    let mut settings = state.settings.clone();
    if *mechanism == Mechanism::Identification {
        if settings.trust.iter().any(|trust| *trust != 0.0) {
            let expected = "zeros, where nothing is corrected";
            return Err(Error::State { field: "trust", turn: 1, expected });
        }
        settings.trust.fill(1.0);
    }
    let responses = measurements.responses().to_vec();
    IdentifyingLoop::new(problem.clone(), settings, *mechanism, unknowns.clone(), responses, *fit)
}

/// Whether a turn can have been made on this model: unknowns that its fit found, or those believed at first, and a correction.
fn check_model(
    campaign: &IdentifyingLoop,
    unknowns: &[f64],
    found: Option<&Identification>,
    carried: &Local,
) -> Result<(), Error> {
    campaign.unknowns.region().check(unknowns)?;
    let believed = found.map_or_else(|| campaign.unknowns.start().to_vec(), Identification::values);
    if believed != unknowns || (found.is_some() && !campaign.mechanism.identifies()) {
        return Err(wrong(campaign, "unknowns", "those that its identification found, or the start without one"));
    }
    if !is_usable(campaign, carried) {
        return Err(wrong(campaign, "carried", "a finite slope for each parameter and a finite offset"));
    }
    Ok(())
}

fn is_usable(campaign: &IdentifyingLoop, correction: &Local) -> bool {
    let is_finite = correction.offset().is_finite() && correction.slope().iter().all(|slope| slope.is_finite());
    is_finite && correction.slope().len() == campaign.inner.problem.n_parameters()
}

/// A saved iteration, if it can be the next of this campaign with that correction.
fn reopened(campaign: &mut IdentifyingLoop, carried: &Local, saved: OpenIteration) -> Result<OpenIteration, Error> {
    if !campaign.mechanism.identifies() && *carried != campaign.inner.correction() {
        return Err(wrong(campaign, "carried", "the correction after the turn before"));
    }
    match campaign.inner.history.last_mut() {
        Some(last) => last.correction = carried.clone(),
        None => {
            if *carried != campaign.inner.correction() {
                return Err(wrong(campaign, "carried", "nothing in the first turn"));
            }
        }
    }
    checked(&campaign.inner, saved)
}

/// Puts the corrections in that were learned anew since.
fn learn(campaign: &mut IdentifyingLoop, corrections: Vec<Local>, carried: &Local) -> Result<(), Error> {
    let is_each = corrections.len() == campaign.turns.len();
    if !is_each || corrections.iter().any(|correction| !is_usable(campaign, correction)) {
        return Err(wrong(campaign, "corrections", "one for each turn, of finite numbers"));
    }
    if campaign.inner.open.is_some() && corrections.last().is_some_and(|last| last != carried) {
        return Err(wrong(campaign, "corrections", "the last one with which the open turn began"));
    }
    for (report, correction) in campaign.inner.history.iter_mut().zip(corrections) {
        report.correction = correction;
    }
    Ok(())
}

/// Every outcome was measured once, where its trial was.
fn check_measurements(campaign: &IdentifyingLoop, measurements: &Measurements) -> Result<(), Error> {
    let closed = campaign.turns.iter().flat_map(|turn| turn.report.trials.iter().map(|record| &record.trial));
    let outstanding = campaign.inner.outstanding();
    let is_told = |trial: &&_| !outstanding.contains(trial);
    let open = campaign.inner.open.iter().flat_map(|open| open.trials.trials()).filter(is_told);
    let mut points: Vec<&[f64]> = closed.chain(open).map(|trial| trial.point.as_slice()).collect();
    let n_told = points.len();
    let is_of_a_trial = measurements.designs().all(|design| {
        let at = points.iter().position(|point| *point == design);
        at.map(|at| points.swap_remove(at)).is_some()
    });
    if !is_of_a_trial || measurements.n_experiments() + measurements.n_failed() != n_told {
        return Err(wrong(campaign, "measurements", "the readings of all trials that were told, or that they failed"));
    }
    Ok(())
}
