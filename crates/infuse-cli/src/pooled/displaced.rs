//! That a simulation is right of another design: how far it is displaced, in words and as JSON.

use design_space::Parameter;
use infuse::pooled::Assessment;
use infuse::pooled::reported::{Refused, Registration};
use page::Finding;
use serde_json::{Map, Value, json};

use super::bands::{IGNORED, NINE_IN_TEN};
use super::campaign::Campaign;
use crate::findings::{displaced_by, give_or_take};
use crate::number::{percent, short, with_unit};
use crate::problem::{Problem, shown};
use crate::simulator::identity;

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
            named(campaign, told),
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
        Some(Refused::OneResult) => "that rests on a single result, which may be a slip",
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

/// The share of the levels of a parameter, or of its range, that is left within the bounds.
fn within(along: &Along<'_>) -> f64 {
    let beyond = along.by.abs() / along.parameter.width();
    let n = along.n_levels as f64;
    (1.0 - beyond * (n - 1.0) / n).max(0.0)
}

/// "a higher by 1 mm (give or take 0.5 mm)", along all that it is displaced along.
fn named(campaign: &Campaign, told: &Registration) -> String {
    displaced_by(campaign.problem.region.parameters(), &told.displacement, Some(&told.deviations))
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
        match worth.ignored >= IGNORED {
            true => format!(
                " From there it explains {there}, and of the same results {here} as it stands; it is hardly used either way."
            ),
            false => format!(
                " It is taken from there, where it explains {there}; of the same results it explains {here} as it stands."
            ),
        }
    });
    format!(
        "It is displaced: what is measured at {here}, it says of {there}: {}{}.{explained} For {} of the designs that is beyond the bounds, where \
         experiments have to tell. Is a parameter of the model, or the zero of a sensor, off by as much? Where the \
         response is one smooth bowl, a slope that the simulation lacks looks the same.",
        named(campaign, told),
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
    if before.by.as_ref().is_some_and(|then| *then != identity(&campaign.problem.simulator)) {
        let now =
            if told.is_sure() { "what is said of it now is of this one" } else { "this one is taken as it stands" };
        return Some(format!("{since}; but that was another simulator: {now}."));
    }
    if !told.is_sure() {
        return Some(format!(
            "{since}: by all that is known now {}, so it is taken as it stands again.",
            why_not(told)
        ));
    }
    let then = before.simulation.as_ref().and_then(|simulation| simulation.deviations.as_deref());
    let none = vec![0.0; by.len()];
    let mut moves = by.iter().zip(then.unwrap_or(&none)).zip(told.displacement.iter().zip(&told.deviations));
    let has_moved =
        moves.any(|((then, of_then), (now, of_now))| (now - then).abs() > NINE_IN_TEN * of_then.hypot(*of_now));
    has_moved.then(|| {
        let then = displaced_by(campaign.problem.region.parameters(), by, then);
        format!("{since} otherwise: {then}. It is farther from that now than both bands: what was made of it then does not hold.")
    })
}

/// Of a design of which a displaced simulation would tell from beyond the bounds: that it tells little there.
pub(super) fn beyond(campaign: &Campaign, found: &Assessment, point: &[f64]) -> Option<Finding> {
    let by = found.displacement.as_ref()?;
    let parameters = campaign.problem.region.parameters().iter();
    let there = parameters.zip(point.iter().zip(by)).filter(|(_, (_, by))| by.abs() > 0.0);
    let there = there.map(|(parameter, (&setting, &by))| (parameter, setting + by));
    let is_beyond = |(parameter, there): &(&Parameter, f64)| {
        let rounding = 1e-9 * parameter.width();
        *there < parameter.lower() - rounding || *there > parameter.upper() + rounding
    };
    let over = there.filter(is_beyond).map(|(parameter, there)| {
        let (low, high) = (shown(parameter, parameter.lower()), shown(parameter, parameter.upper()));
        let there = with_unit(&short(there), parameter.unit());
        format!("{} {there}, beyond {low} to {high}", parameter.name())
    });
    let over = over.collect::<Vec<_>>().join("; ");
    let sentence = format!(
        "The simulation is displaced, and would tell of it what it says of {over}: it tells little or nothing there, and experiments have to."
    );
    (!over.is_empty()).then(|| Finding::new(sentence))
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
