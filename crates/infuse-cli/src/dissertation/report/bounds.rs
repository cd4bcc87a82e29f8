//! What can be promised, and on which conditions.

use anyhow::Result;
use infuse::global::ObservedErrors;

use crate::dissertation::campaign::Campaign;
use crate::number::{count, grouped, percent};
use page::{Column, Page, Table};

pub(super) fn write(page: &mut Page, campaign: &Campaign) -> Result<()> {
    page.section("bounds", "Bounds");
    if campaign.now.reports().is_empty() {
        page.paragraph("No batch is closed yet, so there is nothing to bound.");
        return Ok(());
    }
    let Some(observed) = campaign.now.observed_certificate()? else {
        page.paragraph(
            "No bound can be given: in some batch the experiments or the simulations were too few, or of a kind of surface, \
             that cannot be fitted without each of its runs in turn.",
        );
        return Ok(());
    };
    let possible = campaign.now.possible_optima(observed.eps)?.map(|possible| possible.n_retained());
    let columns = vec![Column::words("quantity"), Column::number("value", ""), Column::words("what it is")];
    let table = Table { columns, rows: rows(campaign, &observed, possible) };
    page.table(&table, "From what was observed to what follows.");
    page.paragraph("It holds on these conditions:");
    page.list(&conditions(campaign));
    Ok(())
}

fn rows(campaign: &Campaign, observed: &ObservedErrors, possible: Option<u64>) -> Vec<Vec<String>> {
    let reports = campaign.now.reports();
    let gap = |report: Option<&infuse::global::Report>| report.and_then(|report| report.changes.gap);
    let row = |name: &str, value: String, meaning: &str| vec![name.to_owned(), value, meaning.to_owned()];
    let mut rows = Vec::new();
    if let Some(first) = gap(reports.first()) {
        let meaning =
            "largest distance of the surface of the experiments from that of the simulation, over all designs";
        rows.push(row("gap in batch 1", campaign.problem.response.amount(first), meaning));
    }
    if let Some(last) = gap(reports.last()).filter(|_| reports.len() > 1) {
        let meaning = "the same over the designs that were left when the last batch began";
        rows.push(row(&format!("gap in batch {}", reports.len()), campaign.problem.response.amount(last), meaning));
    }
    rows.push(row(
        "error of the simulation's surfaces",
        campaign.problem.response.amount(observed.simulation),
        "largest miss at a simulation that was left out of the fit, over all batches",
    ));
    rows.push(row(
        "error of the experiments' surfaces",
        campaign.problem.response.amount(observed.experiment),
        "largest miss at an experiment that was left out of the fit, its noise included, over all batches",
    ));
    rows.push(row(
        "bound (eps)",
        campaign.problem.response.amount(observed.eps),
        "the corrected simulation is off by at most this: the errors of all batches and what is left of the gap, weighted \
         as the correction weights them",
    ));
    rows.push(row(
        "guarantee",
        campaign.problem.response.amount(observed.certificate.regret),
        "no design left is better than the best one by more than this",
    ));
    if let Some(possible) = possible {
        rows.push(row(
            "designs that may be the best",
            grouped(possible),
            "so many of those left are, by the corrected simulation, within twice the bound of its best",
        ));
    }
    rows
}

fn conditions(campaign: &Campaign) -> Vec<String> {
    let doubt = percent(1.0 - campaign.now.settings().confidence);
    let n_runs: usize = campaign.now.reports().iter().map(|report| report.trials.len()).sum();
    vec![
        format!(
            "The surfaces err nowhere by more than at the runs that were left out, one at a time. It was checked at {} and at \
             the simulations; between them it is assumed.",
            count(n_runs, "experiment")
        ),
        "It speaks of the designs that are left.".to_owned(),
        format!(
            "About a design that was dropped it says nothing. Those were dropped by a test whose level of {doubt} is not \
             the chance of having dropped the best."
        ),
    ]
}
