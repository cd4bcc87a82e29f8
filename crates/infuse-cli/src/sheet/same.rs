//! Whether a sheet that is there already is that of a batch.

use std::path::Path;

use anyhow::{Result, bail, ensure};
use infuse::pooled::Trial;

use super::columns::Columns;
use super::table::Table;
use crate::number::{are_written_alike, with_unit};
use crate::problem::{Problem, written};

/// An error if it holds other experiments, or other settings, than these trials; whatever else stands in it is a person's.
pub(crate) fn check_same(path: &Path, problem: &Problem, trials: &[(Trial, Option<u64>)]) -> Result<()> {
    let columns = Columns::of(problem);
    let Ok(table) = Table::read(path, &columns.all) else {
        bail!("{} is there already and is no sheet of this campaign; name another with --sheet", path.display());
    };
    let advice = "move it, or name another with --sheet";
    for row in table.rows() {
        let id = table.cell(row, Columns::ID);
        if id.is_empty() {
            continue;
        }
        let trial = id
            .parse()
            .ok()
            .and_then(|id: u64| trials.iter().map(|(trial, _)| trial).find(|trial| trial.id.number() == id));
        let Some(trial) = trial else {
            bail!(
                "{} is there already and holds experiment {id}, which is not of this batch; {advice}",
                path.display()
            );
        };
        for (index, parameter) in problem.region.parameters().iter().enumerate() {
            let (asked, text) = (trial.point[index], table.cell(row, columns.setting(index)));
            let there = table.setting(row, columns.setting(index), parameter);
            let is_same = there.map_or(text.is_empty(), |there| are_written_alike(there, asked));
            ensure!(
                is_same,
                "{} is there already with {} {text} for experiment {id}, which is to be made at {}; {advice}",
                path.display(),
                parameter.name(),
                with_unit(&written(parameter, asked), parameter.unit())
            );
        }
    }
    Ok(())
}
