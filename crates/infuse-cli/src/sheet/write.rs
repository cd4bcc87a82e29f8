//! A sheet for the rig.

use std::path::Path;

use anyhow::{Context as _, Result, ensure};
use infuse::pooled::Trial;

use super::columns::Columns;
use super::table::Column;
use crate::disk::replace;
use crate::problem::{Problem, written};

/// Whether a sheet can be written under this name.
///
/// # Errors
///
/// It has the ending of another kind of table.
pub(crate) fn check_ending(path: &Path) -> Result<()> {
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    ensure!(
        !["xls", "xlsm", "xlsb", "ods", "numbers"].contains(&&*ending),
        "{}: a sheet is written as text (.csv) or as a workbook (.xlsx), not as .{ending}",
        path.display()
    );
    Ok(())
}

/// Writes these trials, in the order in which they are to be run. The file is there whole or not at all.
pub(crate) fn write(path: &Path, problem: &Problem, trials: &[(Trial, Option<u64>)]) -> Result<()> {
    let name = || path.display().to_string();
    if is_workbook(path) {
        return replace(path, &super::book::bytes(problem, trials).with_context(name)?);
    }
    let columns = Columns::of(problem);
    let mut table = csv::Writer::from_writer(Vec::new());
    table.write_record(columns.all.iter().map(Column::heading)).with_context(name)?;
    for (index, (trial, repeats)) in trials.iter().enumerate() {
        let mut cells = vec![String::new(); columns.all.len()];
        cells[Columns::RUN] = (index + 1).to_string();
        cells[Columns::ID] = trial.id.to_string();
        cells[Columns::REPEATS] = repeats.map(|id| id.to_string()).unwrap_or_default();
        for (index, (parameter, &value)) in problem.region.parameters().iter().zip(&trial.point).enumerate() {
            cells[columns.setting(index)] = written(parameter, value);
        }
        table.write_record(&cells).with_context(name)?;
    }
    let bytes = table.into_inner().map_err(|error| anyhow::anyhow!("{}: {error}", path.display()))?;
    replace(path, &bytes)
}

fn is_workbook(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("xlsx"))
}
