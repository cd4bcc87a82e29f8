//! Simulations: looked up, or run side by side.

use std::collections::HashMap;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;

use anyhow::{Result, bail};
use design_space::{Cell, Grid};

use crate::journal::Measured;
use crate::number::{plain, with_unit};
use crate::problem::{Problem, Program, Simulator};
use crate::program::Ran;
use crate::sheet::{Fault, Table, none_of, point_columns};

/// A point to simulate.
pub(crate) type Job = (Cell, Vec<f64>);

/// By which a remembered run is known to be of the same simulator.
pub(crate) fn identity(simulator: &Simulator) -> String {
    match simulator {
        Simulator::Table(path) => format!("table {}", path.display()),
        Simulator::Program { program, .. } => {
            program.command.iter().map(|word| quoted(word)).collect::<Vec<_>>().join(" ")
        }
    }
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
    mut done: impl FnMut(&Job, Measured) -> Result<()>,
) -> Result<()> {
    match &problem.simulator {
        Simulator::Table(path) => {
            let values = table(&folder.join(path), problem, grid)?;
            for job in jobs {
                let found = values.get(&job.0).copied().map(Measured::Value);
                done(job, found.unwrap_or_else(|| Measured::Failed(format!("no row in {}", path.display()))))?;
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
    mut done: impl FnMut(&Job, Measured) -> Result<()>,
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
        let mut outcome = Ok(());
        for (job, ran) in receiver {
            let handed = match ran {
                Ok(Ran::Value(value)) => done(job, Measured::Value(value)),
                Ok(Ran::Failed(reason)) => done(job, Measured::Failed(reason)),
                Ok(Ran::Interrupted) => {
                    stop.store(true, Ordering::Relaxed);
                    Ok(())
                }
                Err(error) => Err(error),
            };
            if let Err(error) = handed {
                stop.store(true, Ordering::Relaxed);
                outcome = outcome.and(Err(error));
            }
        }
        outcome
    })
}

/// The values of a table, by cell.
pub(crate) fn table(path: &Path, problem: &Problem, grid: &Grid) -> Result<HashMap<Cell, f64>> {
    let parameters = problem.region.parameters();
    let k = parameters.len();
    let table = Table::read(path, &point_columns(problem))?;
    let (mut values, mut faults): (HashMap<Cell, f64>, Vec<Fault>) = (HashMap::new(), Vec::new());
    for row in table.rows() {
        let mut point = Vec::with_capacity(k);
        for (column, parameter) in parameters.iter().enumerate() {
            match table.number(row, column) {
                Err(expected) => faults.push(table.fault(row, column, expected)),
                Ok(value) => match parameter.snap(value) {
                    Ok(level) if (level - value).abs() <= 1e-6 * parameter.width() => point.push(level),
                    Ok(level) => {
                        let level = with_unit(&plain(level), parameter.unit());
                        faults.push(table.fault(
                            row,
                            column,
                            format!("a level of the parameter, the nearest is {level}"),
                        ));
                    }
                    Err(error) => faults.push(table.fault(row, column, error.to_string())),
                },
            }
        }
        match table.number(row, k) {
            Err(expected) => faults.push(table.fault(row, k, expected)),
            Ok(value) if point.len() == k => {
                let earlier = values.insert(grid.nearest(&point)?, value);
                if earlier.is_some_and(|earlier| earlier.to_bits() != value.to_bits()) {
                    faults.push(table.fault(row, k, "the value that an earlier row has for the same settings"));
                }
            }
            Ok(_) => {}
        }
    }
    none_of(&path.display().to_string(), &faults)?;
    if values.is_empty() {
        bail!("{}: no rows, expected one per simulated point", path.display());
    }
    Ok(values)
}
