//! Why the bound of the certificate is larger than it was a batch ago, as far as that is known.

use infuse::pooled::Assessment;
use page::Finding;
use serde_json::{Map, Value};

use super::bands::{IGNORED, NINE_IN_TEN, resolution};
use super::campaign::{Campaign, Origin};
use super::drift::taken_in_otherwise;
use super::warnings::far;
use crate::campaign::changes;
use crate::journal::Assessed;
use crate::number::{count, short};
use crate::problem::Scale;
use crate::simulator::identity;

/// From so many times what it was on it is said that a bound has risen, as a factor if it is one.
const RISEN: f64 = 1.02;
/// From so many times what it was on it is said that the noise is larger, or the factor of the simulation another.
const OTHER: f64 = 1.1;
/// So many reasons are said.
const MOST_SAID: usize = 3;
/// Settings that the bound hangs on.
const MATTER: [&str; 10] = [
    "confidence",
    "noise",
    "smooth",
    "displaced",
    "blocks",
    "constraints",
    "linear_constraints",
    "plants",
    "lower",
    "upper",
];

/// That the bound was narrower a batch ago, and why.
pub(super) fn risen(campaign: &Campaign, found: &Assessment) -> Option<Finding> {
    let before = last_said(campaign, found)?;
    let bound = before.bound?;
    let response = &campaign.problem.response;
    let has_risen = match response.scale {
        Scale::Linear => found.certificate.bound > RISEN * bound,
        Scale::Log => found.certificate.bound - bound > RISEN.ln(),
    };
    has_risen.then(|| {
        let sentence = format!(
            "After batch {} the bound was {}. It has risen: {}.",
            before.batch,
            response.amount(bound),
            why(campaign, found, before)
        );
        Finding::new(sentence).with("bound before", response.of_difference(bound), response.unit_of_differences())
    })
}

/// What was said after the last batch before what is known now.
fn last_said<'a>(campaign: &'a Campaign, found: &Assessment) -> Option<&'a Assessed> {
    let mut said = campaign.history.values().rev();
    let last = said.next()?;
    // Where nothing came since, what is known now is what was said last, but for what machines round differently.
    let is_of_now = last.bound.is_some_and(|bound| (bound - found.certificate.bound).abs() <= 1e-6 * bound.abs());
    if is_of_now { said.next() } else { Some(last) }
}

fn why(campaign: &Campaign, found: &Assessment, before: &Assessed) -> String {
    let mut reasons = changed(campaign, before);
    reasons.extend(campaign.withdrawn_since(before.batch));
    reasons.extend(taken_in_otherwise(campaign, found, before));
    let well = campaign.problem.response.well();
    match (&found.forecast, &found.find) {
        _ if !reasons.is_empty() => {}
        // What is held for a number of runs is a share of what their results differ by.
        (forecast, _) if forecast.reserves_until().is_some() => {
            return format!("since then results differ by more, so more is held for a narrow {well}");
        }
        (forecast, Some(_)) if forecast.is_for_a_find() => {
            return format!("what was found since may be a part of a narrow {well}");
        }
        (forecast, None) if forecast.is_for_a_find() => {
            return "a design was measured to be better than the recommended one, against what the surface expects"
                .to_owned();
        }
        _ => {}
    }
    reasons.extend(worse_than_expected(campaign, found, before));
    reasons.extend(stands_out(campaign, found, before));
    reasons.extend(another_is_recommended(campaign, found, before));
    reasons.extend(more_noise(campaign, found, before));
    reasons.extend(of_the_simulation(found, before, campaign.problem.response.scale));
    reasons.truncate(MOST_SAID);
    match reasons.is_empty() {
        true => "no single result stands out, the recommended design is the same, and neither settings nor noise explain it; with all that \
                 came since the surface's parameters were learnt anew, and less is taken for sure"
            .to_owned(),
        false => reasons.join("; "),
    }
}

/// Settings of the loop and the simulator that are others than then.
fn changed(campaign: &Campaign, before: &Assessed) -> Vec<String> {
    let now = campaign.settings_as_said();
    let value = |of: &Value, key: &str| of.get(key).cloned().unwrap_or_default();
    // What a journal of an earlier version does not have is not known to have changed.
    let is_known = |key: &&&str| before.settings.get(**key).is_some();
    let those_that_matter = |of: &Value| {
        let entries = MATTER.iter().filter(is_known).map(|key| ((*key).to_owned(), value(of, key)));
        Value::Object(entries.collect::<Map<String, Value>>())
    };
    let mut changed = changes(&those_that_matter(&before.settings), &those_that_matter(&now));
    let by = identity(&campaign.problem.simulator);
    if before.by.as_ref().is_some_and(|then| *then != by) {
        changed.push("the simulator is another".to_owned());
    }
    changed
}

/// That what was recommended then has been run since, and was worse than expected.
fn worse_than_expected(campaign: &Campaign, found: &Assessment, before: &Assessed) -> Option<String> {
    let response = &campaign.problem.response;
    let (_, cell) = campaign.nearest(&before.recommended).ok()?;
    let trials =
        campaign.experiments.trials.iter().filter(|(_, trial)| trial.batch > before.batch && trial.cell == cell);
    let runs = trials.filter_map(|(&id, _)| Some((id, campaign.experiments.readings.get(&id)?)));
    let costs = runs.flat_map(|(id, reading)| reading.values().map(move |value| (id, response.cost(value))));
    let costs: Vec<(u64, f64)> = costs.collect();
    let (n, expected) = (costs.len() as f64, response.cost(before.expected));
    let mean = costs.iter().map(|(_, cost)| cost).sum::<f64>() / n;
    let half = NINE_IN_TEN * (before.deviation.powi(2) + before.noise.powi(2) / n).sqrt();
    let is_worse = !costs.is_empty() && mean - expected > half;
    is_worse.then(|| {
        let who = match costs.as_slice() {
            [(id, _)] => format!("{} of the design recommended then", campaign.name_of(Origin::Own(*id))),
            all => format!("{} of the design recommended then", count(all.len(), "run")),
        };
        let on_average = if costs.len() > 1 { " on average" } else { "" };
        let known_to = resolution(found);
        format!(
            "{who} measured {}{on_average}, where {} was expected, give or take {}",
            response.value_to(mean, known_to),
            response.value_to(expected, known_to),
            response.amount(half)
        )
    })
}

/// The result since then that is farthest from what all others say.
fn stands_out(campaign: &Campaign, found: &Assessment, before: &Assessed) -> Option<String> {
    let readings = campaign.readings();
    let is_since = |origin: Origin| match origin {
        Origin::Own(id) => campaign.experiments.trial(id).is_ok_and(|trial| trial.batch > before.batch),
        Origin::Imported(_) => false,
    };
    let open = found.outliers.iter().filter(|one| !one.set_aside);
    let since = open.filter_map(|one| Some((one, *readings.get(one.reading).filter(|(origin, _)| is_since(*origin))?)));
    let (outlier, (origin, cost)) = since.max_by(|a, b| a.0.deviations.abs().total_cmp(&b.0.deviations.abs()))?;
    let measured = campaign.problem.response.value_to(cost, resolution(found));
    Some(format!("{} measured {measured}, {} what all others say", campaign.name_of(origin), far(campaign, outlier)))
}

fn another_is_recommended(campaign: &Campaign, found: &Assessment, before: &Assessed) -> Option<String> {
    let (_, cell) = campaign.nearest(&before.recommended).ok()?;
    let is_another = cell != found.recommended.cell;
    is_another
        .then(|| format!("another design is recommended than then, {}", campaign.problem.describe(&before.recommended)))
}

fn more_noise(campaign: &Campaign, found: &Assessment, before: &Assessed) -> Option<String> {
    let response = &campaign.problem.response;
    let is_more = campaign.settings.noise.is_none() && found.noise > OTHER * before.noise;
    is_more.then(|| {
        format!(
            "the noise of one run is taken for {}, and was for {}",
            response.amount(found.noise),
            response.amount(before.noise)
        )
    })
}

/// What is made of the simulation now, where something else was made of it then.
fn of_the_simulation(found: &Assessment, before: &Assessed, scale: Scale) -> Option<String> {
    let (then, now) = (before.simulation.as_ref()?, found.simulation?);
    if then.displacement != found.displacement {
        return Some("the simulation is taken from another place".to_owned());
    }
    match (then.ignored >= IGNORED, now.ignored >= IGNORED) {
        (false, true) => return Some("the simulation is hardly used any more".to_owned()),
        (true, false) => return Some("the simulation is used, and was hardly used then".to_owned()),
        (true, true) => return None,
        (false, false) => {}
    }
    let (least, most) = (now.factor.min(then.factor), now.factor.max(then.factor));
    let is_other = most - least > (OTHER - 1.0) * most.abs().max(least.abs());
    let [then, now] = [then.factor, now.factor].map(short);
    is_other.then(|| match scale {
        Scale::Linear => {
            format!("differences that the simulation predicts count {now} times, and did {then} times")
        }
        Scale::Log => {
            format!("ratios that the simulation predicts are taken to the power of {now}, and were to that of {then}")
        }
    })
}
