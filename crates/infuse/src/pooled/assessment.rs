//! What the experiments so far come to: the recommended design, how far it may be from the best, and what speaks against it.

use std::collections::BTreeSet;

use design_space::Cell;
use rand::RngExt;
use serde::{Deserialize, Serialize};
use surface::process::SimulationUse;

use crate::Error;
use crate::pooled::bands::Bands;
use crate::pooled::certificate::{Certificate, Draws, Evidence, Forecast};
use crate::pooled::coverage::{Coverage, unseen};
use crate::pooled::designs::Designs;
use crate::pooled::drift::{Drift, Members, Shift};
use crate::pooled::economy::Economy;
use crate::pooled::finds::Finds;
use crate::pooled::held::{Expected, MAY_RESPOND, UNKNOWN};
use crate::pooled::knowledge::Knowledge;
use crate::pooled::knowledge_gradient::pick;
use crate::pooled::measurements::Reading;
use crate::pooled::moments::correlation;
use crate::pooled::narrow::narrow_well;
use crate::pooled::outliers::{Doubted, Outlier, Readings, doubted, is_seen_again, outliers};
use crate::pooled::pool::Pool;
use crate::pooled::reason::{Pick, Reason};
use crate::pooled::recommendation::{lowest_mean, possible};
use crate::pooled::registration::Registration;
use crate::pooled::run_means::RunMeans;
use crate::pooled::settings::{Settings, StopBy};
use crate::pooled::shared::Shared;
use crate::pooled::streams::{Purpose, stream};

/// What is known of one design.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Standing {
    /// Its cell.
    pub cell: Cell,
    /// Settings, natural.
    pub point: Vec<f64>,
    /// The response that is expected there.
    pub mean: f64,
    /// Standard deviation of that expectation, without the noise of a reading: up to four times as large as the surface has it while there
    /// are few readings, and as it is when they are many times the terms of a quadratic.
    pub deviation: f64,
    /// Number of readings there.
    pub n_readings: usize,
    /// Mean of those readings.
    pub measured: Option<f64>,
    /// Probability that an experiment there gives a response.
    pub feasible: f64,
    /// Probability that it is better than the recommended design and keeps to every constraint; 0 for that one.
    pub probability_better: f64,
    /// Whether it may still be the best: it is better than the recommended one with a probability of at least 1 − the
    /// certificate's, and an experiment there gives a response with a probability of at least 0.75.
    pub may_be_best: bool,
    /// Each constrained response there, in the order of the constraints.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub constrained: Vec<Constrained>,
    /// Whether it keeps to every constraint with the probability that is asked for, and gives a response with 0.75.
    pub suffices: bool,
}

impl Standing {
    /// The same with a wider band.
    pub(crate) fn widened(self, bands: Bands) -> Self {
        Self { deviation: bands.widen(self.deviation), ..self }
    }
}

/// What is known of a constrained response at one design.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Constrained {
    /// What is expected, and the standard deviation of that without the noise of a reading; none before its first reading.
    pub expected: Option<(f64, f64)>,
    /// Probability that the design keeps to the bounds.
    pub within: f64,
    /// Mean of its readings there.
    pub measured: Option<f64>,
}

/// What is expected at one design.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Expectation {
    /// The response.
    pub mean: f64,
    /// Standard deviation of that, as of a [`Standing`].
    pub deviation: f64,
    /// Probability that an experiment there gives a response.
    pub feasible: f64,
    /// Each constrained response there, in the order of the constraints; `measured` is not looked up.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub constrained: Vec<Constrained>,
}

/// The lowest mean of readings at one design, where it contradicts the recommendation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Contradiction {
    /// The design that measured so low, or the recommended one itself.
    pub standing: Standing,
    /// Its readings lie as many of their standard errors away from what the surface says: below it, or above it for the
    /// recommended design.
    pub deviations: f64,
}

/// What the simulation is worth.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SimulationWorth {
    /// Squared correlation of simulation and readings: the share of their variance that the simulation explains. Where it is displaced, of
    /// the readings of which it tells within the bounds.
    pub explained: f64,
    /// Whether that correlation is negative: what the simulation calls better is worse.
    #[serde(default)]
    pub is_inverted: bool,
    /// Probability that the response is better learnt without it.
    pub ignored: f64,
    /// Mean of its factor ρ, where it is used.
    pub factor: f64,
    /// Standard deviation of that.
    pub factor_deviation: f64,
}

/// What a certificate waits for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Needed {
    /// So many readings, three more than a plane has terms: of fewer none knows how much of what they differ by is noise.
    Readings(usize),
    /// Readings of so many different designs, one more than a plane has terms: repeats do not tell what others are like.
    Designs(usize),
    /// A design that is run again: where there are no more designs than a quadratic has terms, it fits whatever they read, and nothing else
    /// tells the noise.
    Repeat,
    /// A reading that differs: where all are equal, to the last bit, they tell neither what designs differ by nor the noise.
    Difference,
}

impl Needed {
    /// The first of them.
    fn of(evidence: &Evidence, designs: &Designs, settings: &Settings, repeats: (usize, bool)) -> Option<Self> {
        let (n_repeats, are_equal) = repeats;
        let n_designs = usize::try_from(evidence.n_designs).unwrap_or(usize::MAX);
        let (readings, different) = (designs.n_to_promise(), designs.n_to_tell().min(n_designs));
        let is_noise_unknown = settings.noise.is_none() && n_repeats == 0;
        match evidence {
            few if few.n_readings < readings => Some(Self::Readings(readings)),
            few if few.n_tried < different => Some(Self::Designs(different)),
            _ if is_noise_unknown && designs.are_few() => Some(Self::Repeat),
            _ if are_equal && n_designs > 1 => Some(Self::Difference),
            _ => None,
        }
    }
}

/// The state of knowledge after some experiments.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Assessment {
    /// The feasible design with the lowest mean.
    pub recommended: Standing,
    /// How much better another may be.
    pub certificate: Certificate,
    /// What the certificate waits for before it says anything.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub needed: Option<Needed>,
    /// How that is expected to fall.
    pub forecast: Forecast,
    /// Standard deviation of one reading, as given or as learnt.
    pub noise: f64,
    /// Standard deviation of the error that all runs of an assembly share, where plants are told apart, or of a block, where that is taken in.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub assembly: Option<f64>,
    /// As much of that may be the plants' own, a part of the response: what plants that were put together again do not differ by.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub own: Option<f64>,
    /// Assemblies beyond the first of their plant, which alone tell one from the other.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub n_again: Option<usize>,
    /// Degrees of freedom of the repeats, which alone measure the noise: readings beyond one per setting.
    pub n_repeats: usize,
    /// Whether readings are taken to have no noise, because that was said or because repeats do not differ at all.
    #[serde(default)]
    pub is_exact: bool,
    /// Share of all designs that may still be the best.
    pub left: f64,
    /// Their number, where all designs were looked at: of many, `left` is told from a sample.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub n_left: Option<u64>,
    /// Share of all designs that a well may take and have been met by no run: as many evenly spread runs as leave no more of the box
    /// unseen would have met a larger one with the certificate's probability. None where every design was run.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unseen: Option<f64>,
    /// What the simulation is worth; none without one, or before three readings.
    pub simulation: Option<SimulationWorth>,
    /// How far the simulation is displaced, in the unit of each parameter: an experiment gives what it says of a design so much farther on.
    /// None where it is not, as far as readings tell.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub displacement: Option<Vec<f64>>,
    /// What the readings tell of that, sure or not; none without a simulation, before there are enough of them, and where the campaign takes the
    /// simulation as it stands.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub registration: Option<Registration>,
    /// What the readings say of runs of a batch that read otherwise than those of others, sure or not; none where they are too few, where
    /// such an error is [taken in](Settings::blocks) whatever they say, and where runs of a plant share one anyway.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drift: Option<Drift>,
    /// The same of each constrained response; empty where nothing is constrained, or nobody asks.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub constrained_drifts: Vec<Option<Drift>>,
    /// By how much the runs of each block read above what is expected of them, where they [share an error](Self::assembly) that is taken in.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub shifts: Vec<Shift>,
    /// Standard deviation of the error that readings of each constrained response share, where that is taken in; empty where it is for none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub constrained_shared: Vec<Option<f64>>,
    /// Readings that contradict the recommendation.
    pub contradiction: Option<Contradiction>,
    /// Settings of the best design that was measured to be far better than runs elsewhere say, and was not looked around on all sides
    /// yet; natural.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub find: Option<Vec<f64>>,
    /// Readings more than four standard deviations off, and those that are set aside.
    pub outliers: Vec<Outlier>,
    /// Whether the response is [said](Settings::smooth) to have no narrow well, and is not believed to: runs of one design, more than one, are
    /// far better than all others say.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub smooth_refuted: bool,
    /// The one of them on which the recommended design stands, if its settings were run but once: what is expected there holds unless that
    /// reading is a slip.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub doubted: Option<Doubted>,
    /// [Further batches](Forecast::further_batches) until what the campaign [stops by](Settings::stop_by) is expected to be as small as its `worth`,
    /// open ones among them: 0 if it is. None without `worth`, and where there is no forecast.
    pub further_batches: Option<u64>,
}

impl Assessment {
    /// By how much another design may be better, as the certificate has it; none while something is [needed](Self::needed) to say so, and
    /// where no design is known to keep to its bounds.
    #[must_use]
    pub fn bound(&self) -> Option<f64> {
        let is_kept = self.recommended.suffices || self.recommended.constrained.is_empty();
        (self.needed.is_none() && is_kept).then_some(self.certificate.bound)
    }

    /// With what nobody needs to choose a batch.
    pub(crate) fn with_shifts(
        self,
        knowledge: &mut Knowledge<'_, '_>,
        readings: &Readings,
        settings: &Settings,
    ) -> Result<Self, Error> {
        if settings.plants.is_some() || !readings.are_shared() {
            return Ok(self);
        }
        let cells: Vec<Cell> = readings.kept.iter().map(|reading| reading.cell).collect();
        let places = knowledge.places(&cells)?;
        let beyond = readings.kept.iter().zip(knowledge.process.marginals(&places)?.means);
        let beyond: Vec<f64> = beyond.map(|(reading, expected)| reading.response - expected).collect();
        let shifts = Shift::of_each(&Members::of(&readings.kept, &readings.blocks), &beyond);
        Ok(Self { shifts, ..self })
    }

    /// The same, as a campaign has it that [stops](Settings::stop_by) so.
    #[must_use]
    pub fn bound_to_stop_by(&self, stop_by: StopBy) -> Option<f64> {
        self.bound().map(|bound| match stop_by {
            StopBy::Bound => bound,
            StopBy::Surface => self.forecast.by_the_surface(),
        })
    }
}

/// A look at what is known.
pub(crate) struct Look {
    pub(crate) assessment: Assessment,
    /// The cells from which the next batch is picked.
    pub(crate) pool: Pool,
    /// None where a simulation says what lies between the runs.
    coverage: Coverage,
    /// Cells of outliers that another run may explain.
    again: Vec<Cell>,
    finds: Finds,
    /// Where the lowest response was measured.
    best_read: Cell,
}

/// Of the designs run, a repeat counting half, those outside of the campaign alone, of which the readings have numbers below `n_earlier`,
/// beyond as many evenly spread ones as leave as much of the box unseen.
fn crowded(
    knowledge: &Knowledge<'_, '_>,
    pool: &Pool,
    readings: &[Reading],
    n_earlier: usize,
    seed: u64,
) -> Result<f64, Error> {
    let own: BTreeSet<Cell> =
        readings.iter().filter(|reading| reading.number >= n_earlier).map(|reading| reading.cell).collect();
    let alone: Vec<&Reading> = readings.iter().filter(|reading| !own.contains(&reading.cell)).collect();
    if alone.is_empty() {
        return Ok(0.0);
    }
    let designs: BTreeSet<Cell> = alone.iter().map(|reading| reading.cell).collect();
    let runs: Vec<&[f64]> = alone.iter().map(|reading| &reading.coded[..]).collect();
    let n_even = Coverage::of(knowledge.designs, pool, &runs)?.even_runs(knowledge.designs, designs.len(), seed)?;
    Ok(0.5 * (designs.len() + alone.len()) as f64 - n_even as f64)
}

/// So many promising cells are looked at on each plant of a batch.
const PROMISING: usize = 100;
/// Beyond so many standard errors readings contradict the surface.
const CONTRADICTING: f64 = 3.0;
/// Where a setting was run more often, another run would not explain an outlier; where it was run as often and the runs differ by no more
/// than so many standard deviations of the noise, neither.
const MOST_RUNS: usize = 2;
const AGREEING: f64 = 3.0;

impl Look {
    pub(crate) fn at(
        knowledge: &mut Knowledge<'_, '_>,
        readings: &Readings,
        settings: &Settings,
        batch: usize,
    ) -> Result<Self, Error> {
        let Readings { n_earlier, n_failed, .. } = *readings;
        let (drift, constrained_drifts) = (readings.drift.clone(), readings.constrained_drifts.clone());
        let (constrained, set_aside, readings) = (&readings.constrained, &readings.set_aside, &readings.kept[..]);
        let open = outliers(knowledge, readings, settings)?;
        let again = to_run_again(readings, &open, knowledge.process.noise());
        let tried: BTreeSet<Cell> = readings.iter().map(|reading| reading.cell).collect();
        let refuted = settings.smooth && is_seen_again(readings, &open);
        let unsmooth = Settings { smooth: false, ..settings.clone() };
        let settings = if refuted { &unsmooth } else { settings };
        let may_be_recommended = |cell: &Cell| knowledge.designs.allows(*cell) && keeps(knowledge, constrained, *cell);
        let eligible: BTreeSet<Cell> = tried.iter().copied().filter(may_be_recommended).collect();
        let mut rng = stream(settings.seed, Purpose::Finds, batch);
        let finds = Finds::of(readings, &open, settings, |cell| eligible.contains(&cell));
        let finds = finds.with_pockets(knowledge, settings, |cell| eligible.contains(&cell), &mut rng)?;
        let pool = Pool::gather(knowledge, settings.seed, batch)?;
        let lowest = lowest_mean(knowledge, &pool, readings.len(), settings.seed, batch)?;
        let cell = match least(readings, settings) {
            Some(least) => possible(knowledge, lowest, least, readings, &eligible)?,
            None => lowest,
        };
        let runs: Vec<&[f64]> = readings.iter().map(|reading| &reading.coded[..]).collect();
        let coverage = Coverage::of(knowledge.designs, &pool, &runs)?;
        let n_even = coverage.even_runs(knowledge.designs, readings.len(), settings.seed)?;
        let recommended = standing(knowledge, readings, constrained, cell, cell, settings.confidence)?;
        let designs = knowledge.designs;
        let evidence = Evidence {
            n_readings: readings.len(),
            n_tried: tried.len(),
            n_even,
            n_failed,
            crowded: crowded(knowledge, &pool, readings, n_earlier, settings.seed)?,
            ignored: knowledge.ignored(),
            n_designs: designs.n_allowed(),
            is_smooth: settings.smooth,
            n_parameters: designs.region().n_parameters(),
            n_terms: designs.n_terms(),
            narrow: narrow_well(&pool, readings, recommended.mean, designs.n_terms()),
        };
        let never_run = evidence.never_run();
        let shared =
            settings.plants.as_ref().map(|plants| Ok::<_, Error>((plants, Shared::of(knowledge, readings, plants)?)));
        let shared = shared.transpose()?;
        let of_plants = shared.map_or(0.0, |(plants, shared)| {
            let n_plants = plants.n_plants(designs);
            shared.best_of(n_plants, settings.confidence)
        });
        let has_assemblies = Reading::are_shared(readings);
        let of_a_block = || if has_assemblies { knowledge.process.assembly_deviation().powi(2) } else { 0.0 };
        let error_of_a_reading = shared.map_or_else(of_a_block, |(_, shared)| shared.error_of_a_reading());
        let mut rng = stream(settings.seed, Purpose::Finds, batch);
        let contradiction =
            contradiction(knowledge, readings, constrained, &recommended, error_of_a_reading, settings.confidence)?;
        let measured = contradiction.as_ref().and_then(|one| one.standing.measured).unwrap_or(recommended.mean);
        let find = finds.open(knowledge, settings, recommended.mean, &mut rng)?;
        let found = find.map_or(0.0, |open| open.reach).max(recommended.mean - measured);
        let draws = Draws::of(knowledge, &pool, cell, readings, evidence, settings.seed, batch)?;
        let above = contradiction.is_none().then(|| above_the_least(&recommended, readings, settings)).flatten();
        // What runs of a plant share, and bounds that only some designs keep to, these do not know of.
        let is_plain = !has_assemblies && settings.constraints.is_empty();
        let by_runs = never_run <= 0.0 && designs.are_few() && is_plain;
        let run_means = by_runs.then(|| RunMeans::of(readings, cell, settings.noise)).flatten();
        let draws = draws.beside(found).with_plants(of_plants).above_the_least(above).by_runs(run_means);
        let certificate = draws.certificate(settings.confidence);
        let forecast = draws.forecast(settings.confidence, settings.n_experiments);
        let (left, n_left) = left(knowledge, &pool, cell, settings.confidence)?;
        let lowest = readings.iter().filter(|reading| designs.allows(reading.cell));
        let lowest = lowest.min_by(|a, b| a.response.total_cmp(&b.response).then(a.number.cmp(&b.number)));
        let best_read = lowest.map_or(cell, |reading| reading.cell);
        let n_repeats = knowledge.process.sites().n_repeats();
        let are_equal = readings.windows(2).all(|two| two[0].response.to_bits() == two[1].response.to_bits());
        let needed = Needed::of(&evidence, designs, settings, (n_repeats, are_equal));
        let bands = Bands::of(readings, designs.n_terms());
        let of_each = knowledge.held.iter().zip(constrained);
        let of_each = of_each.map(|(held, readings)| held.shared().filter(|_| Reading::are_shared(readings)));
        let shared_of_each: Vec<Option<f64>> = of_each.collect();
        let assessment = Assessment {
            noise: knowledge.process.noise(),
            assembly: has_assemblies.then(|| knowledge.process.assembly_deviation()),
            own: shared.map(|(_, shared)| shared.own.sqrt()),
            n_again: shared.map(|(_, shared)| shared.n_again),
            n_repeats,
            is_exact: settings.noise.is_some_and(|noise| noise <= 0.0),
            left,
            n_left,
            needed,
            // No well is larger than all that was never run.
            unseen: (never_run > 0.0).then(|| unseen(n_even, settings.confidence).min(never_run)),
            simulation: simulation_worth(knowledge, readings)?,
            drift,
            constrained_drifts,
            // These nobody needs to choose a batch.
            shifts: Vec::new(),
            constrained_shared: if shared_of_each.iter().any(Option::is_some) { shared_of_each } else { Vec::new() },
            registration: knowledge.registration.clone(),
            displacement: knowledge.displacement().map(|displacement| displacement.natural(designs)),
            contradiction: contradiction.map(|one| Contradiction { standing: one.standing.widened(bands), ..one }),
            find: find.map(|open| designs.grid().point(open.find)).transpose()?,
            smooth_refuted: refuted,
            doubted: doubted(knowledge, readings, &open, (cell, recommended.mean), settings)?,
            outliers: set_aside.iter().copied().chain(open).collect(),
            recommended: recommended.widened(bands),
            further_batches: settings
                .worth
                .and_then(|worth| match settings.stop_by {
                    StopBy::Bound => forecast.further_batches(worth),
                    StopBy::Surface => forecast.further_batches_by_the_surface(worth),
                })
                .map(|batches| batches.max(u64::from(needed.is_some()))),
            certificate,
            forecast,
        };
        let doubted = knowledge.sceptic.as_ref().map(|sceptic| sceptic.marginals(&pool.places)).transpose()?;
        Ok(Self {
            assessment,
            pool: pool.reduced(doubted.as_ref(), settings.seed, batch),
            coverage,
            again,
            finds,
            best_read,
        })
    }

    /// The cells of the next batch.
    pub(crate) fn picks(
        &self,
        knowledge: &mut Knowledge<'_, '_>,
        settings: &Settings,
        pending: &[Cell],
        batch: usize,
    ) -> Result<Vec<Pick>, Error> {
        let scramble = stream(settings.seed, Purpose::KnowledgeGradient, batch).random();
        let count = settings.n_experiments;
        let mut economy = Economy::of(settings.plants.as_ref(), knowledge.designs);
        // What is far from all others is run again first, on its own plant.
        self.again.iter().take(count).for_each(|&again| economy.take(again));
        let mut picks = pick(knowledge, &self.pool, &self.coverage, pending, count, scramble, economy.clone())?;
        if let Some(plants) = &settings.plants {
            for cell in Pick::cells(&picks) {
                if economy.allows(cell) {
                    economy.take(cell);
                }
            }
            let built = economy.built().to_vec();
            let mut rng = stream(settings.seed, Purpose::Plants, batch);
            let near = self.pool.first(&self.pool.by_lower_bound(2.0), PROMISING).cells;
            let on_them = plants.cells_of(knowledge.designs, &built, &near, &mut rng);
            let pool = self.pool.clone().with(knowledge, &on_them)?;
            let confined = Economy::of(Some(plants), knowledge.designs).confined_to(&built);
            picks = pick(knowledge, &pool, &self.coverage, pending, count, scramble, confined)?;
        }
        for (pick, again) in picks.iter_mut().zip(&self.again) {
            *pick = Pick { cell: *again, reason: Reason::Again };
        }
        if let Some(cell) = self.to_test_noise(knowledge, settings, pending, &picks) {
            let last = picks.iter().rposition(|pick| pick.reason.is_gain()).unwrap_or(picks.len() - 1);
            picks[last] = Pick { cell, reason: Reason::Noise };
        }
        // No other plant is built for what lies around a find.
        let allowed = Economy::of(settings.plants.as_ref(), knowledge.designs).confined_to(economy.built());
        let mut rng = stream(settings.seed, Purpose::Finds, batch);
        self.finds.look_around(knowledge.designs, &mut picks, pending, |cell| allowed.allows(cell), &mut rng)?;
        Ok(picks)
    }
}

/// Of fewer experiments a batch none is given away to test the noise.
const FEWEST_TO_TEST: usize = 4;
/// So many repeats are a test: where the noise is ten times what was given, one agrees by chance one time in five.
const ENOUGH_TO_TEST: usize = 2;

impl Look {
    /// A design to be run again where the noise was given, and hardly anything has been run twice: too little noise would make of every band and
    /// promise less than it is, and nothing else shows it. The one of the best reading, which is of use anyway; none where plants are
    /// dear.
    fn to_test_noise(
        &self,
        knowledge: &Knowledge<'_, '_>,
        settings: &Settings,
        pending: &[Cell],
        picks: &[Pick],
    ) -> Option<Cell> {
        let is_given = settings.noise.is_some_and(|noise| noise > 0.0) && self.assessment.assembly.is_none();
        let measured = |cell: &Cell| knowledge.measured.contains(cell);
        let is_tested = self.assessment.n_repeats >= ENOUGH_TO_TEST
            || pending.iter().any(measured)
            || picks.iter().any(|pick| measured(&pick.cell));
        (is_given && !is_tested && picks.len() >= FEWEST_TO_TEST).then_some(self.best_read)
    }
}

/// Cells of outliers that another run may explain, each once.
fn to_run_again(readings: &[Reading], outliers: &[Outlier], noise: f64) -> Vec<Cell> {
    let mut again: Vec<Cell> = Vec::new();
    for outlier in outliers {
        let cell = readings.iter().find(|reading| reading.number == outlier.reading).map(|reading| reading.cell);
        let Some(cell) = cell.filter(|cell| !again.contains(cell)) else { continue };
        let here = || readings.iter().filter(|reading| reading.cell == cell).map(|reading| reading.response);
        let differ_by = here().fold(f64::NEG_INFINITY, f64::max) - here().fold(f64::INFINITY, f64::min);
        let n_runs = here().count();
        if n_runs < MOST_RUNS || (n_runs == MOST_RUNS && differ_by > AGREEING * noise) {
            again.push(cell);
        }
    }
    again
}

/// What the surface has of a design, beside the recommended one.
pub(crate) fn standing(
    knowledge: &mut Knowledge<'_, '_>,
    readings: &[Reading],
    constrained: &[Vec<Reading>],
    cell: Cell,
    recommended: Cell,
    confidence: f64,
) -> Result<Standing, Error> {
    let cells = [recommended, cell];
    let places = knowledge.places(&cells)?;
    let marginals = knowledge.marginals(&places)?;
    let chances = knowledge.chances(&cells, &places)?;
    let feasible = chances.responding[1];
    let probability_better = match cell == recommended {
        true => 0.0,
        false => better(knowledge, &places)?[1] * chances.within[1],
    };
    let here: Vec<f64> =
        readings.iter().filter(|reading| reading.cell == cell).map(|reading| reading.response).collect();
    let n_readings = here.len();
    let may_be_best = cell == recommended || (feasible >= MAY_RESPOND && probability_better >= 1.0 - confidence);
    let mut of_constraints = constrained_at(knowledge, &[cell])?.remove(0);
    for (one, readings) in of_constraints.iter_mut().zip(constrained) {
        let here = readings.iter().filter(|reading| reading.cell == cell).map(|reading| reading.response);
        let n = here.clone().count() as f64;
        one.measured = (n > 0.0).then(|| here.sum::<f64>() / n);
    }
    Ok(Standing {
        cell,
        point: knowledge.designs.grid().point(cell)?,
        mean: marginals.means[1],
        deviation: marginals.variances[1].sqrt(),
        n_readings,
        measured: (n_readings > 0).then(|| here.iter().map(|response| response / n_readings as f64).sum()),
        feasible,
        probability_better,
        may_be_best,
        constrained: of_constraints,
        suffices: chances.suffices[1],
    })
}

/// The least that a response can be, where that is known and no reading is less: nobody knows then what it is.
fn least(readings: &[Reading], settings: &Settings) -> Option<f64> {
    settings.least.filter(|least| readings.iter().all(|reading| reading.response >= *least))
}

/// How far a design is above the least that a response can be, the worse of what is expected there and what was measured, and the standard
/// deviation of the former.
fn above_the_least(here: &Standing, readings: &[Reading], settings: &Settings) -> Option<(f64, f64)> {
    let least = least(readings, settings)?;
    Some((here.mean.max(here.measured.unwrap_or(here.mean)) - least, here.deviation))
}

/// What is known of each constrained response at each of the cells.
pub(crate) fn constrained_at(knowledge: &Knowledge<'_, '_>, cells: &[Cell]) -> Result<Vec<Vec<Constrained>>, Error> {
    let of_each = knowledge.expected_of_each(cells)?;
    let at = |place: usize| {
        let one = |expected: &Option<Expected>| Constrained {
            expected: expected.as_ref().map(|expected| (expected.means[place], expected.deviations[place])),
            within: expected.as_ref().map_or(UNKNOWN, |expected| expected.within[place]),
            measured: None,
        };
        of_each.iter().map(one).collect()
    };
    Ok((0..cells.len()).map(at).collect())
}

/// Probability of each place to be better than the first, over all particles.
fn better(knowledge: &Knowledge<'_, '_>, places: &surface::process::Places) -> Result<Vec<f64>, Error> {
    let of_each = knowledge.contrasts(places)?;
    let n = of_each.len() as f64;
    let below = |place: usize| of_each.iter().map(|each| each.probability_below(place) / n).sum();
    Ok((0..places.n_places()).map(below).collect())
}

/// Cells of which the share of designs left is counted, at most.
const COUNTED: u64 = 4000;

/// The share of all designs that may still be the best: counted in small grids, with their number, estimated from random designs
/// otherwise.
fn left(
    knowledge: &mut Knowledge<'_, '_>,
    pool: &Pool,
    recommended: Cell,
    confidence: f64,
) -> Result<(f64, Option<u64>), Error> {
    let are_all = knowledge.designs.n_cells() <= COUNTED;
    let cells: Vec<Cell> = if are_all { knowledge.designs.cells().collect() } else { pool.random.clone() };
    let n = cells.len();
    let with_recommended: Vec<Cell> = std::iter::once(recommended).chain(cells).collect();
    let places = knowledge.places(&with_recommended)?;
    let chances = knowledge.chances(&with_recommended, &places)?;
    let better = better(knowledge, &places)?;
    let left = |row: &usize| {
        let is_better = better[*row] * chances.within[*row] >= 1.0 - confidence;
        with_recommended[*row] == recommended || (is_better && chances.responding[*row] >= MAY_RESPOND)
    };
    let counted = (1..=n).filter(left).count();
    let share = (counted as f64 / n as f64).max(1.0 / knowledge.designs.n_cells() as f64);
    Ok((share, are_all.then_some(counted as u64)))
}

fn simulation_worth(knowledge: &mut Knowledge<'_, '_>, readings: &[Reading]) -> Result<Option<SimulationWorth>, Error> {
    let cells: Vec<Cell> = readings.iter().map(|reading| reading.cell).collect();
    let places = knowledge.places(&cells)?;
    let Some(simulated) = places.simulated().filter(|simulated| simulated.len() >= 3) else {
        return Ok(None);
    };
    let responses = readings.iter().map(|reading| reading.response);
    let within = |place: usize| places.unknown().get(place).is_none_or(|unknown| *unknown <= 0.0);
    let told = simulated.iter().copied().zip(responses).enumerate().filter(|(place, _)| within(*place));
    let (told, responses): (Vec<f64>, Vec<f64>) = told.map(|(_, pair)| pair).unzip();
    let particles = knowledge.process.particles();
    let used = particles.iter().filter(|particle| particle.structure().simulation != SimulationUse::Ignored);
    // A difference has the factor 1, and no doubt about it.
    let factors: Vec<[f64; 2]> = used.map(|particle| particle.simulation_factor().unwrap_or([1.0, 0.0])).collect();
    let correlation = correlation(&told, &responses);
    let n = factors.len().max(1) as f64;
    let factor = factors.iter().map(|[mean, _]| mean).sum::<f64>() / n;
    let variance = factors.iter().map(|[mean, variance]| variance + (mean - factor).powi(2)).sum::<f64>() / n;
    Ok(Some(SimulationWorth {
        explained: correlation.powi(2),
        is_inverted: correlation < 0.0,
        ignored: knowledge.ignored(),
        factor,
        factor_deviation: variance.sqrt(),
    }))
}

/// The design whose readings lie farthest below what is recommended, or the recommended one if its own lie above.
fn contradiction(
    knowledge: &mut Knowledge<'_, '_>,
    readings: &[Reading],
    constrained: &[Vec<Reading>],
    recommended: &Standing,
    shared: f64,
    confidence: f64,
) -> Result<Option<Contradiction>, Error> {
    let noise = knowledge.process.noise();
    if let Some(measured) = recommended.measured {
        let error = (noise * noise / recommended.n_readings as f64 + shared + recommended.deviation.powi(2)).sqrt();
        let deviations = (measured - recommended.mean) / error;
        if deviations > CONTRADICTING {
            return Ok(Some(Contradiction { standing: recommended.clone(), deviations }));
        }
    }
    let mut over: Vec<(f64, Cell)> = Vec::new();
    let allowed = knowledge.measured.iter().filter(|&&cell| knowledge.designs.allows(cell));
    for &cell in allowed.filter(|&&cell| cell != recommended.cell && keeps(knowledge, constrained, cell)) {
        let here = readings.iter().filter(|reading| reading.cell == cell).map(|reading| reading.response);
        let n = here.clone().count() as f64;
        let error = (noise * noise / n + shared + recommended.deviation.powi(2)).sqrt();
        let deviations = (recommended.mean - here.sum::<f64>() / n) / error;
        if deviations > CONTRADICTING {
            over.push((deviations, cell));
        }
    }
    over.sort_by(|a, b| b.0.total_cmp(&a.0));
    for (deviations, cell) in over {
        let standing = standing(knowledge, readings, constrained, cell, recommended.cell, confidence)?;
        // Where a bound was not measured, what is expected of it decides.
        let mut pairs = knowledge.held.iter().zip(&standing.constrained);
        let may_be_kept = pairs.all(|(held, there)| {
            there.measured.is_some() || there.expected.is_none() || there.within >= held.constraint.probability
        });
        if may_be_kept {
            return Ok(Some(Contradiction { standing, deviations }));
        }
    }
    Ok(None)
}

/// Whether what was measured at a cell, if anything, keeps to every constraint in the mean.
fn keeps(knowledge: &Knowledge<'_, '_>, constrained: &[Vec<Reading>], cell: Cell) -> bool {
    knowledge.held.iter().zip(constrained).all(|(held, readings)| {
        let here = readings.iter().filter(|reading| reading.cell == cell).map(|reading| reading.response);
        let n = here.clone().count();
        n == 0 || held.constraint.allows(here.sum::<f64>() / n as f64)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn correlation_is_that_of_the_textbook_and_zero_of_a_constant() {
        // Of 1, 2, 3 with 1, 3, 2: sums of squares 2 and 2, of products 1.
        for (a, b, expected) in [
            ([1.0, 2.0, 3.0], [1.0, 3.0, 2.0], 0.5),
            ([1.0, 2.0, 3.0], [5.0, 3.0, 1.0], -1.0),
            ([2.0, 2.0, 2.0], [1.0, 3.0, 2.0], 0.0),
            ([1.0, 3.0, 2.0], [7.0, 7.0, 7.0], 0.0),
        ] {
            let found = correlation(&a, &b);
            assert!((found - expected).abs() < 1e-14, "{a:?} and {b:?}: {found}");
        }
    }

    #[test]
    fn an_outlier_is_run_again_once_and_once_more_if_that_run_says_otherwise() {
        let mut scene = crate::pooled::scene::Scene::new(&[21]);
        for (x, response) in
            [(0, 9.0), (5, 1.0), (5, 1.2), (9, 1.0), (9, 1.4), (12, 1.0), (12, 3.0), (12, 5.0), (20, 0.0)]
        {
            scene.read(&[x], response);
        }
        let outlier = |reading: usize| Outlier { reading, deviations: 9.0, set_aside: false };
        let all: Vec<Outlier> = (0..8).map(outlier).collect();
        assert_eq!(to_run_again(&scene.readings, &all, 0.1), [scene.cell(&[0]), scene.cell(&[9])]);
        assert_eq!(to_run_again(&scene.readings, &all, 0.05), [scene.cell(&[0]), scene.cell(&[5]), scene.cell(&[9])]);
        assert_eq!(to_run_again(&scene.readings, &[], 0.1), []);
    }

    /// Errors of the readings, of their assembly and of the recommended mean add up in squares.
    #[test]
    fn a_contradiction_is_told_in_standard_errors_of_the_readings_and_of_what_they_contradict() {
        let mut scene = crate::pooled::scene::Scene::new(&[21]);
        for (at, (x, response)) in
            [(0, 2.0), (0, 2.3), (5, 1.0), (5, 1.1), (10, 0.5), (10, 0.6), (15, 1.6), (20, 2.1)].into_iter().enumerate()
        {
            scene.read(&[x], response);
            scene.readings[at].assembly = Some(at / 2);
        }
        let (readings, low, recommended) = (scene.readings.clone(), scene.cell(&[10]), scene.cell(&[1]));
        let mut knowledge = scene.knowledge(None);
        let (noise, assembly) = (knowledge.process.noise(), knowledge.process.assembly_deviation());
        assert!(noise > 0.0 && assembly > 0.0, "{noise} {assembly}");
        for deviation in [0.0, 1.0] {
            let one = standing(&mut knowledge, &readings, &[], recommended, recommended, 0.9).unwrap();
            let one = Standing { mean: 50.0, deviation, ..one };
            let found = contradiction(&mut knowledge, &readings, &[], &one, assembly * assembly, 0.9).unwrap().unwrap();
            let error = (0.5_f64.sqrt() * noise).hypot(assembly).hypot(deviation);
            assert_eq!(found.standing.cell, low, "two readings of 0.55 in the mean");
            assert!((found.deviations * error - 49.45).abs() < 1e-9, "{} of {error}", found.deviations);
            // Its own readings come first: four of them, 10 worse than is expected.
            let own = Standing { measured: Some(60.0), n_readings: 4, ..one };
            let found = contradiction(&mut knowledge, &readings, &[], &own, assembly * assembly, 0.9).unwrap().unwrap();
            let error = (0.5 * noise).hypot(assembly).hypot(deviation);
            assert_eq!(found.standing.cell, recommended);
            assert!((found.deviations * error - 10.0).abs() < 1e-9, "{} of {error}", found.deviations);
        }
    }
}
