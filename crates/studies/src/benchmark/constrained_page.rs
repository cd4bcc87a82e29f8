//! `docs/results-constraints.md`: how often what was promised of a constraint held, or of a run to give a value, and how good the
//! recommended designs are.

use page::{Column, Finding, Table, quantile};

use super::constrained::{ALLOWED, BATCHES, CASES, Case, EDGE, RESPONDING, Row, SEEDS, WAYS, Way};
use super::figure::Regrets;
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
    /// Mean share of runs that gave no value.
    failed: f64,
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
            failed: rows.iter().map(|row| row.failed / rows.len() as f64).sum(),
        }
    }
}

fn of<'a>(rows: &'a [Row], way: &Way, is_meant: impl Fn(&Row) -> bool) -> Vec<&'a Row> {
    rows.iter().filter(|row| row.way == way.name && is_meant(row)).collect()
}

/// A part of the campaigns that is told of for itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Part {
    /// A response has to stay within a bound.
    Bound,
    /// Beyond the bound runs fail.
    Failing,
}

impl Part {
    fn has(self, case: &Case) -> bool {
        (self == Self::Failing) == case.kind.fails()
    }

    fn cases(self) -> impl Iterator<Item = &'static Case> {
        CASES.iter().filter(move |case| self.has(case))
    }

    fn rows(self, rows: &[Row]) -> Vec<Row> {
        rows.iter().filter(|row| self.cases().any(|case| case.name == row.family)).cloned().collect()
    }
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
    let mut text = "# Responses within bounds, and runs that fail\n\n".to_owned();
    let [bound, failing] = [Part::Bound, Part::Failing].map(|part| part.rows(rows));
    let all = Came::of(&of(&bound, &WAYS[0], |_| true));
    let kept = format!(
        "Of {} recommended designs of the pooled loop that were said to keep to the bound with 90 % probability or more ({} % on \
         average), {} % truly do; of the certificates {} % held.",
        number((all.n as f64 * all.suffice).round(), 0),
        exactly(all.promised),
        exactly(all.kept),
        exactly(all.held)
    );
    let all = Came::of(&of(&failing, &WAYS[0], |_| true));
    let responds = format!(
        "Where a quarter to {} % of all designs fail, of {} recommended ones, said to give a value with {} % probability on average, {} % do; of \
         the certificates {} % held.",
        percent(1.0 - RESPONDING),
        number((all.n as f64 * all.suffice).round(), 0),
        exactly(all.promised),
        exactly(all.kept),
        exactly(all.held)
    );
    let worse = |rows: &[Row]| {
        let last = |way: &Way| Came::of(&of(rows, way, |row| row.batch == BATCHES));
        let said = WAYS.iter().map(|way| {
            let came = last(way);
            format!("{} {} % (90th percentile {} %)", way.words, number(came.median, 2), number(came.p90, 2))
        });
        said.collect::<Vec<_>>().join("; ")
    };
    let findings = [
        kept,
        format!(
            "After {BATCHES} batches the recommended design is, in the median, worse than the best that is allowed by: {}.",
            worse(&bound)
        ),
        responds,
        format!(
            "Where runs fail it is worse than the best that gives a value by: {}; {} % of the runs of the first gave none.",
            worse(&failing),
            percent(Came::of(&of(&failing, &WAYS[0], |row| row.batch == BATCHES)).failed)
        ),
    ];
    text += &around(
        &findings.map(Finding::new),
        "![Regret among the allowed](results-constraints.svg)",
        &format!(
            "Median over all families and {SEEDS} seeds, of the recommended designs that keep to the bound, or give a value. Lower is \
             better."
        ),
    );
    text += &format!(
        "\nThe response is that of a family of the [benchmark](results-benchmark.md), the constrained one that of the same family with \
         another seed: at most the {} % quantile of all designs. Both are measured with noise, and simulated wrongly. Regret is in percent \
         of the range of the response. In the cases with a choice the last \
         parameter is one of four, at places of its axis in no order. Where runs fail, nothing is measured beyond the {} % quantile, at an edge (beyond {} % of the first parameter) or with one of four \
         choices, not even by how much, and the simulation knows nothing of it. Nothing was tuned on these campaigns. The way that knows nothing of what is promising runs Sobol \
         points and recommends by the same rule.\n\nWritten by `cargo xtask benchmark --constrained` from \
         `fixtures/benchmark/constrained.csv`; `--page` runs none, and `--check`, a part of `cargo xtask ci`, runs some anew.\n\n\
         ## Batch by batch\n\n{}\n## Family by family, after the last batch\n\n{}\n## Where runs fail, batch by batch\n\n{}\n\
         ## Where runs fail, family by family, after the last batch\n\n{}",
        percent(ALLOWED),
        percent(RESPONDING),
        percent(EDGE),
        table(rows, Part::Bound, true).markdown(),
        table(rows, Part::Bound, false).markdown(),
        table(rows, Part::Failing, true).markdown(),
        table(rows, Part::Failing, false).markdown()
    );
    text
}

fn table(rows: &[Row], part: Part, by_batch: bool) -> Table {
    let rows = &part.rows(rows);
    let mut cells = Vec::new();
    for way in &WAYS {
        let parts: Vec<(String, Vec<&Row>)> = if by_batch {
            (1..=BATCHES).map(|batch| (batch.to_string(), of(rows, way, |row| row.batch == batch))).collect()
        } else {
            part.cases()
                .map(|case| {
                    (case.name.to_owned(), of(rows, way, |row| row.family == case.name && row.batch == BATCHES))
                })
                .collect()
        };
        for (name, rows) in parts {
            let Came { n, suffice, promised, kept, median, p90, held, width, failed } = Came::of(&rows);
            let mut row = vec![
                way.words.to_owned(),
                name,
                n.to_string(),
                percent(suffice),
                percent(promised),
                percent(kept),
                number(median, 2),
                number(p90, 2),
                percent(held),
                number(width, 1),
            ];
            if part == Part::Failing {
                row.push(percent(failed));
            }
            cells.push(row);
        }
    }
    let mut columns = vec![
        Column::words("way"),
        Column::words(if by_batch { "batch" } else { "family" }),
        Column::number("campaigns", ""),
        Column::number("said to suffice", "%"),
        Column::number(if part == Part::Bound { "promised to keep" } else { "promised to give a value" }, "%"),
        Column::number(if part == Part::Bound { "keep" } else { "give one" }, "%"),
        Column::number("regret, median", "%"),
        Column::number("90th percentile", "%"),
        Column::number("certificates that held", "%"),
        Column::number("their width, median", "%"),
    ];
    if part == Part::Failing {
        columns.push(Column::number("runs that failed", "%"));
    }
    Table { columns, rows: cells }
}

fn picture(rows: &[Row]) -> String {
    let curve = |way: &Way, part: Part, n_factors: usize| -> Vec<f64> {
        let has = |case: &Case| case.family().is_ok_and(|family| family.n_factors == n_factors);
        let is_one = |name: &str| part.cases().any(|case| case.name == name && has(case));
        (1..=BATCHES)
            .map(|batch| {
                let rows = of(rows, way, |row| row.batch == batch && is_one(&row.family));
                // On a scale of ratios nothing is drawn as nothing.
                Came::of(&rows).median.max(0.02)
            })
            .collect()
    };
    let panel = |(part, n_factors): (Part, usize)| {
        let what = if part == Part::Bound { "regret" } else { "runs fail: regret" };
        let curves = WAYS.iter().map(|way| (way.words, curve(way, part, n_factors))).collect();
        (format!("{what}, {n_factors} parameters"), curves)
    };
    Regrets {
        title: "How much worse the recommended design is than the best that keeps to the bound",
        panels: [Part::Bound, Part::Failing].into_iter().flat_map(|part| [(part, 2), (part, 4)]).map(panel).collect(),
        is_one_scale: false,
    }
    .picture()
}
