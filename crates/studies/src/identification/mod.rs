//! `cargo xtask identify`: the loop of Chapter 4 with numbers of the plant identified from its experiments, alone and together with the
//! correction (27).

mod campaign;
mod file;
mod flights;
mod held_out;
mod kept;
mod page;
mod plant;
mod store;
mod which;

use std::path::Path;

use anyhow::{Result, ensure};
use rayon::prelude::*;

use crate::kept::KeptFile;
use crate::reproduction::progress;
use campaign::run_campaign;
use file::Study;
use plant::Doubted;
use store::{Kept, KeptTurn, REMEDY, Store};
use which::Which;

const KEPT: &str = "fixtures/bat/identification";
/// Campaigns at once, so that a killed run loses no more than these.
const AT_ONCE: usize = 4;

/// The study, what is kept of it, and where its flights are kept.
fn read(root: &Path) -> Result<(Study, Store, KeptFile)> {
    let study = Study::read(root)?;
    let (folder, key) = (root.join(KEPT), study.key(root)?);
    let flights = kept::file(&folder, &study, &key)?;
    let store = Store::read(&folder, &study, key)?;
    Ok((study, store, flights))
}

/// That no campaign is missing.
fn complete(study: &Study, store: &Store) -> Result<()> {
    let all = study.campaigns();
    let missing = all.iter().filter(|campaign| store.find(**campaign).is_none()).count();
    ensure!(missing == 0, "{KEPT}: {missing} of {} campaigns are missing: run `cargo xtask identify`", all.len());
    Ok(())
}

/// Runs the campaigns that are missing, and writes the page; keeps the flights that a check needs where they are missing.
pub(crate) fn run(root: &Path) -> Result<()> {
    let (study, mut store, flights) = read(root)?;
    flights_agree(&study, &store)?;
    let mut missing: Vec<_> =
        study.campaigns().into_iter().filter(|campaign| store.find(*campaign).is_none()).collect();
    // A run that is killed leaves as many of one loop as of another.
    missing.sort_by_key(|campaign| campaign.seed);
    let bar = progress("campaigns", study.campaigns().len());
    bar.inc((study.campaigns().len() - missing.len()) as u64);
    for some in missing.chunks(AT_ONCE) {
        let run = |which: &Which| run_campaign(&study, *which).inspect(|_| bar.inc(1));
        store.add(some.par_iter().map(run).collect::<Result<_>>()?)?;
    }
    bar.finish();
    if missing.is_empty() && flights.rows()?.is_some() {
        return page::write(root, &study, &store);
    }
    // A study that knows no flights: what it flies now is what a check needs.
    let (study, store, flights) = read(root)?;
    prove(&study, &store)?;
    page::write(root, &study, &store)?;
    kept::keep(&flights, &study)
}

/// Writes the page of the campaigns that are kept.
pub(crate) fn write_page(root: &Path) -> Result<()> {
    let (study, store, _) = read(root)?;
    flights_agree(&study, &store)?;
    complete(&study, &store)?;
    page::write(root, &study, &store)
}

/// That a campaign run anew is the one that is kept, that every kept number is what its flight says, and that the page follows, with
/// the flights that are kept: some of them are flown anew.
pub(crate) fn check(root: &Path) -> Result<()> {
    let (study, store, flights) = read(root)?;
    kept::take_over(&flights, &study)?;
    prove(&study, &store)?;
    page::check(root, &study, &store)?;
    flights.warn(study.flights.n_flown(), "flights");
    Ok(())
}

/// That a campaign run anew is the one that is kept, and that every kept number is what its flight says.
fn prove(study: &Study, store: &Store) -> Result<()> {
    flights_agree(study, store)?;
    complete(study, store)?;
    let again = run_campaign(study, study.quick())?;
    ensure!(
        store.find(study.quick()).is_some_and(|kept: &Kept| kept.agrees(&again)),
        "{KEPT}: `{}` without noise is no longer what is kept: remove its rows and run `cargo xtask identify`",
        study.loops[study.quick().index].label
    );
    Ok(())
}

/// That the model with the unknowns of each kept iteration costs what is kept.
fn flights_agree(study: &Study, store: &Store) -> Result<()> {
    let turns =
        store.campaigns().iter().enumerate().flat_map(|(index, kept)| kept.turns.iter().map(move |turn| (index, turn)));
    let turns: Vec<(usize, &KeptTurn)> = turns.collect();
    let pairs: Vec<(&[f64], &[f64])> = turns.iter().map(|(_, turn)| (&turn.unknowns[..], &turn.design[..])).collect();
    for ((index, turn), flown) in turns.iter().zip(Doubted(study).fly(&pairs)) {
        let is_same = flown.is_ok_and(|cost| (cost.total / turn.model_cost - 1.0).abs() < 1e-9);
        ensure!(
            is_same,
            "{}: the model no longer costs {} at {:?}; {REMEDY}",
            store.place(*index),
            turn.model_cost,
            turn.design
        );
    }
    Ok(())
}
