//! The state of a global campaign in a file, and what is checked when it is read.

use std::collections::BTreeSet;

use design_space::Region;
use serde::{Deserialize, Serialize};

use crate::global::agreement::Agreement;
use crate::global::batch::{Batch, DesignSpace};
use crate::global::earlier::EarlierExperiment;
use crate::global::iteration::{OpenIteration, trials};
use crate::global::report::{Report, SimulationRecord};
use crate::global::trial::TrialRecord;
use crate::global::{Loop, Settings};
use crate::{Error, Outcome};

const FORMAT: u32 = 1;

/// The fields of a saved campaign.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename = "Loop")]
pub(crate) struct State {
    format: u32,
    region: Region,
    settings: Settings,
    history: Vec<Report>,
    open: Option<OpenIteration>,
    #[serde(default)]
    failed_cells: BTreeSet<u64>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    earlier: Vec<EarlierExperiment>,
}

impl From<Loop> for State {
    fn from(campaign: Loop) -> Self {
        Self {
            format: FORMAT,
            region: campaign.region().clone(),
            settings: campaign.settings,
            history: campaign.history,
            open: campaign.open,
            failed_cells: campaign.failed_cells,
            earlier: campaign.earlier,
        }
    }
}

impl TryFrom<State> for Loop {
    type Error = Error;

    /// Replays the campaign: everything but the outcomes and the choice of the cells is computed anew and must agree, what
    /// was chosen exactly, what was computed to [rounding](Agreement). The numbers found are those that stay. The
    /// designs are checked to be designs over what was left, and are not searched for again.
    fn try_from(state: State) -> Result<Self, Error> {
        if state.format != FORMAT {
            return Err(Error::StateFormat { found: state.format, supported: FORMAT });
        }
        let mut campaign = Self::new(&state.region, state.settings)?;
        let n_iterations = state.history.len() + 1;
        for earlier in state.earlier {
            let iteration = earlier.since;
            earlier.check(&state.region).map_err(|_| {
                let expected = "finite costs and settings near the region";
                Error::State { field: "earlier", iteration, expected }
            })?;
            if !(1..=n_iterations).contains(&iteration) {
                let expected = "since an iteration of the campaign";
                return Err(Error::State { field: "earlier", iteration, expected });
            }
            campaign.earlier.push(earlier);
        }
        for report in state.history {
            let iteration = campaign.iteration();
            check_may_go_on(&campaign)?;
            let Report { batch, simulations, trials, .. } = report.clone();
            let mut open = OpenIteration { batch, simulations, trials };
            open.batch = check_open(&campaign, &open)?;
            if !open.is_complete() {
                let expected = "an outcome for each of its trials";
                return Err(Error::State { field: "history", iteration, expected });
            }
            let closed = campaign.finish(open)?;
            agreement(&campaign, &closed.report.simulations, &closed.report.trials)
                .of_reports(&report, &closed.report)?;
            campaign.close(closed);
        }
        if !state.failed_cells.iter().all(|&cell| state.open.is_none() && campaign.is_retained(cell)) {
            let expected = "cells that are left, and none in an open iteration";
            return Err(Error::State { field: "failed_cells", iteration: campaign.iteration(), expected });
        }
        campaign.failed_cells = state.failed_cells;
        if let Some(mut open) = state.open {
            let iteration = campaign.iteration();
            check_may_go_on(&campaign)?;
            open.batch = check_open(&campaign, &open)?;
            if open.is_complete() {
                let expected = "at least one trial without an outcome";
                return Err(Error::State { field: "open", iteration, expected });
            }
            campaign.open = Some(open);
        }
        Ok(campaign)
    }
}

fn agreement(campaign: &Loop, simulations: &[SimulationRecord], trials: &[TrialRecord]) -> Agreement {
    let past = campaign.reports().iter().map(|report| (&report.simulations[..], &report.trials[..]));
    let costs = past.chain([(simulations, trials)]).flat_map(|(simulations, trials)| {
        let simulated = simulations.iter().map(|record| &record.outcome);
        simulated.chain(trials.iter().filter_map(|record| record.outcome.as_ref())).filter_map(Outcome::cost)
    });
    let largest_cost = costs.fold(0.0_f64, |largest, cost| largest.max(cost.abs()));
    Agreement { iteration: campaign.iteration(), largest_cost }
}

/// An iteration can follow only on a campaign that had not ended. The limit on iterations is left
/// out: it may be changed in the file.
fn check_may_go_on(campaign: &Loop) -> Result<(), Error> {
    let last = campaign.reports().last();
    if last.is_some_and(|last| last.own_stop(campaign.settings()).is_some()) {
        let expected = "none after the campaign had ended";
        return Err(Error::State { field: "history", iteration: campaign.iteration(), expected });
    }
    Ok(())
}

/// Checks batch, simulations and trials of an iteration against what was left at its onset. Returns the batch as found.
fn check_open(campaign: &Loop, open: &OpenIteration) -> Result<Batch, Error> {
    let (cells, settings, iteration) = (&campaign.cells, &campaign.settings, campaign.iteration());
    let wrong = |field, expected| Error::State { field, iteration, expected };
    let experiments: Vec<u64> = open.trials.iter().map(|record| record.trial.cell).collect();
    let runs: Vec<u64> = open.simulations.iter().map(|record| record.cell).collect();
    if experiments.len() != settings.n_experiments || runs.len() != settings.n_simulations {
        return Err(wrong("trials", "as many experiments and simulations as the settings say"));
    }
    if !experiments.iter().chain(&runs).all(|&cell| campaign.is_retained(cell)) {
        return Err(wrong("cell", "a cell that was left at the onset of the iteration"));
    }
    let space = DesignSpace::of(&campaign.retained, cells, settings, iteration)?;
    let handed_out = trials(&experiments, &space.uses(&experiments)?, cells, iteration, campaign.n_asked())?;
    let agreement = agreement(campaign, &open.simulations, &open.trials);
    for (saved, found) in open.trials.iter().zip(&handed_out) {
        agreement.of_trials(&saved.trial, &found.trial)?;
    }
    let batch = space.batch(&experiments, &runs)?;
    agreement.of_batches(&open.batch, &batch)?;
    for (mut record, told) in handed_out.into_iter().zip(&open.trials) {
        match &told.outcome {
            Some(outcome) => record.tell(told.actual.clone(), outcome.clone(), cells.region())?,
            None if told.actual.is_some() => return Err(wrong("actual", "nothing while the trial is outstanding")),
            None => {}
        }
    }
    for record in &open.simulations {
        agreement.exact("simulations.point", &record.point, &cells.natural(record.cell)?)?;
        if matches!(record.outcome, Outcome::Value(cost) if !cost.is_finite()) {
            return Err(wrong("simulations", "finite costs"));
        }
    }
    campaign.check_simulations(open)?;
    Ok(batch)
}
