//! What a person reads of Chapter 3.

use std::path::Path;

use anyhow::Result;

use super::findings::{Findings, sentences, spans};
use super::panels::PanelFlights;
use super::tables::{best_table, count_table};
use crate::claims::{self, Claim};
use crate::first_screen::FirstScreen;
use crate::provenance::provenance_table;
use crate::reproduction::{Picture, markdown_list, picture};
use page::{Finding, Page};

pub(crate) const NO_EXPERIMENT: &str = "No experiment was made. The water channel of the dissertation is replaced by a stand-in, the numerical \
    model plus stall plus added mass. The plant was calibrated to rows 1 and 3 of Table 3 and rows 0 and 3 of Table 5; \
    nothing in this chapter was fitted to Figure 14, which shows no numbers that could be read.";

pub(crate) const BEST_CAPTION: &str = "The stable design with the lowest cost (20) in each panel, among the centers of mass that Table 4 \
    allows and over the whole lattice; with the shares of heading and lateral position in the cost, and the rate at which the \
    slowest disturbance grows (negative: dies out) at the worst speed of the test.";

pub(crate) const COUNT_CAPTION: &str = "What the designs of the lattice do. Unstable: a small disturbance grows at one of the three speeds, \
    with the lines held as they are trimmed at the first; such a design may still get through the test, slowly growing. \
    A slack line or a state outside the model ends a flight without a cost.";

/// What the pages begin with.
pub(crate) fn first_screen<'a>(findings: &Findings<'_>, pictures: &'a [Picture]) -> Result<FirstScreen<'a>> {
    let spans = spans(findings);
    let (least, most) =
        (spans.iter().copied().fold(f64::INFINITY, f64::min), spans.iter().copied().fold(0.0, f64::max));
    let designs = || findings.stand_in.iter().flat_map(PanelFlights::designs);
    let (n, n_unstable) = (designs().count(), findings.stand_in.iter().flat_map(PanelFlights::unstable).count());
    Ok(FirstScreen {
        findings: vec![
            Finding::new(format!(
                "In each of {} configurations the open-loop cost depends on trim pitch and center of mass: of the stable designs within \
                 Table 4 the worst costs {least:.0} to {most:.0} times as much as the best.",
                spans.len()
            ))
            .with("least ratio of the highest to the lowest cost", least, "1")
            .with("largest ratio of the highest to the lowest cost", most, "1"),
            Finding::new(format!(
                "{n_unstable} of {n} designs are unstable in the stand-in; in the numerical model {} are.",
                findings.model.iter().flat_map(PanelFlights::unstable).count()
            ))
            .with("unstable designs", n_unstable as f64, "1")
            .with("designs", n as f64, "1"),
        ],
        picture: picture(pictures, "lowest-costs")?,
    })
}

/// The page of the study.
pub(crate) fn page(
    findings: &Findings<'_>,
    claims: &[Claim],
    pictures: &[Picture],
    first: &FirstScreen<'_>,
) -> Result<Page> {
    let mut page = Page::new("Chapter 3: which configurations fly well without a controller");
    first.show_in(&mut page);
    page.note(NO_EXPERIMENT);
    page.paragraph(
        "Before anything is optimized, the bare machine is compared in four configurations: with the horizontal fin at three angles \
         of incidence, and with one or two of its three lines forward. No controller runs. The center of mass and the trim pitch \
         are varied, the lines are reeled in and out one after the other at three flow speeds, and the cost is the integral of \
         heading and lateral position squared.",
    );
    page.heading(claims::BY_VERDICT);
    claims::by_verdict(claims).iter().for_each(|finding| page.finding(finding));
    page.heading("Figure 14");
    picture(pictures, "figure-14")?.show_in(&mut page);
    page.list(&sentences(findings));
    page.table(&best_table(findings, &findings.stand_in), BEST_CAPTION);
    page.table(&count_table(&findings.stand_in), COUNT_CAPTION);
    page.heading("The test");
    picture(pictures, "one-flight")?.show_in(&mut page);
    page.heading("The same in the numerical model");
    page.paragraph("Without stall and added mass, which is what a designer has before any experiment.");
    picture(pictures, "figure-14-model")?.show_in(&mut page);
    page.table(&best_table(findings, &findings.model), BEST_CAPTION);
    page.table(&count_table(&findings.model), COUNT_CAPTION);
    page.heading("Every number");
    page.table(
        &provenance_table(&findings.setup.records),
        "Plant, controller and test: value, unit and where each comes from. Center of mass, pitch set point, fin incidence and \
         layout are replaced by those of each design; the controller's gains are not used.",
    );
    page.paragraph(&format!("Made by `cargo xtask reproduce-chapter3` in {:.0} s.", findings.seconds));
    Ok(page)
}

/// The results as a page of `docs/`.
pub(crate) fn markdown(findings: &Findings<'_>, claims: &[Claim], first: &str) -> String {
    format!(
        "# Chapter 3: results\n\n{first}\n\
         Written by `cargo xtask reproduce-chapter3`; `cargo xtask ci` fails when this page is not what the command finds.\n\
         {NO_EXPERIMENT}\n\n{}\n\
         ## Figure 14, in the stand-in\n\n{}\n{BEST_CAPTION}\n\n{}\n{COUNT_CAPTION}\n\n{}\n\
         ## In the numerical model\n\n{}\n{}",
        claims::by_verdict_markdown(claims),
        markdown_list(&sentences(findings)),
        best_table(findings, &findings.stand_in).markdown(),
        count_table(&findings.stand_in).markdown(),
        best_table(findings, &findings.model).markdown(),
        count_table(&findings.model).markdown(),
    )
}

/// The closing summary.
#[expect(clippy::print_stdout, reason = "the result of the command")]
pub(crate) fn print(findings: &Findings<'_>, out: &Path) {
    println!(
        "\nChapter 3: which configurations fly well without a controller (in the stand-in for the water channel)\n"
    );
    println!("{}\n", best_table(findings, &findings.stand_in).text());
    for sentence in sentences(findings) {
        println!("- {sentence}");
    }
    println!("\nPage, figures and data: {} (open index.html), after {:.0} s.", out.display(), findings.seconds);
}
