//! `infuse tell`: results come back.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::Duration;

use anyhow::{Context as _, Result, anyhow, bail, ensure};
use page::Finding;
use serde_json::{Value, json};

use super::output::Output;
use super::settings;
use crate::arguments::Tell;
use crate::campaign::{Campaign, Reading, Stage};
use crate::echo::echo;
use crate::findings::{ended, next, outstanding, taken, without_columns};
use crate::folder;
use crate::journal::{Event, Measured, Told, Writer, now};
use crate::number::{count, plain};
use crate::problem::Problem;
use crate::sheet::{Answer, Answers, Fault, answers, none_of};
use crate::shell::infuse;

pub(crate) fn tell(folder: &Path, wait: Duration, tell: &Tell) -> Result<Output> {
    let (mut campaign, mut writer) = folder::open(folder, wait)?;
    let mut notices = campaign.take_notices();
    let (Answers { filled, n_empty, said_twice, lacks }, from) = match &tell.sheet {
        Some(path) => (answers(path, campaign.problem(), &campaign.experiments().trials)?, path.display().to_string()),
        None => {
            let filled = vec![single(tell, &*campaign)?];
            (Answers { filled, n_empty: 0, said_twice: Vec::new(), lacks: Vec::new() }, "the command line".to_owned())
        }
    };
    notices.extend(said_twice);
    let (fresh, n_known) = fresh(&*campaign, filled, &from, tell.correct)?;
    let (n, infuse) = (fresh.len(), infuse(campaign.folder()));
    let (mut findings, json) = take(&mut *campaign, &mut writer, fresh, &from, (n_known, n_empty))?;
    if n > 0 && !lacks.is_empty() {
        findings.insert(1, without_columns(&lacks, n, &format!("{infuse} tell {from} --correct")));
    }
    Ok(Output::new(&findings, json, notices))
}

/// Writes new results down, each with whether it replaces one, beside rows that were known or are empty.
pub(crate) fn take(
    campaign: &mut dyn Campaign,
    writer: &mut Writer,
    fresh: Vec<(Answer, bool)>,
    from: &str,
    (n_known, n_empty): (usize, usize),
) -> Result<(Vec<Finding>, Value)> {
    let n_closed = campaign.n_closed();
    let rows = fresh.len();
    let n_failed = fresh.iter().filter(|(answer, _)| answer.result.value().is_none()).count();
    let (at, problem) = (now(), campaign.problem().clone());
    let event = |(index, (answer, corrects)): (usize, (Answer, bool))| {
        let Answer { id, result, constrained, actual, repeat, note, .. } = answer;
        let (from, at, units) = (from.to_owned(), at.clone(), problem.units_of(&constrained));
        Event::Told(Told {
            row: index + 1,
            rows,
            id,
            result,
            constrained,
            units,
            actual,
            repeat,
            corrects,
            note,
            from,
            at,
        })
    };
    let events: Vec<Event> = fresh.into_iter().enumerate().map(event).collect();
    campaign.record(writer, events)?;
    let mut findings = taken(rows, n_failed, n_known, n_empty);
    let n_outstanding = campaign.experiments().n_outstanding();
    let batch = campaign.experiments().last_batch().unwrap_or(0);
    let is_closed = campaign.n_closed() > n_closed;
    if is_closed {
        let infuse = infuse(campaign.folder());
        findings.extend(campaign.lesson()?);
        findings.push(match campaign.stage()? {
            Stage::Ended { reason, .. } => {
                ended(&reason).detail(Finding::new(format!("Where it ended: {infuse} status")))
            }
            stage @ Stage::Pending => next(campaign, &stage),
            Stage::Ready => Finding::new(format!("Next: {infuse} status, then {infuse} ask")),
        });
    } else if n_outstanding > 0 {
        let experiments = campaign.experiments();
        findings.extend(
            experiments.open_batches().into_iter().map(|open| outstanding(open, experiments.n_outstanding_of(open))),
        );
    } else if rows > 0 {
        // A result put right, or one more run, may change what a whole sheet taught.
        findings.extend(campaign.lesson()?);
        findings.push(Finding::new(format!("Next: {} status", infuse(campaign.folder()))));
    }
    let json = json!({
        "taken": rows, "known": n_known, "empty": n_empty, "batch": batch, "outstanding": n_outstanding,
        "batch_is_complete": is_closed,
    });
    Ok((findings, json))
}

/// An experiment told by its id.
fn single(tell: &Tell, campaign: &dyn Campaign) -> Result<Answer> {
    let problem = campaign.problem();
    let id = tell.id.context("expected a sheet or --id")?;
    let result = match (tell.value, &tell.failed) {
        (Some(value), None) => {
            if let Some(expected) = problem.response.fault(value) {
                bail!("--value is {value}, expected {expected}");
            }
            Measured::Value(value)
        }
        (None, Some(reason)) if !reason.trim().is_empty() => Measured::Failed(reason.clone()),
        (None, Some(_)) => bail!("--failed is empty, expected the reason"),
        _ => bail!("expected --value or --failed beside --id"),
    };
    let actual = match &tell.actual {
        Some(text) => settings::some(text, &problem.region).context("--actual")?,
        None => BTreeMap::new(),
    };
    ensure!(!tell.again || actual.is_empty(), "--again is at the same settings; import a run at others");
    for (name, &value) in &actual {
        let index = problem.region.index_of(name).context("a parameter")?;
        if let Some(expected) = crate::sheet::setting_fault(&problem.region.parameters()[index], value) {
            bail!("--actual: `{name}` is {}, expected {expected}", plain(value));
        }
    }
    ensure!(
        !tell.again || campaign.experiments().readings.get(&id).is_some_and(|reading| reading.first.is_some()),
        "--again: experiment {id} has no result yet, expected one more run of an experiment that was told"
    );
    let reading = campaign.experiments().readings.get(&id);
    let repeat = match reading {
        // Said on the command line, one more run is one more run, whatever it gave.
        Some(reading) if tell.again => reading.again.keys().next_back().copied().unwrap_or(0) + 1,
        Some(reading) if tell.correct => run_to_correct(tell, campaign, id, reading)?,
        _ => 0,
    };
    ensure!(repeat == 0 || actual.is_empty(), "--actual is of the first run alone; import a run at other settings");
    let constrained = match &tell.constrained {
        Some(text) => constrained(text, problem).context("--constrained")?,
        None => BTreeMap::new(),
    };
    Ok(Answer { id, result, constrained, actual, repeat, note: tell.note.clone().unwrap_or_default(), row: 0 })
}

/// The repeat that is meant, 0 for the first run: of several it has to be said which.
fn run_to_correct(tell: &Tell, campaign: &dyn Campaign, id: u64, reading: &Reading) -> Result<usize> {
    let repeats: Vec<usize> = std::iter::once(0).chain(reading.again.keys().copied()).collect();
    let results = repeats.iter().filter_map(|&repeat| reading.result(repeat));
    let results: Vec<String> = results.map(|result| result_in_words(campaign, result)).collect();
    let had = format!("experiment {id} had {}: {}", count(repeats.len(), "run"), results.join("; "));
    match tell.run {
        Some(run) => {
            let known = repeats.get(run - 1).copied();
            known.with_context(|| format!("--run is {run}, but {had}; expected at most {}", repeats.len()))
        }
        None if repeats.len() == 1 => Ok(0),
        None => bail!("{had}; expected --run beside --correct, 1 for the first of them"),
    }
}

/// "travel=11.2,force=300", by the names of constraints.
fn constrained(text: &str, problem: &Problem) -> Result<BTreeMap<String, f64>> {
    let named: Vec<String> = problem.constraints.iter().map(|held| format!("`{}`", held.name())).collect();
    let mut all = BTreeMap::new();
    for part in text.split(',').filter(|part| !part.trim().is_empty()) {
        let (name, value) =
            part.split_once('=').with_context(|| format!("`{part}` is no value, expected name=value"))?;
        let name = name.trim();
        ensure!(
            problem.constraints.iter().any(|held| held.name() == name),
            "no constraint is called `{name}`, expected {}",
            match named.as_slice() {
                [] => "a name of a [[constraint]], of which there are none".to_owned(),
                all => all.join(", "),
            }
        );
        let value = crate::number::parse(value.trim())
            .map_err(|expected| anyhow!("`{name}` is `{}`, expected {expected}", value.trim()))?;
        ensure!(all.insert(name.to_owned(), value).is_none(), "`{name}` comes twice");
    }
    Ok(all)
}

/// What is new, each with whether it replaces a result, and how much was known.
fn fresh(
    campaign: &dyn Campaign,
    answers: Vec<Answer>,
    from: &str,
    correct: bool,
) -> Result<(Vec<(Answer, bool)>, usize)> {
    let (mut fresh, mut faults): (Vec<(Answer, bool)>, Vec<Fault>) = (Vec::new(), Vec::new());
    let mut n_known = 0;
    for answer in answers {
        let id = answer.id;
        let Some(trial) = campaign.experiments().trials.get(&id) else {
            return Err(anyhow!("{from}: experiment {id} was never asked for, expected {}", asked(campaign)));
        };
        // A sheet that is told twice does not make runs twice.
        let told = campaign.experiments().readings.get(&id).and_then(|reading| reading.result(answer.repeat));
        let reading = campaign.experiments().readings.get(&id);
        let same_constrained = reading.and_then(|r| r.constrained.get(&answer.repeat)) == Some(&answer.constrained);
        let same_settings =
            same_constrained && (answer.repeat > 0 || reading.is_some_and(|reading| reading.actual == answer.actual));
        if told == Some(&answer.result) && same_settings {
            n_known += 1;
            continue;
        }
        if let Some(told) = told.filter(|_| !correct) {
            let said = match campaign.experiments().readings.get(&id).filter(|_| answer.repeat == 0) {
                Some(reading) => said(campaign, reading),
                None => result_in_words(campaign, told),
            };
            if answer.row == 0 {
                let (now, infuse) = (result_in_words(campaign, &answer.result), infuse(campaign.folder()));
                let result = match &answer.result {
                    Measured::Value(value) => format!("--value {}", plain(*value)),
                    Measured::Failed(reason) => format!("--failed \"{}\"", echo(reason)),
                };
                bail!(
                    "experiment {id} has a result already, {said}, and {now} was not taken; add --correct to replace it, or --again if \
                     it is one more run: {infuse} tell --id {id} {result} --correct"
                );
            }
            let more = if answer.repeat > 0 {
                format!("; for one more run: infuse tell --id {id} --value ... --again")
            } else {
                String::new()
            };
            let expected = format!(
                "the result known before, {said}; to replace it, tell experiment {id} again with --correct{more}"
            );
            let (column, value) = (campaign.problem().response.name.clone(), result_in_words(campaign, &answer.result));
            faults.push(Fault { row: answer.row, column, value, expected });
            continue;
        }
        if correct && answer.row == 0 && told.is_none() {
            bail!(
                "--correct: experiment {id} has no result yet, expected one that is to be replaced; its first result is told without \
                 --correct"
            );
        }
        if let Some(expected) = campaign.refusal(trial) {
            faults.push(Fault { row: answer.row, column: "id".to_owned(), value: id.to_string(), expected });
            continue;
        }
        let corrects = told.is_some();
        fresh.push((answer, corrects));
    }
    none_of(from, &faults)?;
    Ok((fresh, n_known))
}

fn asked(campaign: &dyn Campaign) -> String {
    match (campaign.experiments().trials.keys().next(), campaign.experiments().trials.keys().next_back()) {
        (Some(first), Some(last)) => format!("an id from {first} to {last}"),
        _ => "one that was asked for, and nothing was yet: see `infuse ask`".to_owned(),
    }
}

fn said(campaign: &dyn Campaign, reading: &Reading) -> String {
    let result = reading.first.as_ref().map(|result| result_in_words(campaign, result)).unwrap_or_default();
    let made = reading.actual.iter().map(|(name, &value)| format!("{name} {}", plain(value)));
    let made: Vec<String> = made.collect();
    if made.is_empty() { result } else { format!("{result} at {}", made.join(", ")) }
}

fn result_in_words(campaign: &dyn Campaign, result: &Measured) -> String {
    match result {
        Measured::Value(value) => crate::number::with_unit(&plain(*value), &campaign.problem().response.unit),
        Measured::Failed(reason) => format!("failed: {reason}"),
    }
}
