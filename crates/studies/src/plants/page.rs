//! `docs/results-plants.md`: regret against plants built.

use std::path::Path;

use anyhow::Result;
use page::{Axis, Column, Finding, LineFigure, Panel, Series, Table, line_figure, quantile};

use super::campaign::{ASSEMBLY, BATCHES, EXPERIMENTS, METHODS, Method, NOISE, SEEDS};
use super::case::Case;
use super::store::Store;
use crate::first_screen::around;
use crate::kept;
use crate::words::{capitalized, number};

const PAGE: &str = "docs/results-plants.md";
const PICTURE: &str = "docs/results-plants.svg";

pub(super) fn write(root: &Path, cases: &[Case], store: &Store) -> Result<()> {
    kept::write(root, &texts(cases, store))
}

pub(super) fn check(root: &Path, cases: &[Case], store: &Store) -> Result<()> {
    kept::check(root, &texts(cases, store), "does not follow from the campaigns kept: run `cargo xtask plants --page`")
}

fn texts(cases: &[Case], store: &Store) -> [(&'static str, String); 2] {
    [(PAGE, markdown(cases, store)), (PICTURE, picture(cases, store))]
}

/// Quantiles over the seeds after a batch, in percent.
struct After {
    plants: f64,
    median: f64,
    p90: f64,
    /// Share of certificates that held.
    held: f64,
}

fn after(case: &Case, method: &Method, batch: usize, store: &Store) -> After {
    let rows: Vec<_> = store
        .rows
        .iter()
        .filter(|row| row.case == case.name && row.method == method.name && row.batch == batch)
        .collect();
    let of = |values: Vec<f64>, share: f64| quantile(&values, share).unwrap_or(f64::NAN);
    let regrets = || rows.iter().map(|row| 100.0 * row.regret).collect::<Vec<f64>>();
    let held = rows.iter().filter(|row| row.regret <= row.bound + 1e-9).count();
    After {
        plants: of(rows.iter().map(|row| row.plants as f64).collect(), 0.5),
        median: of(regrets(), 0.5),
        p90: of(regrets(), 0.9),
        held: held as f64 / rows.len().max(1) as f64,
    }
}

/// The first batch after which the median regret is at most this, with the plants built by then.
fn first_at_most(case: &Case, method: &Method, regret: f64, store: &Store) -> Option<(usize, f64)> {
    let of = |batch: usize| (batch, after(case, method, batch, store));
    (1..=BATCHES).map(of).find(|(_, after)| after.median <= regret).map(|(batch, after)| (batch, after.plants))
}

fn markdown(cases: &[Case], store: &Store) -> String {
    let mut text = "# Plants that have to be built\n\n".to_owned();
    let findings: Vec<Finding> = cases.iter().map(|case| Finding::new(finding(case, store))).collect();
    text += &around(
        &findings,
        "![Regret against plants built](results-plants.svg)",
        &format!(
            "Median of {SEEDS} seeds, a dot a batch of {EXPERIMENTS} experiments. Further left is cheaper, lower is better."
        ),
    );
    text += &format!(
        "\nTwo parameters are built, the others are typed: two, and one of the formula. A plant is put together for a batch and taken apart after it; what goes wrong \
         then is an error that its runs share, of {} % of what 80 % of all designs span, beside the noise of a run of {} %. Regret is what \
         the recommended design costs more than the best that is known, in percent of the same; the machines are the stand-in for the \
         water channel, the test stand of the [suspension](tutorial-campaign-suspension.md), and a formula with a ripple along what is built that \
         its simulation lacks. Nothing was tuned on the campaigns of turbine and suspension; how large a part of the response may be the \
         plant's own was chosen among three on others with such a ripple, and the first five seeds of the suspension.\n\n\
         Written by `cargo xtask plants` from `fixtures/plants`; `--page` runs none, and `--check`, a part of `cargo xtask ci`, runs one \
         campaign of each machine anew; what designs cost it takes from there, and finds one in fifty of them anew.\n",
        number(100.0 * ASSEMBLY, 0),
        number(100.0 * NOISE, 0)
    );
    for case in cases {
        text += &format!(
            "\n## {}\n\nA design drawn at random has a median regret of {} %.\n\n{}",
            capitalized(case.words),
            number(100.0 * (case.typical - case.best) / case.spread, 0),
            table(case, store).markdown()
        );
    }
    text
}

fn finding(case: &Case, store: &Store) -> String {
    let [own, _, two, blind] = &METHODS;
    let last = |method: &Method| after(case, method, BATCHES, store);
    let goal = last(own).median.max(last(two).median).max(0.5);
    let reached = |method: &Method| match first_at_most(case, method, goal, store) {
        Some((batch, plants)) => format!("{} plants in {batch} batches", number(plants, 0)),
        None => "not reached".to_owned(),
    };
    format!(
        "**{}**: a median regret of {} % takes {} with two plants a batch, and {} where each run has its own; after {BATCHES} batches \
         two plants that nobody chose, with settings that nobody chose, are at {} %.",
        case.words,
        number(goal, 1),
        reached(two),
        reached(own),
        number(last(blind).median, 1)
    )
}

fn table(case: &Case, store: &Store) -> Table {
    let mut rows = Vec::new();
    for method in &METHODS {
        for batch in 1..=BATCHES {
            let After { plants, median, p90, held } = after(case, method, batch, store);
            let cells = [number(plants, 0), number(median, 2), number(p90, 2), number(100.0 * held, 0)];
            rows.push([vec![method.words.to_owned(), batch.to_string()], cells.to_vec()].concat());
        }
    }
    let columns = vec![
        Column::words("campaigns"),
        Column::number("batch", ""),
        Column::number("plants built", ""),
        Column::number("regret, median", "%"),
        Column::number("90th percentile", "%"),
        Column::number("certificates that held", "%"),
    ];
    Table { columns, rows }
}

fn picture(cases: &[Case], store: &Store) -> String {
    let curve = |case: &Case, method: &Method| -> (Vec<f64>, Vec<f64>) {
        (1..=BATCHES)
            .map(|batch| {
                let After { plants, median, .. } = after(case, method, batch, store);
                // On a scale of ratios nothing is drawn as nothing.
                (plants, median.max(0.05))
            })
            .unzip()
    };
    let all = || cases.iter().flat_map(|case| METHODS.iter().map(move |method| curve(case, method)));
    let plants: Vec<f64> = all().flat_map(|(plants, _)| plants).collect();
    let most = plants.iter().copied().fold(0.0, f64::max);
    let panel = |case: &Case| {
        let heights: Vec<f64> = all().flat_map(|(_, regrets)| regrets).flat_map(|y| [0.85 * y, 1.18 * y]).collect();
        let series = METHODS.iter().map(|method| {
            let (x, y) = curve(case, method);
            let line = Series::line(method.words, &x, &y);
            if method.name == "two" { line } else { line.dashed() }
        });
        Panel {
            x_axis: Some(Axis::new("plants built", "1").with_range(0.0, most + 2.0)),
            y_axis: Axis::new(&format!("regret, {}", case.name), "%").in_ratios(heights),
            series: series.collect(),
        }
    };
    line_figure(&LineFigure {
        title: "How much worse the recommended design is than the best, against the plants built for it".to_owned(),
        x_axis: Axis::new("plants built", "1"),
        panels: cases.iter().map(panel).collect(),
        shaded: None,
    })
}
