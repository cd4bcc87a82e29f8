//! What a run of Chapter 2 found, in numbers and in sentences made of them.

use anyhow::{Context as _, Result};
use scaling::{BigRational, Remedies, Similarity};

use super::file::{Analysis, Setup, Stated};
use super::full_scale::FullScale;
use super::models::{Case, Releases};

/// Everything that the study found.
pub(crate) struct Findings<'a> {
    pub(crate) setup: &'a Setup,
    pub(crate) similarity: Similarity,
    /// The masses that would match, with the tether as the length and with the chord.
    pub(crate) remedies: [Remedies; 2],
    /// Each case of flights.
    pub(crate) releases: Vec<Releases>,
    /// Models of the printed masses in hulls similar to the reference's: displaced mass, and why they cannot fly.
    pub(crate) in_similar_hulls: Vec<(f64, Option<String>)>,
    pub(crate) full_scale: FullScale,
    pub(crate) seconds: f64,
}

pub(crate) const REPAIRED_19: &str = "(19), its slips repaired (t_bar/tau_z in place of V/tau_z, which is not dimensionless, and V/k_p,phi, which is \
    missing; t_bar = L_t/V),";

impl Findings<'_> {
    pub(crate) fn releases(&self, case: Case) -> Option<&Releases> {
        self.releases.iter().find(|releases| releases.case == case)
    }

    pub(crate) fn groups_sentence(&self, analysis: &Analysis, equation: &str) -> String {
        let system = &analysis.system;
        let same = analysis.groups.span_same_space(&analysis.listed);
        format!(
            "{} variables of rank {} leave {} groups. With {} repeating the computed ones and the {} listed in {equation} {}. {} \
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

    pub(crate) fn mismatch_sentence(&self) -> String {
        let named: Vec<String> = self
            .similarity
            .mismatches()
            .map(|row| {
                let values: Vec<String> = row.values.iter().map(|value| significant(*value, 4)).collect();
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
    pub(crate) fn hull_sentence(&self) -> String {
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
    pub(crate) fn release_sentence(&self) -> String {
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
    pub(crate) fn honest_paragraph(&self) -> String {
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
    pub(crate) fn printed_full_scale(&self) -> Result<Vec<String>> {
        let mut sentences = Vec::new();
        for printed in &self.setup.file.printed_full_scale {
            let units = &self.setup.units;
            let converted = self.full_scale.rig().converted.iter().find(|number| number.path == printed.key);
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

    pub(crate) fn full_scale_sentences(&self) -> Vec<String> {
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
                power_above(flight.largest_difference)
                    .map_or_else(|| "nothing".to_owned(), |power| format!("less than {power}"))
            ));
        }
        sentences
    }

    pub(crate) fn law_sentence(&self) -> Result<String> {
        let law = self.setup.full_scale_law()?;
        let (mut agreeing, mut differing) = (0, Vec::new());
        for stated in &self.setup.file.stated {
            let power = power_of_length(&law.rule(&stated.variable)?);
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

/// The power of length in a law, at one gravity and in one fluid.
pub(crate) fn power_of_length(rule: &scaling::Rule) -> BigRational {
    let zero = || BigRational::from_integer(0.into());
    rule.exponents.iter().find(|(name, _)| name == "L_t").map_or_else(zero, |(_, power)| power.clone())
}

/// A rounding error to its power of ten: its digits are nobody's business and differ between builds.
pub(crate) fn magnitude(value: f64) -> String {
    power_above(value).map_or_else(|| "0".to_owned(), |power| format!("below {power}"))
}

/// The power of ten that a positive value is not above.
fn power_above(value: f64) -> Option<String> {
    (value > 0.0).then(|| format!("1e{:.0}", value.log10().ceil()))
}

/// A number with some significant digits.
pub(crate) fn significant(value: f64, digits: i32) -> String {
    let order = if value == 0.0 { 0 } else { value.abs().log10().floor() as i32 };
    if (-4..=6).contains(&order) {
        format!("{value:.*}", (digits - 1 - order).max(0) as usize)
    } else {
        format!("{value:.*e}", (digits - 1).max(0) as usize)
    }
}
