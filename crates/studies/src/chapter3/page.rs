//! What a person reads of Chapter 3.

use std::path::Path;

use super::findings::{Findings, sentences};
use super::tables::{best_table, count_table};
use crate::claims::{self, Claim};
use crate::provenance::provenance_table;
use crate::reproduction::{Picture, markdown_list};
use page::Page;

pub(crate) const SURROGATE: &str = "No experiment was made. The water channel of the dissertation is replaced by a surrogate, the numerical \
    model plus stall plus added mass. The plant was calibrated to rows 1 of Tables 3 and 5 and to the best design of Table 3; \
    nothing in this chapter was fitted to Figure 14, which shows no numbers that could be read.";

pub(crate) const BEST_CAPTION: &str = "The stable design with the lowest cost (20) in each panel, among the centers of mass that Table 4 \
    allows and over the whole lattice; with the shares of heading and lateral position in the cost, and the rate at which the \
    slowest disturbance grows (negative: dies out) at the worst speed of the test.";

pub(crate) const COUNT_CAPTION: &str = "What the designs of the lattice do. Unstable: a small disturbance grows at one of the three speeds, \
    with the lines held as they are trimmed at the first; such a design may still get through the test, slowly growing. \
    A slack line or a state outside the model ends a flight without a cost.";

/// The page of the study.
pub(crate) fn page(findings: &Findings<'_>, claims: &[Claim], pictures: &[Picture]) -> Page {
    let mut page = Page::new("Chapter 3: which configurations fly well without a controller");
    claims::begin(&mut page, claims, pictures.first());
    page.note(SURROGATE);
    page.paragraph(
        "Before anything is optimized, the bare machine is compared in four configurations: with the horizontal fin at three angles \
         of incidence, and with one or two of its three lines forward. No controller runs. The center of mass and the trim pitch \
         are varied, the lines are reeled in and out one after the other at three flow speeds, and the cost is the integral of \
         heading and lateral position squared.",
    );
    page.heading("Figure 14");
    page.list(&sentences(findings));
    page.table(&best_table(findings, &findings.stand_in), BEST_CAPTION);
    page.table(&count_table(&findings.stand_in), COUNT_CAPTION);
    page.heading("The test");
    pictures[2].show_in(&mut page);
    page.heading("The same in the numerical model");
    page.paragraph("Without stall and added mass, which is what a designer has before any experiment.");
    pictures[1].show_in(&mut page);
    page.table(&best_table(findings, &findings.model), BEST_CAPTION);
    page.table(&count_table(&findings.model), COUNT_CAPTION);
    page.heading("Every number");
    page.table(
        &provenance_table(&findings.setup.records),
        "Plant, controller and test: value, unit and where each comes from. Center of mass, pitch set point, fin incidence and \
         layout are replaced by those of each design; the controller's gains are not used.",
    );
    page.paragraph(&format!("Made by `cargo xtask reproduce-chapter3` in {:.0} s.", findings.seconds));
    page
}

/// The results as a page of `docs/`.
pub(crate) fn markdown(findings: &Findings<'_>, claims: &[Claim]) -> String {
    format!(
        "# Chapter 3: results\n\n\
         Written by `cargo xtask reproduce-chapter3`; `cargo xtask ci` fails when this page is not what the command finds.\n\
         {SURROGATE}\n\n{}\n\
         ## Figure 14, in the stand-in\n\n{}\n{BEST_CAPTION}\n\n{}\n{COUNT_CAPTION}\n\n{}\n\
         ## In the numerical model\n\n{}\n{}",
        claims::beginning(claims),
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
