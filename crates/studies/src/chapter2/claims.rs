//! What Chapter 2 of the dissertation says, and whether it holds here.

use anyhow::Result;

use super::file::Analysis;
use super::findings::{Findings, REPAIRED_19, power_of_length};
use super::models::{Case, Releases};
use crate::claims::{Claim, Place, Verdict};

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
pub(crate) const COLLAPSED: f64 = 0.01;

pub(crate) fn percent(share: f64) -> String {
    if share < 1e-6 { "less than 1e-4 %".to_owned() } else { format!("{:.1} %", 100.0 * share) }
}

/// Whether a stated power of length is another than the one that follows.
pub(crate) fn law_differs(findings: &Findings<'_>) -> Result<bool> {
    let law = findings.setup.full_scale_law()?;
    for stated in &findings.setup.file.stated {
        if stated.power()? != power_of_length(&law.rule(&stated.variable)?) {
            return Ok(true);
        }
    }
    Ok(false)
}
