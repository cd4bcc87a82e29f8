//! Experiments from before the campaign.

use std::path::Path;

use anyhow::{Result, ensure};

use super::columns::point_columns;
use super::read::setting_fault;
use super::table::{Column, Fault, Table, none_of};
use crate::campaign::Imported;
use crate::journal::{Constrained, Measured};
use crate::problem::Problem;

/// Reads a table with a column per parameter, one for the response, and possibly columns named `source`, `failed` and `note`; the
/// second says why there is no response. Where no source of all rows is given, each row has to say its own;
/// where one is, that of a row may be empty.
pub(crate) fn imported(path: &Path, problem: &Problem, of_all: Option<&str>) -> Result<Vec<Imported>> {
    let parameters = problem.region.parameters();
    let k = parameters.len();
    let mut columns = point_columns(problem);
    let source = columns.len();
    columns.extend(["source", "failed", "note"].map(|name| Column::optional(name, "")));
    let table = Table::read(path, &columns)?;
    ensure!(
        of_all.is_some() || table.has(source),
        "{}: there is no column `source`, and --source is missing: expected one of them, to say where these experiments come from",
        path.display()
    );
    let (mut found, mut faults): (Vec<Imported>, Vec<Fault>) = (Vec::new(), Vec::new());
    for row in table.rows() {
        let mut usable = |column: usize, read: Result<f64, String>| {
            read.map_err(|expected| faults.push(table.fault(row, column, expected))).ok()
        };
        let settings = parameters.iter().enumerate();
        let settings = settings.map(|(column, p)| usable(column, table.setting(row, column, p)));
        let point: Vec<Option<f64>> = settings.collect();
        let mut number = |column: usize| usable(column, table.number(row, column).map_err(|fault| fault.to_string()));
        let mut constrained = Constrained::new();
        for (index, held) in problem.constraints.iter().enumerate() {
            let column = k + 1 + index;
            if !table.cell(row, column).is_empty() {
                constrained.extend(number(column).map(|value| (held.name().to_owned(), value)));
            }
        }
        let failed = table.cell(row, source + 1);
        let result = match (table.cell(row, k).is_empty(), failed.is_empty()) {
            (true, false) => Some(Measured::Failed(failed.to_owned())),
            _ => usable(k, table.number(row, k).map_err(|fault| fault.of_result())).map(Measured::Value),
        };
        if let (Some(Measured::Value(_)), false) = (&result, failed.is_empty()) {
            faults.push(table.fault(row, source + 1, "nothing, as there is a value; or no value, if the run failed"));
        }
        if of_all.is_none() && table.cell(row, source).trim().is_empty() {
            faults.push(table.fault(
                row,
                source,
                "where this experiment comes from; or --source, which says it of all rows",
            ));
        }
        for (column, (parameter, setting)) in parameters.iter().zip(&point).enumerate() {
            if let Some(expected) = setting.and_then(|setting| setting_fault(parameter, setting)) {
                faults.push(table.fault(row, column, expected));
            }
        }
        let value = result.as_ref().and_then(Measured::value);
        if let Some(expected) = value.and_then(|value| problem.response.fault(value)) {
            faults.push(table.fault(row, k, expected));
        }
        if let (Some(point), Some(result)) = (point.into_iter().collect(), result) {
            let text = |column: usize| table.cell(row, column).to_owned();
            found.push(Imported { point, result, constrained, source: text(source), note: text(source + 2) });
        }
    }
    none_of(&path.display().to_string(), &faults)?;
    ensure!(!found.is_empty(), "{}: no rows, expected at least one experiment", path.display());
    Ok(found)
}
