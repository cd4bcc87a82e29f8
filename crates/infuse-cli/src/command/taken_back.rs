//! What still stands in a sheet though it was taken back.

use std::collections::BTreeSet;
use std::path::Path;

use anyhow::Result;

use crate::campaign::{Campaign, Experiments};
use crate::journal::{Event, Journal, Told};
use crate::sheet::{Answer, answers};

/// That a sheet would tell again what was taken back and not told since; a sheet that cannot be read tells nothing.
pub(super) fn still_in_the_sheet(campaign: &dyn Campaign, journal: &Journal, sheet: &Path) -> Option<String> {
    let experiments = campaign.experiments();
    let taken_back = told(journal).filter(|(line, _)| journal.taken_back.contains(line)).map(|(_, told)| told);
    let taken_back: Vec<&Told> = taken_back.filter(|told| !counts(experiments, told)).collect();
    if taken_back.is_empty() {
        return None;
    }
    let filled = answers(sheet, campaign.problem(), &experiments.trials).ok()?.filled;
    let again = filled.iter().filter(|answer| taken_back.iter().any(|told| is_same(answer, told)));
    let ids: BTreeSet<u64> = again.map(|answer| answer.id).collect();
    (!ids.is_empty()).then(|| {
        format!(
            "{} still has what was taken back, of {}: empty it there or put it right, or `infuse tell` takes it again",
            sheet.display(),
            of_experiments(ids.iter().copied())
        )
    })
}

/// The experiments of which a sheet has results that the journal never had, taken back or not.
pub(super) fn never_told(campaign: &dyn Campaign, journal: &Journal, sheet: &Path) -> Result<BTreeSet<u64>> {
    let filled = answers(sheet, campaign.problem(), &campaign.experiments().trials)?.filled;
    let untold = filled.iter().filter(|answer| !told(journal).any(|(_, told)| is_same(answer, told)));
    Ok(untold.map(|answer| answer.id).collect())
}

/// All that was ever told, with its lines.
fn told(journal: &Journal) -> impl Iterator<Item = (usize, &Told)> {
    journal
        .all
        .iter()
        .filter_map(|(line, event)| if let Event::Told(told) = event { Some((*line, told)) } else { None })
}

/// Whether there is a result of this run.
fn counts(experiments: &Experiments, told: &Told) -> bool {
    experiments.readings.get(&told.id).is_some_and(|reading| match told.repeat {
        0 => reading.first.is_some(),
        repeat => reading.again.contains_key(&repeat),
    })
}

fn is_same(answer: &Answer, told: &Told) -> bool {
    (answer.id, answer.repeat, &answer.result) == (told.id, told.repeat, &told.result)
}

/// So many are named.
const MOST_NAMED: usize = 12;

/// "experiments 3, 4, 7".
pub(super) fn of_experiments(ids: impl ExactSizeIterator<Item = u64>) -> String {
    let n = ids.len();
    let named: Vec<String> = ids.take(MOST_NAMED).map(|id| id.to_string()).collect();
    let more = if n > MOST_NAMED { ", ..." } else { "" };
    format!("{} {}{more}", if n == 1 { "experiment" } else { "experiments" }, named.join(", "))
}
