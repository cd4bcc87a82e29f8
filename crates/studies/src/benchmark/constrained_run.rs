//! `cargo xtask benchmark --constrained`: what is missing of the campaigns with a constraint, kept and checked.

use std::path::Path;

use anyhow::{Context as _, Result, ensure};

use super::constrained::{CASES, Kind, Row, SEEDS, WAYS, run as run_campaign};
use super::constrained_page::texts;
use crate::kept;

const KEPT: &str = "fixtures/benchmark/constrained.csv";
/// Campaigns at once, so that a killed run loses no more than these.
const AT_ONCE: usize = 6;

/// Runs what is missing, and writes the page.
pub(crate) fn run(root: &Path) -> Result<()> {
    let mut rows: Vec<Row> = kept::rows(&root.join(KEPT))?;
    let has = |rows: &[Row], family: &str, way: &str, seed: u64| {
        rows.iter().any(|row| row.family == family && row.way == way && row.seed == seed)
    };
    let all =
        (1..=SEEDS).flat_map(|seed| CASES.iter().flat_map(move |&case| WAYS.iter().map(move |&way| (case, way, seed))));
    let missing: Vec<_> = all.filter(|(case, way, seed)| !has(&rows, case.name, way.name, *seed)).collect();
    kept::run_missing(&root.join(KEPT), &mut rows, &missing, AT_ONCE, |&(case, way, seed)| {
        run_campaign(case, way, seed).with_context(|| format!("{}, {}, seed {seed}", case.name, way.words))
    })?;
    write_page(root)
}

/// Writes the page of the campaigns that are kept.
pub(crate) fn write_page(root: &Path) -> Result<()> {
    kept::write(root, &texts(&kept::rows(&root.join(KEPT))?))
}

/// That one campaign of each way, one with a choice, and one of each way to fail, is the one that is kept, that none is missing, and that the page follows.
pub(crate) fn check(root: &Path) -> Result<()> {
    let rows: Vec<Row> = kept::rows(&root.join(KEPT))?;
    let expected = SEEDS as usize * CASES.len() * WAYS.len() * super::constrained::BATCHES;
    ensure!(
        rows.len() == expected,
        "{KEPT}: {} rows, expected {expected}: run `cargo xtask benchmark --constrained`",
        rows.len()
    );
    let others = [Kind::Choice, Kind::Failing, Kind::FailingEdge, Kind::FailingChoice]
        .map(|kind| CASES.iter().find(|case| case.kind == kind));
    let others = others.into_iter().flatten().map(|case| (*case, WAYS[0]));
    for (case, way) in WAYS.map(|way| (CASES[0], way)).into_iter().chain(others) {
        let again = run_campaign(case, way, 1)?;
        let is_meant = |row: &&Row| row.family == case.name && row.way == way.name && row.seed == 1;
        let same = again.iter().zip(rows.iter().filter(is_meant)).all(|(a, b)| a.agrees(b));
        ensure!(same, "{KEPT}: {}, {}, seed 1, is no longer what is kept", case.name, way.words);
    }
    kept::check(
        root,
        &texts(&rows),
        "does not follow from the campaigns kept: run `cargo xtask benchmark --constrained --page`",
    )
}
