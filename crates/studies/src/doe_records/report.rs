//! What a person reads of the record.

use std::path::Path;

use super::findings::{
    Findings, GOAL, GRID, GRID_STARTS, LARGE_STARTS, LIST_RUNS, LIST_STARTS, MOST_STARTS, Row, Verified,
};
use anyhow::Result;

use crate::first_screen::FirstScreen;
use crate::reproduction::{Picture, picture};
use page::{Column, Finding, Page, Table};

const DEFINITION: &str = "G-efficiency is p / (N max v), where p is the number of terms, N the number of runs and v the prediction \
    variance for unit variance of a run; the maximum is over the whole cube. For continuous weights 100 % is always reached; for N \
    runs it mostly cannot be.";

const RECORD_CAPTION: &str = "Kept designs, verified in this run, beside the best published ones and those of an earlier search of \
    ours; full quadratic model. The maximum is over the cube, but in the column of five levels, which is how the published figures are \
    printed. Lattice: the largest prediction variance on a dense lattice over the maximum that the efficiency is \
    made of, which it must not exceed.";

/// Every kept design beside the record.
pub(crate) fn record_table(verified: &Verified) -> Table {
    let mut table = Table::new(vec![
        Column::new("K", "1"),
        Column::new("N", "1"),
        Column::new("published, five levels", "%"),
        Column::new("published, cube", "%"),
        Column::new("earlier, cube", "%"),
        Column::new("kept here, cube", "%"),
        Column::new("gain", "points"),
        Column::new("lattice", "1"),
    ]);
    for row in &verified.rows {
        let published = verified.record.published.get(&row.size);
        let percent = row.kept.efficiency.percent;
        let optional =
            |value: Option<f64>, decimals: usize| value.map_or("–".to_owned(), |v| format!("{v:.decimals$}"));
        table.push(vec![
            row.size.0.to_string(),
            row.size.1.to_string(),
            optional(published.map(|case| case.lattice), 3),
            optional(published.map(|case| case.cube), 3),
            optional(published.and_then(|case| case.earlier), 3),
            format!("{percent:.3}"),
            published.map_or("–".to_owned(), |case| gain(percent - case.cube)),
            format!("{:.6}", row.lattice_share),
        ]);
    }
    table
}

/// A gain to the digits that are published; a gain of nothing has no sign.
fn gain(points: f64) -> String {
    if points.abs() < 5e-4 { "0.000".to_owned() } else { format!("{points:+.3}") }
}

/// The searches of this run.
pub(crate) fn search_table(findings: &Findings) -> Table {
    let mut table = Table::new(vec![
        Column::new("K", "1"),
        Column::new("N", "1"),
        Column::new("found", "%"),
        Column::new("of the kept", "%"),
        Column::new("starts", "1"),
        Column::new("time", "s"),
        Column::new("per start", "ms"),
    ]);
    let mut push = |size: super::Size, found: &doe::Found, kept: Option<f64>| {
        let seconds = found.report.elapsed.as_secs_f64();
        table.push(vec![
            size.0.to_string(),
            size.1.to_string(),
            format!("{:.3}", found.efficiency.percent),
            kept.map_or("–".to_owned(), |kept| format!("{:.2}", 100.0 * found.efficiency.percent / kept)),
            found.report.starts.to_string(),
            format!("{seconds:.3}"),
            format!("{:.2}", 1000.0 * seconds / found.report.starts.max(1) as f64),
        ]);
    };
    for (row, again) in findings.verified.rows.iter().zip(&findings.again) {
        push(row.size, again, Some(row.kept.efficiency.percent));
    }
    for (size, found) in &findings.large {
        push(*size, found, None);
    }
    table
}

/// The case study's grid.
pub(crate) fn grid_table(findings: &Findings) -> Table {
    let mut table = Table::new(vec![
        Column::new("model", ""),
        Column::new("N", "1"),
        Column::new("G-efficiency over the grid", "%"),
        Column::new("starts", "1"),
        Column::new("time", "s"),
    ]);
    for row in &findings.grid {
        table.push(vec![
            row.model.to_owned(),
            row.runs.to_string(),
            format!("{:.2}", row.found.efficiency.percent),
            row.found.report.starts.to_string(),
            format!("{:.1}", row.found.report.elapsed.as_secs_f64()),
        ]);
    }
    table
}

/// The kept designs beside the record.
fn compared(verified: &Verified) -> Vec<Finding> {
    let compared: Vec<(f64, super::Size)> = verified
        .rows
        .iter()
        .filter_map(|row| {
            Some((row.kept.efficiency.percent - verified.record.published.get(&row.size)?.cube, row.size))
        })
        .collect();
    let missing: Vec<String> = verified
        .record
        .published
        .keys()
        .filter(|size| !verified.record.kept.contains_key(size))
        .map(|(k, n)| format!("K = {k}, N = {n}"))
        .collect();
    // Published figures have three decimals.
    let (above, level): (Vec<_>, Vec<_>) = compared.iter().partition(|(gain, _)| *gain > 5e-4);
    let below = level.iter().filter(|(gain, _)| *gain < -5e-4).count();
    let n_level = level.len() - below;
    let mut found = vec![
        Finding::new(format!(
            "Of {} published sizes the kept designs are better in {}, level in {n_level} and worse in {below}.",
            compared.len(),
            above.len()
        ))
        .with("better", above.len() as f64, "1")
        .with("level", n_level as f64, "1")
        .with("worse", below as f64, "1"),
    ];
    for factors in 2..=5 {
        let gains: Vec<f64> = compared.iter().filter(|(_, size)| size.0 == factors).map(|(gain, _)| *gain).collect();
        if let (Some(least), Some(most)) =
            (gains.iter().copied().reduce(f64::min), gains.iter().copied().reduce(f64::max))
        {
            let sentence =
                format!("K = {factors}: {} to {} points over the published designs.", gain(least), gain(most));
            found.push(Finding::new(sentence).with("least gain", least, "points").with("most gain", most, "points"));
        }
    }
    if !missing.is_empty() {
        found.push(Finding::new(format!("Published, and without a kept design: {}.", missing.join("; "))));
    }
    found
}

/// What the pages begin with.
pub(crate) fn first_screen<'a>(verified: &Verified, pictures: &'a [Picture]) -> Result<FirstScreen<'a>> {
    Ok(FirstScreen { findings: compared(verified), picture: picture(pictures, "record")? })
}

/// How the time grows with the length of a list.
pub(crate) fn list_table(findings: &Findings) -> Table {
    let mut table = Table::new(vec![
        Column::new("candidates", "1"),
        Column::new("G-efficiency over the list", "%"),
        Column::new("per start", "ms"),
        Column::new("per start and candidate", "µs"),
    ]);
    for (candidates, found) in &findings.lists {
        let seconds = found.report.elapsed.as_secs_f64() / found.report.starts.max(1) as f64;
        table.push(vec![
            candidates.to_string(),
            format!("{:.2}", found.efficiency.percent),
            format!("{:.1}", 1e3 * seconds),
            format!("{:.3}", 1e6 * seconds / *candidates as f64),
        ]);
    }
    table
}

/// Why the time grows as it does, with the figures of this run.
fn about_the_growth(findings: &Findings) -> Vec<String> {
    let per_start = |found: &doe::Found| found.report.elapsed.as_secs_f64() / found.report.starts.max(1) as f64;
    let of = |size: super::Size| {
        let mut both = findings.verified.rows.iter().zip(&findings.again);
        both.find(|(row, _)| row.size == size).map(|(_, again)| 1e3 * per_start(again))
    };
    let mut sentences = Vec::new();
    if let (Some(two), Some(three), Some(four), Some(five)) = (of((2, 8)), of((3, 12)), of((4, 18)), of((5, 26))) {
        sentences.push(format!(
            "With K: {two:.1}, {three:.1}, {four:.0} and {five:.0} ms a start for N = 8, 12, 18 and 26. A step of the descent sums \
             products of the p = (K + 1)(K + 2)/2 terms over a lattice of 9², 5³ or 3^K points, and the polish solves for K N \
             coordinates against all maxima, so both grow faster than any power that two sizes suggest."
        ));
    }
    if let (Some(few), Some(many)) = (of((4, 18)), of((4, 36))) {
        sentences.push(format!("With N at K = 4: {few:.0} ms a start for 18 runs, {many:.0} ms for 36."));
    }
    if let [(least, first), .., (most, last)] = findings.lists.as_slice() {
        let exponent = (per_start(last) / per_start(first)).ln() / (*most as f64 / *least as f64).ln();
        sentences.push(format!(
            "With the length of a list: as its power {exponent:.2} between {least} and {most} candidates. Exchanges look at a few \
             hundred candidates only; the list as a whole is scanned once in a while for those that have become worst."
        ));
    }
    sentences
}

/// A kept design is beaten by more than this, relative: less is what the last steps of a search leave open.
const BEATEN: f64 = 5e-6;

/// What the searches of this run say of the kept designs and of their own goal.
fn about_the_searches(findings: &Findings) -> Vec<String> {
    let size = |row: &Row| format!("K = {}, N = {}", row.size.0, row.size.1);
    let shares: Vec<(&Row, f64)> = findings
        .verified
        .rows
        .iter()
        .zip(&findings.again)
        .map(|(row, again)| (row, again.efficiency.percent / row.kept.efficiency.percent))
        .collect();
    let named = |is_meant: fn(f64) -> bool| {
        let rows = shares.iter().filter(|(_, share)| is_meant(*share));
        let names: Vec<String> = rows.map(|(row, share)| format!("{} ({:.2} %)", size(row), 100.0 * share)).collect();
        if names.is_empty() { "none".to_owned() } else { names.join("; ") }
    };
    let missed = named(|share| share < GOAL);
    let beaten = named(|share| share > 1.0 + BEATEN);
    vec![
        format!("Searches that missed their goal of {:.0} % of the kept design: {missed}.", 100.0 * GOAL),
        format!("Kept designs that a search of this run has beaten, and that should be replaced: {beaten}."),
        "Starts are made 16 at a time, so a time is that of all 16.".to_owned(),
    ]
}

/// The page of the study.
pub(crate) fn page(findings: &Findings, pictures: &[Picture], first: &FirstScreen<'_>) -> Result<Page> {
    let mut page = Page::new("Optimal designs: the record");
    first.show_in(&mut page);
    page.paragraph(
        "Which N runs predict best? A G-optimal design makes the worst prediction in the design space as good as N runs allow. For \
         exact designs of a full quadratic model nobody knows the optimum beyond the smallest cases; there is a published record.",
    );
    page.paragraph(DEFINITION);
    page.table(&record_table(&findings.verified), RECORD_CAPTION);
    page.heading("Where the designs in two factors predict badly");
    picture(pictures, "surfaces")?.show_in(&mut page);
    page.heading("How fast");
    page.table(
        &search_table(findings),
        &format!(
            "Searches of this run, on all threads: to {:.0} % of the kept design or {MOST_STARTS} starts; the last {} rows, which show \
             how the time grows, with {LARGE_STARTS} starts and no goal.",
            100.0 * GOAL,
            findings.large.len()
        ),
    );
    page.list(&about_the_searches(findings));
    page.table(
        &list_table(findings),
        &format!("Full quadratic model, K = 4, N = {LIST_RUNS}, {LIST_STARTS} starts: lists of growing length."),
    );
    page.list(&about_the_growth(findings));
    page.heading("The grid of the case study");
    page.table(
        &grid_table(findings),
        &format!(
            "{} levels in each of {} factors, {} points, {GRID_STARTS} starts each; the maximum is over the points of the grid.",
            GRID[0],
            GRID.len(),
            GRID.iter().map(|levels| u64::from(*levels)).product::<u64>()
        ),
    );
    page.heading("How much of the space is predicted how well");
    picture(pictures, "fractions")?.show_in(&mut page);
    picture(pictures, "fractions-grid")?.show_in(&mut page);
    page.paragraph(&format!("Made by `cargo xtask doe-records` in {:.0} s.", findings.seconds));
    Ok(page)
}

/// The results as a page of `docs/`: what was verified, without what a search finds on a machine and in which time.
pub(crate) fn markdown(verified: &Verified, first: &str) -> String {
    format!(
        "# Optimal designs: the record\n\n{first}\n\
         Written by `cargo xtask doe-records`; `cargo xtask ci` fails when this page is not what the command finds.\n\
         {DEFINITION}\n\n## Every kept design\n\n{RECORD_CAPTION}\n\n{}\n\
         The command also searches for designs of the same sizes anew, and for designs on the grid of the case study (24 levels in each of \
         four factors), and shows efficiencies and times on its page.\n",
        record_table(verified).markdown(),
    )
}

/// The closing summary.
#[expect(clippy::print_stdout, reason = "the result of the command")]
pub(crate) fn print(findings: &Findings, out: &Path) {
    println!("\nOptimal designs: the record (G-efficiency over the cube, full quadratic model)\n");
    println!("{}\n", record_table(&findings.verified).text());
    println!("{}\n", search_table(findings).text());
    println!("{}\n", grid_table(findings).text());
    println!("{}\n", list_table(findings).text());
    let compared = compared(&findings.verified);
    let compared = compared.iter().map(|finding| finding.sentence().to_owned());
    for sentence in compared.chain(about_the_searches(findings)).chain(about_the_growth(findings)) {
        println!("- {sentence}");
    }
    println!("\nPage, figures and data: {} (open index.html), after {:.0} s.", out.display(), findings.seconds);
}
