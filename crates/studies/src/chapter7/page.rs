//! What a person reads of Chapter 7.

use std::path::Path;

use anyhow::Result;

use super::both_loops;
use super::campaigns::Runs;
use super::claims::last_row_words;
use super::file::Case;
use super::findings::{Findings, Found};
use super::tables::{self, Rows};
use super::wrong::Choice;
use crate::claims::{self, Claim, FOUND};
use crate::first_screen::FirstScreen;
use crate::handover::Excerpt;
use crate::provenance::provenance_table;
use crate::reproduction::{Picture, markdown_list, picture};
use page::{Finding, Page, Summary};

/// The picture that the pages begin with.
const FIRST: &str = "true-costs";

const NO_EXPERIMENT: &str = "No experiment was made. The water channel of the dissertation is replaced by a stand-in: the numerical model \
    plus stall plus added mass, its costs read with noise of bounded size. One physical parameter set (rig.toml) and one test serve \
    Chapters 4, 6 and 7; between Chapter 4 and this one only the weights of the cost differ (cost-chapter7.toml, those of Chapter 6).";

const CALIBRATED: &str = "Plant and weights were fitted so that the numerical optimum is row 0 of Table 5 and the best design of the \
    stand-in is its last row, (49.53 % chord, 7.51 deg). So row 0 of Table 5 is calibrated, and of its last row the place where the \
    loop should end; whether the loop gets there, every row between, all shares, and all of Table 6 are predicted. Neither gain nor noise, \
    weights of the cost, runs for two parameters nor seeds are printed: they are ours, and nothing in the loop was tuned to a row.";

const TABLE_CAPTION: &str = "ours beside it. Iteration 0: the optimum of the numerical model itself, and of the first \
    surface fitted to its simulations. Then each optimum of the combined surface: without noise; with the seed of noise whose last design \
    has the median regret (the same seed in every iteration); and, where they are shown, the medians and extremes over the seeds, taken \
    column by column, which are no designs. CM_CB = x_cb − x_cm, negative where the center of mass is aft of the center of buoyancy; the share is what the z-test leaves. True cost: in the stand-in, \
    without noise. Regret: that less the cost of the best design known.";

const CHOICE_CAPTION: &str = "Regret: true cost of the last design less that of the best cell of the grid. Better than the loop: \
    seeds for which it ends lower than the loop as it is with the same noise. Best dropped: campaigns whose z-test dropped the truly best \
    cell.";

const WEIGHT_CAPTION: &str = "The weights of the cost, calibrated; (21) has a term of its own for the center \
    of mass, (60) has none. All else of plant, controller and test is the same in both chapters.";

const FLIGHT_CAPTION: &str = "Flights in the stand-in, means over the test. Before: the numerical optimum. After: the last optimum of the \
    loop without noise, and its spread over the seeds of noise.";

const FIELD_CAPTION: &str = "What is known of the costs without any loop: the grids that are flown in whole, and the best design known \
    of each physics. Noise is a part of the range of the stand-in.";

const CLAIM_CAPTION: &str = "Claim by claim, with the regressor (61). A claim holds if it does without noise and for nine in ten seeds, in \
    part if it does in any of these campaigns.";

fn loop_words(findings: &Findings, case: &Case, found: &Found) -> String {
    let (file, entry) = (&findings.setup.file, &case.entry);
    let first = found.main().quiet_campaign.reports().first();
    let threshold = first.map_or("–".to_owned(), |report| format!("{:.4}", report.screening.threshold));
    let gain = file.rule.gain.as_constant().map_or("k = 1/n".to_owned(), |k| format!("k = {k}"));
    format!(
        "{}: {} levels an axis ({} cells), {} experiments and {} simulations an iteration with weights {} and {} in the combined surface, \
         {} iterations, z-test at {} % (z_0 = {threshold}), {gain}, noise within ±{} % of the range of the true cost (±{:.3} s).",
        entry.label,
        entry.levels,
        case.space.n_cells(),
        entry.batch.experiments,
        entry.batch.simulations,
        entry.batch.experiment_weight,
        entry.batch.simulation_weight,
        entry.iterations,
        100.0 * file.rule.confidence,
        100.0 * file.noise.share,
        findings.noise_s(found)
    )
}

fn best_words(case: &Case, found: &Found) -> String {
    let how = if case.is_flown_whole() {
        "lowest of all cells, each flown"
    } else {
        "found by optimizing the stand-in itself, which no engineer could"
    };
    let regret = found.main().quiet.last().map_or(f64::NAN, |step| step.cost - found.best.cost);
    format!(
        "The best design of the stand-in ({how}) is {} at {:.3} s; the numerical optimum costs {:.3} s there, and the loop without noise \
         ends {regret:.3} s above the best.",
        case.space.words(&found.best.point),
        found.best.cost,
        found.numerical_true_cost
    )
}

/// Why the space shrinks as it does.
fn spread_words(found: &Found) -> String {
    let of = |runs: &Runs| {
        let reports = runs.quiet_campaign.reports().iter();
        let spreads: Vec<String> = reports
            .map(|report| report.screening.spread.s().map_or("–".to_owned(), |spread| format!("{spread:.3}")))
            .collect();
        format!("{} s with the {}", spreads.join(", "), runs.label)
    };
    let first = found.main().quiet_campaign.reports().first();
    let factor = first.map_or(f64::NAN, |report| std::f64::consts::SQRT_2 * report.screening.threshold);
    format!(
        "S of (40), how far the surface is from validation experiments, iteration by iteration without noise: {}. The z-test drops a cell \
         only where the surface is {factor:.2} S above its optimum, so a regressor that does not follow the stand-in keeps the space large; the \
         range of the true cost is {:.2} s.",
        found.runs.iter().map(of).collect::<Vec<_>>().join("; "),
        found.truth.range()
    )
}

fn choice_words(case: &Case) -> String {
    let grid =
        if case.is_flown_whole() { "the grid of the loop" } else { "a coarser grid, so that the best cell is known" };
    format!("{}, {} levels an axis ({grid}).", case.entry.label, case.entry.flown_levels)
}

/// The choices beside the loop as it is, in sentences: medians, worst cases, and seed by seed.
fn ranking(found: &Found) -> String {
    let Some((own, others)) = found.choices.split_first() else { return String::new() };
    let n = own.regrets.len();
    let named = |worse: bool| {
        let words = |choice: &Choice| {
            let (median, worst, beats) = (choice.median(), choice.worst(), choice.beats(own));
            format!("{} ({median:.3} s, worst {worst:.3} s, {beats} of {n})", choice.label)
        };
        let names: Vec<String> =
            others.iter().filter(|choice| (choice.median() > own.median()) == worse).map(words).collect();
        if names.is_empty() { "none".to_owned() } else { names.join(", ") }
    };
    let lower = others.iter().filter(|choice| choice.median() < own.median()).count();
    format!(
        "The loop as it is ends {:.3} s above the best cell in the median and {:.3} s at worst; {lower} of {} other choices have a lower \
         median. Each beside it: regret in the median and at worst, and for how many seeds it ends lower than the loop with the same noise. \
         Worse in the median: {}. \
         As good or better: {}.",
        own.median(),
        own.worst(),
        others.len(),
        named(true),
        named(false)
    )
}

fn designs_caption(case: &Case) -> String {
    format!("Table {} of the dissertation and {TABLE_CAPTION}", case.entry.table)
}

/// What is to be read under the table of designs.
fn design_words(case: &Case, found: &Found) -> Vec<String> {
    let mut words = vec![best_words(case, found)];
    words.extend(last_row_words(case, found));
    words
}

fn choice_caption(case: &Case) -> String {
    format!("{} {CHOICE_CAPTION}", choice_words(case))
}

/// What the page over all claims shows of this study.
pub(crate) fn excerpts(findings: &Findings) -> Vec<Excerpt> {
    let designs = findings.cases().map(|(case, found)| Excerpt {
        heading: format!("Table {}, {}", case.entry.table, case.entry.label),
        paragraphs: design_words(case, found),
        table: tables::designs(case, found, found.main(), Rows::Short),
        caption: designs_caption(case),
    });
    let choices = findings.cases().map(|(case, found)| Excerpt {
        heading: format!("What the wrong choices cost, {}", case.entry.label),
        paragraphs: vec![ranking(found)],
        table: tables::choices(found),
        caption: choice_caption(case),
    });
    designs.chain(choices).collect()
}

/// How far the true cost falls in one study.
fn fall(case: &Case, found: &Found) -> Finding {
    let runs = found.main();
    let before = found.numerical_true_cost;
    let after = runs.quiet.0.last().map_or(f64::NAN, |step| step.cost);
    let median = Summary::of(&runs.over_seeds(case.entry.iterations, |step| step.cost)).map_or(f64::NAN, |s| s.median);
    let (best, n) = (found.best.cost, runs.noisy.len());
    let share = |cost: f64| 100.0 * (1.0 - cost / before);
    let fitted = if case.ends_are_fitted() { " Both ends were calibrated, the way between them was not." } else { "" };
    Finding::new(format!(
        "{}: the numerical optimum truly costs {before:.3} s, that of the loop {after:.3} s without noise ({:.1} % less) and {median:.3} s \
         in the median of {n} seeds of noise ({:.1} % less); the best design known costs {best:.3} s.{fitted}",
        case.entry.label,
        share(after),
        share(median)
    ))
    .with("true cost of the numerical optimum", before, "s")
    .with("true cost without noise", after, "s")
    .with("true cost in the median of the seeds", median, "s")
    .with("true cost of the best design known", best, "s")
}

/// The first iteration of a study where its design is worse than the one that the loop began with.
fn first_rise(case: &Case, found: &Found) -> Option<Finding> {
    let runs = found.main();
    let (before, first) = (found.numerical_true_cost, runs.quiet.0.first()?.cost);
    let median = Summary::of(&runs.over_seeds(1, |step| step.cost))?.median;
    let sentence = format!(
        "{}: on the way there the design of the first iteration truly costs {first:.3} s without noise and {median:.3} s in the median of \
         the seeds, {:.1} and {:.1} times as much as the numerical optimum.",
        case.entry.label,
        first / before,
        median / before
    );
    let finding = Finding::new(sentence).with("true cost after the first iteration without noise", first, "s").with(
        "true cost after the first iteration in the median of the seeds",
        median,
        "s",
    );
    (first > before).then_some(finding)
}

/// Whether it was the loop, in one study.
fn other_choices(case: &Case, found: &Found) -> Option<Finding> {
    let (own, others) = found.choices.split_first()?;
    let lower = others.iter().filter(|choice| choice.median() < own.median()).count();
    let sentence = format!(
        "{}, {} levels an axis: of {} other ways to choose a design {lower} end lower in the median than the loop, which ends {:.3} s above \
         the best cell.",
        case.entry.label,
        case.entry.flown_levels,
        others.len(),
        own.median()
    );
    Some(Finding::new(sentence).with("ways that end lower", lower as f64, "1").with("regret", own.median(), "s"))
}

/// What the pages begin with.
pub(crate) fn first_screen<'a>(findings: &Findings, pictures: &'a [Picture]) -> Result<FirstScreen<'a>> {
    let falls = findings.cases().flat_map(|(case, found)| [Some(fall(case, found)), first_rise(case, found)]);
    let choices = findings.cases().filter_map(|(case, found)| other_choices(case, found));
    let all = falls.flatten().chain(choices).chain([both_loops::finding(findings)]);
    Ok(FirstScreen { findings: all.collect(), picture: picture(pictures, FIRST)? })
}

/// The page of the study.
pub(crate) fn page(findings: &Findings, claims: &[Claim], pictures: &[Picture], first: &FirstScreen<'_>) -> Page {
    let mut page = Page::new("Chapter 7: experimentally infused optimization over two and over four parameters");
    first.show_in(&mut page);
    page.note(NO_EXPERIMENT);
    page.paragraph(
        "In every iteration a few experiments and more simulations are made where they say most, one surface is fitted to training \
         experiments and corrected simulations, its optimum is the design, and what is worse than it beyond doubt is dropped. The \
         dissertation did this with experiments in a water channel; its tables stand beside ours row by row.",
    );
    page.paragraph(CALIBRATED);
    page.list(&findings.cases().map(|(case, found)| loop_words(findings, case, found)).collect::<Vec<_>>());
    page.heading(claims::BY_VERDICT);
    claims::by_verdict(claims).iter().for_each(|finding| page.finding(finding));
    for (case, found) in findings.cases() {
        designs(&mut page, case, found, pictures);
    }
    page.heading("What the wrong choices cost");
    for (case, found) in findings.cases() {
        page.table(&tables::choices(found), &choice_caption(case));
        page.paragraph(&ranking(found));
    }
    page.heading("Before and after");
    page.table(&tables::flights(findings), FLIGHT_CAPTION);
    for name in ["figure-24", "figure-26", "figure-27", "figure-28"] {
        show(&mut page, pictures, name);
    }
    page.heading("The costs");
    page.table(&tables::weights(findings), WEIGHT_CAPTION);
    page.table(&tables::fields(findings), FIELD_CAPTION);
    page.heading("What the dissertation says, and what holds here");
    page.prose_table(&claims::table(claims), CLAIM_CAPTION, &claims::WIDTHS_PCT);
    page.paragraph(FOUND);
    claims::found(claims).iter().for_each(|finding| page.finding(finding));
    page.heading("Every number");
    if let Some(case) = findings.setup.cases.first() {
        page.table(
            &provenance_table(&case.bat.records),
            "Plant, controller, test and cost: value, unit and where each comes from.",
        );
    }
    page.heading(both_loops::HEADING);
    page.paragraph(both_loops::WHAT);
    show(&mut page, pictures, both_loops::PICTURE);
    for (case, found) in findings.cases() {
        page.table(&both_loops::table(case, found), &both_loops::caption(case, found));
        both_loops::words(case, found).iter().for_each(|words| page.paragraph(words));
    }
    page.paragraph(&format!("Made by `cargo xtask reproduce-chapter7` in {:.0} s.", findings.seconds));
    page
}

/// The designs of a study with every choice of the loop.
fn designs(page: &mut Page, case: &Case, found: &Found, pictures: &[Picture]) {
    page.heading(&format!("{}: Table {}", case.entry.label, case.entry.table));
    for (number, runs) in found.runs.iter().enumerate() {
        let which = if number == 0 { Rows::All } else { Rows::Ours };
        let caption = if number == 0 {
            designs_caption(case)
        } else {
            format!("Ours with the {}, {} seeds.", runs.label, runs.noisy.len())
        };
        page.table(&tables::designs(case, found, runs, which), &caption);
        if number == 0 {
            design_words(case, found).iter().for_each(|words| page.paragraph(words));
            page.paragraph(&spread_words(found));
        }
    }
    show(page, pictures, &format!("seeds-table-{}", case.entry.table));
    if case.space.variables.len() == 2 {
        show(page, pictures, "figure-23");
    }
}

/// The pictures whose names begin like this.
fn show(page: &mut Page, pictures: &[Picture], name: &str) {
    for picture in pictures.iter().filter(|picture| picture.name.starts_with(name)) {
        picture.show_in(page);
    }
}

/// The results as a page of `docs/`, without anything that differs from run to run.
pub(crate) fn markdown(findings: &Findings, claims: &[Claim], first: &str) -> String {
    let loops: Vec<String> = findings.cases().map(|(case, found)| loop_words(findings, case, found)).collect();
    let mut text = format!(
        "# Chapter 7: results\n\n{first}\n\
         Written by `cargo xtask reproduce-chapter7`; `cargo xtask ci` fails when this page is not what the command finds.\n\
         See [departures](departures.md) for what is built instead of what is printed.\n\n{}\n{NO_EXPERIMENT}\n\n{CALIBRATED}\n\n{}",
        claims::by_verdict_markdown(claims),
        markdown_list(&loops)
    );
    let mut section = |heading: &str, words: &str, table: &str| {
        text.push_str(&format!("\n## {heading}\n\n{words}\n\n{table}"));
    };
    for (case, found) in findings.cases() {
        let (label, number) = (&case.entry.label, case.entry.table);
        for (index, runs) in found.runs.iter().enumerate() {
            let which = if index == 0 { Rows::All } else { Rows::Ours };
            let words = if index == 0 {
                format!(
                    "{}\n\n{}\n\n{}",
                    designs_caption(case),
                    design_words(case, found).join("\n\n"),
                    spread_words(found)
                )
            } else {
                format!("Ours only, {} seeds.", runs.noisy.len())
            };
            let table = tables::designs(case, found, runs, which).markdown();
            section(&format!("{label}: Table {number}, {}", runs.label), &words, &table);
        }
    }
    for (case, found) in findings.cases() {
        let words = format!("{}\n\n{}", choice_caption(case), ranking(found));
        section(
            &format!("What the wrong choices cost, {}", case.entry.label),
            &words,
            &tables::choices(found).markdown(),
        );
    }
    section("Before and after", FLIGHT_CAPTION, &tables::flights(findings).markdown());
    section("The weights of the cost", WEIGHT_CAPTION, &tables::weights(findings).markdown());
    section("The costs", FIELD_CAPTION, &tables::fields(findings).markdown());
    section(
        "What the dissertation says, and what holds here",
        CLAIM_CAPTION,
        &format!("{}\n{FOUND}\n\n{}", claims::table(claims).markdown(), claims::markdown(&claims::found(claims))),
    );
    for (number, (case, found)) in findings.cases().enumerate() {
        let what = (number == 0).then(|| both_loops::WHAT.to_owned());
        let words = what.into_iter().chain([both_loops::caption(case, found)]);
        let words: Vec<String> = words.chain(both_loops::words(case, found)).collect();
        let heading = format!("{}: {}", both_loops::HEADING, case.entry.label);
        section(&heading, &words.join("\n\n"), &both_loops::table(case, found).markdown());
    }
    text
}

/// The closing summary.
#[expect(clippy::print_stdout, reason = "the result of the command")]
pub(crate) fn print(findings: &Findings, claims: &[Claim], out: &Path) {
    println!("\nChapter 7: Tables 5 and 6 in a stand-in for the water channel\n");
    for claim in claims {
        println!("- {}: {}: {}.\n    {}", claim.place, claim.words(), claim.verdict, claim.found);
    }
    for (case, found) in findings.cases() {
        println!("\n{}: {}\n{}", case.entry.label, design_words(case, found).join("\n"), ranking(found));
    }
    println!("\nPage, figures and data: {} (open index.html), after {:.0} s.", out.display(), findings.seconds);
}
