//! That runs of a batch read otherwise than those of others, in words and as JSON.

use std::cmp::Ordering;

use anyhow::Result;
use infuse::pooled::reported::{Block, Drift, Shift};
use infuse::pooled::{Assessment, Settings};
use page::Finding;
use serde_json::{Value, json};

use super::campaign::Campaign;
use crate::number::{short, with_unit};
use crate::problem::Held;

/// Blocks that are named, those that are farthest off, of those of so many runs at least.
const MOST_NAMED: usize = 6;
const FEWEST: usize = 3;
/// The name of a number.
const TIMES: &str = "times more probable, logarithm";

/// The responses of which the results are sure that they drift.
pub(super) fn drifting<'a>(campaign: &'a Campaign, found: &'a Assessment) -> impl Iterator<Item = &'a str> {
    let problem = &campaign.problem;
    let names = std::iter::once(problem.response.name.as_str()).chain(problem.constraints.iter().map(Held::name));
    let drifts = std::iter::once(&found.drift).chain(&found.constrained_drifts);
    let sure = names.zip(drifts).filter(|(_, drift)| drift.as_ref().is_some_and(Drift::is_sure));
    sure.map(|(name, _)| name)
}

/// That results were sure of it after the batch before, and are not any more.
pub(super) fn no_more(campaign: &Campaign, found: &Assessment) -> Option<Finding> {
    if campaign.settings.blocks.is_some() || campaign.settings.plants.is_some() {
        return None;
    }
    let before = campaign.history.range(..campaign.batches.len()).next_back()?.1;
    let now: Vec<&str> = drifting(campaign, found).collect();
    let gone: Vec<String> =
        before.drifting.iter().filter(|name| !now.contains(&name.as_str())).map(|name| format!("`{name}`")).collect();
    let sentence = format!(
        "Careful: after batch {} the results were sure that runs of one batch read alike in {}; by all that is known now they are not, so that \
         nothing is taken in for that. One result far from all others can do so. `blocks = true` in [loop] keeps it.",
        before.batch,
        gone.join(", ")
    );
    (!gone.is_empty()).then(|| Finding::new(sentence))
}

/// That the rig drifts, as far as results are sure of it, and what allows for that: of the response, and of each one that is constrained.
pub(super) fn warnings(campaign: &Campaign, found: &Assessment) -> Vec<Finding> {
    let response = &campaign.problem.response;
    let of_response = found.drift.as_ref().filter(|drift| drift.is_sure()).map(|drift| {
        let shifts = if found.shifts.is_empty() { &drift.shifts } else { &found.shifts };
        let named = named_of_response(campaign, shifts);
        let shared = found.assembly.map(|shared| response.amount(shared));
        let has_it = if shared.is_none() && campaign.settings.noise.is_none() { ", with that in it" } else { "" };
        let noise = format!("{}{has_it}", response.amount(found.noise));
        let finding = warning("", &named, &noise, drift, shared);
        let deviation = response.of_difference(found.assembly.unwrap_or(drift.deviation));
        let unit = response.unit_of_differences();
        finding.with("shared by runs of a batch", deviation, unit)
    });
    let of_each = campaign.problem.constraints.iter().zip(&found.constrained_drifts).enumerate();
    let of_constraints = of_each.filter_map(|(index, (held, drift))| {
        let drift = drift.as_ref().filter(|drift| drift.is_sure())?;
        let amount = |amount: f64| with_unit(&short(amount), &held.unit);
        let named = named_of_constraint(held, &drift.shifts);
        let what = format!(" in `{}`", held.name());
        let shared = found.constrained_shared.get(index).copied().flatten();
        let finding = warning(&what, &named, &amount(drift.noise), drift, shared.map(amount));
        Some(finding.with("shared by runs of a batch", shared.unwrap_or(drift.deviation), &held.unit))
    });
    of_response.into_iter().chain(of_constraints).collect()
}

/// By how much blocks are off in the response, as [`named`] has them.
fn named_of_response(campaign: &Campaign, shifts: &[Shift]) -> String {
    let response = &campaign.problem.response;
    named(shifts, |by| format!("{} {}", response.amount(by.abs()), response.side(by)))
}

/// The same of a response that is constrained.
fn named_of_constraint(held: &Held, shifts: &[Shift]) -> String {
    let side = |by: f64| if by < 0.0 { "below" } else { "above" };
    named(shifts, |by| format!("{} {}", with_unit(&short(by.abs()), &held.unit), side(by)))
}

/// `shared` is the error that runs of a block share, where it is taken in.
fn warning(what: &str, named: &str, noise: &str, drift: &Drift, shared: Option<String>) -> Finding {
    let farthest = drift.shifts.iter().max_by(|a, b| a.by.abs().total_cmp(&b.by.abs()));
    let question = match farthest.is_some_and(|far| matches!(far.block, Block::Source(_))) {
        true => "Does another rig, or another day, read otherwise?",
        false => "Does the rig drift from day to day?",
    };
    let so = match shared {
        Some(shared) => format!(
            "That is taken in: they share an error of {shared} (standard deviation), and what is expected is the mean over batches and sources \
             (`blocks` in [loop])."
        ),
        None => "`blocks = false` in [loop] leaves it so; without it they share an error that is learnt.".to_owned(),
    };
    let sentence = format!(
        "Careful: runs of one batch, or of one source, read alike{what}, beyond what their settings explain: {named} what is expected of them, in \
         the mean; the noise of one run is about {noise}. {question} {so}"
    );
    with_gain(Finding::new(sentence), Some(drift))
}

/// "Runs of a batch share an error", where the file says so, and whether the results say so, too.
pub(super) fn shared(campaign: &Campaign, found: &Assessment) -> Result<Option<Finding>> {
    let is_said = campaign.settings.blocks == Some(true) && campaign.settings.plants.is_none();
    let Some(shared) = found.assembly.filter(|_| is_said) else { return Ok(None) };
    let response = &campaign.problem.response;
    let named = in_the_mean(&named_of_response(campaign, &found.shifts));
    let (drift, constrained_drifts) =
        by_themselves(campaign)?.map_or((None, Vec::new()), |found| (found.drift, found.constrained_drifts));
    let sentence = format!(
        "Runs of a batch, or of a source, share an error, as `blocks` in [loop] says: {} (standard deviation), as far as the runs tell it \
         from the noise; where nothing drifts about as much as that of one run, or less.{named} What is expected is the mean over batches and \
         sources. {}",
        response.amount(shared),
        spoken_for(drift.as_ref())
    );
    let finding =
        Finding::new(sentence).with("shared error", response.of_difference(shared), response.unit_of_differences());
    let finding = with_gain(finding, drift.as_ref());
    let of_each = campaign.problem.constraints.iter().zip(&found.constrained_shared).enumerate();
    let of_each = of_each.filter_map(|(index, (held, shared))| {
        Some(of_constraint(held, (*shared)?, constrained_drifts.get(index).and_then(Option::as_ref)))
    });
    Ok(Some(of_each.fold(finding, Finding::detail)))
}

fn of_constraint(held: &Held, shared: f64, drift: Option<&Drift>) -> Finding {
    let named = drift.map_or_else(String::new, |drift| in_the_mean(&named_of_constraint(held, &drift.shifts)));
    let shown = with_unit(&short(shared), &held.unit);
    let sentence = format!("{}: {shown} (standard deviation).{named} {}", held.name(), spoken_for(drift));
    with_gain(Finding::new(sentence).with("shared error", shared, &held.unit), drift)
}

/// " In the mean batch 1 0.2 mm above what is expected of them."
fn in_the_mean(named: &str) -> String {
    if named.is_empty() { String::new() } else { format!(" In the mean {named} what is expected of them.") }
}

/// Whether results speak for an error that the file says there is.
fn spoken_for(drift: Option<&Drift>) -> &'static str {
    match drift {
        Some(drift) if drift.is_sure() => "By themselves, too, the results are sure of it.",
        Some(drift) if drift.gain > 0.0 => "By themselves the results speak for it, and are not sure of it.",
        Some(_) => "By themselves the results do not speak for it.",
        None => "Whether there is one, results tell from two batches, or sources, of several designs on.",
    }
}

fn with_gain(finding: Finding, drift: Option<&Drift>) -> Finding {
    drift.into_iter().fold(finding, |finding, drift| finding.with(TIMES, drift.gain, "1"))
}

/// What would be known had the file not said that runs of a batch share an error: only then it is asked whether results speak for one.
fn by_themselves(campaign: &Campaign) -> Result<Option<Assessment>> {
    campaign.with_loop(|now, simulate| {
        let settings = Settings::clone(now.settings());
        let mut unsaid = settings.clone();
        unsaid.blocks = Some(false);
        // How large an error may be that is shared is asked in multiples of the noise.
        unsaid.noise = unsaid.noise.filter(|noise| *noise > 0.0);
        now.set_settings(unsaid)?;
        let found = now.assess(simulate);
        now.set_settings(settings)?;
        found
    })
}

/// "batch 1 0.2 mm above, batch 3 0.3 mm below, and 2 more": those that are farthest off, in their order.
fn named(shifts: &[Shift], far: impl Fn(f64) -> String) -> String {
    let mut large: Vec<&Shift> = shifts.iter().filter(|shift| shift.n_readings >= FEWEST).collect();
    large.sort_by(|a, b| b.by.abs().partial_cmp(&a.by.abs()).unwrap_or(Ordering::Equal));
    let n_more = large.len().saturating_sub(MOST_NAMED);
    large.truncate(MOST_NAMED);
    large.sort_by(|a, b| a.block.cmp(&b.block));
    let named: Vec<String> =
        large.iter().map(|shift| format!("{} {}", named_block(&shift.block), far(shift.by))).collect();
    let more = if n_more > 0 { format!(" (and {n_more} more, less far off)") } else { String::new() };
    format!("{}{more}", named.join(", "))
}

pub(super) fn named_block(block: &Block) -> String {
    match block {
        Block::Batch(batch) => format!("batch {batch}"),
        Block::Source(source) => format!("`{source}`"),
        _ => "others".to_owned(),
    }
}

/// For programs: what is said in words, of the error that is taken in where one is.
pub(super) fn as_json(campaign: &Campaign, found: &Assessment) -> Value {
    let response = &campaign.problem.response;
    let taken_in = found.assembly.filter(|_| !found.shifts.is_empty());
    let drift = found.drift.clone().map(|drift| match taken_in {
        Some(deviation) => Drift { deviation, noise: found.noise, shifts: found.shifts.clone(), ..drift },
        None => drift,
    });
    in_json(
        drift.as_ref(),
        |deviation| response.of_difference(deviation),
        |by| response.of_difference(response.of_deviations(by)),
    )
}

/// By how much batches and sources are off, where an error that their runs share is taken in.
pub(super) fn shifts_as_json(campaign: &Campaign, found: &Assessment) -> Value {
    let response = &campaign.problem.response;
    let one = |shift: &Shift| shift_in_json(shift, response.of_difference(response.of_deviations(shift.by)));
    found.shifts.iter().map(one).collect()
}

/// The same of each constrained response.
pub(super) fn of_constraints_as_json(campaign: &Campaign, found: &Assessment) -> Value {
    let pairs = campaign.problem.constraints.iter().zip(&found.constrained_drifts);
    let one = |(held, drift): (&Held, &Option<Drift>)| (held.name().to_owned(), in_json(drift.as_ref(), |x| x, |x| x));
    Value::Object(pairs.map(one).collect())
}

fn in_json(drift: Option<&Drift>, deviation: impl Fn(f64) -> f64, by: impl Fn(f64) -> f64) -> Value {
    drift.map_or(Value::Null, |drift| {
        let shifts: Value = drift.shifts.iter().map(|shift| shift_in_json(shift, by(shift.by))).collect();
        json!({
            "gain": drift.gain, "is_sure": drift.is_sure(), "standard_deviation": deviation(drift.deviation), "shifts": shifts,
        })
    })
}

fn shift_in_json(shift: &Shift, by: f64) -> Value {
    json!({ "of": named_block(&shift.block).replace('`', ""), "runs": shift.n_readings, "by": by })
}
