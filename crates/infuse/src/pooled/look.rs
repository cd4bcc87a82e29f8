//! A look at what is known: what the experiments so far come to, and what the next ones are picked from.

use std::collections::BTreeSet;

use design_space::Cell;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use surface::process::SimulationUse;

use crate::Error;
use crate::pooled::assessment::{Assessment, Contradiction, Needed, SimulationWorth, Standing, better, standing};
use crate::pooled::bands::Bands;
use crate::pooled::certificate::{Draws, Evidence, Forecast};
use crate::pooled::coverage::{Coverage, unseen};
use crate::pooled::designs::Designs;
use crate::pooled::economy::Economy;
use crate::pooled::finds::Finds;
use crate::pooled::held::MAY_RESPOND;
use crate::pooled::knowledge::Knowledge;
use crate::pooled::knowledge_gradient::pick;
use crate::pooled::measurements::Reading;
use crate::pooled::moments::correlation;
use crate::pooled::narrow::narrow_well;
use crate::pooled::outliers::{Outlier, Readings, doubted, is_seen_again, outliers};
use crate::pooled::pool::Pool;
use crate::pooled::reason::{Pick, Reason};
use crate::pooled::recommendation::{lowest_mean, possible};
use crate::pooled::run_means::RunMeans;
use crate::pooled::settings::{Settings, StopBy};
use crate::pooled::shared::Shared;
use crate::pooled::streams::{Purpose, stream};

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

/// What was measured, by which settings, and after which batch.
#[derive(Clone, Copy)]
struct Scope<'r> {
    readings: &'r Readings,
    settings: &'r Settings,
    batch: usize,
}

impl Look {
    pub(crate) fn at(
        knowledge: &mut Knowledge<'_, '_>,
        readings: &Readings,
        settings: &Settings,
        batch: usize,
    ) -> Result<Self, Error> {
        let open = outliers(knowledge, &readings.kept, settings)?;
        let again = to_run_again(&readings.kept, &open, knowledge.process.noise());
        let smooth_refuted = settings.smooth && is_seen_again(&readings.kept, &open);
        let settings = &Settings { smooth: settings.smooth && !smooth_refuted, ..settings.clone() };
        let scope = Scope { readings, settings, batch };
        let eligible = scope.eligible(knowledge);
        let finds = scope.finds(knowledge, &open, &eligible)?;
        let pool = Pool::gather(knowledge, settings.seed, batch)?;
        let cell = scope.recommended(knowledge, &pool, &eligible)?;
        let runs: Vec<&[f64]> = readings.kept.iter().map(|reading| &reading.coded[..]).collect();
        let coverage = Coverage::of(knowledge.designs, &pool, &runs)?;
        let assessment = scope.assessment(knowledge, (&pool, &coverage, &finds), open, cell)?;
        let doubted = knowledge.sceptic.as_ref().map(|sceptic| sceptic.marginals(&pool.places)).transpose()?;
        Ok(Self {
            assessment: Assessment { smooth_refuted, ..assessment },
            pool: pool.reduced(doubted.as_ref(), settings.seed, batch),
            coverage,
            again,
            finds,
            best_read: scope.best_read(knowledge).unwrap_or(cell),
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
        for cell in self.to_test_noise(knowledge, settings, pending, &picks) {
            let is_other = |pick: &Pick| pick.cell != cell;
            let last = picks.iter().rposition(|pick| pick.reason.is_gain() && is_other(pick));
            let last = last.or_else(|| picks.iter().rposition(is_other)).unwrap_or(picks.len() - 1);
            picks[last] = Pick { cell, reason: Reason::Noise };
        }
        // No other plant is built for what lies around a find.
        let allowed = Economy::of(settings.plants.as_ref(), knowledge.designs).confined_to(economy.built());
        let mut rng = stream(settings.seed, Purpose::Finds, batch);
        self.finds.look_around(knowledge.designs, &mut picks, pending, |cell| allowed.allows(cell), &mut rng)?;
        Ok(picks)
    }
}

/// The steps of a look.
impl Scope<'_> {
    fn rng(&self) -> ChaCha8Rng {
        stream(self.settings.seed, Purpose::Finds, self.batch)
    }

    /// The designs run that may be recommended.
    fn eligible(&self, knowledge: &Knowledge<'_, '_>) -> BTreeSet<Cell> {
        let may_be_recommended =
            |cell: &Cell| knowledge.designs.allows(*cell) && keeps(knowledge, &self.readings.constrained, *cell);
        self.readings.kept.iter().map(|reading| reading.cell).filter(may_be_recommended).collect()
    }

    fn finds(
        &self,
        knowledge: &mut Knowledge<'_, '_>,
        open: &[Outlier],
        eligible: &BTreeSet<Cell>,
    ) -> Result<Finds, Error> {
        let finds = Finds::of(&self.readings.kept, open, self.settings, |cell| eligible.contains(&cell));
        finds.with_pockets(knowledge, self.settings, |cell| eligible.contains(&cell), &mut self.rng())
    }

    fn recommended(
        &self,
        knowledge: &mut Knowledge<'_, '_>,
        pool: &Pool,
        eligible: &BTreeSet<Cell>,
    ) -> Result<Cell, Error> {
        let readings = &self.readings.kept;
        let lowest = lowest_mean(knowledge, pool, readings.len(), self.settings.seed, self.batch)?;
        match least(readings, self.settings) {
            Some(least) => possible(knowledge, lowest, least, readings, eligible),
            None => Ok(lowest),
        }
    }

    /// Where the lowest response was measured, of designs that keep to the linear constraints.
    fn best_read(&self, knowledge: &Knowledge<'_, '_>) -> Option<Cell> {
        let allowed = self.readings.kept.iter().filter(|reading| knowledge.designs.allows(reading.cell));
        let lowest = allowed.min_by(|a, b| a.response.total_cmp(&b.response).then(a.number.cmp(&b.number)));
        lowest.map(|reading| reading.cell)
    }

    /// What speaks for how much better another design may be, besides the surface.
    fn evidence(
        &self,
        knowledge: &Knowledge<'_, '_>,
        pool: &Pool,
        coverage: &Coverage,
        mean: f64,
    ) -> Result<Evidence, Error> {
        let (designs, settings) = (knowledge.designs, self.settings);
        let Readings { kept: readings, n_earlier, n_failed, .. } = self.readings;
        let tried: BTreeSet<Cell> = readings.iter().map(|reading| reading.cell).collect();
        Ok(Evidence {
            n_readings: readings.len(),
            n_tried: tried.len(),
            n_even: coverage.even_runs(designs, readings.len(), settings.seed)?,
            n_failed: *n_failed,
            crowded: crowded(knowledge, pool, readings, *n_earlier, settings.seed)?,
            ignored: knowledge.ignored(),
            n_designs: designs.n_allowed(),
            is_smooth: settings.smooth,
            n_parameters: designs.region().n_parameters(),
            n_terms: designs.n_terms(),
            narrow: narrow_well(pool, readings, mean, designs.n_terms()),
        })
    }

    /// What runs of a plant share, where there are plants.
    fn shared(&self, knowledge: &mut Knowledge<'_, '_>) -> Result<Option<Shared>, Error> {
        let plants = self.settings.plants.as_ref();
        plants.map(|plants| Shared::of(knowledge, &self.readings.kept, plants)).transpose()
    }

    /// Variance of the error that a reading shares with others.
    fn error_of_a_reading(&self, knowledge: &Knowledge<'_, '_>, shared: Option<Shared>) -> f64 {
        match shared {
            Some(shared) => shared.error_of_a_reading(),
            None if self.readings.are_shared() => knowledge.process.assembly_deviation().powi(2),
            None => 0.0,
        }
    }

    /// By how much the best of all plants may be better than the one recommended, by what is their own.
    fn of_plants(&self, designs: &Designs, shared: Option<Shared>) -> f64 {
        let pair = self.settings.plants.as_ref().zip(shared);
        pair.map_or(0.0, |(plants, shared)| shared.best_of(plants.n_plants(designs), self.settings.confidence))
    }

    /// Student's bound, where every design was run: what runs of a plant share, and bounds that only some designs keep to, it does not know of.
    fn run_means(&self, designs: &Designs, evidence: &Evidence, cell: Cell) -> Option<RunMeans> {
        let is_plain = !self.readings.are_shared() && self.settings.constraints.is_empty();
        let are_all_run = evidence.never_run() <= 0.0 && designs.are_few();
        (are_all_run && is_plain).then(|| RunMeans::of(&self.readings.kept, cell, self.settings.noise)).flatten()
    }

    fn needed(&self, knowledge: &Knowledge<'_, '_>, evidence: &Evidence) -> Option<Needed> {
        let mut pairs = self.readings.kept.windows(2);
        let are_equal = pairs.all(|two| two[0].response.to_bits() == two[1].response.to_bits());
        let n_repeats = knowledge.process.sites().n_repeats();
        Needed::of(evidence, knowledge.designs, self.settings, (n_repeats, are_equal))
    }

    /// Readings that tell of the parameters, where a bound is a multiple of what these differ by, and they may be noise alone.
    fn needs_signal(&self, knowledge: &Knowledge<'_, '_>, forecast: &Forecast) -> Option<Needed> {
        if !forecast.holds_reserve() || forecast.is_for_the_least() {
            return None;
        }
        let gain = knowledge.process.gain_over_noise(self.settings.noise)?;
        (gain < SIGNAL).then_some(Needed::Signal)
    }

    /// Further batches by the number that the campaign stops by, one at least where something is needed.
    fn further_batches(&self, forecast: &Forecast, needed: Option<Needed>) -> Option<u64> {
        let worth = self.settings.worth?;
        let further = match self.settings.stop_by {
            StopBy::Bound => forecast.further_batches(worth),
            StopBy::Surface => forecast.further_batches_by_the_surface(worth),
        };
        further.map(|batches| batches.max(u64::from(needed.is_some())))
    }

    /// Standard deviation of the error that readings of each constrained response share; empty where those of none do.
    fn constrained_shared(&self, knowledge: &Knowledge<'_, '_>) -> Vec<Option<f64>> {
        let of_each = knowledge.held.iter().zip(&self.readings.constrained);
        let of_each = of_each.map(|(held, readings)| held.shared().filter(|_| Reading::are_shared(readings)));
        let of_each: Vec<Option<f64>> = of_each.collect();
        if of_each.iter().any(Option::is_some) { of_each } else { Vec::new() }
    }

    /// All of it in one report, of this cell as the recommended one.
    fn assessment(
        &self,
        knowledge: &mut Knowledge<'_, '_>,
        (pool, coverage, finds): (&Pool, &Coverage, &Finds),
        open: Vec<Outlier>,
        cell: Cell,
    ) -> Result<Assessment, Error> {
        let (settings, confidence, designs) = (self.settings, self.settings.confidence, knowledge.designs);
        let Readings { kept: readings, constrained, set_aside, drift, constrained_drifts, .. } = self.readings;
        let recommended = standing(knowledge, readings, constrained, cell, cell, confidence)?;
        let evidence = self.evidence(knowledge, pool, coverage, recommended.mean)?;
        let shared = self.shared(knowledge)?;
        let error = self.error_of_a_reading(knowledge, shared);
        let contradiction = contradiction(knowledge, readings, constrained, &recommended, error, confidence)?;
        let measured = contradiction.as_ref().and_then(|one| one.standing.measured).unwrap_or(recommended.mean);
        let find = finds.open(knowledge, settings, recommended.mean, &mut self.rng())?;
        let found = find.map_or(0.0, |open| open.reach).max(recommended.mean - measured);
        let above = contradiction.is_none().then(|| above_the_least(&recommended, readings, settings)).flatten();
        let draws = Draws::of(knowledge, pool, cell, readings, evidence, settings.seed, self.batch)?
            .beside(found)
            .with_plants(self.of_plants(designs, shared))
            .above_the_least(above)
            .by_runs(self.run_means(designs, &evidence, cell));
        let forecast = draws.forecast(confidence, settings.n_experiments);
        let needed = self.needed(knowledge, &evidence).or_else(|| self.needs_signal(knowledge, &forecast));
        let never_run = evidence.never_run();
        let (left, n_left) = left(knowledge, pool, cell, confidence)?;
        let bands = Bands::of(readings, designs.n_terms());
        Ok(Assessment {
            noise: knowledge.process.noise(),
            assembly: self.readings.are_shared().then(|| knowledge.process.assembly_deviation()),
            own: shared.map(|shared| shared.own.sqrt()),
            n_again: shared.map(|shared| shared.n_again),
            n_repeats: knowledge.process.sites().n_repeats(),
            is_exact: settings.noise.is_some_and(|noise| noise <= 0.0),
            left,
            n_left,
            needed,
            // No well is larger than all that was never run.
            unseen: (never_run > 0.0).then(|| unseen(evidence.n_even, confidence).min(never_run)),
            simulation: simulation_worth(knowledge, readings)?,
            drift: drift.clone(),
            constrained_drifts: constrained_drifts.clone(),
            // These nobody needs to choose a batch.
            shifts: Vec::new(),
            constrained_shared: self.constrained_shared(knowledge),
            registration: knowledge.registration.clone(),
            displacement: knowledge.displacement().map(|displacement| displacement.natural(designs)),
            contradiction: contradiction.map(|one| Contradiction { standing: one.standing.widened(bands), ..one }),
            find: find.map(|open| designs.grid().point(open.find)).transpose()?,
            smooth_refuted: false,
            doubted: doubted(knowledge, readings, &open, (cell, recommended.mean), settings)?,
            outliers: set_aside.iter().copied().chain(open).collect(),
            recommended: recommended.widened(bands),
            further_batches: self.further_batches(&forecast, needed),
            certificate: draws.certificate(confidence),
            forecast,
        })
    }
}

/// With less of a [gain over noise](surface::process::AveragedProcess::gain_over_noise) readings may be noise alone.
const SIGNAL: f64 = 3.0;
/// Of fewer experiments a batch none is given away to test the noise.
const FEWEST_TO_TEST: usize = 4;
/// So many repeats are a test: where the noise is ten times what was given, one agrees by chance one time in five.
const ENOUGH_TO_TEST: usize = 2;

impl Look {
    /// Designs to be run again where the noise was given, and hardly anything has been run twice: too little noise would make of every band and
    /// promise less than it is, and nothing else shows it. The one of the best reading, which is of use anyway; twice where runs of a batch share
    /// an error, as then only those of one batch tell the noise; none where plants are dear.
    fn to_test_noise(
        &self,
        knowledge: &Knowledge<'_, '_>,
        settings: &Settings,
        pending: &[Cell],
        picks: &[Pick],
    ) -> Vec<Cell> {
        let is_given = settings.noise.is_some_and(|noise| noise > 0.0) && settings.plants.is_none();
        if !is_given || picks.len() < FEWEST_TO_TEST || self.assessment.n_repeats >= ENOUGH_TO_TEST {
            return Vec::new();
        }
        if self.assessment.assembly.is_some() {
            return self.twice_in_one_batch(pending, picks);
        }
        let measured = |cell: &Cell| knowledge.measured.contains(cell);
        let is_tested = pending.iter().any(measured) || picks.iter().any(|pick| measured(&pick.cell));
        if is_tested { Vec::new() } else { vec![self.best_read] }
    }

    /// What has to be added to a batch so that it runs a design twice, unless it does or what is waited for does.
    fn twice_in_one_batch(&self, pending: &[Cell], picks: &[Pick]) -> Vec<Cell> {
        let is_twice = |cells: &[Cell]| cells.iter().collect::<BTreeSet<_>>().len() < cells.len();
        let picked = Pick::cells(picks);
        let n_there = usize::from(picked.contains(&self.best_read));
        if is_twice(pending) || is_twice(&picked) { Vec::new() } else { vec![self.best_read; 2 - n_there] }
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
    use crate::pooled::scene::Scene;

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
        let mut scene = Scene::new(&[21]);
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
        let mut scene = Scene::new(&[21]);
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
