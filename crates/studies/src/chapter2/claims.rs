//! What Chapter 2 of the dissertation says, and whether it holds here.

use anyhow::Result;

use super::file::Analysis;
use super::findings::{Findings, REPAIRED_19, power_of_length};
use super::models::{Case, Releases};
use crate::claims::{Claim, Place};
use crate::rules::{Count, Judged, Standing};

/// What the dissertation claims in this chapter, and what of it came out.
pub(crate) fn claims(findings: &Findings<'_>) -> Result<Vec<Claim>> {
    let setup = findings.setup;
    let same = |analysis: &Analysis| analysis.groups.span_same_space(&analysis.listed);
    let theory = |holds: bool| Judged::of(Count::one(holds), Standing::Theory);
    let in_kind = |holds: bool| Judged::of(Count::one(holds), Standing::StandIn);
    // Of similar models by construction: the equations that fly here have no viscosity.
    let sure = |holds: bool| Judged::of(Count::one(holds), Standing::Sure);
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
    let n_checked = setup.plant.groups.len() - findings.similarity.unchecked().len();
    let n_agreeing = n_laws_that_agree(findings)?;
    let groups = |analysis: &Analysis| format!("{} computed, {} listed", analysis.groups.len(), analysis.listed.len());
    let apart_words = |k: usize| {
        format!(
            "{} of the peak apart if similar, {:.0} % with the printed masses",
            percent(similar[k]),
            100.0 * printed[k]
        )
    };
    Ok(vec![
        Claim::new(
            Place::Contribution(4),
            "Dynamic equivalence between the full-scale and the lab-scale system",
            sure(same(&setup.plant) && flights < COLLAPSED),
            format!(
                "The closed-loop test flown with the laboratory's files and with the converted ones differs in dimensionless form by \
                 {} of the peak. Reynolds number and turbulence are outside of this similarity, in the dissertation and here.",
                percent(flights)
            ),
        )
        .in_short(format!("{} of the peak apart in dimensionless form", percent(flights))),
        Claim::new(
            Place::Table(1),
            "The variables of Table 1 give the 11 groups (15)",
            theory(same(&setup.plant)),
            findings.groups_sentence(&setup.plant, "(15)"),
        )
        .in_short(groups(&setup.plant)),
        Claim::new(
            Place::Section("2.4.2".to_owned()),
            "The controller's variables give the 8 groups of (19)",
            in_kind(same(&setup.controller)),
            findings.groups_sentence(&setup.controller, REPAIRED_19),
        )
        .in_short(groups(&setup.controller)),
        Claim::new(
            Place::Section("2.4".to_owned()),
            "How speeds, times and gains go with the length",
            Judged::of(Count { holding: n_agreeing, cases: setup.file.stated.len() }, Standing::Theory),
            findings.law_sentence()?,
        )
        .in_short(format!("{n_agreeing} of {} stated powers of length follow", setup.file.stated.len())),
        Claim::new(
            Place::Table(2),
            "Three scale models match in every group",
            theory(mismatches == 0),
            findings.mismatch_sentence(),
        )
        .in_short(format!("{mismatches} of the {} groups that Table 2 determines does not match", n_checked)),
        Claim::new(
            Place::Figure(11),
            "The heading of three scale models collapses against normalized time",
            sure(similar[0] < COLLAPSED),
            curve(0),
        )
        .in_short(apart_words(0))
        .shown_in(&["figure-11-similar"]),
        Claim::new(
            Place::Figure(12),
            "So does the lateral position, normalized",
            sure(similar[1] < COLLAPSED),
            curve(1),
        )
        .in_short(apart_words(1))
        .shown_in(&["figure-12-similar"]),
    ])
}

/// Curves closer than this, as a share of the peak, lie on one another.
pub(crate) const COLLAPSED: f64 = 0.01;

pub(crate) fn percent(share: f64) -> String {
    if share < 1e-6 { "less than 1e-4 %".to_owned() } else { format!("{:.1} %", 100.0 * share) }
}

/// How many of the stated powers of length are those that follow.
pub(crate) fn n_laws_that_agree(findings: &Findings<'_>) -> Result<usize> {
    let law = findings.setup.full_scale_law()?;
    let mut n = 0;
    for stated in &findings.setup.file.stated {
        n += usize::from(stated.power()? == power_of_length(&law.rule(&stated.variable)?));
    }
    Ok(n)
}
