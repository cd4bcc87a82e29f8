//! The rows of the form: what a page knew of each, what was typed, and what of it is new.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::Duration;

use anyhow::Result;
use infuse::pooled::Trial;

use crate::campaign::{Campaign, Reading};
use crate::folder;
use crate::journal::Measured;
use crate::number::plain;
use crate::problem::{Problem, written};
use crate::sheet::{Answer, to_fill_in, typed};

use super::super::tell::take;
use super::http::Request;

/// The cells of a row that are filled in, from the response to the note, as a sheet has them.
pub(super) type Cells = Vec<String>;

/// Rows that were sent and not taken, by the ids of their experiments.
pub(super) type Refused = BTreeMap<u64, Row>;

/// A row as it was sent.
#[derive(Debug, Clone, Default)]
pub(super) struct Row {
    /// What the page knew when it was made, see [`state`].
    was: String,
    pub(super) typed: Cells,
    /// What is wrong with a cell, by its place.
    pub(super) faults: BTreeMap<usize, String>,
    /// What is wrong with the row.
    pub(super) fault: Option<String>,
}

/// The name of the field of a cell; without a place, of what the page knew.
pub(super) fn field(id: u64, place: Option<usize>) -> String {
    place.map_or_else(|| format!("was-{id}"), |place| format!("cell-{id}-{place}"))
}

/// What is known of an experiment, as it would be typed.
pub(super) fn known(problem: &Problem, reading: Option<&Reading>) -> Cells {
    match reading.and_then(|reading| Some((reading, reading.first.as_ref()?))) {
        None => vec![String::new(); to_fill_in(problem).len()],
        Some((reading, result)) => {
            let none = BTreeMap::new();
            let constrained = reading.constrained.get(&0).unwrap_or(&none);
            cells(problem, result, constrained, &reading.actual, &reading.note)
        }
    }
}

fn cells(
    problem: &Problem,
    result: &Measured,
    constrained: &BTreeMap<String, f64>,
    actual: &BTreeMap<String, f64>,
    note: &str,
) -> Cells {
    let (value, failed) = match result {
        Measured::Value(value) => (plain(*value), String::new()),
        Measured::Failed(reason) => (String::new(), reason.trim().to_owned()),
    };
    let held = problem.constraints.iter();
    let held = held.map(|held| constrained.get(held.name()).map_or_else(String::new, |&value| plain(value)));
    let made = problem.region.parameters().iter();
    let made = made
        .map(|parameter| actual.get(parameter.name()).map_or_else(String::new, |&setting| written(parameter, setting)));
    [value].into_iter().chain(held).chain([failed]).chain(made).chain([note.trim().to_owned()]).collect()
}

/// What a page knows of an experiment: its settings, and what was told. An id alone may be that of another experiment, if
/// its batch was taken back.
pub(super) fn state(problem: &Problem, trial: &Trial, cells: &Cells) -> String {
    let settings: Vec<String> =
        problem.region.parameters().iter().zip(&trial.point).map(|(p, &setting)| written(p, setting)).collect();
    serde_json::json!([settings, cells, to_fill_in(problem)]).to_string()
}

/// Of a page's state what it showed of a row, and under which headings.
fn parsed(was: &str) -> Option<(Cells, Vec<String>)> {
    serde_json::from_str::<(Vec<String>, Cells, Vec<String>)>(was).ok().map(|(_, cells, headings)| (cells, headings))
}

/// What the page showed of a row, of its state.
fn shown(was: &str) -> Option<Cells> {
    parsed(was).map(|(cells, _)| cells)
}

/// The rows of a request.
pub(super) fn rows(request: &Request) -> BTreeMap<u64, Row> {
    let mut rows: BTreeMap<u64, Row> = BTreeMap::new();
    for (name, text) in &request.fields {
        let mut parts = name.split('-');
        let (kind, id) = (parts.next(), parts.next().and_then(|id| id.parse().ok()));
        let place = parts.next().and_then(|place| place.parse::<usize>().ok());
        match (kind, id, place) {
            (Some("was"), Some(id), None) => text.clone_into(&mut rows.entry(id).or_default().was),
            // No sheet has more columns.
            (Some("cell"), Some(id), Some(place)) if place < 10_000 => {
                let typed = &mut rows.entry(id).or_default().typed;
                typed.resize(typed.len().max(place + 1), String::new());
                text.trim().clone_into(&mut typed[place]);
            }
            _ => {}
        }
    }
    rows
}

/// Takes what is new in these rows, all or nothing: what was refused comes back as it was typed, with what is wrong.
pub(super) fn tell(folder: &Path, wait: Duration, mut rows: BTreeMap<u64, Row>) -> Result<Option<Refused>> {
    // A row that nobody touched says nothing, even if another page has changed it since.
    rows.retain(|_, row| shown(&row.was).is_none_or(|shown| shown != row.typed));
    if rows.is_empty() {
        return Ok(None);
    }
    let (mut campaign, mut writer) = folder::open(folder, wait)?;
    let (mut fresh, mut n_known) = (Vec::new(), 0);
    for (&id, row) in &mut rows {
        match row.fresh(id, &*campaign)? {
            Some(new) => fresh.push(new),
            None => n_known += usize::from(row.is_right()),
        }
    }
    if !rows.values().all(Row::is_right) {
        return Ok(Some(rows));
    }
    if !fresh.is_empty() {
        take(&mut *campaign, &mut writer, fresh, "the page", (n_known, 0))?;
    }
    Ok(None)
}

impl Row {
    /// Whether nothing of it was wrong: it was not taken because of another, or because the folder was not to be had.
    pub(super) fn is_right(&self) -> bool {
        self.fault.is_none() && self.faults.is_empty()
    }

    /// The answer of a row, with whether it replaces one; nothing if it is known, or if something is wrong, which is then
    /// written beside it.
    fn fresh(&mut self, id: u64, campaign: &dyn Campaign) -> Result<Option<(Answer, bool)>> {
        let (problem, experiments) = (campaign.problem(), campaign.experiments());
        let Some(trial) = experiments.trials.get(&id) else {
            self.fault = Some("this experiment is not asked for any more".to_owned());
            return Ok(None);
        };
        let known = known(problem, experiments.readings.get(&id));
        let are_others = parsed(&self.was).is_some_and(|(_, headings)| headings != to_fill_in(problem));
        if are_others || self.typed.len() > known.len() {
            let typed: Vec<&str> = self.typed.iter().map(String::as_str).filter(|text| !text.is_empty()).collect();
            self.fault = Some(format!(
                "not taken: the columns are others than when this page was made, so that nobody knows which is meant; typed were {}",
                typed.join(", ")
            ));
            self.typed = known;
            return Ok(None);
        }
        let answer = match typed(id, &self.typed, problem, &experiments.trials)? {
            Ok(answer) => answer,
            Err(faults) => {
                let headings = to_fill_in(problem);
                for fault in faults {
                    match headings.iter().position(|heading| *heading == fault.column) {
                        Some(place) => drop(self.faults.insert(place, format!("expected {}", fault.expected))),
                        None => self.fault = Some(fault.to_string()),
                    }
                }
                return Ok(None);
            }
        };
        let has_result = experiments.has_result(trial.id);
        let Some(answer) = answer else {
            // What was told is not taken back by an empty row.
            if has_result || self.typed.iter().any(|text| !text.is_empty()) {
                drop(self.faults.insert(0, "expected a value, or why there is none".to_owned()));
            }
            return Ok(None);
        };
        let said = cells(problem, &answer.result, &answer.constrained, &answer.actual, &answer.note);
        if said == known {
            return Ok(None);
        }
        if self.was != state(problem, trial, &known) {
            self.fault = Some(conflict(&known));
            return Ok(None);
        }
        self.fault = campaign.refusal(trial).map(|expected| format!("expected {expected}"));
        Ok(self.fault.is_none().then_some((answer, has_result)))
    }
}

/// Somebody else was faster.
fn conflict(known: &Cells) -> String {
    let now: Vec<&str> = known.iter().map(String::as_str).filter(|text| !text.is_empty()).collect();
    let now =
        if now.is_empty() { "nothing is known of it".to_owned() } else { format!("now it has {}", now.join(", ")) };
    format!("not taken: this experiment was changed since this page was made, and {now}; save again to replace it")
}
