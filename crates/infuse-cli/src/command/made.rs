//! Experiments that a command makes: here, one after the other, or in a queue.

use std::collections::BTreeMap;

use anyhow::{Context as _, Result, bail};

use crate::campaign::{Campaign, Progress, checked};
use crate::job_numbers::JobNumbers;
use crate::journal::{BY_ITSELF, Constrained, Event, Measured, Submitted, Told, Writer, now};
use crate::number::count;
use crate::problem::{Problem, Program, Queue};
use crate::program::{Ran, is_interrupted};
use crate::queue::{self, Happened, Key, Queued, Task};
use crate::sheet;
use crate::shell::sheet_path;
use crate::simulator::identity_of;

/// Makes the experiments that are waited for, and writes each down at once. How many.
pub(super) fn make(campaign: &mut dyn Campaign, writer: &mut Writer) -> Result<usize> {
    let problem = campaign.problem().clone();
    let experiment = problem.experiment.as_ref().context("an experiment")?;
    let tasks = waited_for(campaign)?;
    match &experiment.queue {
        None => make_here(campaign, writer, &problem, &experiment.program, &tasks),
        Some(queue) => make_queued(campaign, writer, &problem, (&experiment.program, queue), &tasks),
    }
}

/// All experiments without a result, in the order of the sheets, which are written if they are missing.
fn waited_for(campaign: &dyn Campaign) -> Result<Vec<Task>> {
    let (folder, problem, experiments) = (campaign.folder(), campaign.problem(), campaign.experiments());
    let mut tasks = Vec::new();
    for batch in 1..=experiments.last_batch().unwrap_or(0) {
        let of_batch = experiments.in_run_order(batch, problem.seed);
        let waited: Vec<Task> = of_batch
            .iter()
            .filter(|(trial, _)| !experiments.has_result(trial.id))
            .map(|(trial, _)| Task { key: Key::Experiment(trial.id.number(), trial.cell), point: trial.point.clone() })
            .collect();
        let path = sheet_path(folder, problem.sheets, batch, None);
        if !waited.is_empty() && !path.exists() {
            sheet::write(&path, problem, &of_batch)?;
        }
        tasks.extend(waited);
    }
    Ok(tasks)
}

fn make_here(
    campaign: &mut dyn Campaign,
    writer: &mut Writer,
    problem: &Problem,
    program: &Program,
    tasks: &[Task],
) -> Result<usize> {
    let folder = campaign.folder().to_path_buf();
    let mut numbers = JobNumbers::default();
    for task in tasks {
        let ran = program.run(&folder, &problem.region, &task.point, task.key.id())?;
        // What an experiment gave is written down at once: it may be taken back, but not made again for nothing.
        numbers.suspects(&ran, 1).context("what was written down so far: `infuse undo` takes it back")?;
        let (result, others) = match ran {
            Ran::Value { value, others, .. } => (Measured::Value(value), others),
            Ran::Failed(reason) => (Measured::Failed(reason), BTreeMap::new()),
            Ran::Interrupted => bail!("interrupted: the results so far are written down, run again to go on"),
        };
        campaign.record(writer, vec![told(problem, task, result, others)])?;
    }
    Ok(tasks.len())
}

fn make_queued(
    campaign: &mut dyn Campaign,
    writer: &mut Writer,
    problem: &Problem,
    (program, queue): (&Program, &Queue),
    tasks: &[Task],
) -> Result<usize> {
    let (folder, by) = (campaign.folder().to_path_buf(), identity_of(program));
    let submitted: Vec<Submitted> =
        campaign.submitted().iter().filter(|one| one.is_of_experiments()).cloned().collect();
    let of = Queued { folder: &folder, region: &problem.region, program, queue, by: &by, submitted: &submitted };
    let mut progress = Progress::new("experiments", tasks.len());
    let (bar, mut n_made) = (progress.bar(), 0);
    let happened = |happens: Happened<'_>| match happens {
        Happened::Submitted(submitted) => campaign.record(writer, vec![Event::Submitted(submitted)]),
        Happened::Ended(task, result, others) => {
            campaign.record(writer, vec![told(problem, task, result, others)])?;
            n_made += 1;
            bar.inc(1);
            Ok(())
        }
    };
    let outcome = queue::run_all(of, tasks, happened, |n, trouble| progress.queued(n, trouble));
    bar.finish_and_clear();
    outcome?;
    if is_interrupted() && n_made < tasks.len() {
        let stop = if queue.cancel.is_empty() { "" } else { ", or stop it with `infuse cancel`" };
        bail!(
            "interrupted: {n_made} of {} are written down, what is in the queue goes on; run again to wait for it{stop}",
            count(tasks.len(), "experiment")
        );
    }
    Ok(n_made)
}

/// The line for a result; a value that cannot be is a failure.
fn told(problem: &Problem, task: &Task, result: Measured, others: BTreeMap<String, f64>) -> Event {
    let impossible = result.value().and_then(|value| Some((value, problem.response.fault(value)?)));
    let (result, constrained) = match (impossible, &result) {
        (Some((value, expected)), _) => {
            (Measured::Failed(format!("it returned {value}, expected {expected}")), Constrained::new())
        }
        (None, _) => checked(problem, result, others),
    };
    let (actual, note, id) = (BTreeMap::new(), String::new(), task.key.id().unwrap_or_default());
    let (from, at, units) = (BY_ITSELF.to_owned(), now(), problem.units_of(&constrained));
    Event::Told(Told {
        row: 1,
        rows: 1,
        id,
        result,
        constrained,
        units,
        actual,
        repeat: 0,
        corrects: false,
        note,
        from,
        at,
    })
}
