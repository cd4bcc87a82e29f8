//! `cargo xtask benchmark --drift`: what is missing of the campaigns on a rig that drifts, kept and checked.

use std::path::Path;

use anyhow::{Context as _, Result, ensure};
use rayon::prelude::*;

use super::drift::{BATCHES, KINDS, Row, WAYS, Which};
use super::drift_page::texts;
use crate::kept;

const KEPT: &str = "fixtures/benchmark/drift.csv";
/// Campaigns at once, so that a killed run loses no more than these.
const AT_ONCE: usize = 8;

/// Runs what is missing, and writes the page.
pub(crate) fn run(root: &Path) -> Result<()> {
    let mut rows: Vec<Row> = kept::rows(&root.join(KEPT))?;
    let missing: Vec<Which> = Which::all().filter(|which| !rows.iter().any(|row| which.is_of(row))).collect();
    kept::run_missing(&root.join(KEPT), &mut rows, &missing, AT_ONCE, |which| {
        which.run().with_context(|| which.words())
    })?;
    write_page(root)
}

/// Writes the page of the campaigns that are kept.
pub(crate) fn write_page(root: &Path) -> Result<()> {
    kept::write(root, &texts(&kept::rows(&root.join(KEPT))?)?)
}

/// That one campaign of each kind and way is the one that is kept, that none is missing, and that the page follows.
pub(crate) fn check(root: &Path) -> Result<()> {
    let rows: Vec<Row> = kept::rows(&root.join(KEPT))?;
    let expected = Which::all().count() * BATCHES;
    ensure!(
        rows.len() == expected,
        "{KEPT}: {} rows, expected {expected}: run `cargo xtask benchmark --drift`",
        rows.len()
    );
    let once: Vec<Which> = Which::all().take(KINDS.len() * WAYS.len()).collect();
    once.par_iter().try_for_each(|which| {
        let again = which.run()?;
        let kept = rows.iter().filter(|row| which.is_of(row));
        let is_same = kept.clone().count() == again.len() && again.iter().zip(kept).all(|(a, b)| a.agrees(b));
        ensure!(is_same, "{KEPT}: {} is no longer what is kept", which.words());
        Ok(())
    })?;
    kept::check(
        root,
        &texts(&rows)?,
        "does not follow from the campaigns kept: run `cargo xtask benchmark --drift --page`",
    )
}
