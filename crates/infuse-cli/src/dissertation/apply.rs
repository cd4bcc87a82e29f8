//! How each line of a journal changes a campaign.

use anyhow::{Context as _, Result, bail, ensure};
use design_space::Cell;
use indicatif::ProgressBar;
use infuse::pooled::Trial;
use infuse::{Error, global};
use std::cell::OnceCell;

use super::campaign::{Campaign, EarlierChange, Planned, Remembered};
use crate::campaign::busy;
use crate::journal::{Event, JOURNAL, Learned, Measured, Submitted, Told};
use crate::number::{grouped, plain};

/// So many designs are gone through before anybody wonders.
const FEW_CELLS: u64 = 10_000_000;

impl Campaign {
    /// An event of the journal; an error names its line.
    pub(super) fn apply_line(&mut self, line: usize, event: Event) -> Result<()> {
        self.apply(event).with_context(|| format!("{JOURNAL}, line {line}, does not follow from what comes before it"))
    }

    pub(super) fn apply(&mut self, event: Event) -> Result<()> {
        match event {
            Event::Planned { batch, experiments, simulations, .. } => {
                self.settle()?;
                let expected = self.settled.reports().len() + 1;
                ensure!(batch == expected, "batch {batch} is planned, expected batch {expected}");
                // A failure is remembered for the batch it belongs to; another batch may try again.
                self.memory.retain(|_, known| matches!(known.result, Measured::Value(_)));
                let plan = global::Plan { experiments, simulations };
                self.plan = Some(Planned { batch, plan, is_open: false });
            }
            Event::Simulated { cell, result, by, .. } => {
                self.memory.insert(cell, Remembered { by, result });
            }
            Event::Submitted(submitted) => self.submitted.push(submitted),
            Event::Discarded { .. } => {
                self.memory.clear();
                // Results of runs that were to be thrown away are not read again.
                self.submitted.retain(Submitted::is_of_experiments);
            }
            Event::Opened { batch, .. } => self.open_batch(batch)?,
            Event::Sheet { batch, path, .. } => self.experiments.note_sheet(batch, path),
            Event::Told(told) => self.tell(told)?,
            Event::Imported { point, result, source, .. } => {
                let value = result.value().context(
                    "an imported experiment without a value is of use with `method` = \"pooled\" only: leave it out",
                )?;
                let cost = self.problem.response.cost(value);
                self.change_earlier(EarlierChange::Added { point, cost, source })?;
            }
            Event::Withdrawn { source, .. } => {
                self.change_earlier(EarlierChange::Withdrawn { source })?;
            }
            Event::Learned(learned) => self.check_learned(&learned)?,
            Event::Undone { .. } => bail!("what was taken back is left out before"),
            Event::Campaign { .. } => bail!("expected the event `campaign` on the first line only"),
            Event::Assessed(_) | Event::Checked { .. } => bail!("the event belongs to `method` = \"pooled\""),
        }
        Ok(())
    }

    /// Shows that all designs are gone through, where that takes seconds.
    fn passing(&self) -> Option<ProgressBar> {
        let (n_cells, batch) = (self.now.retained().n_cells(), self.batch());
        (n_cells > FEW_CELLS).then(|| busy(format!("batch {batch}: going through {} designs", grouped(n_cells))))
    }

    fn open_batch(&mut self, batch: usize) -> Result<()> {
        let _passing = self.passing();
        let Some(planned) = self.plan.as_mut().filter(|planned| planned.batch == batch && !planned.is_open) else {
            bail!("batch {batch} is opened, expected a batch that was planned just before");
        };
        self.is_stale = true;
        let (memory, problem) = (&self.memory, &self.problem);
        let mut look_up = |cell: Cell, _: &[f64]| match memory.get(&cell).map(|known| &known.result) {
            Some(Measured::Value(value)) => Ok(problem.response.cost(*value)),
            Some(Measured::Failed(reason)) => Err(reason.clone()),
            None => Err("it was never simulated".to_owned()),
        };
        match self.settled.open(&planned.plan, &mut look_up) {
            Ok(trials) => {
                planned.is_open = true;
                self.uses.extend(trials.iter().map(|trial| (trial.id.number(), trial.used_for)));
                let plain = |trial: global::Trial| {
                    let global::Trial { id, batch, cell, point, .. } = trial;
                    Trial { id, batch, cell, point }
                };
                self.experiments.hand_out(trials.into_iter().map(plain));
            }
            // The loop has noted where: the next plan goes elsewhere.
            Err(error @ (Error::EverySimulationFailed { .. } | Error::TooFewSimulations { .. })) => {
                self.plan = None;
                self.failed_opening = Some(error);
            }
            Err(error) => return Err(error.into()),
        }
        Ok(())
    }

    fn tell(&mut self, told: Told) -> Result<()> {
        let (id, batch) = (told.id, self.experiments.trial(told.id)?.batch);
        let is_open = self.plan.as_ref().is_some_and(|plan| plan.is_open && plan.batch == batch);
        ensure!(is_open, "experiment {id} belongs to batch {batch}, and later batches rest on its result: it stands");
        self.is_stale = true;
        // What it taught is to be said anew.
        self.n_learned = self.n_learned.min(batch - 1);
        self.experiments.tell(told)
    }

    /// Closes the batch that is open; from here on it stands.
    fn settle(&mut self) -> Result<()> {
        if !self.plan.as_ref().is_some_and(|plan| plan.is_open) {
            return Ok(());
        }
        let untold = self.settled.outstanding().iter().filter(|trial| !self.experiments.has_result(trial.id)).count();
        ensure!(untold == 0, "{untold} experiments of the batch before have no result");
        self.refresh()?;
        self.settled = self.now.clone();
        self.since_complete.clear();
        self.plan = None;
        Ok(())
    }

    /// The campaign with all that has been told up to now.
    pub(super) fn refresh(&mut self) -> Result<()> {
        if self.is_stale {
            let _passing = self.passing();
            self.now = self.with_what_was_told()?;
            self.outlook = OnceCell::new();
            self.is_stale = false;
        }
        Ok(())
    }

    /// Earlier experiments come or go, from the batch that is not complete yet on.
    fn change_earlier(&mut self, change: EarlierChange) -> Result<()> {
        let is_learned = self.plan.as_ref().is_some_and(|plan| plan.is_open && plan.batch == self.n_learned);
        if is_learned {
            self.refresh()?;
            change.apply(&mut self.now)?;
            self.outlook = OnceCell::new();
            self.since_complete.push(change);
        } else {
            change.apply(&mut self.settled)?;
            self.is_stale = true;
        }
        Ok(())
    }

    fn with_what_was_told(&self) -> Result<global::Loop> {
        let mut now = self.settled.clone();
        for trial in self.settled.outstanding() {
            let reading = self.experiments.readings.get(&trial.id.number());
            if let Some(outcome) = reading.and_then(|reading| reading.outcome(&self.problem.response)) {
                now.tell_at(trial.id, &self.experiments.settings_of(trial.id.number()), outcome)?;
            }
        }
        self.since_complete.iter().try_for_each(|change| change.apply(&mut now))?;
        Ok(now)
    }

    /// What was learned follows from the lines before; if it does not, one of them was changed.
    fn check_learned(&mut self, said: &Learned) -> Result<()> {
        self.refresh()?;
        let report = self.now.reports().last().filter(|report| report.number == said.batch);
        let Some(found) = report.map(|report| self.learned(report)) else {
            bail!("batch {} is not complete", said.batch);
        };
        let scale = found.predicted.abs().max(found.spread.unwrap_or(0.0));
        let is_close = |said: f64, found: f64| global::agrees(said, found, scale);
        let spreads = match (said.spread, found.spread) {
            (Some(a), Some(b)) => is_close(a, b),
            (a, b) => a.is_none() && b.is_none(),
        };
        let is_same = said.optimum == found.optimum
            && is_close(said.predicted, found.predicted)
            && spreads
            && (said.kept, said.of) == (found.kept, found.of);
        let show = |learned: &Learned| {
            let spread = learned.spread.map_or_else(|| "none".to_owned(), plain);
            let (predicted, Learned { kept, of, .. }) = (plain(learned.predicted), learned);
            format!("{} with {predicted}, S {spread}, {kept} of {of} kept", self.problem.describe(&learned.optimum))
        };
        ensure!(
            is_same,
            "it says that batch {} found {}; from the lines before follows {}: one of them was changed",
            said.batch,
            show(said),
            show(&found)
        );
        self.n_learned = said.batch;
        Ok(())
    }
}

impl EarlierChange {
    fn apply(&self, to: &mut global::Loop) -> Result<()> {
        match self {
            Self::Added { point, cost, source } => to.add_earlier(point, *cost, source.clone())?,
            Self::Withdrawn { source } => {
                let n = to.withdraw_earlier(source);
                ensure!(n > 0, "nothing that is in use was imported from `{source}`");
            }
        }
        Ok(())
    }
}
