//! Every experiment: those of the batches, and those from before.

use anyhow::Result;
use infuse::{
    Outcome,
    global::{self, TracedSurface, TrialUse},
};

use crate::campaign::{Campaign, Reading};
use crate::journal::Measured;
use crate::number::{self, count, plain, short};
use crate::problem::step;
use page::{Column, Page, Table};

/// Failed simulations that are listed; more are counted.
const MOST_FAILED: usize = 10;

pub(super) fn write(page: &mut Page, campaign: &Campaign) -> Result<()> {
    page.section("sheets", "Sheets");
    let Some(last) = campaign.last_batch() else {
        page.paragraph("No experiment was asked for yet.");
        return write_imported(page, campaign);
    };
    for batch in 1..=last {
        page.subheading(&format!("Batch {batch}"));
        let (table, caption) = sheet(campaign, batch)?;
        page.table(&table, &caption);
        write_failed_simulations(page, campaign, batch);
    }
    write_imported(page, campaign)
}

/// A column and its cells.
type Filled = (Column, Vec<String>);

/// The experiments of a batch, and the caption of their table.
fn sheet(campaign: &Campaign, batch: usize) -> Result<(Table, String)> {
    let rows = campaign.in_run_order(batch);
    let (surface, by) = surface_for(campaign, batch);
    let trials = || rows.iter().map(|(trial, _)| trial);
    let response = &campaign.problem.response;
    let numbers = |cells: Vec<String>, name: &str| (Column::number(name, ""), cells);
    let mut filled: Vec<Filled> = vec![
        numbers((1..=rows.len()).map(|run| run.to_string()).collect(), "run"),
        numbers(trials().map(|trial| trial.id.to_string()).collect(), "id"),
    ];
    let repeats: Vec<String> = rows.iter().map(|(_, id)| id.map(|id| id.to_string()).unwrap_or_default()).collect();
    filled.extend(unless_empty(Column::number("repeats", ""), repeats));
    for (index, column) in settings_columns(campaign).enumerate() {
        filled.push((column, trials().map(|trial| setting(campaign, trial, index)).collect()));
    }
    let reading = |trial: &global::Trial| campaign.readings.get(&trial.id.number());
    let told = trials().map(|trial| reading(trial).map_or_else(|| "no result yet".to_owned(), told));
    filled.push((Column::number(&response.name, &response.unit), told.collect()));
    if let Some(surface) = surface {
        let predicted = trials().map(|trial| predicted(campaign, trial, surface)).collect::<Result<_>>()?;
        filled.push((Column::number("predicted", &response.unit), predicted));
    }
    filled.push((Column::words("use"), trials().map(|trial| used_for(trial).to_owned()).collect()));
    let notes = trials().map(|trial| reading(trial).map(|reading| reading.note.clone()).unwrap_or_default());
    filled.extend(unless_empty(Column::words("note"), notes.collect()));
    Ok((table(rows.len(), filled), format!("In the order in which to run them.{by}")))
}

/// The surface that predicts a batch, and what to say about that.
fn surface_for(campaign: &Campaign, batch: usize) -> (Option<&TracedSurface>, String) {
    let surfaces = campaign.now.surfaces();
    let (surface, by) = match (surfaces.get(batch - 1), surfaces.last()) {
        (Some(own), _) => (own, batch),
        (None, Some(last)) => (last, surfaces.len()),
        (None, None) => return (None, String::new()),
    };
    (Some(&surface.combined), format!(" Predicted by the combined surface of batch {by}."))
}

fn unless_empty(column: Column, cells: Vec<String>) -> Option<Filled> {
    cells.iter().any(|cell| !cell.is_empty()).then_some((column, cells))
}

fn table(n_rows: usize, filled: Vec<Filled>) -> Table {
    let rows = (0..n_rows).map(|row| filled.iter().map(|(_, cells)| cells[row].clone()).collect());
    Table { rows: rows.collect(), columns: filled.iter().map(|(column, _)| column.clone()).collect() }
}

fn settings_columns(campaign: &Campaign) -> impl Iterator<Item = Column> {
    campaign.problem.region.parameters().iter().map(|p| Column::number(p.name(), p.unit()))
}

/// What was set, and what should have been if that was something else.
fn setting(campaign: &Campaign, trial: &global::Trial, parameter: usize) -> String {
    let step = step(&campaign.problem.region.parameters()[parameter]);
    let asked = number::setting(trial.point[parameter], step);
    let made = campaign.settings_of(trial.id.number()).get(parameter).map(|&made| number::setting(made, step));
    let made = made.unwrap_or_else(|| asked.clone());
    if asked == made { made } else { format!("{made} (asked: {asked})") }
}

fn predicted(campaign: &Campaign, trial: &global::Trial, surface: &TracedSurface) -> Result<String> {
    let coded = campaign.problem.region.coded(&campaign.settings_of(trial.id.number()))?;
    Ok(short(campaign.problem.response.of_cost(surface.surface().predict(&coded))))
}

fn used_for(trial: &global::Trial) -> &'static str {
    match trial.used_for {
        TrialUse::Training => "training",
        TrialUse::Validation => "validation",
    }
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

fn write_failed_simulations(page: &mut Page, campaign: &Campaign, batch: usize) {
    let Some(report) = campaign.now.reports().get(batch - 1) else { return };
    let n_failed = report.failed_simulations().count();
    if n_failed == 0 {
        return;
    }
    let more = if n_failed > MOST_FAILED { format!("; the first {MOST_FAILED}:") } else { ":".to_owned() };
    page.paragraph(&format!("Of {} {n_failed} failed{more}", count(report.simulations.len(), "simulation")));
    let described = report.failed_simulations().take(MOST_FAILED).map(|record| {
        let Outcome::Failed { reason } = &record.outcome else { return String::new() };
        format!("{}: {reason}", campaign.problem.describe(&record.point))
    });
    page.list(&described.collect::<Vec<_>>());
}

fn write_imported(page: &mut Page, campaign: &Campaign) -> Result<()> {
    let earlier = campaign.now.earlier();
    if earlier.is_empty() {
        return Ok(());
    }
    let response = &campaign.problem.response;
    let mut columns: Vec<Column> = settings_columns(campaign).collect();
    columns.extend([
        Column::number(&response.name, &response.unit),
        Column::number("from batch", ""),
        Column::words("source"),
    ]);
    let rows = earlier.iter().map(|earlier| {
        let mut cells: Vec<String> = earlier.point.iter().map(|&setting| plain(setting)).collect();
        cells.extend([plain(response.of_cost(earlier.cost)), earlier.since.to_string(), earlier.source.clone()]);
        cells
    });
    page.subheading("Imported");
    let caption = "Experiments from before the campaign. From the batch named they train the surfaces, as long as their \
                   settings are among the designs left.";
    page.table(&Table { columns, rows: rows.collect() }, caption);
    Ok(())
}
