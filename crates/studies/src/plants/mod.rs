//! `cargo xtask plants`: how many plants have to be built, where one is built for several runs and where each run may have its own.

mod campaign;
mod case;
mod page;
mod store;
mod suspension;

use std::path::Path;

use anyhow::{Result, ensure};
use rayon::prelude::*;

use crate::reproduction::progress;
use campaign::{METHODS, SEEDS, run as run_campaign};
use case::Case;
use store::Store;

const KEPT: &str = "fixtures/plants/campaigns.csv";
/// Campaigns at once, so that a killed run loses no more than these.
const AT_ONCE: usize = 4;

/// Runs what is missing among the kept campaigns, and writes the page.
pub(crate) fn run(root: &Path) -> Result<()> {
    let cases = Case::all(root)?;
    let mut store = Store::read(&root.join(KEPT))?;
    let all = (1..=SEEDS)
        .flat_map(|seed| METHODS.iter().flat_map(move |&method| (0..2).map(move |case: usize| (case, method, seed))));
    let missing: Vec<_> =
        all.filter(|(case, method, seed)| !store.has(cases[*case].name, method.name, *seed)).collect();
    let bar = progress("campaigns", missing.len());
    for some in missing.chunks(AT_ONCE) {
        let rows = some
            .par_iter()
            .map(|&(case, method, seed)| run_campaign(&cases[case], method, seed).inspect(|_| bar.inc(1)));
        store.add(rows.collect::<Result<Vec<_>>>()?.concat())?;
    }
    bar.finish();
    page::write(root, &cases, &store)
}

/// Writes the page of the campaigns that are kept.
pub(crate) fn write_page(root: &Path) -> Result<()> {
    page::write(root, &Case::all(root)?, &Store::read(&root.join(KEPT))?)
}

/// That a campaign of each case run anew is the one that is kept, that none is missing, and that the page follows.
pub(crate) fn check(root: &Path) -> Result<()> {
    let (cases, store) = (Case::all(root)?, Store::read(&root.join(KEPT))?);
    let quick = METHODS[METHODS.len() - 1];
    for case in &cases {
        for method in METHODS {
            let n = (1..=SEEDS).filter(|&seed| store.has(case.name, method.name, seed)).count();
            ensure!(
                n as u64 == SEEDS,
                "{KEPT}: {n} of {SEEDS} campaigns of {}, {}: run `cargo xtask plants`",
                case.name,
                method.words
            );
        }
        let (again, before) = (run_campaign(case, quick, 1)?, store.of(case.name, quick.name, 1));
        let same = before.len() == again.len() && before.iter().zip(&again).all(|(a, b)| a.agrees(b));
        ensure!(same, "{KEPT}: {} on {}, seed 1, is no longer what is kept", quick.words, case.name);
    }
    page::check(root, &cases, &store)
}
