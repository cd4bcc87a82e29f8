//! What a person reads of Chapter 6.

use std::path::Path;

use anyhow::{Context as _, Result};

use super::campaigns::Ended;
use super::claims::lawful;
use super::findings::Findings;
use super::tables;
use crate::claims::{self, Claim, Place, Truth};
use crate::first_screen::FirstScreen;
use crate::gridded::SUP;
use crate::provenance::provenance_table;
use crate::reproduction::{Extent, Picture};
use page::{Column, Finding, Page, Table};

const NO_EXPERIMENT: &str = "No experiment was made. As in Section 6.2 a richer model takes the place of experiments and its costs are \
    read with noise of bounded size: stall alone, as printed, and beside it our stand-in for the water channel, stall and added mass. \
    The plant and the weights of the cost (60) were calibrated to Tables 3 and 5 before this loop was run; nothing was fitted to this \
    chapter.";

const OURS: &str = "The dissertation gives neither gain, noise, grid, runs for two parameters nor seed of this study: those are ours, \
    chosen beforehand. Norms are those of (42) over the cells left at the onset of an iteration, in coordinates coded to −1..1 over the \
    original box; the true costs of model and richer models are flown at every cell, so that every error is measured and not estimated.";

const DECIDED: &str = "What decides each claim";

const CLAIM_CAPTION: &str = "By place and verdict, without (36) to the letter, which is there to fail. Nothing of this chapter prints a number \
    to compare with, so what is shown by its figures is reproduced in kind at most.";

const CAMPAIGN_CAPTION: &str = "Every campaign with the gain of the figures. Noise: of the range of the truth. It ended after all \
    iterations, or where it says so because one cell was left. Error: norm (42) with q = 2 of the corrected model less the truth, over what is left, at the \
    first and the last iteration; the largest part that it ever is of its finite-iteration bound, in any norm; the iteration from which on \
    it stays below 2 E1 + E2 of the same iteration. Best dropped at: the iteration whose z-test dropped the truly best cell. Regret left: \
    true cost of the last optimum less the lowest of the cells that were left at the onset of the last iteration; certified: the bound on \
    that, from the corrected model and the finite bound, for which one must know the truth. Regret overall: less the lowest of the whole \
    space, of which a certificate says nothing once the best cell is dropped.";

const VARIANT_CAPTION: &str = "The same for the other gains, and for three campaigns beside the printed ones: the law that corrects \
    against the current simulation, (36) to the letter, and the full quadratic regressor.";

const NORM_CAPTION: &str = "Some iterations of the campaign in the figures, in two norms (iterations.csv has all, and q = 1): the \
    error of the corrected model, the finite-iteration bound, and the right-hand side of (55) with the errors of the iteration; the \
    optimum, its true cost, its regret over what was left and what is certified of it.";

const HOW_MANY_CAPTION: &str = "The third question of the dissertation, how many iterations, answered by the finite-iteration bound in the \
    sup norm, if the errors of the first iteration stayed as they are: iterations until the bound is within a tenth of the gap of its limit; a dash where the limit lies above the gap, so that it promises less \
    than no correction would. The harmonic gain forgets the gap at once; the law that corrects \
    against the current simulation has the lower limit.";

const FLIGHT_CAPTION: &str =
    "How the optima of the first and of the last iteration fly in the truth, noise as in the figures.";

const FIELD_CAPTION: &str = "The costs at every cell. The noise of an experiment is a part of the range of its truth. For two parameters \
    the best designs of the numerical model and of the stand-in were calibrated to rows 0 and 3 of Table 5; the others were not.";

/// The picture that the page begins with: with all levels that of the space that has more of them.
fn first_picture(extent: Extent) -> &'static str {
    match extent {
        Extent::Default | Extent::WithKept | Extent::Anew => "figure-21-2-parameters-stand-in",
        Extent::Full => "figure-21-4-parameters-stand-in",
    }
}

/// Campaigns of the first variant.
fn main_table(findings: &Findings) -> Table {
    tables::campaigns_of(findings, findings.ended.iter().filter(|ended| ended.case.variant == 0)).without("Correction")
}

fn other_table(findings: &Findings) -> Table {
    tables::campaigns_of(findings, findings.ended.iter().filter(|ended| ended.case.variant != 0))
}

/// The campaign that is followed iteration by iteration: the stand-in in the space of the first picture.
fn followed(findings: &Findings) -> Result<&Ended> {
    let space = if findings.extent == Extent::Full { findings.setup.spaces.len() - 1 } else { 0 };
    findings.shown(space, findings.setup.n_truths() - 1)
}

fn extent_words(findings: &Findings) -> String {
    let cells: Vec<String> = findings
        .setup
        .spaces
        .iter()
        .map(|space| format!("{} cells for {}", space.space.n_cells(), space.entry.label))
        .collect();
    let rest = match findings.extent {
        Extent::Default | Extent::WithKept | Extent::Anew => "; `--full` takes 24 levels for each of the four",
        Extent::Full => "",
    };
    format!("Grid: {}{rest}.", cells.join(", "))
}

fn loop_words(findings: &Findings) -> String {
    let file = &findings.setup.file;
    let runs: Vec<String> = findings
        .setup
        .spaces
        .iter()
        .map(|space| {
            let (entry, batch) = (&space.entry, &space.entry.batch);
            format!(
                "{}: {} experiments and {} simulations an iteration with weights {} and {}",
                entry.label, batch.experiments, batch.simulations, batch.experiment_weight, batch.simulation_weight
            )
        })
        .collect();
    format!(
        "{} iterations; regressor: {}; z-test at {} %; {}.",
        file.iterations.iterations,
        file.iterations.model.words(),
        100.0 * file.iterations.confidence,
        runs.join("; ")
    )
}

/// How close the campaign that is followed comes to the truth.
fn example(findings: &Findings) -> Result<Finding> {
    let ended = followed(findings)?;
    let last = ended.accuracy.last().context("an iteration")?;
    let [error, bound, gap] = {
        let norm = &last.norms[SUP];
        [norm.error, norm.finite_bound, norm.gap]
    };
    Ok(Finding::new(format!(
        "For example ({}): after {} iterations {:.1} % of the space is left; the corrected model is within {} s of the truth there, its \
         bound is {} s, without correction it would be {} s.",
        findings.setup.words(ended.case),
        last.iteration,
        100.0 * last.share_after,
        tables::digits(error),
        tables::digits(bound),
        tables::digits(gap)
    ))
    .with("share left", last.share_after, "1")
    .with("error", error, "s")
    .with("bound", bound, "s")
    .with("error without correction", gap, "s"))
}

/// In how many campaigns the proposition comes out, with either truth.
fn within(claims: &[Claim]) -> Result<Finding> {
    let of = |truth: Truth| {
        let mut mine = claims.iter().filter(|claim| claim.place == Place::Contribution(3) && claim.truth == truth);
        mine.find_map(|claim| claim.judged).map(|judged| judged.count).context("no claim about (55)")
    };
    let [printed, ours] = [of(Truth::Printed)?, of(Truth::StandIn)?];
    Ok(Finding::new(format!(
        "The corrected model ends within 2 E1 + E2 of the truth, as (55) says, in {printed} campaigns with stall alone as the truth \
         and in {ours} with our stand-in. E1 and E2 are the errors of the surfaces fitted to simulations and to experiments."
    ))
    .with("campaigns within, with stall alone", printed.holding as f64, "1")
    .with("campaigns within, with our stand-in", ours.holding as f64, "1"))
}

/// How many campaigns were run and judged.
fn campaigns(findings: &Findings) -> Finding {
    let (n, n_judged) = (findings.ended.len(), lawful(findings).len());
    Finding::new(format!(
        "{n} campaigns of the dissertation's loop were run on experiments with a richer model, whose truth is known. {} of them run (36) as \
         printed, which is there to fail, so that {n_judged} are judged. The gain k is the part of the measured error by which an iteration \
         corrects the model.",
        n - n_judged
    ))
    .with("campaigns", n as f64, "1")
    .with("campaigns judged", n_judged as f64, "1")
}

/// What the pages begin with.
pub(crate) fn first_screen<'a>(
    findings: &Findings,
    claims: &[Claim],
    pictures: &'a [Picture],
) -> Result<FirstScreen<'a>> {
    const FIRST_CLAIMS: [Place; 2] = [Place::Figure(21), Place::Figure(20)];
    let first_claims = claims.iter().filter(|claim| FIRST_CLAIMS.contains(&claim.place)).map(claims::finding);
    let found = [within(claims)?, example(findings)?].into_iter().chain(first_claims).chain([campaigns(findings)]);
    let first = first_picture(findings.extent);
    let picture = pictures.iter().find(|picture| picture.name.starts_with(first));
    Ok(FirstScreen {
        findings: found.collect(),
        picture: picture.with_context(|| format!("no picture is called {first}"))?,
    })
}

/// The page of the study.
pub(crate) fn page(
    findings: &Findings,
    claims: &[Claim],
    pictures: &[Picture],
    first: &FirstScreen<'_>,
) -> Result<Page> {
    let mut page = Page::new("Chapter 6: how close the corrected model comes to the truth");
    first.show_in(&mut page);
    page.note(NO_EXPERIMENT);
    page.paragraph(
        "A cheap model is wrong and an experiment is dear. In every iteration a few experiments and more simulations are made where they \
         say most, surfaces are fitted to both, the model is corrected by their difference, and designs that are worse than the best \
         beyond doubt are dropped. Section 6.1 proves that the corrected model ends within 2 E1 + E2 of the truth, E1 and E2 being the \
         errors of the surfaces. Here the truth is known, so the proof can be watched.",
    );
    page.paragraph(OURS);
    page.paragraph(&extent_words(findings));
    page.paragraph(&loop_words(findings));
    page.heading(claims::BY_VERDICT);
    claims::by_verdict(claims).iter().for_each(|finding| page.finding(finding));
    let show = |page: &mut Page, names: &str| {
        let others = pictures.iter().filter(|picture| !picture.name.starts_with(first_picture(findings.extent)));
        for picture in others.filter(|picture| picture.name.starts_with(names)) {
            picture.show_in(page);
        }
    };
    page.heading("Designs and responses");
    show(&mut page, "figure-20");
    page.heading("Error, bounds, and what is left");
    show(&mut page, "figure-21");
    page.table(&main_table(findings), CAMPAIGN_CAPTION);
    page.table(&tables::norms(findings, followed(findings)?), NORM_CAPTION);
    page.heading("Gains and laws");
    show(&mut page, "gains");
    page.table(&other_table(findings), VARIANT_CAPTION);
    page.table(&tables::how_many(findings)?, HOW_MANY_CAPTION);
    page.heading("Before and after");
    show(&mut page, "figure-22");
    page.table(&tables::flights(findings), FLIGHT_CAPTION);
    page.heading("The fields");
    page.table(&tables::fields(findings)?, FIELD_CAPTION);
    page.heading(DECIDED);
    page.paragraph(CLAIM_CAPTION);
    claims::decided(claims).iter().for_each(|finding| page.finding(finding));
    page.heading("Every number");
    page.table(
        &provenance_table(&findings.setup.spaces[0].bat.records),
        "Plant, controller, test and cost: value, unit and where each comes from.",
    );
    page.paragraph(&format!("Made by `cargo xtask reproduce-chapter6` in {:.0} s.", findings.seconds));
    Ok(page)
}

fn written_by(extent: Extent) -> &'static str {
    match extent {
        Extent::Default | Extent::WithKept | Extent::Anew => {
            "Written by `cargo xtask reproduce-chapter6`; `cargo xtask ci` fails when this page is not what the command finds. What becomes of \
             the claims with 24 levels for each of four parameters, as in Section 7.2, stands in [another page](results-chapter6-full.md)."
        }
        Extent::Full => {
            "Written by `cargo xtask reproduce-chapter6 --full`, which `cargo xtask ci` does not run: this page is kept from a run \
             to its end (how long that took is in the README of `studies`). What `cargo xtask ci` makes anew is the \
             [page with fewer levels](results-chapter6.md); where the two differ is said below, and `reproduction.md` counts this one."
        }
    }
}

/// The same claim with fewer levels.
fn twin<'a>(claim: &Claim, fewer: &'a [Claim]) -> Option<&'a Claim> {
    fewer.iter().find(|other| other.is_same(claim))
}

/// Every claim with fewer levels and with all.
fn beside_fewer(claims: &[Claim], fewer: &[Claim]) -> String {
    let mut table = Table::new(vec![
        Column::new("Place", ""),
        Column::new("Claim", ""),
        Column::new("With fewer levels", ""),
        Column::new("With all levels", ""),
    ]);
    for claim in claims.iter().filter(|claim| claim.judged.is_some()) {
        let other = twin(claim, fewer).map_or("–".to_owned(), Claim::verdict_words);
        table.push(vec![claim.place.to_string(), claim.words(), other, claim.verdict_words()]);
    }
    format!("## With fewer levels, and with all\n\n{}\n", table.markdown())
}

/// How many verdicts are others than with fewer levels.
pub(crate) fn changed(claims: &[Claim], fewer: &[Claim]) -> Finding {
    let is_other = |claim: &&Claim| twin(claim, fewer).is_some_and(|other| other.verdict != claim.verdict);
    let changed: Vec<&Claim> = claims.iter().filter(is_other).collect();
    let words: Vec<String> = changed.iter().map(|claim| format!("{} ({})", claim.words(), claim.place)).collect();
    Finding::new(format!(
        "{} of {} verdicts are others than with fewer levels: {}.",
        changed.len(),
        claims.iter().filter(|claim| claim.judged.is_some()).count(),
        if words.is_empty() { "none".to_owned() } else { words.join("; ") }
    ))
    .with("verdicts changed", changed.len() as f64, "1")
}

/// The results as a page of `docs/`, without anything that differs from run to run.
pub(crate) fn markdown(findings: &Findings, claims: &[Claim], fewer: Option<&[Claim]>, first: &str) -> Result<String> {
    Ok(format!(
        "# Chapter 6: results{}\n\n{first}\n{}\n\
         See [departures](departures.md) for what is built instead of what is printed.\n\n{}\n{}{NO_EXPERIMENT}\n\n{OURS}\n\n{}\n\n{}\n\n\
         ## Campaigns with the first gain\n\n{CAMPAIGN_CAPTION}\n\n{}\n## Other gains, laws and regressors\n\n{VARIANT_CAPTION}\n\n{}\n\
         ## One campaign, iteration by iteration\n\n{}.\n{NORM_CAPTION}\n\n{}\n## How many iterations\n\n{HOW_MANY_CAPTION}\n\n{}\n\
         ## Before and after\n\n{FLIGHT_CAPTION}\n\n{}\n## The fields\n\n{FIELD_CAPTION}\n\n{}\n\
         ## {DECIDED}\n\n{CLAIM_CAPTION}\n\n{}",
        if findings.extent == Extent::Full { ", with all levels" } else { "" },
        written_by(findings.extent),
        claims::by_verdict_markdown(claims),
        fewer.map_or(String::new(), |fewer| beside_fewer(claims, fewer)),
        extent_words(findings),
        loop_words(findings),
        main_table(findings).markdown(),
        other_table(findings).markdown(),
        findings.setup.words(followed(findings)?.case),
        tables::norms(findings, followed(findings)?).markdown(),
        tables::how_many(findings)?.markdown(),
        tables::flights(findings).markdown(),
        tables::fields(findings)?.markdown(),
        claims::markdown(&claims::decided(claims)),
    ))
}

/// The closing summary.
#[expect(clippy::print_stdout, reason = "the result of the command")]
pub(crate) fn print(findings: &Findings, claims: &[Claim], out: &Path) -> Result<()> {
    println!(
        "\nChapter 6: {} campaigns of the loop on experiments with a richer model, whose truth is known\n",
        findings.ended.len()
    );
    for claim in claims {
        println!("- {}: {}: {}.\n    {}", claim.place, claim.words(), claim.verdict, claim.found);
    }
    println!("\n{}", example(findings)?.sentence());
    println!("\nPage, figures and data: {} (open index.html), after {:.0} s.", out.display(), findings.seconds);
    Ok(())
}
