//! A campaign of the dissertation's loop, as it follows from its problem and its journal.

use std::cell::OnceCell;
use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};

use anyhow::Result;
use design_space::Cell;
use infuse::global::{self, Outlook, PureError, TrialUse};

use crate::campaign::Experiments;
use crate::journal::{Event, Journal, Learned, Measured, Submitted, Writer, now};
use crate::problem::Problem;

/// Surfaces drawn to see what more experiments could bring.
const DRAWS: usize = 400;

/// Where a campaign stands.
#[derive(Debug, Clone)]
pub(crate) struct Campaign {
    pub(crate) folder: PathBuf,
    pub(crate) problem: Problem,
    /// What a person should know about the journal.
    pub(crate) notices: Vec<String>,
    pub(crate) experiments: Experiments,
    /// What each of them is used for.
    pub(crate) uses: BTreeMap<u64, TrialUse>,
    /// With every batch but the last.
    pub(super) settled: global::Loop,
    /// With all that has been told.
    pub(crate) now: global::Loop,
    pub(super) plan: Option<Planned>,
    pub(super) memory: HashMap<Cell, Remembered>,
    /// What was handed to a queue.
    pub(super) submitted: Vec<Submitted>,
    /// The last batch whose lesson the journal has, as it stands.
    pub(super) n_learned: usize,
    /// Whether something was applied that `now` does not know.
    pub(super) is_stale: bool,
    /// Changes of the earlier experiments since the batch that is open was complete; they count from the next one on.
    pub(super) since_complete: Vec<EarlierChange>,
    /// Of `now`, once it was asked for.
    pub(super) outlook: OnceCell<Option<Outlook>>,
    /// Why the last batch that was planned could not be opened.
    pub(crate) failed_opening: Option<infuse::Error>,
}

/// A batch that was designed.
#[derive(Debug, Clone)]
pub(super) struct Planned {
    pub(super) batch: usize,
    pub(super) plan: global::Plan,
    pub(super) is_open: bool,
}

/// What changed among the earlier experiments.
#[derive(Debug, Clone)]
pub(super) enum EarlierChange {
    Added { point: Vec<f64>, cost: f64, source: String },
    Withdrawn { source: String },
}

#[derive(Debug, Clone)]
pub(super) struct Remembered {
    pub(super) by: String,
    pub(super) result: Measured,
}

/// What there is to do next.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Stage {
    /// A batch is to be designed, or its simulations are to be finished.
    Ready,
    /// Experiments are waited for.
    Pending,
    /// Nothing: it has ended.
    Ended(global::StopReason),
    /// Nothing: what another batch may gain is less than it is worth.
    NotWorth { gain: f64, worth: f64 },
}

impl Campaign {
    pub(crate) fn of(folder: &Path, problem: Problem, settings: global::Settings, journal: Journal) -> Result<Self> {
        let settled = global::Loop::new(&problem.region, settings)?;
        let mut campaign = Self {
            folder: folder.to_path_buf(),
            now: settled.clone(),
            settled,
            experiments: Experiments::of(&problem.region, &[]),
            problem,
            notices: journal.notices,
            plan: None,
            uses: BTreeMap::new(),
            memory: HashMap::new(),
            submitted: Vec::new(),
            n_learned: 0,
            is_stale: false,
            since_complete: Vec::new(),
            outlook: OnceCell::new(),
            failed_opening: None,
        };
        for (line, event) in journal.events {
            campaign.apply_line(line, event)?;
        }
        campaign.refresh()?;
        Ok(campaign)
    }

    /// Writes these events down, all or none, and lets them happen. What a batch taught is written down with its last result.
    pub(super) fn write_down(&mut self, writer: &mut Writer, events: Vec<Event>) -> Result<()> {
        // Only what can happen is written down.
        let mut next = self.clone();
        // A journal may lack it: an earlier version wrote it down with the next batch, and a call can be interrupted.
        let missing = next.learning();
        let mut written: Vec<Event> = missing.into_iter().chain(events).collect();
        for event in &written {
            next.apply(event.clone())?;
        }
        next.refresh()?;
        if let Some(learned) = next.learning() {
            next.apply(learned.clone())?;
            written.push(learned);
        }
        if !written.is_empty() {
            writer.add(&written)?;
        }
        *self = next;
        Ok(())
    }

    /// A single event after which nothing is asked of the campaign before the next one.
    pub(super) fn record_simulation(&mut self, writer: &mut Writer, event: Event) -> Result<()> {
        writer.add(std::slice::from_ref(&event))?;
        self.apply(event)
    }

    pub(super) fn its_stage(&self) -> Result<Stage> {
        if let Some(reason) = self.now.stop() {
            return Ok(Stage::Ended(reason));
        }
        if !self.now.outstanding().is_empty() {
            return Ok(Stage::Pending);
        }
        if self.plan.as_ref().is_some_and(|plan| !plan.is_open) {
            return Ok(Stage::Ready);
        }
        if let (Some(worth), Some(outlook)) = (self.problem.worth, self.outlook()?)
            && let Some(gain) = outlook.total_gain().filter(|&gain| gain < worth)
        {
            return Ok(Stage::NotWorth { gain, worth });
        }
        Ok(Stage::Ready)
    }

    pub(crate) fn outlook(&self) -> Result<Option<Outlook>> {
        if let Some(outlook) = self.outlook.get() {
            return Ok(outlook.clone());
        }
        let outlook = self.now.outlook(DRAWS, self.noise())?;
        Ok(self.outlook.get_or_init(|| outlook).clone())
    }

    /// The number of the batch that is open or comes next.
    pub(crate) fn batch(&self) -> usize {
        self.now.reports().len() + 1
    }

    /// Whether what was told about an experiment of this batch stands, because the journal has gone on from it.
    pub(crate) fn is_settled(&self, batch: usize) -> bool {
        self.settled.reports().len() >= batch
    }

    /// The simulations that the planned batch still needs from this simulator, each once.
    pub(crate) fn missing_simulations(&self, by: &str) -> Result<Vec<(Cell, Vec<f64>)>> {
        let Some(Planned { plan, is_open: false, .. }) = &self.plan else {
            return Ok(Vec::new());
        };
        let mut missing = Vec::new();
        let mut seen = std::collections::BTreeSet::new();
        for &cell in &plan.simulations {
            let is_known = self.memory.get(&cell).is_some_and(|known| known.by == by);
            if !is_known && seen.insert(cell) {
                missing.push((cell, self.now.point(cell)?));
            }
        }
        Ok(missing)
    }

    /// The event that plans the next batch; none if one is planned.
    pub(crate) fn planning(&self) -> Result<Option<Event>> {
        if self.plan.as_ref().is_some_and(|plan| !plan.is_open) {
            return Ok(None);
        }
        let plan = self.now.plan()?;
        let event = |plan: global::Plan| Event::Planned {
            batch: self.batch(),
            at: now(),
            experiments: plan.experiments,
            simulations: plan.simulations,
            purpose: None,
            reasons: Vec::new(),
            // They stand once there is a result.
            settings: None,
        };
        Ok(plan.map(event))
    }

    /// The event that says what the last closed batch taught; none if the journal has it.
    pub(super) fn learning(&self) -> Option<Event> {
        let report = self.now.reports().last().filter(|report| report.number > self.n_learned)?;
        Some(Event::Learned(self.learned(report)))
    }

    pub(super) fn learned(&self, report: &infuse::global::Report) -> Learned {
        let screening = &report.screening;
        Learned {
            batch: report.number,
            optimum: screening.optimum.clone(),
            predicted: self.problem.response.of_cost(screening.optimum_value),
            spread: screening.spread.s(),
            kept: screening.n_after,
            of: screening.n_before,
        }
    }

    /// The noise of the experiments, from all runs at equal settings.
    pub(crate) fn noise(&self) -> Option<PureError> {
        self.experiments.noise_until(usize::MAX)
    }
}
