//! That runs of a batch read otherwise than those of others, in words and as JSON.

use std::cmp::Ordering;

use anyhow::Result;
use infuse::pooled::reported::{Block, Drift, Shift};
use infuse::pooled::{Assessment, Settings};
use page::Finding;
use serde_json::{Value, json};

use super::campaign::Campaign;
use crate::echo::echo;
use crate::journal::Assessed;
use crate::number::{short, with_unit};
use crate::problem::{Held, Response};

/// Blocks that are named, those that are farthest off, of those of so many runs at least.
const MOST_NAMED: usize = 4;
const FEWEST: usize = 3;
/// The name of a number.
const TIMES: &str = "times more probable, logarithm";

/// The responses of which the results are sure that they drift, where the file leaves it to them.
fn drifting<'a>(campaign: &'a Campaign, found: &'a Assessment) -> impl Iterator<Item = &'a str> {
    sure_ones(campaign, found.drift.as_ref(), &found.constrained_drifts)
}

/// That results were sure of it after the last batch, or the one before, and are not any more.
pub(super) fn no_more(campaign: &Campaign, found: &Assessment) -> Option<Finding> {
    if campaign.settings.blocks.is_some() || campaign.settings.plants.is_some() {
        return None;
    }
    let now: Vec<&str> = drifting(campaign, found).collect();
    let last = campaign.history.values().next_back();
    let before = campaign.history.range(..campaign.batches.len()).next_back().map(|(_, said)| said);
    let (before, gone) =
        last.into_iter().chain(before).map(|said| (said, gone(said, &now))).find(|(_, gone)| !gone.is_empty())?;
    let why = match campaign.withdrawn_since(before.batch) {
        Some(withdrawn) => format!("Since then {withdrawn}."),
        None => "One result far from all others can do so.".to_owned(),
    };
    let sentence = format!(
        "Careful: after batch {} the results were sure that runs of one batch read alike in {}; by all that is known now they are not, so that \
         nothing is taken in for that. {why} `blocks = true` in [loop] keeps it.",
        before.batch,
        gone.join(", ")
    );
    Some(Finding::new(sentence).with("sure after batch", before.batch as f64, "1"))
}

/// The responses of which results were sure then that they drift, and are not now.
fn gone(before: &Assessed, now: &[&str]) -> Vec<String> {
    let gone = before.drifting.iter().filter(|name| !now.contains(&name.as_str()));
    gone.map(|name| format!("`{name}`")).collect()
}

/// Why the bound is another than it was: that an error which runs of a batch share is taken in now, and was not then, or no more.
pub(super) fn taken_in_otherwise(campaign: &Campaign, found: &Assessment, before: &Assessed) -> Option<String> {
    if campaign.settings.blocks.is_some() || campaign.settings.plants.is_some() {
        return None;
    }
    let now: Vec<&str> = drifting(campaign, found).collect();
    let gone = gone(before, &now);
    let new = now.iter().filter(|name| !before.drifting.iter().any(|then| then == *name));
    let new: Vec<String> = new.map(|name| format!("`{name}`")).collect();
    match (new.is_empty(), gone.is_empty()) {
        (false, _) => Some(format!(
            "an error that runs of one batch share in {} is taken in by now, as results are sure of it",
            new.join(", ")
        )),
        (true, false) => Some(format!(
            "results are not sure any more that runs of one batch read alike in {}, so that nothing is taken in for that",
            gone.join(", ")
        )),
        (true, true) => None,
    }
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
        let finding = finding.with("noise", response.of_difference(found.noise), response.unit_of_differences());
        let finding = with_shifts(finding, shifts, |by| of_shift(response, by), response.unit_of_differences());
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
        let with_numbers = |finding: Finding| {
            with_shifts(finding.with("noise", drift.noise, &held.unit), &drift.shifts, |by| by, &held.unit)
        };
        let finding = warning(&what, &named, &amount(drift.noise), drift, shared.map(amount));
        Some(with_numbers(finding).with("shared by runs of a batch", shared.unwrap_or(drift.deviation), &held.unit))
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
        None => "`blocks = false` in [loop] leaves it so: bands and bounds are narrower than they should be, as each run is taken for one by itself. \
                 Without it they share an error that is learnt."
            .to_owned(),
    };
    let sentence = format!(
        "Careful: runs of one batch, or of one source, read alike{what}, beyond what their settings explain: {named} what is expected of them, in \
         the mean; the noise of one run is about {noise}. {question}"
    );
    with_gain(Finding::new(sentence), Some(drift)).detail(Finding::new(so))
}

/// "Runs of a batch share an error", where the file says so, and whether the results say so, too.
pub(super) fn shared(campaign: &Campaign, found: &Assessment) -> Result<Option<Finding>> {
    let Some(shared) = found.assembly.filter(|_| is_told(campaign)) else { return Ok(None) };
    let response = &campaign.problem.response;
    let unit = response.unit_of_differences();
    let (drift, constrained_drifts) =
        campaign.by_themselves()?.map_or((None, Vec::new()), |found| (found.drift, found.constrained_drifts));
    let sentence = format!(
        "Runs of a batch, or of a source, share an error, as `blocks` in [loop] says: {} (standard deviation), as far as the runs tell it \
         from the noise; where nothing drifts about as much as that of one run, or less.",
        response.amount(shared)
    );
    let finding = Finding::new(sentence).with("shared error", response.of_difference(shared), unit);
    let finding = with_shifts(finding, &found.shifts, |by| of_shift(response, by), unit);
    let named = in_the_mean(&named_of_response(campaign, &found.shifts));
    let finding = if named.is_empty() { finding } else { finding.detail(Finding::new(named.trim_start())) };
    let means = format!("What is expected is the mean over batches and sources. {}", spoken_for(drift.as_ref()));
    let finding = with_gain(finding, drift.as_ref()).detail(Finding::new(means));
    let of_each = campaign.problem.constraints.iter().zip(&found.constrained_shared).enumerate();
    let of_each = of_each.filter_map(|(index, (held, shared))| {
        Some(of_constraint(held, (*shared)?, constrained_drifts.get(index).and_then(Option::as_ref)))
    });
    Ok(Some(of_each.fold(finding, Finding::detail)))
}

/// Whether the file says that runs of a batch share an error.
fn is_told(campaign: &Campaign) -> bool {
    campaign.settings.blocks == Some(true) && campaign.settings.plants.is_none()
}

fn of_constraint(held: &Held, shared: f64, drift: Option<&Drift>) -> Finding {
    let named = drift.map_or_else(String::new, |drift| in_the_mean(&named_of_constraint(held, &drift.shifts)));
    let shown = with_unit(&short(shared), &held.unit);
    let sentence = format!("{}: {shown} (standard deviation).{named} {}", held.name(), spoken_for(drift));
    let finding = Finding::new(sentence).with("shared error", shared, &held.unit);
    let shifts = drift.map_or(&[][..], |drift| &drift.shifts);
    with_gain(with_shifts(finding, shifts, |by| by, &held.unit), drift)
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

/// By how much a block reads above what is expected of it, as differences of the response are said.
fn of_shift(response: &Response, by: f64) -> f64 {
    response.of_difference(response.of_deviations(by))
}

/// With by how much each block reads above what is expected of it, those that are not named, too.
fn with_shifts(finding: Finding, shifts: &[Shift], by: impl Fn(f64) -> f64, unit: &str) -> Finding {
    let told = shifts.iter().filter(|shift| shift.n_readings >= FEWEST);
    told.fold(finding, |finding, shift| finding.with(&format!("{} above", in_plain(&shift.block)), by(shift.by), unit))
}

impl Campaign {
    /// What would be known had the file not said that runs of a batch share an error: only then it is asked whether results speak for one.
    pub(super) fn by_themselves(&self) -> Result<Option<Assessment>> {
        if let Some(known) = self.unsaid.get() {
            return Ok(known.clone());
        }
        let found = self.with_loop(|now, simulate| {
            let settings = Settings::clone(now.settings());
            let mut unsaid = settings.clone();
            unsaid.blocks = Some(false);
            // How large an error may be that is shared is asked in multiples of the noise.
            unsaid.noise = unsaid.noise.filter(|noise| *noise > 0.0);
            now.set_settings(unsaid)?;
            let found = now.assess(simulate);
            now.set_settings(settings)?;
            found
        })?;
        Ok(self.unsaid.get_or_init(|| found).clone())
    }
}

/// What results say of a drift: of the response, and of each one that is constrained, whatever the file says.
fn drifts(campaign: &Campaign, found: &Assessment) -> Result<(Option<Drift>, Vec<Option<Drift>>)> {
    let of = |found: &Assessment| (found.drift.clone(), found.constrained_drifts.clone());
    Ok(match is_told(campaign) {
        true => campaign.by_themselves()?.as_ref().map(of).unwrap_or_default(),
        false => of(found),
    })
}

/// The responses of which results are sure that they drift, whatever the file says.
pub(super) fn sure(campaign: &Campaign, found: &Assessment) -> Result<Vec<String>> {
    let (drift, constrained) = drifts(campaign, found)?;
    Ok(sure_ones(campaign, drift.as_ref(), &constrained).map(str::to_owned).collect())
}

fn sure_ones<'a>(
    campaign: &'a Campaign,
    drift: Option<&'a Drift>,
    constrained: &'a [Option<Drift>],
) -> impl Iterator<Item = &'a str> {
    let problem = &campaign.problem;
    let names = std::iter::once(problem.response.name.as_str()).chain(problem.constraints.iter().map(Held::name));
    let drifts = std::iter::once(drift).chain(constrained.iter().map(Option::as_ref));
    names.zip(drifts).filter(|(_, drift)| drift.is_some_and(Drift::is_sure)).map(|(name, _)| name)
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
        Block::Source(source) => format!("`{}`", echo(source)),
        _ => "others".to_owned(),
    }
}

/// The same for programs.
fn in_plain(block: &Block) -> String {
    match block {
        Block::Source(source) => source.clone(),
        other => named_block(other),
    }
}

/// For programs: what results say of a drift, of the response and of each one that is constrained, and by how much batches and sources are
/// off. Where an error is taken in these are of that, whatever the file says; where it forbids it, they are what would be taken in.
pub(super) fn as_json(campaign: &Campaign, found: &Assessment) -> Result<Value> {
    let response = &campaign.problem.response;
    let (drift, constrained) = drifts(campaign, found)?;
    let taken_in = found.assembly.filter(|_| !found.shifts.is_empty());
    let drift = drift.map(|drift| match taken_in {
        Some(deviation) => Drift { deviation, noise: found.noise, shifts: found.shifts.clone(), ..drift },
        None => drift,
    });
    let by = |by: f64| of_shift(response, by);
    let of_response = in_json(drift.as_ref(), taken_in.is_some(), |deviation| response.of_difference(deviation), by);
    let shifts = match &drift {
        Some(drift) if taken_in.is_none() && drift.is_sure() => &drift.shifts,
        _ => &found.shifts,
    };
    let shifts: Value = shifts.iter().map(|shift| shift_in_json(shift, by(shift.by))).collect();
    let of_each = campaign.problem.constraints.iter().zip(&constrained).enumerate().map(|(index, (held, drift))| {
        let is_taken_in = found.constrained_shared.get(index).is_some_and(Option::is_some);
        (held.name().to_owned(), in_json(drift.as_ref(), is_taken_in, |x| x, |x| x))
    });
    Ok(json!({ "drift": of_response, "shifts": shifts, "drift_of_constraints": Value::Object(of_each.collect()) }))
}

fn in_json(drift: Option<&Drift>, is_taken_in: bool, deviation: impl Fn(f64) -> f64, by: impl Fn(f64) -> f64) -> Value {
    drift.map_or(Value::Null, |drift| {
        let shifts: Value = drift.shifts.iter().map(|shift| shift_in_json(shift, by(shift.by))).collect();
        json!({
            "gain": drift.gain, "is_sure": drift.is_sure(), "is_taken_in": is_taken_in,
            "standard_deviation": deviation(drift.deviation), "shifts": shifts,
        })
    })
}

fn shift_in_json(shift: &Shift, by: f64) -> Value {
    json!({ "of": in_plain(&shift.block), "runs": shift.n_readings, "by": by })
}
