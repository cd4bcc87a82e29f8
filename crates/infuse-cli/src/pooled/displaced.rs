//! That a simulation is right of another design: how far it is displaced, in words and as JSON.

use design_space::Parameter;
use infuse::pooled::Assessment;
use infuse::pooled::reported::{Refused, Registration};
use page::Finding;
use serde_json::{Map, Value, json};

use super::bands::NINE_IN_TEN;
use super::campaign::Campaign;
use crate::number::{percent, short, with_unit};
use crate::problem::{Problem, shown};

/// It is said that a simulation may be displaced from this share of what it takes to be sure on.
const WORTH_SAYING: f64 = 0.5;

/// What is said of it beside what the simulation is worth.
pub(super) fn findings(campaign: &Campaign, found: &Assessment) -> Vec<Finding> {
    let Some(told) = &found.registration else { return Vec::new() };
    let along = along(campaign, told);
    let withdrawn = changed(campaign, told).map(Finding::new);
    let finding = if told.is_sure() {
        taken(campaign, found, told, &along)
    } else if told.gain > WORTH_SAYING * told.needed && !along.is_empty() {
        format!(
            "It may be displaced: it fits best that what is measured at a design it says of one with {}. But {}, so it is taken as it stands.",
            named(&along),
            why_not(told)
        )
    } else {
        return withdrawn.into_iter().collect();
    };
    let finding = along.into_iter().fold(Finding::new(finding), |finding, along| {
        let (name, unit) = (along.parameter.name(), along.parameter.unit());
        let finding = finding.with(&format!("displaced along {name}"), along.by, unit);
        finding.with(&format!("displaced along {name}, give or take"), along.half(), unit)
    });
    withdrawn.into_iter().chain([finding]).collect()
}

/// Why a displacement is not believed.
fn why_not(told: &Registration) -> &'static str {
    match told.refused.filter(|_| told.gain > told.needed) {
        Some(Refused::TooFar) => "that is farther than is believed: something else that it has may lie there by chance",
        Some(Refused::BeyondBounds) => {
            "for most of the results that place is beyond the bounds, where it tells little or nothing"
        }
        Some(Refused::ExplainsLess) => {
            "of the results for which that place is within the bounds it explains less from there"
        }
        None => "the results are not sure of it",
    }
}

/// How far along a parameter.
struct Along<'p> {
    parameter: &'p Parameter,
    by: f64,
    deviation: f64,
    n_levels: u64,
}

impl Along<'_> {
    /// Half the width of a band in which it is nine times of ten.
    fn half(&self) -> f64 {
        NINE_IN_TEN * self.deviation
    }
}

fn along<'p>(campaign: &'p Campaign, told: &Registration) -> Vec<Along<'p>> {
    let parameters = campaign.problem.region.parameters().iter().zip(campaign.grid.combinations().counts());
    let all = parameters.zip(told.displacement.iter().zip(&told.deviations));
    let all = all.map(|((parameter, &n_levels), (&by, &deviation))| Along { parameter, by, deviation, n_levels });
    all.filter(|along| along.by.abs() > 0.0).collect()
}

/// As much of a band as anyone needs.
fn two_digits(value: f64) -> f64 {
    format!("{value:.1e}").parse().unwrap_or(value)
}

/// The share of the levels of a parameter, or of its range, that is left within the bounds.
fn within(along: &Along<'_>) -> f64 {
    let beyond = along.by.abs() / along.parameter.width();
    let n = along.n_levels as f64;
    (1.0 - beyond * (n - 1.0) / n).max(0.0)
}

/// "a higher by 1 mm, b lower by 2 mm".
fn named(all: &[Along<'_>]) -> String {
    let one = |along: &Along<'_>| {
        format!("{} {}", one_way(along.parameter, along.by), give_or_take(along.parameter, along.deviation))
    };
    all.iter().map(one).collect::<Vec<_>>().join(", ")
}

/// "(give or take 0.5 mm)".
fn give_or_take(parameter: &Parameter, deviation: f64) -> String {
    format!("(give or take {})", with_unit(&short(two_digits(NINE_IN_TEN * deviation)), parameter.unit()))
}

/// "; tilt in its place (give or take 2 deg)", of parameters along which it was looked for, and is not displaced.
fn in_place(campaign: &Campaign, told: &Registration) -> String {
    let all = campaign.problem.region.parameters().iter().zip(told.displacement.iter().zip(&told.deviations));
    let here = all.filter(|(_, (by, deviation))| by.abs() <= 0.0 && **deviation > 0.0);
    let named = here.map(|(parameter, (_, &deviation))| {
        format!("; {} in its place {}", parameter.name(), give_or_take(parameter, deviation))
    });
    named.collect()
}

/// "a higher by 1 mm".
fn one_way(parameter: &Parameter, by: f64) -> String {
    let way = if by > 0.0 { "higher" } else { "lower" };
    format!("{} {way} by {}", parameter.name(), with_unit(&short(by.abs()), parameter.unit()))
}

/// What is made of a displacement that the results are sure of.
fn taken(campaign: &Campaign, found: &Assessment, told: &Registration, all: &[Along<'_>]) -> String {
    let [here, there] = [0.0, 1.0].map(|share| {
        let one = |along: &Along<'_>| {
            let parameter = along.parameter;
            let middle = parameter.snap(parameter.center()).unwrap_or(parameter.center());
            let place = shown(parameter, middle + share * along.by);
            format!("{} {}", parameter.name(), with_unit(&place, parameter.unit()))
        };
        all.iter().map(one).collect::<Vec<_>>().join(", ")
    });
    let within: f64 = all.iter().map(within).product();
    let explained = found.simulation.map_or_else(String::new, |worth| {
        let [there, here] = [worth.explained, told.explained_in_place].map(percent);
        format!(
            " It is taken from there, where it explains {there}; of the same results it explains {here} as it stands."
        )
    });
    format!(
        "It is displaced: what is measured at {here}, it says of {there}: {}{}.{explained} Of {} of the designs that is beyond the bounds: there \
         it tells little or nothing, and experiments have to. Is a parameter of the model, or the zero of a sensor, off by as much? Where the \
         response is one smooth bowl, a slope that the simulation lacks looks the same.",
        named(all),
        in_place(campaign, told),
        percent(1.0 - within)
    )
}

/// That it was taken to be displaced after the batch before, and is not any more, or by something else.
fn changed(campaign: &Campaign, told: &Registration) -> Option<String> {
    let before = campaign.history.range(..campaign.batches.len()).next_back()?.1;
    let by = before.simulation.as_ref().and_then(|simulation| simulation.displacement.as_ref())?;
    if by.iter().all(|by| by.abs() <= 0.0) {
        return None;
    }
    let since = format!("After batch {} it was taken to be displaced", before.batch);
    if !told.is_sure() {
        return Some(format!(
            "{since}: by all that is known now {}, so it is taken as it stands again.",
            why_not(told)
        ));
    }
    let none = vec![0.0; by.len()];
    let deviations = before.simulation.as_ref().and_then(|simulation| simulation.deviations.as_ref()).unwrap_or(&none);
    let mut moves = by.iter().zip(deviations).zip(told.displacement.iter().zip(&told.deviations));
    let has_moved =
        moves.any(|((then, of_then), (now, of_now))| (now - then).abs() > NINE_IN_TEN * of_then.hypot(*of_now));
    let parameters = campaign.problem.region.parameters().iter().zip(by.iter().zip(deviations));
    let then = parameters.filter(|(_, (by, _))| by.abs() > 0.0);
    let then = then.map(|(parameter, (&by, &deviation))| match deviation > 0.0 {
        true => format!("{} {}", one_way(parameter, by), give_or_take(parameter, deviation)),
        false => one_way(parameter, by),
    });
    let then = then.collect::<Vec<_>>().join(", ");
    has_moved.then(|| {
        format!("{since} otherwise: {then}. It is farther from that now than both bands: what was made of it then does not hold.")
    })
}

/// By the names of the parameters along which it is taken to be displaced; nothing where it is taken as it stands.
pub(super) fn as_json(problem: &Problem, found: &Assessment) -> Option<Value> {
    found.displacement.as_ref().map(|by| by_name(problem, by))
}

/// What the results tell of it, sure or not.
pub(super) fn registration_as_json(problem: &Problem, found: &Assessment) -> Option<Value> {
    let told = found.registration.as_ref()?;
    let half: Vec<f64> = told.deviations.iter().map(|deviation| NINE_IN_TEN * deviation).collect();
    Some(json!({
        "displacement": by_name(problem, &told.displacement),
        "give_or_take": by_name(problem, &half),
        "log_probability_above_none": told.gain,
        "believed_above": told.needed,
        "is_believed": told.is_sure(),
        "refused": told.refused,
        "explained_as_it_stands": told.explained_in_place,
    }))
}

fn by_name(problem: &Problem, all: &[f64]) -> Value {
    let by = problem.region.parameters().iter().zip(all).filter(|(_, by)| by.abs() > 0.0);
    Value::Object(by.map(|(parameter, by)| (parameter.name().to_owned(), json!(by))).collect::<Map<_, _>>())
}
