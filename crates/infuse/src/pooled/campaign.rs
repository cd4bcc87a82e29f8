//! A campaign of the pooled loop, as ask and tell.

use std::collections::{BTreeMap, BTreeSet};

use design_space::{Cell, Grid, Region};
use rand::RngExt;
use serde::{Deserialize, Serialize};

use crate::global::trial::{NEAR_THE_REGION, far_setting};
use crate::pooled::assessment::{Assessment, Constrained, Expectation, Look, Standing, constrained_at, standing};
use crate::pooled::designs::Designs;
use crate::pooled::first_batch::{first_batch, spread};
use crate::pooled::knowledge::Knowledge;
use crate::pooled::measurements::{Measurements, Reading};
use crate::pooled::outliers::{Readings, set_aside, surprises};
use crate::pooled::plants::Assemblies;
use crate::pooled::pool::Pool;
use crate::pooled::recommendation::lowest_mean;
use crate::pooled::settings::Settings;
use crate::pooled::simulated::{Emulator, Responses, Simulate, Simulated, Source};
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
    /// Its constrained responses, in the order of the constraints, as far as they were measured.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub constrained: Vec<Option<f64>>,
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
    /// The constrained responses of trials, as far as they were measured.
    constrained: BTreeMap<TrialId, Vec<Option<f64>>>,
    /// Designs that nobody can build.
    refused: BTreeSet<Cell>,
}

impl Loop {
    /// A campaign that has not begun, over this region.
    ///
    /// # Errors
    ///
    /// [`Error::DesignSpace`] for 2⁶⁴ designs or more, by levels alone, [`Error::NoDesignAllowed`], and those of
    /// [`Settings::validate`].
    pub fn new(region: &Region, settings: Settings) -> Result<Self, Error> {
        settings.validate()?;
        check_plants(&settings, region)?;
        let mut rng = stream(settings.seed, Purpose::Designs, 0);
        Ok(Self {
            designs: Designs::of(region, &settings.linear_constraints, &mut rng)?,
            settings,
            records: Vec::new(),
            earlier: Vec::new(),
            simulated: Simulated::default(),
            due: Vec::new(),
            constrained: BTreeMap::new(),
            refused: BTreeSet::new(),
        })
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
    /// Those of [`Settings::validate`], [`Error::NoDesignAllowed`]; the settings are then as before.
    pub fn set_settings(&mut self, settings: Settings) -> Result<(), Error> {
        settings.validate()?;
        check_plants(&settings, self.region())?;
        if settings.linear_constraints != self.settings.linear_constraints {
            let mut rng = stream(settings.seed, Purpose::Designs, 0);
            self.designs.keep_to(&settings.linear_constraints, &mut rng)?;
        }
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
    pub fn ask(&mut self, simulate: Option<&mut dyn Simulate>) -> Result<Ask, Error> {
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
    pub fn ask_more(&mut self, simulate: Option<&mut dyn Simulate>) -> Result<Ask, Error> {
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
        let measurements = self.measurements()?;
        let (settings, designs) = (&self.settings, &self.designs);
        let mut source = source(settings, designs, &self.simulated, simulate)?;
        // Too few to tell even a plane from its noise.
        let (cells, due) = if measurements.readings.len() < designs.n_factors() + 2 {
            let simulated = &mut self.simulated;
            let Measurements { readings, failed: mut tested, .. } = measurements;
            tested.extend(readings.iter().map(|reading| reading.cell).chain(pending_cells(&self.records)));
            let cells = first_batch(designs, settings, &tested, simulated, &mut source)?;
            let due = cells.iter().copied().filter(|&cell| settings.simulations.is_some() && !simulated.contains(cell));
            let due: Vec<Cell> = due.collect();
            (cells, due)
        } else {
            let pending = pending_cells(&self.records);
            let simulated = &mut self.simulated;
            let (mut knowledge, readings) = learnt(measurements, designs, settings, simulated, source)?;
            let look = Look::at(&mut knowledge, &readings, settings, batch)?;
            if settings.worth.is_some_and(|worth| look.assessment.certificate.bound <= worth) {
                return Ok(Ask::Stopped(StopReason::NotWorthIt));
            }
            let cells = look.picks(&mut knowledge, settings, &pending, batch)?.cells;
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
        self.simulated.insert(cell, outcome.cost().map(Responses::from));
        self.due.retain(|&due| due != cell);
        Ok(())
    }

    /// The responses of a simulation, the constrained ones among them, handed out or not.
    ///
    /// # Errors
    ///
    /// [`Error::DesignSpace`] for a cell that does not exist, [`Error::WrongLength`] for more values than constraints.
    pub fn tell_simulated(&mut self, cell: Cell, responses: Responses) -> Result<(), Error> {
        self.designs.grid().digits(cell)?;
        self.check_constrained(&responses.constrained)?;
        self.simulated.insert(cell, Some(responses));
        self.due.retain(|&due| due != cell);
        Ok(())
    }

    /// The constrained responses of a trial, in the order of the [constraints](Settings::constraints), none where one was not
    /// measured. Before or after its [outcome](Self::tell), and as often as there is something to put right.
    ///
    /// # Errors
    ///
    /// [`Error::UnknownTrial`], [`Error::WrongLength`] for more values than constraints, [`Error::ConstrainedValue`]. The state
    /// is then as before.
    pub fn tell_constrained(&mut self, id: TrialId, values: &[Option<f64>]) -> Result<(), Error> {
        if !self.records.iter().any(|record| record.trial.id == id) {
            return Err(Error::UnknownTrial { id });
        }
        self.check_constrained(values)?;
        let unusable = |value: &f64| value.is_nan() || value.abs() > surface::Data::LARGEST;
        for (constraint, value) in self.settings.constraints.iter().zip(values) {
            if let Some(value) = value.filter(unusable) {
                return Err(Error::ConstrainedValue { id, constraint: constraint.name.clone(), value });
            }
        }
        self.constrained.insert(id, values.to_vec());
        Ok(())
    }

    /// The constrained responses of a trial, in the order of the constraints, as far as they were measured.
    #[must_use]
    pub fn constrained(&self, id: TrialId) -> &[Option<f64>] {
        self.constrained.get(&id).map_or(&[], Vec::as_slice)
    }

    fn check_constrained(&self, values: &[Option<f64>]) -> Result<(), Error> {
        let (expected, found) = (self.settings.constraints.len(), values.len());
        if found <= expected { Ok(()) } else { Err(Error::WrongLength { name: "constrained", expected, found }) }
    }

    /// A design that nobody can build, whatever was measured there: it is neither asked for nor recommended, and its neighbors are
    /// suspected. Trials of it that
    /// are outstanding stay.
    ///
    /// # Errors
    ///
    /// [`Error::DesignSpace`] for a cell that does not exist.
    pub fn refuse(&mut self, cell: Cell) -> Result<(), Error> {
        self.designs.grid().digits(cell)?;
        self.refused.insert(cell);
        Ok(())
    }

    /// Whether a cell keeps to the linear constraints, and was not refused.
    #[must_use]
    pub fn allows(&self, cell: Cell) -> bool {
        self.designs.allows(cell) && !self.refused.contains(&cell)
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
    /// width outside of its bounds, [`Error::Setting`] for a response that is not finite or beyond 1e100,
    /// [`Error::WrongLength`] for more constrained responses than constraints.
    pub fn add_earlier(
        &mut self,
        point: &[f64],
        responses: impl Into<Responses>,
        source: impl Into<String>,
    ) -> Result<(), Error> {
        self.check_earlier(point)?;
        let Responses { objective, constrained } = responses.into();
        self.check_constrained(&constrained)?;
        let values = constrained.iter().flatten().chain([&objective]);
        if let Some(&value) = values.into_iter().find(|value| value.is_nan() || value.abs() > surface::Data::LARGEST) {
            let expected = "a response of at most 1e100 in magnitude";
            return Err(Error::Setting { name: "response", value, expected });
        }
        let (point, outcome) = (point.to_vec(), Outcome::Value(objective));
        self.earlier.push(Earlier { point, outcome, constrained, source: source.into() });
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
        let (point, constrained) = (point.to_vec(), Vec::new());
        self.earlier.push(Earlier { point, outcome, constrained, source: source.into() });
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
    pub fn assess(&mut self, simulate: Option<&mut dyn Simulate>) -> Result<Option<Assessment>, Error> {
        let pending = pending_cells(&self.records);
        self.with_knowledge(simulate, |knowledge, readings, settings, batch| {
            Look::at(knowledge, readings, settings, batch)?.with_prospect(knowledge, settings, &pending, batch)
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
        simulate: Option<&mut dyn Simulate>,
    ) -> Result<Option<Vec<Standing>>, Error> {
        self.with_knowledge(simulate, |knowledge, readings, settings, batch| {
            let pool = Pool::gather(knowledge, settings.seed, batch)?;
            let recommended = lowest_mean(knowledge, &pool, settings.seed, batch)?;
            let constrained = &readings.constrained;
            cells
                .iter()
                .map(|&cell| standing(knowledge, &readings.kept, constrained, cell, recommended, settings.confidence))
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
        simulate: Option<&mut dyn Simulate>,
    ) -> Result<Option<Vec<Expectation>>, Error> {
        self.with_knowledge(simulate, |knowledge, _, _, _| {
            let places = knowledge.places(cells)?;
            let (marginals, chances) = (knowledge.marginals(&places), knowledge.chances(cells, &places)?);
            let pairs = marginals.means.into_iter().zip(marginals.variances).zip(chances.responding);
            let pairs = pairs.zip(constrained_at(knowledge, cells)?);
            let expectation = |(((mean, variance), feasible), constrained): (((f64, f64), f64), Vec<Constrained>)| {
                Expectation { mean, deviation: variance.sqrt(), feasible, constrained }
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
    pub fn surprises(&mut self, simulate: Option<&mut dyn Simulate>) -> Result<Option<Vec<f64>>, Error> {
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
        simulate: Option<&mut dyn Simulate>,
        read: impl FnOnce(&mut Knowledge<'_, '_>, &Readings, &Settings, usize) -> Result<T, Error>,
    ) -> Result<Option<T>, Error> {
        let measurements = self.measurements()?;
        if measurements.readings.is_empty() {
            return Ok(None);
        }
        let batch = self.batch();
        let (settings, designs) = (&self.settings, &self.designs);
        let source = source(settings, designs, &self.simulated, simulate)?;
        let (mut knowledge, readings) = learnt(measurements, designs, settings, &mut self.simulated, source)?;
        read(&mut knowledge, &readings, settings, batch).map(Some)
    }

    /// Asks and tells until the campaign ends, with experiments and simulations that answer at once.
    ///
    /// # Errors
    ///
    /// Those of [`ask`](Self::ask) and [`tell`](Self::tell).
    pub fn run(
        &mut self,
        simulate: &mut dyn Simulate,
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
                Ok(Reading { coded: self.designs.coded_of(cell)?, cell, response, number: 0, assembly: None })
            }
        });
        let numbered = |(number, reading): (usize, Result<Reading, Error>)| Ok(Reading { number, ..reading? });
        let mut readings: Vec<Reading> = earlier.chain(own).enumerate().map(numbered).collect::<Result<_, Error>>()?;
        let batches = self.records.iter().filter(|record| record.cost().is_some()).map(|record| record.trial.batch);
        self.assemble(&mut readings, batches.collect());
        Ok(readings)
    }

    /// Says which readings share an error: those of one plant in one batch, of which these are the batches; what was made before
    /// stands alone.
    fn assemble(&self, readings: &mut [Reading], batches: Vec<usize>) {
        let Some(plants) = &self.settings.plants else { return };
        let mut assemblies = Assemblies::default();
        let n_earlier = readings.len() - batches.len();
        let batches = std::iter::repeat_n(None, n_earlier).chain(batches.into_iter().map(Some));
        for (reading, batch) in readings.iter_mut().zip(batches) {
            reading.assembly = Some(match batch {
                Some(batch) => assemblies.of(batch, plants.of(&self.designs, reading.cell)),
                None => assemblies.alone(),
            });
        }
    }

    /// All that was measured.
    fn measurements(&self) -> Result<Measurements, Error> {
        let mut failed = self.failed_cells()?;
        failed.extend(&self.refused);
        let constrained = (0..self.settings.constraints.len()).map(|index| self.constrained_readings(index));
        let (constrained, refused) = (constrained.collect::<Result<_, _>>()?, self.refused.clone());
        Ok(Measurements { readings: self.readings()?, constrained, failed, refused })
    }

    /// All readings of a constrained response: earlier ones first.
    fn constrained_readings(&self, index: usize) -> Result<Vec<Reading>, Error> {
        let value = |values: &[Option<f64>]| values.get(index).copied().flatten();
        let earlier = self.earlier.iter().filter_map(|one| Some(self.reading(&one.point, value(&one.constrained)?)));
        let own = self.records.iter().filter_map(|record| {
            let response = value(self.constrained(record.trial.id))?;
            Some(self.reading(record.actual.as_ref().unwrap_or(&record.trial.point), response))
        });
        let numbered = |(number, reading): (usize, Result<Reading, Error>)| Ok(Reading { number, ..reading? });
        let mut readings: Vec<Reading> = earlier.chain(own).enumerate().map(numbered).collect::<Result<_, Error>>()?;
        let measured = self.records.iter().filter(|record| value(self.constrained(record.trial.id)).is_some());
        self.assemble(&mut readings, measured.map(|record| record.trial.batch).collect());
        Ok(readings)
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
        let (on_grid, here) = (self.designs.coded_of(cell)?, self.designs.coded_point(point)?);
        // Settings of the grid, however they were written, are those of the grid.
        let same = on_grid.iter().zip(&here).all(|(a, b)| (a - b).abs() < 1e-9);
        Ok(Reading { coded: if same { on_grid } else { here }, cell, response, number: 0, assembly: None })
    }
}

/// Whether the parameters of the plant are there.
fn check_plants(settings: &Settings, region: &Region) -> Result<(), Error> {
    let n = region.n_parameters();
    let wrong = settings.plants.iter().flat_map(|plants| &plants.parameters).find(|&&parameter| parameter >= n);
    match wrong {
        Some(&parameter) => Err(Error::Constraint {
            constraint: "plants".to_owned(),
            field: "parameters",
            value: parameter as f64,
            expected: "places of parameters in the region, from 0",
        }),
        None => Ok(()),
    }
}

/// What follows from readings, but for those that are set aside.
fn learnt<'a, 's>(
    mut measurements: Measurements,
    designs: &'a Designs,
    settings: &Settings,
    simulated: &'a mut Simulated,
    source: Source<'s>,
) -> Result<(Knowledge<'a, 's>, Readings), Error> {
    let mut knowledge = Knowledge::of(&measurements, designs, settings, simulated, source)?;
    let set_aside = set_aside(&mut knowledge, &mut measurements.readings, settings)?;
    if !set_aside.is_empty() {
        knowledge = knowledge.through(&measurements, settings)?;
    }
    let Measurements { readings: kept, constrained, .. } = measurements;
    Ok((knowledge, Readings { kept, constrained, set_aside }))
}

/// Where simulated responses come from.
fn source<'a>(
    settings: &Settings,
    designs: &Designs,
    simulated: &Simulated,
    simulate: Option<&'a mut dyn Simulate>,
) -> Result<Source<'a>, Error> {
    Ok(match (settings.simulations, simulate) {
        (Some(_), _) => Emulator::of(simulated, designs, settings)?.map_or(Source::Nothing, Source::Emulated),
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
