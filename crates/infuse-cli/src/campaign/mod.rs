//! A campaign as it follows from its problem and its journal.

mod apply;
mod changes;
mod reading;

use std::cell::OnceCell;
use std::collections::{BTreeMap, HashMap};
use std::path::Path;
use std::time::Duration;

use anyhow::Result;
use design_space::Cell;
use infuse::global::{self, Outlook, PureError};
use rand::seq::SliceRandom as _;
use rand::{RngExt as _, SeedableRng as _};
use rand_pcg::Pcg64;

use crate::journal::{Event, FORMAT, Journal, Learned, Measured, Writer, now};
use crate::problem::Problem;
pub(crate) use reading::Reading;

/// Surfaces drawn to see what more experiments could bring.
const DRAWS: usize = 400;

/// Where a campaign stands.
#[derive(Debug, Clone)]
pub(crate) struct Campaign {
    pub(crate) problem: Problem,
    /// What a person should know about the journal.
    pub(crate) notices: Vec<String>,
    /// With every batch but the last.
    settled: global::Loop,
    /// With all that has been told.
    pub(crate) now: global::Loop,
    plan: Option<Planned>,
    /// Every experiment that was ever handed out, by id.
    pub(crate) trials: BTreeMap<u64, global::Trial>,
    /// What was told about them.
    pub(crate) readings: BTreeMap<u64, Reading>,
    memory: HashMap<Cell, Remembered>,
    /// The last batch whose lesson the journal has, as it stands.
    n_learned: usize,
    has_begun: bool,
    /// Whether something was applied that `now` does not know.
    is_stale: bool,
    /// Changes of the earlier experiments since the batch that is open was complete; they count from the next one on.
    since_complete: Vec<EarlierChange>,
    /// Of `now`, once it was asked for.
    outlook: OnceCell<Option<Outlook>>,
    /// Why the last batch that was planned could not be opened.
    pub(crate) failed_opening: Option<infuse::Error>,
}

/// A batch that was designed.
#[derive(Debug, Clone)]
struct Planned {
    batch: usize,
    plan: global::Plan,
    is_open: bool,
}

/// What changed among the earlier experiments.
#[derive(Debug, Clone)]
enum EarlierChange {
    Added { point: Vec<f64>, cost: f64, source: String },
    Withdrawn { source: String },
}

#[derive(Debug, Clone)]
struct Remembered {
    by: String,
    result: Measured,
}

/// What there is to do next.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Stage {
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
    /// The campaign of this folder, for reading.
    pub(crate) fn read(folder: &Path) -> Result<Self> {
        Self::of(Problem::read(folder)?, Journal::read(folder)?)
    }

    /// The campaign of this folder, and its journal to write to. A journal that has not begun is begun.
    pub(crate) fn open(folder: &Path, wait: Duration) -> Result<(Self, Writer)> {
        let problem = Problem::read(folder)?;
        let (mut writer, journal) = Writer::open(folder, wait)?;
        let mut campaign = Self::of(problem, journal)?;
        if !campaign.has_begun {
            let begin = Event::Campaign { format: FORMAT, at: now(), problem: campaign.problem.core() };
            campaign.record(&mut writer, vec![begin])?;
        }
        Ok((campaign, writer))
    }

    fn of(problem: Problem, journal: Journal) -> Result<Self> {
        let settled = global::Loop::new(&problem.region, problem.settings.clone())?;
        let mut campaign = Self {
            now: settled.clone(),
            settled,
            problem,
            notices: journal.notices,
            plan: None,
            trials: BTreeMap::new(),
            readings: BTreeMap::new(),
            memory: HashMap::new(),
            n_learned: 0,
            has_begun: false,
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
    pub(crate) fn record(&mut self, writer: &mut Writer, events: Vec<Event>) -> Result<()> {
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
    pub(crate) fn record_simulation(&mut self, writer: &mut Writer, event: Event) -> Result<()> {
        writer.add(std::slice::from_ref(&event))?;
        self.apply(event)
    }

    pub(crate) fn stage(&self) -> Result<Stage> {
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

    /// The number of the batch that was handed out last.
    pub(crate) fn last_batch(&self) -> Option<usize> {
        self.trials.values().next_back().map(|trial| trial.iteration)
    }

    /// Whether what was told about this trial stands, because the journal has gone on from it.
    pub(crate) fn is_settled(&self, trial: &global::Trial) -> bool {
        self.settled.reports().len() >= trial.iteration
    }

    /// The trials of a batch in the order in which they are to be run, each with the one that it repeats.
    pub(crate) fn in_run_order(&self, batch: usize) -> Vec<(global::Trial, Option<u64>)> {
        let own = self.trials.values().filter(|trial| trial.iteration == batch);
        let mut trials: Vec<_> = own.map(|trial| (trial.clone(), self.repeated(trial))).collect();
        let mut generator = Pcg64::seed_from_u64(self.problem.settings.seed);
        for _ in 0..batch {
            generator = Pcg64::seed_from_u64(generator.random());
        }
        trials.shuffle(&mut generator);
        trials
    }

    /// The first trial of the same batch at the same settings, if this is another.
    pub(crate) fn repeated(&self, trial: &global::Trial) -> Option<u64> {
        let same = |other: &&global::Trial| other.iteration == trial.iteration && other.cell == trial.cell;
        let first = self.trials.values().find(same)?.id;
        (first < trial.id).then(|| first.number())
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
        };
        Ok(plan.map(event))
    }

    /// The event that says what the last closed batch taught; none if the journal has it.
    fn learning(&self) -> Option<Event> {
        let report = self.now.reports().last().filter(|report| report.iteration > self.n_learned)?;
        Some(Event::Learned(self.learned(report)))
    }

    fn learned(&self, report: &infuse::global::Report) -> Learned {
        let screening = &report.screening;
        Learned {
            batch: report.iteration,
            optimum: screening.optimum.clone(),
            predicted: self.problem.response.of_cost(screening.optimum_value),
            spread: screening.spread.s(),
            kept: screening.n_after,
            of: screening.n_before,
        }
    }

    /// The noise of the experiments, from all runs at equal settings.
    pub(crate) fn noise(&self) -> Option<PureError> {
        self.noise_until(usize::MAX)
    }

    /// The same, of the batches up to this one.
    pub(crate) fn noise_until(&self, batch: usize) -> Option<PureError> {
        let is_meant = |id: &u64| self.trials.get(id).is_some_and(|trial| trial.iteration <= batch);
        let meant = self.readings.iter().filter(|(id, _)| is_meant(id));
        PureError::of_readings(meant.flat_map(|(&id, reading)| {
            let settings = self.settings_of(id);
            reading.values().map(move |value| (settings.clone(), value))
        }))
    }

    /// The settings that an experiment was made at.
    pub(crate) fn settings_of(&self, id: u64) -> Vec<f64> {
        let Some(trial) = self.trials.get(&id) else { return Vec::new() };
        let actual = self.readings.get(&id).map(|reading| &reading.actual);
        let settings = self.problem.names().zip(&trial.point);
        settings.map(|(name, &asked)| actual.and_then(|actual| actual.get(name).copied()).unwrap_or(asked)).collect()
    }
}
