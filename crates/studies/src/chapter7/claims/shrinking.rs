//! What is said of the design space, iteration by iteration.

use design_space::Cell;
use infuse::global;

use super::votes::{Votes, count};
use super::words::{median_words, table_place};
use crate::chapter7::campaigns::{Runs, Steps};
use crate::chapter7::file::Case;
use crate::chapter7::findings::Found;
use crate::claims::{Claim, Place};
use crate::rules::{Count, Judged, MUCH, Standing};

const FIGURE: &str = "figure-23";

/// The designs of two parameters, iteration by iteration.
fn pictures(case: &Case) -> Vec<String> {
    if case.space.variables.len() == 2 { vec![FIGURE.to_owned()] } else { Vec::new() }
}

/// Shares from before the first iteration on.
fn shares(steps: &Steps) -> Vec<f64> {
    std::iter::once(100.0).chain(steps.0.iter().map(|step| step.share)).collect()
}

fn words(shares: impl IntoIterator<Item = f64>) -> String {
    let words: Vec<String> = shares.into_iter().map(|share| format!("{share:.2}")).collect();
    format!("{} %", words.join(", "))
}

fn left_words(steps: &Steps) -> String {
    words(steps.0.iter().map(|step| step.share))
}

/// Per cent of the original space that iteration `n` drops; none if it was not made.
fn dropped(steps: &Steps, n: usize) -> Option<f64> {
    let shares = shares(steps);
    Some(shares.get(n - 1)? - shares.get(n)?)
}

/// The same in the dissertation.
fn published_dropped(case: &Case, n: usize) -> Option<f64> {
    Some(case.published.get(n - 1)?.share - case.published.get(n)?.share)
}

fn percent(share: Option<f64>) -> String {
    share.map_or("–".to_owned(), |share| format!("{share:.2}"))
}

fn median_dropped(runs: &Runs, n: usize) -> String {
    median_words(runs.noisy.iter().filter_map(|steps| dropped(steps, n)), 2)
}

fn fall(shares: &[f64]) -> bool {
    shares.windows(2).all(|pair| pair[1] < pair[0])
}

pub(super) fn every_iteration(case: &Case, found: &Found) -> Claim {
    let runs = found.main();
    let votes = Votes::of(&runs.quiet, &runs.noisy, |steps| fall(&shares(steps)));
    let pairs =
        || runs.noisy.iter().flat_map(|steps| shares(steps).windows(2).map(|p| p[1] < p[0]).collect::<Vec<_>>());
    let (dropping, made) = (pairs().filter(|drops| *drops).count(), pairs().count());
    let others: Vec<String> =
        found.runs.iter().skip(1).map(|runs| format!("; {}: {}", runs.label, left_words(&runs.quiet))).collect();
    Claim::new(
        table_place(case),
        "the design space shrinks at every iteration",
        Judged::of(votes.count(), Standing::StandIn),
        format!(
            "{}; {dropping} of {made} iterations with noise drop a cell. Left without noise: {}; published: {}{}.",
            votes.sentence(),
            left_words(&runs.quiet),
            words(case.published.iter().skip(1).map(|row| row.share)),
            others.concat()
        ),
    )
    .in_short(format!("{}; {dropping} of {made} iterations drop a cell", votes.words()))
    .with_pictures(pictures(case))
}

/// Of Figure 23.
pub(super) fn designs(case: &Case, found: &Found) -> Claim {
    let runs = found.main();
    // The figure shows the onset of each iteration: what the last one drops is not in it.
    let onsets = |steps: &Steps| shares(steps)[..steps.0.len()].to_vec();
    let votes = Votes::of(&runs.quiet, &runs.noisy, |steps| fall(&onsets(steps)));
    let reports = runs.quiet_campaign.reports();
    let is_left = |report: &global::Report, cell| {
        runs.quiet_campaign.retained_at(report.number).is_some_and(|left| left.contains(cell))
    };
    let cells = |report: &global::Report| -> Vec<Cell> {
        let experiments = report.trials.iter().map(|record| record.trial.cell);
        experiments.chain(report.simulations.iter().map(|run| run.cell)).collect()
    };
    let inside: Vec<bool> =
        reports.iter().flat_map(|report| cells(report).into_iter().map(|cell| is_left(report, cell))).collect();
    let efficiencies = |of: fn(&global::Report) -> f64| {
        let words: Vec<String> = reports.iter().map(|report| format!("{:.0}", of(report))).collect();
        format!("{} %", words.join(", "))
    };
    Claim::new(
        Place::Figure(23),
        "the runs of every iteration are G-optimal in a space that has shrunk since the iteration before",
        Judged::of(votes.count(), Standing::StandIn),
        format!(
            "{}. Left at the onset of each iteration without noise: {}; published: {}. {} of {} runs lie in what was left, by \
             construction; G-efficiency over it of the experiments {}, of the simulations {}. The figure prints no number of runs: \
             those are ours.",
            votes.sentence(),
            words(onsets(&runs.quiet)),
            words(case.published.iter().take(case.entry.iterations).map(|row| row.share)),
            count(&inside),
            inside.len(),
            efficiencies(|report| report.batch.experiment_efficiency),
            efficiencies(|report| report.batch.simulation_efficiency)
        ),
    )
    .in_short(format!(
            "{}; G-efficiency {}",
            votes.words(),
            efficiencies(|report| report.batch.experiment_efficiency)
        ))
    .with_pictures(pictures(case))
}

pub(super) fn first_shrinks_less(case: &Case, found: &Found) -> Claim {
    let runs = found.main();
    let less = |steps: &Steps| matches!((dropped(steps, 1), dropped(steps, 2)), (Some(a), Some(b)) if a < b);
    let votes = Votes::of(&runs.quiet, &runs.noisy, less);
    Claim::new(
        Place::Section("7.1".to_owned()),
        "the first iteration shrinks the space less than the second, because the model is not corrected yet",
        Judged::of(votes.count(), Standing::StandIn),
        format!(
            "{}. Dropped by the first and the second iteration, in % of the original space: median {} and {}; published {} and {}.",
            votes.sentence(),
            median_dropped(runs, 1),
            median_dropped(runs, 2),
            percent(published_dropped(case, 1)),
            percent(published_dropped(case, 2))
        ),
    )
    .in_short(votes.words())
}

/// Whether the third iteration drops little, and less than it does without noise.
fn is_limited(steps: &Steps, quiet: &Steps) -> bool {
    match (dropped(steps, 2), dropped(steps, 3), dropped(quiet, 3)) {
        (Some(second), Some(third), Some(without)) => third < MUCH * second && third < without,
        _ => false,
    }
}

/// Of noise, so the seeds decide; the campaign without noise is what they are compared with.
pub(super) fn noise_limits(case: &Case, found: &Found, noise_s: f64) -> Claim {
    let runs = found.main();
    let limited: Vec<bool> = runs.noisy.iter().map(|steps| is_limited(steps, &runs.quiet)).collect();
    let last = |steps: &Steps| steps.0.last().map_or(f64::NAN, |step| step.share);
    let smaller: Vec<bool> = runs.noisy.iter().map(|steps| last(steps) < last(&runs.quiet)).collect();
    let spread = runs.quiet_campaign.reports().get(2).and_then(|report| report.screening.spread.s());
    Claim::new(
        Place::Section("7.1".to_owned()),
        "from the third iteration on noise limits further reduction",
        Judged::of(Count::of(limited.iter().copied()), Standing::StandIn),
        format!(
            "The third iteration drops less than half of what the second does, and less than it drops without noise, for {} of {} seeds: \
             {} % of the original space in the median, {} % without noise; published {}. At the end less is left with noise than \
             without for {} of {} seeds. In the third iteration S is {} s without any noise, which is within ±{noise_s:.3} s{}.",
            count(&limited),
            limited.len(),
            median_dropped(runs, 3),
            percent(dropped(&runs.quiet, 3)),
            percent(published_dropped(case, 3)),
            count(&smaller),
            smaller.len(),
            spread.map_or("–".to_owned(), |s| format!("{s:.3}")),
            if spread.is_some_and(|s| s > noise_s) {
                ": here the misfit of the regressor keeps the space large, not noise"
            } else {
                ""
            }
        ),
    )
    .in_short(format!("{} of {} seeds", count(&limited), limited.len()))
}

/// The test of Section 5.5, over a grid whose best cell is known: seeds, those that dropped it, and the share of cells left at the end.
pub(super) fn keeps_best(says: &str, seeds: usize, lost: usize, left: f64) -> Claim {
    let count = Count { holding: seeds - lost, cases: seeds };
    let beside = if count.share() < left { "less often than that" } else { "more often than that" };
    Claim::new(
        Place::Section("5.5".to_owned()),
        says,
        Judged::of(count, Standing::StandIn).beside(left),
        format!(
            "The truly best cell of the grid that is flown in whole is dropped for {lost} of {seeds} seeds of noise; one in ten is what the \
             test allows. {:.1} % of the cells are left in the mean, and a blind draw of as many would keep the best so often: the test \
             keeps it {beside}.",
            100.0 * left
        ),
    )
    .in_short(format!("the best cell is dropped for {lost} of {seeds} seeds; {:.1} % of the cells are left", 100.0 * left))
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
    fn noise_limits_only_what_goes_on_without_it() {
        let noisy = steps(&[60.0, 20.0, 18.0]);
        assert!(is_limited(&noisy, &steps(&[60.0, 20.0, 5.0])), "2 % after 40 %, where 15 % go without noise");
        assert!(!is_limited(&noisy, &steps(&[60.0, 20.0, 19.0])), "without noise even less is dropped");
        assert!(!is_limited(&steps(&[60.0, 40.0, 20.0]), &steps(&[60.0, 40.0, 0.0])), "as much as before");
    }

    #[test]
    fn the_test_has_to_do_better_than_a_blind_draw() {
        use crate::claims::Verdict;
        let verdict = |lost, left| keeps_best("It keeps the best", 20, lost, left).verdict;
        assert_eq!(
            [verdict(2, 0.3), verdict(3, 0.3), verdict(19, 0.3)].map(Verdict::short),
            ["in kind", "in part", "not"]
        );
        assert_eq!(verdict(0, 0.64), Verdict::NotDiscriminating, "64 of 100 draws keep it, too");
        assert!(keeps_best("It", 20, 13, 0.48).found.ends_with("keeps it less often than that."), "35 % beside 48");
    }
}
