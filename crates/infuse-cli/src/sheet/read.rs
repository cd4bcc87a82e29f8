//! A sheet that comes back, wholly or partly filled.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::{Result, ensure};
use design_space::Parameter;
use infuse::pooled::Trial;

use super::columns::Columns;
use super::table::Row;
use super::table::{Column, Fault, Table, none_of};
use crate::journal::{Constrained, Measured};
use crate::number::{are_written_alike, plain, with_unit};
use crate::problem::{Problem, written};

/// What a row says about a trial.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Answer {
    pub(crate) id: u64,
    pub(crate) result: Measured,
    /// Of the responses that have to stay within bounds.
    pub(crate) constrained: Constrained,
    pub(crate) actual: BTreeMap<String, f64>,
    /// Of a run besides the one that was asked for, its number from 1; otherwise 0.
    pub(crate) repeat: usize,
    pub(crate) note: String,
    /// For messages.
    pub(crate) row: usize,
}

/// What a sheet says.
#[derive(Debug)]
pub(crate) struct Answers {
    pub(crate) filled: Vec<Answer>,
    /// How many rows have neither a value nor a reason.
    pub(crate) n_empty: usize,
    /// Of each row that says once more what another says of the same experiment, that it does.
    pub(crate) said_twice: Vec<String>,
    /// Headings of constraints that the sheet has no column for, as one that was written before they came.
    pub(crate) lacks: Vec<String>,
}

/// Reads a sheet against the trials that were ever handed out.
pub(crate) fn answers(path: &Path, problem: &Problem, trials: &BTreeMap<u64, Trial>) -> Result<Answers> {
    let (answers, faults) = sound_answers(path, problem, trials)?;
    none_of(&path.display().to_string(), &faults)?;
    let n_rows = answers.filled.len() + answers.n_empty;
    ensure!(n_rows > 0, "{}: no rows under the headings, expected at least one experiment", path.display());
    Ok(answers)
}

/// As [`answers`], but what rows without a fault say, beside the faults of the others.
pub(crate) fn sound_answers(
    path: &Path,
    problem: &Problem,
    trials: &BTreeMap<u64, Trial>,
) -> Result<(Answers, Vec<Fault>)> {
    let columns = Columns::of(problem);
    let table = Table::read(path, &columns.all)?;
    let reader = Reader { columns, table, problem, trials };
    let (mut filled, mut faults, mut n_empty): (Vec<Answer>, Vec<Fault>, usize) = (Vec::new(), Vec::new(), 0);
    for row in reader.table.rows() {
        match reader.row(row, &mut faults) {
            Some(Some(answer)) => filled.push(answer),
            Some(None) => n_empty += 1,
            None => {}
        }
    }
    // Rows that repeat the same experiment are known by their order.
    let mut n_repeats: BTreeMap<u64, usize> = BTreeMap::new();
    for answer in filled.iter_mut().filter(|answer| answer.repeat > 0) {
        let number = n_repeats.entry(answer.id).or_default();
        *number += 1;
        answer.repeat = *number;
    }
    for (index, answer) in filled.iter().enumerate() {
        let is_same = |other: &&Answer| other.id == answer.id && other.repeat == 0 && answer.repeat == 0;
        if let Some(other) = filled[..index].iter().find(is_same)
            && (other.result != answer.result
                || other.actual != answer.actual
                || other.constrained != answer.constrained)
        {
            let (id, first) = (answer.id, other.row);
            let value = id.to_string();
            let expected = format!(
                "one row for it: row {first} says something else; one more run of {id} gets a row with an empty `id` and `repeats` = {id}"
            );
            faults.push(Fault { row: answer.row, column: "id".to_owned(), value, expected });
        }
    }
    // A row that comes twice and says the same is said once.
    let (mut seen, mut said_twice) = (BTreeMap::new(), Vec::new());
    filled.retain(|answer| {
        let first = if answer.repeat > 0 { answer.row } else { *seen.entry(answer.id).or_insert(answer.row) };
        if first != answer.row {
            let Answer { id, row, .. } = answer;
            said_twice.push(format!(
                "row {row} says of experiment {id} what row {first} says, and was not counted; one more run of {id} gets a row with \
                 an empty `id` and `repeats` = {id}"
            ));
        }
        first == answer.row
    });
    let held = (0..problem.constraints.len()).map(|index| reader.columns.constrained(index));
    let lacking = held.filter(|&column| !reader.table.has(column));
    let lacks = lacking.map(|column| reader.columns.all[column].heading()).collect();
    Ok((Answers { filled, n_empty, said_twice, lacks }, faults))
}

/// What a row of a form says about a trial: its cells from the response to the note, as a sheet has them; nothing if all
/// are empty. The faults name columns by their headings.
pub(crate) fn typed(
    id: u64,
    filled_in: &[String],
    problem: &Problem,
    trials: &BTreeMap<u64, Trial>,
) -> Result<Result<Option<Answer>, Vec<Fault>>> {
    let columns = Columns::of(problem);
    let mut cells = vec![String::new(); columns.all.len()];
    cells[Columns::ID] = id.to_string();
    for (cell, text) in cells[columns.response()..].iter_mut().zip(filled_in) {
        text.trim().clone_into(cell);
    }
    let table = Table::of_row(&columns.all, &cells)?;
    let reader = Reader { columns, table, problem, trials };
    let mut faults = Vec::new();
    let answer = reader.table.rows().first().and_then(|row| reader.row(row, &mut faults)).flatten();
    Ok(if faults.is_empty() { Ok(answer) } else { Err(faults) })
}

/// The headings of what is filled in, from the response to the note.
pub(crate) fn to_fill_in(problem: &Problem) -> Vec<String> {
    let columns = Columns::of(problem);
    columns.all[columns.response()..].iter().map(Column::heading).collect()
}

struct Reader<'a> {
    columns: Columns,
    table: Table,
    problem: &'a Problem,
    trials: &'a BTreeMap<u64, Trial>,
}

impl Reader<'_> {
    /// What a row says: `Some(None)` for one not filled in yet, none for a fault.
    fn row(&self, row: &Row, faults: &mut Vec<Fault>) -> Option<Option<Answer>> {
        let n_before = faults.len();
        let (columns, table) = (&self.columns, &self.table);
        let trial = self.trial(row, faults);
        let again = table.cell(row, Columns::ID).is_empty();
        if let Some(trial) = trial {
            self.check_settings(row, trial, faults);
        }
        let (value, failed) = (table.cell(row, columns.response()), table.cell(row, columns.failed()));
        let (mut actual, mut made_otherwise) = (BTreeMap::new(), None);
        for (index, parameter) in self.problem.region.parameters().iter().enumerate() {
            match self.actual(row, index, parameter) {
                Ok(Some(setting)) => {
                    actual.insert(parameter.name().to_owned(), setting);
                    made_otherwise = made_otherwise.or(Some(index));
                }
                Ok(None) => {}
                Err(fault) => faults.push(fault),
            }
        }
        let constrained = self.constrained(row, faults);
        let result = match (value.is_empty(), failed.is_empty()) {
            (true, true) => {
                let is_bare = actual.is_empty() && constrained.is_empty() && !again;
                if !is_bare {
                    let expected = "a value, or a reason under `failed`, as the row is filled in otherwise";
                    faults.push(table.fault(row, columns.response(), expected));
                }
                None
            }
            (true, false) => Some(Measured::Failed(failed.to_owned())),
            (false, false) => {
                let expected = "nothing, as there is a value; or no value, if the run failed";
                faults.push(table.fault(row, columns.failed(), expected));
                None
            }
            (false, true) => match table.number(row, columns.response()) {
                Ok(value) => {
                    if let Some(expected) = self.problem.response.fault(value) {
                        faults.push(table.fault(row, columns.response(), expected));
                    }
                    Some(Measured::Value(value))
                }
                Err(value) => {
                    faults.push(table.fault(row, columns.response(), value.of_result()));
                    None
                }
            },
        };
        if again && let Some(index) = made_otherwise {
            let expected = "nothing, as it repeats a run at the same settings; a run at others is imported";
            faults.push(table.fault(row, columns.actual(index), expected));
        }
        if faults.len() > n_before {
            return None;
        }
        let note = table.cell(row, columns.note()).to_owned();
        let answer = |(trial, result): (&Trial, Measured)| {
            let id = trial.id.number();
            Answer { id, result, constrained, actual, repeat: usize::from(again), note, row: row.number }
        };
        Some(trial.zip(result).map(answer))
    }

    /// The responses that have to stay within bounds; an empty cell was not measured.
    fn constrained(&self, row: &Row, faults: &mut Vec<Fault>) -> Constrained {
        let mut constrained = Constrained::new();
        for (index, held) in self.problem.constraints.iter().enumerate() {
            let column = self.columns.constrained(index);
            match self.table.number(row, column) {
                _ if self.table.cell(row, column).is_empty() => {}
                Ok(value) => drop(constrained.insert(held.name().to_owned(), value)),
                Err(expected) => faults.push(self.table.fault(row, column, expected)),
            }
        }
        constrained
    }

    fn trial(&self, row: &Row, faults: &mut Vec<Fault>) -> Option<&Trial> {
        let table = &self.table;
        let column = if table.cell(row, Columns::ID).is_empty() { Columns::REPEATS } else { Columns::ID };
        let text = table.cell(row, column);
        let known = match (self.trials.keys().next(), self.trials.keys().next_back()) {
            (Some(first), Some(last)) => format!("the id of an experiment that was asked for, {first} to {last}"),
            _ => "the id of an experiment that was asked for, and nothing was asked for yet".to_owned(),
        };
        if text.is_empty() {
            let expected = format!("{known}; or, for one more run of an experiment, its id under `repeats`");
            faults.push(table.fault(row, Columns::ID, expected));
            return None;
        }
        let trial = text.parse().ok().and_then(|id: u64| self.trials.get(&id));
        if trial.is_none() {
            faults.push(table.fault(row, column, known));
        }
        trial
    }

    /// The settings of the sheet are those asked for: who made others says so in the columns for it.
    fn check_settings(&self, row: &Row, trial: &Trial, faults: &mut Vec<Fault>) {
        for (index, (parameter, &asked)) in self.problem.region.parameters().iter().zip(&trial.point).enumerate() {
            let column = self.columns.setting(index);
            let text = self.table.cell(row, column);
            // Sheets hold twelve digits.
            let is_same =
                |value: f64| (value - asked).abs() <= 1e-9 * parameter.width() || are_written_alike(value, asked);
            let there = self.table.setting(row, column, parameter);
            let is_asked = there.as_ref().is_ok_and(|&there| is_same(there));
            if !text.is_empty() && !is_asked {
                if let Err(expected) = there {
                    faults.push(self.table.fault(row, column, expected));
                    continue;
                }
                let asked = with_unit(&written(parameter, asked), parameter.unit());
                let expected = format!(
                    "{asked}, as it was asked for; a setting that was made otherwise goes under `actual {}`, and a run that \
                     was not asked for is imported",
                    parameter.name()
                );
                faults.push(self.table.fault(row, column, expected));
            }
        }
    }

    fn actual(&self, row: &Row, index: usize, parameter: &Parameter) -> Result<Option<f64>, Fault> {
        let column = self.columns.actual(index);
        let text = self.table.cell(row, column);
        if text.is_empty() {
            return Ok(None);
        }
        let value =
            self.table.setting(row, column, parameter).map_err(|expected| self.table.fault(row, column, expected))?;
        match setting_fault(parameter, value) {
            Some(expected) => Err(self.table.fault(row, column, expected)),
            None => Ok(Some(value)),
        }
    }
}

/// What is allowed of a setting that was really made, unless this is.
pub(crate) fn setting_fault(parameter: &Parameter, value: f64) -> Option<String> {
    if parameter.choices().is_some() {
        return parameter.choice(value).is_none().then(|| "one of the choices".to_owned());
    }
    let (lower, upper) = made_range(parameter);
    if (lower..=upper).contains(&value) {
        return None;
    }
    let range = format!("{} to {}", plain(lower), with_unit(&plain(upper), parameter.unit()));
    Some(format!("{range}: at most half the width outside the bounds of the parameter"))
}

/// Between which settings one that was really made is taken.
pub(super) fn made_range(parameter: &Parameter) -> (f64, f64) {
    (parameter.lower() - 0.5 * parameter.width(), parameter.upper() + 0.5 * parameter.width())
}
