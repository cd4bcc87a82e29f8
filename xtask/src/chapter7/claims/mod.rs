//! What Chapter 7 says of its results, and whether it holds here.

use super::campaigns::{Runs, Steps};
use super::file::{Case, Standing};
use super::flights::Means;
use super::{Findings, Found};
use crate::claims::{Claim, Place, Verdict};
use crate::figures::Summary;
use crate::study::Variable;

/// An improvement is called great, significant or much when what is left is at most this part.
const GREATLY: f64 = 0.5;

/// What the dissertation says of its results, and what of it came out.
pub(crate) fn all(findings: &Findings) -> Vec<Claim> {
    let mut all = Vec::new();
    for (case, found) in findings.cases() {
        for claim in claims(case, found) {
            let says = format!("{}: {}", case.entry.label, claim.says);
            all.push(Claim { says, ..claim });
        }
    }
    all.push(framework(findings));
    all
}

/// The loop as such: that it ends with a better design than it began with, in every study and seed.
fn framework(findings: &Findings) -> Claim {
    let ends = |found: &Found| {
        let runs = found.main();
        let before = found.numerical_true_cost;
        std::iter::once(&runs.quiet)
            .chain(&runs.noisy)
            .map(|steps| steps.0.last().is_some_and(|step| step.cost < before))
            .collect::<Vec<_>>()
    };
    let better: Vec<bool> = findings.cases().flat_map(|(_, found)| ends(found)).collect();
    let n = better.iter().filter(|better| **better).count();
    Claim::new(
        Place::Contribution(2),
        "A global framework of optimal designs, response surfaces and hypothesis tests",
        Verdict::in_kind_of(n, better.len()),
        format!(
            "`infuse::GlobalLoop` with (36) mended ends truly better than the numerical model alone in {n} of {} campaigns.",
            better.len()
        ),
    )
}

/// A yes or no without noise, and how often with it.
struct Votes {
    quiet: bool,
    noisy: Vec<bool>,
}

impl Votes {
    fn of<T>(quiet: &T, noisy: &[T], holds: impl Fn(&T) -> bool) -> Self {
        Self { quiet: holds(quiet), noisy: noisy.iter().map(holds).collect() }
    }

    fn n_holding(&self) -> usize {
        self.noisy.iter().filter(|holds| **holds).count()
    }

    /// It holds if it does without noise and for nine in ten seeds, in part if it ever does.
    fn verdict(&self) -> Verdict {
        let n = self.n_holding();
        match (self.quiet, 10 * n >= 9 * self.noisy.len()) {
            (true, true) => Verdict::InKind,
            _ if self.quiet || n > 0 => Verdict::InPart,
            _ => Verdict::NotReproduced,
        }
    }

    /// The same as the beginning of a sentence.
    fn sentence(&self) -> String {
        self.words().replacen("it ", "It ", 1)
    }

    fn words(&self) -> String {
        let (n, all) = (self.n_holding(), self.noisy.len());
        if self.quiet {
            format!("it holds without noise, and for {n} of {all} seeds")
        } else {
            format!("it does not hold without noise; it holds for {n} of {all} seeds")
        }
    }
}

fn claims(case: &Case, found: &Found) -> Vec<Claim> {
    let mut all = vec![shrinks(case, found), first_shrinks_less(case, found)];
    if case.space.variables.len() == 2 {
        all.push(third_hardly_shrinks(found));
    }
    all.extend(aft(case, found));
    all.push(numerical_row(case, found));
    all.push(system(found));
    all.extend(flights(case, found));
    all
}

fn table_place(case: &Case) -> Place {
    Place::Table(u8::try_from(case.entry.table).unwrap_or_default())
}

/// The designs of two parameters, iteration by iteration.
fn shares_picture(case: &Case) -> Vec<String> {
    if case.space.variables.len() == 2 { vec!["figure-23".to_owned()] } else { Vec::new() }
}

/// Shares from before the first iteration on.
fn shares(steps: &Steps) -> Vec<f64> {
    std::iter::once(100.0).chain(steps.0.iter().map(|step| step.share)).collect()
}

fn share_words(steps: &Steps) -> String {
    let words: Vec<String> = steps.0.iter().map(|step| format!("{:.2}", step.share)).collect();
    format!("{} %", words.join(", "))
}

/// Per cent of the original space that iteration `n` drops; none if it was not made.
fn dropped(steps: &Steps, n: usize) -> Option<f64> {
    let shares = shares(steps);
    Some(shares.get(n - 1)? - shares.get(n)?)
}

fn shrinks(case: &Case, found: &Found) -> Claim {
    let runs = found.main();
    let votes = Votes::of(&runs.quiet, &runs.noisy, |steps| shares(steps).windows(2).all(|pair| pair[1] < pair[0]));
    let published: Vec<String> = case.published.iter().skip(1).map(|row| format!("{:.2}", row.share)).collect();
    let pairs =
        || runs.noisy.iter().flat_map(|steps| shares(steps).windows(2).map(|p| p[1] < p[0]).collect::<Vec<_>>());
    let (dropping, made) = (pairs().filter(|drops| *drops).count(), pairs().count());
    let other = |runs: &Runs| format!("; {}: {}", runs.label, share_words(&runs.quiet));
    let others: Vec<String> = found.runs.iter().skip(1).map(other).collect();
    Claim {
        place: table_place(case),
        pictures: shares_picture(case),
        says: "the design space shrinks at every iteration".to_owned(),
        verdict: votes.verdict(),
        found: format!(
            "{}; {dropping} of {made} iterations with noise drop a cell. Left without noise: {}; published: {} %{}.",
            votes.sentence(),
            share_words(&runs.quiet),
            published.join(", "),
            others.concat()
        ),
    }
}

fn first_shrinks_less(case: &Case, found: &Found) -> Claim {
    let runs = found.main();
    let less = |steps: &Steps| matches!((dropped(steps, 1), dropped(steps, 2)), (Some(a), Some(b)) if a < b);
    let votes = Votes::of(&runs.quiet, &runs.noisy, less);
    let median = |n| {
        let values: Vec<f64> = runs.noisy.iter().filter_map(|steps| dropped(steps, n)).collect();
        Summary::of(&values).map_or("–".to_owned(), |summary| format!("{:.2}", summary.median))
    };
    let published = |n: usize| match (case.published.get(n - 1), case.published.get(n)) {
        (Some(before), Some(after)) => format!("{:.2}", before.share - after.share),
        _ => "–".to_owned(),
    };
    Claim {
        place: Place::Section("7.1".to_owned()),
        pictures: Vec::new(),
        says: "the first iteration shrinks the space less than the second, because the model is not corrected yet"
            .to_owned(),
        verdict: votes.verdict(),
        found: format!(
            "{}. Dropped by the first and the second iteration, in % of the original space: median {} and {}; published {} and {}.",
            votes.sentence(),
            median(1),
            median(2),
            published(1),
            published(2)
        ),
    }
}

fn third_hardly_shrinks(found: &Found) -> Claim {
    let runs = found.main();
    let less = |steps: &Steps| matches!((dropped(steps, 2), dropped(steps, 3)), (Some(a), Some(b)) if b < GREATLY * a);
    let votes = Votes::of(&runs.quiet, &runs.noisy, less);
    let values: Vec<f64> = runs.noisy.iter().filter_map(|steps| dropped(steps, 3)).collect();
    let median = Summary::of(&values).map_or("–".to_owned(), |summary| format!("{:.2}", summary.median));
    Claim {
        place: Place::Section("7.1".to_owned()),
        pictures: Vec::new(),
        says: "from the third iteration on noise limits further reduction".to_owned(),
        verdict: votes.verdict(),
        found: format!(
            "If the third iteration drops less than half of what the second does: {}. The third drops {median} % \
             of the original space in the median; published 1.19.",
            votes.words()
        ),
    }
}

fn aft(case: &Case, found: &Found) -> Option<Claim> {
    let k = case.space.variables.iter().position(|variable| *variable == Variable::CenterOfMass)?;
    let runs = found.main();
    let start = found.numerical.point[k];
    let end = |steps: &Steps| steps.0.last().map_or(f64::NAN, |step| step.point[k]);
    let votes = Votes::of(&runs.quiet, &runs.noisy, |steps| end(steps) > start);
    let median = Summary::of(&runs.noisy.iter().map(end).collect::<Vec<_>>()).map_or(f64::NAN, |s| s.median);
    let published = |row: Option<&super::file::Row>| row.map_or(f64::NAN, |row| row.point[k]);
    Some(Claim {
        place: table_place(case),
        pictures: Vec::new(),
        says: "infusion moves the center of mass aft".to_owned(),
        verdict: votes.verdict(),
        found: format!(
            "{}: from {start:.2} % of chord (numerical optimum) to {:.2} without noise, {median:.2} in the median; published {:.2} to \
             {:.2}.",
            votes.sentence(),
            end(&runs.quiet),
            published(case.published.first()),
            published(case.published.last())
        ),
    })
}

/// Within this part of each parameter's width a design counts as the published one.
const NEAR: f64 = 0.1;

fn numerical_row(case: &Case, found: &Found) -> Claim {
    let parameters = case.space.region().parameters();
    let departures: Vec<f64> = case
        .published
        .first()
        .into_iter()
        .flat_map(|row| row.point.iter().zip(&found.numerical.point).zip(parameters))
        .map(|((theirs, ours), parameter)| (theirs - ours).abs() / (parameter.upper() - parameter.lower()))
        .collect();
    let near = departures.iter().filter(|departure| **departure <= NEAR).count();
    let standing = case.published.first().map_or("", |row| row.standing.words());
    let words: Vec<String> = departures.iter().map(|departure| format!("{:.0}", 100.0 * departure)).collect();
    Claim {
        place: table_place(case),
        pictures: Vec::new(),
        says: "the numerical optimum is row 0".to_owned(),
        verdict: match case.published.first() {
            Some(row) if row.standing != Standing::Predicted => Verdict::Calibrated,
            _ => Verdict::in_kind_of(near, departures.len()),
        },
        found: format!(
            "{} here ({standing}); departures {} % of the parameters' widths. Up to {:.0} % counts as near: {near} of {} are.",
            super::tables::point_words(case, &found.numerical.point),
            words.join(", "),
            100.0 * NEAR,
            departures.len()
        ),
    }
}

fn system(found: &Found) -> Claim {
    let runs = found.main();
    let before = found.numerical_true_cost;
    let end = |steps: &Steps| steps.0.last().map_or(f64::NAN, |step| step.cost);
    let votes = Votes::of(&runs.quiet, &runs.noisy, |steps| end(steps) < before);
    let median = Summary::of(&runs.noisy.iter().map(end).collect::<Vec<_>>()).map_or(f64::NAN, |s| s.median);
    let fall = |after: f64| 100.0 * (1.0 - after / before);
    Claim {
        place: Place::Contribution(6),
        pictures: Vec::new(),
        says: "infusion gives a better system than the numerical model alone".to_owned(),
        verdict: votes.verdict(),
        found: format!(
            "{}: true cost {before:.3} s at the numerical optimum, {:.3} s at the infused one without noise (a fall of {:.1} %), {median:.3} \
             s in the median ({:.1} %); the best known design would be a fall of {:.1} %.",
            votes.sentence(),
            end(&runs.quiet),
            fall(end(&runs.quiet)),
            fall(median),
            fall(found.best.cost)
        )
        .replace("of -", "of −")
        .replace("(-", "(−"),
    }
}

/// What is said of the flights: the figure, words, a reading with its unit, and how much of it may be left.
type Said = (u8, &'static str, fn(&Means) -> f64, &'static str, f64);

const OF_TWO: [Said; 2] = [
    (24, "heading squared improves significantly", |m| m.heading2, "deg²", GREATLY),
    (24, "pitch error squared improves significantly", |m| m.pitch2, "deg²", GREATLY),
];

const OF_FOUR: [Said; 5] = [
    (26, "the heading is significantly improved", |m| m.heading2, "deg²", GREATLY),
    (27, "the roll offset is greatly reduced", |m| m.roll_offset, "deg", GREATLY),
    (27, "the zenith angle is slightly lower", |m| m.zenith, "deg", 1.0),
    (28, "altitude tracking improves", |m| m.altitude2, "cm²", 1.0),
    (28, "pitch tracking improves", |m| m.pitch2, "deg²", 1.0),
];

fn flights(case: &Case, found: &Found) -> Vec<Claim> {
    let said: &[Said] = if case.space.variables.len() == 2 { &OF_TWO } else { &OF_FOUR };
    let (before, after) = (found.flights.before.means(), found.flights.after.means());
    let claim = |(figure, says, reading, unit, left): &Said| {
        let start = reading(&before);
        let votes = Votes::of(&after, &found.flights.after_seeds, |means| reading(means) < left * start);
        let better = found.flights.after_seeds.iter().filter(|means| reading(means) < start).count();
        let seeds: Vec<f64> = found.flights.after_seeds.iter().map(reading).collect();
        let median = Summary::of(&seeds).map_or(f64::NAN, |summary| summary.median);
        let threshold = if *left < 1.0 {
            format!("Much is at least a half: {}; it is lower at all for {better} seeds", votes.words())
        } else {
            votes.sentence()
        };
        Claim {
            place: Place::Figure(*figure),
            pictures: vec![format!("figure-{figure}")],
            says: (*says).to_owned(),
            verdict: votes.verdict(),
            found: format!(
                "{threshold}. {start:.3} {unit} at the numerical optimum, {:.3} at the infused one without noise, {median:.3} in the \
                 median.",
                reading(&after)
            ),
        }
    };
    said.iter().map(claim).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chapter7::campaigns::Step;

    fn steps(shares: &[f64]) -> Steps {
        Steps(shares.iter().map(|share| Step { point: Vec::new(), cost: 1.0, share: *share }).collect())
    }

    #[test]
    fn what_an_iteration_drops_is_a_part_of_the_original_space() {
        // Table 5.
        let published = steps(&[61.53, 16.52, 15.33]);
        for (n, expected) in [(1, 38.47), (2, 45.01), (3, 1.19)] {
            let found = dropped(&published, n).expect("three iterations");
            assert!((found - expected).abs() < 1e-9, "iteration {n}: {found}");
        }
        assert_eq!(dropped(&published, 4), None, "it was not made");
    }

    #[test]
    fn a_verdict_needs_the_quiet_campaign_and_nine_in_ten_seeds() {
        let votes = |quiet, n: usize| Votes { quiet, noisy: (0..10).map(|k| k < n).collect() };
        let verdicts = [(true, 10), (true, 9), (true, 8), (false, 10), (true, 0), (false, 1), (false, 0)]
            .map(|(quiet, n)| votes(quiet, n).verdict());
        use Verdict::{InKind, InPart, NotReproduced};
        assert_eq!(verdicts, [InKind, InKind, InPart, InPart, InPart, InPart, NotReproduced]);
    }
}
