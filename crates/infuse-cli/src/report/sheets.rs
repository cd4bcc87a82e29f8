//! Every experiment of a batch, as a table.

use infuse::pooled::Trial;
use page::{Column, Table};

use crate::campaign::{Experiments, Reading};
use crate::journal::Measured;
use crate::number::plain;
use crate::problem::{Problem, shown};

/// A column and its cells.
pub(crate) type Filled = (Column, Vec<String>);

/// The experiments of a batch in the order in which to run them, with what else the method knows of each.
pub(crate) fn sheet(
    problem: &Problem,
    experiments: &Experiments,
    batch: usize,
    more: impl IntoIterator<Item = Filled>,
) -> Table {
    let rows = experiments.in_run_order(batch, problem.seed);
    let trials = || rows.iter().map(|(trial, _)| trial);
    let response = &problem.response;
    let numbers = |cells: Vec<String>, name: &str| (Column::number(name, ""), cells);
    let mut filled: Vec<Filled> = vec![
        numbers((1..=rows.len()).map(|run| run.to_string()).collect(), "run"),
        numbers(trials().map(|trial| trial.id.to_string()).collect(), "id"),
    ];
    let repeats: Vec<String> = rows.iter().map(|(_, id)| id.map(|id| id.to_string()).unwrap_or_default()).collect();
    filled.extend(unless_empty(Column::number("repeats", ""), repeats));
    for (index, column) in settings_columns(problem).enumerate() {
        filled.push((column, trials().map(|trial| setting(problem, experiments, trial, index)).collect()));
    }
    let reading = |trial: &Trial| experiments.readings.get(&trial.id.number());
    let told = trials().map(|trial| reading(trial).map_or_else(|| "no result yet".to_owned(), told));
    filled.push((Column::number(&response.name, &response.unit), told.collect()));
    for held in &problem.constraints {
        let measured = |trial: &Trial| reading(trial).and_then(|reading| reading.mean_of(held.name()));
        let cells = trials().map(|trial| measured(trial).map(plain).unwrap_or_default());
        filled.push((Column::number(held.name(), &held.unit), cells.collect()));
    }
    filled.extend(more);
    let notes = trials().map(|trial| reading(trial).map(|reading| reading.note.clone()).unwrap_or_default());
    filled.extend(unless_empty(Column::words("note"), notes.collect()));
    table(rows.len(), filled)
}

fn unless_empty(column: Column, cells: Vec<String>) -> Option<Filled> {
    cells.iter().any(|cell| !cell.is_empty()).then_some((column, cells))
}

fn table(n_rows: usize, filled: Vec<Filled>) -> Table {
    let rows = (0..n_rows).map(|row| filled.iter().map(|(_, cells)| cells[row].clone()).collect());
    Table { rows: rows.collect(), columns: filled.iter().map(|(column, _)| column.clone()).collect() }
}

/// A column per parameter.
pub(crate) fn settings_columns(problem: &Problem) -> impl Iterator<Item = Column> {
    problem.region.parameters().iter().map(|p| Column::number(p.name(), p.unit()))
}

/// What was set, and what should have been if that was something else.
fn setting(problem: &Problem, experiments: &Experiments, trial: &Trial, parameter: usize) -> String {
    let of = &problem.region.parameters()[parameter];
    let asked = shown(of, trial.point[parameter]);
    let made = experiments.settings_of(trial.id.number()).get(parameter).map(|&made| shown(of, made));
    let made = made.unwrap_or_else(|| asked.clone());
    if asked == made { made } else { format!("{made} (asked: {asked})") }
}

/// Every run at these settings.
fn told(reading: &Reading) -> String {
    let in_words = |result: &Measured| match result {
        Measured::Value(value) => plain(*value),
        Measured::Failed(reason) => format!("failed: {reason}"),
    };
    let all: Vec<String> = reading.first.iter().chain(reading.again.values()).map(in_words).collect();
    if reading.first.is_some() { all.join(", ") } else { format!("no result yet; again: {}", all.join(", ")) }
}
