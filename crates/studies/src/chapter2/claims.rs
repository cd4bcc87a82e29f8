//! What Chapter 2 of the dissertation says, and whether it holds here.

use anyhow::Result;

use super::file::Analysis;
use super::findings::{Findings, REPAIRED_19, power_of_length};
use super::models::{Case, Releases};
use crate::claims::{Claim, Place};
use crate::rules::{Count, Judged, Standing};

/// What the dissertation claims in this chapter, and what of it came out.
pub(crate) fn claims(findings: &Findings<'_>) -> Result<Vec<Claim>> {
    let apart = Apart::of(findings);
    let heading = (Place::Figure(11), "The heading of three scale models collapses against normalized time");
    let lateral = (Place::Figure(12), "So does the lateral position, normalized");
    Ok(vec![
        equivalence(findings),
        groups_of_the_plant(findings),
        groups_in_normalized_time(findings),
        groups_of_the_controller(findings),
        powers_of_length(findings)?,
        scale_models(findings),
        apart.claim(0, heading).shown_in(&["figure-11-similar"]),
        apart.claim(1, lateral).shown_in(&["figure-12-similar"]),
    ])
}

fn theory(holds: bool) -> Judged {
    Judged::of(Count::one(holds), Standing::Theory)
}

/// Of similar models by construction: the equations that fly here have no viscosity.
fn sure(holds: bool) -> Judged {
    Judged::of(Count::one(holds), Standing::Sure)
}

/// Whether the groups that are listed say the same as those that follow.
fn is_same(analysis: &Analysis) -> bool {
    analysis.groups.span_same_space(&analysis.listed)
}

fn in_numbers(analysis: &Analysis) -> String {
    format!("{} computed, {} listed", analysis.groups.len(), analysis.listed.len())
}

fn equivalence(findings: &Findings<'_>) -> Claim {
    let flights = findings.full_scale.flights.iter().map(|flight| flight.largest_difference).fold(0.0, f64::max);
    Claim::new(
        Place::Contribution(4),
        "Dynamic equivalence between the full-scale and the lab-scale system",
        sure(is_same(&findings.setup.plant) && flights < COLLAPSED),
        format!(
            "The closed-loop test flown with the laboratory's files and with the converted ones differs in dimensionless form by \
             {} of the peak. Reynolds number and turbulence are outside of this similarity, in the dissertation and here.",
            percent(flights)
        ),
    )
    .in_short(format!("{} of the peak apart in dimensionless form", percent(flights)))
}

fn groups_of_the_plant(findings: &Findings<'_>) -> Claim {
    let plant = &findings.setup.plant;
    Claim::new(
        Place::Table(1),
        "The variables of Table 1 give the 11 groups (15)",
        theory(is_same(plant)),
        findings.groups_sentence(plant, "(15)"),
    )
    .in_short(in_numbers(plant))
}

fn groups_in_normalized_time(findings: &Findings<'_>) -> Claim {
    let stretched = &findings.setup.normalized_time;
    Claim::new(
        Place::Section("2.4.1".to_owned()),
        "In normalized time they give the 12 groups (17)",
        theory(is_same(stretched)),
        findings.groups_sentence(stretched, "(17)"),
    )
    .in_short(in_numbers(stretched))
}

fn groups_of_the_controller(findings: &Findings<'_>) -> Claim {
    let controller = &findings.setup.controller;
    Claim::new(
        Place::Section("2.4.2".to_owned()),
        "The controller's variables give the 8 groups of (19)",
        Judged::of(Count::one(is_same(controller)), Standing::StandIn),
        findings.groups_sentence(controller, REPAIRED_19),
    )
    .in_short(in_numbers(controller))
}

fn powers_of_length(findings: &Findings<'_>) -> Result<Claim> {
    let count = Count { holding: n_laws_that_agree(findings)?, cases: findings.setup.file.stated.len() };
    let claim = Claim::new(
        Place::Section("2.4".to_owned()),
        "How speeds, times and gains go with the length",
        Judged::of(count, Standing::Theory),
        findings.law_sentence()?,
    );
    Ok(claim.in_short(format!("{count} stated powers of length follow")))
}

fn scale_models(findings: &Findings<'_>) -> Claim {
    let mismatches = findings.similarity.mismatches().count();
    let n_checked = findings.setup.plant.groups.len() - findings.similarity.unchecked().len();
    Claim::new(
        Place::Table(2),
        "Three scale models match in every group",
        theory(mismatches == 0),
        findings.mismatch_sentence(),
    )
    .in_short(format!("{mismatches} of the {n_checked} groups that Table 2 determines does not match"))
}

/// How far the curves of the models are apart against normalized time, heading and lateral position, as shares of the peak.
struct Apart {
    similar: [f64; 2],
    printed: [f64; 2],
}

impl Apart {
    fn of(findings: &Findings<'_>) -> Self {
        let of = |case: Case| {
            let departures = findings.releases(case).map(Releases::apart_when_normalized);
            departures.map_or([f64::INFINITY; 2], |apart| [apart.heading, apart.lateral])
        };
        Self { similar: of(Case::Similar), printed: of(Case::PrintedMasses) }
    }

    /// That the curves of heading (0) or lateral position (1) collapse.
    fn claim(&self, k: usize, (place, says): (Place, &str)) -> Claim {
        let (similar, printed) = (percent(self.similar[k]), 100.0 * self.printed[k]);
        Claim::new(
            place,
            says,
            sure(self.similar[k] < COLLAPSED),
            format!(
                "Against normalized time the curves of models 1 and 3 are within {similar} of that of model 2, as a share of its peak, if \
                 the models are similar; with the printed masses within {printed:.0} %."
            ),
        )
        .in_short(format!("{similar} of the peak apart if similar, {printed:.0} % with the printed masses"))
    }
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
