//! The campaign of a folder: which method it goes by, and whether its journal still belongs to its problem.

use std::path::Path;
use std::time::Duration;

use anyhow::{Context as _, Result, bail, ensure};
use serde_json::Value;

use crate::campaign::{Campaign, changes};
use crate::journal::{Event, FORMAT, JOURNAL, Journal, Writer, now};
use crate::problem::{Method, PROBLEM, Problem, by_key};
use crate::shell::sheet_path;
use crate::{dissertation, pooled};

/// Sheets with higher numbers are not looked for.
const MOST_BATCHES: usize = 200;

/// The campaign of a folder, for reading.
pub(crate) fn read(folder: &Path) -> Result<Box<dyn Campaign>> {
    let journal = Journal::read(folder)?;
    check_sheets(folder, &Problem::read(folder)?, &journal)?;
    replay(folder, journal)
}

/// Sheets of a campaign whose journal is gone: nothing of them is known, and nothing may be begun as if they were not there.
fn check_sheets(folder: &Path, problem: &Problem, journal: &Journal) -> Result<()> {
    // Of a journal that was cut, what is left is gone on with.
    let is_there = std::fs::metadata(folder.join(JOURNAL)).is_ok_and(|file| file.len() > 0);
    if is_there || !journal.all.is_empty() {
        return Ok(());
    }
    let sheets = (1..=MOST_BATCHES).map(|batch| sheet_path(folder, problem.sheets, batch, None));
    if let Some(first) = sheets.into_iter().find(|sheet| sheet.exists()) {
        bail!(
            "there is {}, but no {JOURNAL}: nothing of the sheets is known without it; if it was moved, put it back, and if the \
             campaign is to begin anew, move the sheets away",
            first.display()
        );
    }
    Ok(())
}

/// The campaign that follows from a journal.
pub(crate) fn replay(folder: &Path, mut journal: Journal) -> Result<Box<dyn Campaign>> {
    let problem = Problem::read(folder)?;
    let method = method_of(&problem, &journal)?;
    if !begins(&journal, &core(folder, &problem, method, &journal)?) {
        journal.events.clear();
    }
    of(folder, problem, method, journal)
}

/// The campaign of a folder, and its journal to write to. A journal that has not begun is begun.
pub(crate) fn open(folder: &Path, wait: Duration) -> Result<(Box<dyn Campaign>, Writer)> {
    let problem = Problem::read(folder)?;
    // What is wrong with the settings is said before anything is written.
    let there = Journal::read(folder)?;
    check_sheets(folder, &problem, &there)?;
    core(folder, &problem, method_of(&problem, &there)?, &there)?;
    let (mut writer, mut journal) = Writer::open(folder, wait)?;
    let method = method_of(&problem, &journal)?;
    let core = core(folder, &problem, method, &journal)?;
    if !begins(&journal, &core) {
        let begin = Event::Campaign { format: FORMAT, at: now(), problem: core };
        writer.add(std::slice::from_ref(&begin))?;
        let line = journal.all.last().map_or(1, |(line, _)| line + 1);
        journal.events.push((line, begin));
    }
    Ok((of(folder, problem, method, journal)?, writer))
}

/// The last beginning in a journal, with its place.
fn beginning(journal: &Journal) -> Option<(usize, u32, &Value)> {
    let mut beginnings = journal.events.iter().enumerate().rev().filter_map(|(place, (_, event))| match event {
        Event::Campaign { format, problem, .. } => Some((place, *format, problem)),
        _ => None,
    });
    beginnings.next()
}

/// Whether anything in a journal would be lost if it began anew.
fn has_results(journal: &Journal) -> bool {
    journal.events.iter().any(|(_, event)| matches!(event, Event::Told(_) | Event::Imported { .. }))
}

/// Whether the journal's beginning stands: it agrees with the problem, or it has results. A slip in the problem that is put right
/// before the first result is nothing but a new beginning.
fn begins(journal: &Journal, core: &Value) -> bool {
    beginning(journal).is_some_and(|(_, _, then)| then == core) || has_results(journal)
}

/// By the method that the problem names, or else that with which the journal began, or else the pooled loop.
fn method_of(problem: &Problem, journal: &Journal) -> Result<Method> {
    let began = beginning(journal).map(|(_, _, core)| Method::of_core(core));
    let method = problem.rule.method.or(began).unwrap_or_default();
    if let Some(began) = began.filter(|_| has_results(journal)) {
        ensure!(
            began == method,
            "{PROBLEM} was changed after the journal had begun: [loop] `method` was \"{}\" and is \"{}\"; change it back, or \
             begin a new campaign in another folder and `infuse import` the experiments",
            began.name(),
            method.name()
        );
    }
    Ok(method)
}

/// What the journal rests on: once it has results, none of this may change.
fn core(folder: &Path, problem: &Problem, method: Method, journal: &Journal) -> Result<Value> {
    let (mut core, file) = (problem.core(), || folder.join(PROBLEM).display().to_string());
    match method {
        // All data count anew at every step, so its settings may change from batch to batch.
        Method::Pooled => {
            problem.pooled_settings().with_context(file)?;
            core["method"] = method.name().into();
        }
        Method::Dissertation => {
            let careful = is_careful(journal);
            ensure!(
                problem.simulator.is_there() || !has_results(journal),
                "{PROBLEM} was changed after the journal had begun: [simulator] was taken out, which `method` = \"dissertation\" \
                 corrects by experiments; put it back, or begin a new campaign in another folder and `infuse import` the experiments"
            );
            let mut settings = serde_json::to_value(problem.dissertation_settings(careful).with_context(file)?)?;
            if let Some(settings) = settings.as_object_mut() {
                settings.remove("max_batches");
                if !careful {
                    settings.remove("careful");
                }
            }
            core["loop"] = settings;
        }
    }
    Ok(core)
}

/// Whether the dissertation's loop minds what it has run: always, but in journals from before it could.
fn is_careful(journal: &Journal) -> bool {
    match beginning(journal).filter(|_| has_results(journal)) {
        Some((_, _, then)) => then["loop"]["careful"].as_bool().unwrap_or(false),
        None => true,
    }
}

fn of(folder: &Path, problem: Problem, method: Method, mut journal: Journal) -> Result<Box<dyn Campaign>> {
    let careful = is_careful(&journal);
    match beginning(&journal) {
        Some((place, format, then)) => {
            check_begun(format, then, &core(folder, &problem, method, &journal)?)
                .with_context(|| format!("{JOURNAL}, line {}", journal.events[place].0))?;
            let before = journal
                .events
                .drain(..=place)
                .any(|(_, event)| matches!(event, Event::Told(_) | Event::Imported { .. }));
            ensure!(
                !before,
                "{JOURNAL}: the event `campaign` comes again after results, expected it on the first line only"
            );
        }
        None => {
            if let Some((line, _)) = journal.events.first() {
                bail!("{JOURNAL}, line {line}: expected the event `campaign` on the first line");
            }
        }
    }
    Ok(match method {
        Method::Pooled => Box::new(pooled::Campaign::of(folder, problem, journal)?),
        Method::Dissertation => {
            let settings = problem.dissertation_settings(careful)?;
            Box::new(dissertation::Campaign::of(folder, problem, settings, journal)?)
        }
    })
}

/// Under the names of the file. What a parameter is called for, plant or controller, is shown and changes no result.
fn as_in_the_file(core: &Value) -> Value {
    let mut core = core.clone();
    if let Some(settings) = core.get_mut("loop") {
        *settings = by_key(settings);
    }
    if let Some(settings) = core.get_mut("loop").and_then(Value::as_object_mut) {
        // None is not written down.
        settings.entry("replicates").or_insert_with(|| 0.into());
    }
    let parameters = core.get_mut("parameter").and_then(Value::as_array_mut).into_iter().flatten();
    for parameter in parameters.filter_map(Value::as_object_mut) {
        parameter.remove("role");
    }
    core
}

/// Whether a journal's beginning agrees with the problem as it is now.
fn check_begun(format: u32, then: &Value, now: &Value) -> Result<()> {
    ensure!(format == FORMAT, "the journal has format {format}, expected {FORMAT}");
    let changed = changes(&as_in_the_file(then), &as_in_the_file(now));
    ensure!(
        changed.is_empty(),
        "{PROBLEM} was changed after the journal had begun: {}; change it back, and copy it to another folder to change it there, where \
         `infuse import`, the name of this folder and `--source` take all experiments over",
        changed.join("; ")
    );
    Ok(())
}
