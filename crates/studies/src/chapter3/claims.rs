//! What Chapter 3 of the dissertation says, and whether it holds here.

use super::findings::{Findings, spans};
use crate::claims::{Claim, Place};
use crate::rules::{Count, Judged, Standing};

/// What the dissertation claims in this chapter, and what of it came out.
pub(crate) fn claims(findings: &Findings<'_>) -> Vec<Claim> {
    let spans = spans(findings);
    let depends = spans.iter().filter(|span| **span > MATTERS).count();
    let panels = Count { holding: depends, cases: findings.stand_in.len() };
    let words: Vec<String> = spans.iter().map(|span| format!("{span:.1}")).collect();
    let claim = Claim::new(
        Place::Figure(14),
        "In each of four configurations the open-loop cost depends on trim pitch and center of mass",
        Judged::of(panels, Standing::StandIn),
        format!(
            "In the stand-in the highest cost of the stable designs within Table 4 is {} times the lowest, panel by panel. The figure \
             prints no numbers that could be compared.",
            words.join(", ")
        ),
    );
    let short = format!("the highest cost is {} times the lowest", words.join(", "));
    vec![claim.in_short(short).shown_in(&["figure-14"])]
}

/// A cost that varies by less than this factor would depend on nothing.
pub(crate) const MATTERS: f64 = 1.5;
