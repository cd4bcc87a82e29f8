//! A campaign of the pooled loop in a file: all that it was told. What it thinks of that follows.

use std::collections::BTreeSet;

use design_space::{Cell, Region};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::checks::check_format;
use crate::pooled::campaign::{Earlier, Loop, Record, Trial};
use crate::pooled::reason::Reason;
use crate::pooled::settings::Settings;
use crate::pooled::simulated::Responses;
use crate::{Error, Outcome};

const FORMAT: u32 = 1;

/// The fields of a saved campaign.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename = "Loop")]
struct State {
    format: u32,
    region: Region,
    settings: Settings,
    trials: Vec<Saved>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    earlier: Vec<Earlier>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    simulated: Vec<Simulation>,
    /// Cells to simulate before the next batch.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    due: Vec<Cell>,
    /// Designs that nobody can build.
    #[serde(default, skip_serializing_if = "BTreeSet::is_empty")]
    refused: BTreeSet<Cell>,
}

/// A trial with all that is known of it.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Saved {
    trial: Trial,
    /// Settings that were made, where they are not those asked for; natural.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    actual: Option<Vec<f64>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    outcome: Option<Outcome>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    constrained: Vec<Option<f64>>,
    /// Why the loop asked for it; none where the experimenter wanted it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    reason: Option<Reason>,
}

/// What a simulation gave; no responses where it failed.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Simulation {
    cell: Cell,
    responses: Option<Responses>,
}

impl Serialize for Loop {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let saved = |Record { trial, actual, outcome }: &Record| Saved {
            trial: trial.clone(),
            actual: actual.clone(),
            outcome: outcome.clone(),
            constrained: self.constrained(trial.id).to_vec(),
            reason: self.reason(trial.id),
        };
        let simulated =
            self.simulated.all().map(|(cell, responses)| Simulation { cell, responses: responses.cloned() });
        let state = State {
            format: FORMAT,
            region: self.region().clone(),
            settings: self.settings.clone(),
            trials: self.records.iter().map(saved).collect(),
            earlier: self.earlier.clone(),
            simulated: simulated.collect(),
            due: self.due.clone(),
            refused: self.refused.clone(),
        };
        state.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Loop {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        told_anew(State::deserialize(deserializer)?).map_err(serde::de::Error::custom)
    }
}

/// The campaign that was told all this, if it can have been.
fn told_anew(state: State) -> Result<Loop, Error> {
    let State { format, region, settings, trials, earlier, simulated, due, refused } = state;
    check_format(format, FORMAT)?;
    let mut campaign = Loop::new(&region, settings)?;
    for batch in trials.chunk_by(|a, b| a.trial.batch == b.trial.batch) {
        hand_out_anew(&mut campaign, batch)?;
    }
    for Earlier { point, outcome, constrained, source } in earlier {
        match outcome {
            Outcome::Value(cost) => {
                campaign.add_earlier(&point, Responses { cost, constrained }, source)?;
            }
            Outcome::Failed { reason } => campaign.add_earlier_failure(&point, reason, source)?,
        }
    }
    for Simulation { cell, responses } in simulated {
        campaign.tell_simulation(cell, responses.ok_or_else(String::new))?;
    }
    for cell in refused {
        campaign.refuse(cell)?;
    }
    let is_due = |cell: &Cell| !campaign.simulated.contains(*cell) && campaign.grid().digits(*cell).is_ok();
    if !due.is_sorted_by(|a, b| a < b) || !due.iter().all(is_due) {
        let expected = "cells that were not simulated, ascending";
        return Err(Error::State { field: "due", turn: campaign.batch(), expected });
    }
    campaign.due = due;
    Ok(campaign)
}

/// Hands out one more batch, with its outcomes.
fn hand_out_anew(campaign: &mut Loop, batch: &[Saved]) -> Result<(), Error> {
    let cells: Vec<Cell> = batch.iter().map(|saved| saved.trial.cell).collect();
    let trials = campaign.hand_out(&cells)?;
    let turn = campaign.batch();
    if !trials.iter().eq(batch.iter().map(|saved| &saved.trial)) {
        let expected = "the numbers, the batch and the settings that follow from its cells";
        return Err(Error::State { field: "trials", turn, expected });
    }
    for Saved { trial, actual, outcome, constrained, reason } in batch {
        match (outcome.clone(), actual) {
            (Some(outcome), Some(actual)) => campaign.tell_at(trial.id, actual, outcome)?,
            (Some(outcome), None) => campaign.tell(trial.id, outcome)?,
            (None, None) => {}
            (None, Some(_)) => {
                return Err(Error::State { field: "trials.actual", turn, expected: "none before there is an outcome" });
            }
        }
        if !constrained.is_empty() {
            campaign.tell_constrained(trial.id, constrained)?;
        }
        campaign.reasons.extend(reason.map(|reason| (trial.id, reason)));
    }
    Ok(())
}
