//! `docs/results-drift.md`: what a rig costs that drifts from batch to batch, and how often that is said.

use anyhow::{Context as _, Result};
use infuse::pooled::reported::Drift;
use page::{Column, Finding, Table};

use super::drift::{BATCHES, KINDS, Kind, NAMES, Row, SEEDS, WAYS, Way};
use super::figure::Regrets;
use super::summary::{FLOOR, Paired, is_broken};
use crate::first_screen::around;
use crate::words::number;

const PAGE: &str = "docs/results-drift.md";
const PICTURE: &str = "docs/results-drift.svg";

/// The kind that drifts most.
const MOST: usize = 2;

fn of(rows: &[Row], kind: Kind, way: Way, batch: usize) -> Vec<&Row> {
    let is_meant = |row: &&Row| row.kind == kind.name && row.way == way.name && row.batch == batch;
    let mut found: Vec<&Row> = rows.iter().filter(is_meant).collect();
    found.sort_by(|a, b| a.family.cmp(&b.family).then(a.seed.cmp(&b.seed)));
    found
}

fn logarithm(row: &Row) -> f64 {
    (row.regret + FLOOR).log10()
}

/// The geometric mean of what is missing, the floor added to each, in percent.
fn typical(rows: &[&Row]) -> f64 {
    let sum: f64 = rows.iter().map(|row| logarithm(row)).sum();
    100.0 * 10.0_f64.powf(sum / rows.len().max(1) as f64)
}

/// What is missing in this way by that of results as they are, campaign by campaign.
fn paired(rows: &[Row], kind: Kind, way: Way, batch: usize) -> Option<Paired> {
    let [plain, other] = [WAYS[0], way].map(|way| of(rows, kind, way, batch));
    let ratios = other.iter().zip(plain).map(|(other, plain)| logarithm(other) - logarithm(plain));
    Paired::of(&ratios.collect::<Vec<_>>())
}

fn broken(rows: &[&Row]) -> usize {
    rows.iter().filter(|row| is_broken(row.regret, row.bound)).count()
}

/// Of the range, in percent.
fn median_bound(rows: &[&Row]) -> String {
    let bounds: Vec<f64> = rows.iter().map(|row| 100.0 * row.bound).collect();
    number(page::quantile(&bounds, 0.5).unwrap_or(f64::NAN), 1)
}

fn said(rows: &[&Row]) -> usize {
    rows.iter().filter(|row| row.is_said).count()
}

pub(super) fn texts(rows: &[Row]) -> Result<[(&'static str, String); 2]> {
    Ok([(PAGE, markdown(rows)?), (PICTURE, picture(rows))])
}

fn findings(rows: &[Row]) -> Vec<Finding> {
    let last = |kind: Kind| WAYS.map(|way| typical(&of(rows, kind, way, BATCHES)));
    let [still, most] = [KINDS[0], KINDS[MOST]].map(last);
    let head = Finding::new(format!(
        "On a rig that reads all runs of a batch three noises higher or lower, anew each batch, {} % of the range is missing after {BATCHES} \
         batches; {} % if it is told by `blocks`, {} % if it finds out by itself, as it does unless told; where nothing drifts {}, {} and {} %.",
        number(most[0], 2),
        number(most[1], 2),
        number(most[2], 2),
        number(still[0], 2),
        number(still[1], 2),
        number(still[2], 2)
    ));
    let quiet = |batch| of(rows, KINDS[0], WAYS[0], batch);
    let [alarms, assessments] = [said as fn(&[&Row]) -> usize, |rows| rows.len()]
        .map(|count| (2..=BATCHES).map(|batch| count(&quiet(batch))).sum::<usize>());
    let mut detected = Finding::new(format!(
        "That a rig drifts is said where nothing drifts in {alarms} of {assessments} assessments from batch 2 on, and where it does, after batches \
         2 to {BATCHES}:"
    ));
    for kind in &KINDS[1..] {
        let of_each = (2..=BATCHES).map(|batch| {
            let there = of(rows, *kind, WAYS[0], batch);
            format!("{:.0}", 100.0 * said(&there) as f64 / there.len().max(1) as f64)
        });
        detected = detected.detail(Finding::new(format!(
            "{}: in {} % of the campaigns.",
            crate::words::capitalized(kind.words),
            of_each.collect::<Vec<_>>().join(", ")
        )));
    }
    let held = WAYS.map(|way| {
        let all: Vec<&Row> =
            (1..=BATCHES).flat_map(|batch| KINDS.map(|kind| of(rows, kind, way, batch)).concat()).collect();
        format!("{} of {}, {}", broken(&all), all.len(), way.words)
    });
    let widths = WAYS.map(|way| median_bound(&of(rows, KINDS[0], way, BATCHES)));
    let certificates = format!(
        "Batches after which the certificate was broken: {}; where nothing drifts it is after {BATCHES} batches {} % of the range in the median.",
        held.join("; "),
        widths.join(", ")
    );
    vec![head, detected, Finding::new(certificates)]
}

fn markdown(rows: &[Row]) -> Result<String> {
    let mut text = "# A rig that drifts\n\n".to_owned();
    text += &around(
        &findings(rows),
        "![Regret after each batch, by how the rig drifts](results-drift.svg)",
        "What is missing after each batch: geometric mean over campaigns, 0.3 % of the range added to each. Lower is better.",
    );
    text += &format!(
        "\nWritten by `cargo xtask benchmark --drift` from the campaigns kept in `fixtures/benchmark/drift.csv`; delete rows there and they are \
         run anew. With `--check` it runs some of them again. Families of the [benchmark](results-benchmark.md): `{}`, seeds {} to {}, on which \
         nothing was chosen; the gain from which on a drift is believed, {}, was chosen on others, 601 to 604, 621 and 622, as were the two witnesses that have to agree, with Chapter 7 and a truth that is no family here; \
         that it is asked once more without results that are far from what all others say, on problems that are no family here. To what is read all runs of a \
         batch have something added; with `blocks` the loop knows that they may, not how much; by itself it takes that in as soon as the results are sure of it.\n",
        NAMES.join("`, `"),
        SEEDS.start(),
        SEEDS.end(),
        Drift::SURE
    );
    text += "\n## What is missing\n\nGeometric mean in % of the range after each batch, and the mean of the decimal logarithm of the ratio to that of \
             results as they are, campaign by campaign, after the last one, with its standard error. Of each drift there are as many campaigns.\n\n";
    let heads = ["drift", WAYS[0].words, WAYS[1].words, "its ratio", WAYS[2].words, "its ratio"];
    let mut table = Table::new(heads.map(Column::words).to_vec());
    for kind in KINDS {
        let by_batch = |way: Way| {
            (1..=BATCHES).map(|batch| number(typical(&of(rows, kind, way, batch)), 2)).collect::<Vec<_>>().join(", ")
        };
        let ratio = |way: Way| {
            let Paired { mean, error, .. } = paired(rows, kind, way, BATCHES).context("too few campaigns")?;
            Ok::<_, anyhow::Error>(format!("{mean:.2} ± {error:.2}"))
        };
        table.push(vec![
            kind.words.to_owned(),
            by_batch(WAYS[0]),
            by_batch(WAYS[1]),
            ratio(WAYS[1])?,
            by_batch(WAYS[2]),
            ratio(WAYS[2])?,
        ]);
    }
    text += &table.markdown();
    text += "\n## What is said, and what is promised\n\nIn how many campaigns it is said that the rig drifts, after each batch from the second \
             on; in how many the certificate was broken, after any batch; the median of what it says in % of the range after the last one; each \
             for results as they are, with `blocks`, and once results are sure. Last, the median of the error that runs of a batch share, in \
             noises of one run, as it is then learnt with `blocks`.\n\n";
    let heads = ["drift", "campaigns", "said", "broken", "c", "shared error"];
    let mut table = Table::new(heads.map(Column::words).to_vec());
    for kind in KINDS {
        let of_said = (2..=BATCHES).map(|batch| said(&of(rows, kind, WAYS[0], batch)).to_string());
        let broken =
            WAYS.map(|way| (1..=BATCHES).map(|batch| broken(&of(rows, kind, way, batch))).sum::<usize>().to_string());
        let shared: Vec<f64> = of(rows, kind, WAYS[1], BATCHES).iter().filter_map(|row| row.shared).collect();
        table.push(vec![
            kind.words.to_owned(),
            of(rows, kind, WAYS[0], BATCHES).len().to_string(),
            of_said.collect::<Vec<_>>().join(", "),
            broken.join(", "),
            WAYS.map(|way| median_bound(&of(rows, kind, way, BATCHES))).join(", "),
            number(page::quantile(&shared, 0.5).context("no shared error")?, 1),
        ]);
    }
    text += &table.markdown();
    Ok(text)
}

fn picture(rows: &[Row]) -> String {
    let panel = |way: &Way| {
        let curve = |kind: &Kind| {
            (kind.words, (1..=BATCHES).map(|batch| typical(&of(rows, *kind, *way, batch))).collect::<Vec<f64>>())
        };
        (format!("missing, {}", way.words.replace('`', "")), KINDS.iter().map(curve).collect())
    };
    Regrets { title: "Regret, by how the rig drifts", panels: WAYS.iter().map(panel).collect(), is_one_scale: true }
        .picture()
}
