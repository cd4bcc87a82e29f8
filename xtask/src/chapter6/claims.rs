//! What the dissertation says of this study, and whether it holds here.

use infuse::CorrectionLaw;

use super::tables::{Q2, digits};
use super::{Ended, Findings};
use crate::claims::{Claim, Place, Verdict};
use crate::gridded::{IterationAccuracy, NORMS};

/// Rounding, relative, that a bound may be exceeded by.
const ROUNDING: f64 = 1e-9;

/// Of a statement about all cases.
fn verdict(all: bool, some: bool) -> Verdict {
    match (all, some) {
        (true, _) => Verdict::Reproduced,
        (false, true) => Verdict::InKind,
        (false, false) => Verdict::NotReproduced,
    }
}

/// What the dissertation says of this study, and what of it came out.
pub(crate) fn claims(findings: &Findings) -> Vec<Claim> {
    let lawful: Vec<&Ended> = findings.ended.iter().filter(|ended| !is_literal(ended)).collect();
    let main: Vec<&Ended> = lawful.iter().copied().filter(|ended| ended.case.variant == 0).collect();
    vec![
        Claim::new(
            Place::Table(4),
            "Four parameters and their ranges",
            Verdict::TakenOver,
            "As printed, with the center of buoyancy at 45.4 % of chord and the first row's ends in order.".to_owned(),
        ),
        finite_bound(findings),
        proposition(&lawful),
        monotonic_errors(&lawful),
        shrinking(&main),
        best_design(&lawful),
        noise(findings),
        heading(findings),
        footprint(findings),
    ]
}

/// (36) to the letter is there to fail.
fn is_literal(ended: &Ended) -> bool {
    ended.campaign.settings().correction.law == CorrectionLaw::AsPrinted36
}

fn finite_bound(findings: &Findings) -> Claim {
    let norms = findings.ended.iter().flat_map(|ended| &ended.accuracy.iterations).flat_map(|i| &i.norms);
    let shares: Vec<f64> = norms.filter(|n| n.finite_bound > 0.0).map(|n| n.error / n.finite_bound).collect();
    let outside = shares.iter().filter(|share| **share > 1.0 + ROUNDING).count();
    let largest = shares.iter().copied().fold(0.0, f64::max);
    Claim::new(
        Place::Contribution(3),
        "A bound on the distance of the corrected model from the truth",
        verdict(outside == 0, outside < shares.len()),
        format!(
            "At every n and in all norms ({}) the error is inside the finite-iteration bound, which follows from the errors of \
             the surfaces: outside in {outside} of {} cases, largest part of the bound {:.1} %.",
            NORMS.join(", "),
            shares.len(),
            100.0 * largest
        ),
    )
}

fn proposition(lawful: &[&Ended]) -> Claim {
    let inside = |i: &IterationAccuracy| i.norms[Q2].error <= i.norms[Q2].proposition * (1.0 + ROUNDING);
    let all = || lawful.iter().flat_map(|ended| &ended.accuracy.iterations);
    let (n, n_inside) = (all().count(), all().filter(|i| inside(i)).count());
    let at_end = lawful.iter().filter(|ended| ended.accuracy.last().is_some_and(inside)).count();
    Claim::new(
        Place::Section("6.1".to_owned()),
        "In the limit it is at most 2 E1 + E2, (55)",
        verdict(at_end == lawful.len(), at_end > 0),
        format!(
            "With the errors of the iteration itself (q = 2) the right-hand side holds in {n_inside} of {n} iterations and at the \
             end of {at_end} of {} campaigns. It is a statement about the limit of errors that have settled; while the space \
             shrinks they have not.",
            lawful.len()
        ),
    )
}

fn monotonic_errors(lawful: &[&Ended]) -> Claim {
    let holds = |q: usize| lawful.iter().filter(|ended| ended.accuracy.assumption[q].holds()).count();
    let (q2, sup) = (holds(Q2), holds(2));
    Claim::new(
        Place::Section("6.1".to_owned()),
        "E1 and E2 fall from iteration to iteration, because the space shrinks (43), (44)",
        verdict(q2 == lawful.len() && sup == lawful.len(), q2 + sup >= lawful.len()),
        format!(
            "Never growing by more than 5 % above the least so far: in {q2} of {} campaigns for q = 2, in {sup} for q = ∞. Every \
             iteration fits anew, so an error may grow though the space shrinks; the finite bound needs no such assumption.",
            lawful.len()
        ),
    )
}

fn shrinking(main: &[&Ended]) -> Claim {
    let grows = main.iter().flat_map(|ended| &ended.accuracy.iterations).any(|i| i.share_after > i.share_before);
    let shares: Vec<String> = main
        .iter()
        .filter_map(|ended| {
            let last = ended.accuracy.last()?;
            Some(format!("{:.2} %", 100.0 * last.share_after))
        })
        .collect();
    let dropping: usize = main.iter().map(|ended| ended.accuracy.n_shrinking()).sum();
    let made: usize = main.iter().map(|ended| ended.accuracy.iterations.len()).sum();
    Claim::new(
        Place::Figure(20),
        "The design space shrinks monotonically, and much",
        Verdict::in_kind_if(!grows),
        format!(
            "It never grows, by construction; with the first gain {dropping} of {made} iterations drop a cell, and what is left at the end \
             is {}.",
            shares.join(", ")
        ),
    )
    .shown_in(&["figure-20-stand-in-for-the-water-channel"])
}

fn best_design(lawful: &[&Ended]) -> Claim {
    let dropped: Vec<usize> = lawful.iter().filter_map(|ended| ended.accuracy.best_dropped_at()).collect();
    let regrets = |dropped: bool| -> f64 {
        let of = lawful.iter().filter(|ended| ended.accuracy.best_dropped_at().is_some() == dropped);
        of.filter_map(|ended| ended.accuracy.last()).map(|last| last.regret).fold(0.0, f64::max)
    };
    Claim::new(
        Place::Section("5.5".to_owned()),
        "The z-test keeps what may be the optimum",
        verdict(dropped.is_empty(), dropped.len() < lawful.len()),
        format!(
            "The truly best cell is dropped in {} of {} campaigns, earliest at iteration {}. The largest regret at the end is {} s \
             where it was dropped and {} s where it was kept.",
            dropped.len(),
            lawful.len(),
            dropped.iter().min().map_or("–".to_owned(), ToString::to_string),
            digits(regrets(true)),
            digits(regrets(false))
        ),
    )
}

fn noise(findings: &Findings) -> Claim {
    let mut words = Vec::new();
    let (mut rising, mut all) = (0, 0);
    for space in 0..findings.setup.spaces.len() {
        for truth in 0..findings.setup.n_truths() {
            let errors: Vec<f64> = findings
                .main(space, truth)
                .iter()
                .filter_map(|ended| Some(ended.accuracy.last()?.norms[2].error))
                .collect();
            rising += errors.windows(2).filter(|pair| pair[0] <= pair[1]).count();
            all += errors.len().saturating_sub(1);
            let errors: Vec<String> = errors.iter().map(|error| digits(*error)).collect();
            words.push(format!(
                "{}, {}: {} s",
                findings.setup.spaces[space].entry.label,
                findings.setup.truth(truth).label,
                errors.join(", ")
            ));
        }
    }
    let shares: Vec<String> =
        findings.setup.file.noise.shares.iter().map(|share| format!("{}", 100.0 * share)).collect();
    Claim::new(
        Place::Figure(21),
        "Low noise and a good fit bring the corrected model close to the truth",
        verdict(rising == all, rising > 0),
        format!(
            "Largest error over what is left at the end (q = ∞) for noise {} %: {}. The error grows with the noise in {rising} of \
             {all} steps; what the regressor cannot follow stays without any noise.",
            shares.join(", "),
            words.join("; ")
        ),
    )
    .shown_in(&["figure-21-2-parameters-stand-in-for-the-water-channel", "figure-21-4-parameters-stand-in-for-the-water-channel"])
}

fn heading(findings: &Findings) -> Claim {
    let pairs: Vec<(f64, f64)> =
        findings.footprints.iter().map(|pair| (pair.designs[0].heading_deg2, pair.designs[1].heading_deg2)).collect();
    let better = pairs.iter().filter(|(first, last)| last < first).count();
    let words: Vec<String> = pairs.iter().map(|(first, last)| format!("{first:.2} → {last:.2}")).collect();
    Claim::new(
        Place::Figure(22),
        "The heading is significantly better at the last optimum than at the first",
        Verdict::in_kind_if(2 * better >= pairs.len()),
        format!("Mean heading error squared, first → last optimum, in deg²: {}.", words.join(", ")),
    )
    .shown_in(&["figure-22-2-parameters", "figure-22-4-parameters"])
}

fn footprint(findings: &Findings) -> Claim {
    let pairs: Vec<(f64, f64)> =
        findings.footprints.iter().map(|pair| (pair.designs[0].footprint_m2, pair.designs[1].footprint_m2)).collect();
    let smaller = pairs.iter().filter(|(first, last)| last < first).count();
    let words: Vec<String> = pairs.iter().map(|(first, last)| format!("{first:.4} → {last:.4}")).collect();
    Claim::new(
        Place::Section("6.2.2".to_owned()),
        "The footprint on the ground is slightly reduced",
        Verdict::in_kind_if(2 * smaller >= pairs.len()),
        format!("Mean footprint, first → last optimum, in m²: {}.", words.join(", ")),
    )
}
