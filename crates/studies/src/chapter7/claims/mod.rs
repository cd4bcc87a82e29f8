//! What Chapter 7 says of its results, and whether it holds here.

mod designs;
mod flown;
mod shrinking;
mod votes;
mod words;

pub(super) use designs::last_row_words;

use super::file::Case;
use super::findings::{Findings, Found};
use crate::claims::{Claim, Place};
use crate::rules::{Count, Judged, Standing};

/// What the dissertation says of its results, and what of it came out.
pub(crate) fn all(findings: &Findings) -> Vec<Claim> {
    let mut all = Vec::new();
    for (case, found) in findings.cases() {
        for claim in claims(case, found, findings.noise_s(found)) {
            let says = format!("{}: {}", case.entry.label, claim.says);
            all.push(Claim { says, ..claim });
        }
    }
    all.push(framework(findings));
    all.extend(findings.cases().filter_map(|(case, found)| keeps_best(case, found)));
    all
}

fn claims(case: &Case, found: &Found, noise_s: f64) -> Vec<Claim> {
    let mut all = vec![shrinking::every_iteration(case, found)];
    // Section 7.1 and Figure 23 are about two parameters.
    if case.space.variables.len() == 2 {
        all.push(shrinking::designs(case, found));
        all.push(shrinking::first_shrinks_less(case, found));
        all.push(shrinking::noise_limits(case, found, noise_s));
    }
    all.extend(designs::aft(case, found));
    all.push(designs::numerical_row(case, found));
    all.extend(designs::last_row(case, found));
    all.push(designs::system(case, found));
    all.extend(flown::flights(case, found));
    all
}

/// The loop as such: that it ends with a better design than it began with, judged where no end of it was fitted.
fn framework(findings: &Findings) -> Claim {
    let better = |found: &Found| -> Vec<bool> {
        let runs = found.main();
        let campaigns = std::iter::once(&runs.quiet).chain(&runs.noisy);
        campaigns.map(|steps| steps.0.last().is_some_and(|step| step.cost < found.numerical_true_cost)).collect()
    };
    let of = |are_fitted: bool| -> Vec<bool> {
        let cases = findings.cases().filter(|(case, _)| case.ends_are_fitted() == are_fitted);
        cases.flat_map(|(_, found)| better(found)).collect()
    };
    let (free, fitted) = (of(false), of(true));
    let chances: Vec<f64> = findings
        .cases()
        .filter(|(case, _)| !case.ends_are_fitted())
        .map(|(_, found)| found.flights.blind.share(|(_, means)| means.cost < found.numerical_true_cost))
        .collect();
    let by_chance = chances.iter().sum::<f64>() / chances.len() as f64;
    let words = |better: &[bool]| format!("{} of {}", votes::count(better), better.len());
    Claim::new(
        Place::Contribution(2),
        "A global framework of optimal designs, response surfaces and hypothesis tests",
        Judged::of(Count::of(free.iter().copied()), Standing::StandIn).beside(by_chance),
        format!(
            "`infuse::global::Loop` with (36) repaired ends truly better than the numerical model alone in {} campaigns whose ends were not \
             calibrated, which decide here, and in {} between calibrated ends.",
            words(&free),
            words(&fitted)
        ),
    )
    .in_short(format!("truly better in {} campaigns whose ends were not calibrated", words(&free)))
}

/// The test of Section 5.5, where the wrong choices are compared: the loop as it is comes first.
fn keeps_best(case: &Case, found: &Found) -> Option<Claim> {
    let own = found.choices.first()?;
    let says = if case.space.variables.len() == 2 {
        "The z-test at 90 % keeps what may be the optimum, with the settings of Chapter 7".to_owned()
    } else {
        format!("{}: the z-test at 90 % keeps what may be the optimum", case.entry.label)
    };
    Some(shrinking::keeps_best(&says, own.regrets.len(), own.lost?, own.left?))
}
