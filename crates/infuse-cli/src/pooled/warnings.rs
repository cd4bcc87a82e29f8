//! What speaks against a campaign or its recommendation: each in a sentence that says what to do about it.

use std::cmp::Ordering;

use anyhow::Result;
use infuse::pooled::reported::Outlier;
use infuse::pooled::{Assessment, Standing};
use page::Finding;

use super::bands::resolution;
use super::campaign::{Campaign, Origin};
use super::drift;
use super::given_noise::{too_large, too_small};
use crate::campaign::Campaign as _;
use crate::findings::{Twice, there_twice};
use crate::number::{count, plain, short, with_unit};
use crate::problem::{Goal, Scale};
use crate::wording::all_of;

/// Outliers that are named.
const MOST_NAMED: usize = 5;
/// So many results that are all equal are no chance.
const FEWEST_EQUAL: usize = 3;

/// What speaks against what is recommended.
pub(super) fn warnings(campaign: &Campaign, found: &Assessment) -> Result<Vec<Finding>> {
    let (problem, response) = (&campaign.problem, &campaign.problem.response);
    let mut warnings = Vec::new();
    if let Some(contradiction) = &found.contradiction {
        let there = &contradiction.standing;
        let measured = response.value_to(there.measured.unwrap_or(there.mean), resolution(found));
        let times = short(contradiction.deviations.abs());
        let off = off_there(campaign, found, there);
        let sentence = if there.cell == found.recommended.cell {
            format!(
                "Careful: the recommended design itself measured {measured}{off}, {times} standard errors worse than the surface \
                 expects of it."
            )
        } else {
            format!(
                "Careful: {} measured {measured}{off}, {times} standard errors better than what is expected of the recommended \
                 design. Run both again, with `infuse confirm`.",
                problem.describe(&there.point)
            )
        };
        warnings.push(Finding::new(sentence).with("standard errors", contradiction.deviations, "1"));
    }
    warnings.extend(set_aside(campaign, found));
    warnings.extend(beyond_the_bounds(campaign));
    warnings.extend(another_unit(campaign));
    warnings.extend(drift::warnings(campaign, found));
    warnings.extend(drift::no_more(campaign, found));
    warnings.extend(at_an_end(campaign));
    warnings.extend(too_large(campaign, found));
    warnings.extend(all_equal(campaign));
    warnings.extend(imported_twice(campaign));
    Ok(warnings)
}

/// ", in batch 2, which reads 1.1 mm below what is expected of it (4.3 mm without that)", where that is taken in.
fn off_there(campaign: &Campaign, found: &Assessment, there: &Standing) -> String {
    let is_there =
        |origin: &Origin| campaign.grid.nearest(&campaign.settings_of(*origin)).is_ok_and(|near| near == there.cell);
    let are_there: Vec<bool> = campaign.origins().iter().map(is_there).collect();
    let off = campaign.off_of_readings(found, |at| are_there[at]);
    match (off.in_words(campaign), there.measured) {
        (off_in_words, Some(measured)) if !off_in_words.is_empty() => {
            let without = campaign.problem.response.value_to(measured - off.by, resolution(found));
            format!("{off_in_words} ({without} without that)")
        }
        (off_in_words, _) => off_in_words,
    }
}

/// That no experiment gave a value, though some were made.
pub(super) fn nothing_but_failures(campaign: &Campaign) -> Vec<Finding> {
    let said = campaign.nothing_but_failures().map(|(n, reason)| {
        let sentence = format!(
            "Careful: not one of {} gave a value; the first one: {reason}. Until one does, batches are spread over what was \
             not tried yet.",
            count(n, "run")
        );
        Finding::new(sentence).with("runs without a value", n as f64, "1")
    });
    said.into_iter().collect()
}

/// Where the upper quartile of the results is more than so many times the lower one, and the largest more than so many times the
/// smallest, they span powers of ten.
const QUARTILES_APART: f64 = 10.0;
const ENDS_APART: f64 = 1000.0;
/// Of so many results at least.
const FEWEST_TO_SPAN: usize = 8;

/// That results, all of one sign, span powers of ten: in their own unit a surface sees the largest of them alone.
fn powers_of_ten(campaign: &Campaign) -> Option<Finding> {
    let response = &campaign.problem.response;
    if !response.scale.is_linear() {
        return None;
    }
    let values: Vec<f64> = campaign.costs().into_iter().map(|cost| response.of_cost(cost)).collect();
    let is_positive = values.iter().all(|value| *value > 0.0);
    let is_of_one_sign = is_positive || values.iter().all(|value| *value < 0.0);
    let mut sizes: Vec<f64> = values.iter().map(|value| value.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let quarter = sizes.len() / 4;
    let (low, high) = (*sizes.get(quarter)?, *sizes.get(sizes.len().checked_sub(quarter + 1)?)?);
    let (least, most) = (*sizes.first()?, *sizes.last()?);
    let is_spanning = high > QUARTILES_APART * low && most > ENDS_APART * least;
    (is_of_one_sign && sizes.len() >= FEWEST_TO_SPAN && is_spanning).then(|| {
        let sign = if is_positive { 1.0 } else { -1.0 };
        let [least, most] = [least, most].map(|size| with_unit(&short(sign * size), &response.unit));
        let remedy = match is_positive {
            true => {
                "set `scale` = \"log\" in [response]: at once, for all that was told. Then `worth` in [stop] and `noise` in [loop] are factors"
            }
            false => {
                "begin a campaign with the other sign, the other `goal` and `scale` = \"log\" in [response], and import these results \
                 into it"
            }
        };
        let sentence = format!(
            "Results span powers of ten, {least} to {most}. In that unit the surface sees the largest alone and takes all others for \
             equal. If they are so by nature, as a leak rate or a life is, {remedy}."
        );
        Finding::new(sentence).with("upper quartile by lower", high / low, "1")
    })
}

/// That settings which mean something else on the scale of now stand as they were on another.
fn left_from_another_scale(campaign: &Campaign) -> Option<Finding> {
    let left = campaign.left_from_another_scale();
    let named = left.iter().map(|(what, value)| format!("{what} is {}", plain(*value)));
    let (before, now) = match campaign.problem.response.scale {
        Scale::Linear => ("a factor on the logarithmic scale", "differences"),
        Scale::Log => ("a difference on the linear scale", "factors"),
    };
    (!left.is_empty()).then(|| {
        let sentence = format!(
            "Careful: `scale` of [response] was changed, and {} as before: it was {before}. Now `worth` and `noise` are {now}: put them \
             right; from the next batch on they are taken for meant.",
            all_of(&named.collect::<Vec<_>>())
        );
        Finding::new(sentence)
    })
}

/// As many designs whose best results are one number are no chance.
const FEWEST_AT_AN_END: usize = 3;

/// That several designs share the best result of all to the last digit, though `[response]` does not say that nothing is better: where
/// a detector ends, surfaces look for more beyond.
fn at_an_end(campaign: &Campaign) -> Option<Finding> {
    let (response, runs) = (&campaign.problem.response, campaign.runs());
    let best = runs.iter().map(|run| run.1).min_by(f64::total_cmp)?;
    let is_best = |cost: f64| cost.total_cmp(&best).is_eq();
    let mut designs: Vec<&[f64]> = runs.iter().filter(|run| is_best(run.1)).map(|run| &*run.0).collect();
    let n_runs = designs.len();
    designs.sort_by(|a, b| a.partial_cmp(b).unwrap_or(Ordering::Equal));
    designs.dedup();
    let is_said = response.least().is_some_and(|least| least >= best);
    let is_meant = designs.len() >= FEWEST_AT_AN_END && n_runs < runs.len() && !is_said;
    is_meant.then(|| {
        let (key, word) = (if response.goal == Goal::Minimize { "lower" } else { "upper" }, response.better());
        let sentence = format!(
            "{} of {} designs are {}, and none is {word}. If the sensor tells no more there, set `{key}` = {} in [response]: \
             else {word} values are expected where nothing can tell them.",
            count(n_runs, "result"),
            designs.len(),
            response.value_to(best, f64::NAN),
            plain(response.of_cost(best))
        );
        Finding::new(sentence).with("results at the end", n_runs as f64, "1")
    })
}

/// That all results are the same number.
pub(super) fn all_equal(campaign: &Campaign) -> Option<Finding> {
    let costs = campaign.costs();
    let (first, n) = (costs.first()?, costs.len());
    let is_equal = n >= FEWEST_EQUAL && costs.iter().all(|cost| cost.to_bits() == first.to_bits());
    is_equal.then(|| {
        let all = campaign.problem.response.value_to(*first, f64::NAN);
        Finding::new(format!(
            "Careful: all {n} results are {all}: nothing can be learnt from them. Does the sensor read at all?"
        ))
    })
}

/// That imported experiments of two sources have the same settings and results: of each two sources.
fn imported_twice(campaign: &Campaign) -> Vec<Finding> {
    there_twice(&Twice::among(&campaign.imported, 0))
}

/// What counts, and is far from what all others say, and noise that was given too small: nothing else is worth much before that is put
/// right.
pub(super) fn suspects(campaign: &Campaign, found: &Assessment) -> Vec<Finding> {
    // Runs of equal settings share their distance.
    let is_seen_again = |one: &Outlier| {
        let same = |other: &&Outlier| other.deviations.to_bits() == one.deviations.to_bits();
        found.outliers.iter().filter(same).count() > 1
    };
    let once = outliers(campaign, found, |one| !one.set_aside && !is_seen_again(one)).map(|(n, named)| {
        let (remedy, them) = (remedy(campaign, found), if n == 1 { "it" } else { "them" });
        let sentence = format!(
            "Careful: far from what all others say: {named}. Look at the notes of those runs; {remedy}. Run {them} again before you \
             believe what is recommended."
        );
        Finding::new(sentence).with("outliers", n as f64, "1")
    });
    let again = found.outliers.iter().filter(|one| !one.set_aside && is_seen_again(one));
    let again = seen_again(campaign, found, &again.copied().collect::<Vec<_>>());
    let scale = powers_of_ten(campaign).into_iter().chain(left_from_another_scale(campaign));
    too_small(campaign, found).into_iter().chain(scale).chain(once).chain(again).collect()
}

/// Settings whose runs, more than one, are far from what runs of other settings say: named once, with their number and their mean.
fn seen_again(campaign: &Campaign, found: &Assessment, outliers: &[Outlier]) -> Option<Finding> {
    let (readings, response) = (campaign.readings(), &campaign.problem.response);
    let mut of_settings: Vec<(&Outlier, Vec<f64>)> = Vec::new();
    for outlier in outliers {
        let cost = readings.get(outlier.reading)?.1;
        match of_settings.iter_mut().find(|(first, _)| first.deviations.to_bits() == outlier.deviations.to_bits()) {
            Some((_, costs)) => costs.push(cost),
            None => of_settings.push((outlier, vec![cost])),
        }
    }
    let (n_settings, n_runs) = (of_settings.len(), outliers.len());
    let named = of_settings.iter().take(MOST_NAMED).filter_map(|(outlier, costs)| {
        let place = campaign.problem.describe(&campaign.settings_of(readings.get(outlier.reading)?.0));
        let mean = response.value_to(costs.iter().sum::<f64>() / costs.len() as f64, resolution(found));
        Some(format!("{place} ({}, mean {mean}, {})", count(costs.len(), "run"), far(campaign, outlier)))
    });
    let named = named.collect::<Vec<_>>().join("; ");
    let more = if n_settings > MOST_NAMED { format!("; and {} more", n_settings - MOST_NAMED) } else { String::new() };
    let smooth = match (campaign.settings.smooth, found.smooth_refuted) {
        (_, true) => ": `smooth` in [stop] is not believed while that stands",
        (true, false) => ": `smooth` in [stop] may be wrong",
        (false, false) => "",
    };
    (n_runs > 0).then(|| {
        let sentence = format!(
            "Seen more than once, though far from what runs of other settings say: {named}{more}. The response is steeper or \
             narrower there than the surface takes it to be{smooth}."
        );
        Finding::new(sentence).with("outliers seen again", n_runs as f64, "1")
    })
}

/// What does not count, and why.
fn set_aside(campaign: &Campaign, found: &Assessment) -> Option<Finding> {
    let (n, named) = outliers(campaign, found, |one| one.set_aside)?;
    let remedy = remedy(campaign, found);
    let sentence = format!(
        "Set aside, because other runs of the same settings gave something else, which all others expect: {named}. Look at \
         the notes of those runs; {remedy}."
    );
    Some(Finding::new(sentence).with("outliers", n as f64, "1"))
}

/// How many were measured that the others do not expect, and which of those that are meant.
fn outliers(campaign: &Campaign, found: &Assessment, is_meant: impl Fn(&Outlier) -> bool) -> Option<(usize, String)> {
    let origins = campaign.origins();
    let meant = found.outliers.iter().filter(|outlier| is_meant(outlier));
    let named = meant.clone().take(MOST_NAMED).filter_map(|outlier| {
        let origin = *origins.get(outlier.reading)?;
        Some(format!("{} ({})", campaign.full_name_of(origin), far(campaign, outlier)))
    });
    let (n, named) = (meant.count(), named.collect::<Vec<_>>().join(", "));
    let more = if n > MOST_NAMED { format!(" and {} more", n - MOST_NAMED) } else { String::new() };
    (n > 0).then(|| (n, format!("{named}{more}")))
}

/// "4.1 standard deviations above".
pub(super) fn far(campaign: &Campaign, outlier: &Outlier) -> String {
    let side = campaign.problem.response.side(outlier.deviations);
    format!("{} standard deviations {side}", short(outlier.deviations.abs()))
}

/// What to do about outliers.
fn remedy(campaign: &Campaign, found: &Assessment) -> &'static str {
    let origins = campaign.origins();
    match found.outliers.iter().any(|one| matches!(origins.get(one.reading), Some(Origin::Imported(_)))) {
        true => {
            "`infuse tell --correct` puts a slip right, a run that was spoilt is told as failed, and what was imported is \
             taken back with `infuse import --withdraw`"
        }
        false => "`infuse tell --correct` puts a slip right, and a run that was spoilt is told as failed",
    }
}

/// Results that `[response]` does not allow: its bounds were set, or changed, after them.
fn beyond_the_bounds(campaign: &Campaign) -> Option<Finding> {
    let (response, readings) = (&campaign.problem.response, campaign.readings());
    let beyond = || {
        let fault = |(origin, cost): &(Origin, f64)| Some((*origin, *cost, response.fault(response.of_cost(*cost))?));
        readings.iter().filter_map(fault)
    };
    let (origin, cost, allowed) = beyond().next()?;
    let (n, shown) = (beyond().count(), response.value_to(cost, f64::NAN));
    let results = if n == 1 { "1 result is".to_owned() } else { format!("{n} results are") };
    let sentence = format!(
        "Careful: {results} not {allowed}; the first, {}: {shown}. One of them is wrong: put the result right with `infuse tell --correct`, \
         or the bound in the file. What the bound says of how much better a design may be is left out.",
        campaign.full_name_of(origin)
    );
    Some(Finding::new(sentence).with("results beyond the bounds", n as f64, "1"))
}

/// From so many times what was measured before on, all results of a batch may be in another unit.
const OTHER_UNIT: f64 = 30.0;
/// Of so many results at least.
const FEWEST_TO_COMPARE: usize = 3;

/// That all results of the last batch are far larger, or far smaller, than any before.
fn another_unit(campaign: &Campaign) -> Option<Finding> {
    let last = campaign.experiments.last_batch()?;
    let is_last = |origin: &Origin| match origin {
        Origin::Own(id) => campaign.experiments.trial(*id).is_ok_and(|trial| trial.batch == last),
        Origin::Imported(_) => false,
    };
    let (now, before): (Vec<_>, Vec<_>) = campaign.readings().into_iter().partition(|(origin, _)| is_last(origin));
    if now.len().min(before.len()) < FEWEST_TO_COMPARE {
        return None;
    }
    let sizes = |readings: &[(Origin, f64)]| {
        let sizes = readings.iter().map(|(_, cost)| campaign.problem.response.of_cost(*cost).abs());
        sizes.fold((f64::INFINITY, 0.0_f64), |(least, most), size| (least.min(size), most.max(size)))
    };
    let ((least, most), (least_before, most_before)) = (sizes(&now), sizes(&before));
    let times = if least > OTHER_UNIT * most_before { least / most_before } else { least_before / most };
    let word = if least > most_before { "larger" } else { "smaller" };
    (times > OTHER_UNIT && times.is_finite()).then(|| {
        let is_it = match campaign.problem.response.unit.as_str() {
            "" => "is that the right unit?".to_owned(),
            unit => format!("are they in {unit}?"),
        };
        let sentence = format!(
            "Careful: all {} of batch {last} are at least {} times {word} than any before: {is_it} If not, put them right with \
             `infuse tell --correct`.",
            count(now.len(), "result"),
            short(times.floor())
        );
        Finding::new(sentence).with("times", times, "1")
    })
}
