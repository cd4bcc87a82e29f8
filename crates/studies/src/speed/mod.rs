//! `cargo xtask speed`: how fast this is, each figure a ratio to a reference in the same run.

mod builds;
mod generated;
mod guard;
mod lists;
mod page;
mod shell;
mod switches;
mod tasks;
mod theirs;

use std::path::Path;
use std::time::{Duration, Instant};

use anyhow::{Result, ensure};
pub(crate) use guard::run as guard;
use page::{Measured, Row};
pub(crate) use switches::run as flights;
use tasks::{Task, tasks};
use theirs::Theirs;

use crate::reproduction::progress;

/// Each task so often, ours and the reference in turn.
const ROUNDS: usize = 11;
/// Threads of ours.
const THREADS: usize = 2;
/// Before each of both: threads of the other that wait for more to do keep a core busy for a while.
const REST: Duration = Duration::from_millis(200);
/// Untimed runs before each of both. On a virtual machine threads were seen to share a processor for a quarter of a second.
const WARMING: Duration = Duration::from_millis(300);
/// Estimates of both agree to this, relative.
const SAME: f64 = 1e-9;

/// Measures everything and writes the page.
pub(crate) fn run(root: &Path) -> Result<()> {
    let mut theirs = Theirs::start(root, "fixtures/peers/speed.py", "numpy, scipy and scikit-learn")?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(THREADS).build()?;
    let tasks = tasks(root)?;
    let n_steps = tasks.len() + lists::COUNT + shell::COUNT + builds::COUNT;
    let bar = progress("tasks, searches, calls, builds from nothing", n_steps);
    let mut rows = Vec::with_capacity(tasks.len());
    for task in tasks {
        rows.push(pool.install(|| measured(task, &mut theirs))?);
        bar.inc(1);
    }
    let searched = lists::measured(|| bar.inc(1))?;
    let called = shell::measured(root, || bar.inc(1))?;
    let built = builds::measured(root, || bar.inc(1))?;
    bar.finish();
    let measured = Measured { rows, searched, called, built };
    page::write(root, &measured, THREADS, theirs.versions())
}

/// Again and again for a while, of which the last counts: threads that have rested begin on one processor, and the system moves them apart
/// some time later.
fn last_of<T>(mut run: impl FnMut() -> Result<T>) -> Result<T> {
    let start = Instant::now();
    while start.elapsed() < WARMING {
        run()?;
    }
    run()
}

/// Ours and the reference in turn, so that whatever else the machine does slows both.
fn measured(mut task: Task, theirs: &mut Theirs) -> Result<Row> {
    let mut row = Row {
        task: task.words,
        reference: task.reference.words(),
        goal: task.goal,
        seconds: Vec::new(),
        part: task.part.as_ref().map(|part| (part.words, Vec::new())),
    };
    for round in 0..=ROUNDS {
        std::thread::sleep(REST);
        let (ours, sum) = last_of(&mut task.ours)?;
        std::thread::sleep(REST);
        let (reference, expected) = last_of(|| task.reference.run(theirs))?;
        if let Some(expected) = expected {
            let is_same = (sum - expected).abs() <= SAME * expected.abs();
            ensure!(is_same, "{}: our estimates sum to {sum}, the reference's to {expected}", task.words);
        }
        // The first is for the caches.
        if round == 0 {
            continue;
        }
        row.seconds.push([ours, reference]);
        if let (Some(part), Some((_, seconds))) = (&mut task.part, &mut row.part) {
            std::thread::sleep(REST);
            seconds.push(last_of(&mut part.run)?.0);
        }
    }
    Ok(row)
}
