//! Simulations that are still missing, run with their progress shown and written down one by one.

use anyhow::{Result, bail};
use design_space::Grid;
use indicatif::{HumanDuration, ProgressBar, ProgressState, ProgressStyle};
use std::io::Write as _;
use std::path::Path;

use crate::journal::{Event, Measured, Submitted};
use crate::number::{count, rounded};
use crate::problem::Problem;
use crate::program;
use crate::queue::{self, Happened, Queued};
use crate::simulator::{Job, identity, simulate};

/// How many simulations were made, and how many of them gave no value.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Simulations {
    pub(crate) n_done: usize,
    pub(crate) n_failed: usize,
}

/// Runs these, here or in a queue that has had those `submitted`; `remember` writes each down as soon as it is there.
pub(crate) fn simulate_missing(
    folder: &Path,
    problem: &Problem,
    grid: &Grid,
    jobs: &[Job],
    submitted: &[Submitted],
    mut remember: impl FnMut(Event) -> Result<()>,
) -> Result<Simulations> {
    let mut done = Simulations::default();
    if jobs.is_empty() {
        return Ok(done);
    }
    let bar = ProgressBar::new(jobs.len() as u64);
    let style = ProgressStyle::with_template("simulations {bar:30} {pos}/{len}{left} {msg}")
        .map(|style| style.with_key("left", time_left));
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar.tick();
    let by = identity(&problem.simulator);
    let mut happened = |happened: Happened<'_>| match happened {
        Happened::Submitted(submitted) => remember(Event::Submitted(submitted)),
        Happened::Simulated((cell, point), result, others) => {
            done.n_failed += usize::from(matches!(result, Measured::Failed(_)));
            let point = point.iter().copied().map(rounded).collect();
            let constrained = problem.of_constraints(others);
            remember(Event::Simulated { cell: *cell, point, result, constrained, by: by.clone() })?;
            done.n_done += 1;
            bar.inc(1);
            Ok(())
        }
    };
    let queue = problem.simulator.queue();
    let outcome = match queue {
        Some((program, queue)) => {
            let of = Queued { folder, region: &problem.region, program, queue, by: &by, submitted };
            let mut said = String::new();
            let show = |n: usize, trouble: &str| {
                bar.set_message(format!("({n} in the queue)"));
                if !trouble.is_empty() && said != trouble {
                    trouble.clone_into(&mut said);
                    let note = format!("note: {trouble}: nobody knows what is in the queue; asking again");
                    // Without a terminal it is the only sign of life.
                    bar.suspend(|| drop(writeln!(std::io::stderr(), "{note}")));
                }
            };
            queue::simulate(of, jobs, &mut happened, show)
        }
        None => simulate(folder, problem, grid, jobs, |job, result, others| {
            happened(Happened::Simulated(job, result, others))
        }),
    };
    bar.finish_and_clear();
    outcome?;
    if program::is_interrupted() {
        let rest = match queue {
            Some(_) => "what is in the queue goes on; ask again to wait for it, or stop it with `infuse cancel`",
            None => "ask again to go on",
        };
        bail!("interrupted: {} of {} are remembered, {rest}", done.n_done, count(jobs.len(), "simulation"));
    }
    Ok(done)
}

/// How long it takes still, as soon as that is known.
fn time_left(state: &ProgressState, out: &mut dyn std::fmt::Write) {
    if state.pos() > 0 {
        let _ = write!(out, ", {:#} left", HumanDuration(state.eta()));
    }
}

/// In words, if some gave no value.
pub(crate) fn failed_in_words(n_failed: usize) -> Option<String> {
    (n_failed > 0).then(|| format!("{} failed; the journal says why", count(n_failed, "simulation")))
}
