//! That runs of a batch read otherwise than those of others, in words and as JSON.

use std::cmp::Ordering;

use infuse::pooled::Assessment;
use infuse::pooled::reported::{Block, Drift, Shift};
use page::Finding;
use serde_json::{Value, json};

use super::campaign::Campaign;

/// Blocks that are named, of those of so many runs at least.
const MOST_NAMED: usize = 6;
const FEWEST: usize = 3;

/// That the rig drifts, as far as results are sure of it, and what allows for that.
pub(super) fn warning(campaign: &Campaign, found: &Assessment) -> Option<Finding> {
    let drift = found.drift.as_ref().filter(|drift| drift.is_sure())?;
    let response = &campaign.problem.response;
    let named = named(drift).map(|shift| {
        let side = match shift.by.total_cmp(&0.0) {
            Ordering::Less => better_side(response.worse_side()),
            _ => response.worse_side(),
        };
        format!("{} {} {side}", of_block(&shift.block), response.amount(shift.by.abs()))
    });
    let named = named.collect::<Vec<_>>().join(", ");
    let sentence = format!(
        "Careful: runs of one batch read alike, beyond what their settings explain: {named} what is expected of them, in the mean; the noise \
         of one run is about {}. Does the rig drift from day to day? `blocks = true` in [loop] allows for it: runs of a batch, or of a source, \
         then share an error that is learnt.",
        response.amount(found.noise)
    );
    let finding = Finding::new(sentence).with("times more probable, logarithm", drift.gain, "1");
    let (deviation, unit) = (response.of_difference(drift.deviation), response.unit_of_differences());
    Some(finding.with("shared by runs of a batch", deviation, unit))
}

/// "Runs of a batch share an error", where that is allowed for.
pub(super) fn shared(campaign: &Campaign, found: &Assessment) -> Option<Finding> {
    let shared = found.assembly.filter(|_| campaign.settings.blocks && campaign.settings.plants.is_none())?;
    let response = &campaign.problem.response;
    let sentence = format!(
        "Runs of a batch, or of a source, share an error, as `blocks` in [loop] says: {} (standard deviation), as far as the runs tell it \
         from the noise.",
        response.amount(shared)
    );
    Some(Finding::new(sentence).with("shared error", response.of_difference(shared), response.unit_of_differences()))
}

fn named(drift: &Drift) -> impl Iterator<Item = &Shift> {
    drift.shifts.iter().filter(|shift| shift.n_readings >= FEWEST).take(MOST_NAMED)
}

fn of_block(block: &Block) -> String {
    match block {
        Block::Batch(batch) => format!("batch {batch}"),
        Block::Source(source) => format!("`{source}`"),
        _ => "others".to_owned(),
    }
}

fn better_side(worse: &str) -> &'static str {
    if worse == "above" { "below" } else { "above" }
}

/// For programs.
pub(super) fn as_json(campaign: &Campaign, found: &Assessment) -> Value {
    let response = &campaign.problem.response;
    let shift = |shift: &Shift| {
        let by = response.of_difference(response.of_deviations(shift.by));
        json!({ "of": of_block(&shift.block).replace('`', ""), "runs": shift.n_readings, "by": by })
    };
    found.drift.as_ref().map_or(Value::Null, |drift| {
        json!({
            "gain": drift.gain, "is_sure": drift.is_sure(), "standard_deviation": response.of_difference(drift.deviation),
            "shifts": drift.shifts.iter().map(shift).collect::<Vec<_>>(),
        })
    })
}
