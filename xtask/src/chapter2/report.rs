//! What a person reads of Chapter 2.

use std::path::Path;

use super::models::{Case, Releases};
use super::tables::{self, magnitude};
use super::{Findings, file::Analysis};
use crate::page::Page;
use crate::reproduction::{Picture, markdown_list};
use crate::table::provenance_table;

const SURROGATE: &str = "No experiment was made. The water channel of the dissertation is replaced by a surrogate, the numerical \
    model plus stall plus added mass; nothing in this chapter was fitted to Table 2 or to Figures 11 and 12.";

const COLLAPSE_CAPTION: &str = "Largest distance of the curves of models 1 and 3 from that of model 2, as a share of that one's peak, \
    against time and against normalized time; and the period of the slowest oscillation of each model about its trim.";

const SIMILARITY_CAPTION: &str = "The groups of (15) that Table 2 determines, at each model. Spread: largest value over smallest, less \
    one. Open by rounding: what the printed digits leave open.";

const LAW_CAPTION: &str = "How everything scales, derived from the groups: L_t, rho and g are given, all else follows. The power of \
    length is what is left at one gravity and in one fluid, beside the power that the dissertation states.";

impl Findings<'_> {
    fn releases(&self, case: Case) -> Option<&Releases> {
        self.releases.iter().find(|releases| releases.case == case)
    }

    fn groups_sentence(&self, analysis: &Analysis, equation: &str) -> String {
        let system = &analysis.system;
        let same = analysis.groups.span_same_space(&analysis.listed);
        format!(
            "{} variables of rank {} leave {} groups; with {} repeating, the computed ones and the {} listed in {equation} {}. {} \
             choices of repeating variables are possible.",
            system.variables().len(),
            system.rank(),
            analysis.groups.len(),
            analysis.groups.repeating().join(", "),
            analysis.listed.len(),
            if same {
                "say the same: each set consists of products of powers of the other"
            } else {
                "do NOT say the same"
            },
            system.repeating_sets().count()
        )
    }

    fn mismatch_sentence(&self) -> String {
        let named: Vec<String> = self
            .similarity
            .mismatches()
            .map(|row| {
                let values: Vec<String> = row.values.iter().map(|value| tables::significant(*value, 4)).collect();
                format!("{} ({})", row.group, values.join(", "))
            })
            .collect();
        if named.is_empty() {
            return "Every group that Table 2 determines matches.".to_owned();
        }
        let missing =
            self.similarity.unchecked().iter().map(|one| one.group.to_string()).collect::<Vec<_>>().join(", ");
        format!("Not matched: {}. Not compared, because Table 2 does not give them: {missing}.", named.join("; "))
    }

    /// What becomes of the printed masses in hulls of similar shape.
    fn hull_sentence(&self) -> String {
        let words: Vec<String> = self
            .setup
            .file
            .model
            .iter()
            .zip(&self.in_similar_hulls)
            .map(|(model, (displaced_kg, reason))| {
                let flies = match reason {
                    None => "it can be trimmed".to_owned(),
                    Some(reason) => format!("it cannot fly: {reason}"),
                };
                format!(
                    "{} weighs {} g and would displace {:.0} g, {flies}",
                    model.name,
                    model.mass_g,
                    1000.0 * displaced_kg
                )
            })
            .collect();
        format!("With the printed masses in hulls of similar shape: {}.", words.join("; "))
    }

    /// What the dissertation's plots show and what ours show.
    fn honest_paragraph(&self) -> String {
        let number = |case: Case| {
            let apart = self.releases(case).map(|releases| (releases.apart(), releases.apart_when_normalized()));
            apart.map_or((f64::NAN, f64::NAN, f64::NAN, f64::NAN), |(t, at)| {
                (100.0 * t.heading, 100.0 * at.heading, 100.0 * t.lateral, 100.0 * at.lateral)
            })
        };
        let (similar, rounded, printed) = (number(Case::Similar), number(Case::Rounded), number(Case::PrintedMasses));
        let collapse = if similar.1.max(similar.3) < 1e-6 { "to rounding" } else { "NOT to rounding" };
        let closer = printed.1 < printed.0 && printed.3 < printed.2;
        format!(
            "The dissertation says of its plots that normalization removes a large difference in the frequency of the heading and \
             reduces those in frequency and amplitude of the lateral position; we have read its words, not its curves. In our \
             flights the headings of similar models differ by up to {:.0} % of the peak against time and collapse {collapse} \
             against normalized time; with the printed, rounded lengths and speeds {:.1} % (heading) and {:.1} % (lateral position) \
             remain. With the printed masses the normalized curves stay {:.0} % and {:.0} % apart: {} than against time ({:.0} % \
             and {:.0} %), but no collapse. So either the masses that flew were not those of Table 2, or the printed plots cannot \
             have collapsed as closely as similarity promises; from the text alone we cannot tell which.",
            similar.0,
            rounded.1,
            rounded.3,
            printed.1,
            printed.3,
            if closer { "closer" } else { "not closer" },
            printed.0,
            printed.2
        )
    }

    fn full_scale_sentences(&self) -> Vec<String> {
        let full = &self.full_scale;
        let mut sentences = vec![format!(
            "Of {} numbers in three parameter files, {} came back with other bits after the way to full scale and back.",
            full.n_numbers, full.changed_on_return
        )];
        for flight in &full.flights {
            sentences.push(format!(
                "{}: {} samples of the closed-loop test, {:.0} s in the laboratory and {:.0} s at full scale, differ in \
                 dimensionless form by {} of the peak of each column.",
                flight.physics,
                flight.samples,
                flight.duration_s[0],
                flight.duration_s[1],
                magnitude(flight.largest_difference)
            ));
        }
        sentences
    }

    fn law_sentence(&self) -> String {
        let agreeing = self.setup.file.stated.iter().filter(|stated| {
            let rule = self.setup.full_scale_law().and_then(|law| Ok(law.rule(&stated.variable)?));
            matches!((rule, stated.power()), (Ok(rule), Ok(power)) if tables::power_of_length(&rule) == power)
        });
        format!(
            "{} of the {} laws that the dissertation states come out by computation.",
            agreeing.count(),
            self.setup.file.stated.len()
        )
    }
}

/// The page of the study.
pub(crate) fn page(findings: &Findings<'_>, pictures: &[Picture]) -> Page {
    let setup = findings.setup;
    let mut page = Page::new("Chapter 2: when is a small model a model?");
    page.note(SURROGATE);
    page.paragraph(
        "A turbine of 7.5 m chord is tested as a model of 7.5 cm in water. Which speeds, masses and controller gains make the model \
         move like the machine, only faster? Dimensional analysis answers: those that leave every dimensionless group as it is.",
    );
    page.heading("Dimensionless groups");
    page.table(
        &tables::groups(&setup.plant),
        "Plant: the groups of Table 1's variables, computed in exact arithmetic, beside (15).",
    );
    page.paragraph(&findings.groups_sentence(&setup.plant, "(15)"));
    page.table(
        &tables::groups(&setup.controller),
        "Controller: the groups of Section 2.4.2, beside (19) with its slips mended (t_bar/tau_z in place of V/tau_z, and V/k_p,phi, \
         which is missing there); t_bar = L_t/V.",
    );
    page.paragraph(&findings.groups_sentence(&setup.controller, "(19)"));
    page.heading("Table 2, checked");
    if let Ok(table) = tables::table_2(findings) {
        page.table(&table, "The dissertation's Table 2 as printed, beside what the scale factor X_s makes of model 2.");
    }
    page.table(&tables::similarity(findings), SIMILARITY_CAPTION);
    page.paragraph(&findings.mismatch_sentence());
    page.table(
        &tables::remedies(findings),
        "The masses of the dissertation's Table 2, and those that would match model 2.",
    );
    page.paragraph(&findings.hull_sentence());
    page.heading("Figures 11 and 12");
    page.paragraph(&format!(
        "The rig's own 1/100 model is model 2; the others are converted from it. Each is released at rest, turned by {} deg about its \
         tether's end, without a controller, at its flow speed of Table 2.",
        setup.file.release.twist_deg
    ));
    page.table(&tables::collapse(findings), COLLAPSE_CAPTION);
    for picture in pictures {
        picture.show_in(&mut page);
    }
    page.paragraph(&findings.honest_paragraph());
    page.heading("Scaling laws");
    if let Ok(table) = tables::laws(findings) {
        page.table(&table, LAW_CAPTION);
    }
    page.paragraph(&findings.law_sentence());
    page.heading("The rig at full scale, in air");
    page.table(
        &tables::both_scales(findings),
        "The closed-loop test of Chapter 4, flown with the laboratory's files and with the converted ones.",
    );
    page.list(&findings.full_scale_sentences());
    page.table(
        &tables::full_scale(findings),
        "Every number of the rig at both scales; the files are in the folder full-scale.",
    );
    page.heading("Every number");
    match water_channel::RigFile::parse(&setup.texts.rig.1) {
        Ok(rig) => page.table(
            &provenance_table(&rig.records),
            "The rig of the laboratory: value, unit and where each comes from.",
        ),
        Err(error) => page.paragraph(&error.to_string()),
    }
    page.paragraph(&format!("Made by `cargo xtask reproduce-chapter2` in {:.0} s.", findings.seconds));
    page
}

/// The results as a page of `docs/`.
pub(crate) fn markdown(findings: &Findings<'_>) -> String {
    let setup = findings.setup;
    let table =
        |table: anyhow::Result<crate::table::Table>| table.map_or_else(|e| e.to_string(), |table| table.markdown());
    format!(
        "# Chapter 2: results\n\n\
         Written by `cargo xtask reproduce-chapter2`; `cargo xtask ci` fails when this page is not what the command finds.\n\
         {SURROGATE}\n\n\
         ## Dimensionless groups\n\n{}\n\n{}\n{}\n\n{}\n\
         ## Table 2, checked\n\n{}\n{SIMILARITY_CAPTION}\n\n{}\n{}\n\n{}\n{}\n\n\
         ## Figures 11 and 12\n\n{COLLAPSE_CAPTION}\n\n{}\n{}\n\n\
         ## Scaling laws\n\n{LAW_CAPTION}\n\n{}\n{}\n\n\
         ## The rig at full scale, in air\n\n{}\n{}",
        findings.groups_sentence(&setup.plant, "(15)"),
        tables::groups(&setup.plant).markdown(),
        findings.groups_sentence(&setup.controller, "(19)"),
        tables::groups(&setup.controller).markdown(),
        table(tables::table_2(findings)),
        tables::similarity(findings).markdown(),
        findings.mismatch_sentence(),
        tables::remedies(findings).markdown(),
        findings.hull_sentence(),
        tables::collapse(findings).markdown(),
        findings.honest_paragraph(),
        table(tables::laws(findings)),
        findings.law_sentence(),
        markdown_list(&findings.full_scale_sentences()),
        tables::both_scales(findings).markdown(),
    )
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
