//! What is left of the design space, and why the rest was dropped.

use anyhow::Result;
use design_space::Parameter;
use infuse::global::{Report, RetainedSet};
use page::Finding;

use crate::dissertation::campaign::Campaign;
use crate::number::{are_written_alike, grouped, percent, plain, short, with_unit};

/// How many designs are left, between which settings, and what each batch dropped.
pub(in crate::dissertation) fn left(campaign: &Campaign) -> Result<Finding> {
    let mut left = how_many(campaign);
    let ranges = ranges(campaign, campaign.now.retained())?;
    for (parameter, (least, most)) in campaign.problem.region.parameters().iter().zip(ranges) {
        let whole = least <= parameter.lower() && most >= parameter.upper();
        let range = with_unit(&format!("{} to {}", plain(least), plain(most)), parameter.unit());
        let sentence = format!("{}: {range}{}", parameter.name(), if whole { ", all of it" } else { "" });
        let range = Finding::new(sentence).with("least", least, parameter.unit()).with("most", most, parameter.unit());
        left = left.detail(range);
    }
    let dropped = campaign.now.reports().iter().map(|report| dropped_by(campaign, report));
    Ok(dropped.fold(left, Finding::detail))
}

/// The number alone.
pub(in crate::dissertation) fn how_many(campaign: &Campaign) -> Finding {
    let retained = campaign.now.retained();
    let (n, of) = (retained.n_retained(), retained.n_cells());
    Finding::new(format!("Left: {} of {} designs, {}.", grouped(n), grouped(of), percent(retained.share())))
        .with("designs left", n as f64, "1")
        .with("designs", of as f64, "1")
}

/// Why a batch dropped what it dropped.
pub(in crate::dissertation) fn dropped_by(campaign: &Campaign, report: &Report) -> Finding {
    let n = report.screening.n_before - report.screening.n_after;
    let because = dropped_because(campaign, report);
    Finding::new(format!("batch {} dropped {}: {because}", report.number, grouped(n))).with("dropped", n as f64, "1")
}

/// The reason alone.
pub(in crate::dissertation) fn dropped_because(campaign: &Campaign, report: &Report) -> String {
    let screening = &report.screening;
    match screening.spread.s() {
        _ if !screening.tested => "the first batches only correct, see `drop_from` in [loop]".to_owned(),
        Some(s) => {
            let missed = missed_difference(s);
            let limit = campaign.problem.response.value(screening.optimum_value + screening.threshold * missed);
            let (word, times) = (campaign.problem.response.worse_side(), short(screening.threshold));
            let missed = campaign.problem.response.amount(missed);
            format!(
                "predicted {word} {limit}, that is worse than the best by {times} times {missed}, by which the difference of two \
                 designs may be missed"
            )
        }
        None => "nothing could be dropped, as the validation experiments gave no spread S".to_owned(),
    }
}

/// By how much the difference of two predictions may be missed, if each is missed by S.
fn missed_difference(s: f64) -> f64 {
    s * std::f64::consts::SQRT_2
}

/// Why a design was dropped, or that it was not; the settings that were asked about may lie between those that can be set.
pub(in crate::dissertation) fn why_dropped(campaign: &Campaign, asked: &[f64]) -> Result<Finding> {
    let cell = campaign.now.cell(asked)?;
    let point = campaign.now.point(cell)?;
    let is_off = point.iter().zip(asked).any(|(level, asked)| !are_written_alike(*level, *asked));
    let nearest = if is_off { "The nearest design that can be set, " } else { "" };
    let place = format!("{nearest}{}", campaign.problem.describe(&point));
    if let Some(batch) = campaign.now.failed_in(cell) {
        let sentence = format!("{place} is not asked for again: every run of it failed, in batch {batch}.");
        return Ok(Finding::new(sentence).with("batch", batch as f64, "1"));
    }
    let Some(dropped) = campaign.now.why_dropped(cell) else {
        return Ok(Finding::new(format!("{place} is still among the designs left.")));
    };
    let (response, n) = (&campaign.problem.response, dropped.batch);
    let (there, at_best) =
        (campaign.problem.response.value(dropped.value), campaign.problem.response.value(dropped.optimum_value));
    let (z, z0) = (short(dropped.z), short(dropped.z0));
    let missed = response.amount(missed_difference(dropped.spread));
    let sentence = format!(
        "{place} was dropped by batch {n}: {there} was predicted there against {at_best} at the best. That is worse by {z} times \
         {missed}, by which the difference of two designs may be missed, and {z0} times are enough."
    );
    Ok(Finding::new(sentence)
        .with("batch", n as f64, "1")
        .with("predicted there", response.of_cost(dropped.value), &response.unit)
        .with("predicted at the best", response.of_cost(dropped.optimum_value), &response.unit)
        .with("times what may be missed", dropped.z, "1")
        .with("times that are enough", dropped.z0, "1"))
}

/// The least and the largest setting of each parameter among the designs that are left.
pub(in crate::dissertation) fn ranges(campaign: &Campaign, retained: &RetainedSet) -> Result<Vec<(f64, f64)>> {
    let region = &campaign.problem.region;
    let combinations = campaign.now.grid().combinations();
    let mut digits = vec![0; region.n_parameters()];
    let mut ranges = vec![(u64::MAX, 0); region.n_parameters()];
    for cell in retained.cells() {
        combinations.fill_digits(cell.index(), &mut digits);
        for (range, &digit) in ranges.iter_mut().zip(&digits) {
            *range = (range.0.min(digit), range.1.max(digit));
        }
    }
    let setting = |parameter: &Parameter, digit: u64| parameter.level(u32::try_from(digit).unwrap_or(u32::MAX));
    let pairs = region.parameters().iter().zip(ranges);
    pairs.map(|(parameter, (least, most))| Ok((setting(parameter, least)?, setting(parameter, most)?))).collect()
}
