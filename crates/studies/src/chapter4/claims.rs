//! What Chapter 4 of the dissertation says, and whether it holds here.

use super::findings::Findings;
use super::rows::ERRORS;
use super::seeds::falls_pct;
use crate::claims::{Claim, Place, Verdict};
use page::Summary;

/// What a claim says first when there was nothing to find at either end.
const FITTED: &str = "Both ends of the path and their costs were calibrated; that the loop goes from the one towards the other is what came out.";

/// What the dissertation claims in this chapter, and what of it came out.
pub(crate) fn claims(findings: &Findings<'_>) -> Vec<Claim> {
    let fall = fall_words(findings);
    let between = |holds: bool| Verdict::in_kind_if(holds).between_fitted_ends();
    let falls = findings.printed().fall_pct() > 0.0;
    let mut claims = vec![
        Claim::new(
            Place::Contribution(1),
            "An iterative co-design framework that fuses experiments and simulations by gradients",
            between(falls),
            format!("`infuse::gradient::Loop` with the sign of (27) repaired. {FITTED} {fall}"),
        ),
        Claim::new(
            Place::Contribution(5),
            "It is validated on two parameters in the water channel",
            between(falls),
            format!("Against a stand-in, not in water. {FITTED} {fall}"),
        ),
        iterations(findings, &fall),
        Claim::new(
            Place::Figure(15),
            "The test: three speeds, three pulls at the port line",
            Verdict::TakenOver,
            "As printed in Section 3.2 and (22)-(26).".to_owned(),
        )
        .shown_in(&["figure-15-test-profile"]),
    ];
    claims.extend(errors(findings));
    claims
}

/// How far the experimental cost falls, without noise and with it.
fn fall_words(findings: &Findings<'_>) -> String {
    let rows = findings.printed();
    let first = findings.material.seeded.first();
    let over_seeds = first.and_then(|seeded| Summary::of(&falls_pct(findings.material.setup, seeded)));
    let over_seeds = over_seeds.map_or_else(String::new, |s| {
        format!(" Over {} noise seeds: median {:.1} %, worst {:.1} %.", s.count, s.median, s.minimum)
    });
    format!(
        "The experimental cost falls by {:.1} %, in the dissertation by {:.1} %, with {} experiments each.{over_seeds}",
        rows.fall_pct(),
        findings.published_fall_pct(),
        rows.n_experiments()
    )
}

/// The way of the optimum.
fn iterations(findings: &Findings<'_>, fall: &str) -> Claim {
    let (rows, published) = (findings.printed(), findings.published());
    let (first, last, theirs) = (rows.first(), rows.last(), &published[published.len() - 1]);
    let moves = |k: usize| {
        let published = theirs.point()[k] - published[0].point()[k];
        published * (last.point[k] - first.point[k]) > 0.0
    };
    Claim::new(
        Place::Table(3),
        "In three iterations the optimum moves aft and to a higher pitch, and the experimental cost falls",
        Verdict::in_kind_if(rows.fall_pct() > 0.0 && moves(0) && moves(1)).between_fitted_ends(),
        format!(
            "{FITTED} Last row: {}, in the dissertation {} and {}. {fall}",
            findings.material.setup.sentence(&last.point),
            theirs.center_of_mass,
            theirs.pitch_set_point
        ),
    )
    .shown_in(&["landscape-stand-in"])
}

/// Figures 16 to 18.
fn errors(findings: &Findings<'_>) -> [Claim; 3] {
    let (first, last) = (findings.printed().first(), findings.printed().last());
    ERRORS.map(|(what, number, error)| {
        let (before, after) = (first.mean_squared_deg2(error), last.mean_squared_deg2(error));
        Claim::new(
            Place::Figure(number as u8),
            &format!("The {what} error squared is smaller after infusion"),
            Verdict::in_kind_if(after < before),
            format!("Its mean is {before:.2} deg² before and {after:.2} deg² after."),
        )
        .shown_in(&[&format!("figure-{number}-{what}")])
    })
}
