//! The tables of Chapter 6.

use super::campaigns::Ended;
use super::findings::Findings;
use crate::gridded::{NORMS, Q2, SUP};
use anyhow::Result;
use infuse::{
    convergence::{Bound, ErrorLevels},
    correction::{Law, ModelStage},
    global,
};
use page::{Column, Table};

/// Why a campaign ended before its limit, to be read after the iteration.
pub(crate) fn stop_words(ended: &Ended) -> String {
    match ended.campaign.stop() {
        Some(global::StopReason::BatchLimit) | None => String::new(),
        Some(global::StopReason::FewerThanTwoCells) => ", one cell".to_owned(),
        Some(global::StopReason::NoInformation) => ", no fit".to_owned(),
        Some(global::StopReason::NoSpread) => ", no spread".to_owned(),
        Some(other) => format!(", {other:?}"),
    }
}

/// Three decimals, or two digits with their power of ten for what is large or tiny.
pub(crate) fn digits(value: f64) -> String {
    if value.abs() >= 1e4 || (value.abs() < 1e-3 && value.abs() > 1e-12) {
        format!("{value:.1e}")
    } else if value.abs() <= 1e-12 {
        "0".to_owned()
    } else {
        format!("{value:.3}")
    }
}

pub(crate) fn or_dash(iteration: Option<usize>) -> String {
    iteration.map_or("–".to_owned(), |iteration| iteration.to_string())
}

/// One row for each campaign of these.
pub(crate) fn campaigns_of<'a>(findings: &Findings, ended: impl Iterator<Item = &'a Ended>) -> Table {
    let mut table = Table::new(vec![
        Column::new("Space", ""),
        Column::new("Truth", ""),
        Column::new("Correction", ""),
        Column::new("Noise", "%"),
        Column::new("Ended after", ""),
        Column::new("Space left", "%"),
        Column::new("Error, first", "s"),
        Column::new("last", "s"),
        Column::new("of bound", "%"),
        Column::new("within (55) from", "1"),
        Column::new("Best dropped at", "1"),
        Column::new("Regret left", "s"),
        Column::new("certified", "s"),
        Column::new("Regret overall", "s"),
    ]);
    for ended in ended {
        let setup = &findings.setup;
        let accuracy = &ended.accuracy;
        let (Some(first), Some(last)) = (accuracy.iterations.first(), accuracy.last()) else { continue };
        table.push(vec![
            format!("{}-D", setup.spaces[ended.case.space].space.region().n_parameters()),
            setup.truth(ended.case.truth).short.clone(),
            setup.variant(ended.case).label.clone(),
            format!("{}", 100.0 * ended.case.noise),
            format!("{}{}", last.iteration, stop_words(ended)),
            format!("{:.2}", 100.0 * last.share_after),
            digits(first.norms[Q2].error),
            digits(last.norms[Q2].error),
            format!("{:.1}", 100.0 * accuracy.largest_share_of_bound()),
            or_dash(accuracy.within_proposition_from(Q2)),
            or_dash(accuracy.best_dropped_at()),
            digits(last.retained_regret),
            digits(last.certified_regret),
            digits(last.regret),
        ]);
    }
    table
}

/// One row for each campaign.
pub(crate) fn campaigns(findings: &Findings) -> Table {
    campaigns_of(findings, findings.ended.iter())
}

/// Every iteration of every campaign.
pub(crate) fn iterations(findings: &Findings) -> Table {
    let mut columns = vec![
        Column::new("space", ""),
        Column::new("truth", ""),
        Column::new("correction", ""),
        Column::new("noise", "% of range"),
        Column::new("iteration", "1"),
        Column::new("space before", "1"),
        Column::new("space after", "1"),
        Column::new("S of (40)", "s"),
        Column::new("true cost of the optimum", "s"),
        Column::new("regret over the space", "s"),
        Column::new("regret over what was left", "s"),
        Column::new("certified regret over what was left", "s"),
        Column::new("best design is left", "1"),
    ];
    let fields = ["error", "error at the onset", "gap", "e1", "e2", "finite bound", "right-hand side of (55)"];
    for norm in NORMS {
        columns.extend(fields.iter().map(|field| Column::new(&format!("{field}, {norm}"), "s")));
    }
    let mut table = Table::new(columns);
    for ended in &findings.ended {
        let setup = &findings.setup;
        for i in &ended.accuracy.iterations {
            let mut row = vec![
                setup.spaces[ended.case.space].entry.label.clone(),
                setup.truth(ended.case.truth).label.clone(),
                setup.variant(ended.case).label.clone(),
                (100.0 * ended.case.noise).to_string(),
                i.iteration.to_string(),
                i.share_before.to_string(),
                i.share_after.to_string(),
                i.spread.map_or(String::new(), |s| s.to_string()),
                i.optimum_cost.to_string(),
                i.regret.to_string(),
                i.retained_regret.to_string(),
                i.certified_regret.to_string(),
                u8::from(i.keeps_best).to_string(),
            ];
            for n in &i.norms {
                let values = [n.error, n.onset_error, n.gap, n.simulation, n.experiment, n.finite_bound, n.proposition];
                row.extend(values.map(|value| value.to_string()));
            }
            table.push(row);
        }
    }
    table
}

/// Some iterations of one campaign in all norms.
pub(crate) fn norms(findings: &Findings, ended: &Ended) -> Table {
    let mut columns = vec![Column::new("Iteration", "1"), Column::new("Space left", "%")];
    for norm in &NORMS[Q2..] {
        for field in ["error", "bound", "(55)"] {
            columns.push(Column::new(&format!("{field}, {norm}"), "s"));
        }
    }
    columns.push(Column::new("Optimum", ""));
    columns.push(Column::new("Its cost", "s"));
    columns.push(Column::new("regret", "s"));
    columns.push(Column::new("certified", "s"));
    let mut table = Table::new(columns);
    let n = ended.accuracy.iterations.len();
    for i in &ended.accuracy.iterations {
        if ![1, 2, 3, 4, 5, 7, 10, 15, 20, 25].contains(&i.iteration) && i.iteration != n {
            continue;
        }
        let mut row = vec![i.iteration.to_string(), format!("{:.2}", 100.0 * i.share_after)];
        for norm in &i.norms[Q2..] {
            row.extend([norm.error, norm.finite_bound, norm.proposition].map(digits));
        }
        row.push(findings.point_words(ended.case.space, &i.optimum));
        row.extend([i.optimum_cost, i.retained_regret, i.certified_regret].map(digits));
        table.push(row);
    }
    table
}

pub(crate) fn flights(findings: &Findings) -> Table {
    let mut table = Table::new(vec![
        Column::new("Space", ""),
        Column::new("Truth", ""),
        Column::new("Optimum of", ""),
        Column::new("Design", ""),
        Column::new("Cost", "s"),
        Column::new("Mean heading error squared", "deg²"),
        Column::new("Mean zenith angle", "deg"),
        Column::new("Mean footprint", "m²"),
    ]);
    for pair in &findings.footprints {
        for (when, design) in ["the first iteration", "the last iteration"].into_iter().zip(&pair.designs) {
            table.push(vec![
                findings.setup.spaces[pair.space].entry.label.clone(),
                findings.setup.truth(pair.truth).short.clone(),
                when.to_owned(),
                findings.point_words(pair.space, &design.point),
                format!("{:.3}", design.cost),
                format!("{:.2}", design.heading_deg2),
                format!("{:.2}", design.zenith_deg),
                format!("{:.4}", design.footprint_m2),
            ]);
        }
    }
    table
}

/// The third question of the dissertation: how many iterations?
pub(crate) fn how_many(findings: &Findings) -> Result<Table> {
    let mut table = Table::new(vec![
        Column::new("Space", ""),
        Column::new("Truth", ""),
        Column::new("Correction", ""),
        Column::new("Bound in the limit", "s"),
        Column::new("Gap d_0", "s"),
        Column::new("Iterations", "1"),
    ]);
    for space in 0..findings.setup.spaces.len() {
        for truth in 0..findings.setup.n_truths() {
            let shown = findings.shown(space, truth)?;
            let same = |ended: &&Ended| {
                let variant = findings.setup.variant(ended.case);
                ended.case.space == space
                    && ended.case.truth == truth
                    && ended.case.noise.to_bits() == shown.case.noise.to_bits()
                    && (variant.is_general() || ended.campaign.settings().correction.law == Law::CurrentSimulation)
            };
            for ended in findings.ended.iter().filter(same) {
                let Some(first) = ended.accuracy.iterations.first() else { continue };
                let first = first.norms[SUP];
                let levels = ErrorLevels::new(first.gap, first.simulation, first.experiment)?;
                let bound = Bound::new(ended.campaign.settings().correction, ModelStage::Corrected);
                let limit = bound.limit().map(|limit| limit.error(&levels));
                let promises = limit.is_some_and(|limit| limit < first.gap);
                let needed = if promises { bound.batches_to(&levels, 0.1 * first.gap)? } else { None };
                table.push(vec![
                    findings.setup.spaces[space].entry.label.clone(),
                    findings.setup.truth(truth).short.clone(),
                    findings.setup.variant(ended.case).label.clone(),
                    limit.map_or("–".to_owned(), digits),
                    digits(first.gap),
                    or_dash(needed),
                ]);
            }
        }
    }
    Ok(table)
}

/// The fields over which everything is measured.
pub(crate) fn fields(findings: &Findings) -> Result<Table> {
    let mut table = Table::new(vec![
        Column::new("Space", ""),
        Column::new("Cells", "1"),
        Column::new("Physics", ""),
        Column::new("Lowest cost", "s"),
        Column::new("Range", "s"),
        Column::new("Best design", ""),
        Column::new("Cells that do not fly", "1"),
    ]);
    for (space, flown) in findings.flown.iter().enumerate() {
        let truths = (0..findings.setup.n_truths()).map(|truth| findings.setup.truth(truth).label.as_str());
        let physics = std::iter::once("numerical model").chain(truths);
        for (physics, grid) in physics.zip(std::iter::once(&flown.model).chain(&flown.truths)) {
            let entry = &findings.setup.spaces[space];
            let (cell, lowest) = grid.lowest()?;
            table.push(vec![
                entry.entry.label.clone(),
                entry.space.n_cells().to_string(),
                physics.to_owned(),
                format!("{lowest:.3}"),
                format!("{:.3}", grid.range()),
                findings.point_words(space, &entry.space.point(cell)?),
                grid.n_failed().to_string(),
            ]);
        }
    }
    Ok(table)
}
