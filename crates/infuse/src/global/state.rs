//! The state of a campaign in a file, and what is checked when it is read.

use std::collections::BTreeSet;

use design_space::{Cell, Region};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::Error;
use crate::Outcome;
use crate::checks::check_format;
use crate::global::agreement::Agreement;
use crate::global::batch::DesignSpace;
use crate::global::campaign::Loop;
use crate::global::earlier::EarlierExperiment;
use crate::global::open_batch::{OpenBatch, trials};
use crate::global::report::{Report, SimulationRecord};
use crate::global::settings::Settings;
use crate::global::trial::{Trial, TrialRecord, TrialUse, Trials};
use crate::made::check_actual;

const FORMAT: u32 = 1;

/// The fields of a saved campaign.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename = "Loop")]
struct State {
    format: u32,
    region: Region,
    settings: Settings,
    history: Vec<Report>,
    open: Option<OpenBatch>,
    #[serde(default)]
    failed_cells: BTreeSet<Cell>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    earlier: Vec<EarlierExperiment>,
}

impl Serialize for Loop {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let state = State {
            format: FORMAT,
            region: self.region().clone(),
            settings: self.settings.clone(),
            history: self.history.clone(),
            open: self.open.clone(),
            failed_cells: self.failed_cells.clone(),
            earlier: self.earlier.clone(),
        };
        state.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Loop {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        replayed(State::deserialize(deserializer)?).map_err(serde::de::Error::custom)
    }
}

/// Replays the campaign: everything but the outcomes and the choice of the cells is computed anew and must agree, what
/// was chosen exactly, what was computed to [rounding](Agreement). The numbers found are those that stay. The
/// designs are checked to be designs over what was left, and are not searched for again.
fn replayed(state: State) -> Result<Loop, Error> {
    check_format(state.format, FORMAT)?;
    let mut campaign = Loop::new(&state.region, state.settings)?;
    campaign.earlier = checked_earlier(state.earlier, &state.region, state.history.len() + 1)?;
    for report in &state.history {
        replay(&mut campaign, report)?;
    }
    if !state.failed_cells.iter().all(|&cell| state.open.is_none() && campaign.is_retained(cell)) {
        let expected = "cells that are left, and none in an open batch";
        return Err(Error::State { field: "failed_cells", turn: campaign.batch(), expected });
    }
    campaign.failed_cells = state.failed_cells;
    if let Some(open) = state.open {
        let open = checked_open(&campaign, open)?;
        if open.trials.is_complete() {
            let expected = "at least one trial without an outcome";
            return Err(Error::State { field: "open", turn: campaign.batch(), expected });
        }
        campaign.open = Some(open);
    }
    Ok(campaign)
}

fn checked_earlier(
    earlier: Vec<EarlierExperiment>,
    region: &Region,
    last: usize,
) -> Result<Vec<EarlierExperiment>, Error> {
    for experiment in &earlier {
        let wrong = |expected| Error::State { field: "earlier", turn: experiment.since, expected };
        experiment.check(region).map_err(|_| wrong("finite costs and settings near the region"))?;
        if !(1..=last).contains(&experiment.since) {
            return Err(wrong("since a batch of the campaign"));
        }
    }
    Ok(earlier)
}

/// Closes one more batch with the outcomes of this report, if the rest of the report follows from them.
fn replay(campaign: &mut Loop, report: &Report) -> Result<(), Error> {
    let Report { batch, simulations, trials, .. } = report.clone();
    let saved = OpenBatch { batch, simulations, trials: Trials::of_records(trials) };
    let open = checked_open(campaign, saved)?;
    if !open.trials.is_complete() {
        let expected = "an outcome for each of its trials";
        return Err(Error::State { field: "history", turn: campaign.batch(), expected });
    }
    let closed = campaign.finish(open)?;
    let found = &closed.report;
    agreement(campaign, &found.simulations, &found.trials).of_reports(report, found)?;
    campaign.close(closed);
    Ok(())
}

fn agreement(campaign: &Loop, simulations: &[SimulationRecord], trials: &[TrialRecord]) -> Agreement {
    let past = campaign.reports().iter().map(|report| (&report.simulations[..], &report.trials[..]));
    let costs = past.chain([(simulations, trials)]).flat_map(|(simulations, trials)| {
        let simulated = simulations.iter().map(|record| &record.outcome);
        simulated.chain(trials.iter().filter_map(|record| record.outcome.as_ref())).filter_map(Outcome::cost)
    });
    let largest_cost = costs.fold(0.0_f64, |largest, cost| largest.max(cost.abs()));
    Agreement { turn: campaign.batch(), largest_cost }
}

/// A batch can follow only on a campaign that had not ended. The limit on batches is left
/// out: it may be changed in the file.
fn check_may_go_on(campaign: &Loop) -> Result<(), Error> {
    let last = campaign.reports().last();
    if last.is_some_and(|last| last.own_stop(campaign.settings()).is_some()) {
        let expected = "none after the campaign had ended";
        return Err(Error::State { field: "history", turn: campaign.batch(), expected });
    }
    Ok(())
}

/// A saved batch, if it can be the next of this campaign: its cells, its trials and their outcomes as if each came in now.
/// Its numbers are those found again.
fn checked_open(campaign: &Loop, mut saved: OpenBatch) -> Result<OpenBatch, Error> {
    check_may_go_on(campaign)?;
    let (cells, settings, turn) = (&campaign.cells, &campaign.settings, campaign.batch());
    let wrong = |field, expected| Error::State { field, turn, expected };
    let experiments: Vec<Cell> = saved.trials.trials().map(|trial| trial.cell).collect();
    let runs: Vec<Cell> = saved.simulations.iter().map(|record| record.cell).collect();
    if experiments.len() != settings.n_experiments || runs.len() != settings.n_simulations {
        return Err(wrong("trials", "as many experiments and simulations as the settings say"));
    }
    if !experiments.iter().chain(&runs).all(|&cell| campaign.is_retained(cell)) {
        return Err(wrong("cell", "a cell that was left at the onset of the batch"));
    }
    let space = DesignSpace::of(&campaign.retained, cells, settings, turn)?;
    let mut uses = campaign.uses(&space, &experiments)?;
    if settings.careful {
        // By what was known as it was handed out: what came from outside since then counts in the batch, and did not choose.
        let saved: Vec<TrialUse> = saved.trials.trials().map(|trial| trial.used_for).collect();
        let n_training = |uses: &[TrialUse]| uses.iter().filter(|used_for| **used_for == TrialUse::Training).count();
        if n_training(&saved) != n_training(&uses) {
            return Err(wrong("trials.trial.used_for", "as many for training as the design has"));
        }
        uses = saved;
    }
    let handed_out = trials(&experiments, &uses, cells, turn, campaign.n_asked())?;
    let agreement = agreement(campaign, &saved.simulations, saved.trials.records());
    for (saved, found) in saved.trials.trials().zip(handed_out.trials()) {
        agreement.of_trials(saved, found)?;
    }
    let batch = space.batch(&experiments, &runs)?;
    agreement.of_batches(&saved.batch, &batch)?;
    let check = |trial: &Trial, actual: &Vec<f64>| check_actual(trial.id, actual, cells.region());
    saved.trials = handed_out.with_outcomes_of(&saved.trials, turn, check)?;
    for record in &saved.simulations {
        agreement.exact("simulations.point", &record.point, &cells.natural(record.cell)?)?;
        if matches!(record.outcome, Outcome::Value(cost) if !cost.is_finite()) {
            return Err(wrong("simulations", "finite costs"));
        }
    }
    saved.check_simulations(cells, settings)?;
    saved.batch = batch;
    Ok(saved)
}
