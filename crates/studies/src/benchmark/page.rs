//! The page of the benchmark: what was found, one picture, the tables.

use std::path::Path;

use anyhow::{Context as _, Result, ensure};
use page::{Axis, Column, LineFigure, Panel, Series, Table, line_figure, quantile};

use super::families::{FAMILIES, Family};
use super::methods::METHODS;
use super::results::Results;
use super::summary::{certificate, paired, regret, stops, typical};
use super::task::{BATCHES, SEEDS};

const PAGE: &str = "docs/results-benchmark.md";
const PICTURE: &str = "docs/results-benchmark.svg";
/// What another batch is worth in the table of stops, of the range of the truth.
const WORTH: f64 = 0.02;
/// Families on which priors, pool and allowance of the pooled loop were chosen, seeds 1 to 30; the others were not looked at.
const TUNED_ON: [&str; 6] = ["bowl-2", "stall-2", "wells-2", "cliff-2", "bowl-noisy", "rough-useless"];

pub(super) fn write(root: &Path, kept: &[Results]) -> Result<()> {
    for (path, text) in [(PAGE, markdown(kept)?), (PICTURE, picture(kept))] {
        std::fs::write(root.join(path), text).with_context(|| path.to_owned())?;
    }
    eprintln!("{PAGE}, {PICTURE}");
    Ok(())
}

pub(super) fn check(root: &Path, kept: &[Results]) -> Result<()> {
    for (path, text) in [(PAGE, markdown(kept)?), (PICTURE, picture(kept))] {
        let committed = std::fs::read_to_string(root.join(path)).with_context(|| path.to_owned())?;
        ensure!(committed == text, "{path} does not follow from the kept campaigns: run `cargo xtask benchmark`");
    }
    Ok(())
}

/// The methods that have rows, as they are called.
fn present(kept: &[Results]) -> Vec<(&Results, String)> {
    let words =
        |name: &str| METHODS.iter().find(|method| method.name == name).map_or(name, |method| method.words).to_owned();
    kept.iter().filter(|results| !results.rows.is_empty()).map(|results| (results, words(&results.method))).collect()
}

/// Families of few and of more factors; those of six are too few for a curve.
fn groups() -> [(&'static str, Vec<&'static Family>); 2] {
    let of = |sizes: &[usize]| FAMILIES.iter().filter(|family| sizes.contains(&family.n_factors)).collect();
    [("2 and 3 parameters", of(&[2, 3])), ("4 parameters", of(&[4]))]
}

fn picture(kept: &[Results]) -> String {
    let batches: Vec<f64> = (1..=BATCHES).map(|batch| batch as f64).collect();
    let panel = |(name, families): (&str, Vec<&Family>)| {
        let curve = |results: &Results| {
            (1..=BATCHES).map(|batch| typical(results, &families, batch)).collect::<Option<Vec<f64>>>()
        };
        let curves: Vec<(String, Vec<f64>)> = present(kept)
            .into_iter()
            .filter_map(|(results, words)| curve(results).map(|curve| (words, curve)))
            .collect();
        let all = curves.iter().flat_map(|(_, curve)| curve.iter().copied());
        let y_axis = Axis::new(&format!("regret, {name}"), "of the range").in_decades(all.collect::<Vec<_>>());
        let series = curves.iter().map(|(words, curve)| Series::line(words, &batches, curve)).collect();
        Panel { x_axis: Some(Axis::new("batches of experiments", "1").counting_to(BATCHES)), y_axis, series }
    };
    line_figure(&LineFigure {
        title: "What the recommended design is worse than the best".to_owned(),
        x_axis: Axis::new("batches of experiments", "1").counting_to(BATCHES),
        panels: groups().into_iter().map(panel).collect(),
        shaded: None,
    })
}

/// In percent of the range, two digits.
fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    if percent >= 9.95 { format!("{percent:.0}") } else { format!("{percent:.1}") }
}

fn markdown(kept: &[Results]) -> Result<String> {
    let methods = present(kept);
    let ours = &kept[0];
    ensure!(!ours.rows.is_empty(), "no campaign of the pooled loop is kept: run `cargo xtask benchmark`");
    let mut text = String::from("# The benchmark: regret, promises and time on pairs of a simulation and a truth\n\n");
    text += "Written by `cargo xtask benchmark` from the campaigns kept in `fixtures/benchmark` and `fixtures/peers/results`; \
             delete rows there and they are run anew.\n\n";
    for sentence in findings(&methods, ours) {
        text += &format!("- {sentence}\n");
    }
    text += "\n![Regret after each batch](results-benchmark.svg)\n\n";
    text += &format!(
        "Each family is a pair of a truth and a simulation that is wrong about it; each of {SEEDS} seeds draws its own shift, \
         mirror image and displacement. The truth is scaled to the range 0 to 1, every factor has 24 levels, a reading has \
         noise of 3 % of the range (10 % in `bowl-noisy`), and a batch has 12, 14, 18, 24 experiments for 2, 3, 4, 6 factors. \
         Regret is the truth at the recommended design less the lowest on the grid. Tuned on: {}. All other families were not \
         looked at while the loop was made.\n\n",
        TUNED_ON.join(", ")
    );
    for batch in [3, BATCHES] {
        text += &format!("## Regret after batch {batch}\n\nMedian and 90th percentile, in % of the range.\n\n");
        text += &regret_table(&methods, batch).markdown();
        text.push('\n');
    }
    text += "## Paired with the others\n\nMean over the seeds of log10(our regret / theirs) with its standard error, after batch \
             2, 3, 5: negative where the pooled loop is better; -0.3 is half the regret. 0.3 % of the range is added to both, so \
             that differences far below the noise do not count.\n\n";
    text += &paired_table(&methods, ours).markdown();
    text += "\n## The certificate\n\nPromised with 90 % probability: no design is better by more than c. How often one was, and \
             the median of c in % of the range, after each batch.\n\n";
    text += &certificate_table(ours).markdown();
    text += &format!(
        "\n## Stopping\n\nHad another batch to be worth {} % of the range: campaigns that stopped within {BATCHES} \
             batches, those of them that stopped with more than that missing, those that could have stopped a batch or more \
             earlier, and the mean number of batches.\n\n",
        100.0 * WORTH
    );
    text += &stops_table(ours).markdown();
    text += "\n## Seconds\n\nMedian time to choose a batch and to take its results, on the machine where the rows were made.\n\n";
    text += &seconds_table(&methods).markdown();
    Ok(text)
}

/// What a reader should know first.
fn findings(methods: &[(&Results, String)], ours: &Results) -> Vec<String> {
    let mut findings = Vec::new();
    for (results, words) in methods.iter().skip(1) {
        let compared: Vec<[f64; 2]> =
            FAMILIES.iter().filter_map(|family| paired(ours, results, family, BATCHES, BATCHES)).collect();
        let better = compared.iter().filter(|[mean, error]| *mean < -error).count();
        let worse = compared.iter().filter(|[mean, error]| *mean > *error).count();
        let mean = compared.iter().map(|[mean, _]| mean).sum::<f64>() / compared.len().max(1) as f64;
        findings.push(format!(
            "After {BATCHES} batches the pooled loop is better than {words} in {better} of {} families by more than a standard \
             error, and worse in {worse}; its regret is {:.2} times theirs in the mean.",
            compared.len(),
            10.0_f64.powf(mean)
        ));
    }
    let all: Vec<(&Family, usize, [f64; 2])> = FAMILIES
        .iter()
        .flat_map(|family| (1..=BATCHES).map(move |batch| (family, batch)))
        .filter_map(|(family, batch)| certificate(ours, family, batch).map(|found| (family, batch, found)))
        .collect();
    let mean = all.iter().map(|(_, _, [breached, _])| breached).sum::<f64>() / all.len().max(1) as f64;
    if let Some((family, batch, [most, _])) = all.iter().max_by(|a, b| a.2[0].total_cmp(&b.2[0])) {
        findings.push(format!(
            "The certificate of 90 % was breached in {:.1} % of all batches, most often ({:.0} %) in batch {batch} of {}.",
            100.0 * mean,
            100.0 * most,
            family.name
        ));
    }
    findings
}

fn regret_table(methods: &[(&Results, String)], batch: usize) -> Table {
    let mut columns = vec![Column::words("family")];
    columns.extend(methods.iter().map(|(_, words)| Column::words(words)));
    let mut table = Table::new(columns);
    for family in &FAMILIES {
        let cell = |results: &Results| match regret(results, family, batch) {
            Some([median, most]) => format!("{} / {}", percent(median), percent(most)),
            None => "–".to_owned(),
        };
        let mut row = vec![family.name.to_owned()];
        row.extend(methods.iter().map(|(results, _)| cell(results)));
        table.push(row);
    }
    table
}

fn paired_table(methods: &[(&Results, String)], ours: &Results) -> Table {
    let mut columns = vec![Column::words("family")];
    columns.extend(methods.iter().skip(1).map(|(_, words)| Column::words(words)));
    let mut table = Table::new(columns);
    for family in &FAMILIES {
        let mut row = vec![family.name.to_owned()];
        for (results, _) in methods.iter().skip(1) {
            let one = |batch| {
                paired(ours, results, family, batch, batch).map(|[mean, error]| format!("{mean:.2} ± {error:.2}"))
            };
            let cells: Option<Vec<String>> = [2, 3, BATCHES].into_iter().map(one).collect();
            row.push(cells.map_or("–".to_owned(), |cells| cells.join(", ")));
        }
        table.push(row);
    }
    table
}

fn certificate_table(ours: &Results) -> Table {
    let mut columns = vec![Column::words("family")];
    columns.extend((1..=BATCHES).map(|batch| Column::words(&format!("batch {batch}"))));
    let mut table = Table::new(columns);
    for family in &FAMILIES {
        let mut row = vec![family.name.to_owned()];
        row.extend((1..=BATCHES).map(|batch| match certificate(ours, family, batch) {
            Some([breached, width]) => format!("{:.0} %, c {}", 100.0 * breached, percent(width)),
            None => "–".to_owned(),
        }));
        table.push(row);
    }
    table
}

fn stops_table(ours: &Results) -> Table {
    let names = ["family", "stopped", "too early", "late", "batches"];
    let mut table = Table::new(names.iter().map(|name| Column::words(name)).collect());
    for family in &FAMILIES {
        let stops = stops(ours, family, WORTH);
        let batches = if stops.stopped == 0 { "–".to_owned() } else { format!("{:.1}", stops.batches) };
        let counts = [stops.stopped, stops.too_early, stops.late].map(|count| count.to_string());
        let [stopped, too_early, late] = counts;
        table.push(vec![family.name.to_owned(), stopped, too_early, late, batches]);
    }
    table
}

fn seconds_table(methods: &[(&Results, String)]) -> Table {
    let mut table = Table::new(["method", "2 factors", "4 factors", "6 factors"].map(Column::words).to_vec());
    for (results, words) in methods {
        let cell = |n_factors: usize| {
            let of_size =
                |name: &str| FAMILIES.iter().any(|family| family.name == name && family.n_factors == n_factors);
            let rows: Vec<[f64; 2]> = results
                .rows
                .iter()
                .filter(|row| of_size(&row.family))
                .map(|row| [row.ask_seconds, row.tell_seconds])
                .collect();
            let median = |which: usize| quantile(&rows.iter().map(|seconds| seconds[which]).collect::<Vec<_>>(), 0.5);
            match (median(0), median(1)) {
                (Some(ask), Some(tell)) if ask + tell > 0.0 => format!("{ask:.2} and {tell:.2}"),
                _ => "–".to_owned(),
            }
        };
        table.push(vec![words.clone(), cell(2), cell(4), cell(6)]);
    }
    table
}
