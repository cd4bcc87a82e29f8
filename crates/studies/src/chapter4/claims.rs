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
    let rows = findings.printed();
    let (first, last) = (rows.first(), rows.last());
    let (theirs, published) = (findings.published_fall_pct(), findings.published());
    let falls = rows.fall_pct() > 0.0;
    let moves = |k: usize| {
        let theirs = published[published.len() - 1].point()[k] - published[0].point()[k];
        theirs * (last.point[k] - first.point[k]) > 0.0
    };
    let seeds: Vec<String> = findings
        .material
        .seeded
        .first()
        .and_then(|seeded| Some((seeded, Summary::of(&falls_pct(findings.material.setup, seeded))?)))
        .map(|(_, s)| format!(" Over {} noise seeds: median {:.1} %, worst {:.1} %.", s.count, s.median, s.minimum))
        .into_iter()
        .collect();
    let fall = format!(
        "The experimental cost falls by {:.1} %, in the dissertation by {theirs:.1} %, with {} experiments each.{}",
        rows.fall_pct(),
        rows.n_experiments(),
        seeds.concat()
    );
    let short =
        format!("the experimental cost falls by {:.1} %, in the dissertation by {theirs:.1} %", rows.fall_pct());
    let between = |holds: bool| Verdict::in_kind_if(holds).between_fitted_ends();
    let mut claims = vec![
        Claim::new(
            Place::Contribution(1),
            "An iterative co-design framework that fuses experiments and simulations by gradients",
            between(falls),
            format!("`infuse::gradient::Loop` with the sign of (27) repaired. {FITTED} {fall}"),
        )
        .in_short(&*short),
        Claim::new(
            Place::Contribution(5),
            "It is validated on two parameters in the water channel",
            between(falls),
            format!("Against a stand-in, not in water. {FITTED} {fall}"),
        )
        .in_short(&*short),
        Claim::new(
            Place::Table(3),
            "In three iterations the optimum moves aft and to a higher pitch, and the experimental cost falls",
            between(falls && moves(0) && moves(1)),
            format!(
                "{FITTED} Last row: {}, in the dissertation {} and {}. {fall}",
                findings.material.setup.sentence(&last.point),
                published[published.len() - 1].center_of_mass,
                published[published.len() - 1].pitch_set_point
            ),
        )
        .in_short(format!(
            "to {:.2} % chord and {:.2} deg, {:.1} % less; in the dissertation {} and {}, {theirs:.1} % less",
            last.point[0],
            last.point[1],
            rows.fall_pct(),
            published[published.len() - 1].center_of_mass,
            published[published.len() - 1].pitch_set_point
        ))
        .shown_in(&["landscape-stand-in"]),
        Claim::new(
            Place::Figure(15),
            "The test: three speeds, three pulls at the port line",
            Verdict::TakenOver,
            "As printed in Section 3.2 and (22)-(26).".to_owned(),
        )
        .shown_in(&["figure-15-test-profile"]),
    ];
    claims.extend(ERRORS.map(|(what, number, error)| {
        let (before, after) = (first.mean_squared_deg2(error), last.mean_squared_deg2(error));
        Claim::new(
            Place::Figure(number as u8),
            &format!("The {what} error squared is smaller after infusion"),
            Verdict::in_kind_if(after < before),
            format!("Its mean is {before:.2} deg² before and {after:.2} deg² after."),
        )
        .in_short(format!("mean {before:.2} → {after:.2} deg²"))
        .shown_in(&[&format!("figure-{number}-{what}")])
    }));
    claims
}
