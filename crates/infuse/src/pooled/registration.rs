//! By how much a simulation is displaced, told from the readings: what is called registration where it is pictures that are laid over each
//! other.

use std::collections::{BTreeMap, BTreeSet};

use design_space::Cell;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use surface::Data;
use surface::process::RegressorEvidence;

use crate::Error;
use crate::pooled::designs::Designs;
use crate::pooled::displacement::{Displacement, LEAST_STEP, free, share, steps};
use crate::pooled::measurements::Reading;
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

/// The most probable one, if it is so much more so than none that the readings are sure of it.
pub(crate) fn registered(
    readings: &[Reading],
    designs: &Designs,
    rng: &mut ChaCha8Rng,
    simulation: &mut dyn Simulation,
) -> Result<Displacement, Error> {
    let free = free(designs);
    if free.is_empty() || readings.len() < designs.region().n_parameters() + FEWEST {
        return Ok(Displacement::default());
    }
    let mut search = Search::of(readings, designs, free, simulation)?;
    let none = search.none();
    let without = search.probability(&none)?;
    if without.is_infinite() {
        return Ok(none);
    }
    let (best, there) = search.best(rng)?;
    let surely = 0.5 * search.free.len() as f64 * (readings.len() as f64).ln() + SURELY;
    Ok(if there - without > surely { best } else { none })
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
        let [mean, deviation] = *self.units.get_or_insert_with(|| units(&said));
        if deviation <= 0.0 {
            return Ok(f64::NEG_INFINITY);
        }
        said.iter_mut().for_each(|value| *value = (*value - mean) / deviation);
        let counts = self.designs.combinations().counts();
        let far: f64 =
            one.0.iter().zip(counts).map(|(step, count)| (share(*step, *count) / usual(self.free.len())).powi(2)).sum();
        let probability = self.evidence.log_likelihood(&said)? - 0.5 * far;
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

fn units(values: &[f64]) -> [f64; 2] {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    [mean, (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / n).sqrt()]
}

#[cfg(test)]
mod tests {
    use design_space::{Parameter, Region};
    use proptest::prelude::*;
    use rand::SeedableRng as _;

    use super::*;
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
        registered(&readings, &designs, &mut rng, &mut runs).unwrap()
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
            let found = registered(&readings, &designs, &mut rng, &mut emulation).unwrap();
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
