//! By how much a simulation is displaced, told from the readings: what is called registration where it is pictures that are laid over each
//! other.

use std::collections::{BTreeMap, BTreeSet};

use design_space::Cell;
use faer::Mat;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use surface::Data;
use surface::process::RegressorEvidence;

use crate::Error;
use crate::pooled::designs::Designs;
use crate::pooled::displacement::{
    Displacement, LEAST_STEP, WITHIN_A_STEP, correlation, free, left_of, share, steps, went_on,
};
use crate::pooled::measurements::Reading;
use crate::pooled::moments::{correlation as correlation_of, mean_and_deviation};
use crate::pooled::simulated::{Column, Emulator, Simulate, Simulated};
use crate::pooled::spread::{Normal, mean_squares_about};

/// Prior standard deviation along each of one or two axes, as a share of its range; of more, so that the distance is as far as along two.
const USUAL: f64 = 0.1;

fn usual(n_free: usize) -> f64 {
    USUAL * (2.0 / n_free.max(2) as f64).sqrt()
}

/// Along no axis more than so much of its range is looked at in the first place.
const MOST: f64 = 0.3;
/// So many displacements are drawn from the prior; the search goes on from the best of them.
const DRAWN: usize = 128;
const REFINED: usize = 4;
/// So many are drawn near the most probable one, and at most so many times it gives way to a more probable one of those.
const NEAR: usize = 64;
const MOVES: usize = 3;
/// The first steps of that, as a share of the range; never less than a level.
const FIRST_STEP: f64 = 0.05;
/// Beyond so many readings more than there are parameters it is looked for.
const FEWEST: usize = 4;
/// By so much more than half of the logarithm of the number of readings a parameter (Schwarz 1978) the logarithm of its probability must
/// be above that of none.
const SURELY: f64 = 2.0;

/// What readings tell of how far a simulation is displaced.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Registration {
    /// The most probable displacement, in the unit of each parameter: an experiment gives what the simulation says of a design so much
    /// farther on.
    pub displacement: Vec<f64>,
    /// Standard deviation of that along each axis; 0 along those that were not looked along.
    pub deviations: Vec<f64>,
    /// The logarithm of its probability less that of none.
    pub gain: f64,
    /// From this on it is believed.
    pub needed: f64,
    /// Squared correlation of the readings with what the simulation says of their own designs, over those readings of which it tells within
    /// the bounds from there, as [`SimulationWorth::explained`](crate::pooled::reported::SimulationWorth::explained) is.
    pub explained_in_place: f64,
    /// Why it is not believed, however probable it is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub refused: Option<Refused>,
}

/// Why a displacement is not believed: with several axes there are so many of them that one fits by chance where the simulation is wrong
/// in another way, its best well that of another one, say.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Refused {
    /// It is so far along one axis that next to no displacement is, before there are results.
    TooFar,
    /// For most of what was measured it points beyond the bounds, where nobody knows what the simulation would say.
    BeyondBounds,
    /// It stands and falls with a single result, which may be a slip: without that it would be no more probable than none.
    OneResult,
}

impl Registration {
    /// Whether the simulation is taken to be displaced.
    #[must_use]
    pub fn is_sure(&self) -> bool {
        self.gain > self.needed && self.refused.is_none()
    }
}

/// The most probable one, and by how much it is so; nothing where readings are too few to look for it or the simulation tells nothing.
pub(crate) fn registered(
    readings: &[Reading],
    designs: &Designs,
    rng: &mut ChaCha8Rng,
    simulation: &mut dyn Simulation,
) -> Result<Option<(Displacement, Registration)>, Error> {
    let free = free(designs);
    if free.is_empty() || readings.len() < designs.region().n_parameters() + FEWEST {
        return Ok(None);
    }
    let mut search = Search::of(readings, designs, free, simulation)?;
    let none = search.none();
    let without = search.probability(&none)?;
    if without.is_infinite() {
        return Ok(None);
    }
    let (best, there, deviations) = search.best(rng)?;
    let needed = 0.5 * search.free.len() as f64 * (readings.len() as f64).ln() + SURELY;
    let gain = there - without;
    let refused = match search.refused(&best) {
        None if gain > needed => search.hangs_on_one(&best)?.then_some(Refused::OneResult),
        refused => refused,
    };
    let explained_in_place = search.explained_in_place(&best, readings)?;
    let displacement = best.natural(designs);
    let registration = Registration { displacement, deviations, gain, needed, explained_in_place, refused };
    Ok(Some((best, registration)))
}

/// Farther along an axis than so many standard deviations of the prior none is believed,
const FARTHEST: f64 = 3.5;
/// nor one that tells of less than this share of the readings within the bounds.
const LEAST_WITHIN: f64 = 0.4;

/// What is known of a simulation.
pub(crate) trait Simulation {
    /// What it says of each of these; none where it says nothing at all.
    fn says(&mut self, designs: &Designs, cells: &[Cell]) -> Result<Option<Vec<f64>>, Error>;
}

/// One that is run wherever it is asked for.
pub(crate) struct Runs<'s> {
    pub(crate) simulated: &'s mut Simulated,
    pub(crate) simulate: &'s mut dyn Simulate,
    /// Where it fails the nearest of these stands for it.
    pub(crate) screened: &'s [Cell],
}

impl Simulation for Runs<'_> {
    fn says(&mut self, designs: &Designs, cells: &[Cell]) -> Result<Option<Vec<f64>>, Error> {
        self.simulated.run(designs, cells, self.simulate)?;
        self.simulated.at_or_near_all(designs, cells, self.screened, Column::Cost)
    }
}

/// One that a surface through a few runs of it tells of.
pub(crate) struct Emulation<'s> {
    emulator: &'s Emulator,
    simulated: &'s Simulated,
    known: BTreeMap<Cell, f64>,
}

impl<'s> Emulation<'s> {
    pub(crate) fn of(emulator: &'s Emulator, simulated: &'s Simulated) -> Self {
        Self { emulator, simulated, known: BTreeMap::new() }
    }
}

impl Simulation for Emulation<'_> {
    fn says(&mut self, designs: &Designs, cells: &[Cell]) -> Result<Option<Vec<f64>>, Error> {
        let new: BTreeSet<Cell> = cells.iter().copied().filter(|cell| !self.known.contains_key(cell)).collect();
        let new: Vec<Cell> = new.into_iter().collect();
        if !new.is_empty() {
            let said = self.emulator.says(designs, &new, self.simulated, Column::Cost)?;
            self.known.extend(new.into_iter().zip(said.into_iter().flatten()));
        }
        Ok(cells.iter().map(|cell| self.known.get(cell).copied()).collect())
    }
}

/// What a simulation says of each reading.
struct Said {
    /// With the mean 0 and the standard deviation 1.
    said: Vec<f64>,
    /// The standard deviation of what is unknown of that.
    unknown: Vec<f64>,
}

struct Search<'s> {
    designs: &'s Designs,
    free: Vec<usize>,
    cells: Vec<Cell>,
    evidence: RegressorEvidence,
    /// The logarithm of each probability.
    known: BTreeMap<Displacement, f64>,
    simulation: &'s mut dyn Simulation,
}

impl<'s> Search<'s> {
    fn of(
        readings: &[Reading],
        designs: &'s Designs,
        free: Vec<usize>,
        simulation: &'s mut dyn Simulation,
    ) -> Result<Self, Error> {
        let coordinates = readings.iter().flat_map(|reading| &reading.coded).copied().collect();
        let responses = readings.iter().map(|reading| reading.response).collect();
        let evidence = RegressorEvidence::of(&Data::new(designs.n_factors(), coordinates, responses)?)?;
        let cells = readings.iter().map(|reading| reading.cell).collect();
        Ok(Self { designs, free, cells, evidence, known: BTreeMap::new(), simulation })
    }

    fn none(&self) -> Displacement {
        Displacement(vec![0; self.designs.combinations().counts().len()])
    }

    /// Asks at once for what several displacements are told by.
    fn look_ahead<'d>(&mut self, all: impl Iterator<Item = &'d Displacement>) -> Result<(), Error> {
        let unknown = all.filter(|one| !self.known.contains_key(one));
        let there = unknown.flat_map(|one| self.cells.iter().flat_map(|&cell| self.told_by(one, cell)));
        let there: Vec<Cell> = there.collect();
        self.simulation.says(self.designs, &there)?;
        Ok(())
    }

    /// The designs whose simulations tell of one.
    fn told_by(&self, one: &Displacement, cell: Cell) -> [Cell; 2] {
        [one.of(self.designs, cell), one.inside(self.designs, cell)]
    }

    /// The displacements next to one, so far along each axis.
    fn around(&self, one: &Displacement, step: f64) -> Vec<Displacement> {
        let counts = self.designs.combinations().counts();
        let moved = |(axis, sign): (usize, i64)| {
            let mut other = one.clone();
            other.0[axis] += sign * steps(step, counts[axis]).max(1);
            other
        };
        self.free.iter().flat_map(|&axis| [(axis, -1), (axis, 1)]).map(moved).collect()
    }

    /// The logarithm of the probability, up to a constant; that of none at all where nothing is simulated, or the same everywhere.
    fn probability(&mut self, one: &Displacement) -> Result<f64, Error> {
        if let Some(known) = self.known.get(one) {
            return Ok(*known);
        }
        let probability = match self.regressor(one)? {
            Some(Said { said, unknown }) => {
                self.evidence.log_likelihood_in_part(&said, &unknown)? + self.log_prior(one)
            }
            None => f64::NEG_INFINITY,
        };
        self.known.insert(one.clone(), probability);
        Ok(probability)
    }

    /// What the simulation says from there of each reading, and how far that is unknown; nothing where it says nothing, or the same everywhere.
    fn regressor(&mut self, one: &Displacement) -> Result<Option<Said>, Error> {
        let there: Vec<Cell> = self.cells.iter().flat_map(|&cell| self.told_by(one, cell)).collect();
        let Some(said) = self.simulation.says(self.designs, &there)? else { return Ok(None) };
        let said: Vec<f64> = said.chunks_exact(2).map(|pair| went_on(pair[0], pair[1])).collect();
        // In units of its own: what goes on steeply beyond the bounds would count for its size alone where two explain as much.
        let [mean, deviation] = mean_and_deviation(&said);
        if deviation <= 0.0 {
            return Ok(None);
        }
        let said: Vec<f64> = said.into_iter().map(|value| (value - mean) / deviation).collect();
        // Beyond the bounds nobody knows what it would say.
        let unknown = self.cells.iter().map(|&cell| left_of(correlation(one.beyond(self.designs, cell))));
        Ok(Some(Said { said, unknown: unknown.collect() }))
    }

    fn log_prior(&self, one: &Displacement) -> f64 {
        let counts = self.designs.combinations().counts();
        let axes = one.0.iter().zip(counts);
        -0.5 * axes.map(|(step, count)| (share(*step, *count) / usual(self.free.len())).powi(2)).sum::<f64>()
    }

    /// Whether it would be no more probable than none, were one of the readings not there.
    fn hangs_on_one(&mut self, one: &Displacement) -> Result<bool, Error> {
        let (Some(there), Some(in_place)) = (self.regressor(one)?, self.regressor(&self.none())?) else {
            return Ok(false);
        };
        let without_each = |one: Said| self.evidence.log_likelihoods_without_each(&one.said, &one.unknown);
        let (there, in_place) = (without_each(there)?, without_each(in_place)?);
        let prior = self.log_prior(one);
        Ok(there.into_iter().zip(in_place).any(|(there, in_place)| there + prior <= in_place))
    }

    /// The most probable one, by steps along each axis from the best of those that were drawn, its probability and how far off it may be.
    fn best(&mut self, rng: &mut ChaCha8Rng) -> Result<(Displacement, f64, Vec<f64>), Error> {
        let prior = Normal::about_none(&vec![usual(self.free.len()); self.free.len()]);
        let of_prior: Vec<Vec<f64>> = (0..DRAWN).map(|_| prior.draw(rng)).collect();
        let drawn = [self.none()].into_iter().chain(of_prior.iter().map(|one| self.rounded(one)));
        let drawn: Vec<Displacement> = drawn.collect();
        self.look_ahead(drawn.iter())?;
        let of_each = drawn.into_iter().map(|one| Ok((self.probability(&one)?, one)));
        let mut of_each = of_each.collect::<Result<Vec<_>, Error>>()?;
        of_each.sort_by(|a, b| b.0.total_cmp(&a.0).then_with(|| a.1.cmp(&b.1)));
        of_each.dedup_by(|a, b| a.1 == b.1);
        of_each.truncate(REFINED);
        let mut best = (self.none(), f64::NEG_INFINITY);
        for (probability, one) in of_each {
            let found = self.climb(one, probability)?;
            if found.1 > best.1 {
                best = found;
            }
        }
        self.spread(best, (&prior, &of_prior), rng)
    }

    /// How the logarithm of the probability bends around the most probable one, in shares of the ranges (Laplace's method): the inverse of
    /// a covariance.
    fn precision(&mut self, best: &Displacement) -> Result<Mat<f64>, Error> {
        let counts = self.designs.combinations().counts().to_vec();
        let (free, n_free) = (self.free.clone(), self.free.len());
        let step = |axis: usize| steps(LEAST_STEP, counts[axis]).max(1);
        let length = |axis: usize| share(step(axis), counts[axis]);
        let moved = |by: &[(usize, i64)]| {
            let mut other = best.clone();
            by.iter().for_each(|&(axis, sign)| other.0[axis] += sign * step(axis));
            other
        };
        let pairs = free.iter().flat_map(|&a| free.iter().filter(move |&&b| b >= a).map(move |&b| (a, b)));
        let around = |(a, b): (usize, usize), sign: i64| {
            if a == b { moved(&[(a, sign)]) } else { moved(&[(a, sign), (b, sign)]) }
        };
        let all: Vec<Displacement> = pairs.flat_map(|pair| [-1, 1].map(|sign| around(pair, sign))).collect();
        self.look_ahead(all.iter())?;
        let here = self.probability(best)?;
        // The second difference of one step along one axis, or of one along each of two.
        let mut bend = |pair: (usize, usize)| -> Result<f64, Error> {
            let [back, on] = [-1, 1].map(|sign| self.probability(&around(pair, sign)));
            Ok(2.0 * here - back? - on?)
        };
        let mut precision = Mat::<f64>::zeros(n_free, n_free);
        for (row, &a) in free.iter().enumerate() {
            // Never less than the prior's.
            precision[(row, row)] = bend((a, a))?.max((length(a) / usual(n_free)).powi(2));
        }
        for (row, &a) in free.iter().enumerate() {
            for (column, &b) in free.iter().enumerate().take(row) {
                let both = 0.5 * (bend((b.min(a), b.max(a)))? - precision[(row, row)] - precision[(column, column)]);
                (precision[(row, column)], precision[(column, row)]) = (both, both);
            }
        }
        let in_shares = |row: usize, column: usize| length(free[row]) * length(free[column]);
        Ok(Mat::from_fn(n_free, n_free, |row, column| precision[(row, column)] / in_shares(row, column)))
    }

    /// The most probable one of these and of those near it, with the standard deviations of what it is off by, in the unit of each parameter,
    /// by importance sampling: beside the displacements that the search began with, which are drawn from the prior, some are drawn near the
    /// most probable one, and each counts by its probability over the density that it was drawn with. One that is more probable takes
    /// its place.
    fn spread(
        &mut self,
        (mut best, mut there): (Displacement, f64),
        (prior, of_prior): (&Normal, &[Vec<f64>]),
        rng: &mut ChaCha8Rng,
    ) -> Result<(Displacement, f64, Vec<f64>), Error> {
        let counts = self.designs.combinations().counts().to_vec();
        let mut n_moves = 0;
        loop {
            let precision = self.precision(&best)?;
            let center: Vec<f64> = self.free.iter().map(|&axis| share(best.0[axis], counts[axis])).collect();
            let step = |axis: usize| share(steps(LEAST_STEP, counts[axis]).max(1), counts[axis]);
            let within: Vec<f64> = self.free.iter().map(|&axis| WITHIN_A_STEP * step(axis)).collect();
            let near = Normal::near(center, &precision, &within);
            let drawn: Vec<Vec<f64>> = of_prior.iter().cloned().chain((0..NEAR).map(|_| near.draw(rng))).collect();
            let rounded: Vec<Displacement> = drawn.iter().map(|one| self.rounded(one)).collect();
            self.look_ahead(rounded.iter())?;
            let probabilities = rounded.iter().map(|one| self.probability(one)).collect::<Result<Vec<_>, _>>()?;
            let most = (0..drawn.len()).max_by(|&a, &b| probabilities[a].total_cmp(&probabilities[b]));
            if let Some(most) = most.filter(|&most| probabilities[most] > there && n_moves < MOVES) {
                (best, there) = self.climb(rounded[most].clone(), probabilities[most])?;
                n_moves += 1;
                continue;
            }
            let densities = [(prior, of_prior.len()), (&near, NEAR)];
            let about = mean_squares_about(near.center(), &drawn, &probabilities, &densities);
            let mut deviations = vec![0.0; counts.len()];
            for (row, &axis) in self.free.iter().enumerate() {
                // No less than it bends, where hardly any of those that were drawn count.
                let share = about[row].max(near.variance(row)).sqrt();
                deviations[axis] = share * self.designs.region().parameters()[axis].width();
            }
            return Ok((best, there, deviations));
        }
    }

    /// Why one is not to be believed.
    fn refused(&self, one: &Displacement) -> Option<Refused> {
        let (counts, farthest) = (self.designs.combinations().counts(), FARTHEST * usual(self.free.len()));
        if self.free.iter().any(|&axis| share(one.0[axis], counts[axis]).abs() > farthest) {
            return Some(Refused::TooFar);
        }
        let n_within = self.cells.iter().filter(|&&cell| one.beyond(self.designs, cell) <= 0.0).count();
        ((n_within as f64) < LEAST_WITHIN * self.cells.len() as f64).then_some(Refused::BeyondBounds)
    }

    /// How much the simulation explains as it stands of the readings of which it tells within the bounds from there.
    fn explained_in_place(&mut self, one: &Displacement, readings: &[Reading]) -> Result<f64, Error> {
        let within = readings.iter().filter(|reading| one.beyond(self.designs, reading.cell) <= 0.0);
        let (cells, responses): (Vec<Cell>, Vec<f64>) = within.map(|reading| (reading.cell, reading.response)).unzip();
        let said = self.simulation.says(self.designs, &cells)?;
        Ok(said.map_or(0.0, |said| correlation_of(&said, &responses).powi(2)))
    }

    /// In whole levels.
    fn rounded(&self, shares: &[f64]) -> Displacement {
        let (mut rounded, counts) = (self.none(), self.designs.combinations().counts());
        for (&axis, share) in self.free.iter().zip(shares) {
            rounded.0[axis] = steps(share.clamp(-MOST, MOST), counts[axis]);
        }
        rounded
    }

    fn climb(&mut self, mut one: Displacement, mut probability: f64) -> Result<(Displacement, f64), Error> {
        let counts = self.designs.combinations().counts().to_vec();
        let mut reach = FIRST_STEP;
        loop {
            let mut is_better = false;
            self.look_ahead(self.around(&one, reach).iter())?;
            for axis in self.free.clone() {
                let levels = steps(reach, counts[axis]).max(1);
                for step in [-levels, levels] {
                    let mut other = one.clone();
                    other.0[axis] += step;
                    let there = self.probability(&other)?;
                    if there > probability {
                        (one, probability, is_better) = (other, there, true);
                        self.look_ahead(self.around(&one, reach).iter())?;
                    }
                }
            }
            if is_better {
                continue;
            }
            // No step is less than a level.
            let is_least = self.free.iter().all(|&axis| steps(reach, counts[axis]) <= 1);
            if reach <= LEAST_STEP || is_least {
                return Ok((one, probability));
            }
            reach = (0.5 * reach).max(LEAST_STEP);
        }
    }
}

#[cfg(test)]
mod tests {
    use design_space::{Parameter, Region};
    use proptest::prelude::*;
    use rand::SeedableRng as _;
    use rand_distr::{Distribution as _, StandardNormal};

    use super::*;
    use crate::pooled::bands::NINE_IN_TEN;
    use crate::pooled::settings::Settings;

    const LEVELS: i64 = 21;

    fn designs() -> Designs {
        designs_of(LEVELS)
    }

    fn designs_of(levels: i64) -> Designs {
        let number = |name: &str| {
            let number = Parameter::continuous(name, "mm", 0.0, 10.0).unwrap();
            number.with_levels(levels as u32).unwrap()
        };
        let shape = Parameter::categorical("shape", ["round", "flat", "long"]).unwrap();
        let region = Region::new(vec![number("x"), shape, number("y")]).unwrap();
        Designs::of(&region, &[], &mut ChaCha8Rng::seed_from_u64(1)).unwrap()
    }

    /// Two wells on a slope, 0 to 20 along each axis, and another slope for each shape.
    fn height(x: f64, shape: u64, y: f64) -> f64 {
        let well = |a: f64, b: f64, depth: f64| depth * (-((x - a).powi(2) + (y - b).powi(2)) / 18.0).exp();
        0.03 * x + 0.2 * shape as f64 - well(6.0, 14.0, 1.0) - well(15.0, 5.0, 0.7)
    }

    fn at(designs: &Designs, cell: Cell, by: [i64; 2]) -> f64 {
        let digits = designs.combinations().digits(cell.index());
        height((digits[0] as i64 + by[0]) as f64, digits[1], (digits[2] as i64 + by[1]) as f64)
    }

    /// So many runs of what lies so many levels farther on.
    fn readings(designs: &Designs, by: [i64; 2], n: usize, noise: f64, rng: &mut ChaCha8Rng) -> Vec<Reading> {
        let one = |number: usize| {
            let cell = designs.random(rng);
            let normal: f64 = StandardNormal.sample(rng);
            let response = 3.0 + 1.3 * at(designs, cell, by) + noise * normal;
            Reading { coded: designs.coded_of(cell).unwrap(), cell, response, number, assembly: None }
        };
        (0..n).map(one).collect()
    }

    /// What is found of them.
    fn found(by: [i64; 2], n: usize, noise: f64, seed: u64, simulated: impl Fn(&Designs, Cell) -> f64) -> Displacement {
        let (designs, mut rng) = (designs(), ChaCha8Rng::seed_from_u64(seed));
        let readings = readings(&designs, by, n, noise, &mut rng);
        let mut simulate = |cell: Cell, _: &[f64]| Ok::<f64, String>(simulated(&designs, cell));
        let mut runs = Runs { simulated: &mut Simulated::default(), simulate: &mut simulate, screened: &[] };
        believed(registered(&readings, &designs, &mut rng, &mut runs).unwrap())
    }

    fn registration(by: [i64; 2], n: usize, noise: f64, seed: u64) -> Option<(Displacement, Registration)> {
        let (designs, mut rng) = (designs(), ChaCha8Rng::seed_from_u64(seed));
        let readings = readings(&designs, by, n, noise, &mut rng);
        let mut simulate = |cell: Cell, _: &[f64]| Ok::<f64, String>(at(&designs, cell, [0, 0]));
        let mut runs = Runs { simulated: &mut Simulated::default(), simulate: &mut simulate, screened: &[] };
        registered(&readings, &designs, &mut rng, &mut runs).unwrap()
    }

    fn believed(found: Option<(Displacement, Registration)>) -> Displacement {
        found.filter(|(_, registration)| registration.is_sure()).map(|(found, _)| found).unwrap_or_default()
    }

    /// To the level where there are enough runs, and never along the axis of a choice.
    #[test]
    fn a_displaced_simulation_is_found_out_and_by_how_much() {
        for (seed, by) in [[2, -1], [-3, 2], [0, 3], [1, 1]].into_iter().enumerate() {
            let found = found(by, 40, 0.02, seed as u64, |designs, cell| at(designs, cell, [0, 0]));
            assert_eq!(found, Displacement(vec![by[0], 0, by[1]]));
            assert_eq!(found.natural(&designs()), [0.5 * by[0] as f64, 0.0, 0.5 * by[1] as f64], "in millimetres");
        }
    }

    /// Nine times of ten it is as near as is said, where it is known to a level or less and where it is not.
    #[test]
    fn it_is_as_near_as_is_said_nine_times_of_ten() {
        let by = [2, -1];
        for (noise, n, n_seeds) in [(0.02, 40, 40), (0.1, 25, 80)] {
            let [mut n_near, mut n_found] = [0; 2];
            for seed in 0..n_seeds {
                let Some((found, told)) = registration(by, n, noise, 100 + seed) else { continue };
                if !told.is_sure() {
                    continue;
                }
                assert_eq!(told.displacement, found.natural(&designs()));
                for (axis, by) in [(0, by[0]), (2, by[1])] {
                    let off = told.displacement[axis] - 0.5 * by as f64;
                    n_near += usize::from(off.abs() <= NINE_IN_TEN * told.deviations[axis]);
                    n_found += 1;
                }
                assert!(told.deviations[1] <= 0.0, "a choice has no order");
            }
            let share = n_near as f64 / n_found as f64;
            assert!(n_found >= 40 && share > 0.83, "{n_near} of {n_found}, noise {noise}");
        }
    }

    /// A quarter of the range along both axes: what four of nine designs have to do with lies beyond the bounds, and is left out.
    #[test]
    fn a_displacement_that_points_out_of_the_bounds_is_found_to_the_level() {
        for (seed, by) in [[5, -5], [-5, 5], [5, 5], [-5, -5]].into_iter().enumerate() {
            let found = found(by, 40, 0.02, 50 + seed as u64, |designs, cell| at(designs, cell, [0, 0]));
            assert_eq!(found, Displacement(vec![by[0], 0, by[1]]));
        }
    }

    /// From 150 of 1323 designs, by a surface that is not quite what it tells of: to a level along each axis.
    #[test]
    fn a_few_simulations_tell_of_it_too() {
        let (designs, mut rng) = (designs(), ChaCha8Rng::seed_from_u64(9));
        let mut simulated = Simulated::default();
        while simulated.len() < 150 {
            let cell = designs.random(&mut rng);
            simulated.insert(cell, Some(at(&designs, cell, [0, 0]).into()));
        }
        let emulator = Emulator::of(&simulated, &designs, &Settings::new(5)).unwrap().unwrap();
        for by in [[3, -2], [-2, 3], [0, 0]] {
            let readings = readings(&designs, by, 40, 0.02, &mut rng);
            let mut emulation = Emulation::of(&emulator, &simulated);
            let found = believed(registered(&readings, &designs, &mut rng, &mut emulation).unwrap());
            if found.is_none() {
                assert_eq!(by, [0, 0], "it is displaced");
                continue;
            }
            let is_near = (found.0[0] - by[0]).abs() <= 1 && (found.0[2] - by[1]).abs() <= 1;
            assert!(is_near && found.0[1] == 0 && found.is_none() == (by == [0, 0]), "{found:?} of {by:?}");
        }
    }

    /// Of 40 draws hardly one is believed to be displaced where the simulation is in its place. Among so many displacements of noise one fits
    /// by chance now and then: of 40 fewer than a fifth.
    #[test]
    fn a_simulation_in_its_place_stays_there_and_so_does_noise() {
        let [mut n_moved, mut n_moved_noise] = [0; 2];
        for seed in 0..40 {
            let in_place = found([0, 0], 20, 0.05, seed, |designs, cell| at(designs, cell, [0, 0]));
            n_moved += usize::from(!in_place.is_none());
            let noise = found([0, 0], 20, 0.05, seed, |_, cell| {
                StandardNormal.sample(&mut ChaCha8Rng::seed_from_u64(seed.wrapping_add(1000 * cell.index())))
            });
            n_moved_noise += usize::from(!noise.is_none());
        }
        assert!(n_moved <= 2 && n_moved_noise < 8, "{n_moved} in place, {n_moved_noise} of noise");
    }

    /// Without noise, of few results. At the corner of a slope there is a well of a single design, which a displacement would go on with beyond the bounds,
    /// twice as deep, and explain as much.
    #[test]
    fn a_simulation_that_is_right_of_every_result_is_in_its_place() {
        let needle = |designs: &Designs, cell: Cell| {
            let digits = designs.combinations().digits(cell.index());
            if [digits[0], digits[2]] == [0, 0] { -3.0 } else { 0.005 * (digits[0] + digits[2]) as f64 }
        };
        for seed in 0..10 {
            let (designs, mut rng) = (designs(), ChaCha8Rng::seed_from_u64(seed));
            let corner = Cell::new(0);
            let cells = [corner].into_iter().chain((0..8).map(|_| designs.random(&mut rng)));
            let cells: Vec<Cell> = cells.collect();
            let one = |(number, cell): (usize, &Cell)| {
                let (coded, response) = (designs.coded_of(*cell).unwrap(), needle(&designs, *cell));
                Reading { coded, cell: *cell, response, number, assembly: None }
            };
            let readings: Vec<Reading> = cells.iter().enumerate().map(one).collect();
            let mut simulate = |cell: Cell, _: &[f64]| Ok::<f64, String>(needle(&designs, cell));
            let mut runs = Runs { simulated: &mut Simulated::default(), simulate: &mut simulate, screened: &[] };
            let found = registered(&readings, &designs, &mut rng, &mut runs).unwrap();
            assert!(believed(found).is_none(), "seed {seed}");
        }
    }

    #[test]
    fn a_simulation_that_says_nothing_is_not_displaced() {
        assert!(found([2, 2], 30, 0.01, 1, |_, _| 4.0).is_none(), "the same everywhere");
        assert!(found([2, 2], 6, 0.01, 1, |designs, cell| at(designs, cell, [0, 0])).is_none(), "too few runs");
    }

    type Landscape = fn(f64, f64) -> f64;

    /// Landscapes, 0 to 20 along each axis, their values differing by about 1, and the least share of bands that hold.
    const LANDSCAPES: [(&str, Landscape, f64); 5] = [
        ("two wells", |x, y| 0.7 * height(x, 0, y), 0.9),
        ("a bowl", |x, y| 0.4 * off(x, 8.0).powi(2) + 0.3 * off(y, 12.0).powi(2), 0.9),
        (
            "a steep bowl",
            |x, y| {
                let (u, v) = (off(x, 8.0).powi(2), off(y, 12.0).powi(2));
                0.26 * (u * u + 0.5 * u) + 0.17 * (v * v + 0.4 * v)
            },
            0.87,
        ),
        (
            "a ridge",
            |x, y| {
                let (u, v) = (off(x, 10.0), off(y, 10.0));
                0.25 * (u + v).powi(2) + 0.01 * (u - v).powi(2) + 0.01 * u
            },
            0.75,
        ),
        (
            "a bowl beyond the bounds",
            |x, y| 0.08 * off(x, 22.0).powi(2) + 0.07 * off(y, -3.0).powi(2) + 0.03 * (0.4 * x).sin(),
            0.75,
        ),
    ];

    fn off(x: f64, center: f64) -> f64 {
        (x - center) / 10.0
    }

    /// As many of the displacements that are believed as lie in the bands that are said; each is drawn from the prior, in whole levels where
    /// these are many, half of the runs lie anywhere, half where the best is, and what is measured differs from what is simulated by a smooth part, too.
    fn held(landscape: Landscape, levels: i64, n: usize, noise: f64, n_seeds: u64) -> (usize, usize) {
        let [mut n_held, mut n_told] = [0; 2];
        let step = 20.0 / (levels - 1) as f64;
        for seed in 0..n_seeds {
            let (designs, mut rng) = (designs_of(levels), ChaCha8Rng::seed_from_u64(1000 + seed));
            let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
            let by = [normal(), normal()].map(|normal| 2.0 * normal);
            let by = if levels == LEVELS { by.map(f64::round) } else { by };
            let bend = 0.025 * normal();
            let truth = |x: f64, y: f64| 1.3 * landscape(x + by[0], y + by[1]) + bend * off(x, 10.0) * off(y, 10.0);
            let digits = |cell: Cell| {
                let digits = designs.combinations().digits(cell.index());
                [step * digits[0] as f64, digits[1] as f64, step * digits[2] as f64]
            };
            let all = (0..levels).flat_map(|x| (0..levels).map(move |y| (step * x as f64, step * y as f64)));
            let best = all.min_by(|a, b| truth(a.0, a.1).total_cmp(&truth(b.0, b.1))).unwrap();
            let mut readings = Vec::new();
            while readings.len() < n {
                let cell = designs.random(&mut rng);
                let [x, shape, y] = digits(cell);
                if readings.len() >= n / 2 && (x - best.0).abs().max((y - best.1).abs()) > 3.0 {
                    continue;
                }
                let normal: f64 = StandardNormal.sample(&mut rng);
                let response = 3.0 + truth(x, y) + 0.2 * shape + noise * normal;
                let (coded, number) = (designs.coded_of(cell).unwrap(), readings.len());
                readings.push(Reading { coded, cell, response, number, assembly: None });
            }
            let mut simulate = |cell: Cell, _: &[f64]| {
                let [x, shape, y] = digits(cell);
                Ok::<f64, String>(landscape(x, y) + 0.2 * shape)
            };
            let mut runs = Runs { simulated: &mut Simulated::default(), simulate: &mut simulate, screened: &[] };
            let Some((_, told)) = registered(&readings, &designs, &mut rng, &mut runs).unwrap() else { continue };
            if told.is_sure() {
                for (axis, by) in [(0, by[0]), (2, by[1])] {
                    let off = told.displacement[axis] - 0.5 * by;
                    n_held += usize::from(off.abs() <= NINE_IN_TEN * told.deviations[axis]);
                    n_told += 1;
                }
            }
        }
        (n_held, n_told)
    }

    /// By frequency, with 40 displacements drawn for each number of runs and noise. Along a ridge, and where a bowl lies beyond the bounds, a
    /// slope looks like a displacement: there fewer hold.
    #[test]
    fn bands_of_displacements_hold_where_features_tell_and_where_none_do() {
        let [mut n_held, mut n_told] = [0; 2];
        for (name, landscape, least) in LANDSCAPES {
            let of_each = [(24, 0.02), (48, 0.02), (48, 0.06)].map(|(n, noise)| held(landscape, LEVELS, n, noise, 40));
            let [held, told] = of_each.into_iter().fold([0; 2], |sum, one| [sum[0] + one.0, sum[1] + one.1]);
            assert!(told >= 25 && held as f64 >= least * told as f64, "{name}: {held} of {told}");
            (n_held, n_told) = (n_held + held, n_told + told);
        }
        assert!(n_held as f64 >= 0.9 * n_told as f64, "{n_held} of {n_told}");
    }

    /// Nine levels an axis, of which a displacement is a whole number only by chance: of whole ones alone one is told, and what it is off
    /// by is said.
    #[test]
    fn bands_of_displacements_hold_between_few_levels() {
        let of_each = LANDSCAPES.map(|(_, landscape, _)| held(landscape, 9, 24, 0.02, 60));
        let [held, told] = of_each.into_iter().fold([0; 2], |sum, one| [sum[0] + one.0, sum[1] + one.1]);
        assert!(told >= 150 && held as f64 >= 0.9 * told as f64, "{held} of {told}");
    }

    /// The true one is not refused; one that is farther than 3.5 standard deviations of the prior is, 8 of 20 steps, and one by three levels
    /// where only the four lowest were run.
    #[test]
    fn what_is_not_believed_however_well_it_fits() {
        let (designs, mut rng) = (designs(), ChaCha8Rng::seed_from_u64(4));
        let mut refused = |truth: [i64; 2], lowest: u64, by: [i64; 2]| {
            let mut readings = readings(&designs, truth, 200, 0.02, &mut rng);
            readings.retain(|reading| designs.combinations().digits(reading.cell.index())[0] < lowest);
            let mut simulate = |cell: Cell, _: &[f64]| Ok::<f64, String>(at(&designs, cell, [0, 0]));
            let mut runs = Runs { simulated: &mut Simulated::default(), simulate: &mut simulate, screened: &[] };
            let search = Search::of(&readings, &designs, free(&designs), &mut runs).unwrap();
            search.refused(&Displacement(vec![by[0], 0, by[1]]))
        };
        assert_eq!(refused([3, -2], 21, [3, -2]), None);
        assert_eq!(refused([8, 0], 21, [8, 0]), Some(Refused::TooFar));
        assert_eq!(refused([-3, 0], 4, [-3, 0]), Some(Refused::BeyondBounds));
        assert_eq!(refused([0, 0], 21, [0, 0]), None);
    }

    /// Of a smooth bowl and another one, with noise, in which one reading at a corner is a tenth of what it should be: by that alone the corner is as
    /// good as the best, which a displacement would make up for.
    #[test]
    fn one_slip_is_no_displacement() {
        let bowl = |x: f64, y: f64, a: f64, b: f64| 2.0 + 4.0 * (off(x, a).powi(2) + 0.7 * off(y, b).powi(2));
        let [mut n_refused, mut n_believed] = [0; 2];
        for seed in 0..20 {
            let (designs, mut rng) = (designs(), ChaCha8Rng::seed_from_u64(seed));
            let digits = |cell: Cell| designs.combinations().digits(cell.index());
            let mut readings = Vec::new();
            while readings.len() < 24 {
                let cell = if readings.is_empty() { Cell::new(0) } else { designs.random(&mut rng) };
                let normal: f64 = StandardNormal.sample(&mut rng);
                let digits = digits(cell);
                let truth = bowl(digits[0] as f64, digits[2] as f64, 12.0, 13.0);
                let response = if readings.is_empty() { 0.1 * truth } else { truth } + 0.1 * normal;
                let (coded, number) = (designs.coded_of(cell).unwrap(), readings.len());
                readings.push(Reading { coded, cell, response, number, assembly: None });
            }
            let mut simulate = |cell: Cell, _: &[f64]| {
                let digits = digits(cell);
                let (x, y) = (digits[0] as f64, digits[2] as f64);
                Ok::<f64, String>(bowl(x, y, 12.0, 13.0) + 0.5 * bowl(x, y, 7.0, 10.0))
            };
            let mut of = |readings: &[Reading], rng: &mut ChaCha8Rng| {
                let mut runs = Runs { simulated: &mut Simulated::default(), simulate: &mut simulate, screened: &[] };
                registered(readings, &designs, rng, &mut runs).unwrap().map(|(_, told)| told)
            };
            let with_slip = of(&readings, &mut rng);
            n_refused += usize::from(with_slip.as_ref().is_some_and(|told| told.refused == Some(Refused::OneResult)));
            n_believed += usize::from(with_slip.is_some_and(|told| told.is_sure()));
        }
        assert!(n_refused >= 15 && n_believed <= 2, "{n_refused} refused, {n_believed} believed");
    }

    proptest! {
        /// Away from the bounds the way there and back is none; at them it ends on a design.
        #[test]
        fn there_and_back(x in 0..LEVELS, shape in 0..3_i64, y in 0..LEVELS, by in (-6..=6_i64, -6..=6_i64)) {
            let designs = designs();
            let cell = Cell::new(designs.combinations().index(&[x, shape, y].map(|digit| digit as u64)));
            let displacement = Displacement(vec![by.0, 0, by.1]);
            let there = displacement.of(&designs, cell);
            let expected = [x + by.0, shape, y + by.1].map(|digit| digit.clamp(0, LEVELS - 1) as u64);
            prop_assert_eq!(designs.combinations().digits(there.index()), expected);
            let is_inside = (0..LEVELS).contains(&(x + by.0)) && (0..LEVELS).contains(&(y + by.1));
            prop_assert!(!is_inside || displacement.back(&designs, there) == cell);
        }
    }
}
