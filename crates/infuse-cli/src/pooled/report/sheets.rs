//! Every experiment: those of the batches, those from before, and simulations that failed.

use anyhow::Result;
use page::{Column, Page, Table};

use super::nothing::NOTHING;
use super::view::{View, cell_of};
use crate::journal::{Measured, Purpose};
use crate::number::{count, plain, short};
use crate::pooled::campaign::Campaign;
use crate::problem::{Simulator, written};
use crate::report::sheets::{Filled, settings_columns, sheet};
use crate::simulator::identity;

/// Failed simulations that are listed; more are counted.
const MOST_FAILED: usize = 10;

pub(super) fn write(page: &mut Page, campaign: &Campaign, view: Option<&View>) -> Result<()> {
    page.section("sheets", "Sheets");
    if campaign.batches.is_empty() {
        page.paragraph("No experiment was asked for yet.");
    }
    for (index, batch) in campaign.batches.iter().enumerate() {
        let (number, purpose) = (index + 1, batch.purpose);
        let heading = match purpose {
            Some(Purpose::Confirm) => format!("Batch {number}, to confirm"),
            None => format!("Batch {number}"),
        };
        page.subheading(&heading);
        let expected = view.map(|view| expected(view, number)).transpose()?;
        let by = if view.is_some() { " Expected by all that is known now." } else { "" };
        let table = sheet(&campaign.problem, &campaign.experiments, number, expected);
        page.table(&table, &format!("In the order in which to run them.{by}"));
    }
    write_failed_simulations(page, campaign)?;
    write_imported(page, campaign, view)
}

fn expected(view: &View, batch: usize) -> Result<Filled> {
    let campaign = view.campaign;
    let trials = campaign.experiments.in_run_order(batch, campaign.problem.seed);
    let cells = trials.iter().map(|(trial, _)| {
        let expected = view.expected(cell_of(campaign, trial.id.number())?);
        Ok(expected.map_or_else(|| NOTHING.to_owned(), short))
    });
    Ok((Column::number("expected", &view.response().unit), cells.collect::<Result<Vec<_>>>()?))
}

/// Of a simulator that is a command.
fn write_failed_simulations(page: &mut Page, campaign: &Campaign) -> Result<()> {
    if let Simulator::Nothing | Simulator::Table(_) = campaign.problem.simulator {
        return Ok(());
    }
    let by = identity(&campaign.problem.simulator);
    let own = || campaign.memory.iter().filter(|(_, known)| known.by == by);
    let n = own().count();
    let mut failed: Vec<_> = own()
        .filter_map(|(&cell, known)| match &known.result {
            Measured::Failed(reason) => Some((cell, reason)),
            Measured::Value(_) => None,
        })
        .collect();
    if failed.is_empty() {
        return Ok(());
    }
    failed.sort_by_key(|(cell, _)| *cell);
    let more = if failed.len() > MOST_FAILED { format!("; the first {MOST_FAILED}:") } else { ":".to_owned() };
    page.subheading("Simulations");
    page.paragraph(&format!("Of {} {} failed{more}", count(n, "simulation"), failed.len()));
    let described = failed
        .into_iter()
        .take(MOST_FAILED)
        .map(|(cell, reason)| Ok(format!("{}: {reason}", campaign.problem.describe(&campaign.grid.point(cell)?))));
    page.list(&described.collect::<Result<Vec<_>>>()?);
    Ok(())
}

fn write_imported(page: &mut Page, campaign: &Campaign, view: Option<&View>) -> Result<()> {
    if campaign.imported.is_empty() {
        return Ok(());
    }
    let response = &campaign.problem.response;
    let mut columns: Vec<Column> = settings_columns(&campaign.problem).collect();
    columns.extend([
        Column::number(&response.name, &response.unit),
        Column::number("expected", &response.unit),
        Column::words("source"),
    ]);
    let mut table = Table { columns, rows: Vec::new() };
    for imported in &campaign.imported {
        let cell = campaign.grid.nearest_clamped(&imported.point)?;
        let expected = view.and_then(|view| view.expected(cell));
        let settings = campaign.problem.region.parameters().iter().zip(&imported.point);
        let mut row: Vec<String> = settings.map(|(parameter, &setting)| written(parameter, setting)).collect();
        row.extend([
            match &imported.result {
                Measured::Value(value) => plain(*value),
                Measured::Failed(reason) => format!("failed: {reason}"),
            },
            expected.map_or_else(|| NOTHING.to_owned(), short),
            imported.source.clone(),
        ]);
        table.rows.push(row);
    }
    page.subheading("Imported");
    page.table(&table, "Experiments from before the campaign. They count as much as its own.");
    Ok(())
}
