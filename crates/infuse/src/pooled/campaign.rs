//! A campaign of the pooled loop, as ask and tell.

use std::collections::BTreeSet;

use design_space::{Cell, Grid, Region};
use rand::RngExt;
use serde::{Deserialize, Serialize};

use crate::global::trial::{NEAR_THE_REGION, far_setting};
use crate::pooled::assessment::{Assessment, Expectation, Look, Standing, standing};
use crate::pooled::designs::Designs;
use crate::pooled::first_batch::{first_batch, spread};
use crate::pooled::knowledge::{Knowledge, Reading};
use crate::pooled::outliers::{Readings, set_aside, surprises};
use crate::pooled::pool::Pool;
use crate::pooled::settings::Settings;
use crate::pooled::simulated::{Emulator, Simulate, Simulated, Source};
use crate::pooled::streams::{Purpose, stream};
use crate::{Error, Outcome, TrialId};

/// An experiment to run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Trial {
    /// Number under which its outcome is reported.
    pub id: TrialId,
    /// Batch it belongs to, from 1.
    pub batch: usize,
    /// The cell.
    pub cell: Cell,
    /// Settings, natural coordinates.
    pub point: Vec<f64>,
}

/// A trial with what is known of it; `actual` holds the settings really made, natural.
pub type Record = crate::Record<Trial, Vec<f64>>;

/// An experiment that was made outside of the campaign.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Earlier {
    /// Its settings, natural; not necessarily on the grid.
    pub point: Vec<f64>,
    /// The response that it gave, or why it gave none.
    pub outcome: Outcome,
    /// Where it comes from, in the experimenter's own words.
    pub source: String,
}

/// What there is to do next.
#[derive(Debug, Clone, PartialEq)]
pub enum Ask {
    /// Run these, in any order, and tell the outcome of each. Either list may be empty, not both.
    Run {
        /// The experiments.
        trials: Vec<Trial>,
        /// Cells to simulate, where simulations are dear.
        simulations: Vec<Cell>,
    },
    /// Nothing: the campaign has ended.
    Stopped(StopReason),
}

/// Why a campaign has ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StopReason {
    /// All batches were run.
    MaxBatches,
    /// No design is better than the recommended one by more than another batch is worth, says the certificate.
    NotWorthIt,
}

/// Optimization by experiments, with all of them and the simulation in one surface.
///
/// All that it says follows from the readings, the simulated responses and the settings, in whatever order they came; nothing
/// is forgotten and nothing dropped for good.
#[derive(Debug, Clone)]
pub struct Loop {
    designs: Designs,
    settings: Settings,
    records: Vec<Record>,
    earlier: Vec<Earlier>,
    simulated: Simulated,
    /// Cells to simulate before the next batch.
    due: Vec<Cell>,
}

impl Loop {
    /// A campaign that has not begun, over this region.
    ///
    /// # Errors
    ///
    /// [`Error::DesignSpace`] for 2⁶⁴ designs or more, by levels alone, and those of [`Settings::validate`].
    pub fn new(region: &Region, settings: Settings) -> Result<Self, Error> {
        settings.validate()?;
        let (records, earlier, due) = (Vec::new(), Vec::new(), Vec::new());
        Ok(Self { designs: Designs::of(region)?, settings, records, earlier, simulated: Simulated::default(), due })
    }

    /// The settings.
    #[must_use]
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Goes on with other settings from the next batch on.
    ///
    /// # Errors
    ///
    /// Those of [`Settings::validate`]; the settings are then as before.
    pub fn set_settings(&mut self, settings: Settings) -> Result<(), Error> {
        settings.validate()?;
        self.settings = settings;
        Ok(())
    }

    /// The parameters.
    #[must_use]
    pub fn region(&self) -> &Region {
        self.designs.region()
    }

    /// The designs: every combination of levels, a continuous parameter having 1001 of them, or as many fewer as it takes to
    /// count the designs.
    #[must_use]
    pub fn grid(&self) -> &Grid {
        self.designs.grid()
    }

    /// Every trial so far, with its outcome if there is one.
    #[must_use]
    pub fn records(&self) -> &[Record] {
        &self.records
    }

    /// The experiments made outside of the campaign.
    #[must_use]
    pub fn earlier(&self) -> &[Earlier] {
        &self.earlier
    }

    /// Number of cells that were simulated.
    #[must_use]
    pub fn n_simulated(&self) -> usize {
        self.simulated.len()
    }

    /// The trials without an outcome.
    #[must_use]
    pub fn outstanding(&self) -> Vec<Trial> {
        self.records.iter().filter(|record| record.outcome.is_none()).map(|record| record.trial.clone()).collect()
    }

    /// Number of the last batch, 0 before the first.
    #[must_use]
    pub fn batch(&self) -> usize {
        self.records.last().map_or(0, |record| record.trial.batch)
    }

    /// What to run now: what is outstanding, or else a new batch.
    ///
    /// `simulate` is for a cheap simulation and is called wherever the loop likes, each cell once. Where simulations are dear
    /// ([`Settings::simulations`]) it is not called: their cells are handed out with the trials, the first ones ahead of them.
    ///
    /// # Errors
    ///
    /// [`Error::Surface`] if the responses cannot be fitted. The state is then as before.
    pub fn ask(&mut self, simulate: Option<&mut Simulate<'_>>) -> Result<Ask, Error> {
        let trials = self.outstanding();
        if trials.is_empty() && self.due.is_empty() {
            return self.ask_more(simulate);
        }
        Ok(Ask::Run { trials, simulations: self.due.clone() })
    }

    /// A new batch, whether or not there are outstanding trials: those count as if they had given what is expected of them.
    /// Hands out all that is outstanding, the new trials last.
    ///
    /// # Errors
    ///
    /// Those of [`ask`](Self::ask).
    pub fn ask_more(&mut self, simulate: Option<&mut Simulate<'_>>) -> Result<Ask, Error> {
        let batch = self.batch();
        if batch >= self.settings.max_batches {
            return Ok(Ask::Stopped(StopReason::MaxBatches));
        }
        if self.needs_first_simulations() {
            let mut rng = stream(self.settings.seed, Purpose::Simulations, 0);
            self.due = spread(&self.designs, self.settings.simulations.unwrap_or(0), rng.random());
            self.due.sort_unstable();
            self.due.dedup();
            return Ok(Ask::Run { trials: self.outstanding(), simulations: self.due.clone() });
        }
        let (readings, failed) = (self.readings()?, self.failed_cells()?);
        let (settings, designs) = (&self.settings, &self.designs);
        let mut source = source(settings, designs, &self.simulated, simulate)?;
        // Too few to tell even a plane from its noise.
        let (cells, due) = if readings.len() < designs.n_factors() + 2 {
            let simulated = &mut self.simulated;
            let mut tested = failed;
            tested.extend(readings.iter().map(|reading| reading.cell).chain(pending_cells(&self.records)));
            let cells = first_batch(designs, settings, &tested, simulated, &mut source)?;
            let due = cells.iter().copied().filter(|&cell| settings.simulations.is_some() && !simulated.contains(cell));
            let due: Vec<Cell> = due.collect();
            (cells, due)
        } else {
            let pending = pending_cells(&self.records);
            let simulated = &mut self.simulated;
            let (mut knowledge, readings) = learnt(readings, &failed, designs, settings, simulated, source)?;
            let look = Look::at(&mut knowledge, &readings, settings, batch)?;
            if settings.worth.is_some_and(|worth| look.assessment.certificate.bound <= worth) {
                return Ok(Ask::Stopped(StopReason::NotWorthIt));
            }
            let cells = look.picks(&knowledge, settings, &pending, batch).cells;
            let due = match settings.simulations {
                Some(budget) => simulations_of_a_batch(&knowledge, &look.pool, &cells, budget)?,
                None => Vec::new(),
            };
            (cells, due)
        };
        self.due.extend(due);
        self.due.sort_unstable();
        self.due.dedup();
        self.hand_out(&cells)?;
        Ok(Ask::Run { trials: self.outstanding(), simulations: self.due.clone() })
    }

    /// New trials at these cells, as one more batch: for experiments that the experimenter wants.
    ///
    /// # Errors
    ///
    /// [`Error::DesignSpace`] for a cell that does not exist; the state is then as before.
    pub fn hand_out(&mut self, cells: &[Cell]) -> Result<Vec<Trial>, Error> {
        let points = cells.iter().map(|&cell| self.designs.grid().point(cell)).collect::<Result<Vec<_>, _>>()?;
        let (batch, first) = (self.batch() + 1, self.records.len() as u64 + 1);
        let ids = (first..).map(TrialId::new);
        let trials: Vec<Trial> =
            ids.zip(cells.iter().zip(points)).map(|(id, (&cell, point))| Trial { id, batch, cell, point }).collect();
        self.records.extend(trials.iter().map(|trial| Record { trial: trial.clone(), actual: None, outcome: None }));
        Ok(trials)
    }

    /// The outcome of an outstanding trial, at the settings asked for.
    ///
    /// # Errors
    ///
    /// [`Error::UnknownTrial`], [`Error::AlreadyTold`], [`Error::NonFiniteOutcome`]. The state is then as before.
    pub fn tell(&mut self, id: TrialId, outcome: Outcome) -> Result<(), Error> {
        self.record(id, None, outcome, false)
    }

    /// The outcome of an outstanding trial at other settings than those asked for: all parameters, natural. They may be off the
    /// grid, and outside of the region by up to half a parameter's width.
    ///
    /// # Errors
    ///
    /// Those of [`tell`](Self::tell), [`Error::DesignSpace`] for a wrong number of settings, [`Error::ActualSettingOf`].
    pub fn tell_at(&mut self, id: TrialId, actual: &[f64], outcome: Outcome) -> Result<(), Error> {
        self.record(id, Some(actual.to_vec()), outcome, false)
    }

    /// Another outcome for a trial that had one: it was misread.
    ///
    /// # Errors
    ///
    /// Those of [`tell_at`](Self::tell_at), but for [`Error::AlreadyTold`].
    pub fn correct(&mut self, id: TrialId, actual: Option<&[f64]>, outcome: Outcome) -> Result<(), Error> {
        self.record(id, actual.map(<[f64]>::to_vec), outcome, true)
    }

    /// The outcome of a simulation, handed out or not.
    ///
    /// # Errors
    ///
    /// [`Error::DesignSpace`] for a cell that does not exist.
    pub fn tell_simulation(&mut self, cell: Cell, outcome: &Outcome) -> Result<(), Error> {
        self.designs.grid().digits(cell)?;
        self.simulated.insert(cell, outcome);
        self.due.retain(|&due| due != cell);
        Ok(())
    }

    /// Forgets every simulation: the simulator was changed.
    pub fn forget_simulations(&mut self) {
        self.simulated = Simulated::default();
        self.due.clear();
    }

    /// An experiment made outside of the campaign, at these natural settings: it counts as much as any other.
    ///
    /// # Errors
    ///
    /// [`Error::DesignSpace`] for a wrong number of settings, [`Error::EarlierSetting`] for one more than half a parameter's
    /// width outside of its bounds, [`Error::Setting`] for a response that is not finite or beyond 1e100.
    pub fn add_earlier(&mut self, point: &[f64], response: f64, source: impl Into<String>) -> Result<(), Error> {
        self.check_earlier(point)?;
        if response.is_nan() || response.abs() > surface::Data::LARGEST {
            let expected = "a response of at most 1e100 in magnitude";
            return Err(Error::Setting { name: "response", value: response, expected });
        }
        self.earlier.push(Earlier { point: point.to_vec(), outcome: Outcome::Value(response), source: source.into() });
        Ok(())
    }

    /// An experiment made outside of the campaign that gave no response: it tells where others may fail.
    ///
    /// # Errors
    ///
    /// [`Error::DesignSpace`] for a wrong number of settings, [`Error::EarlierSetting`] for one more than half a parameter's
    /// width outside of its bounds.
    pub fn add_earlier_failure(
        &mut self,
        point: &[f64],
        reason: impl Into<String>,
        source: impl Into<String>,
    ) -> Result<(), Error> {
        self.check_earlier(point)?;
        let outcome = Outcome::Failed { reason: reason.into() };
        self.earlier.push(Earlier { point: point.to_vec(), outcome, source: source.into() });
        Ok(())
    }

    fn check_earlier(&self, point: &[f64]) -> Result<(), Error> {
        match far_setting(point, self.region())? {
            Some((parameter, value)) => Err(Error::EarlierSetting { parameter, value, expected: NEAR_THE_REGION }),
            None => Ok(()),
        }
    }

    /// Takes back the [earlier](Self::add_earlier) experiments from this source. How many there were.
    pub fn withdraw_earlier(&mut self, source: &str) -> usize {
        let before = self.earlier.len();
        self.earlier.retain(|earlier| earlier.source != source);
        before - self.earlier.len()
    }

    /// What the experiments so far come to; nothing before the first response.
    ///
    /// # Errors
    ///
    /// [`Error::Surface`] if the responses cannot be fitted.
    pub fn assess(&mut self, simulate: Option<&mut Simulate<'_>>) -> Result<Option<Assessment>, Error> {
        let pending = pending_cells(&self.records);
        self.with_knowledge(simulate, |knowledge, readings, settings, batch| {
            Ok(Look::at(knowledge, readings, settings, batch)?.with_prospect(knowledge, settings, &pending, batch))
        })
    }

    /// What is known of these designs, beside the recommended one; nothing before the first response.
    ///
    /// # Errors
    ///
    /// [`Error::Surface`] if the responses cannot be fitted, [`Error::DesignSpace`] for a cell that does not exist.
    pub fn standings(
        &mut self,
        cells: &[Cell],
        simulate: Option<&mut Simulate<'_>>,
    ) -> Result<Option<Vec<Standing>>, Error> {
        self.with_knowledge(simulate, |knowledge, readings, settings, batch| {
            let pool = Pool::gather(knowledge, settings.seed, batch)?;
            let recommended = crate::pooled::recommendation::lowest_mean(knowledge, &pool)?;
            cells
                .iter()
                .map(|&cell| standing(knowledge, &readings.kept, cell, recommended, settings.confidence))
                .collect::<Result<Vec<_>, _>>()
        })
    }

    /// What is expected at these designs, all at once; nothing before the first response.
    ///
    /// # Errors
    ///
    /// Those of [`standings`](Self::standings).
    pub fn expectations(
        &mut self,
        cells: &[Cell],
        simulate: Option<&mut Simulate<'_>>,
    ) -> Result<Option<Vec<Expectation>>, Error> {
        self.with_knowledge(simulate, |knowledge, _, _, _| {
            let places = knowledge.places(cells)?;
            let (marginals, feasible) = (knowledge.marginals(&places), knowledge.feasible(cells, &places));
            let pairs = marginals.means.into_iter().zip(marginals.variances).zip(feasible);
            let expectation = |((mean, variance), feasible): ((f64, f64), f64)| Expectation {
                mean,
                deviation: variance.sqrt(),
                feasible,
            };
            Ok(pairs.map(expectation).collect())
        })
    }

    /// How far each reading is from what all others say of its settings, in standard deviations; those of
    /// [earlier](Self::earlier) experiments first, then those of the trials in their order. Nothing before the first response.
    ///
    /// # Errors
    ///
    /// [`Error::Surface`] if the responses cannot be fitted.
    pub fn surprises(&mut self, simulate: Option<&mut Simulate<'_>>) -> Result<Option<Vec<f64>>, Error> {
        let n = self.readings()?.len();
        self.with_knowledge(simulate, |knowledge, readings, _, _| {
            let mut all = vec![0.0; n];
            for (reading, surprise) in readings.kept.iter().zip(surprises(knowledge, &readings.kept)) {
                all[reading.number] = surprise;
            }
            for outlier in &readings.set_aside {
                all[outlier.reading] = outlier.deviations;
            }
            Ok(all)
        })
    }

    fn with_knowledge<T>(
        &mut self,
        simulate: Option<&mut Simulate<'_>>,
        read: impl FnOnce(&mut Knowledge<'_, '_>, &Readings, &Settings, usize) -> Result<T, Error>,
    ) -> Result<Option<T>, Error> {
        let readings = self.readings()?;
        if readings.is_empty() {
            return Ok(None);
        }
        let (batch, failed) = (self.batch(), self.failed_cells()?);
        let (settings, designs) = (&self.settings, &self.designs);
        let source = source(settings, designs, &self.simulated, simulate)?;
        let (mut knowledge, readings) = learnt(readings, &failed, designs, settings, &mut self.simulated, source)?;
        read(&mut knowledge, &readings, settings, batch).map(Some)
    }

    /// Asks and tells until the campaign ends, with experiments and simulations that answer at once.
    ///
    /// # Errors
    ///
    /// Those of [`ask`](Self::ask) and [`tell`](Self::tell).
    pub fn run(
        &mut self,
        simulate: &mut Simulate<'_>,
        experiment: &mut impl FnMut(&Trial) -> Result<f64, String>,
    ) -> Result<StopReason, Error> {
        loop {
            let (trials, simulations) = match self.ask(Some(&mut *simulate))? {
                Ask::Stopped(reason) => return Ok(reason),
                Ask::Run { trials, simulations } => (trials, simulations),
            };
            self.simulated.run(&self.designs, &simulations, &mut *simulate)?;
            self.due.retain(|&due| !self.simulated.contains(due));
            for trial in trials {
                self.tell(trial.id, experiment(&trial).into())?;
            }
        }
    }

    /// Whether simulations are dear and none was run yet.
    fn needs_first_simulations(&self) -> bool {
        self.settings.simulations.is_some_and(|budget| budget > 0) && self.simulated.len() == 0 && self.due.is_empty()
    }

    fn record(&mut self, id: TrialId, actual: Option<Vec<f64>>, outcome: Outcome, again: bool) -> Result<(), Error> {
        let position =
            self.records.iter().position(|record| record.trial.id == id).ok_or(Error::UnknownTrial { id })?;
        if self.records[position].outcome.is_some() != again {
            return Err(if again { Error::UnknownTrial { id } } else { Error::AlreadyTold { id } });
        }
        if let Some(value) = outcome.cost().filter(|value| value.is_nan() || value.abs() > surface::Data::LARGEST) {
            return Err(Error::NonFiniteOutcome { id, value });
        }
        if let Some(actual) = &actual
            && let Some((parameter, actual)) = far_setting(actual, self.region())?
        {
            return Err(Error::ActualSettingOf { id, parameter, actual, expected: NEAR_THE_REGION });
        }
        let record = &mut self.records[position];
        (record.actual, record.outcome) = (actual, Some(outcome));
        Ok(())
    }

    /// All responses: earlier ones first, then those of the trials in their order.
    fn readings(&self) -> Result<Vec<Reading>, Error> {
        let measured = |earlier: &Earlier| Some(self.reading(&earlier.point, earlier.outcome.cost()?));
        let earlier = self.earlier.iter().filter_map(measured);
        let measured = self.records.iter().filter_map(|record| record.cost().map(|response| (record, response)));
        let own = measured.map(|(record, response)| match &record.actual {
            Some(actual) => self.reading(actual, response),
            None => {
                let cell = record.trial.cell;
                Ok(Reading { coded: self.designs.grid().coded(cell)?, cell, response, number: 0 })
            }
        });
        let numbered = |(number, reading): (usize, Result<Reading, Error>)| Ok(Reading { number, ..reading? });
        earlier.chain(own).enumerate().map(numbered).collect()
    }

    /// Where an experiment failed: at the settings really made, as far as they are known.
    fn failed_cells(&self) -> Result<BTreeSet<Cell>, Error> {
        let nearest = |point: &[f64]| Ok(self.designs.grid().nearest(&self.region().clamp(point)?)?);
        let earlier = self.earlier.iter().filter(|earlier| earlier.outcome.cost().is_none());
        let own = self.records.iter().filter(|record| record.is_failed()).map(|record| match &record.actual {
            Some(actual) => nearest(actual),
            None => Ok(record.trial.cell),
        });
        earlier.map(|earlier| nearest(&earlier.point)).chain(own).collect()
    }

    /// A response at natural settings, on the grid or off it.
    fn reading(&self, point: &[f64], response: f64) -> Result<Reading, Error> {
        let cell = self.designs.grid().nearest(&self.region().clamp(point)?)?;
        let (on_grid, here) = (self.designs.grid().coded(cell)?, self.region().coded(point)?);
        // Settings of the grid, however they were written, are those of the grid.
        let same = on_grid.iter().zip(&here).all(|(a, b)| (a - b).abs() < 1e-9);
        Ok(Reading { coded: if same { on_grid } else { here }, cell, response, number: 0 })
    }
}

/// What follows from readings, but for those that are set aside.
fn learnt<'a, 'b>(
    mut readings: Vec<Reading>,
    failed: &BTreeSet<Cell>,
    designs: &'a Designs,
    settings: &Settings,
    simulated: &'a mut Simulated,
    source: Source<'a, 'b>,
) -> Result<(Knowledge<'a, 'b>, Readings), Error> {
    let mut knowledge = Knowledge::of(&readings, failed, designs, settings, simulated, source)?;
    let set_aside = set_aside(&mut knowledge, &mut readings, settings)?;
    if !set_aside.is_empty() {
        knowledge = knowledge.through(&readings, failed, settings)?;
    }
    Ok((knowledge, Readings { kept: readings, set_aside }))
}

/// Where simulated responses come from.
fn source<'a, 'b>(
    settings: &Settings,
    designs: &Designs,
    simulated: &Simulated,
    simulate: Option<&'a mut Simulate<'b>>,
) -> Result<Source<'a, 'b>, Error> {
    Ok(match (settings.simulations, simulate) {
        (Some(_), _) => Emulator::of(simulated, designs, settings.seed)?.map_or(Source::Nothing, Source::Emulated),
        (None, Some(simulate)) => Source::Cheap(simulate),
        (None, None) => Source::Nothing,
    })
}

/// What a batch simulates: its own cells, and as many promising ones as the budget allows, where the emulator knows least.
fn simulations_of_a_batch(
    knowledge: &Knowledge<'_, '_>,
    pool: &Pool,
    cells: &[Cell],
    budget: usize,
) -> Result<Vec<Cell>, Error> {
    let mut due: Vec<Cell> = cells.iter().copied().filter(|&cell| !knowledge.simulated.contains(cell)).collect();
    due.sort_unstable();
    due.dedup();
    let new = pool.cells.iter().copied().filter(|cell| !knowledge.simulated.contains(*cell) && !due.contains(cell));
    let new: Vec<Cell> = new.collect();
    due.extend(knowledge.least_simulated(&new, budget.saturating_sub(due.len()))?);
    Ok(due)
}

fn pending_cells(records: &[Record]) -> Vec<Cell> {
    records.iter().filter(|record| record.outcome.is_none()).map(|record| record.trial.cell).collect()
}
