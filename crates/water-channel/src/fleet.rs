//! Many flights of one test: lanes within a core, threads across cores, each flight on its own.

use bat_dynamics::{FlightState, LANES, Lanes, Plant};
use multiversion::multiversion;
use rayon::prelude::*;

use crate::error::{Error, FlightError};
use crate::flight::{Flight, FlightRequest, Kind, Ready, Tables, check_log, fly_logged};
use crate::integrate::{Ending, Setup, integrate};
use crate::log::{FlightLog, LogRow};
use crate::profile::TestProfile;
use crate::settings::FlightSettings;

/// Flies every request through `profile`, in parallel; result `i` belongs to request `i`.
///
/// Each result has the same bits as that of [`fly`](crate::fly), whatever flies beside it and however many
/// threads there are. `finished` is called with the number of flights that a finished batch adds, from any thread.
pub fn fly_all(
    requests: &[FlightRequest],
    profile: &TestProfile,
    settings: &FlightSettings,
    finished: impl Fn(usize) + Sync,
) -> Vec<Result<Flight, FlightError>> {
    fly_chunks(requests, None, profile, settings, finished)
}

/// Flies like [`fly_all`], the water of request `i` from `seeds[i]` in place of the seed of the profile.
///
/// Each result has the bits of [`fly`](crate::fly) in a profile with that seed. Still and recorded water has no seed: all seeds
/// are then one. With another number of seeds than of requests every result is an error.
pub fn fly_seeded(
    requests: &[FlightRequest],
    seeds: &[u64],
    profile: &TestProfile,
    settings: &FlightSettings,
    finished: impl Fn(usize) + Sync,
) -> Vec<Result<Flight, FlightError>> {
    if seeds.len() != requests.len() {
        let (name, value) = ("number of seeds", seeds.len() as f64);
        let error = Error::Argument { name, value, expected: "one per request" };
        return requests.iter().map(|_| Err(error.clone().into())).collect();
    }
    fly_chunks(requests, Some(seeds), profile, settings, finished)
}

/// Flies like [`fly_all`] and keeps every `every`-th sample of each flight.
///
/// Each result has the bits of [`fly_logged`]; a flight that fails has no log.
pub fn fly_all_logged(
    requests: &[FlightRequest],
    profile: &TestProfile,
    settings: &FlightSettings,
    every: usize,
) -> Vec<Result<(Flight, FlightLog), FlightError>> {
    let alone = |request: &FlightRequest| {
        let (flight, log) = fly_logged(request, profile, settings, every)?;
        Ok((flight?, log))
    };
    let fly = |chunk: &[FlightRequest]| {
        let abreast = logged_abreast(chunk, profile, settings, every);
        abreast.unwrap_or_else(|| chunk.iter().map(alone).collect())
    };
    requests.par_chunks(LANES).flat_map_iter(fly).collect()
}

/// Up to `LANES` flights side by side with their logs; none where they do not all begin, or one is not of the plain kind: then each
/// has to fly alone.
fn logged_abreast(
    requests: &[FlightRequest],
    profile: &TestProfile,
    settings: &FlightSettings,
    every: usize,
) -> Option<Vec<Result<(Flight, FlightLog), FlightError>>> {
    if requests.len() < 2 || every == 0 || settings.validate().is_err() {
        return None;
    }
    if requests.iter().any(|request| check_log(&request.rig, profile, every).is_err()) {
        return None;
    }
    let mut tables = Tables::of(profile);
    let ready = requests.iter().enumerate().map(|(k, request)| Ok((k, Ready::new(request, &mut tables, None)?)));
    let batch: Vec<(usize, Ready)> = ready.collect::<Result<_, Error>>().ok()?;
    let sample_time_s = batch[0].1.controller.parameters().sample_time_s;
    let fits = |one: &Ready| {
        one.kind() == Kind::Plain && one.controller.parameters().sample_time_s.to_bits() == sample_time_s.to_bits()
    };
    if !batch.iter().all(|(_, one)| fits(one)) {
        return None;
    }
    let mut logs = vec![FlightLog::default(); batch.len()];
    let (setup, start) = gathered(&batch, sample_time_s, profile, settings);
    let endings = integrate_plain_logged(&setup, start, requests, every, &mut logs);
    let flown = batch.into_iter().zip(endings).zip(logs);
    Some(flown.map(|(((_, one), ending), log)| Ok((one.finish(ending)?, log))).collect())
}

fn fly_chunks(
    requests: &[FlightRequest],
    seeds: Option<&[u64]>,
    profile: &TestProfile,
    settings: &FlightSettings,
    finished: impl Fn(usize) + Sync,
) -> Vec<Result<Flight, FlightError>> {
    if let Err(error) = settings.validate() {
        return requests.iter().map(|_| Err(error.clone().into())).collect();
    }
    let tables = match (requests.first(), seeds) {
        (Some(first), None) => Tables::shared_with(profile, first),
        (Some(first), Some(_)) => Tables::seeded(profile, first),
        (None, _) => Tables::of(profile),
    };
    requests
        .par_chunks(LANES)
        .enumerate()
        .flat_map_iter(|(number, chunk)| {
            let seeds = seeds.map(|seeds| &seeds[number * LANES..]);
            let results = fly_chunk(chunk, seeds, &mut tables.clone(), settings);
            finished(chunk.len());
            results
        })
        .collect()
}

/// Up to `LANES` flights side by side; those that cannot start are left out.
fn fly_chunk(
    requests: &[FlightRequest],
    seeds: Option<&[u64]>,
    tables: &mut Tables<'_>,
    settings: &FlightSettings,
) -> Vec<Result<Flight, FlightError>> {
    let profile = tables.profile();
    let mut results: Vec<Option<Result<Flight, FlightError>>> = Vec::with_capacity(requests.len());
    let mut ready: Vec<(usize, Ready)> = Vec::with_capacity(requests.len());
    for (index, request) in requests.iter().enumerate() {
        match Ready::new(request, tables, seeds.map(|seeds| seeds[index])) {
            Ok(one) => {
                results.push(None);
                ready.push((index, one));
            }
            Err(error) => results.push(Some(Err(error.into()))),
        }
    }
    // Flights in one batch share the instants of their samples and the code that flies them.
    let kind = |one: &Ready| (one.controller.parameters().sample_time_s.to_bits(), one.kind());
    while !ready.is_empty() {
        let first = kind(&ready[0].1);
        let sample_time_s = ready[0].1.controller.parameters().sample_time_s;
        let (batch, rest): (Vec<_>, Vec<_>) = ready.into_iter().partition(|(_, one)| kind(one) == first);
        ready = rest;
        let endings = fly_lanes(&batch, sample_time_s, profile, settings);
        for ((index, one), ending) in batch.into_iter().zip(endings) {
            results[index] = Some(one.finish(ending));
        }
    }
    results.into_iter().flatten().collect()
}

fn fly_lanes(
    batch: &[(usize, Ready)],
    sample_time_s: f64,
    profile: &TestProfile,
    settings: &FlightSettings,
) -> [Ending; LANES] {
    let (setup, start) = gathered(batch, sample_time_s, profile, settings);
    match batch[0].1.kind() {
        Kind::Plain => integrate_plain(&setup, start),
        Kind::Moving => integrate_moving(&setup, start),
        Kind::Lopsided => integrate_lopsided(&setup, start),
    }
}

/// Flights that are ready, lane by lane, with where each starts.
fn gathered<'a>(
    batch: &'a [(usize, Ready)],
    sample_time_s: f64,
    profile: &'a TestProfile,
    settings: &'a FlightSettings,
) -> (Setup<'a, Lanes, LANES>, [&'a FlightState; LANES]) {
    // Unused lanes repeat the last flight.
    let lane = |k: usize| &batch[k.min(batch.len() - 1)].1;
    // All fly one test: either each has its water or none.
    let water = match core::array::from_fn(|k| lane(k).water.as_deref()) {
        [Some(a), Some(b), Some(c), Some(d)] => Some([a, b, c, d]),
        _ => None,
    };
    let setup = Setup {
        plant: Plant::gather(core::array::from_fn(|k| &lane(k).plant)),
        controllers: core::array::from_fn(|k| &lane(k).controller),
        viewers: core::array::from_fn(|k| lane(k).viewer.as_ref()),
        sample_time_s,
        profile,
        settings,
        water,
        meters: core::array::from_fn(|k| lane(k).meter),
        used: batch.len(),
    };
    (setup, core::array::from_fn(|k| &lane(k).start))
}

/// The loop compiled for several instruction sets, chosen when it runs; none of them contracts a product and a
/// sum into one rounding, so all give the same bits.
#[multiversion(targets("x86_64+avx+avx2"))]
fn integrate_plain(setup: &Setup<'_, Lanes, LANES>, start: [&FlightState; LANES]) -> [Ending; LANES] {
    integrate::<Lanes, LANES, false, false>(setup, start, |_| {})
}

/// Like [`integrate_plain`] with the samples of each flight.
#[multiversion(targets("x86_64+avx+avx2"))]
fn integrate_plain_logged(
    setup: &Setup<'_, Lanes, LANES>,
    start: [&FlightState; LANES],
    requests: &[FlightRequest],
    every: usize,
    logs: &mut [FlightLog],
) -> [Ending; LANES] {
    let mut sample = 0;
    integrate::<Lanes, LANES, false, false>(setup, start, |seen| {
        if sample % every == 0 {
            for (lane, (log, request)) in logs.iter_mut().zip(requests).enumerate() {
                log.rows.push(LogRow::of(seen, lane, &request.rig));
            }
        }
        sample += 1;
    })
}

/// Like [`integrate_plain`] for symmetric plants in water that moves beside its mean flow.
#[multiversion(targets("x86_64+avx+avx2"))]
fn integrate_moving(setup: &Setup<'_, Lanes, LANES>, start: [&FlightState; LANES]) -> [Ending; LANES] {
    integrate::<Lanes, LANES, false, true>(setup, start, |_| {})
}

/// Like [`integrate_plain`] for plants whose sides differ, in any water.
#[multiversion(targets("x86_64+avx+avx2"))]
fn integrate_lopsided(setup: &Setup<'_, Lanes, LANES>, start: [&FlightState; LANES]) -> [Ending; LANES] {
    integrate::<Lanes, LANES, true, true>(setup, start, |_| {})
}
