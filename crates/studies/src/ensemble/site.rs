//! A plant in a world: what designs cost in its model, what an experiment reads, and what a design truly shows.

use std::collections::HashMap;
use std::sync::Mutex;
use std::sync::PoisonError;
use std::sync::atomic::{AtomicUsize, Ordering};

use anyhow::Result;
use rayon::prelude::*;
use water_channel::{BoundedNoise, CostWeights, LogRow, MovingWater, Rig, Sensing, TestProfile};

use super::file::Setup;
use super::row::{N_READINGS, Reading, Readings, World};
use crate::bat::{Bat, STAND_IN};
use crate::calibration::Plant;
use crate::costs::Cost;
use crate::logged::Logged;

/// Experiments have seeds from here on, so that none shares its water with the flights that are the truth.
const FIRST_OF_EXPERIMENTS: u64 = 1_000_000;
/// Between the seeds of two campaigns.
const BETWEEN_CAMPAIGNS: u64 = 10_000;
/// The end of the test over which an error counts as steady, in s.
const STEADY_S: f64 = 10.0;

/// What is added to a cost where the world has no noise of its own.
#[derive(Clone, Copy, Debug)]
pub(super) enum Noise {
    /// Largest share of the cost itself.
    OfCost(f64),
    /// Largest error, in s.
    Absolute(f64),
}

/// What a design shows in a flight.
#[derive(Clone, Debug)]
struct Shown {
    readings: Readings,
    /// The cameras that saw no dot in any image, by their place.
    blind: Vec<usize>,
}

/// What a design truly shows in all of its flights.
#[derive(Clone, Debug)]
struct Seen {
    readings: Readings,
    /// Of each flight that came to its end.
    blind: Vec<Vec<usize>>,
}

/// A plant in a world.
#[derive(Debug)]
pub(super) struct Site {
    world: World,
    /// What experiments are made on.
    rig: Bat,
    /// The same in the water of each of the flights that are the truth.
    truths: Vec<Bat>,
    seen: Mutex<HashMap<Vec<u64>, Seen>>,
    n_seeded: AtomicUsize,
}

impl Site {
    /// A plant with these weights; `base` has the variables.
    pub(super) fn new(setup: &Setup, base: &Bat, plant: &Plant, weights: CostWeights, world: World) -> Result<Self> {
        let (rig, truths) = if world == World::Still {
            let on = || base.on(plant.rig.clone(), weights, setup.still.clone());
            (on(), vec![on()])
        } else {
            let rig = setup.lopsided(plant);
            let truths = (1..=setup.campaigns.truth_seeds).map(|seed| {
                let seen = || Sensing { seed, ..setup.sensing.clone() };
                let rig = Rig { sensing: (world == World::Cameras).then(seen), ..rig.clone() };
                Ok(base.on(rig, weights, seeded(setup, seed)?))
            });
            (base.on(rig.clone(), weights, setup.moving().clone()), truths.collect::<Result<_>>()?)
        };
        Ok(Self { world, rig, truths, seen: Mutex::default(), n_seeded: AtomicUsize::new(0) })
    }

    /// What experiments read, each by its number within the campaign of a seed.
    pub(super) fn read(&self, seed: u64, experiments: &[(u64, Vec<f64>)], noise: Noise) -> Vec<Cost> {
        let points: Vec<Vec<f64>> = experiments.iter().map(|(_, point)| point.clone()).collect();
        if self.world == World::Still {
            let costs = self.rig.costs(&points, STAND_IN, |_| {});
            let read = |((id, _), cost): (&(u64, Vec<f64>), Cost)| noisy(cost, noise, seed, *id);
            return experiments.iter().zip(costs).map(read).collect();
        }
        let of_flight = |(id, _): &(u64, Vec<f64>)| FIRST_OF_EXPERIMENTS + BETWEEN_CAMPAIGNS * seed + id;
        let seeds: Vec<u64> = experiments.iter().map(of_flight).collect();
        self.n_seeded.fetch_add(points.len(), Ordering::Relaxed);
        self.rig.seeded_costs(&points, &seeds, STAND_IN)
    }

    /// What designs truly show, in their order.
    pub(super) fn observe(&self, points: &[Vec<f64>]) -> Vec<Readings> {
        let mut seen = self.seen.lock().unwrap_or_else(PoisonError::into_inner);
        let mut unknown: Vec<&Vec<f64>> = points.iter().filter(|point| !seen.contains_key(&bits(point))).collect();
        unknown.sort_by_key(|point| bits(point));
        unknown.dedup_by_key(|point| bits(point));
        let flights = unknown.par_iter().flat_map(|point| self.truths.par_iter().map(|bat| fly(bat, point)));
        let flights: Vec<Option<Shown>> = flights.collect();
        self.n_seeded.fetch_add(flights.len(), Ordering::Relaxed);
        for (point, flights) in unknown.iter().zip(flights.chunks(self.truths.len())) {
            let blind = flights.iter().flatten().map(|shown| shown.blind.clone()).collect();
            let flights: Vec<Option<Readings>> =
                flights.iter().map(|shown| shown.as_ref().map(|shown| shown.readings)).collect();
            seen.insert(bits(point), Seen { readings: mean(&flights), blind });
        }
        let of = |point: &Vec<f64>| seen.get(&bits(point)).map_or([f64::NAN; N_READINGS], |seen| seen.readings);
        points.iter().map(of).collect()
    }

    /// Of each flight so far that came to its end the cameras that saw no dot in it, by their place.
    pub(super) fn blind_cameras(&self) -> Vec<Vec<usize>> {
        let seen = self.seen.lock().unwrap_or_else(PoisonError::into_inner);
        seen.values().flat_map(|seen| seen.blind.iter().cloned()).collect()
    }

    /// How many flights were made of experiments and of what designs truly show.
    pub(super) fn n_flights(&self) -> usize {
        self.rig.n_known(STAND_IN) + self.n_seeded.load(Ordering::Relaxed)
    }

    /// The rig of the experiments.
    pub(super) fn rig(&self) -> &Bat {
        &self.rig
    }
}

/// A plant with sides that differ, and the test in the water of the first flight that is the truth.
pub(super) fn lopsided_in_water(setup: &Setup, plant: &Plant) -> Result<(Rig, TestProfile)> {
    Ok((setup.lopsided(plant), seeded(setup, 1)?))
}

/// The test in the water of another seed.
fn seeded(setup: &Setup, seed: u64) -> Result<TestProfile> {
    let profile = setup.moving().clone();
    match profile.water().copied() {
        Some(water) => Ok(profile.with_water(MovingWater { seed, ..water })?),
        None => Ok(profile),
    }
}

fn noisy(cost: Cost, noise: Noise, seed: u64, id: u64) -> Cost {
    let error = |share: f64| -> Result<f64, String> {
        Ok(BoundedNoise::new(share, seed).map_err(|error| error.to_string())?.relative_error(id))
    };
    let cost = cost?;
    Ok(match noise {
        Noise::OfCost(share) => cost * (1.0 + error(share)?),
        // Half of it, twice: a share must be less than 1.
        Noise::Absolute(largest) => cost + 2.0 * largest * error(0.5)?,
    })
}

fn bits(point: &[f64]) -> Vec<u64> {
    point.iter().map(|x| x.to_bits()).collect()
}

fn fly(bat: &Bat, point: &[f64]) -> Option<Shown> {
    let logged = bat.logged(point, STAND_IN).ok()?;
    let mut readings = [f64::NAN; N_READINGS];
    let mut set = |reading: Reading, value: f64| readings[reading as usize] = value;
    let square = |of: fn(&LogRow) -> f64| logged.mean(|row| of(row).to_degrees().powi(2));
    set(Reading::Cost, logged.cost.total);
    set(Reading::Heading, square(|row| row.heading_rad));
    set(Reading::Pitch, square(|row| row.pitch_error_rad));
    set(Reading::Roll, square(|row| row.roll_error_rad));
    set(Reading::RollOffset, logged.mean(|row| row.roll_error_rad.to_degrees()).abs());
    set(Reading::Zenith, logged.mean(|row| row.zenith_rad().to_degrees()));
    set(Reading::Altitude, logged.mean(|row| (100.0 * row.altitude_error_m).powi(2)));
    set(Reading::Footprint, 1e4 * logged.mean(LogRow::footprint_m2));
    set(Reading::SteadyPitch, steady(&logged, |row| row.pitch_error_rad.to_degrees()));
    set(Reading::Held, held(&logged));
    Some(Shown { readings, blind: logged.flight.blind_cameras })
}

/// Magnitude of the mean over the end of the test.
fn steady(logged: &Logged, of: fn(&LogRow) -> f64) -> f64 {
    let end_s = logged.log.rows.last().map_or(0.0, |row| row.time_s) - STEADY_S;
    let values: Vec<f64> = logged.log.rows.iter().filter(|row| row.time_s >= end_s).map(of).collect();
    (values.iter().sum::<f64>() / values.len() as f64).abs()
}

/// Share of the samples at which the cameras had no new pose; not finite without cameras. The first second does not count: there is no
/// image yet.
fn held(logged: &Logged) -> f64 {
    let rows = logged.log.rows.iter().filter(|row| row.time_s > 1.0);
    let estimates: Vec<bool> =
        rows.filter_map(|row| row.estimate.as_ref().map(|estimate| estimate.hold.is_some())).collect();
    estimates.iter().filter(|held| **held).count() as f64 / estimates.len() as f64
}

/// Means over flights, and the spread of their costs; nothing where one of them fails.
fn mean(flights: &[Option<Readings>]) -> Readings {
    let Some(flights) = flights.iter().copied().collect::<Option<Vec<Readings>>>() else {
        return [f64::NAN; N_READINGS];
    };
    let n = flights.len() as f64;
    let mut means: Readings = core::array::from_fn(|k| flights.iter().map(|flight| flight[k]).sum::<f64>() / n);
    let cost = means[Reading::Cost as usize];
    let squares: f64 = flights.iter().map(|flight| (flight[Reading::Cost as usize] - cost).powi(2)).sum();
    means[Reading::CostSd as usize] = if flights.len() > 1 { (squares / (n - 1.0)).sqrt() } else { f64::NAN };
    means
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn absolute_noise_stays_within_its_bound_and_follows_its_number() {
        let errors: Vec<f64> = (1..500)
            .filter_map(|id| noisy(Ok(10.0), Noise::Absolute(3.0), 1, id).ok().map(|cost| cost - 10.0))
            .collect();
        assert_eq!(errors.len(), 499);
        assert!(errors.iter().all(|error| error.abs() <= 3.0));
        assert!(errors.iter().any(|error| *error > 2.5) && errors.iter().any(|error| *error < -2.5));
        assert_eq!(noisy(Ok(10.0), Noise::Absolute(3.0), 1, 7), noisy(Ok(10.0), Noise::Absolute(3.0), 1, 7));
        assert!(noisy(Err("slack".to_owned()), Noise::OfCost(0.1), 1, 1).is_err());
    }

    #[test]
    fn one_flight_that_fails_leaves_a_design_without_readings() {
        let flight = |cost: f64| {
            let mut readings = [1.0; N_READINGS];
            readings[Reading::Cost as usize] = cost;
            Some(readings)
        };
        let found = mean(&[flight(1.0), flight(3.0)]);
        assert!((found[Reading::Cost as usize] - 2.0).abs() < 1e-12);
        assert!((found[Reading::CostSd as usize] - 2f64.sqrt()).abs() < 1e-12, "sd of 1 and 3 by n - 1");
        assert!(mean(&[flight(1.0), None]).iter().all(|reading| reading.is_nan()));
    }

    /// Two worlds of one plant: what designs show and what experiments read have the same bits on any number of threads, and each
    /// experiment of a campaign meets water of its own.
    #[test]
    fn flights_do_not_depend_on_threads() -> Result<()> {
        let setup = Setup::read(&std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../.."))?;
        let (plant, case) = (&setup.plants[0], &setup.chapter7.cases[0]);
        let points = [vec![47.0, 5.0], vec![50.0, 9.0], vec![47.0, 5.0]];
        let experiments = [(1, points[0].clone()), (2, points[0].clone())];
        let fly = |world: World, threads: usize| -> Result<(Vec<Readings>, Vec<Cost>)> {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
            let site = Site::new(&setup, &case.bat, plant, plant.weights[1], world)?;
            Ok(pool.install(|| (site.observe(&points), site.read(1, &experiments, Noise::OfCost(0.01)))))
        };
        for world in World::OF_CAMPAIGNS {
            let (seen, read) = fly(world, 1)?;
            let (again, read_again) = fly(world, 3)?;
            let bits = |all: &[Readings]| all.iter().flatten().map(|x| x.to_bits()).collect::<Vec<u64>>();
            assert_eq!((bits(&seen), &read), (bits(&again), &read_again), "{world:?}");
            assert_eq!(bits(&seen[..1]), bits(&seen[2..]), "one design is one design");
            assert_ne!(read[0], read[1], "two experiments on it are two");
        }
        Ok(())
    }
}
