//! By how much a simulation is displaced, told from the readings: what is called registration where it is pictures that are laid over each
//! other.

use std::collections::{BTreeMap, BTreeSet};

use design_space::Cell;
use faer::linalg::solvers::DenseSolveCore as _;
use faer::{Mat, Side};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde::{Deserialize, Serialize};
use surface::Data;
use surface::process::RegressorEvidence;

use crate::Error;
use crate::pooled::designs::Designs;
use crate::pooled::displacement::{Displacement, LEAST_STEP, WITHIN_A_STEP, correlation, free, left_of, share, steps};
use crate::pooled::measurements::Reading;
use crate::pooled::moments::{correlation as correlation_of, mean_and_deviation};
use crate::pooled::simulated::{Column, Emulator, Simulate, Simulated};

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
    /// Squared correlation of the readings with what the simulation says of their own designs.
    pub explained_in_place: f64,
}

impl Registration {
    /// Whether the simulation is taken to be displaced.
    #[must_use]
    pub fn is_sure(&self) -> bool {
        self.gain > self.needed
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
    let explained_in_place = search.explained_in_place(readings)?;
    let (best, there) = search.best(rng)?;
    let needed = 0.5 * search.free.len() as f64 * (readings.len() as f64).ln() + SURELY;
    let (displacement, deviations) = (best.natural(designs), search.deviations(&best)?);
    let registration = Registration { displacement, deviations, gain: there - without, needed, explained_in_place };
    Ok(Some((best, registration)))
}

/// What is known of a simulation.
pub(crate) trait Simulation {
    /// What it says of each of these; none where it says nothing at all.
    fn says(&mut self, designs: &Designs, cells: &[Cell]) -> Result<Option<Vec<f64>>, Error>;
}

/// One that is run wherever it is asked for.
pub(crate) struct Runs<'s> {
    pub(crate) simulated: &'s mut Simulated,
    pub(crate) simulate: &'s mut dyn Simulate,
}

impl Simulation for Runs<'_> {
    fn says(&mut self, designs: &Designs, cells: &[Cell]) -> Result<Option<Vec<f64>>, Error> {
        self.simulated.run_aside(designs, cells, self.simulate)?;
        cells.iter().map(|&cell| self.simulated.aside_or_near(designs, cell, Column::Objective)).collect()
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
            let said = self.emulator.says(designs, &new, self.simulated, Column::Objective)?;
            self.known.extend(new.into_iter().zip(said.into_iter().flatten()));
        }
        Ok(cells.iter().map(|cell| self.known.get(cell).copied()).collect())
    }
}

struct Search<'s> {
    designs: &'s Designs,
    free: Vec<usize>,
    cells: Vec<Cell>,
    evidence: RegressorEvidence,
    /// Mean and standard deviation of what the simulation says of the readings' own designs.
    units: Option<[f64; 2]>,
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
        Ok(Self { designs, free, cells, evidence, units: None, known: BTreeMap::new(), simulation })
    }

    fn none(&self) -> Displacement {
        Displacement(vec![0; self.designs.combinations().counts().len()])
    }

    /// Asks at once for what several displacements are told by.
    fn look_ahead<'d>(&mut self, all: impl Iterator<Item = &'d Displacement>) -> Result<(), Error> {
        let unknown = all.filter(|one| !self.known.contains_key(one));
        let there = unknown.flat_map(|one| self.cells.iter().map(|&cell| one.of(self.designs, cell)));
        let there: Vec<Cell> = there.collect();
        self.simulation.says(self.designs, &there)?;
        Ok(())
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
        let there: Vec<Cell> = self.cells.iter().map(|&cell| one.of(self.designs, cell)).collect();
        let Some(mut said) = self.simulation.says(self.designs, &there)? else { return Ok(f64::NEG_INFINITY) };
        let [mean, deviation] = *self.units.get_or_insert_with(|| mean_and_deviation(&said));
        if deviation <= 0.0 {
            return Ok(f64::NEG_INFINITY);
        }
        // Beyond the bounds nobody knows what it would say.
        let known: Vec<f64> = self.cells.iter().map(|&cell| correlation(one.beyond(self.designs, cell))).collect();
        said.iter_mut().zip(&known).for_each(|(value, known)| *value = known * (*value - mean) / deviation);
        let unknown: Vec<f64> = known.into_iter().map(left_of).collect();
        let counts = self.designs.combinations().counts();
        let far: f64 =
            one.0.iter().zip(counts).map(|(step, count)| (share(*step, *count) / usual(self.free.len())).powi(2)).sum();
        let probability = self.evidence.log_likelihood_in_part(&said, &unknown)? - 0.5 * far;
        self.known.insert(one.clone(), probability);
        Ok(probability)
    }

    /// The most probable one: by steps along each axis from the best of those that were drawn.
    fn best(&mut self, rng: &mut ChaCha8Rng) -> Result<(Displacement, f64), Error> {
        let mut drawn = vec![self.none()];
        drawn.extend((0..DRAWN).map(|_| self.draw(rng)));
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
        Ok(best)
    }

    /// Standard deviations of the most probable one in the unit of each parameter, from how the logarithm of the probability bends around
    /// it (Laplace's method), and because it is a whole number of steps.
    fn deviations(&mut self, best: &Displacement) -> Result<Vec<f64>, Error> {
        let counts = self.designs.combinations().counts().to_vec();
        let (free, n_free) = (self.free.clone(), self.free.len());
        let step = |axis: usize| steps(LEAST_STEP, counts[axis]).max(1);
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
            let least = (share(step(a), counts[a]) / usual(n_free)).powi(2);
            precision[(row, row)] = bend((a, a))?.max(least);
        }
        for (row, &a) in free.iter().enumerate() {
            for (column, &b) in free.iter().enumerate().take(row) {
                let both = 0.5 * (bend((b.min(a), b.max(a)))? - precision[(row, row)] - precision[(column, column)]);
                (precision[(row, column)], precision[(column, row)]) = (both, both);
            }
        }
        let alone = |row: usize| 1.0 / precision[(row, row)];
        // Where it bends up along some way between the axes, each is told alone.
        let inverse = precision.llt(Side::Lower).ok().map(|factor| factor.inverse());
        let variance = |row: usize| inverse.as_ref().map_or_else(|| alone(row), |inverse| inverse[(row, row)]);
        let mut deviations = vec![0.0; counts.len()];
        for (row, &axis) in free.iter().enumerate() {
            let in_steps = (variance(row) + WITHIN_A_STEP.powi(2)).sqrt();
            let width = self.designs.region().parameters()[axis].width();
            deviations[axis] = in_steps * share(step(axis), counts[axis]) * width;
        }
        Ok(deviations)
    }

    /// Squared correlation of the readings with what the simulation says of their own designs.
    fn explained_in_place(&mut self, readings: &[Reading]) -> Result<f64, Error> {
        let Some(said) = self.simulation.says(self.designs, &self.cells)? else { return Ok(0.0) };
        let responses: Vec<f64> = readings.iter().map(|reading| reading.response).collect();
        Ok(correlation_of(&said, &responses).powi(2))
    }

    fn draw(&self, rng: &mut ChaCha8Rng) -> Displacement {
        let (mut one, counts) = (self.none(), self.designs.combinations().counts());
        for &axis in &self.free {
            let normal: f64 = StandardNormal.sample(rng);
            one.0[axis] = steps((usual(self.free.len()) * normal).clamp(-MOST, MOST), counts[axis]);
        }
        one
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

    use super::*;
    use crate::pooled::bands::NINE_IN_TEN;
    use crate::pooled::settings::Settings;

    const LEVELS: i64 = 21;

    fn designs() -> Designs {
        let number = |name: &str| {
            let number = Parameter::continuous(name, "mm", 0.0, 10.0).unwrap();
            number.with_levels(LEVELS as u32).unwrap()
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
        let mut runs = Runs { simulated: &mut Simulated::default(), simulate: &mut simulate };
        believed(registered(&readings, &designs, &mut rng, &mut runs).unwrap())
    }

    fn registration(by: [i64; 2], n: usize, noise: f64, seed: u64) -> Option<(Displacement, Registration)> {
        let (designs, mut rng) = (designs(), ChaCha8Rng::seed_from_u64(seed));
        let readings = readings(&designs, by, n, noise, &mut rng);
        let mut simulate = |cell: Cell, _: &[f64]| Ok::<f64, String>(at(&designs, cell, [0, 0]));
        let mut runs = Runs { simulated: &mut Simulated::default(), simulate: &mut simulate };
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

    #[test]
    fn a_simulation_that_says_nothing_is_not_displaced() {
        assert!(found([2, 2], 30, 0.01, 1, |_, _| 4.0).is_none(), "the same everywhere");
        assert!(found([2, 2], 6, 0.01, 1, |designs, cell| at(designs, cell, [0, 0])).is_none(), "too few runs");
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
