//! Every experiment: those of the batches, and those from before.

use anyhow::Result;
use infuse::pooled::Trial;
use infuse::{
    Outcome,
    global::{TracedSurface, TrialUse},
};
use page::{Column, Page, Table};

use crate::dissertation::campaign::Campaign;
use crate::number::{count, plain, short};
use crate::report::sheets::{Filled, settings_columns, sheet};

/// Failed simulations that are listed; more are counted.
const MOST_FAILED: usize = 10;

pub(super) fn write(page: &mut Page, campaign: &Campaign) -> Result<()> {
    page.section("sheets", "Sheets");
    let Some(last) = campaign.experiments.last_batch() else {
        page.paragraph("No experiment was asked for yet.");
        return write_imported(page, campaign);
    };
    for batch in 1..=last {
        page.subheading(&format!("Batch {batch}"));
        let (surface, by) = surface_for(campaign, batch);
        let more = known(campaign, batch, surface)?;
        let table = sheet(&campaign.problem, &campaign.experiments, batch, more);
        page.table(&table, &format!("In the order in which to run them.{by}"));
        write_failed_simulations(page, campaign, batch);
    }
    write_imported(page, campaign)
}

/// What the loop knows of each experiment: its prediction and its use.
fn known(campaign: &Campaign, batch: usize, surface: Option<&TracedSurface>) -> Result<Vec<Filled>> {
    let trials = campaign.experiments.in_run_order(batch, campaign.problem.seed);
    let trials = || trials.iter().map(|(trial, _)| trial);
    let mut filled = Vec::new();
    if let Some(surface) = surface {
        let predicted = trials().map(|trial| predicted(campaign, trial, surface)).collect::<Result<_>>()?;
        filled.push((Column::number("predicted", &campaign.problem.response.unit), predicted));
    }
    filled.push((Column::words("use"), trials().map(|trial| used_for(campaign, trial).to_owned()).collect()));
    Ok(filled)
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

fn predicted(campaign: &Campaign, trial: &Trial, surface: &TracedSurface) -> Result<String> {
    let coded = campaign.problem.region.coded(&campaign.experiments.settings_of(trial.id.number()))?;
    Ok(short(campaign.problem.response.of_cost(surface.surface().predict(&coded))))
}

fn used_for(campaign: &Campaign, trial: &Trial) -> &'static str {
    match campaign.uses.get(&trial.id.number()) {
        Some(TrialUse::Validation) => "validation",
        _ => "training",
    }
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
    let mut columns: Vec<Column> = settings_columns(&campaign.problem).collect();
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
