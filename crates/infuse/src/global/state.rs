//! The state of a global campaign in a file, and what is checked when it is read.

use doe::Region;
use serde::{Deserialize, Serialize};

use crate::global::batch::DesignSpace;
use crate::global::iteration::{OpenIteration, trials};
use crate::global::report::GlobalReport;
use crate::{Error, GlobalLoop, GlobalSettings, Outcome};

const FORMAT: u32 = 1;

/// The fields of a saved campaign.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename = "GlobalLoop")]
pub(crate) struct State {
    format: u32,
    region: Region,
    settings: GlobalSettings,
    history: Vec<GlobalReport>,
    open: Option<OpenIteration>,
}

impl From<GlobalLoop> for State {
    fn from(campaign: GlobalLoop) -> Self {
        Self {
            format: FORMAT,
            region: campaign.region().clone(),
            settings: campaign.settings,
            history: campaign.history,
            open: campaign.open,
        }
    }
}

impl TryFrom<State> for GlobalLoop {
    type Error = Error;

    /// Replays the campaign: everything but the outcomes and the choice of the cells is computed anew and must agree,
    /// number for number. The designs are checked to be designs over what was left, and are not searched for again.
    fn try_from(state: State) -> Result<Self, Error> {
        if state.format != FORMAT {
            return Err(Error::StateFormat { found: state.format, supported: FORMAT });
        }
        let mut campaign = Self::new(&state.region, state.settings)?;
        for report in state.history {
            let iteration = campaign.iteration();
            check_may_go_on(&campaign)?;
            let GlobalReport { batch, simulations, trials, .. } = report.clone();
            let open = OpenIteration { batch, simulations, trials };
            check_open(&campaign, &open)?;
            if !open.is_complete() {
                let expected = "an outcome for each of its trials";
                return Err(Error::State { field: "history", iteration, expected });
            }
            let closed = campaign.finish(open)?;
            if closed.report != report {
                let expected = "what follows from its simulations, the outcomes of its trials and the settings";
                return Err(Error::State { field: "history", iteration, expected });
            }
            campaign.close(closed);
        }
        if let Some(open) = state.open {
            let iteration = campaign.iteration();
            check_may_go_on(&campaign)?;
            check_open(&campaign, &open)?;
            if open.is_complete() {
                let expected = "at least one trial without an outcome";
                return Err(Error::State { field: "open", iteration, expected });
            }
            campaign.open = Some(open);
        }
        Ok(campaign)
    }
}

/// An iteration can follow only on a campaign that had not ended. The limit on iterations is left
/// out: it may be changed in the file.
fn check_may_go_on(campaign: &GlobalLoop) -> Result<(), Error> {
    let last = campaign.reports().last();
    if last.is_some_and(|last| last.own_stop(campaign.settings()).is_some()) {
        let expected = "none after the campaign had ended";
        return Err(Error::State { field: "history", iteration: campaign.iteration(), expected });
    }
    Ok(())
}

/// Checks batch, simulations and trials of an iteration against what was left at its onset.
fn check_open(campaign: &GlobalLoop, open: &OpenIteration) -> Result<(), Error> {
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
    if !handed_out.iter().map(|record| &record.trial).eq(open.trials.iter().map(|record| &record.trial)) {
        return Err(wrong("trials", "the trials that were handed out"));
    }
    if space.batch(&experiments, &runs)? != open.batch {
        return Err(wrong("batch", "what follows from the cells that were left and those that were chosen"));
    }
    for (mut record, told) in handed_out.into_iter().zip(&open.trials) {
        match &told.outcome {
            Some(outcome) => record.tell(told.actual.clone(), outcome.clone(), cells.region())?,
            None if told.actual.is_some() => return Err(wrong("actual", "nothing while the trial is outstanding")),
            None => {}
        }
    }
    for record in &open.simulations {
        if record.point != cells.natural(record.cell)? {
            return Err(wrong("simulations", "the settings of their cells"));
        }
        if matches!(record.outcome, Outcome::Value(cost) if !cost.is_finite()) {
            return Err(wrong("simulations", "finite costs"));
        }
    }
    campaign.check_simulations(open)
}
