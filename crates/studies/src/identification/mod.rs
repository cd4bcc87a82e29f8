//! `cargo xtask identify`: the loop of Chapter 4 with numbers of the plant identified from its experiments, alone and together with the
//! correction (27).

mod ahead;
mod campaign;
mod file;
mod flights;
mod held_out;
mod page;
mod plant;
mod store;
mod which;

use std::path::Path;

use anyhow::{Result, ensure};
use rayon::prelude::*;

use crate::reproduction::progress;
use ahead::Ahead;
use campaign::run_campaign;
use file::Study;
use plant::Doubted;
use store::{Kept, KeptTurn, REMEDY, Store};
use which::Which;

const KEPT: &str = "fixtures/bat/identification";
/// In this folder, what the campaign of a check will ask the model for.
const ASKED: &str = "asked.txt";
/// Campaigns at once, so that a killed run loses no more than these.
const AT_ONCE: usize = 4;

/// The study, and what is kept of it, with the model flown to see that it costs what is kept.
fn read(root: &Path) -> Result<(Study, Store)> {
    let study = Study::read(root)?;
    let store = Store::read(&root.join(KEPT), &study, study.key(root)?)?;
    flights_agree(&study, &store)?;
    Ok((study, store))
}

/// That no campaign is missing.
fn complete(study: &Study, store: &Store) -> Result<()> {
    let all = study.campaigns();
    let missing = all.iter().filter(|campaign| store.find(**campaign).is_none()).count();
    ensure!(missing == 0, "{KEPT}: {missing} of {} campaigns are missing: run `cargo xtask identify`", all.len());
    Ok(())
}

/// Runs the campaigns that are missing, and writes the page.
pub(crate) fn run(root: &Path) -> Result<()> {
    let (study, mut store) = read(root)?;
    let mut missing: Vec<_> =
        study.campaigns().into_iter().filter(|campaign| store.find(*campaign).is_none()).collect();
    // A run that is killed leaves as many of one loop as of another.
    missing.sort_by_key(|campaign| campaign.seed);
    let bar = progress("campaigns", study.campaigns().len());
    bar.inc((study.campaigns().len() - missing.len()) as u64);
    for some in missing.chunks(AT_ONCE) {
        let run = |which: &Which| run_campaign(&study, *which, &mut Doubted(&study)).inspect(|_| bar.inc(1));
        store.add(some.par_iter().map(run).collect::<Result<_>>()?)?;
    }
    bar.finish();
    let asked = root.join(KEPT).join(ASKED);
    if missing.contains(&study.quick()) || !asked.exists() {
        let mut model = Ahead::read(&study, &asked);
        run_campaign(&study, study.quick(), &mut model)?;
        model.write(&asked)?;
    }
    page::write(root, &study, &store)
}

/// Writes the page of the campaigns that are kept.
pub(crate) fn write_page(root: &Path) -> Result<()> {
    let (study, store) = read(root)?;
    complete(&study, &store)?;
    page::write(root, &study, &store)
}

/// That a campaign run anew is the one that is kept, that every kept number is what its flight says, and that the page follows.
pub(crate) fn check(root: &Path) -> Result<()> {
    let (study, store) = read(root)?;
    complete(&study, &store)?;
    let mut model = Ahead::read(&study, &root.join(KEPT).join(ASKED));
    let again = run_campaign(&study, study.quick(), &mut model)?;
    let (missed, all) = model.n_missed();
    if missed > 0 {
        eprintln!("{KEPT}/{ASKED} foresaw {} of {all} designs: remove it and run `cargo xtask identify`", all - missed);
    }
    ensure!(
        store.find(study.quick()).is_some_and(|kept: &Kept| kept.agrees(&again)),
        "{KEPT}: `{}` without noise is no longer what is kept: remove its rows and run `cargo xtask identify`",
        study.loops[study.quick().index].label
    );
    page::check(root, &study, &store)
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
