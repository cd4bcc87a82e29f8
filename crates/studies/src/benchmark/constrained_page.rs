//! `docs/results-constraints.md`: how often what was promised of a constraint held, and how good the recommended designs are.

use page::{Axis, Column, Finding, LineFigure, Panel, Series, Table, line_figure, quantile};

use super::constrained::{ALLOWED, BATCHES, CASES, Case, Row, SEEDS, WAYS, Way};
use crate::first_screen::around;
use crate::words::number;

pub(super) const PAGE: &str = "docs/results-constraints.md";
pub(super) const PICTURE: &str = "docs/results-constraints.svg";

/// What came of some rows.
struct Came {
    n: usize,
    /// Share of recommended designs that were said to suffice.
    suffice: f64,
    /// Of those, the mean probability that was printed, and the share that does keep to the bound.
    promised: f64,
    kept: f64,
    /// Of those that keep to it, what they are worse by than the best that does, in percent.
    median: f64,
    p90: f64,
    /// Share of certificates that held.
    held: f64,
    /// The median of what they say, in percent.
    width: f64,
}

impl Came {
    fn of(rows: &[&Row]) -> Self {
        let sure: Vec<&&Row> = rows.iter().filter(|row| row.suffices).collect();
        let share = |n: usize, of: usize| if of == 0 { f64::NAN } else { n as f64 / of as f64 };
        let kept: Vec<f64> = sure.iter().filter(|row| row.keeps).map(|row| 100.0 * row.regret).collect();
        let at = |share: f64| quantile(&kept, share).unwrap_or(f64::NAN);
        // No design that keeps to the bound is better by more, whether or not the recommended one does.
        let held = rows.iter().filter(|row| row.regret <= row.bound + 1e-9).count();
        Self {
            n: rows.len(),
            suffice: share(sure.len(), rows.len()),
            promised: sure.iter().map(|row| row.promised / sure.len() as f64).sum(),
            kept: share(kept.len(), sure.len()),
            median: at(0.5),
            p90: at(0.9),
            held: share(held, rows.len()),
            width: 100.0 * quantile(&rows.iter().map(|row| row.bound).collect::<Vec<_>>(), 0.5).unwrap_or(f64::NAN),
        }
    }
}

fn of<'a>(rows: &'a [Row], way: &Way, is_meant: impl Fn(&Row) -> bool) -> Vec<&'a Row> {
    rows.iter().filter(|row| row.way == way.name && is_meant(row)).collect()
}

pub(super) fn texts(rows: &[Row]) -> [(&'static str, String); 2] {
    [(PAGE, markdown(rows)), (PICTURE, picture(rows))]
}

fn percent(share: f64) -> String {
    number(100.0 * share, 0)
}

/// Where a few in a thousand count.
fn exactly(share: f64) -> String {
    number(100.0 * share, 1)
}

fn markdown(rows: &[Row]) -> String {
    let mut text = "# Responses within bounds\n\n".to_owned();
    let last = |way: &Way| Came::of(&of(rows, way, |row| row.batch == BATCHES));
    let all = Came::of(&of(rows, &WAYS[0], |_| true));
    let kept = format!(
        "Of {} recommended designs of the pooled loop that were said to keep to the bound with 90 % probability or more ({} % on \
         average), {} % truly do; of the certificates {} % held.",
        number((all.n as f64 * all.suffice).round(), 0),
        exactly(all.promised),
        exactly(all.kept),
        exactly(all.held)
    );
    let said: Vec<String> = WAYS
        .iter()
        .map(|way| {
            let came = last(way);
            format!("{} {} % (90th percentile {} %)", way.words, number(came.median, 2), number(came.p90, 2))
        })
        .collect();
    let worse = format!(
        "After {BATCHES} batches the recommended design is, in the median, worse than the best that is allowed by: {}.",
        said.join("; ")
    );
    text += &around(
        &[kept, worse].map(Finding::new),
        "![Regret among the allowed](results-constraints.svg)",
        &format!(
            "Median over all families and {SEEDS} seeds, of the recommended designs that keep to the bound. Lower is better."
        ),
    );
    text += &format!(
        "\nThe response is that of a family of the [benchmark](results-benchmark.md), the constrained one that of the same family with \
         another seed: at most the {} % quantile of all designs. Both are measured with noise, and simulated wrongly. Regret is in percent \
         of the range of the response. In the cases with a choice the last \
         parameter is one of four, at places of its axis in no order. Nothing was tuned on these campaigns. The way that knows nothing of what is promising runs Sobol \
         points and recommends by the same rule.\n\nWritten by `cargo xtask benchmark --constrained` from \
         `fixtures/benchmark/constrained.csv`; `--page` runs none, and `--check`, a part of `cargo xtask ci`, runs some anew.\n\n\
         ## Batch by batch\n\n{}\n## Family by family, after the last batch\n\n{}",
        percent(ALLOWED),
        table(rows, true).markdown(),
        table(rows, false).markdown()
    );
    text
}

fn table(rows: &[Row], by_batch: bool) -> Table {
    let mut cells = Vec::new();
    for way in &WAYS {
        let parts: Vec<(String, Vec<&Row>)> = if by_batch {
            (1..=BATCHES).map(|batch| (batch.to_string(), of(rows, way, |row| row.batch == batch))).collect()
        } else {
            CASES
                .iter()
                .map(|case| {
                    (case.name.to_owned(), of(rows, way, |row| row.family == case.name && row.batch == BATCHES))
                })
                .collect()
        };
        for (part, rows) in parts {
            let Came { n, suffice, promised, kept, median, p90, held, width } = Came::of(&rows);
            cells.push(vec![
                way.words.to_owned(),
                part,
                n.to_string(),
                percent(suffice),
                percent(promised),
                percent(kept),
                number(median, 2),
                number(p90, 2),
                percent(held),
                number(width, 1),
            ]);
        }
    }
    let columns = vec![
        Column::words("way"),
        Column::words(if by_batch { "batch" } else { "family" }),
        Column::number("campaigns", ""),
        Column::number("said to suffice", "%"),
        Column::number("promised to keep", "%"),
        Column::number("keep", "%"),
        Column::number("regret, median", "%"),
        Column::number("90th percentile", "%"),
        Column::number("certificates that held", "%"),
        Column::number("their width, median", "%"),
    ];
    Table { columns, rows: cells }
}

fn picture(rows: &[Row]) -> String {
    let batches: Vec<f64> = (1..=BATCHES).map(|batch| batch as f64).collect();
    let curve = |way: &Way, n_factors: usize| -> Vec<f64> {
        let has = |case: &Case| case.family().is_ok_and(|family| family.n_factors == n_factors);
        let is_one = |name: &str| CASES.iter().any(|case| case.name == name && has(case));
        (1..=BATCHES)
            .map(|batch| {
                let rows = of(rows, way, |row| row.batch == batch && is_one(&row.family));
                // On a scale of ratios nothing is drawn as nothing.
                Came::of(&rows).median.max(0.02)
            })
            .collect()
    };
    let panel = |n_factors: usize| {
        let curves: Vec<(&Way, Vec<f64>)> = WAYS.iter().map(|way| (way, curve(way, n_factors))).collect();
        let heights: Vec<f64> = curves.iter().flat_map(|(_, y)| y).flat_map(|y| [0.85 * y, 1.18 * y]).collect();
        let series = curves.iter().map(|(way, y)| {
            let line = Series::line(way.words, &batches, y);
            if way.name == WAYS[0].name { line } else { line.dashed() }
        });
        Panel {
            x_axis: Some(Axis::new("batches of experiments", "1").counting_to(BATCHES)),
            y_axis: Axis::new(&format!("regret, {n_factors} parameters"), "% of range").in_ratios(heights),
            series: series.collect(),
        }
    };
    line_figure(&LineFigure {
        title: "How much worse the recommended design is than the best that keeps to the bound".to_owned(),
        x_axis: Axis::new("batches of experiments", "1").counting_to(BATCHES),
        panels: [2, 4].map(panel).into_iter().collect(),
        shaded: None,
    })
}
