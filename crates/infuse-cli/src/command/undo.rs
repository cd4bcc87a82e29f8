//! `infuse undo`: takes the last thing back that was done.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::{Context as _, Result, ensure};
use page::Finding;
use serde_json::json;

use super::output::Output;
use super::taken_back::{InTheSheet, in_the_sheet, of_experiments, still_in_the_sheet};
use crate::campaign::Campaign;
use crate::echo::echo;
use crate::findings::next;
use crate::folder;
use crate::journal::{BY_ITSELF, Deed, Event, JOURNAL, Journal, Last, Measured, Submitted, Told, now};
use crate::number::count;
use crate::sheet::Fault;
use crate::shell::{kept_name, sheet_path, typed_name};
use crate::wording::all_of;

/// `n_lines` is how many lines the journal has to have, where somebody has seen what would be taken back.
pub(crate) fn undo(folder: &Path, wait: Duration, n_lines: Option<usize>) -> Result<Output> {
    // A campaign that has not begun is not begun by this.
    last_of(folder)?;
    let (mut campaign, mut writer) = folder::open(folder, wait)?;
    let (Journal { all, notices, .. }, last) = last_of(folder)?;
    ensure!(
        n_lines.is_none_or(|n_lines| n_lines == all.len()),
        "something was written down since: nothing was taken back, look again at what would be"
    );
    let undone = Event::Undone { deed: last.deed, lines: last.events.len(), at: now() };
    let mut after = all;
    after.push((after.last().map_or(1, |(line, _)| line + 1), undone.clone()));
    let mut after = folder::replay(folder, Journal::of(after, notices)?)
        .context("it cannot be taken back, as what is left would be no campaign")?;
    writer.add(std::slice::from_ref(&undone))?;
    let mut notices = campaign.take_notices();
    notices.extend(after.take_notices());
    let journal = Journal::read(folder)?;
    notices.extend(sheets_left(&*campaign, &journal, &last));
    notices.extend(runs_left(&*campaign, &last));
    notices.extend(still_in_sheets(&*after, &journal, &last));
    let sentence = format!("Taken back: {}.", in_words(&last));
    let mut findings = vec![Finding::new(sentence).with("lines taken back", last.events.len() as f64, "1")];
    match after.stage() {
        Ok(stage) => findings.push(next(&*after, &stage)),
        // It is taken back all the same, and there may be more to take back.
        Err(error) => notices.push(format!("what is left cannot be used as it is ({error:#}): `infuse log` shows it")),
    }
    let json = json!({ "undone": last.deed, "lines": last.events.iter().map(|(line, _)| line).collect::<Vec<_>>() });
    Ok(Output::new(&findings, json, notices))
}

/// The journal, and what can be taken back.
pub(crate) fn last_of(folder: &Path) -> Result<(Journal, Last)> {
    let mut journal = Journal::read(folder)?;
    let last = journal.last.take();
    let last = last.with_context(|| {
        format!("nothing can be taken back: {JOURNAL} has no `ask`, `tell`, `import` or `confirm` that counts")
    })?;
    Ok((journal, last))
}

/// The sheets of a batch that does not count any more are a person's, and stay.
fn sheets_left(campaign: &dyn Campaign, journal: &Journal, last: &Last) -> Vec<String> {
    let planned = last.events.iter().rev().find_map(|(line, event)| match event {
        Event::Planned { batch, experiments, .. } if !experiments.is_empty() => Some((*line, *batch)),
        _ => None,
    });
    let Some((line, batch)) = planned else { return Vec::new() };
    let mut sheets = named_sheets(campaign.folder(), journal, batch, line);
    if sheets.is_empty() {
        sheets.push(sheet_path(campaign.folder(), campaign.problem().sheets, batch, None));
    }
    sheets.iter().filter(|sheet| sheet.exists()).map(|sheet| sheet_left(campaign, journal, sheet)).collect()
}

/// What a sheet has that was never told stands nowhere else.
fn sheet_left(campaign: &dyn Campaign, journal: &Journal, path: &Path) -> String {
    let sheet = path.display();
    let keep = "they stand nowhere else. Where the same is asked for again, `infuse tell` takes them; else move the sheet before the next ask, \
                and copy them into a table for `infuse import`";
    let InTheSheet { never_told, told_before, faults } = match in_the_sheet(campaign, journal, path) {
        Ok(found) => found,
        Err(fault) => {
            return format!(
                "{sheet} belongs to what was taken back, and whether it has results that were never told cannot be read ({fault:#}). If it \
                 has, {keep}"
            );
        }
    };
    let of = |ids: &BTreeSet<u64>| of_experiments(ids.iter().copied());
    let remove = if faults.is_empty() { ": move or remove it before the next ask" } else { "" };
    let has = match (never_told.is_empty(), told_before.is_empty()) {
        (true, true) => remove.to_owned(),
        (true, false) => format!(", and has results that were told and taken back, of {}{remove}", of(&told_before)),
        (false, true) => format!(", and has results that were never told, of {}: {keep}", of(&never_told)),
        (false, false) => format!(
            ", and has results that were told and taken back, of {}, and others that were never told, of {}: {keep}",
            of(&told_before),
            of(&never_told)
        ),
    };
    let unread = match faults.as_slice() {
        [] => String::new(),
        [first, ..] => {
            format!(
                ". It has {} that cannot be read, and may hold more that stands nowhere else: {first}",
                count(rows(&faults), "row")
            )
        }
    };
    format!("{sheet} belongs to what was taken back{has}{unread}")
}

/// In how many rows these faults are.
fn rows(faults: &[Fault]) -> usize {
    faults.iter().map(|fault| fault.row).collect::<BTreeSet<_>>().len()
}

/// The sheets of open batches are a person's, too, and so is what was told from; what they hold would be told again.
fn still_in_sheets(after: &dyn Campaign, journal: &Journal, last: &Last) -> Vec<String> {
    let (folder, mut sheets) = (after.folder(), Vec::new());
    for batch in after.experiments().open_batches() {
        sheets.push(sheet_path(folder, after.problem().sheets, batch, None));
        sheets.extend(named_sheets(folder, journal, batch, 0));
    }
    let told_from = last.events.iter().filter_map(|(_, event)| match event {
        Event::Told(Told { from, .. }) if from != BY_ITSELF => Some(PathBuf::from(from)),
        _ => None,
    });
    sheets.extend(told_from);
    let mut seen = BTreeSet::new();
    sheets.retain(|sheet| sheet.is_file() && seen.insert(kept_name(folder, sheet)));
    sheets.iter().filter_map(|sheet| still_in_the_sheet(after, journal, sheet)).collect()
}

/// Where the experiments of a batch stand, as the journal has it after a line, taken back or not.
fn named_sheets(folder: &Path, journal: &Journal, batch: usize, after: usize) -> Vec<PathBuf> {
    let named = journal.all.iter().filter_map(|(line, event)| match event {
        Event::Sheet { batch: of, path, .. } if *of == batch && *line > after => Some(typed_name(folder, path)),
        _ => None,
    });
    named.collect()
}

fn runs_left(campaign: &dyn Campaign, last: &Last) -> Option<String> {
    let is_planned = last.events.iter().any(|(_, event)| matches!(event, Event::Planned { .. }));
    let n = campaign.submitted().iter().map(|Submitted { cells, .. }| cells.len()).sum::<usize>();
    (is_planned && n > 0).then(|| "runs of it that are in the queue go on: `infuse cancel` stops them".to_owned())
}

/// What was done, with its numbers.
pub(crate) fn in_words(last: &Last) -> String {
    let events = || last.events.iter().map(|(_, event)| event);
    match last.deed {
        Deed::Tell => told(events().filter_map(|event| if let Event::Told(told) = event { Some(told) } else { None })),
        Deed::Import => {
            let n = events().filter(|event| matches!(event, Event::Imported { .. })).count();
            let from =
                events().find_map(|event| if let Event::Imported { from, .. } = event { Some(from) } else { None });
            let from = from.map_or("", String::as_str);
            format!("{} imported from {from}, as {}", count(n, "experiment"), sources(events()))
        }
        Deed::Withdraw => {
            let source = events()
                .find_map(|event| if let Event::Withdrawn { source, .. } = event { Some(source) } else { None });
            format!("the withdrawal of `{}`", source.map_or("", String::as_str))
        }
        Deed::Ask | Deed::Confirm => {
            let mut planned = events().filter_map(|event| match event {
                Event::Planned { batch, experiments, .. } => Some((*batch, experiments.len())),
                _ => None,
            });
            let (batch, n) = planned.next_back().unwrap_or_default();
            let why = if last.deed == Deed::Confirm { " that was to confirm" } else { "" };
            format!("batch {batch}{why}, of {} none of which was told", count(n, "experiment"))
        }
    }
}

/// So many sources are named.
const MOST_SOURCES: usize = 12;

/// Of what was imported, each source once: "`page 7` and `page 8`".
fn sources<'a>(events: impl Iterator<Item = &'a Event>) -> String {
    let sources: BTreeSet<&str> = events
        .filter_map(|event| if let Event::Imported { source, .. } = event { Some(&**source) } else { None })
        .collect();
    let mut named: Vec<String> =
        sources.iter().take(MOST_SOURCES).map(|source| format!("`{}`", echo(source))).collect();
    let n_more = sources.len() - named.len();
    named.extend((n_more > 0).then(|| format!("{n_more} more")));
    all_of(&named)
}

/// Results, where they come from and what of them is special.
pub(super) fn told<'a>(told: impl Iterator<Item = &'a Told>) -> String {
    let told: Vec<&Told> = told.collect();
    let n_failed = told.iter().filter(|told| matches!(told.result, Measured::Failed(_))).count();
    let n_corrected = told.iter().filter(|told| told.corrects).count();
    let from = told.first().map_or("", |told| &*told.from);
    let more = |n: usize, word: &str| if n > 0 { format!(", {n} {word}") } else { String::new() };
    format!(
        "{} from {from} (of {}{}{})",
        count(told.len(), "result"),
        of_experiments(told.iter().map(|told| told.id)),
        more(n_failed, "without a value"),
        more(n_corrected, "in the place of an earlier one")
    )
}
