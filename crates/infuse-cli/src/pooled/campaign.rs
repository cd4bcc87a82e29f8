//! A campaign of the pooled loop, as it follows from its problem and its journal.

use std::cell::{OnceCell, RefCell};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::{Path, PathBuf};
use std::rc::Rc;

use anyhow::{Result, anyhow, bail, ensure};
use design_space::{Cell, Grid};
use infuse::global::PureError;
use infuse::pooled::reported::Block;
use infuse::pooled::{Assessment, Loop, Reason, Responses, Settings, Simulate};
use infuse::{Error, Outcome, TrialId};
use serde_json::{Value, json};

use crate::campaign::{Experiments, Imported, Reading, busy};
use crate::echo::echo;
use crate::journal::{Assessed, BY_ITSELF, Constrained, Event, Journal, Measured, Purpose, Submitted, Told};
use crate::number::{count, plain};
use crate::problem::{Goal, PROBLEM, Problem, Scale, Simulator, linear_in_words};
use crate::simulator::{Job, Rows, identity, looked_up};
use crate::wording::all_of;

/// Designs of which a command simulates all.
const MOST_SIMULATED: u64 = 20_000;
/// A table with a smaller share of the designs is continued by a surface through some of its rows: so many at most.
const DENSE: f64 = 0.5;
const MOST_ROWS: usize = 400;
/// Results that are named, at most.
const MOST_NAMED: usize = 5;

/// What was simulated of some designs, in the order of the cells.
pub(super) type Costs = Rc<[(Cell, f64)]>;

/// Where a campaign stands.
#[derive(Debug, Clone)]
pub(crate) struct Campaign {
    pub(super) folder: PathBuf,
    pub(super) problem: Problem,
    pub(super) settings: Settings,
    pub(super) grid: Grid,
    /// What a person should know.
    pub(super) notices: Vec<String>,
    pub(super) experiments: Experiments,
    pub(super) batches: Vec<Batch>,
    /// Cells that were to be simulated.
    pub(super) planned: BTreeSet<Cell>,
    pub(super) memory: HashMap<Cell, Remembered>,
    /// What was handed to a queue.
    pub(super) submitted: Vec<Submitted>,
    pub(super) imported: Vec<Imported>,
    pub(super) withdrawn: Vec<Withdrawn>,
    /// Whether designs can be built.
    pub(super) checked: BTreeMap<Cell, Checked>,
    /// What was known after each batch.
    pub(super) history: BTreeMap<usize, Assessed>,
    /// What was said last, if that was on another scale than the response has now.
    pub(super) on_another_scale: Option<Assessed>,
    /// The rows of a simulator that is a table, once they were read.
    rows: Rc<OnceCell<Rows>>,
    /// Their costs, where the loop may ask for them.
    costs_of_rows: Rc<OnceCell<Costs>>,
    /// The loop before anything was told.
    pub(super) empty: Loop,
    /// The loop with all that was told, once it was asked for.
    now: RefCell<Option<Loop>>,
    assessed: OnceCell<Option<Assessment>>,
    /// The same, had the file not said that runs of a batch share an error.
    pub(super) unsaid: OnceCell<Option<Assessment>>,
    /// Designs that gave a value, and are not thought to keep to a bound that was not measured there.
    doubtful: OnceCell<BTreeSet<Cell>>,
}

/// The responses that people measured beside the one that counts; what programs say besides is theirs.
fn measured_by_people(events: &[(usize, Event)]) -> BTreeSet<String> {
    let of_event = |event: &Event| match event {
        Event::Told(Told { constrained, from, .. }) if from != BY_ITSELF => constrained.keys().cloned().collect(),
        _ => Vec::new(),
    };
    events.iter().flat_map(|(_, event)| of_event(event)).collect()
}

/// Experiments that were handed out together.
#[derive(Debug, Clone)]
pub(super) struct Batch {
    pub(super) cells: Vec<Cell>,
    pub(super) purpose: Option<Purpose>,
    /// Why the loop asked for each experiment; none if that was not written down.
    pub(super) reasons: Vec<Reason>,
}

/// A simulation, and by which simulator.
#[derive(Debug, Clone)]
pub(super) struct Remembered {
    pub(super) by: String,
    pub(super) result: Measured,
    pub(super) constrained: Constrained,
}

/// Whether a design can be built, and which command said so.
#[derive(Debug, Clone)]
pub(super) struct Checked {
    pub(super) by: String,
    pub(super) can_be_built: bool,
}

/// Imported experiments that are not used any more.
#[derive(Debug, Clone)]
pub(super) struct Withdrawn {
    pub(super) source: String,
    pub(super) n: usize,
    /// The last batch of which it was said before what it had taught; 0 if there was none.
    pub(super) after: usize,
}

/// Which experiment a reading of the loop is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Origin {
    /// By its place among those in use.
    Imported(usize),
    /// By its id.
    Own(u64),
}

/// How the loop comes to know what the simulation says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Access {
    /// There is no simulation.
    Nothing,
    /// Every design can be looked up.
    LookedUp,
    /// Every design is simulated before the first batch.
    All,
    /// A budget per batch, and a surface through them.
    Budget,
}

impl Campaign {
    pub(crate) fn of(folder: &Path, problem: Problem, journal: Journal) -> Result<Self> {
        let (settings, unused) = problem.pooled_settings()?;
        let empty = Loop::new(&problem.region, settings.clone()).map_err(|error| by_constraints(&problem, error))?;
        let grid = empty.grid().clone();
        let mut notices = journal.notices;
        if !unused.is_empty() {
            let keys = unused.iter().map(|key| format!("`{key}`")).collect::<Vec<_>>().join(", ");
            notices
                .push(format!("of [loop] the pooled loop does not use {keys}: for `method` = \"dissertation\" only"));
        }
        let mut campaign = Self {
            folder: folder.to_path_buf(),
            settings,
            grid,
            notices,
            experiments: Experiments::of(&problem.region, &problem.plant()),
            problem,
            batches: Vec::new(),
            planned: BTreeSet::new(),
            memory: HashMap::new(),
            submitted: Vec::new(),
            imported: Vec::new(),
            withdrawn: Vec::new(),
            checked: BTreeMap::new(),
            empty,
            history: BTreeMap::new(),
            on_another_scale: None,
            rows: Rc::new(OnceCell::new()),
            costs_of_rows: Rc::new(OnceCell::new()),
            now: RefCell::new(None),
            assessed: OnceCell::new(),
            unsaid: OnceCell::new(),
            doubtful: OnceCell::new(),
        };
        let by_people = measured_by_people(&journal.events);
        for (line, event) in journal.events {
            campaign.apply_line(line, event)?;
        }
        campaign.check_the_scale()?;
        campaign.notice_unknown_constraints(by_people);
        campaign.notice_what_is_not_allowed();
        Ok(campaign)
    }

    /// What was measured before the scale became logarithmic may have no logarithm.
    fn check_the_scale(&self) -> Result<()> {
        let imported = self.imported.iter().enumerate();
        let imported = imported.filter_map(|(index, one)| Some((Origin::Imported(index), one.result.value()?)));
        let own = self.experiments.readings.iter();
        let own = own.flat_map(|(&id, reading)| reading.values().map(move |value| (Origin::Own(id), value)));
        let response = &self.problem.response;
        let fault = |(origin, value): (Origin, f64)| Some((origin, value, response.without_logarithm(value)?));
        let faults: Vec<(Origin, f64, String)> = imported.chain(own).filter_map(fault).collect();
        let Some((_, _, expected)) = faults.first() else { return Ok(()) };
        let named = faults.iter().take(MOST_NAMED);
        let named = named.map(|(origin, value, _)| format!("{} gave {}", self.full_name_of(*origin), plain(*value)));
        let named = named.collect::<Vec<_>>().join(", ");
        let more = match faults.len().saturating_sub(MOST_NAMED) {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        bail!(
            "{named}{more}, expected {expected}; take `scale` out, put the results right with `infuse tell --correct`, or take them \
             back, and set `scale` then"
        );
    }

    /// The settings of the loop as the file has them: on a logarithmic scale factors, and that scale.
    pub(super) fn settings_as_said(&self) -> Value {
        let (mut said, response) = (serde_json::to_value(&self.settings).unwrap_or_default(), &self.problem.response);
        // As the file calls it.
        if let Some(stop_by) = said.as_object_mut().and_then(|said| said.remove("stop_by")) {
            said["by"] = stop_by;
        }
        if let Some(least) = self.settings.least {
            said.as_object_mut().and_then(|said| said.remove("least"));
            said[if response.goal == Goal::Minimize { "lower" } else { "upper" }] = json!(response.of_cost(least));
        }
        if response.scale == Scale::Log {
            said["noise"] = json!(self.problem.rule.noise);
            said["worth"] = json!(self.problem.worth);
            said["scale"] = json!(response.scale);
        }
        said
    }

    /// Settings that stand as they were before the scale became another, on which they mean something else.
    pub(super) fn left_from_another_scale(&self) -> Vec<(&'static str, f64)> {
        let then = |key: &str| self.on_another_scale.as_ref()?.settings.get(key)?.as_f64();
        let pairs = [
            ("`worth` in [stop]", "worth", self.problem.worth),
            ("`noise` in [loop]", "noise", self.problem.rule.noise),
        ];
        let is_left = |(_, key, now): &(&'static str, &str, Option<f64>)| {
            then(key).zip(*now).is_some_and(|(then, now)| then.total_cmp(&now).is_eq())
        };
        pairs.into_iter().filter(is_left).filter_map(|(what, _, now)| Some((what, now?))).collect()
    }

    /// Says of which responses there are measurements that no constraint of the file uses.
    fn notice_unknown_constraints(&mut self, mut names: BTreeSet<String>) {
        names.extend(self.imported.iter().flat_map(|one| one.constrained.keys().cloned()));
        let is_known = |name: &str| self.problem.constraints.iter().any(|held| held.name() == name);
        let unknown: Vec<String> =
            names.into_iter().filter(|name| !is_known(name)).map(|name| format!("`{name}`")).collect();
        if !unknown.is_empty() {
            let names = unknown.join(", ");
            self.notices.push(format!("{names} was measured, but {PROBLEM} has no [[constraint]] of that name"));
        }
    }

    /// Says which experiments that are waited for are not to be had any more.
    fn notice_what_is_not_allowed(&mut self) {
        let waited = self.experiments.trials.values().filter(|trial| !self.experiments.has_result(trial.id));
        let broken: Vec<(u64, String)> =
            waited.filter_map(|trial| Some((trial.id.number(), self.why_not(trial.cell)?))).collect();
        let ids: Vec<String> = broken.iter().map(|(id, _)| id.to_string()).collect();
        if let Some((_, why_not)) = broken.first() {
            let of = if ids.len() == 1 { "experiment" } else { "experiments" };
            self.notices.push(format!(
                "{of} {} of the open batch would not be asked for any more ({why_not}): run them all the same, tell them as \
                 failed, or take the ask back",
                ids.join(", ")
            ));
        }
    }

    /// Something has changed that the loop does not know.
    pub(super) fn forget_the_loop(&mut self) {
        *self.now.borrow_mut() = None;
        self.assessed = OnceCell::new();
        self.unsaid = OnceCell::new();
        self.doubtful = OnceCell::new();
    }

    /// How many experiments were handed out.
    pub(super) fn n_handed_out(&self) -> u64 {
        self.experiments.trials.len() as u64
    }

    /// Batches that were not planned by the loop: they do not count for the limit.
    pub(super) fn n_confirming(&self) -> usize {
        self.batches.iter().filter(|batch| batch.purpose.is_some()).count()
    }

    /// Batches all of whose experiments were told.
    pub(super) fn n_complete(&self) -> usize {
        let waiting: BTreeSet<usize> = self
            .experiments
            .trials
            .values()
            .filter(|trial| !self.experiments.has_result(trial.id))
            .map(|trial| trial.batch)
            .collect();
        self.batches.len() - waiting.len()
    }

    /// How the simulation is come by.
    pub(super) fn access(&self) -> Result<Access> {
        let n_cells = self.grid.n_cells();
        Ok(match (&self.problem.simulator, self.settings.simulations) {
            (Simulator::Nothing, _) => Access::Nothing,
            (Simulator::Table(_), _) => {
                let share = self.rows()?.len() as f64 / n_cells as f64;
                if share >= DENSE { Access::LookedUp } else { Access::Budget }
            }
            (Simulator::Program { .. }, Some(budget)) if (budget as u64) < n_cells => Access::Budget,
            (Simulator::Program { .. }, Some(_)) => Access::All,
            (Simulator::Program { .. }, None) => {
                ensure!(
                    n_cells <= MOST_SIMULATED,
                    "{PROBLEM}: [loop] `simulations` is \"all\" of {n_cells} designs, expected a number per batch (or a table) \
                     for more than {MOST_SIMULATED}"
                );
                Access::All
            }
        })
    }

    /// The rows of the table that is the simulator.
    pub(super) fn rows(&self) -> Result<&Rows> {
        if let (Simulator::Table(path), None) = (&self.problem.simulator, self.rows.get()) {
            let rows = looked_up(&self.folder, path, &self.problem, &self.grid)?;
            let _ = self.rows.set(rows);
        }
        Ok(self.rows.get_or_init(|| Rows::none(self.problem.constraints.len())))
    }

    /// What is to be simulated before the campaign can go on.
    pub(super) fn missing_simulations(&self) -> Result<Vec<Job>> {
        let by = identity(&self.problem.simulator);
        let is_missing = |cell: &Cell| self.memory.get(cell).is_none_or(|known| known.by != by);
        let cells: Vec<Cell> = match (self.access()?, &self.problem.simulator) {
            (_, Simulator::Table(_)) | (Access::Nothing | Access::LookedUp, _) => Vec::new(),
            (Access::All, _) => self.grid.cells().filter(|&cell| self.empty.allows(cell)).filter(is_missing).collect(),
            (Access::Budget, _) => self.planned.iter().copied().filter(is_missing).collect(),
        };
        cells.into_iter().map(|cell| Ok((cell, self.grid.point(cell)?))).collect()
    }

    /// Every simulated cost that is known, in the order of the cells.
    pub(super) fn simulated(&self) -> Result<Costs> {
        let response = &self.problem.response;
        if let Simulator::Table(_) = &self.problem.simulator {
            let rows = self.rows()?;
            let costs = || {
                let allowed = rows.iter().filter(|(cell, _)| self.empty.allows(*cell));
                allowed.map(|(cell, row)| (cell, response.cost(row.value))).collect()
            };
            return Ok(Rc::clone(self.costs_of_rows.get_or_init(costs)));
        }
        let by = identity(&self.problem.simulator);
        let of_it = self.memory.iter().filter(|(_, known)| known.by == by);
        let cost = |(&cell, known): (&Cell, &Remembered)| Some((cell, response.cost(known.result.value()?)));
        let mut costs: Vec<(Cell, f64)> = of_it.filter_map(cost).collect();
        costs.sort_by_key(|&(cell, _)| cell);
        Ok(costs.into())
    }

    /// What was simulated of the responses that have to stay within bounds, in the order of the constraints.
    fn simulated_constraints(&self, cell: Cell) -> Result<Vec<Option<f64>>> {
        Ok(match &self.problem.simulator {
            Simulator::Nothing => Vec::new(),
            Simulator::Table(_) => self.rows()?.get(cell).map(|row| row.constrained()).unwrap_or_default(),
            Simulator::Program { .. } => {
                self.memory.get(&cell).map(|known| self.problem.in_order(&known.constrained)).unwrap_or_default()
            }
        })
    }

    /// Why a design is not to be asked for or recommended, whatever is expected of it.
    pub(super) fn why_not(&self, cell: Cell) -> Option<String> {
        let point = self.grid.point(cell).ok()?;
        let linear = self.problem.linear_constraints.iter().find(|linear| !linear.allows(&point));
        let broken = linear
            .map(|linear| format!("[[linear_constraint]] asks for {}", linear_in_words(&self.problem.region, linear)));
        broken.or_else(|| self.is_refused(cell).then(|| "[can_be_built] says that it cannot be built".to_owned()))
    }

    /// Whether a design keeps to every bound, as far as the simulation says.
    fn is_within_by_simulation(&self, cell: Cell) -> Result<bool> {
        if self.problem.constraints.is_empty() {
            return Ok(true);
        }
        let values = self.simulated_constraints(cell)?;
        let mut pairs = self.problem.constraints.iter().zip(values);
        Ok(pairs.all(|(held, value)| value.is_none_or(|value| held.constraint.allows(value))))
    }

    /// The design that the simulation likes best, of those that were simulated and keep to the bounds, as it says; none where it
    /// says the same of all.
    pub(super) fn choice_of_the_simulation(&self) -> Result<Option<Cell>> {
        let (mut best, simulated): (Option<(Cell, f64)>, _) = (None, self.simulated()?);
        if !tells_designs_apart(&simulated) {
            return Ok(None);
        }
        for &(cell, cost) in simulated.iter() {
            let is_better = best.is_none_or(|(_, least)| cost.total_cmp(&least).is_lt());
            if is_better && self.is_within_by_simulation(cell)? && self.why_not(cell).is_none() {
                best = Some((cell, cost));
            }
        }
        Ok(best.map(|(cell, _)| cell))
    }

    /// How many designs were simulated, where more will be.
    pub(super) fn n_simulated_of_many(&self) -> Result<Option<usize>> {
        let n = self.simulated()?.len();
        Ok((self.access()? == Access::Budget && (n as u64) < self.grid.n_cells()).then_some(n))
    }

    /// Whether what an experiment measured, in the mean of its runs, keeps to every bound.
    pub(super) fn keeps_to_bounds(&self, reading: &Reading) -> bool {
        self.problem.allows(|name| reading.mean_of(name))
    }

    /// Designs that gave a value, and are not thought to keep to a bound that was not measured there.
    fn doubtful(&self) -> &BTreeSet<Cell> {
        self.doubtful.get_or_init(|| {
            let is_incomplete = |constrained: &dyn Fn(&str) -> bool| {
                self.problem.constraints.iter().any(|held| !constrained(held.name()))
            };
            let imported = self.imported.iter().filter(|one| is_incomplete(&|name| one.constrained.contains_key(name)));
            let imported = imported.filter_map(|one| self.grid.nearest(&one.point).ok());
            let own =
                self.experiments.readings.iter().filter(|(_, one)| is_incomplete(&|name| one.mean_of(name).is_some()));
            let own = own.filter_map(|(&id, _)| self.experiments.trials.get(&id).map(|trial| trial.cell));
            let cells: BTreeSet<Cell> = imported.chain(own).collect();
            if cells.is_empty() {
                return cells;
            }
            let cells: Vec<Cell> = cells.into_iter().collect();
            let found = self.with_loop(|now, simulate| now.standings(&cells, simulate)).ok().flatten();
            let doubtful = found.unwrap_or_default().into_iter().filter(|there| {
                // Another run of the same settings may have measured it.
                self.problem.constraints.iter().zip(&there.constrained).any(|(held, one)| match one.measured {
                    Some(measured) => !held.constraint.allows(measured),
                    None => one.expected.is_some() && one.within < held.constraint.probability,
                })
            });
            doubtful.map(|there| there.cell).collect()
        })
    }

    /// Whether settings are not thought to keep to a bound that was not measured there.
    pub(super) fn is_doubtful(&self, settings: &[f64]) -> bool {
        self.grid.nearest(settings).is_ok_and(|cell| self.doubtful().contains(&cell))
    }

    /// Whether an experiment may be called the best measured: it keeps to every bound, as measured or else as expected.
    pub(super) fn may_be_best_measured(&self, id: u64, reading: &Reading) -> bool {
        let cell = self.experiments.trials.get(&id).map(|trial| trial.cell);
        self.keeps_to_bounds(reading) && !cell.is_some_and(|cell| self.doubtful().contains(&cell))
    }

    /// What the experiments of the batches up to this one cost, made in the order of their sheets, and for how many plants; none
    /// where nothing is hard to change.
    pub(super) fn spent_until(&self, batch: usize) -> Option<(f64, usize)> {
        let costs = self.problem.costs.as_ref()?;
        let in_order = (1..=batch).flat_map(|batch| self.experiments.in_run_order(batch, self.problem.seed));
        let made: Vec<Vec<f64>> =
            in_order.filter(|(trial, _)| self.experiments.has_result(trial.id)).map(|(trial, _)| trial.point).collect();
        let runs: Vec<&[f64]> = made.iter().map(Vec::as_slice).collect();
        Some(costs.of_runs(None, &runs))
    }

    /// That imported experiments which counted after a batch were withdrawn since.
    pub(super) fn withdrawn_since(&self, batch: usize) -> Option<String> {
        let since = self.withdrawn.iter().filter(|withdrawn| withdrawn.after >= batch);
        let since: Vec<String> = since
            .map(|Withdrawn { source, n, .. }| format!("{} of `{}`", count(*n, "experiment"), echo(source)))
            .collect();
        (!since.is_empty()).then(|| format!("what had been imported was withdrawn, {}", all_of(&since)))
    }

    /// How many experiments from before the campaign gave a value.
    pub(super) fn n_imported_values(&self) -> usize {
        self.imported.iter().filter(|one| one.result.value().is_some()).count()
    }

    /// All costs that were measured.
    pub(super) fn costs(&self) -> Vec<f64> {
        let response = &self.problem.response;
        let imported = self.imported.iter().filter_map(|one| one.result.value());
        let own = self.experiments.readings.values().flat_map(|reading| reading.values());
        imported.chain(own).map(|value| response.cost(value)).collect()
    }

    /// What all runs of equal settings tell of the noise, as far as `found` says which are repeats.
    pub(super) fn repeats(&self, found: &Assessment) -> Option<PureError> {
        PureError::of_readings(self.runs_to_compare(found))
    }

    /// The readings of the loop in its order, each with its settings and its cost. Where runs of a batch share an error, as the file says or as
    /// they drift, those of another batch are no repeats: what they are of stands behind the settings.
    pub(super) fn runs_to_compare(&self, found: &Assessment) -> Vec<(Vec<f64>, f64)> {
        let mut runs = self.runs();
        if self.settings.blocks == Some(true) || found.is_drifting() {
            let (origins, blocks) = (self.origins(), self.blocks());
            for (at, (settings, _)) in runs.iter_mut().enumerate() {
                let first_of_block = || blocks.iter().position(|block| *block == blocks[at]).unwrap_or(at);
                settings.push(match (origins[at], &blocks[at]) {
                    // Of a further run nobody knows the day.
                    (Origin::Own(_), Block::Source(_)) => at as f64,
                    _ => first_of_block() as f64,
                });
            }
        }
        runs
    }

    /// The readings of the loop in its order, each with its settings and its cost.
    pub(super) fn runs(&self) -> Vec<(Vec<f64>, f64)> {
        self.readings().into_iter().map(|(origin, cost)| (self.settings_of(origin), cost)).collect()
    }

    /// The block of each reading of the loop, in its order.
    pub(super) fn blocks(&self) -> Vec<Block> {
        let origins = self.origins();
        let firsts = self.experiments.readings.values().filter_map(|reading| reading.first.as_ref()?.value());
        let n_before = origins.len() - firsts.count();
        origins.into_iter().enumerate().map(|(at, origin)| self.block_of(origin, at < n_before)).collect()
    }

    /// Of what batch or source a run is; a further run of an experiment is a source of its own.
    pub(super) fn block_of(&self, origin: Origin, is_further: bool) -> Block {
        match origin {
            Origin::Imported(index) => Block::Source(self.imported[index].source.clone()),
            Origin::Own(id) if is_further => Block::Source(source_of_further(id)),
            Origin::Own(id) => Block::Batch(self.experiments.trial(id).map_or(0, |trial| trial.batch)),
        }
    }

    /// All runs that gave a value of a response that has to stay within bounds: their settings, as they were made, and the value.
    pub(super) fn runs_of(&self, constraint: &str) -> Vec<(Vec<f64>, f64)> {
        let imported =
            self.imported.iter().filter_map(|one| Some((one.point.clone(), *one.constrained.get(constraint)?)));
        let own = self.experiments.readings.iter().flat_map(|(&id, reading)| {
            let settings = self.experiments.settings_of(id);
            let values = reading.constrained.values().filter_map(|of_a_run| of_a_run.get(constraint));
            values.map(move |&value| (settings.clone(), value))
        });
        imported.chain(own).collect()
    }

    /// Lets the loop answer, with all that was told.
    pub(super) fn with_loop<T>(
        &self,
        read: impl FnOnce(&mut Loop, Option<&mut dyn Simulate>) -> Result<T, infuse::Error>,
    ) -> Result<T> {
        let access = self.access()?;
        let mut now = self.now.borrow_mut();
        let now = match now.as_mut() {
            Some(now) => now,
            None => now.insert(self.build(access)?),
        };
        if matches!(access, Access::Nothing | Access::Budget) {
            return Ok(read(now, None)?);
        }
        let response = &self.problem.response;
        let rows = self.rows()?;
        let remembered = |cell: Cell| match self.memory.get(&cell).map(|known| (&known.result, &known.constrained)) {
            Some((Measured::Value(value), constrained)) => {
                Ok(Responses { cost: response.cost(*value), constrained: self.problem.in_order(constrained) })
            }
            Some((Measured::Failed(reason), _)) => Err(reason.clone()),
            None => Err("it was never simulated".to_owned()),
        };
        let looked_up = |cell: Cell| {
            let row = rows.get(cell).ok_or_else(|| "no row".to_owned())?;
            Ok(Responses { cost: response.cost(row.value), constrained: row.constrained() })
        };
        let mut look_up = |cell: Cell, _: &[f64]| match access {
            Access::All => remembered(cell),
            _ => looked_up(cell),
        };
        Ok(read(now, Some(&mut look_up))?)
    }

    /// The loop with all that was told.
    fn build(&self, access: Access) -> Result<Loop> {
        let mut settings = self.settings.clone();
        // Whether to stop is decided here, where a person may go on all the same.
        settings.worth = None;
        settings.max_batches = 100_000;
        settings.simulations = match access {
            Access::Budget => Some(self.settings.simulations.unwrap_or(2)),
            Access::Nothing | Access::LookedUp | Access::All => None,
        };
        let mut now = Loop::new(&self.problem.region, settings)?;
        for batch in &self.batches {
            now.hand_out(&batch.cells)?;
        }
        for cell in self.refused() {
            now.refuse(cell)?;
        }
        let response = &self.problem.response;
        let responses = |value: f64, constrained: &Constrained| Responses {
            cost: response.cost(value),
            constrained: self.problem.in_order(constrained),
        };
        for imported in &self.imported {
            let source = imported.source.clone();
            match &imported.result {
                Measured::Value(value) => {
                    now.add_earlier(&imported.point, responses(*value, &imported.constrained), source)?;
                }
                Measured::Failed(reason) => now.add_earlier_failure(&imported.point, reason.clone(), source)?,
            }
        }
        for (&id, reading) in &self.experiments.readings {
            let none = Constrained::new();
            let of_run = |run: usize| reading.constrained.get(&run).unwrap_or(&none);
            for (&run, result) in &reading.again {
                if let Some(value) = result.value() {
                    let (settings, source) = (self.experiments.settings_of(id), source_of_further(id));
                    now.add_earlier(&settings, responses(value, of_run(run)), source)?;
                }
            }
            let outcome = match &reading.first {
                Some(Measured::Value(value)) => Outcome::Value(response.cost(*value)),
                Some(Measured::Failed(reason)) => Outcome::Failed { reason: reason.clone() },
                None => continue,
            };
            match reading.actual.is_empty() {
                true => now.tell(TrialId::new(id), outcome)?,
                false => now.tell_at(TrialId::new(id), &self.experiments.settings_of(id), outcome)?,
            }
            now.tell_constrained(TrialId::new(id), &self.problem.in_order(of_run(0)))?;
        }
        if access == Access::Budget {
            self.tell_simulations(&mut now)?;
        }
        Ok(now)
    }

    /// The experiments that the surface does without.
    pub(super) fn set_aside(&self, found: &Assessment) -> Vec<Origin> {
        let origins = self.origins();
        let aside = found.outliers.iter().filter(|outlier| outlier.set_aside);
        aside.filter_map(|outlier| origins.get(outlier.reading).copied()).collect()
    }

    /// Which experiment each reading of the loop is, in its order.
    pub(super) fn origins(&self) -> Vec<Origin> {
        self.readings().into_iter().map(|(origin, _)| origin).collect()
    }

    /// The readings of the loop in its order, each with its experiment and its cost.
    pub(super) fn readings(&self) -> Vec<(Origin, f64)> {
        let response = &self.problem.response;
        let read = |origin: Origin, result: &Measured| Some((origin, response.cost(result.value()?)));
        let imported = self.imported.iter().enumerate();
        let imported = imported.filter_map(|(index, one)| read(Origin::Imported(index), &one.result));
        let readings = &self.experiments.readings;
        let again = readings
            .iter()
            .flat_map(|(&id, reading)| reading.again.values().filter_map(move |result| read(Origin::Own(id), result)));
        let first = readings.iter().filter_map(|(&id, reading)| read(Origin::Own(id), reading.first.as_ref()?));
        imported.chain(again).chain(first).collect()
    }

    /// The settings of an experiment, as they were made.
    pub(super) fn settings_of(&self, origin: Origin) -> Vec<f64> {
        match origin {
            Origin::Imported(index) => self.imported[index].point.clone(),
            Origin::Own(id) => self.experiments.settings_of(id),
        }
    }

    /// What was simulated; of a table that has few designs, some rows.
    fn tell_simulations(&self, now: &mut Loop) -> Result<()> {
        let response = &self.problem.response;
        if let Simulator::Table(_) = self.problem.simulator {
            for (cell, cost) in some_rows(&self.simulated()?, &self.planned) {
                now.tell_simulation(cell, Ok(Responses { cost, constrained: self.simulated_constraints(cell)? }))?;
            }
            return Ok(());
        }
        let by = identity(&self.problem.simulator);
        for (&cell, known) in self.memory.iter().filter(|(_, known)| known.by == by) {
            let said = match &known.result {
                Measured::Value(value) => {
                    let constrained = self.problem.in_order(&known.constrained);
                    Ok(Responses { cost: response.cost(*value), constrained })
                }
                Measured::Failed(reason) => Err(reason.clone()),
            };
            now.tell_simulation(cell, said)?;
        }
        Ok(())
    }

    /// What the experiments so far come to; nothing before the first response.
    pub(super) fn assessment(&self) -> Result<Option<Assessment>> {
        if let Some(assessed) = self.assessed.get() {
            return Ok(assessed.clone());
        }
        let worth = self.settings.worth;
        let taking = busy(format!("fitting the surface to {}", count(self.costs().len(), "result")));
        let assessed = self.with_loop(|now, simulate| {
            let settings = Settings::clone(now.settings());
            let mut with_worth = settings.clone();
            with_worth.worth = worth;
            now.set_settings(with_worth)?;
            let found = now.assess(simulate);
            now.set_settings(settings)?;
            found
        });
        taking.finish_and_clear();
        let assessed = assessed?;
        Ok(self.assessed.get_or_init(|| assessed).clone())
    }
}

/// Where the loop is told that further runs of an experiment come from: of what day they are nobody knows.
fn source_of_further(id: u64) -> String {
    format!("experiment {id}")
}

/// Whether a simulation says more than one thing.
pub(super) fn tells_designs_apart(simulated: &[(Cell, f64)]) -> bool {
    simulated.windows(2).any(|pair| pair[0].1.to_bits() != pair[1].1.to_bits())
}

/// The linear constraints by what they say, where no design keeps to all of them.
fn by_constraints(problem: &Problem, error: Error) -> anyhow::Error {
    match error {
        Error::NoDesignAllowed { .. } => {
            let all = problem.linear_constraints.iter().map(|linear| linear_in_words(&problem.region, linear));
            let all = all.collect::<Vec<_>>().join("; ");
            anyhow!(
                "{PROBLEM}: [[linear_constraint]]: no design was found with {all}; expected some within the bounds of the parameters"
            )
        }
        other => other.into(),
    }
}

/// The best rows, those of planned cells, and others all over the table: at most 400.
fn some_rows(rows: &[(Cell, f64)], planned: &BTreeSet<Cell>) -> Vec<(Cell, f64)> {
    let mut order = rows.to_vec();
    if order.len() <= MOST_ROWS {
        return order;
    }
    order.sort_by(|a, b| {
        planned.contains(&b.0).cmp(&planned.contains(&a.0)).then(a.1.total_cmp(&b.1)).then(a.0.cmp(&b.0))
    });
    let mut chosen: Vec<(Cell, f64)> = order.drain(..MOST_ROWS / 2).collect();
    order.sort_by_key(|row| row.0);
    let stride = order.len().div_ceil(MOST_ROWS / 2);
    chosen.extend(order.into_iter().step_by(stride));
    chosen
}
