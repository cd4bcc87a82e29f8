//! Batch by batch: the best design, what was dropped, what was learned.

use infuse::global::{self, BatchSurfaces, ObservedErrors};

use super::trends;
use crate::dissertation::campaign::Campaign;
use crate::dissertation::findings::{best_of_batch, dropped_because};
use crate::number::{grouped, percent, short};
use page::{Column, Page, Table};

/// In a cell that has nothing to say.
const NOTHING: &str = "–";
const BEST: &str = "Best design after each batch. S: how far experiments that the surface had not seen were missed. The last \
                    column is the best of the designs that were left, by the simulation alone.";
const LEARNED: &str = "What each batch taught. Off by up to: how far the surface of its experiments lies, at the most, from what was \
                       predicted, by the corrected simulation of the batch before, for the first batch by the simulation. Correction: how far the \
                       corrected simulation moved. Bound: see Bounds. Noise: standard deviation of repeats, of all batches \
                       so far. Lack of fit: a probability p below 0.05 says that the surface of the experiments misses more \
                       than noise explains.";

pub(super) fn write(page: &mut Page, campaign: &Campaign, observed: &[Option<ObservedErrors>]) {
    page.section("history", "History");
    let reports = campaign.now.reports();
    if reports.is_empty() {
        page.paragraph("No batch is closed yet.");
        return;
    }
    trends::write(page, campaign, observed);
    page.table(&best(campaign, reports), BEST);
    let of = grouped(campaign.now.retained().n_cells());
    page.table(&dropped(campaign, reports), &format!("What each batch dropped of the {of} designs, and why."));
    page.table(&learned(campaign, reports, observed), LEARNED);
}

fn best(campaign: &Campaign, reports: &[global::Report]) -> Table {
    let response = &campaign.problem.response;
    let row = |report: &global::Report| {
        let screening = &report.screening;
        vec![
            report.number.to_string(),
            campaign.problem.describe(&screening.optimum),
            short(response.of_cost(screening.optimum_value)),
            screening.spread.s().map_or_else(nothing, short),
            best_of_batch(report).map_or_else(nothing, |cost| short(response.of_cost(cost))),
            campaign.problem.describe(&screening.simulation_optimum),
        ]
    };
    Table {
        columns: vec![
            Column::number("batch", ""),
            Column::words("best design"),
            Column::number("predicted", &response.unit),
            Column::number("S", &response.unit),
            Column::number("best measured in the batch", &response.unit),
            Column::words("simulation alone"),
        ],
        rows: reports.iter().map(row).collect(),
    }
}

fn dropped(campaign: &Campaign, reports: &[global::Report]) -> Table {
    let of = campaign.now.retained().n_cells();
    let row = |report: &global::Report| {
        let screening = &report.screening;
        vec![
            report.number.to_string(),
            grouped(screening.n_before - screening.n_after),
            dropped_because(campaign, report),
            grouped(screening.n_after),
            percent(screening.n_after as f64 / of as f64),
        ]
    };
    Table {
        columns: vec![
            Column::number("batch", ""),
            Column::number("dropped", ""),
            Column::words("why"),
            Column::number("left", ""),
            Column::number("share", ""),
        ],
        rows: reports.iter().map(row).collect(),
    }
}

fn learned(campaign: &Campaign, reports: &[global::Report], observed: &[Option<ObservedErrors>]) -> Table {
    let optional = |amount: Option<f64>| amount.map_or_else(nothing, short);
    let unit = &campaign.problem.response.unit;
    let rows = reports.iter().zip(campaign.now.surfaces()).zip(observed);
    let row = |((report, surfaces), observed): ((&global::Report, &BatchSurfaces), &Option<ObservedErrors>)| {
        let noise = campaign.experiments.noise_until(report.number);
        vec![
            report.number.to_string(),
            optional(report.changes.innovation),
            short(report.changes.model),
            optional(observed.map(|observed| observed.eps)),
            format!("{} of {}", report.failed_trials().count(), report.trials.len()),
            format!("{} of {}", report.failed_simulations().count(), report.simulations.len()),
            optional(noise.map(|noise| noise.standard_deviation())),
            lack_of_fit(surfaces),
        ]
    };
    Table {
        columns: vec![
            Column::number("batch", ""),
            Column::number("off by up to", unit),
            Column::number("correction", unit),
            Column::number("bound", unit),
            Column::number("experiments failed", ""),
            Column::number("simulations failed", ""),
            Column::number("noise", unit),
            Column::number("lack of fit, p", ""),
        ],
        rows: rows.map(row).collect(),
    }
}

fn lack_of_fit(surfaces: &BatchSurfaces) -> String {
    let test = surfaces.experiment.as_ref().and_then(|surface| surface.regression()?.lack_of_fit().ok());
    test.map_or_else(nothing, |test| short(test.p_value))
}

fn nothing() -> String {
    NOTHING.to_owned()
}
