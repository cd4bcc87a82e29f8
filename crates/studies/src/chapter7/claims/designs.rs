//! What is said of the designs: where they begin and end, and how much better they are.

use super::votes::{Votes, count};
use super::words::{FITTED, median_words, table_place};
use crate::chapter7::campaigns::Steps;
use crate::chapter7::file::{Case, Row, Standing as RowStanding};
use crate::chapter7::findings::Found;
use crate::claims::{Claim, Place, Verdict};
use crate::rules::{Count, Judged, NEAR, Standing};
use crate::variable::Variable;
use crate::words::number;

/// A design is at an edge of the box within this part of the width: rounding.
const AT_EDGE: f64 = 1e-9;

/// How far two designs are apart, as parts of the parameters' widths.
fn departures(case: &Case, theirs: &[f64], ours: &[f64]) -> Vec<f64> {
    let parameters = case.space.region().parameters();
    let pairs = theirs.iter().zip(ours).zip(parameters);
    pairs.map(|((theirs, ours), parameter)| (theirs - ours).abs() / (parameter.upper() - parameter.lower())).collect()
}

fn is_near(departures: &[f64]) -> bool {
    departures.iter().all(|departure| *departure <= NEAR)
}

fn percents(departures: &[f64]) -> String {
    departures.iter().map(|departure| format!("{:.0}", 100.0 * departure)).collect::<Vec<_>>().join(", ")
}

fn is_at_edge(case: &Case, point: &[f64]) -> bool {
    point.iter().zip(case.space.region().parameters()).any(|(x, parameter)| {
        let width = parameter.upper() - parameter.lower();
        (x - parameter.lower()).min(parameter.upper() - x) <= AT_EDGE * width
    })
}

fn end(steps: &Steps) -> &[f64] {
    steps.0.last().map_or(&[], |step| &step.point)
}

/// What can become of a claim about the ends of the loop.
pub(super) fn standing(case: &Case) -> Standing {
    if case.ends_are_fitted() { Standing::FittedEnds } else { Standing::StandIn }
}

/// A warning where both ends were fitted.
fn fitted_words(case: &Case) -> String {
    if case.ends_are_fitted() { format!("{FITTED} ") } else { String::new() }
}

pub(super) fn aft(case: &Case, found: &Found) -> Option<Claim> {
    let k = case.space.variables.iter().position(|variable| *variable == Variable::CenterOfMass)?;
    let start = found.numerical.point[k];
    let place = |steps: &Steps| end(steps).get(k).copied().unwrap_or(f64::NAN);
    let votes =
        |runs: &crate::chapter7::campaigns::Runs| Votes::of(&runs.quiet, &runs.noisy, |steps| place(steps) > start);
    let runs = found.main();
    let published = |row: Option<&Row>| row.map_or(f64::NAN, |row| row.point[k]);
    let others = found.runs.iter().skip(1).map(|runs| format!(" With the {}: {}.", runs.label, votes(runs).words()));
    let by_chance = found.flights.blind.share(|(point, _)| point[k] > start);
    let claim = Claim::new(
        table_place(case),
        "infusion moves the center of mass aft",
        Judged::of(votes(runs).count(), standing(case)).beside(by_chance),
        format!(
            "{}{}: from {start:.2} % of chord (numerical optimum) to {:.2} without noise, {} in the median; published {:.2} to {:.2}.{}",
            fitted_words(case),
            votes(runs).sentence(),
            place(&runs.quiet),
            median_words(runs.noisy.iter().map(place), 2),
            published(case.published.first()),
            published(case.published.last()),
            others.collect::<String>()
        ),
    );
    Some(claim.in_short(format!(
        "{}; from {start:.2} to {:.2} % of chord without noise",
        votes(runs).words(),
        place(&runs.quiet)
    )))
}

pub(super) fn numerical_row(case: &Case, found: &Found) -> Claim {
    let row = case.published.first();
    let departures = row.map_or(Vec::new(), |row| departures(case, &row.point, &found.numerical.point));
    let near = departures.iter().filter(|departure| **departure <= NEAR).count();
    let standing = row.map_or("", |row| row.standing.words());
    let says = "the numerical optimum is row 0";
    let words = format!(
        "{} here ({standing}); departures {} % of the parameters' widths. Up to {:.0} % in each counts as near: {near} of {} are.",
        case.space.words(&found.numerical.point),
        percents(&departures),
        100.0 * NEAR,
        departures.len()
    );
    let claim = match row {
        Some(row) if row.standing != RowStanding::Predicted => {
            Claim::given(table_place(case), says, Verdict::Calibrated, words)
        }
        _ => {
            let count = Count::one(!departures.is_empty() && is_near(&departures));
            Claim::new(table_place(case), says, Judged::of(count, Standing::StandIn), words)
        }
    };
    claim.in_short(format!("{near} of {} parameters within {:.0} % of their widths", departures.len(), 100.0 * NEAR))
}

/// How the campaigns end beside the last printed row.
fn last_row_votes(row: &Row, case: &Case, runs: &crate::chapter7::campaigns::Runs) -> Votes {
    Votes::of(&runs.quiet, &runs.noisy, |steps| is_near(&departures(case, &row.point, end(steps))))
}

pub(super) fn last_row(case: &Case, found: &Found) -> Option<Claim> {
    let row = case.published.last()?;
    let votes = last_row_votes(row, case, found.main());
    let standing = if row.standing == RowStanding::Predicted { Standing::StandIn } else { Standing::FittedEnds };
    let by_chance = found.flights.blind.share(|(point, _)| is_near(&departures(case, &row.point, point)));
    let judged = Judged::of(votes.count(), standing).beside(by_chance);
    let claim =
        Claim::new(table_place(case), "the loop ends at the last printed row", judged, last_row_words(case, found)?);
    Some(claim.in_short(votes.words()))
}

/// The same as a paragraph.
pub(in crate::chapter7) fn last_row_words(case: &Case, found: &Found) -> Option<String> {
    let row = case.published.last()?;
    let runs = found.main();
    let away = departures(case, &row.point, end(&runs.quiet));
    let edges: Vec<bool> = runs.noisy.iter().map(|steps| is_at_edge(case, end(steps))).collect();
    let others = found
        .runs
        .iter()
        .skip(1)
        .map(|runs| format!(" With the {}: {}.", runs.label, last_row_votes(row, case, runs).words()));
    let fitted = match row.standing {
        RowStanding::Predicted => "",
        RowStanding::Calibrated | RowStanding::DesignCalibrated => {
            " The best design of the stand-in was fitted to this row; the loop does not get there."
        }
    };
    let votes = last_row_votes(row, case, runs);
    let fitted = if votes.count().few() { fitted } else { "" };
    Some(format!(
        "The last row is {}, ours without noise {}: departures {} % of the parameters' widths. If up to {:.0} % in each counts as reached, \
         {}. {} of {} seeds end on an edge of the box.{}{fitted}",
        case.space.words(&row.point),
        case.space.words(end(&runs.quiet)),
        percents(&away),
        100.0 * NEAR,
        votes.words(),
        count(&edges),
        edges.len(),
        others.collect::<String>()
    ))
}

pub(super) fn system(case: &Case, found: &Found) -> Claim {
    let runs = found.main();
    let before = found.numerical_true_cost;
    let cost = |steps: &Steps| steps.0.last().map_or(f64::NAN, |step| step.cost);
    let votes = Votes::of(&runs.quiet, &runs.noisy, |steps| cost(steps) < before);
    let median = super::words::median(runs.noisy.iter().map(cost));
    let fall = |after: f64| number(100.0 * (1.0 - after / before), 1);
    let by_chance = found.flights.blind.share(|(_, means)| means.cost < before);
    Claim::new(
        Place::Contribution(6),
        "infusion gives a better system than the numerical model alone",
        Judged::of(votes.count(), standing(case)).beside(by_chance),
        format!(
            "{}{}: true cost {before:.3} s at the numerical optimum, {:.3} s at the infused one without noise (a fall of {} %), \
             {median:.3} s in the median ({} %); the best known design would be a fall of {} %.",
            fitted_words(case),
            votes.sentence(),
            cost(&runs.quiet),
            fall(cost(&runs.quiet)),
            fall(median),
            fall(found.best.cost)
        ),
    )
    .in_short(format!(
        "{}; the true cost falls from {before:.3} to {:.3} s without noise",
        votes.words(),
        cost(&runs.quiet)
    ))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::chapter7::file::Setup;

    #[test]
    fn a_design_is_near_only_if_every_parameter_is() {
        assert!(is_near(&[0.1, 0.0]) && !is_near(&[0.0, 0.11]));
    }

    #[test]
    fn departures_and_edges_are_those_of_table_4() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/bat/chapter7.toml");
        let setup = Setup::read(&path).expect("the study file");
        let two = &setup.cases[0];
        // Widths of Table 4: 5.6 % of chord and 15 deg.
        let away = departures(two, &[49.53, 7.51], &[51.25, 0.0]);
        assert!((away[0] - 1.72 / 5.6).abs() < 1e-9 && (away[1] - 7.51 / 15.0).abs() < 1e-9, "{away:?}");
        assert!(is_at_edge(two, &[51.25, 7.0]) && is_at_edge(two, &[50.0, 0.0]) && !is_at_edge(two, &[50.0, 7.0]));
        assert!(two.ends_are_fitted() && !setup.cases[1].ends_are_fitted());
    }
}
