//! Whether runs of a batch share an error that those of others do not have: a rig that drifts from day to day.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use surface::Data;
use surface::process::{AveragedProcess, GaussianProcess, Hyperparameters, Places, SamplerSettings, Sites, Structure};

use crate::Error;
use crate::pooled::block::Block;
use crate::pooled::measurements::Reading;

/// By how much a block reads above what is expected of its settings, in the mean.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Shift {
    /// Whose runs.
    pub block: Block,
    /// How many of them gave a response.
    pub n_readings: usize,
    /// In the unit of the response.
    pub by: f64,
}

/// That runs of one block, a batch say, read higher or lower than those of others, whatever their settings are.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Drift {
    /// The logarithm of how many times more probable the readings are if blocks share an error, the lesser of two estimates.
    pub gain: f64,
    /// Standard deviation of that error.
    pub deviation: f64,
    /// Standard deviation of one run besides it.
    pub noise: f64,
    /// Of each block, sources behind batches.
    pub shifts: Vec<Shift>,
}

/// The readings of each block, by their places, and whose they are.
pub(crate) struct Members<'a>(BTreeMap<&'a Block, Vec<usize>>);

impl<'a> Members<'a> {
    /// Of readings whose numbers count the blocks; what has none is left out.
    pub(crate) fn of(readings: &[Reading], blocks: &'a [Block]) -> Self {
        let mut members: BTreeMap<&Block, Vec<usize>> = BTreeMap::new();
        for (at, reading) in readings.iter().enumerate() {
            if let Some(block) = blocks.get(reading.number) {
                members.entry(block).or_default().push(at);
            }
        }
        Self(members)
    }

    /// Readings of blocks of several designs, by their places, ascending; and how many such blocks there are.
    fn telling(&self, readings: &[Reading]) -> (Vec<usize>, usize) {
        let n_designs =
            |members: &Vec<usize>| members.iter().map(|&at| readings[at].cell).collect::<BTreeSet<_>>().len();
        let telling: Vec<&Vec<usize>> =
            self.0.values().filter(|members| n_designs(members) >= FEWEST_OF_A_BLOCK).collect();
        let mut at: Vec<usize> = telling.iter().copied().flatten().copied().collect();
        at.sort_unstable();
        (at, telling.len())
    }

    /// The number of the block of each of so many readings; none if one has none.
    fn numbers(&self, n_readings: usize) -> Option<Vec<usize>> {
        let mut numbers = vec![None; n_readings];
        for (number, members) in self.0.values().enumerate() {
            members.iter().for_each(|&at| numbers[at] = Some(number));
        }
        numbers.into_iter().collect()
    }
}

impl Shift {
    /// Of each block, by how much each reading is above what is expected of its settings.
    pub(crate) fn of_each(members: &Members<'_>, beyond: &[f64]) -> Vec<Self> {
        let mean = |members: &[usize]| members.iter().map(|&at| beyond[at]).sum::<f64>() / members.len() as f64;
        let of_block = |(block, members): (&&Block, &Vec<usize>)| Self {
            block: (*block).clone(),
            n_readings: members.len(),
            by: mean(members),
        };
        members.0.iter().map(of_block).collect()
    }
}

impl Drift {
    /// From this gain on it is believed: seldom where nothing drifts, as `docs/results-drift.md` counts.
    pub const SURE: f64 = 3.0;

    /// Whether the readings are sure of it.
    #[must_use]
    pub fn is_sure(&self) -> bool {
        self.gain >= Self::SURE
    }
}

/// Fewer readings tell nothing,
const FEWEST: usize = 8;
/// and neither does a block of fewer designs: what all its runs read more, as those that confirm a design, may be the design's.
const FEWEST_OF_A_BLOCK: usize = 3;
/// So many particles are learnt with a shared error, and as many without, to tell which explains the readings.
const COMPARED: usize = 96;
/// What a drift was taken for may have made the noise larger: its variance may be so many times that of the surface.
const OF_THE_NOISE: [f64; 3] = [1.0, 0.25, 0.0625];
/// Variances of the shared error that are tried, in multiples of that of the noise.
const SHARED: [f64; 5] = [0.25, 1.0, 4.0, 16.0, 64.0];

/// One way in which readings may have come about.
struct Case {
    structure: Structure,
    hyper: Hyperparameters,
    is_shared: bool,
}

impl Drift {
    /// What the readings say, with what the simulation says of the place of each. None for few readings, or if fewer than two blocks have
    /// several designs; of other blocks nothing is said.
    ///
    /// A surface that is wrong where a batch lies asks for a shared error, too. So there are two witnesses, and the lesser gain counts: with
    /// structures and hyperparameters that were learnt without a shared error, the `particles`; and, where these are sure, with those that this
    /// sampler learns either way.
    pub(crate) fn of(
        readings: &[Reading],
        blocks: &[Block],
        places: &Places,
        particles: &[GaussianProcess],
        sampler: &SamplerSettings,
    ) -> Result<Option<Self>, Error> {
        let members = Members::of(readings, blocks);
        let (telling, n_blocks) = members.telling(readings);
        if telling.len() < FEWEST || n_blocks < 2 {
            return Ok(None);
        }
        if telling.len() < readings.len() {
            let of_them: Vec<Reading> = telling.iter().map(|&at| readings[at].clone()).collect();
            return Self::of(&of_them, blocks, &places.select(&telling), particles, sampler);
        }
        let Some(numbers) = members.numbers(readings.len()) else { return Ok(None) };
        let coordinates = readings.iter().flat_map(|reading| &reading.coded).copied().collect();
        let responses = readings.iter().map(|reading| reading.response).collect();
        let data = Data::new(places.n_factors(), coordinates, responses)?;
        let sites = Sites::in_assemblies(&data, places.simulated(), &numbers)?
            .with_deviations(places.deviations())?
            .with_unknown(places.unknown())?;
        let sites = Arc::new(sites);
        let of_the_noise = if sampler.noise.is_some() { &OF_THE_NOISE[..1] } else { &OF_THE_NOISE };
        let cases: Vec<Case> = particles
            .iter()
            .flat_map(|particle| of_the_noise.iter().map(move |times| (particle, times)))
            .flat_map(|(particle, times)| [0.0].iter().chain(&SHARED).map(move |shared| (particle, *times, *shared)))
            .map(|(particle, times, shared)| {
                let mut hyper = particle.hyperparameters().clone();
                hyper.noise *= times;
                hyper.assembly = shared * hyper.noise;
                Case { structure: particle.structure(), hyper, is_shared: shared > 0.0 }
            })
            .collect();
        let fitted = cases
            .into_par_iter()
            .map(|case| {
                let process = GaussianProcess::new(Arc::clone(&sites), case.structure, case.hyper)?;
                Ok::<_, Error>((process.log_likelihood(), case.is_shared, process))
            })
            .collect::<Result<Vec<_>, _>>()?;
        let likelihoods =
            |is_shared: bool| fitted.iter().filter(move |one| one.1 == is_shared).map(|one| one.0).collect::<Vec<_>>();
        let mut gain = log_mean_exp(&likelihoods(true)) - log_mean_exp(&likelihoods(false));
        if gain >= Self::SURE {
            gain = gain.min(gain_of_both(&sites, sampler)?);
        }
        let shared: Vec<&(f64, bool, GaussianProcess)> = fitted.iter().filter(|one| one.1).collect();
        let largest = shared.iter().map(|one| one.0).fold(f64::NEG_INFINITY, f64::max);
        let weights: Vec<f64> = shared.iter().map(|one| (one.0 - largest).exp()).collect();
        let total: f64 = weights.iter().sum();
        let mut beyond = vec![0.0; readings.len()];
        let (mut deviation, mut noise) = (0.0, 0.0);
        for ((_, _, process), weight) in shared.iter().zip(&weights) {
            // What weighs next to nothing is not worth its prediction.
            if *weight < 1e-3 {
                continue;
            }
            let share = weight / total;
            deviation += share * process.assembly_deviation();
            noise += share * process.noise();
            let expected = process.means(places)?;
            for ((beyond, reading), expected) in beyond.iter_mut().zip(readings).zip(expected) {
                *beyond += share * (reading.response - expected);
            }
        }
        let shifts = Shift::of_each(&members, &beyond);
        Ok((gain.is_finite() && deviation.is_finite()).then_some(Self { gain, deviation, noise, shifts }))
    }
}

/// By how much the evidence is greater with a shared error than without, each way with all that it leaves possible.
fn gain_of_both(sites: &Sites, sampler: &SamplerSettings) -> Result<f64, Error> {
    let [with, without] = [true, false].map(|shared_error| {
        let sampler = SamplerSettings { shared_error, particles: COMPARED, ..sampler.clone() };
        AveragedProcess::new(sites.clone(), &sampler).map(|process| process.log_evidence())
    });
    Ok(with? - without?)
}

/// The logarithm of the mean of what these are logarithms of.
fn log_mean_exp(logarithms: &[f64]) -> f64 {
    let largest = logarithms.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let sum: f64 = logarithms.iter().map(|one| (one - largest).exp()).sum();
    largest + (sum / logarithms.len().max(1) as f64).ln()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pooled::scene::Scene;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    /// Three batches of ten runs of a bowl with this noise; each reads by so much more than the truth. What is made of the readings, in a unit.
    fn seen(shifts: [f64; 3], noise: f64, seed: u64, unit: f64) -> Option<Drift> {
        let mut scene = Scene::new(&[21, 21]);
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut blocks = Vec::new();
        for (batch, shift) in (1..).zip(shifts) {
            for _ in 0..10 {
                let digits = [rng.random_range(0..21), rng.random_range(0..21)];
                let [x, y] = digits.map(|digit| digit as f64 / 20.0);
                let normal: f64 = StandardNormal.sample(&mut rng);
                let truth = (x - 0.6).powi(2) + 2.0 * (y - 0.3).powi(2);
                scene.read(&digits, unit * (truth + noise * normal + shift));
                blocks.push(Block::Batch(batch));
            }
        }
        of_scene(&mut scene, &blocks)
    }

    fn of_scene(scene: &mut Scene, blocks: &[Block]) -> Option<Drift> {
        scene.settings.particles = 12;
        let readings = scene.readings.clone();
        let mut knowledge = scene.knowledge(None);
        let cells: Vec<_> = readings.iter().map(|reading| reading.cell).collect();
        let places = knowledge.places(&cells).unwrap();
        Drift::of(&readings, blocks, &places, knowledge.process.particles(), &scene.settings.sampler()).unwrap()
    }

    /// Of 40 rigs that stand still at most two are believed to drift; of 20 that are off by four noises all are, and by about as much.
    #[test]
    fn a_rig_that_drifts_is_found_out_and_one_that_stands_still_is_not() {
        let still =
            (0..40).filter(|&seed| seen([0.0; 3], 0.05, seed, 1.0).is_some_and(|drift| drift.is_sure())).count();
        assert!(still <= 2, "{still} of 40 that stand still");
        for seed in 0..20 {
            let drift = seen([0.0, 0.2, -0.2], 0.05, seed, 1.0).unwrap();
            assert!(drift.is_sure(), "seed {seed}: {drift:?}");
            let of: Vec<f64> = drift.shifts.iter().map(|shift| shift.by).collect();
            assert!((of[1] - of[0] - 0.2).abs() < 0.1 && (of[2] - of[0] + 0.2).abs() < 0.1, "seed {seed}: {of:?}");
            assert!((0.05..0.8).contains(&drift.deviation), "seed {seed}: {drift:?}");
            assert!(drift.shifts.iter().all(|shift| shift.n_readings == 10));
        }
    }

    /// Three batches over four parameters, the later ones about where the first was lowest, of a truth with a crease: surfaces are wrong there,
    /// and no rig drifts.
    #[test]
    fn a_surface_that_is_wrong_where_later_batches_are_is_no_drift() {
        let mut n_sure = 0;
        for seed in 0..40 {
            let mut scene = Scene::new(&[21; 4]);
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let truth = |x: &[f64]| {
                let far: f64 = x.iter().map(|x| (x - 0.5).abs()).sum();
                far.powf(0.6) + (1.3 * x[0] + x[1] - 0.9 * x[2]).sin().abs() * 0.6
            };
            let mut blocks = Vec::new();
            for batch in 1..=3 {
                for _ in 0..14 {
                    let digits: [u64; 4] = std::array::from_fn(|_| match batch {
                        1 => rng.random_range(0..21),
                        2 => rng.random_range(6..15),
                        _ => rng.random_range(9..12),
                    });
                    let normal: f64 = StandardNormal.sample(&mut rng);
                    scene.read(&digits, truth(&digits.map(|digit| digit as f64 / 20.0)) + 0.005 * normal);
                    blocks.push(Block::Batch(batch));
                }
            }
            n_sure += usize::from(of_scene(&mut scene, &blocks).is_some_and(|drift| drift.is_sure()));
        }
        assert!(n_sure <= 1, "{n_sure} of 40");
    }

    /// What all runs read more is no drift, and neither is another unit.
    #[test]
    fn what_is_said_of_a_drift_does_not_hang_on_the_zero_or_the_unit_of_the_response() {
        for shifts in [[0.0, 0.1, 0.05], [0.0; 3]] {
            let plain = seen(shifts, 0.05, 3, 1.0).unwrap();
            let all_more = seen(shifts.map(|shift| shift + 7.0), 0.05, 3, 1.0).unwrap();
            let in_milli = seen(shifts, 0.05, 3, 1000.0).unwrap();
            for (other, unit) in [(all_more, 1.0), (in_milli, 1000.0)] {
                assert!((other.gain - plain.gain).abs() < 1e-6, "{other:?} {plain:?}");
                assert!(
                    (other.deviation - unit * plain.deviation).abs() < 1e-6 * other.deviation,
                    "{other:?} {plain:?}"
                );
            }
        }
    }

    #[test]
    fn one_batch_and_a_few_runs_tell_nothing_of_a_drift() {
        let of = |blocks: &[usize]| {
            let mut scene = Scene::new(&[21, 21]);
            for (at, block) in blocks.iter().enumerate() {
                scene.read(&[at as u64, (7 * at as u64) % 21], at as f64 + 5.0 * *block as f64);
            }
            of_scene(&mut scene, &blocks.iter().map(|block| Block::Batch(*block)).collect::<Vec<_>>())
        };
        assert_eq!(of(&[1; 12]), None, "one batch");
        assert_eq!(of(&[1, 1, 1, 2, 2, 2]), None, "six runs");
        assert_eq!(of(&[1, 1, 1, 1, 1, 1, 1, 1, 2, 2]), None, "two of the second batch");
        assert!(of(&[1, 1, 1, 1, 1, 1, 1, 2, 2, 2]).is_some());
    }

    /// A batch of one design that reads far from what is expected of it, as one that confirms, may tell of the design: whether the rig drifts is
    /// asked of the others alone.
    #[test]
    fn a_batch_that_confirms_a_design_is_no_drift() {
        for (above, seed) in [(0.0, 1), (0.0, 2), (1.0, 3), (1.0, 4)] {
            let mut scene = Scene::new(&[21, 21]);
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let mut blocks = Vec::new();
            for batch in 1..=2 {
                for _ in 0..10 {
                    let digits = [rng.random_range(0..21), rng.random_range(0..21)];
                    let [x, y] = digits.map(|digit| digit as f64 / 20.0);
                    let normal: f64 = StandardNormal.sample(&mut rng);
                    let shift = above * (batch - 1) as f64;
                    scene.read(&digits, (x - 0.6).powi(2) + 2.0 * (y - 0.3).powi(2) + 0.02 * normal + shift);
                    blocks.push(Block::Batch(batch));
                }
            }
            let before = of_scene(&mut scene, &blocks).unwrap();
            for normal in [0.02, -0.01, 0.0] {
                scene.read(&[12, 6], 1.0 + normal);
                blocks.push(Block::Batch(3));
            }
            let with_it = of_scene(&mut scene, &blocks).unwrap();
            assert_eq!((before.is_sure(), with_it.is_sure()), (above > 0.0, above > 0.0), "{before:?} {with_it:?}");
            assert!(with_it.shifts.len() == 2 && with_it.shifts.iter().all(|shift| shift.n_readings == 10));
        }
    }

    /// (e + 3e) / 2 is 2e, of which the logarithm is 1 + ln 2; as large as numbers may be.
    #[test]
    fn mean_of_what_logarithms_are_of() {
        for at in [0.0, 1e4, -1e4] {
            let found = log_mean_exp(&[at + 1.0, at + 1.0 + 3.0_f64.ln()]);
            assert!((found - at - 1.0 - 2.0_f64.ln()).abs() < 1e-9, "{found} at {at}");
        }
    }
}
