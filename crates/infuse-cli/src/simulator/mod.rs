//! Simulations: looked up, or run side by side.

mod index;
mod rows;

pub(crate) use rows::Rows;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;

use anyhow::{Context as _, Result};
use design_space::{Cell, Grid};

use crate::job_numbers::JobNumbers;
use crate::journal::{Constrained, Measured};
use crate::problem::{Problem, Program, Simulator};
use crate::program::Ran;

/// A point to simulate.
pub(crate) type Job = (Cell, Vec<f64>);

/// By which a remembered run is known to be of the same simulator.
pub(crate) fn identity(simulator: &Simulator) -> String {
    match simulator {
        Simulator::Nothing => String::new(),
        Simulator::Table(path) => format!("table {}", path.display()),
        Simulator::Program { program, .. } => identity_of(program),
    }
}

/// A command as it stands in the file.
pub(crate) fn identity_of(program: &Program) -> String {
    program.command.iter().map(|word| quoted(word)).collect::<Vec<_>>().join(" ")
}

/// A word of a command, in quotes where it could be taken for several: so two commands never read the same.
fn quoted(word: &str) -> String {
    let is_plain = !word.is_empty() && !word.contains(|c: char| c.is_whitespace() || c == '"' || c == '\\');
    if is_plain { word.to_owned() } else { format!("{word:?}") }
}

/// Simulates every job, in any order, and hands each result over as soon as it is there. Stops at the first error of
/// `done`, and without an error when a person wants to stop.
pub(crate) fn simulate(
    folder: &Path,
    problem: &Problem,
    grid: &Grid,
    jobs: &[Job],
    mut done: impl FnMut(&Job, Measured, Constrained) -> Result<()>,
) -> Result<()> {
    match &problem.simulator {
        Simulator::Nothing => Ok(()),
        Simulator::Table(path) => {
            let rows = looked_up(folder, path, problem, grid)?;
            for job in jobs {
                match rows.get(job.0) {
                    Some(row) => done(job, Measured::Value(row.value), row.named(problem))?,
                    None => done(job, Measured::Failed(format!("no row in {}", path.display())), BTreeMap::new())?,
                }
            }
            Ok(())
        }
        Simulator::Program { program, jobs: n_workers, .. } => {
            run_all(folder, problem, program, (*n_workers).min(jobs.len()), jobs, done)
        }
    }
}

fn run_all(
    folder: &Path,
    problem: &Problem,
    program: &Program,
    n_workers: usize,
    jobs: &[Job],
    mut done: impl FnMut(&Job, Measured, Constrained) -> Result<()>,
) -> Result<()> {
    let (waiting, stop) = (Mutex::new(jobs.iter()), AtomicBool::new(false));
    let (sender, receiver) = mpsc::channel();
    std::thread::scope(|scope| {
        for _ in 0..n_workers {
            let (sender, waiting, stop) = (sender.clone(), &waiting, &stop);
            scope.spawn(move || {
                while !stop.load(Ordering::Relaxed) {
                    let next = waiting.lock().map_or(None, |mut waiting| waiting.next());
                    let Some(job) = next else { break };
                    let ran = program.run(folder, &problem.region, &job.1, None);
                    if sender.send((job, ran)).is_err() {
                        break;
                    }
                }
            });
        }
        drop(sender);
        let (mut numbers, mut held_back, mut outcome) = (JobNumbers::default(), Vec::new(), Ok(()));
        for (job, ran) in receiver {
            let suspects = ran.and_then(|ran| Ok((numbers.suspects(&ran, n_workers)?, ran)));
            let handed = suspects.and_then(|(is_suspect, ran)| {
                stop.fetch_or(matches!(ran, Ran::Interrupted), Ordering::Relaxed);
                held_back.push((job, ran));
                if is_suspect { Ok(()) } else { hand_over(&mut held_back, &mut done) }
            });
            if let Err(error) = handed {
                stop.store(true, Ordering::Relaxed);
                held_back.clear();
                outcome = outcome.and(Err(error));
            }
        }
        outcome.and_then(|()| hand_over(&mut held_back, &mut done))
    })
}

/// Hands over what was held back.
fn hand_over(
    ran: &mut Vec<(&Job, Ran)>,
    done: &mut impl FnMut(&Job, Measured, Constrained) -> Result<()>,
) -> Result<()> {
    ran.drain(..).try_for_each(|(job, ran)| match ran {
        Ran::Value { value, others, .. } => done(job, Measured::Value(value), others),
        Ran::Failed(reason) => done(job, Measured::Failed(reason), BTreeMap::new()),
        Ran::Interrupted => Ok(()),
    })
}

/// What a table in a campaign's folder says. A long one is read once: what it says is kept beside the journal, and taken
/// from there for as long as neither the table nor what is asked of it changes.
pub(crate) fn looked_up(folder: &Path, path: &Path, problem: &Problem, grid: &Grid) -> Result<Rows> {
    let path = folder.join(path);
    let name = path.display().to_string();
    let bytes = std::fs::read(&path)
        .with_context(|| format!("[simulator]: `table` is {name:?}, expected a CSV file that can be read"))?;
    if bytes.len() < index::LEAST_BYTES {
        return rows::read(&bytes, &name, problem, grid);
    }
    let key = index::key(&bytes, problem);
    if let Some(rows) = index::read(folder, &key, grid) {
        return Ok(rows);
    }
    let rows = rows::read(&bytes, &name, problem, grid)?;
    index::write(folder, &key, &rows);
    Ok(rows)
}
