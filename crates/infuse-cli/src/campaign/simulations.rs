//! Simulations that are still missing, run with their progress shown and written down one by one.

use anyhow::{Result, bail};
use design_space::{Cell, Grid};
use std::path::Path;

use super::progress::Progress;
use crate::echo::echo;
use crate::journal::{Constrained, Event, Measured, Submitted};
use crate::number::{self, count, grouped, plain, rounded};
use crate::problem::Problem;
use crate::program;
use crate::queue::{self, Happened, Key, Queued, Task};
use crate::simulator::{Job, identity, simulate};

/// How many simulations were made, and which of them gave no value.
#[derive(Debug, Clone, Default)]
pub(crate) struct Simulations {
    pub(crate) n_done: usize,
    /// In the order of the designs.
    pub(crate) failed: Vec<FailedSimulation>,
}

/// A simulation that gave no value.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct FailedSimulation {
    pub(crate) cell: Cell,
    /// Settings, natural.
    pub(crate) point: Vec<f64>,
    pub(crate) reason: String,
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
    let mut progress = Progress::new("simulations", jobs.len());
    let bar = progress.bar();
    let by = identity(&problem.simulator);
    let simulated = |cell: Cell, point: &[f64], result: Measured, others: Constrained| {
        let (result, constrained) = checked(problem, result, others);
        let point = point.iter().copied().map(rounded).collect();
        Event::Simulated { cell, point, result, constrained, by: by.clone() }
    };
    let mut happened = |event: Event| {
        let is_done = matches!(event, Event::Simulated { .. });
        if let Event::Simulated { cell, point, result: Measured::Failed(reason), .. } = &event {
            done.failed.push(FailedSimulation { cell: *cell, point: point.clone(), reason: reason.clone() });
        }
        remember(event)?;
        done.n_done += usize::from(is_done);
        bar.inc(u64::from(is_done));
        Ok(())
    };
    let queue = problem.simulator.queue();
    let outcome = match queue {
        Some((program, queue)) => {
            let submitted: Vec<Submitted> = submitted.iter().filter(|one| !one.is_of_experiments()).cloned().collect();
            let of = Queued { folder, region: &problem.region, program, queue, by: &by, submitted: &submitted };
            let task = |(cell, point): &Job| Task { key: Key::Simulation(*cell), point: point.clone() };
            let tasks: Vec<Task> = jobs.iter().map(task).collect();
            let ended = |happens: Happened<'_>| match happens {
                Happened::Submitted(submitted) => happened(Event::Submitted(submitted)),
                Happened::Ended(task, result, others) => {
                    happened(simulated(task.key.cell(), &task.point, result, others))
                }
            };
            queue::run_all(of, &tasks, ended, |n, trouble| progress.queued(n, trouble))
        }
        None => simulate(folder, problem, grid, jobs, |(cell, point), result, others| {
            happened(simulated(*cell, point, result, others))
        }),
    };
    bar.finish_and_clear();
    outcome?;
    done.failed.sort_by_key(|one| one.cell);
    if program::is_interrupted() {
        let rest = match queue {
            Some((_, queue)) if queue.cancel.is_empty() => "what is in the queue goes on; ask again to wait for it",
            Some(_) => "what is in the queue goes on; ask again to wait for it, or stop it with `infuse cancel`",
            None => "ask again to go on",
        };
        bail!("interrupted: {} of {} are remembered, {rest}", done.n_done, count(jobs.len(), "simulation"));
    }
    Ok(done)
}

/// What a run gave, with every number beside the value: a constraint may be added when it has been run. One whose value of a
/// constraint is no number has failed.
pub(crate) fn checked(problem: &Problem, result: Measured, mut others: Constrained) -> (Measured, Constrained) {
    let Measured::Value(value) = result else { return (result, Constrained::new()) };
    if let Some(expected) = problem.response.without_logarithm(value) {
        return (Measured::Failed(format!("it returned {}, expected {expected}", plain(value))), Constrained::new());
    }
    let is_fault = |name: &str| others.get(name).is_some_and(|value| number::fault(*value).is_some());
    if let Some(held) = problem.constraints.iter().find(|held| is_fault(held.name())) {
        let reason =
            format!("what it gave as `{}` is no number, expected one, or null where there is none", held.name());
        return (Measured::Failed(reason), Constrained::new());
    }
    others.retain(|_, value| number::fault(*value).is_none());
    (result, others)
}

/// So many are named.
const MOST_NAMED: usize = 3;

/// "3 of 40 simulations failed: a 4 mm, b 7 mm: out of memory; ...", if some gave no value: the first few each with its reason, or the
/// reason once where all have the same.
pub(crate) fn failed_in_words(problem: &Problem, n_all: usize, failed: &[FailedSimulation]) -> Option<String> {
    let (first, n) = (failed.first()?, failed.len());
    let is_one_reason = n > 1 && failed.iter().all(|one| one.reason == first.reason);
    let named = failed.iter().take(MOST_NAMED).map(|one| match is_one_reason {
        true => problem.describe(&one.point),
        false => format!("{}: {}", problem.describe(&one.point), echo(&one.reason)),
    });
    let named = named.collect::<Vec<_>>().join("; ");
    let why = if is_one_reason { format!(", all for one reason, {}", echo(&first.reason)) } else { String::new() };
    let more = match n.saturating_sub(MOST_NAMED) {
        0 => String::new(),
        more => format!("; and {} more, which the journal names", grouped(more as u64)),
    };
    Some(format!("{} of {} failed{why}: {named}{more}", grouped(n as u64), count(n_all, "simulation")))
}
