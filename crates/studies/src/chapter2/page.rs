//! What a person reads of Chapter 2.

use std::path::Path;

use anyhow::Result;

use super::claims::percent;
use super::findings::{Findings, REPAIRED_19};
use super::models::{Case, Releases};
use super::tables;
use crate::claims::{self, Claim};
use crate::first_screen::FirstScreen;
use crate::provenance::provenance_table;
use crate::reproduction::{Picture, markdown_list, picture};
use page::{Finding, Page};

pub(crate) const NO_EXPERIMENT: &str = "No experiment was made. The water channel of the dissertation is replaced by a stand-in, the numerical \
    model plus stall plus added mass. The plant was calibrated to rows 1 and 3 of the dissertation's Table 3 and rows 0 and 3 of its \
    Table 5; nothing in this chapter was fitted to its Table 2 or to Figures 11 and 12.";

pub(crate) const BY_CONSTRUCTION: &str = "The equations that fly here have no viscosity. That similar models fly alike in them, and that the \
    machine flies like its model, is a property of the equations: it verifies the laws and the program, and says nothing about water \
    or air. The group of viscosity, the Reynolds number, is not kept by any of this; the dissertation assumes that the aerodynamic \
    coefficients do not depend on it between 75,000 (1 m/s in water) and 5,000,000 (10 m/s in air).";

pub(crate) const REYNOLDS_CAPTION: &str = "Chord times flow speed over kinematic viscosity (handbook values at 20 degrees Celsius): of the models \
    as printed, and of the reference model converted to full scale.";

pub(crate) const LISTED_15: &str = "listed in (15)";

pub(crate) const LISTED_19: &str = "listed in (19), slips repaired";

pub(crate) const COLLAPSE_CAPTION: &str = "Largest distance of the curves of models 1 and 3 from that of model 2, as a share of that one's peak, \
    against time and against normalized time; and the period of the slowest oscillation of each model about its trim.";

pub(crate) const SIMILARITY_CAPTION: &str = "The groups of (15) that the dissertation's Table 2 determines, at each model. Spread: largest value over smallest, less \
    one. Open by rounding: what the printed digits leave open.";

pub(crate) const LAW_CAPTION: &str = "How everything scales, derived from the dimensions: the ratios of L_t, rho and g are given, all else \
    follows. The power of length is what is left at one gravity and in one fluid, beside the powers that the dissertation states, with \
    their places.";

/// The picture that the pages begin with.
const FIRST: &str = "figure-11-similar";

/// What the pages begin with.
pub(crate) fn first_screen<'a>(findings: &Findings<'_>, pictures: &'a [Picture]) -> Result<FirstScreen<'a>> {
    let setup = findings.setup;
    let (plant, controller) = (setup.plant.groups.len(), setup.controller.groups.len());
    let heading = |case: Case, apart: fn(&Releases) -> f64| findings.releases(case).map_or(f64::NAN, apart);
    let in_time = heading(Case::Similar, |releases| releases.apart().heading);
    let normalized = heading(Case::Similar, |releases| releases.apart_when_normalized().heading);
    let printed = heading(Case::PrintedMasses, |releases| releases.apart_when_normalized().heading);
    let n_mismatches = findings.similarity.mismatches().count();
    let n_checked = plant - findings.similarity.unchecked().len();
    let lie = if n_mismatches == 0 { "they lie" } else { "they do not lie" };
    Ok(FirstScreen {
        findings: vec![
            Finding::new(format!(
                "A model moves like the machine, only faster, if every dimensionless group stays as it is: {plant} groups of the \
                 plant, {controller} of the controller."
            ))
            .with("groups of the plant", plant as f64, "1")
            .with("groups of the controller", controller as f64, "1"),
            Finding::new(format!(
                "Three models that keep them turn back after a twist with headings that are up to {:.0} % of the peak apart against \
                 time, and {} against normalized time.",
                100.0 * in_time,
                percent(normalized)
            ))
            .with("apart against time", in_time, "1")
            .with("apart against normalized time", normalized, "1"),
            Finding::new(format!(
                "With the masses that Table 2 prints {lie} on one curve: {n_mismatches} of the {n_checked} groups that it determines \
                 is not kept, and {:.0} % of the peak are left between the headings.",
                100.0 * printed
            ))
            .with("groups not kept", n_mismatches as f64, "1")
            .with("apart with the printed masses", printed, "1"),
        ],
        picture: picture(pictures, FIRST)?,
    })
}

/// The page of the study.
pub(crate) fn page(
    findings: &Findings<'_>,
    claims: &[Claim],
    pictures: &[Picture],
    first: &FirstScreen<'_>,
) -> Result<Page> {
    let setup = findings.setup;
    let mut page = Page::new("Chapter 2: when is a small model a model?");
    first.show_in(&mut page);
    page.note(NO_EXPERIMENT);
    page.paragraph(
        "A turbine of 7.5 m chord is tested as a model of 7.5 cm in water. Which speeds, masses and controller gains make the model \
         move like the machine, only faster? Dimensional analysis answers: those that leave every dimensionless group as it is.",
    );
    page.heading(claims::BY_VERDICT);
    claims::by_verdict(claims).iter().for_each(|finding| page.finding(finding));
    page.heading("Dimensionless groups");
    page.table(
        &tables::groups(&setup.plant, LISTED_15),
        "Plant: the groups of Table 1's variables, computed in exact arithmetic.",
    );
    page.paragraph(&findings.groups_sentence(&setup.plant, "(15)"));
    page.paragraph(&in_normalized_time(findings));
    page.table(&tables::groups(&setup.controller, LISTED_19), "Controller: the groups of Section 2.4.2's variables.");
    page.paragraph(&findings.groups_sentence(&setup.controller, REPAIRED_19));
    page.heading("The dissertation's Table 2, checked");
    page.table(
        &tables::table_2(findings)?,
        "The dissertation's Table 2 as printed, beside what the scale factor X_s makes of model 2.",
    );
    page.table(&tables::similarity(findings), SIMILARITY_CAPTION);
    page.paragraph(&findings.mismatch_sentence());
    page.table(
        &tables::remedies(findings),
        "The masses of the dissertation's Table 2, and those that would match model 2.",
    );
    page.paragraph(&findings.hull_sentence());
    page.heading("Figures 11 and 12");
    page.paragraph(&findings.release_sentence());
    page.table(&tables::collapse(findings), COLLAPSE_CAPTION);
    for picture in pictures.iter().filter(|picture| picture.name != FIRST) {
        picture.show_in(&mut page);
    }
    page.paragraph(&findings.honest_paragraph());
    page.heading("What this does not show");
    page.paragraph(BY_CONSTRUCTION);
    page.table(&tables::reynolds(findings)?, REYNOLDS_CAPTION);
    page.heading("Scaling laws");
    page.table(&tables::laws(findings)?, LAW_CAPTION);
    page.paragraph(&findings.law_sentence()?);
    page.heading("The rig at full scale, in air");
    page.table(
        &tables::both_scales(findings),
        "The closed-loop test of Chapter 4, flown with the laboratory's files and with the converted ones.",
    );
    page.list(&findings.full_scale_sentences());
    page.list(&findings.printed_full_scale()?);
    page.table(
        &tables::full_scale(findings),
        "Every number of the rig at both scales; the files are in the folder full-scale.",
    );
    page.heading("Every number");
    page.table(
        &provenance_table(&setup.rig.records),
        "The rig of the laboratory: value, unit and where each comes from.",
    );
    page.paragraph(&format!("Made by `cargo xtask reproduce-chapter2` in {:.0} s.", findings.seconds));
    Ok(page)
}

/// The results as a page of `docs/`.
pub(crate) fn markdown(findings: &Findings<'_>, claims: &[Claim], first: &str) -> Result<String> {
    let setup = findings.setup;
    Ok(format!(
        "# Chapter 2: results\n\n{first}\n\
         Written by `cargo xtask reproduce-chapter2`; `cargo xtask ci` fails when this page is not what the command finds.\n\
         {NO_EXPERIMENT}\n\n{}\n\
         ## Dimensionless groups\n\n{} {}\n\n{}\n{}\n\n{}\n\
         ## The dissertation's Table 2, checked\n\n{}\n{SIMILARITY_CAPTION}\n\n{}\n{}\n\n{}\n{}\n\n\
         ## Figures 11 and 12\n\n{}\n\n{COLLAPSE_CAPTION}\n\n{}\n{}\n\n\
         ## What this does not show\n\n{BY_CONSTRUCTION}\n\n{REYNOLDS_CAPTION}\n\n{}\n\
         ## Scaling laws\n\n{LAW_CAPTION}\n\n{}\n{}\n\n\
         ## The rig at full scale, in air\n\n{}{}\n{}",
        claims::by_verdict_markdown(claims),
        findings.groups_sentence(&setup.plant, "(15)"),
        in_normalized_time(findings),
        tables::groups(&setup.plant, LISTED_15).markdown(),
        findings.groups_sentence(&setup.controller, REPAIRED_19),
        tables::groups(&setup.controller, LISTED_19).markdown(),
        tables::table_2(findings)?.markdown(),
        tables::similarity(findings).markdown(),
        findings.mismatch_sentence(),
        tables::remedies(findings).markdown(),
        findings.hull_sentence(),
        findings.release_sentence(),
        tables::collapse(findings).markdown(),
        findings.honest_paragraph(),
        tables::reynolds(findings)?.markdown(),
        tables::laws(findings)?.markdown(),
        findings.law_sentence()?,
        markdown_list(&findings.full_scale_sentences()),
        markdown_list(&findings.printed_full_scale()?),
        tables::both_scales(findings).markdown(),
    ))
}

/// The closing summary.
#[expect(clippy::print_stdout, reason = "the result of the command")]
pub(crate) fn print(findings: &Findings<'_>, out: &Path) {
    println!("\nChapter 2: when is a small model a model? (flights in the stand-in for the water channel)\n");
    println!("{}\n", findings.similarity);
    println!("{}\n", findings.mismatch_sentence());
    println!("{}\n", tables::remedies(findings).text());
    println!("{}\n", tables::collapse(findings).text());
    println!("{}\n", findings.honest_paragraph());
    for sentence in findings.full_scale_sentences() {
        println!("- {sentence}");
    }
    println!(
        "\nPage, figures, data and the rig at full scale: {} (open index.html), after {:.0} s.",
        out.display(),
        findings.seconds
    );
}

fn in_normalized_time(findings: &Findings<'_>) -> String {
    format!(
        "With speed and gravity in normalized time: {}",
        findings.groups_sentence(&findings.setup.normalized_time, "(17)")
    )
}
