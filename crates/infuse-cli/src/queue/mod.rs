//! Simulations and experiments on a cluster, through whatever scheduler has a command to submit and one to list.
//!
//! A batch of runs is a folder, a result is a file in it, and the journal has a submission before the scheduler does. So whoever is
//! killed, nothing is lost, and nothing is submitted twice: killed before the scheduler took it, its name is in no list and there
//! is no result, and it is submitted again; killed after, its name is in the list, or its results are there.
//! A list that cannot be had means that nobody knows, never that a job is gone; and one that has never shown any name yet may
//! leave names out, so nothing is submitted again on its word.

mod runs;
mod scheduler;
mod script;
mod stages;
mod task;

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result, bail};
use design_space::Region;
use sha2::{Digest as _, Sha256};

use crate::echo::echo;
use crate::journal::{Measured, SubmissionName, Submitted, now};
use crate::problem::{Program, Queue};
use crate::program;
use runs::Runs;
use script::ranges;
pub(crate) use stages::{Stages, stages};
pub(crate) use task::{Key, Task};

/// Tasks of one submission, at most: Slurm's own limit is 1001, and counts from 0.
const MOST_TASKS: usize = 1000;
/// A name that was not in the list so often in a row, without a result meanwhile, is not in the queue: what it left may come
/// late over a network.
const GONE: usize = 2;
/// The same for a name that the scheduler took and no list has shown yet: it may show it late.
const NEVER_SHOWN: usize = 10;
/// Pieces of a pause, so that an interrupt is noticed.
const PIECE: Duration = Duration::from_millis(50);

/// What a queue needs to know of a campaign.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Queued<'a> {
    pub(crate) folder: &'a Path,
    pub(crate) region: &'a Region,
    pub(crate) program: &'a Program,
    pub(crate) queue: &'a Queue,
    /// The simulator, or the command of the experiments, as remembered runs name it.
    pub(crate) by: &'a str,
    /// Every submission of the journal that is of the same kind.
    pub(crate) submitted: &'a [Submitted],
}

impl Queued<'_> {
    /// Why a submission is not made again.
    fn never_shown(&self, name: &str, runs: &Runs, listed: &str) -> String {
        let printed = match listed.trim() {
            "" => "nothing".to_owned(),
            listed => format!("`{}`", echo(listed)),
        };
        format!(
            "{}: `submit` took `{name}`, and `list` has not shown it once, looked at {NEVER_SHOWN} times without a result in \
             between. It printed {printed}. A list that leaves jobs out or cuts their names would have all submitted again while \
             it runs, so nothing was; whole names are needed, as in `squeue --me --format=%j`. Put `list` right and call again: \
             nothing is lost. If the scheduler has lost it, remove {} and call again: it is submitted anew",
            self.queue.section,
            runs.taken(name).display()
        )
    }
}

/// What happened, to be written down at once.
pub(crate) enum Happened<'a> {
    Submitted(Submitted),
    /// With every other number that it gave, by name.
    Ended(&'a Task, Measured, BTreeMap<String, f64>),
}

/// Submissions of the same runs, one after the other.
#[derive(Debug)]
struct Batch {
    stem: String,
    keys: Vec<Key>,
    /// Submissions so far.
    names: Vec<String>,
    runs: Runs,
    /// How often in a row its last submission was not listed, and no result came.
    n_absent: usize,
    /// Runs that were waited for when it was looked at last.
    n_waiting: usize,
    /// Submissions that the scheduler is known to have taken since a result came.
    n_fruitless: usize,
}

impl Batch {
    /// Runs that are waited for, numbered from 1.
    fn waiting<'a>(&'a self, tasks: &'a BTreeMap<Key, &Task>) -> impl Iterator<Item = (usize, Key)> + 'a {
        let numbered = self.keys.iter().enumerate().map(|(index, &key)| (index + 1, key));
        numbered.filter(|(_, key)| tasks.contains_key(key))
    }

    /// With its submissions so far: which of them gave a result is not known any more.
    fn of_journal(stem: &str, keys: Vec<Key>, runs: Runs, names: Vec<String>) -> Self {
        let n_fruitless = names.iter().filter(|name| runs.said(name).is_some()).count();
        Self { stem: stem.to_owned(), keys, names, runs, n_absent: 0, n_waiting: usize::MAX, n_fruitless }
    }

    /// Takes in what a list says of the last submission.
    fn look(&mut self, listed: &str, n_waiting: usize) -> Result<()> {
        let is_listed = self.names.last().is_some_and(|name| scheduler::is_listed(listed, name));
        if let (true, Some(name)) = (is_listed, self.names.last()) {
            self.runs.note_shown(name)?;
        }
        let has_result = n_waiting < self.n_waiting;
        if has_result && self.n_waiting < usize::MAX {
            self.n_fruitless = 0;
        }
        let is_alive = is_listed || has_result;
        self.n_absent = if is_alive { 0 } else { self.n_absent + 1 };
        self.n_waiting = n_waiting;
        Ok(())
    }

    /// The last submission, if the scheduler took it and no list has shown it.
    fn never_shown(&self) -> Option<&str> {
        self.names
            .last()
            .map(String::as_str)
            .filter(|name| self.runs.said(name).is_some() && !self.runs.was_shown(name))
    }

    fn is_gone(&self) -> bool {
        self.n_absent >= if self.never_shown().is_some() { NEVER_SHOWN } else { GONE }
    }
}

/// Queues these, and waits until each has a result, or a person wants to stop; `show` is told how many runs wait for theirs, and
/// what is wrong with the queue.
pub(crate) fn run_all<'a>(
    of: Queued<'_>,
    tasks: &'a [Task],
    mut happened: impl FnMut(Happened<'a>) -> Result<()>,
    mut show: impl FnMut(usize, &str),
) -> Result<()> {
    let mut waiting: BTreeMap<Key, &Task> = tasks.iter().map(|task| (task.key, task)).collect();
    let mut batches = batches(of);
    let mut shows_names =
        of.submitted.iter().any(|one| Runs::of(of.folder, &one.name.batch).was_shown(&one.name.to_string()));
    let _running = program::Running::new();
    take_results(&batches, &mut waiting, &mut happened)?;
    loop {
        batches.retain(|batch| batch.waiting(&waiting).next().is_some());
        if waiting.is_empty() || program::is_interrupted() {
            return Ok(());
        }
        let known: BTreeSet<Key> = batches.iter().flat_map(|batch| &batch.keys).copied().collect();
        let is_new = |key: &Key| waiting.contains_key(key) && !known.contains(key);
        let new: Vec<Key> = tasks.iter().map(|task| task.key).filter(is_new).collect();
        for keys in new.chunks(MOST_TASKS * of.queue.runs_per_task) {
            let mut batch = begin(of, keys, batches.len());
            submit(of, &mut batch, &waiting, &mut happened)?;
            batches.push(batch);
        }
        show(waiting.len(), "");
        pause(of.queue.poll);
        // The list before the files: what ends in between is in both, and not in neither.
        let listed = scheduler::run(of.folder, of.queue, &of.queue.list, &[]);
        take_results(&batches, &mut waiting, &mut happened)?;
        let listed = match listed {
            Ok(listed) => listed,
            Err(error) => {
                show(waiting.len(), &format!("{error:#}"));
                continue;
            }
        };
        for batch in &mut batches {
            let n_waiting = batch.waiting(&waiting).count();
            batch.look(&listed, n_waiting)?;
            shows_names |= batch.n_absent == 0 && batch.never_shown().is_none();
            if n_waiting == 0 || !batch.is_gone() {
                continue;
            }
            if let (false, Some(name)) = (shows_names, batch.never_shown()) {
                bail!("{}", of.never_shown(name, &batch.runs, &listed));
            }
            if batch.n_fruitless < of.queue.tries {
                submit(of, batch, &waiting, &mut happened)?;
            } else {
                give_up(of, batch, &mut waiting, &mut happened)?;
            }
        }
    }
}

/// Those of the journal that are of this command.
fn batches(of: Queued<'_>) -> Vec<Batch> {
    let mut found: Vec<(&Submitted, Vec<String>)> = Vec::new();
    for one in of.submitted.iter().filter(|one| one.by == of.by) {
        let name = one.name.to_string();
        match found.iter_mut().find(|(first, _)| first.name.batch == one.name.batch) {
            Some((_, names)) => names.push(name),
            None => found.push((one, vec![name])),
        }
    }
    let batch = |(first, names): (&Submitted, Vec<String>)| {
        let stem = &first.name.batch;
        Batch::of_journal(stem, Key::of(first), Runs::of(of.folder, stem), names)
    };
    found.into_iter().map(batch).collect()
}

fn begin(of: Queued<'_>, keys: &[Key], n_before: usize) -> Batch {
    // Another campaign in the same folder, or another beginning of this one, must not find these results.
    let mut hash = Sha256::new();
    for part in
        [&of.folder.display().to_string(), of.by, &now(), &format!("{} {n_before} {keys:?}", std::process::id())]
    {
        hash.update(part.as_bytes());
    }
    let id: String = hash.finalize().iter().take(4).map(|byte| format!("{byte:02x}")).collect();
    let stem = format!("infuse-{id}");
    let runs = Runs::of(of.folder, &stem);
    Batch::of_journal(&stem, keys.to_vec(), runs, Vec::new())
}

fn take_results<'a>(
    batches: &[Batch],
    waiting: &mut BTreeMap<Key, &'a Task>,
    happened: &mut impl FnMut(Happened<'a>) -> Result<()>,
) -> Result<()> {
    for batch in batches {
        let ended: Vec<(Key, _)> =
            batch.waiting(waiting).filter_map(|(number, key)| Some((key, batch.runs.result(number)?))).collect();
        for (key, (result, others)) in ended {
            if let Some(task) = waiting.remove(&key) {
                happened(Happened::Ended(task, result, others))?;
            }
        }
    }
    Ok(())
}

/// Submits what a batch waits for: written down first, so that a killed call knows the name.
fn submit<'a>(
    of: Queued<'_>,
    batch: &mut Batch,
    waiting: &BTreeMap<Key, &'a Task>,
    happened: &mut impl FnMut(Happened<'a>) -> Result<()>,
) -> Result<()> {
    let submission = SubmissionName { batch: batch.stem.clone(), attempt: batch.names.len() + 1 };
    let name = submission.to_string();
    // A run that has its result is not run again.
    let tasks: Vec<Option<&Task>> = batch.keys.iter().map(|key| waiting.get(key).copied()).collect();
    let script = batch.runs.write(of.folder, of.region, of.program, of.queue, &name, &tasks)?;
    let per_task = of.queue.runs_per_task;
    let mut tasks: Vec<usize> = batch.waiting(waiting).map(|(number, _)| (number - 1) / per_task + 1).collect();
    tasks.dedup();
    let (by, cells) = (of.by.to_owned(), batch.keys.iter().map(|key| key.cell()).collect());
    let experiments = batch.keys.iter().filter_map(|key| key.id()).collect();
    happened(Happened::Submitted(Submitted { name: submission, cells, experiments, by, at: now() }))?;
    batch.names.push(name.clone());
    let n_waiting = batch.waiting(waiting).count();
    (batch.n_absent, batch.n_waiting) = (0, n_waiting);
    let (first, last) = (tasks.first().copied().unwrap_or(1), tasks.last().copied().unwrap_or(1));
    let filled = [
        ("{name}", name.clone()),
        ("{tasks}", ranges(&tasks)),
        // Some schedulers know no array of one task; one that has nothing to run ends at once.
        ("{range}", format!("{first}-{}", last.max(first + 1))),
        ("{first}", first.to_string()),
        ("{last}", last.to_string()),
        ("{script}", script.display().to_string()),
    ];
    let said = scheduler::run(of.folder, of.queue, &of.queue.submit, &filled).with_context(|| {
        let again = if batch.keys.iter().any(|key| key.id().is_some()) { "run" } else { "ask" };
        format!("{} `submit` failed: nothing is lost, {again} again", of.queue.section)
    })?;
    batch.n_fruitless += 1;
    batch.runs.note_taken(&name, &said)
}

/// What the queue lost too often has failed.
fn give_up<'a>(
    of: Queued<'_>,
    batch: &Batch,
    waiting: &mut BTreeMap<Key, &'a Task>,
    happened: &mut impl FnMut(Happened<'a>) -> Result<()>,
) -> Result<()> {
    let lost: Vec<(usize, Key)> = batch.waiting(waiting).collect();
    for (number, key) in lost {
        if let Some(task) = waiting.remove(&key) {
            let reason = format!(
                "the queue lost it {} times, and gave nothing else meanwhile; {number}.sh in {} is what it was to run",
                of.queue.tries,
                batch.runs.path().display()
            );
            happened(Happened::Ended(task, Measured::Failed(reason), BTreeMap::new()))?;
        }
    }
    Ok(())
}

/// Stops what is in the queue of these. How many submissions.
pub(crate) fn cancel<'a>(
    folder: &Path,
    queue: &Queue,
    submitted: impl Iterator<Item = &'a Submitted>,
) -> Result<usize> {
    anyhow::ensure!(!queue.cancel.is_empty(), "{} has no `cancel`, so nothing can be stopped from here", queue.section);
    let listed = scheduler::run(folder, queue, &queue.list, &[])?;
    let mut n = 0;
    for one in submitted {
        let name = one.name.to_string();
        if !scheduler::is_listed(&listed, &name) {
            continue;
        }
        let runs = Runs::of(folder, &one.name.batch);
        runs.note_shown(&name)?;
        let said = runs.said(&name).unwrap_or_default();
        let job = said.split_whitespace().next_back().unwrap_or_default().to_owned();
        let stopped = scheduler::run(folder, queue, &queue.cancel, &[("{name}", name.clone()), ("{job}", job)]);
        if let Err(error) = stopped {
            // What ended between the two calls is nobody's to stop, which schedulers call an error.
            anyhow::ensure!(!scheduler::is_listed(&scheduler::run(folder, queue, &queue.list, &[])?, &name), error);
            continue;
        }
        runs.note_stopped(&name)?;
        n += 1;
    }
    Ok(n)
}

fn pause(poll: Duration) {
    let start = Instant::now();
    while start.elapsed() < poll && !program::is_interrupted() {
        std::thread::sleep(PIECE.min(poll));
    }
}
