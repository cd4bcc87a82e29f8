//! `infuse log`: what happened, and when.

use std::path::Path;

use anyhow::Result;
use design_space::Cell;
use serde_json::{Value, json};

use super::output::Output;
use super::undo::{in_words, told};
use crate::campaign::{Campaign, Stage, changes};
use crate::echo::echo;
use crate::findings::{by_the_surface_alone, displaced_by};
use crate::folder;
use crate::journal::{Assessed, Deed, Event, Journal, Last, Learned, Measured, Submitted, Told};
use crate::number::{count, percent, short, with_unit};
use crate::problem::{Response, by_key};

/// One line of the log.
#[derive(Debug)]
struct Entry {
    /// Of its first line in the journal; 0 for what follows from all of them.
    line: usize,
    at: String,
    what: &'static str,
    sentence: String,
    is_taken_back: bool,
}

pub(crate) fn log(folder: &Path) -> Result<Output> {
    let mut campaign = folder::read(folder)?;
    let journal = Journal::read(folder)?;
    let mut entries = entries(&*campaign, &journal);
    if let Stage::Ended { reason, .. } = campaign.stage()? {
        let (at, sentence) = (String::new(), format!("{reason}."));
        entries.push(Entry { line: 0, at, what: "stopped", sentence, is_taken_back: false });
    }
    let line = |entry: &Entry| {
        let taken_back = if entry.is_taken_back { " (taken back)" } else { "" };
        format!("{:20}  {:9}  {}{taken_back}\n", entry.at, entry.what, entry.sentence)
    };
    let mut text: String = entries.iter().map(line).collect();
    if entries.is_empty() {
        "Nothing happened yet.".clone_into(&mut text);
    }
    let for_machines = |entry: &Entry| {
        json!({
            "line": (entry.line > 0).then_some(entry.line), "at": (!entry.at.is_empty()).then_some(&entry.at), "what": entry.what,
            "sentence": entry.sentence, "taken_back": entry.is_taken_back,
        })
    };
    let notices = campaign.take_notices();
    let json = json!({ "log": entries.iter().map(for_machines).collect::<Vec<_>>(), "notices": notices });
    Ok(Output { text, json, notices })
}

fn entries(campaign: &dyn Campaign, journal: &Journal) -> Vec<Entry> {
    let mut entries: Vec<Entry> = Vec::new();
    let events = &journal.all;
    let (mut at, mut settings, mut core): (&str, Option<&Value>, Option<&Value>) = ("", None, None);
    let mut simulator: Option<&str> = None;
    let mut displacement: Option<&[f64]> = None;
    let mut drifting: &[String] = &[];
    let mut index = 0;
    while let Some((line, event)) = events.get(index) {
        // What was written at once is one thing, and so are simulations one after the other.
        let n = match event {
            Event::Simulated { .. } => {
                events[index..].iter().take_while(|(_, event)| matches!(event, Event::Simulated { .. })).count()
            }
            Event::Checked { .. } => {
                events[index..].iter().take_while(|(_, event)| matches!(event, Event::Checked { .. })).count()
            }
            event => event.group().1.max(1),
        };
        let group = &events[index..events.len().min(index + n)];
        index += n;
        at = event.time().unwrap_or(at);
        let mut add = |what: &'static str, sentence: String| {
            let is_taken_back = journal.taken_back.contains(line);
            entries.push(Entry { line: *line, at: at.to_owned(), what, sentence, is_taken_back });
        };
        if let Some(now) = settings_of(event)
            && let Some(then) = settings.replace(now).filter(|then| *then != now)
        {
            add("changed", format!("campaign.toml: {}.", changed(then, now)));
        }
        match event {
            Event::Campaign { problem, .. } => {
                settings = None;
                match core.replace(problem) {
                    None => add("begun", begun(campaign)),
                    Some(then) => {
                        add("changed", format!("campaign.toml, before the first result: {}.", changed(then, problem)))
                    }
                }
                continue;
            }
            Event::Assessed(Assessed { by, .. }) => {
                if let Some(sentence) = by.as_ref().and_then(|by| another(&mut simulator, by)) {
                    add("changed", sentence);
                }
            }
            Event::Simulated { by, .. } => {
                if let Some(sentence) = another(&mut simulator, by) {
                    add("changed", sentence);
                }
            }
            // A batch that is submitted again is so without what it has given.
            Event::Submitted(submitted) if !submitted.is_of_experiments() => {
                let has_result = |cell: &Cell| {
                    let before = events[..index].iter().map(|(_, event)| event);
                    let simulated = |event: &Event| matches!(event, Event::Simulated { cell: of, by, .. } if of == cell && *by == submitted.by);
                    before.skip_while(|event| !is_first_of(event, submitted)).any(simulated)
                };
                let n = submitted.cells.iter().filter(|cell| !has_result(cell)).count();
                add("submitted", format!("{} to the queue, as {}.", count(n, "simulation"), submitted.name));
                continue;
            }
            Event::Withdrawn { source, .. } => {
                let n = in_use(&events[..index - n], source);
                add("withdrawn", format!("{} that had been imported from `{}`.", count(n, "experiment"), echo(source)));
                continue;
            }
            _ => {}
        }
        if let Some((what, sentence)) = said(campaign, event, group) {
            add(what, sentence);
        }
        if let Event::Assessed(found) = event {
            let now = found.simulation.as_ref();
            let by = now.and_then(|simulation| simulation.displacement.as_deref());
            if std::mem::replace(&mut displacement, by) != by {
                let deviations = now.and_then(|simulation| simulation.deviations.as_deref());
                add("learned", displaced(campaign, found.batch, by, deviations));
            }
            let before = std::mem::replace(&mut drifting, &found.drifting);
            drifts(found.batch, before, drifting).into_iter().for_each(|sentence| add("learned", sentence));
        }
    }
    entries
}

/// How many experiments from a source were in use after these lines, whatever was taken back since.
fn in_use(events: &[(usize, Event)], source: &str) -> usize {
    let standing = Journal::of(events.to_vec(), Vec::new()).map(|journal| journal.events).unwrap_or_default();
    let is_end = |event: &Event| match event {
        Event::Campaign { .. } => true,
        Event::Withdrawn { source: of, .. } => of == source,
        _ => false,
    };
    let is_of_it = |event: &Event| matches!(event, Event::Imported { source: of, .. } if of == source);
    standing
        .iter()
        .rev()
        .map(|(_, event)| event)
        .take_while(|event| !is_end(event))
        .filter(|event| is_of_it(event))
        .count()
}

/// The settings of the loop with which a batch was asked for, or was complete.
fn settings_of(event: &Event) -> Option<&Value> {
    match event {
        Event::Planned { settings, .. } => settings.as_ref(),
        Event::Assessed(found) => Some(&found.settings),
        _ => None,
    }
}

/// What is said where this simulator is another than the last.
fn another<'a>(simulator: &mut Option<&'a str>, by: &'a str) -> Option<String> {
    let in_words = |by: &str| if by.is_empty() { "not there".to_owned() } else { echo(by) };
    let then = simulator.replace(by).filter(|then| *then != by)?;
    Some(format!("the simulator was {} and is {}.", in_words(then), in_words(by)))
}

/// Whether this is the first submission of the same batch.
fn is_first_of(event: &Event, submitted: &Submitted) -> bool {
    matches!(event, Event::Submitted(first) if first.name.batch == submitted.name.batch)
}

/// What is said of responses that drift, and did not before, or no more.
fn drifts(batch: usize, before: &[String], now: &[String]) -> Vec<String> {
    let new = now.iter().filter(|name| !before.contains(name));
    let new = new.map(|name| format!("after batch {batch}: `{name}` drifts, runs of one batch read alike."));
    let gone = before.iter().filter(|name| !now.contains(name));
    let gone = gone.map(|name| format!("after batch {batch}: results are not sure any more that `{name}` drifts."));
    new.chain(gone).collect()
}

/// What is said where the simulation is taken to be displaced, and was not before, or otherwise, or no more.
fn displaced(campaign: &dyn Campaign, batch: usize, by: Option<&[f64]>, deviations: Option<&[f64]>) -> String {
    let parameters = campaign.problem().region.parameters();
    match by {
        Some(by) => {
            format!("after batch {batch}: the simulation is displaced: {}.", displaced_by(parameters, by, deviations))
        }
        None => format!("after batch {batch}: the simulation is taken as it stands again."),
    }
}

fn begun(campaign: &dyn Campaign) -> String {
    let problem = campaign.problem();
    let n = problem.region.n_parameters();
    format!(
        "{}: {}; {} {} is better.",
        echo(&problem.title),
        count(n, "parameter"),
        problem.response.better(),
        problem.response.name
    )
}

/// ", by the surface alone by more than 0.2 mm", where that was written down and is less.
fn alone(response: &Response, bound: f64, alone: Option<f64>) -> String {
    let alone = alone.and_then(|alone| by_the_surface_alone(response, bound, alone));
    alone.map_or_else(String::new, |alone| format!(", by the surface alone by {alone}"))
}

fn changed(then: &Value, now: &Value) -> String {
    changes(&by_key(then), &by_key(now)).join("; ")
}

/// What a line says, or the lines that were written at once.
fn said(campaign: &dyn Campaign, event: &Event, group: &[(usize, Event)]) -> Option<(&'static str, String)> {
    let problem = campaign.problem();
    let unit = &problem.response.unit;
    let as_deed = |deed: Deed| in_words(&Last { deed, events: group.to_vec() });
    Some(match event {
        Event::Planned { experiments, simulations, batch, .. } if experiments.is_empty() => {
            ("planned", format!("{} for batch {batch}.", count(simulations.len(), "simulation")))
        }
        Event::Planned { batch, experiments, purpose, .. } => {
            let why = if purpose.is_some() { ", to confirm" } else { "" };
            ("asked", format!("batch {batch}{why}: {}.", count(experiments.len(), "experiment")))
        }
        Event::Simulated { .. } => {
            let is_failed = |event: &Event| matches!(event, Event::Simulated { result: Measured::Failed(_), .. });
            let n_failed = group.iter().filter(|(_, event)| is_failed(event)).count();
            let failed = if n_failed > 0 { format!(", {n_failed} of them without a value") } else { String::new() };
            ("simulated", format!("{}{failed}.", count(group.len(), "design")))
        }
        Event::Submitted(submitted) => {
            let what = if submitted.is_of_experiments() { "experiment" } else { "simulation" };
            let Submitted { name, cells, .. } = submitted;
            ("submitted", format!("{} to the queue, as {name}.", count(cells.len(), what)))
        }
        Event::Checked { .. } => {
            let is_refused = |event: &Event| matches!(event, Event::Checked { can_be_built: false, .. });
            let n_refused = group.iter().filter(|(_, event)| is_refused(event)).count();
            let refused = if n_refused > 0 { format!(", {n_refused} of them cannot be built") } else { String::new() };
            ("checked", format!("{}{refused}.", count(group.len(), "design")))
        }
        Event::Discarded { .. } => ("discarded", "all simulations so far: the next batch makes them anew.".to_owned()),
        Event::Told(_) => {
            let of_group =
                group.iter().filter_map(|(_, event)| if let Event::Told(told) = event { Some(told) } else { None });
            ("told", format!("{}{}.", told(of_group), value_of(event, unit)))
        }
        Event::Imported { .. } => ("imported", format!("{}.", as_deed(Deed::Import).replacen("imported ", "", 1))),
        Event::Undone { deed, lines, .. } => (
            "undone",
            format!(
                "{}: {} of the journal, marked above, {} no longer.",
                deed.in_words(),
                count(*lines, "line"),
                if *lines == 1 { "counts" } else { "count" }
            ),
        ),
        Event::Assessed(found) => {
            // On the scale that it was said on.
            let response = &Response { scale: found.scale, ..problem.response.clone() };
            let known_to = found.bound.unwrap_or(found.deviation);
            let expected = with_unit(&response.number_to(response.cost(found.expected), known_to), unit);
            let at = problem.describe(&found.recommended);
            (
                "learned",
                match found.bound {
                    Some(bound) => format!(
                        "after batch {}: {at} is best, with {expected}; with {} probability none is better by more than {}{}.",
                        found.batch,
                        percent(found.probability),
                        response.amount(bound),
                        alone(response, bound, found.alone)
                    ),
                    None => format!(
                        "after batch {}: {at} is best, with {expected}; by how much others may be better cannot be said yet.",
                        found.batch
                    ),
                },
            )
        }
        Event::Learned(Learned { batch, optimum, predicted, .. }) => {
            let predicted = with_unit(&short(*predicted), unit);
            (
                "learned",
                format!("from batch {batch}: {} is best, with {predicted} predicted.", problem.describe(optimum)),
            )
        }
        Event::Campaign { .. } | Event::Opened { .. } | Event::Sheet { .. } | Event::Withdrawn { .. } => return None,
    })
}

/// ", travel 11.2, weight 3".
fn of_constraints(one: &Told) -> String {
    one.constrained.iter().map(|(name, value)| format!(", {name} {}", crate::number::plain(*value))).collect()
}

/// Of a single result, what it was.
fn value_of(event: &Event, unit: &str) -> String {
    match event {
        Event::Told(one @ Told { rows: 1, result: Measured::Value(value), .. }) => {
            format!(": {}{}", with_unit(&crate::number::plain(*value), unit), of_constraints(one))
        }
        Event::Told(Told { rows: 1, result: Measured::Failed(reason), .. }) => format!(": {}", echo(reason)),
        _ => String::new(),
    }
}
