//! What a campaign of the pooled loop has found, in sentences with their numbers.

use anyhow::Result;
use infuse::global::PureError;
use infuse::pooled::reported::SimulationWorth;
use infuse::pooled::{Assessment, Certificate, Forecast, Needed, Standing, StopBy};
use page::Finding;
use statrs::distribution::{ChiSquared, ContinuousCDF as _};

use super::bands::{IGNORED, NINE_IN_TEN, resolution};
use super::bounds::{constrained_there, likely_to_keep, not_sure, unlikely_to_keep};
use super::campaign::{Campaign, tells_designs_apart};
use super::displaced;
use super::drift;
use super::failures::{FailedSimulations, where_runs_fail};
use super::given_noise::contradiction;
use super::risen::risen;
use super::warnings::{all_equal, suspects, warnings};
use crate::findings::{MUCH_IS_HELD, WITHOUT_RESERVE, by_the_surface_alone, on_bounds};
use crate::number::{count, grouped, percent, plain, short};
use crate::problem::{Problem, Scale};

/// Below this share of the variance explained a simulation is of little use.
const EXPLAINS_LITTLE: f64 = 0.1;
/// Repeats from which on the noise is known: fewer tell it to no better than a factor of two.
const ENOUGH_REPEATS: usize = 5;

/// The recommended design in one sentence, with its settings.
pub(super) fn recommendation(campaign: &Campaign, found: &Assessment) -> Finding {
    let (problem, point) = (&campaign.problem, &found.recommended.point);
    let best = Finding::new(format!("Recommended: {}.", problem.describe(point)));
    let settings = problem.region.parameters().iter().zip(point);
    settings.fold(best, |best, (parameter, &setting)| best.with(parameter.name(), setting, parameter.unit()))
}

/// What is known, in blocks.
pub(super) fn known(campaign: &Campaign, found: &Assessment) -> Result<Vec<Vec<Finding>>> {
    let sure_to_keep = found.recommended.suffices || campaign.problem.constraints.is_empty();
    let mut best = vec![best(campaign, found)?];
    // Before anything that sounds good.
    best.splice(0..0, suspects(campaign, found).into_iter().chain(not_sure(campaign, &found.recommended)));
    let mut certified = vec![certificate(campaign, found)];
    // Before anything is promised, that none is left is not worth saying.
    certified.extend((sure_to_keep && found.needed.is_none()).then(|| left(found)));
    Ok(vec![
        best,
        confirmed(campaign)?,
        certified,
        std::iter::once(simulation(campaign, found)?)
            .chain(FailedSimulations::of(campaign)?.in_words(campaign))
            .chain([noise(campaign, found)])
            .chain(where_runs_fail(campaign))
            .chain(drift::shared(campaign, found)?)
            .chain(plants(campaign, found))
            .collect(),
    ])
}

/// The recommended design with all that is known of it.
fn best(campaign: &Campaign, found: &Assessment) -> Result<Finding> {
    let (problem, response, here) = (&campaign.problem, &campaign.problem.response, &found.recommended);
    let mut best = recommendation(campaign, found).detail(expected(campaign, found, here));
    best = constrained_there(campaign, here).into_iter().fold(best, Finding::detail);
    best = best.detail(run_there(campaign, found, here));
    best = stands_on(campaign, found).into_iter().fold(best, Finding::detail);
    if campaign.is_to_be_asked(here.cell) {
        let sentence = "Whether it can be built is not known: the command of [can_be_built], as it is now, is asked by the next \
                        `infuse ask` or `infuse confirm`.";
        best = best.detail(Finding::new(sentence));
    }
    // Where all results are equal, one design is as good as another.
    let bounds = if all_equal(campaign).is_some() { Vec::new() } else { on_bounds(problem, &here.point) };
    best = bounds.into_iter().fold(best, Finding::detail);
    let measured = campaign.best_measured(found).map(|measured| measured.in_words(campaign, found));
    best = measured.into_iter().fold(best, Finding::detail);
    if let Some(cell) = campaign.choice_of_the_simulation()? {
        let design = problem.describe(&campaign.grid.point(cell)?);
        let there = match (campaign.failure_at(cell), campaign.standing(cell)?) {
            (Some(reason), _) => format!(", where a run failed ({reason})"),
            (None, Some(there)) => {
                let chance = likely_to_keep(campaign, &there);
                let known_to = resolution(found).max(there.deviation);
                format!(", where {} is expected{chance}", response.value_to(there.mean, known_to))
            }
            (None, None) => String::new(),
        };
        let stands = as_it_stands(found).map_or_else(String::new, |stands| format!(", {stands},"));
        let sentence = match campaign.n_simulated_of_many()? {
            Some(n) => {
                let n = count(n, "design");
                format!("Of the {n} simulated so far, the simulation alone{stands} would choose {design}{there}.")
            }
            None => format!("The simulation alone{stands} would have chosen {design}{there}."),
        };
        best = best.detail(Finding::new(sentence));
    }
    Ok(best)
}

/// Where the simulation is displaced, its own choice is that of nobody who knows.
pub(super) fn as_it_stands(found: &Assessment) -> Option<&'static str> {
    found.displacement.as_ref().map(|_| "taken as it stands")
}

/// What is expected at a design, with its band.
fn expected(campaign: &Campaign, found: &Assessment, here: &Standing) -> Finding {
    let response = &campaign.problem.response;
    if found.needed.is_some() {
        let results = match found.forecast.n_readings {
            1 => "one result".to_owned(),
            n => count(n, "result"),
        };
        let sentence = format!(
            "{} there: {} expected; how far off that may be, {results} cannot tell.",
            response.name,
            response.value_to(here.mean, resolution(found).max(here.deviation))
        );
        return Finding::new(sentence).with("expected", response.of_cost(here.mean), &response.unit);
    }
    let beyond = match response.fault(response.of_cost(here.mean)) {
        Some(possible) => format!(" That cannot be measured, only {possible}: the surface knows no bounds."),
        None => String::new(),
    };
    let sentence = format!(
        "{} there: {} expected, give or take {} (90 %).{beyond}",
        response.name,
        response.value_to(here.mean, resolution(found).max(here.deviation)),
        response.amount(NINE_IN_TEN * here.deviation)
    );
    Finding::new(sentence).with("expected", response.of_cost(here.mean), &response.unit).with(
        "give or take",
        response.of_difference(NINE_IN_TEN * here.deviation),
        response.unit_of_differences(),
    )
}

/// How often a design was run, and with what result.
fn run_there(campaign: &Campaign, found: &Assessment, here: &Standing) -> Finding {
    let response = &campaign.problem.response;
    let sentence = match here.measured {
        Some(mean) => {
            let runs = times(here.n_readings);
            let mean_of = if here.n_readings == 1 { "" } else { "on average " };
            format!("It was run {runs}: {mean_of}{} measured.", response.value_to(mean, resolution(found)))
        }
        None if campaign.n_waited_for_at(here.cell) > 0 => match campaign.n_waited_for_at(here.cell) {
            1 => "It was never run; 1 run of it is waited for.".to_owned(),
            n => format!("It was never run; {n} runs of it are waited for."),
        },
        None => match near(campaign, &here.point).as_slice() {
            // Of what can be set anywhere, the next best is always a hair away.
            [] => {
                let best = campaign.best_measured(found);
                let beyond = match best.is_some_and(|best| here.mean < best.without_shift()) {
                    true => " Nothing that was run measured as good.",
                    false => "",
                };
                format!("It was never run: `infuse confirm` plans a few runs there.{beyond}")
            }
            costs => {
                let mean = costs.iter().sum::<f64>() / costs.len() as f64;
                let (runs, mean_of) = match costs.len() {
                    1 => ("1 run lies".to_owned(), ""),
                    n => (format!("{n} runs lie"), "on average "),
                };
                format!(
                    "It was never run, but {runs} within {} of its settings: {mean_of}{} measured.",
                    percent(NEAR),
                    response.value_to(mean, resolution(found))
                )
            }
        },
    };
    let finding = Finding::new(sentence).with("runs there", here.n_readings as f64, "1");
    let measured = here.measured.map(|mean| response.of_cost(mean));
    measured.into_iter().fold(finding, |finding, mean| finding.with("measured there", mean, &response.unit))
}

/// That the recommended design stands on a single run, which the others do not expect, and what it would be without it.
fn stands_on(campaign: &Campaign, found: &Assessment) -> Option<Finding> {
    let (doubted, response) = (found.doubted?, &campaign.problem.response);
    let (_, cost) = *campaign.readings().get(doubted.reading)?;
    let name = campaign.full_name_of(*campaign.origins().get(doubted.reading)?);
    let sentence = format!(
        "It stands on {name} alone ({}), which the others do not expect: without that {} would be expected there. Until it was run \
         again, nobody knows whether it is a slip.",
        response.value_to(cost, resolution(found)),
        response.value_to(doubted.mean_without, resolution(found))
    );
    let finding = Finding::new(sentence);
    Some(finding.with("expected without it", response.of_cost(doubted.mean_without), &response.unit))
}

/// Settings are near if none of them differs by more than this share of its range.
const NEAR: f64 = 0.01;

/// What runs gave whose settings are near.
fn near(campaign: &Campaign, point: &[f64]) -> Vec<f64> {
    let parameters = campaign.problem.region.parameters();
    let is_near = |settings: &[f64]| {
        let mut pairs = parameters.iter().zip(settings.iter().zip(point));
        pairs.all(|(parameter, (a, b))| (a - b).abs() <= NEAR * parameter.width())
    };
    let readings = campaign.readings();
    let near = readings.iter().filter(|(origin, _)| is_near(&campaign.settings_of(*origin)));
    near.map(|(_, cost)| *cost).collect()
}

/// How large a well may be that no run has met.
fn unseen(campaign: &Campaign, found: &Assessment) -> Option<Finding> {
    // Where `smooth` says that there is none.
    if campaign.problem.smooth == Some(true) && !found.smooth_refuted {
        return None;
    }
    let share = found.unseen?;
    let (that_it_lacks, comma) = match campaign.problem.simulator.is_there() {
        true => (" that the simulation lacks,", ","),
        false => ("", ""),
    };
    let well = campaign.problem.response.well();
    let sentence = format!(
        "A {well}{that_it_lacks} of less than {} of all designs{comma} may be unseen: as many runs, evenly spread, would have met a \
         larger one with {} probability.",
        percent(share),
        percent(found.certificate.probability)
    );
    Some(Finding::new(sentence).with("share of all designs that a well may take unseen", share, "1"))
}

/// By how much another design may be better, where that is said.
pub(super) fn promised(campaign: &Campaign, found: &Assessment) -> Option<f64> {
    found.bound().filter(|_| all_equal(campaign).is_none())
}

/// How much better another design may be, and what follows for the stop.
fn certificate(campaign: &Campaign, found: &Assessment) -> Finding {
    let (response, certificate) = (&campaign.problem.response, &found.certificate);
    if not_sure(campaign, &found.recommended).is_some() {
        let sentence = "How far it is from the best is not said: where no design is known to keep to the bounds, there is no best.";
        return Finding::new(sentence);
    }
    if let Some(needed) = found.needed.filter(|needed| *needed != Needed::Difference || all_equal(campaign).is_none()) {
        let until = match needed {
            Needed::Readings(n) => format!("before there are {n} results: {} so far", found.forecast.n_readings),
            Needed::Designs(n) => format!("before {n} different designs were run: {} so far", found.forecast.n_tried),
            Needed::Difference => "before results differ".to_owned(),
            Needed::Signal => "before results tell of the parameters: these may be noise alone".to_owned(),
            Needed::Repeat => {
                "before a design is run again, or `noise` in [loop] is given: what they differ by may be noise"
                    .to_owned()
            }
        };
        return Finding::new(format!("By how much another design may be better cannot be said {until}. Go on."));
    }
    if all_equal(campaign).is_some() {
        let sentence = "By how much another design may be better cannot be said. All results are equal: whether to go on, they cannot tell.";
        return Finding::new(sentence);
    }
    let alone = alone(campaign, found).map_or_else(String::new, |alone| format!("; by the surface alone, by {alone}"));
    let sentence = format!("With {}{alone}.", none_better(&campaign.problem, certificate));
    let simulation = match campaign.problem.simulator.is_there() {
        true => " on the simulation as far as these agree with it,",
        false => "",
    };
    let excepted = excepted(campaign, found);
    let wells = match (campaign.problem.smooth, excepted) {
        (Some(true), _) if !found.smooth_refuted => {
            format!(", without narrow {}s as `smooth` says", response.well())
        }
        (_, Some(_)) => format!(", without a {} that no run has met", response.well()),
        _ => String::new(),
    };
    let rests = match found.forecast.of_means {
        Some(_) => {
            "It rests on the runs of each design alone: Student's test of the differences of their means.".to_owned()
        }
        None => format!(
            "It rests on the measurements,{simulation} and on a response as smooth as the surface assumes{wells}."
        ),
    };
    let finding = Finding::new(sentence)
        .with("probability", certificate.probability, "1")
        .with("bound", response.of_difference(certificate.bound), response.unit_of_differences())
        .detail(Finding::new(rests));
    let quantile = (!alone.is_empty()).then(|| response.of_difference(certificate.quantile));
    let finding = quantile.into_iter().fold(finding, |finding, alone| {
        finding.with("bound by the surface alone", alone, response.unit_of_differences())
    });
    let finding = risen(campaign, found).into_iter().fold(finding, Finding::detail);
    let finding = held_for_the_unseen(campaign, found).into_iter().fold(finding, Finding::detail);
    let finding = unseen(campaign, found).into_iter().fold(finding, Finding::detail);
    match campaign.settings.worth {
        None => {
            let sentence = match campaign.settings.stop_by {
                StopBy::Bound => "`worth` in [stop] says from what gain on another batch is worth its cost.",
                _ => {
                    "`worth` in [stop] says from what gain on another batch is worth its cost: without it `by` ends nothing."
                }
            };
            finding.detail(Finding::new(sentence))
        }
        Some(worth) => {
            let stop_by = campaign.settings.stop_by;
            let of_worth = format!("{} of `worth`", response.the_amount(worth));
            let that = what_stops(campaign, &alone);
            let is_enough = found.bound_to_stop_by(stop_by).is_some_and(|left| left <= worth);
            let may_be_unseen = match stop_by {
                StopBy::Bound => excepted,
                _ => unseen_share(campaign, found),
            };
            let sentence = match (is_enough, found.further_batches) {
                (true, _) if found.contradiction.is_some() => {
                    format!("{that} is no more than {of_worth}, but a measurement speaks against it: go on.")
                }
                (true, _) => match may_be_unseen {
                    Some(_) => format!(
                        "{that} is no more than {of_worth}: stop, unless such a {} may be there.",
                        response.well()
                    ),
                    None => format!("{that} is no more than {of_worth}: stop."),
                },
                (false, Some(batches)) if batches <= campaign.n_left() as u64 => {
                    let n = count(usize::try_from(batches).unwrap_or(usize::MAX), "more batch");
                    format!("{that} is more than {of_worth}: go on; {n} may do.")
                }
                (false, Some(batches)) if campaign.n_left() > 0 => format!(
                    "{that} is more than {of_worth}: go on, though {} that [loop] `batches` leaves may not do: {} may be needed.",
                    match campaign.n_left() {
                        1 => "the one batch".to_owned(),
                        n => format!("the {}", count(n, "batch")),
                    },
                    grouped(batches)
                ),
                (false, None) => {
                    format!("{that} is more than {of_worth}: {}", beyond_any_forecast(campaign, found, worth))
                }
                (false, _) if campaign.n_left() == 0 => {
                    format!("{that} is more than {of_worth}, and [loop] `batches` leaves none.")
                }
                (false, _) => format!("{that} is more than {of_worth}: go on."),
            };
            let unit = response.unit_of_differences();
            let about_worth = Finding::new(sentence).with("worth", response.of_difference(worth), unit);
            let further = found.further_batches.filter(|_| !is_enough);
            let about_worth = further
                .into_iter()
                .fold(about_worth, |finding, batches| finding.with("further batches", batches as f64, "1"));
            let finding = finding.detail(about_worth);
            may_end_now(campaign, found, worth).into_iter().fold(finding, Finding::detail)
        }
    }
}

/// What has to be no more than `worth`: where two numbers were said, which of them.
fn what_stops(campaign: &Campaign, alone: &str) -> &'static str {
    match (campaign.settings.stop_by, alone.is_empty()) {
        (_, true) => "That",
        (StopBy::Bound, false) => "The bound",
        _ => "By the surface alone, by which `by` in [stop] stops, it",
    }
}

/// How the campaign would end now, were less held for what nobody has seen.
fn may_end_now(campaign: &Campaign, found: &Assessment, worth: f64) -> Option<Finding> {
    let Assessment { forecast, contradiction, smooth_refuted, .. } = found;
    if campaign.settings.stop_by != StopBy::Bound || contradiction.is_some() || found.certificate.bound <= worth {
        return None;
    }
    let well = campaign.problem.response.well();
    let is_held = forecast.reserves_until().is_some() && forecast.drawn <= worth && !smooth_refuted;
    let by_the_surface = "`by = \"surface\"` under [stop]";
    let sentence = match (is_held, forecast.by_the_surface() <= worth) {
        (true, _) => format!(
            "Nothing but what is held for a narrow {well} keeps the campaign going: if the response surely has none, write `smooth = true` \
             under [stop], and it may end now; {by_the_surface} ends it at the risk that there is one."
        ),
        (false, true) => format!(
            "By the surface alone it may end now: {by_the_surface} does so, at the risk of what so few results may not have shown."
        ),
        (false, false) => return None,
    };
    Some(Finding::new(sentence))
}

/// That more batches may be needed than anyone makes, and whether the noise allows for so small a `worth` at all.
fn beyond_any_forecast(campaign: &Campaign, found: &Assessment, worth: f64) -> String {
    let (response, most) = (&campaign.problem.response, Forecast::MOST_BATCHES);
    // Of what is taken for exact the surface keeps a little, so that it can be computed.
    let told_apart = if found.is_exact { 0.0 } else { found.forecast.told_apart(found.noise) };
    let why = match worth < told_apart {
        true => format!(
            "So small a `worth` is less than the noise lets anyone find: with {} (standard deviation of one run) even {most} batches of {}, all of two \
             designs, tell which is better only where they differ by {} or more",
            response.amount(found.noise),
            count(found.forecast.n_experiments, "run"),
            response.amount(told_apart)
        ),
        false => format!("By batches of {} it is out of reach", count(found.forecast.n_experiments, "run")),
    };
    let ends = match campaign.n_left() {
        0 => "[loop] `batches` leaves none".to_owned(),
        n => format!("the campaign ends with the {} that [loop] `batches` leaves", count(n, "batch")),
    };
    format!("more than {most} batches may be needed. {why}: choose a larger `worth`, or {ends}.")
}

/// The share of all designs that a well may take which the certificate does not reckon with: what is held for one is less than results
/// differ by. Such a well may be as deep as that.
fn excepted(campaign: &Campaign, found: &Assessment) -> Option<f64> {
    let is_held = found.certificate.bound >= found.forecast.spread;
    if is_held { None } else { unseen_share(campaign, found) }
}

/// From this share of what runs of a plant share on it is said that it may be the plants' own.
const MUCH_IS_OWN: f64 = 0.3;
/// "more than 0.2 mm": what is left by the surface alone, where that is said.
fn alone(campaign: &Campaign, found: &Assessment) -> Option<String> {
    let Certificate { bound, quantile, .. } = found.certificate;
    by_the_surface_alone(&campaign.problem.response, bound, quantile)
}

/// The share of all designs that a well may take unseen, unless it is said that there is none.
fn unseen_share(campaign: &Campaign, found: &Assessment) -> Option<f64> {
    let is_smooth = campaign.problem.smooth == Some(true) && !found.smooth_refuted;
    if is_smooth { None } else { found.unseen }
}

/// How many designs count as run.
fn so_far(forecast: &Forecast) -> String {
    let crowding = match forecast.crowded > 0.0 {
        true => ", and imported ones that crowd for as few as would tell as much",
        false => "",
    };
    format!("{} so far, a repeat counting half{crowding}", plain(forecast.n_counted()))
}

/// What it is that the least of the response leaves less of: that a narrow well is held for.
fn even_more(campaign: &Campaign, found: &Assessment) -> String {
    let (response, forecast) = (&campaign.problem.response, Forecast { most: None, ..found.forecast });
    let Some(enough) = forecast.reserves_until() else { return String::new() };
    format!(
        " Even more is held for a narrow {} that no run may have met, until {enough} designs were run ({}){}.",
        response.well(),
        so_far(&forecast),
        if found.smooth_refuted { "" } else { ", or `smooth` in [stop] says that there is none" }
    )
}

/// How much of the bound is not what the surface says, but is kept for what so few experiments cannot have shown.
fn held_for_the_unseen(campaign: &Campaign, found: &Assessment) -> Option<Finding> {
    let (response, Certificate { bound, quantile, .. }) = (&campaign.problem.response, found.certificate);
    if let (true, Some(least)) = (found.forecast.is_for_the_least(), response.least()) {
        let sentence = format!(
            "More is not to be had: that is what is left {} to {}, the best that [response] allows, from as far off as the \
             recommended design may be.{}",
            response.better_way(),
            response.value_to(least, 0.0),
            even_more(campaign, found)
        );
        return Some(Finding::new(sentence).with("the best value allowed", response.of_cost(least), &response.unit));
    }
    if bound - quantile <= MUCH_IS_HELD * bound {
        return None;
    }
    let forecast = &found.forecast;
    let well = response.well();
    let few = format!("what {} may not have shown", count(forecast.n_readings, "result"));
    let until = forecast.reserves_until();
    let sentence = match until {
        Some(enough) => {
            let is_widened = forecast.drawn - quantile > MUCH_IS_HELD * forecast.drawn;
            let widened = match is_widened {
                true => format!("With {few} it would be {}. ", response.amount(forecast.drawn)),
                false => String::new(),
            };
            let shown = forecast.narrow.map_or_else(String::new, |share| {
                format!(" The simulation has one of {} of all designs, so that there may be others.", percent(share))
            });
            let or_smooth = match found.smooth_refuted {
                true => "",
                false => ", or by `smooth` in [stop] if there surely is none",
            };
            format!(
                "{widened}The rest is held for a narrow {well} that no run may have met. It falls away \
                 at {enough} designs run ({}){or_smooth}.{shown}",
                so_far(forecast)
            )
        }
        None if forecast.is_for_a_find() => match &found.find {
            Some(find) => format!(
                "The rest is held for a narrow {well} of which only a part may have been found: far \
                 better than runs elsewhere say was {}. The next batch looks around it.",
                campaign.problem.describe(find)
            ),
            None => "The rest is what a measured design is better by that contradicts the recommendation.".to_owned(),
        },
        None => format!("The rest is held for {few}."),
    };
    let (quantile, unit) = (response.of_difference(quantile), response.unit_of_differences());
    let finding = Finding::new(sentence).with("by the surface alone", quantile, unit);
    Some(match until {
        Some(enough) => finding.with(WITHOUT_RESERVE, enough as f64, "1"),
        None => finding,
    })
}

/// The designs that may still be the best, the recommended one among them.
fn left(found: &Assessment) -> Finding {
    let which = match found.left {
        _ if found.n_left == Some(1) => "no other design".to_owned(),
        tiny if tiny < 1e-4 => "less than 0.01 % of all designs".to_owned(),
        share => format!("{} of all designs, the recommended one included,", percent(share)),
    };
    Finding::new(format!("By the surface alone, {which} may still be the best.")).with("left", found.left, "1")
}

/// "90 % probability no design is better than it by more than 0.2 mm".
pub(super) fn none_better(problem: &Problem, certificate: &Certificate) -> String {
    let response = &problem.response;
    let is_confined = if problem.constraints.is_empty() { "" } else { "that keeps to the bounds " };
    let probability = percent(certificate.probability);
    let by = match certificate.bound {
        bound if bound > 0.0 => format!(" by more than {}", response.amount(bound)),
        _ => String::new(),
    };
    format!("{probability} probability no design {is_confined}is better than the recommended one{by}")
}

/// What the simulation is worth.
fn simulation(campaign: &Campaign, found: &Assessment) -> Result<Finding> {
    let simulated = campaign.simulated()?;
    Ok(match found.simulation {
        _ if !campaign.problem.simulator.is_there() => Finding::new(
            "There is no simulation: experiments alone tell, and more of them are needed than with a good one.",
        ),
        _ if simulated.is_empty() => Finding::new(
            "There is no simulation to learn from yet: every one failed, or none was run of what `[simulator]` says now; \
                 `infuse ask` runs some.",
        ),
        _ if simulated.len() > 1 && !tells_designs_apart(&simulated) => {
            Finding::new("The simulation gives the same value everywhere: it tells nothing.")
        }
        None => Finding::new("What the simulation is worth, too few experiments tell."),
        Some(worth) => {
            let finding = Finding::new(worth_in_words(worth, campaign.problem.response.scale))
                .with("explained", worth.explained, "1")
                .with("probability that it is better ignored", worth.ignored, "1")
                .with("factor", worth.factor, "1")
                .with("give or take", NINE_IN_TEN * worth.factor_deviation, "1");
            displaced::findings(campaign, found).into_iter().fold(finding, Finding::detail)
        }
    })
}

/// How much of what was measured a simulation explains, and what the surface makes of it.
fn worth_in_words(worth: SimulationWorth, scale: Scale) -> String {
    let SimulationWorth { explained, is_inverted, ignored, factor, factor_deviation } = worth;
    let (is_little, is_left_out) = (explained < EXPLAINS_LITTLE, ignored >= IGNORED);
    let half = NINE_IN_TEN * factor_deviation;
    // Where a factor is learnt, its sign tells, whatever the places were that were run.
    let is_wrong_way = match is_left_out || half < TAKEN_AS_GIVEN {
        true => is_inverted && !is_little,
        false => factor + half < 0.0,
    };
    let share = percent(explained);
    let mut sentence = match is_wrong_way {
        true => format!(
            "The simulation points the wrong way: what it calls better was worse. Turned round it explains {share} of the variance of \
             what was measured"
        ),
        false => format!("The simulation explains {share} of the variance of what was measured"),
    };
    if is_little {
        // What is left in y − s may be simpler than y, though s and y do not go together.
        sentence.push_str(match is_left_out {
            true => ": it is of little use",
            false => ": little by itself, but what it is off by is easier to learn than the response",
        });
    }
    match (is_little, is_left_out) {
        (true, true) => sentence.push_str(", and hardly used: what is recommended rests on the experiments"),
        (false, true) => sentence.push_str(
            ", but is hardly used: by now a surface through the experiments alone predicts them at least as well",
        ),
        (_, false) => {
            let (shown, give_or_take) = (short(factor), short(half));
            sentence.push_str(&match (scale, half < TAKEN_AS_GIVEN) {
                (Scale::Linear, true) => format!("; differences that it predicts are taken {}", as_they_are(factor)),
                (Scale::Linear, false) => {
                    format!("; differences that it predicts count {shown} times, give or take {give_or_take} (90 %)")
                }
                (Scale::Log, true) if (factor - 1.0).abs() < TAKEN_AS_GIVEN => {
                    "; ratios that it predicts are taken as they are".to_owned()
                }
                (Scale::Log, true) => format!("; ratios that it predicts are taken to the power of {shown}"),
                (Scale::Log, false) => {
                    format!("; ratios that it predicts are taken to the power of {shown}, give or take {give_or_take} (90 %)")
                }
            });
        }
    }
    format!("{sentence}.")
}

/// Below this nothing is in doubt: what is measured is the simulation and a discrepancy, whose factor is 1.
const TAKEN_AS_GIVEN: f64 = 1e-4;

fn as_they_are(factor: f64) -> String {
    if (factor - 1.0).abs() < TAKEN_AS_GIVEN { "as they are".to_owned() } else { format!("{} times", short(factor)) }
}

/// "once", "7 times".
fn times(n: usize) -> String {
    if n == 1 { "once".to_owned() } else { format!("{n} times") }
}

fn noise(campaign: &Campaign, found: &Assessment) -> Finding {
    let response = &campaign.problem.response;
    let deviation = response.amount(found.noise);
    let sentence = match (campaign.settings.noise, found.n_repeats) {
        (Some(given), _) => {
            let given = response.amount(given);
            let untested = match (found.n_repeats, contradiction(campaign, found)) {
                (0, _) => not_tested(campaign, found),
                (_, Some(repeats)) => {
                    format!(" Repeats contradict that: {}.", response.amount(repeats.measured()))
                }
                _ => String::new(),
            };
            format!("Noise of one run: {given} (standard deviation), as `noise` in [loop] says.{untested}")
        }
        (None, 0) if campaign.origins().len() < 3 => "Noise of one run: too few runs to know it.".to_owned(),
        (None, 0) => {
            let twice =
                if found.assembly.is_some() && differs_between_blocks(campaign) { " within a batch" } else { "" };
            format!(
                "Noise of one run: about {deviation} by the surface; it is not known, nothing was run twice{twice}."
            )
        }
        (None, n) if campaign.repeats(found).is_some_and(|repeats| repeats.variance <= 0.0) => {
            let differ = if n == 1 { "the one repeat does not" } else { &*format!("the {n} repeats do not") };
            match found.is_exact {
                false if differs_between_blocks(campaign) => format!(
                    "Noise of one run: about {deviation} by the surface; it is not known. Within a batch {differ} differ at all, but runs of \
                     one design in different batches do, and only where none differ the noise is taken for none. If there surely is none, \
                     give `noise = 0` and `blocks = true` in [loop]."
                ),
                true => format!(
                    "Noise of one run: taken for none, as {differ} differ at all, until one does. If that may be chance, give `noise` in [loop]."
                ),
                false => format!(
                    "Noise of one run: about {deviation} by the surface; it is not known, {differ} differ at all."
                ),
            }
        }
        (None, n) if n < ENOUGH_REPEATS => {
            let few = if n == 1 { "one repeat is" } else { &*format!("{n} repeats are") };
            format!("Noise of one run: about {deviation} by the surface; it is not known, {few} too few.")
        }
        (None, n) => match campaign
            .repeats(found)
            .filter(|repeats| scatter_far_less(repeats.variance, repeats.degrees_of_freedom, found.noise))
        {
            Some(repeats) => {
                let rest = match found.is_drifting() && found.assembly.is_none() {
                    true => "what runs of a batch share, as far as it goes",
                    false => "what the surface misses, as a well or an edge that is narrower than it expects",
                };
                format!(
                    "Noise of one run: {deviation} (standard deviation) by the surface, though the {n} repeats say {}: the rest is {rest}.",
                    response.amount(repeats.standard_deviation())
                )
            }
            None => {
                format!(
                    "Noise of one run: {deviation} (standard deviation), from {} and what the surface leaves.",
                    count(n, "repeat")
                )
            }
        },
    };
    let (noise, unit) = (response.of_difference(found.noise), response.unit_of_differences());
    Finding::new(sentence).with("noise", noise, unit).with("repeats", found.n_repeats as f64, "1")
}

/// Why nothing has put the noise that was given to the test.
fn not_tested(campaign: &Campaign, found: &Assessment) -> String {
    let is_repeated = PureError::of_readings(campaign.runs()).is_some();
    let why = match (found.assembly.is_some(), campaign.settings.plants.is_some()) {
        (true, false) if is_repeated => {
            "No design was run twice within a batch or source, and runs of two of these differ by what they are off by"
        }
        (true, true) if is_repeated => {
            "No design was run twice on a plant as it was put together, and runs on others differ by what these are off by"
        }
        _ => "Nothing was run twice",
    };
    format!(" {why}, so nothing has put it to the test.")
}

/// Whether runs of equal settings differ, whatever batches they are of.
fn differs_between_blocks(campaign: &Campaign) -> bool {
    PureError::of_readings(campaign.runs()).is_some_and(|repeats| repeats.variance > 0.0)
}

/// Repeats that scatter as little are less likely than this, if what the surface takes for noise were noise.
const UNLIKELY: f64 = 0.01;

/// Whether repeats say that the noise is less than this, beyond chance: their sum of squares is χ² of their number of times its square.
fn scatter_far_less(variance: f64, degrees_of_freedom: usize, noise: f64) -> bool {
    let n = degrees_of_freedom as f64;
    let sum_of_squares = n * variance / (noise * noise);
    ChiSquared::new(n).is_ok_and(|chi_squared| chi_squared.cdf(sum_of_squares) < UNLIKELY)
}

/// What was spent, and what the runs of a plant share.
fn plants(campaign: &Campaign, found: &Assessment) -> Option<Finding> {
    let costs = campaign.problem.costs.as_ref()?;
    let (spent, n_plants) = campaign.spent_until(campaign.batches.len())?;
    let runs = count(campaign.experiments.n_made(), "run");
    let sentence =
        format!("Spent so far: {} for {runs} on {}.", costs.shown(spent), count(n_plants, "assembled plant"));
    let mut finding =
        Finding::new(sentence).with("spent", spent, costs.unit()).with("plants assembled", n_plants as f64, "1");
    if let Some(shared) = found.assembly {
        let response = &campaign.problem.response;
        let unit = response.unit_of_differences();
        let sentence = format!(
            "All runs of a plant, as it was put together for a batch, share an error: {} (standard deviation), as far as the \
             runs tell it from the noise.",
            response.amount(shared)
        );
        finding = finding.detail(Finding::new(sentence).with("shared error", response.of_difference(shared), unit));
        let (own, n_again) = (found.own.unwrap_or(0.0), found.n_again.unwrap_or(0));
        if own > MUCH_IS_OWN * shared {
            let why = match n_again {
                0 => "no plant was put together a second time, which alone would tell".to_owned(),
                _ => format!("plants were put together again {}, and differed by less", times(n_again)),
            };
            let sentence = format!(
                "As much as {} of that may be the plants' own, and no error: {why}. The bound allows for it.",
                response.amount(own)
            );
            finding = finding.detail(Finding::new(sentence).with("the plants' own", response.of_difference(own), unit));
        }
    }
    Some(finding)
}

/// What the last batch taught, in short.
pub(super) fn lesson(campaign: &Campaign) -> Result<Vec<Finding>> {
    let Some(found) = campaign.assessment()? else {
        return Ok(vec![Finding::new("No experiment gave a result yet, so nothing is known.")]);
    };
    let mut lesson: Vec<Finding> =
        suspects(campaign, &found).into_iter().chain(not_sure(campaign, &found.recommended)).collect();
    lesson.push(recommendation(campaign, &found).detail(expected(campaign, &found, &found.recommended)));
    lesson.push(certificate(campaign, &found));
    lesson.extend(warnings(campaign, &found)?);
    Ok(lesson)
}

/// The last batch in one line.
pub(super) fn closed(campaign: &Campaign, found: &Assessment) -> Finding {
    let (response, here) = (&campaign.problem.response, &found.recommended);
    let promise = match not_sure(campaign, here) {
        Some(_) => format!("no design is known to keep to the bounds, this one{}", likely_to_keep(campaign, here)),
        None if promised(campaign, found).is_none() => "by how much others may be better cannot be said yet".to_owned(),
        None => format!(
            "none better by more than {} ({}){}",
            response.amount(found.certificate.bound),
            percent(found.certificate.probability),
            alone(campaign, found).map_or_else(String::new, |alone| format!(", by the surface alone by {alone}"))
        ),
    };
    let sentence = format!(
        "batch {}: {}; {} expected, {promise}",
        campaign.batches.len(),
        campaign.problem.describe(&here.point),
        response.value_to(here.mean, resolution(found).max(here.deviation)),
    );
    let finding = Finding::new(sentence).with("expected", response.of_cost(here.mean), &response.unit);
    let unit = response.unit_of_differences();
    let bounds = promised(campaign, found).map(|bound| response.of_difference(bound));
    bounds.into_iter().fold(finding, |finding, bound| finding.with("bound", bound, unit))
}

/// What is known of one design, and whether it may still be the best; it may lie between those that can be set.
pub(super) fn standing_in_words(campaign: &Campaign, asked: &[f64]) -> Result<Finding> {
    let (place, cell) = campaign.nearest(asked)?;
    let response = &campaign.problem.response;
    let (Some(there), Some(found)) = (campaign.standing(cell)?, campaign.assessment()?) else {
        return Ok(Finding::new(format!("{place}: nothing is known of any design yet.")));
    };
    let failure = campaign.failure_at(cell);
    let verdict = if there.cell == found.recommended.cell {
        "it is the recommended design".to_owned()
    } else if let Some(reason) = &failure {
        format!("a run there failed ({reason}), so it is neither asked for again nor recommended")
    } else {
        let may = if there.may_be_best { "may still be the best" } else { "is not thought to be the best" };
        let chance = match there.probability_better {
            tiny if tiny < 1e-4 => "less than 0.01 %".to_owned(),
            share => percent(share),
        };
        let feasible = if there.feasible < 1.0 {
            format!("; a run there gives a value with {} probability", percent(there.feasible))
        } else {
            String::new()
        };
        let breaks = match unlikely_to_keep(&there) {
            Some(within) => format!(
                "it is likely to break a bound, and keeps to all with {} probability; by the surface alone it {may}",
                percent(within)
            ),
            None => format!("by the surface alone it {may}"),
        };
        format!("{breaks}: better than the recommended one with {chance} probability{feasible}")
    };
    let sentence = format!("{place}: {verdict}.");
    let mut finding = Finding::new(sentence).with("probability to be better", there.probability_better, "1").with(
        "probability of a value",
        there.feasible,
        "1",
    );
    if failure.is_none() {
        finding = finding.detail(expected(campaign, &found, &there));
    }
    finding = constrained_there(campaign, &there).into_iter().fold(finding, Finding::detail);
    finding = displaced::beyond(campaign, &found, &there.point).into_iter().fold(finding, Finding::detail);
    if let Some(why_not) = campaign.why_not(cell) {
        finding = finding.detail(Finding::new(format!("It is not to be had: {why_not}.")));
    }
    if let Some(measured) = there.measured {
        let runs = count(there.n_readings, "run");
        finding = finding
            .detail(Finding::new(format!("{runs} there, mean {}.", response.value_to(measured, resolution(&found)))));
    }
    Ok(finding)
}

/// What the last confirming runs measured.
fn confirmed(campaign: &Campaign) -> Result<Vec<Finding>> {
    Ok(campaign.confirmation()?.map(|confirmation| confirmation.in_words(campaign)).into_iter().collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// scipy: chi2.cdf(2.5, 10) = 0.0091, chi2.cdf(2.704, 10) = 0.0124, chi2.cdf(0.735, 6) = 0.0063, chi2.cdf(0.96, 6) = 0.0129.
    #[test]
    fn repeats_scatter_far_less_where_one_time_in_a_hundred_they_would_by_chance() {
        for (degrees_of_freedom, ratio, is_far) in
            [(10, 0.5, true), (10, 0.52, false), (6, 0.35, true), (6, 0.4, false)]
        {
            assert_eq!(
                scatter_far_less(ratio * ratio * 9.0, degrees_of_freedom, 3.0),
                is_far,
                "{degrees_of_freedom} repeats, {ratio}"
            );
        }
        assert!(!scatter_far_less(1.0, 9, 0.0));
    }

    #[test]
    fn a_simulation_is_said_to_be_hardly_used_only_where_it_is() {
        let said = |explained: f64, ignored: f64| {
            let worth = SimulationWorth { explained, is_inverted: false, ignored, factor: 1.0, factor_deviation: 0.0 };
            worth_in_words(worth, Scale::Linear)
        };
        assert_eq!(
            said(0.81, 0.95),
            "The simulation explains 81 % of the variance of what was measured, but is hardly used: by now a surface through \
             the experiments alone predicts them at least as well."
        );
        let inverted = |ignored: f64, factor: f64, factor_deviation: f64| {
            let worth = SimulationWorth { explained: 0.8, is_inverted: true, ignored, factor, factor_deviation };
            worth_in_words(worth, Scale::Linear)
        };
        let wrong_way = "The simulation points the wrong way: what it calls better was worse. ";
        for (ignored, factor, deviation, is_said) in [
            (0.95, 1.0, 0.0, true),
            (0.2, 1.0, 0.0, true),
            (0.2, 0.18, 0.05, false),
            (0.2, -0.8, 0.1, true),
            (0.2, -0.8, 0.6, false),
        ] {
            assert_eq!(inverted(ignored, factor, deviation).starts_with(wrong_way), is_said, "{factor}, {deviation}");
        }
        assert!(said(0.05, 0.95).ends_with(
            "measured: it is of little use, and hardly used: what is recommended rests on the experiments."
        ));
        assert!(said(0.05, 0.2).ends_with(
            "measured: little by itself, but what it is off by is easier to learn than the response; differences that it predicts are \
             taken as they are."
        ));
        assert!(said(0.81, 0.2).ends_with("measured; differences that it predicts are taken as they are."));
    }

    #[test]
    fn a_factor_that_is_not_in_doubt_has_no_band() {
        assert_eq!(as_they_are(1.0), "as they are");
        assert_eq!(as_they_are(1.25), "1.25 times");
    }
}
