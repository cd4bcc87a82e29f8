//! What still stands in a sheet though it was taken back.

use std::collections::BTreeSet;
use std::path::Path;

use anyhow::Result;

use crate::campaign::{Campaign, Experiments};
use crate::journal::{Event, Journal, Told};
use crate::sheet::{Answer, Fault, sound_answers};

/// That a sheet would tell again what was taken back and not told since; a sheet that cannot be read tells nothing, nor do rows with a fault.
pub(super) fn still_in_the_sheet(campaign: &dyn Campaign, journal: &Journal, sheet: &Path) -> Option<String> {
    let experiments = campaign.experiments();
    let taken_back = told(journal).filter(|(line, _)| journal.taken_back.contains(line)).map(|(_, told)| told);
    let taken_back: Vec<&Told> = taken_back.filter(|told| !counts(experiments, told)).collect();
    if taken_back.is_empty() {
        return None;
    }
    let filled = sound_answers(sheet, campaign.problem(), &experiments.trials).ok()?.0.filled;
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

/// What a sheet has that does not count.
#[derive(Debug)]
pub(super) struct InTheSheet {
    /// Of these experiments the journal never had the results.
    pub(super) never_told: BTreeSet<u64>,
    /// Of these it had them, and they were taken back.
    pub(super) told_before: BTreeSet<u64>,
    /// Of rows that cannot be read.
    pub(super) faults: Vec<Fault>,
}

pub(super) fn in_the_sheet(campaign: &dyn Campaign, journal: &Journal, sheet: &Path) -> Result<InTheSheet> {
    let (answers, faults) = sound_answers(sheet, campaign.problem(), &campaign.experiments().trials)?;
    let was_told = |answer: &&Answer| told(journal).any(|(_, told)| is_same(answer, told));
    let (told_before, never_told): (Vec<&Answer>, Vec<&Answer>) = answers.filled.iter().partition(was_told);
    let ids = |answers: Vec<&Answer>| answers.into_iter().map(|answer| answer.id).collect();
    Ok(InTheSheet { never_told: ids(never_told), told_before: ids(told_before), faults })
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
