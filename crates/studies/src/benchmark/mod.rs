//! `cargo xtask benchmark`: the loops on pairs of a biased simulation and a noisy truth, beside those who know less and peers.

mod bands;
mod constrained;
mod constrained_page;
pub(crate) mod constrained_run;
mod displaced_page;
mod drift;
mod drift_page;
pub(crate) mod drift_run;
mod families;
mod figure;
mod methods;
mod page;
mod results;
mod stopping;
mod summary;
mod task;

use std::io::{BufRead, Write};
use std::path::Path;

use anyhow::{Context as _, Result, bail, ensure};
use infuse::pooled::reported::{NINE_IN_TEN, Registration};
use rayon::prelude::*;

use crate::reproduction::progress;
use families::{DECOYS, DISPLACED, FAMILIES, Family};
use methods::{DISPLACED_METHODS, METHODS, Method, UNTOLD};
use results::{Beside, Displaced, Fresh, Results, Row};
use task::{
    COMPARED_SEEDS, DISPLACED_SEEDS, FRESH_SEEDS, LEVELS, SEEDS, Task, broken_families, fresh_families, lowest,
};

/// Where the rows of our methods, and those of the peers, are kept.
const OURS: &str = "fixtures/benchmark";
const PEERS: &str = "fixtures/peers/results";

/// The pooled loop, by the name of its rows.
const OWN: &str = METHODS[0].name;
/// Its campaigns on fresh seeds: apart, so that peers are compared on the others.
const FRESH: &str = "pooled-fresh";
/// The families whose certificate was broken most often, on fresh seeds, too.
const BROKEN: &str = "pooled-broken";
/// Beside these, on the first of the seeds, those that are not told of the simulation.
const FRESH_UNTOLD: &str = "pooled-untold-fresh";
const FRESH_PEER: &str = "botorch-fresh";
const DISPLACED_PEER: &str = "botorch-displaced";

/// Runs what is missing among the kept campaigns, and writes the page.
pub(crate) fn run(root: &Path) -> Result<()> {
    let (quick, slow): (Vec<&Method>, Vec<&Method>) = METHODS.iter().partition(|method| method.is_quick);
    for method in quick.into_iter().chain(slow) {
        let mut results = Results::read(&root.join(OURS), method.name)?;
        // Seed by seed, so that a run that is cut short has all families.
        let all = (1..=SEEDS).flat_map(|seed| FAMILIES.iter().map(move |family| (family, seed)));
        run_missing(method, &mut results, all)?;
        if method.name == OWN {
            let all =
                COMPARED_SEEDS.chain(FRESH_SEEDS).flat_map(|seed| fresh_families().map(move |family| (family, seed)));
            run_missing(method, &mut Results::read(&root.join(OURS), FRESH)?, all)?;
            let all = FRESH_SEEDS.flat_map(|seed| broken_families().map(move |family| (family, seed)));
            run_missing(method, &mut Results::read(&root.join(OURS), BROKEN)?, all)?;
        }
        if method.name == UNTOLD {
            let all = COMPARED_SEEDS.flat_map(|seed| fresh_families().map(move |family| (family, seed)));
            run_missing(method, &mut Results::read(&root.join(OURS), FRESH_UNTOLD)?, all)?;
        }
    }
    for method in &DISPLACED_METHODS {
        let all = DISPLACED_SEEDS.flat_map(|seed| DISPLACED.iter().map(move |family| (family, seed)));
        run_missing(method, &mut Results::read(&root.join(OURS), method.name)?, all)?;
    }
    write_page(root)
}

fn run_missing<'a>(
    method: &Method,
    results: &mut Results,
    campaigns: impl Iterator<Item = (&'a Family, u64)>,
) -> Result<()> {
    let is_missing = |(family, seed): &(&Family, u64)| method.can(family) && !results.has(family.name, *seed);
    let missing: Vec<(&Family, u64)> = campaigns.filter(is_missing).collect();
    let bar = progress(&format!("campaigns: {}", method.words), missing.len());
    // A few campaigns at a time, so that a killed run loses no more than these.
    for some in missing.chunks(8) {
        let rows: Vec<Vec<Row>> = some
            .par_iter()
            .map(|(family, seed)| {
                let rows = campaign(method, family, *seed)?;
                bar.inc(1);
                Ok(rows)
            })
            .collect::<Result<_>>()?;
        results.append(rows.concat())?;
    }
    bar.finish();
    Ok(())
}

/// Writes the page from the campaigns that are kept, and runs none.
pub(crate) fn write_page(root: &Path) -> Result<()> {
    page::write(root, &kept(root)?, &fresh(root)?)
}

/// That the kept rows are what the methods give today, on a few campaigns, and that the page follows from them.
pub(crate) fn check(root: &Path) -> Result<()> {
    let kept_results = kept(root)?;
    for method in METHODS.iter().filter(|method| method.is_quick) {
        let results = Results::read(&root.join(OURS), method.name)?;
        for family in FAMILIES.iter().filter(|family| method.can(family)).step_by(4) {
            check_rows(method, &results, family, 1)?;
        }
    }
    let fresh = fresh(root)?;
    for family in fresh_families().step_by(2) {
        check_rows(&METHODS[0], &fresh.ours, family, *FRESH_SEEDS.start())?;
    }
    for family in broken_families() {
        check_rows(&METHODS[0], &fresh.broken, family, *FRESH_SEEDS.start())?;
    }
    for method in &DISPLACED_METHODS {
        let results = Results::read(&root.join(OURS), method.name)?;
        for family in DISPLACED.iter().step_by(2) {
            check_rows(method, &results, family, *DISPLACED_SEEDS.start())?;
        }
    }
    page::check(root, &kept_results, &fresh)
}

/// That one campaign, run again, has the rows that are kept.
fn check_rows(method: &Method, results: &Results, family: &Family, seed: u64) -> Result<()> {
    let (before, again) = (results.of(family.name, seed), campaign(method, family, seed)?);
    let same = before.len() == again.len() && before.iter().zip(&again).all(|(a, b)| a.agrees(b));
    ensure!(same, "{} on {}, seed {seed}: other rows than kept in {OURS}", method.words, family.name);
    Ok(())
}

fn fresh(root: &Path) -> Result<Fresh> {
    let words = METHODS.iter().find(|method| method.name == UNTOLD).map_or("", |method| method.words);
    let untold = Results::read(&root.join(OURS), FRESH_UNTOLD)?;
    let peer = Results::read(&root.join(PEERS), FRESH_PEER)?;
    let kept = Results::read(&root.join(OURS), FRESH)?;
    let (ours, compared) = (kept.of_seeds(&FRESH_SEEDS), kept.of_seeds(&COMPARED_SEEDS));
    let [cheap, cheap_in_place, dear, dear_in_place] = &DISPLACED_METHODS;
    let beside = |ours: &Method, other: &Method| -> Result<Beside> {
        let [ours, kept] = [ours, other].map(|method| Results::read(&root.join(OURS), method.name));
        let peer = Results::read(&root.join(PEERS), DISPLACED_PEER)?;
        Ok(Beside { ours: ours?, others: vec![(other.words, kept?), (results::PEERS[0].words, peer)] })
    };
    let displaced = Displaced { cheap: beside(cheap, cheap_in_place)?, dear: beside(dear, dear_in_place)? };
    let broken = Results::read(&root.join(OURS), BROKEN)?;
    Ok(Fresh { ours, compared, broken, untold: vec![(words, untold), (results::PEERS[0].words, peer)], displaced })
}

fn kept(root: &Path) -> Result<Vec<Results>> {
    let mut all: Vec<Results> =
        METHODS.iter().map(|method| Results::read(&root.join(OURS), method.name)).collect::<Result<_>>()?;
    for peer in results::PEERS {
        all.push(Results::read(&root.join(PEERS), peer.name)?);
    }
    Ok(all)
}

/// One campaign, a row for each batch.
fn campaign(method: &Method, family: &Family, seed: u64) -> Result<Vec<Row>> {
    let pair = family.pair(seed);
    let task = Task::new(family, &pair, seed)?;
    let best = lowest(&task.grid, &*pair.truth)?;
    let steps = (method.run)(&task).with_context(|| format!("{} on {}, seed {seed}", method.words, family.name))?;
    let row = |(batch, step): (usize, methods::Step)| {
        let point = task.grid.point(step.recommended)?;
        let truth = (pair.truth)(&point);
        let regret = truth - best;
        let methods::Step { bound, quantile, forecast, expected, registration, ask_seconds, tell_seconds, .. } = step;
        let bands = registration.as_ref().zip(pair.displacement.as_ref()).map(|(told, truth)| bands_of(told, truth));
        Ok(Row {
            family: family.name.to_owned(),
            seed,
            batch: batch + 1,
            regret,
            bound,
            quantile,
            drawn: forecast.map(|forecast| forecast.drawn),
            spread: forecast.map(|forecast| forecast.spread),
            tried: forecast.map(|forecast| forecast.n_tried),
            narrow: forecast.and_then(|forecast| forecast.narrow),
            off: expected.map(|[mean, _]| mean - truth),
            deviation: expected.map(|[_, deviation]| deviation),
            bands: bands.map(|[all, _]| all),
            bands_hold: bands.map(|[_, hold]| hold),
            ask_seconds,
            tell_seconds,
        })
    };
    steps.into_iter().enumerate().map(row).collect()
}

/// Along how many axes it is said how far a simulation is displaced, and along how many of those that is as near as is said.
fn bands_of(told: &Registration, truth: &[f64]) -> [usize; 2] {
    let axes =
        told.displacement.iter().zip(&told.deviations).zip(truth).filter(|((_, deviation), _)| **deviation > 0.0);
    let holds = axes.clone().filter(|((said, deviation), by)| (*said - *by).abs() <= NINE_IN_TEN * **deviation);
    [axes.count(), holds.count()]
}

/// Answers points of a pair, for programs in other languages: the first line says the number of factors, the levels, the noise,
/// the experiments of a batch and the lowest truth; then each line of coordinates from 0 to 1 is answered by truth and simulation.
pub(crate) fn serve(family: &str, seed: &str) -> Result<()> {
    let all = || FAMILIES.iter().chain(&DECOYS).chain(&DISPLACED);
    let Some(family) = all().find(|known| known.name == family) else {
        let names: Vec<&str> = all().map(|family| family.name).collect();
        bail!("family is {family:?}, expected one of {}", names.join(", "));
    };
    let seed: u64 = seed.parse().with_context(|| format!("seed is {seed:?}, expected a whole number"))?;
    let pair = family.pair(seed);
    let task = Task::new(family, &pair, seed)?;
    let mut out = std::io::stdout().lock();
    let best = lowest(&task.grid, &*pair.truth)?;
    writeln!(out, "{} {LEVELS} {} {} {best}", pair.n_factors, pair.noise, task.n_experiments)?;
    out.flush()?;
    for line in std::io::stdin().lock().lines() {
        let line = line?;
        let point: Vec<f64> = line.split_whitespace().map(str::parse).collect::<Result<_, _>>()?;
        ensure!(point.len() == pair.n_factors, "{} coordinates, expected {}: {line}", point.len(), pair.n_factors);
        writeln!(out, "{} {}", (pair.truth)(&point), (pair.simulation)(&point))?;
        out.flush()?;
    }
    Ok(())
}
