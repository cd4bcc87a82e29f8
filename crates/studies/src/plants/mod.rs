//! `cargo xtask plants`: how many plants have to be built, where one is built for several runs and where each run may have its own.

mod campaign;
mod case;
mod formula;
mod kept;
mod page;
mod store;
mod suspension;

use std::path::Path;

use anyhow::{Result, ensure};
use rayon::prelude::*;

use crate::reproduction::progress;
use campaign::{METHODS, Method, SEEDS, run as run_campaign};
use case::{Case, N_CASES};
use store::Store;

const KEPT: &str = "fixtures/plants/campaigns.csv";
/// What designs cost on the rigs, as far as a check needs it.
const COSTS: &str = "fixtures/plants/costs.tsv";
/// Campaigns at once, so that a killed run loses no more than these.
const AT_ONCE: usize = 4;

/// The method of the campaigns that a check runs anew, and their seed.
const QUICK: (Method, u64) = (METHODS[METHODS.len() - 1], 1);

/// The cases, all that is asked of them found anew.
fn cases(root: &Path) -> Result<[Case; N_CASES]> {
    let mut cases = Case::read(root)?;
    cases.iter_mut().try_for_each(Case::look_around)?;
    Ok(cases)
}

/// Runs what is missing among the kept campaigns, and writes the page; keeps the costs that a check needs where they are missing.
pub(crate) fn run(root: &Path) -> Result<()> {
    let cases = cases(root)?;
    let mut store = Store::read(&root.join(KEPT))?;
    let all = (1..=SEEDS).flat_map(|seed| {
        METHODS.iter().flat_map(move |&method| (0..N_CASES).map(move |case: usize| (case, method, seed)))
    });
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
    let costs = kept::file(&root.join(COSTS), &cases)?;
    if !missing.is_empty() || costs.rows()?.is_none() {
        // Cases that know no costs: what they find now is what a check needs.
        let cases = self::cases(root)?;
        prove(&cases, &store)?;
        kept::keep(&costs, &cases)?;
    }
    page::write(root, &cases, &store)
}

/// Writes the page of the campaigns that are kept.
pub(crate) fn write_page(root: &Path) -> Result<()> {
    page::write(root, &cases(root)?, &Store::read(&root.join(KEPT))?)
}

/// That a campaign of each case run anew is the one that is kept, that none is missing, and that the page follows, with the costs that
/// are kept: some of them are found anew.
pub(crate) fn check(root: &Path) -> Result<()> {
    let (mut cases, store) = (Case::read(root)?, Store::read(&root.join(KEPT))?);
    let costs = kept::file(&root.join(COSTS), &cases)?;
    kept::take_over(&costs, &cases)?;
    cases.iter_mut().try_for_each(Case::look_around)?;
    prove(&cases, &store)?;
    page::check(root, &cases, &store)?;
    costs.warn(cases.iter().map(|case| case.costs.n_made()).sum(), "costs");
    Ok(())
}

/// That a campaign of each case run anew is the one that is kept, and that none is missing.
fn prove(cases: &[Case], store: &Store) -> Result<()> {
    let (quick, seed) = QUICK;
    for case in cases {
        for method in METHODS {
            let n = (1..=SEEDS).filter(|&seed| store.has(case.name, method.name, seed)).count();
            ensure!(
                n as u64 == SEEDS,
                "{KEPT}: {n} of {SEEDS} campaigns of {}, {}: run `cargo xtask plants`",
                case.name,
                method.words
            );
        }
        let (again, before) = (run_campaign(case, quick, seed)?, store.of(case.name, quick.name, seed));
        let same = before.len() == again.len() && before.iter().zip(&again).all(|(a, b)| a.agrees(b));
        ensure!(same, "{KEPT}: {} on {}, seed {seed}, is no longer what is kept", quick.words, case.name);
    }
    Ok(())
}
