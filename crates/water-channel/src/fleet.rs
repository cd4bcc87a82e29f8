//! Many flights of one test: lanes within a core, threads across cores, each flight on its own.

use bat_dynamics::{LANES, Lanes, Plant};
use multiversion::multiversion;
use rayon::prelude::*;

use crate::error::FlightError;
use crate::flight::{Flight, FlightRequest, Ready};
use crate::integrate::{Ending, Setup, integrate};
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
    if let Err(error) = settings.validate() {
        return requests.iter().map(|_| Err(error.clone().into())).collect();
    }
    requests
        .par_chunks(LANES)
        .flat_map_iter(|chunk| {
            let results = fly_chunk(chunk, profile, settings);
            finished(chunk.len());
            results
        })
        .collect()
}

/// Up to `LANES` flights side by side; those that cannot start are left out.
fn fly_chunk(
    requests: &[FlightRequest],
    profile: &TestProfile,
    settings: &FlightSettings,
) -> Vec<Result<Flight, FlightError>> {
    let mut results: Vec<Option<Result<Flight, FlightError>>> = Vec::with_capacity(requests.len());
    let mut ready: Vec<(usize, Ready)> = Vec::with_capacity(requests.len());
    for (index, request) in requests.iter().enumerate() {
        match Ready::new(request, profile) {
            Ok(one) => {
                results.push(None);
                ready.push((index, one));
            }
            Err(error) => results.push(Some(Err(error.into()))),
        }
    }
    // Flights in one batch share the instants of their samples and the code that flies them.
    let kind = |one: &Ready| (one.controller.parameters().sample_time_s.to_bits(), one.is_plain());
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
    // Unused lanes repeat the last flight.
    let lane = |k: usize| &batch[k.min(batch.len() - 1)].1;
    let setup = Setup {
        plant: Plant::gather(core::array::from_fn(|k| &lane(k).plant)),
        controllers: core::array::from_fn(|k| &lane(k).controller),
        sample_time_s,
        profile,
        settings,
        used: batch.len(),
    };
    let start = core::array::from_fn(|k| &lane(k).start);
    if batch[0].1.is_plain() { integrate_plain(&setup, start) } else { integrate_general(&setup, start) }
}

/// The loop compiled for several instruction sets, chosen when it runs; none of them contracts a product and a
/// sum into one rounding, so all give the same bits.
#[multiversion(targets("x86_64+avx+avx2"))]
fn integrate_plain(setup: &Setup<'_, Lanes, LANES>, start: [&bat_dynamics::FlightState; LANES]) -> [Ending; LANES] {
    integrate::<Lanes, LANES, true>(setup, start, |_| {})
}

/// Like [`integrate_plain`] for plants whose sides differ.
#[multiversion(targets("x86_64+avx+avx2"))]
fn integrate_general(setup: &Setup<'_, Lanes, LANES>, start: [&bat_dynamics::FlightState; LANES]) -> [Ending; LANES] {
    integrate::<Lanes, LANES, false>(setup, start, |_| {})
}
