//! Simulations that are still missing, run with their progress shown and written down one by one.

use std::path::Path;
use std::sync::atomic::Ordering;

use anyhow::{Result, bail};
use design_space::Grid;
use indicatif::{ProgressBar, ProgressStyle};

use crate::journal::{Event, Measured};
use crate::number::{count, rounded};
use crate::problem::Problem;
use crate::program;
use crate::simulator::{Job, identity, simulate};

/// How many simulations were made, and how many of them gave no value.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Simulations {
    pub(crate) n_done: usize,
    pub(crate) n_failed: usize,
}

/// Runs these; `remember` writes each down as soon as it is there.
pub(crate) fn simulate_missing(
    folder: &Path,
    problem: &Problem,
    grid: &Grid,
    jobs: &[Job],
    mut remember: impl FnMut(Event) -> Result<()>,
) -> Result<Simulations> {
    let mut done = Simulations::default();
    if jobs.is_empty() {
        return Ok(done);
    }
    let bar = ProgressBar::new(jobs.len() as u64);
    let style = ProgressStyle::with_template("simulations {bar:30} {pos}/{len}, {eta} left");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar.tick();
    let by = identity(&problem.simulator);
    let outcome = simulate(folder, problem, grid, jobs, |(cell, point), result| {
        done.n_failed += usize::from(matches!(result, Measured::Failed(_)));
        let point = point.iter().copied().map(rounded).collect();
        remember(Event::Simulated { cell: *cell, point, result, by: by.clone() })?;
        done.n_done += 1;
        bar.inc(1);
        Ok(())
    });
    bar.finish_and_clear();
    outcome?;
    if program::INTERRUPTED.load(Ordering::Relaxed) {
        bail!("interrupted: {} of {} are remembered, ask again to go on", done.n_done, count(jobs.len(), "simulation"));
    }
    Ok(done)
}

/// In words, if some gave no value.
pub(crate) fn failed_in_words(n_failed: usize) -> Option<String> {
    (n_failed > 0).then(|| format!("{} failed; the journal says why", count(n_failed, "simulation")))
}
