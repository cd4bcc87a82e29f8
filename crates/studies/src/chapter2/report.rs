//! What a person reads of Chapter 2.

use std::path::Path;

use anyhow::{Context as _, Result};

use super::Findings;
use super::file::{Analysis, Stated};
use super::models::{Case, Releases};
use super::tables::{self, magnitude};
use crate::claims::{self, Claim, Place, Verdict};
use crate::provenance::provenance_table;
use crate::reproduction::{Picture, markdown_list};
use page::Page;

const SURROGATE: &str = "No experiment was made. The water channel of the dissertation is replaced by a surrogate, the numerical \
    model plus stall plus added mass. The plant was calibrated to rows 1 of the dissertation's Tables 3 and 5 and to the best design of \
    its Table 3; nothing in this chapter was fitted to its Table 2 or to Figures 11 and 12.";

const BY_CONSTRUCTION: &str = "The equations that fly here have no viscosity. That similar models fly alike in them, and that the \
    machine flies like its model, is a property of the equations: it verifies the laws and the program, and says nothing about water \
    or air. The group of viscosity, the Reynolds number, is not kept by any of this; the dissertation assumes that the aerodynamic \
    coefficients do not depend on it between 75,000 (1 m/s in water) and 5,000,000 (10 m/s in air).";

const REYNOLDS_CAPTION: &str = "Chord times flow speed over kinematic viscosity (handbook values at 20 degrees Celsius): of the models \
    as printed, and of the reference model converted to full scale.";

const REPAIRED_19: &str = "(19), its slips repaired (t_bar/tau_z in place of V/tau_z, which is not dimensionless, and V/k_p,phi, which is \
    missing; t_bar = L_t/V),";

const LISTED_15: &str = "listed in (15)";
const LISTED_19: &str = "listed in (19), slips repaired";

const COLLAPSE_CAPTION: &str = "Largest distance of the curves of models 1 and 3 from that of model 2, as a share of that one's peak, \
    against time and against normalized time; and the period of the slowest oscillation of each model about its trim.";

const SIMILARITY_CAPTION: &str = "The groups of (15) that the dissertation's Table 2 determines, at each model. Spread: largest value over smallest, less \
    one. Open by rounding: what the printed digits leave open.";

const LAW_CAPTION: &str = "How everything scales, derived from the dimensions: the ratios of L_t, rho and g are given, all else \
    follows. The power of length is what is left at one gravity and in one fluid, beside the powers that the dissertation states, with \
    their places.";

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
            return "Every group that the dissertation's Table 2 determines matches.".to_owned();
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
                    Some(reason) => format!("there is no trim: {reason}"),
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

    /// What was flown for Figures 11 and 12.
    fn release_sentence(&self) -> String {
        let setup = self.setup;
        let (rig, release) = (&setup.rig.rig, setup.file.release);
        let heading =
            self.releases(Case::Similar).and_then(|releases| releases.models[setup.reference].heading_rad.first());
        format!(
            "{} is the rig's own 1/100 model, with its center of mass at {} % chord and trimmed to {:.1} deg of pitch; the others \
             are converted from it. Each is released at rest with a twist of {} deg, which turns its heading by {:.2} deg, without \
             a controller and in the stand-in, in the flow of its model (printed, or by the scale factor where everything is). \
             Twist, pitch and physics are ours: the dissertation does not say how its models were released.",
            setup.file.model[setup.reference].name,
            100.0 * rig.plant.body.center_of_mass_x,
            rig.set_points.pitch_rad.to_degrees(),
            release.twist_deg,
            heading.copied().unwrap_or(f64::NAN).to_degrees()
        )
    }

    /// What the dissertation's plots show and what ours show.
    fn honest_paragraph(&self) -> String {
        let number = |case: Case| {
            let apart = self.releases(case).map(|releases| (releases.apart(), releases.apart_when_normalized()));
            apart.map_or([f64::NAN; 4], |(t, at)| {
                [t.heading, at.heading, t.lateral, at.lateral].map(|share| 100.0 * share)
            })
        };
        let (similar, rounded, printed) = (number(Case::Similar), number(Case::Rounded), number(Case::PrintedMasses));
        let verdict = |[_, heading, _, lateral]: [f64; 4]| match heading.max(lateral) {
            apart if apart < 1e-6 => "collapse to rounding",
            apart if apart < 5.0 => "collapse to a few per cent",
            _ => "do not collapse",
        };
        let closer = if printed[1] < printed[0] && printed[3] < printed[2] { "closer" } else { "not closer" };
        format!(
            "What the dissertation's plots show, and what ours show. The dissertation says that normalization removes a large \
             difference in the frequency of the heading and reduces those in frequency and amplitude of the lateral position; we \
             have read its words, not its curves. Our similar models differ by up to {:.0} % (heading) and {:.0} % (lateral \
             position) of the peak against time, and {} against normalized time. With the printed, rounded lengths and speeds they \
             {}: {:.1} % and {:.1} % are left. With the printed masses they {}: {:.0} % and {:.0} % are left, {closer} than \
             against time ({:.0} % and {:.0} %). These last figures rest on an assumption of ours, that the displaced volume goes \
             with the printed mass while areas, added mass and lines follow the scale factor; without it the smallest model \
             would not float. If the printed masses are right, the models of the dissertation differed in more than scale; other \
             volumes, ballast or masses could explain a collapse, and from the text we cannot tell which.",
            similar[0],
            similar[2],
            verdict(similar),
            verdict(rounded),
            rounded[1],
            rounded[3],
            verdict(printed),
            printed[1],
            printed[3],
            printed[0],
            printed[2]
        )
    }

    /// What of the machine is printed, beside the converted rig.
    fn printed_full_scale(&self) -> Result<Vec<String>> {
        let mut sentences = Vec::new();
        for printed in &self.setup.file.printed_full_scale {
            let units = &self.setup.units;
            let converted = self.full_scale.rig.converted.iter().find(|number| number.path == printed.key);
            let converted =
                converted.with_context(|| format!("printed_full_scale.key = `{}`: no such number", printed.key))?;
            let read = |value: f64, unit: &str| -> Result<f64> { Ok(units.parse(unit)?.factor.apply(value)) };
            let (here, there) = (read(converted.new, &converted.unit)?, read(printed.value, &printed.unit)?);
            sentences.push(format!(
                "{}: {} {} by conversion, {} {} in {} of the dissertation, a ratio of {:.1}: a group of (15) that our rig {}.",
                printed.key,
                converted.new,
                converted.unit,
                printed.value,
                printed.unit,
                printed.place,
                here / there,
                if (here / there - 1.0).abs() <= self.setup.tolerance { "matches" } else { "does not match" }
            ));
        }
        Ok(sentences)
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
                 dimensionless form, as a share of the peak of each column, by {}.",
                flight.physics,
                flight.samples,
                flight.duration_s[0],
                flight.duration_s[1],
                match magnitude(flight.largest_difference).as_str() {
                    "0" => "nothing".to_owned(),
                    below => below.replace("below", "less than"),
                }
            ));
        }
        sentences
    }

    fn law_sentence(&self) -> Result<String> {
        let law = self.setup.full_scale_law()?;
        let (mut agreeing, mut differing) = (0, Vec::new());
        for stated in &self.setup.file.stated {
            let power = tables::power_of_length(&law.rule(&stated.variable)?);
            if stated.power()? == power {
                agreeing += 1;
            } else {
                let Stated { variable, place, .. } = stated;
                differing.push(format!("{variable} as the power {} ({place}), where {power} follows", stated.power()?));
            }
        }
        let differing = if differing.is_empty() {
            "none differs".to_owned()
        } else {
            format!("different: {}", differing.join("; "))
        };
        Ok(format!(
            "Of {} statements of the dissertation about powers of length {agreeing} come out by computation; {differing}.",
            self.setup.file.stated.len()
        ))
    }
}

/// What the dissertation claims in this chapter, and what of it came out.
pub(crate) fn claims(findings: &Findings<'_>) -> Result<Vec<Claim>> {
    let setup = findings.setup;
    let same = |analysis: &Analysis| analysis.groups.span_same_space(&analysis.listed);
    let reproduced = |holds: bool| if holds { Verdict::Reproduced } else { Verdict::NotReproduced };
    let apart = |case: Case| {
        let departures = findings.releases(case).map(Releases::apart_when_normalized);
        departures.map_or([f64::INFINITY; 2], |apart| [apart.heading, apart.lateral])
    };
    let (similar, printed) = (apart(Case::Similar), apart(Case::PrintedMasses));
    let curve = |k: usize| {
        format!(
            "Against normalized time the curves of models 1 and 3 are within {} of that of model 2, as a share of its peak, if the \
             models are similar; with the printed masses within {:.0} %.",
            percent(similar[k]),
            100.0 * printed[k]
        )
    };
    let flights = findings.full_scale.flights.iter().map(|flight| flight.largest_difference).fold(0.0, f64::max);
    let mismatches = findings.similarity.mismatches().count();
    Ok(vec![
        Claim::new(
            Place::Contribution(4),
            "Dynamic equivalence between the full-scale and the lab-scale system",
            Verdict::in_kind_if(same(&setup.plant) && flights < COLLAPSED),
            format!(
                "The closed-loop test flown with the laboratory's files and with the converted ones differs in dimensionless form by \
                 {} of the peak. Reynolds number and turbulence are outside of this similarity, in the dissertation and here.",
                percent(flights)
            ),
        ),
        Claim::new(
            Place::Table(1),
            "The variables of Table 1 give the 11 groups (15)",
            reproduced(same(&setup.plant)),
            findings.groups_sentence(&setup.plant, "(15)"),
        ),
        Claim::new(
            Place::Section("2.4.2".to_owned()),
            "The controller's variables give the 8 groups of (19)",
            Verdict::in_kind_if(same(&setup.controller)),
            findings.groups_sentence(&setup.controller, REPAIRED_19),
        ),
        Claim::new(
            Place::Section("2.4".to_owned()),
            "How speeds, times and gains go with the length",
            if law_differs(findings)? { Verdict::InKind } else { Verdict::Reproduced },
            findings.law_sentence()?,
        ),
        Claim::new(
            Place::Table(2),
            "Three scale models match in every group",
            reproduced(mismatches == 0),
            findings.mismatch_sentence(),
        ),
        Claim::new(
            Place::Figure(11),
            "The heading of three scale models collapses against normalized time",
            Verdict::in_kind_if(similar[0] < COLLAPSED),
            curve(0),
        )
        .shown_in(&["figure-11-similar"]),
        Claim::new(
            Place::Figure(12),
            "So does the lateral position, normalized",
            Verdict::in_kind_if(similar[1] < COLLAPSED),
            curve(1),
        )
        .shown_in(&["figure-12-similar"]),
    ])
}

/// Curves closer than this, as a share of the peak, lie on one another.
const COLLAPSED: f64 = 0.01;

fn percent(share: f64) -> String {
    if share < 1e-6 { "less than 1e-4 %".to_owned() } else { format!("{:.1} %", 100.0 * share) }
}

/// Whether a stated power of length is another than the one that follows.
fn law_differs(findings: &Findings<'_>) -> Result<bool> {
    let law = findings.setup.full_scale_law()?;
    for stated in &findings.setup.file.stated {
        if stated.power()? != tables::power_of_length(&law.rule(&stated.variable)?) {
            return Ok(true);
        }
    }
    Ok(false)
}

/// The page of the study.
pub(crate) fn page(findings: &Findings<'_>, claims: &[Claim], pictures: &[Picture]) -> Result<Page> {
    let setup = findings.setup;
    let mut page = Page::new("Chapter 2: when is a small model a model?");
    claims::begin(&mut page, claims, pictures.first());
    page.note(SURROGATE);
    page.paragraph(
        "A turbine of 7.5 m chord is tested as a model of 7.5 cm in water. Which speeds, masses and controller gains make the model \
         move like the machine, only faster? Dimensional analysis answers: those that leave every dimensionless group as it is.",
    );
    page.heading("Dimensionless groups");
    page.table(
        &tables::groups(&setup.plant, LISTED_15),
        "Plant: the groups of Table 1's variables, computed in exact arithmetic.",
    );
    page.paragraph(&findings.groups_sentence(&setup.plant, "(15)"));
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
    for picture in pictures.iter().skip(1) {
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
pub(crate) fn markdown(findings: &Findings<'_>, claims: &[Claim]) -> Result<String> {
    let setup = findings.setup;
    Ok(format!(
        "# Chapter 2: results\n\n\
         Written by `cargo xtask reproduce-chapter2`; `cargo xtask ci` fails when this page is not what the command finds.\n\
         {SURROGATE}\n\n{}\n\
         ## Dimensionless groups\n\n{}\n\n{}\n{}\n\n{}\n\
         ## The dissertation's Table 2, checked\n\n{}\n{SIMILARITY_CAPTION}\n\n{}\n{}\n\n{}\n{}\n\n\
         ## Figures 11 and 12\n\n{}\n\n{COLLAPSE_CAPTION}\n\n{}\n{}\n\n\
         ## What this does not show\n\n{BY_CONSTRUCTION}\n\n{REYNOLDS_CAPTION}\n\n{}\n\
         ## Scaling laws\n\n{LAW_CAPTION}\n\n{}\n{}\n\n\
         ## The rig at full scale, in air\n\n{}{}\n{}",
        claims::beginning(claims),
        findings.groups_sentence(&setup.plant, "(15)"),
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
