//! Simulations: looked up, or run side by side.

use std::collections::{BTreeMap, HashMap};
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;

use anyhow::{Result, bail};
use design_space::{Cell, Grid};

use crate::job_numbers::JobNumbers;
use crate::journal::{Constrained, Measured};
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
        Simulator::Table(path) => {
            let values = table(&folder.join(path), problem, grid)?;
            for job in jobs {
                match values.get(&job.0) {
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

/// What a table says of a design.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Simulated {
    pub(crate) value: f64,
    /// One per constraint, if the table has a column for it.
    pub(crate) constrained: Vec<Option<f64>>,
}

impl Simulated {
    fn named(&self, problem: &Problem) -> Constrained {
        let pairs = problem.constraints.iter().zip(&self.constrained);
        pairs.filter_map(|(held, value)| Some((held.name().to_owned(), (*value)?))).collect()
    }
}

/// The values of a table, by cell.
pub(crate) fn table(path: &Path, problem: &Problem, grid: &Grid) -> Result<HashMap<Cell, Simulated>> {
    let parameters = problem.region.parameters();
    let k = parameters.len();
    let table = Table::read(path, &point_columns(problem))?;
    let (mut values, mut faults): (HashMap<Cell, Simulated>, Vec<Fault>) = (HashMap::new(), Vec::new());
    for row in table.rows() {
        let mut point = Vec::with_capacity(k);
        for (column, parameter) in parameters.iter().enumerate() {
            match table.setting(row, column, parameter) {
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
        let constrained = (0..problem.constraints.len()).map(|index| {
            let column = k + 1 + index;
            if table.cell(row, column).is_empty() {
                return None;
            }
            table.number(row, column).map_err(|expected| faults.push(table.fault(row, column, expected))).ok()
        });
        let constrained: Vec<Option<f64>> = constrained.collect();
        match table.number(row, k) {
            Err(expected) => faults.push(table.fault(row, k, expected)),
            Ok(value) if point.len() == k => {
                let simulated = Simulated { value, constrained };
                let earlier = values.insert(grid.nearest(&point)?, simulated.clone());
                if earlier.is_some_and(|earlier| earlier != simulated) {
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
