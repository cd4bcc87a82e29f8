//! How simulations and experiments are queued: the commands of a scheduler, known ones or others.

use std::time::Duration;

use anyhow::{Result, ensure};

use super::file::{QueueEntry, QueueKind};

const POLL_SECONDS: f64 = 10.0;
const LONGEST_POLL_SECONDS: f64 = 3600.0;
const TRIES: usize = 3;
const MOST_TRIES: usize = 100;
const MOST_RUNS_PER_TASK: usize = 100_000;

/// The commands of a scheduler, with placeholders, and how patient one is with it.
#[derive(Debug, Clone)]
pub(crate) struct Queue {
    /// Its heading in the file.
    pub(crate) section: &'static str,
    /// Hands a script to the scheduler, as an array of tasks.
    pub(crate) submit: Vec<String>,
    /// Prints the names of all that runs or waits.
    pub(crate) list: Vec<String>,
    /// Stops all tasks of a submission.
    pub(crate) cancel: Vec<String>,
    /// Take the place of `{options}`.
    pub(crate) options: Vec<String>,
    /// From one look at the queue to the next.
    pub(crate) poll: Duration,
    /// How often a run is submitted before it counts as failed.
    pub(crate) tries: usize,
    /// Runs that a task makes one after the other.
    pub(crate) runs_per_task: usize,
}

impl Queue {
    pub(super) fn of(entry: QueueEntry, section: &'static str) -> Result<Self> {
        let [submit, list, cancel] = chosen(entry.kind, [entry.submit, entry.list, entry.cancel])?;
        let options = entry.options.unwrap_or_default();
        check_placeholders(&submit, !options.is_empty())?;
        let seconds = entry.poll_seconds.unwrap_or(POLL_SECONDS);
        ensure!(
            seconds > 0.0 && seconds <= LONGEST_POLL_SECONDS,
            "`poll_seconds` is {seconds:?}, expected a positive number up to {LONGEST_POLL_SECONDS}"
        );
        let tries = entry.tries.unwrap_or(TRIES);
        ensure!((1..=MOST_TRIES).contains(&tries), "`tries` is {tries}, expected 1 to {MOST_TRIES}");
        let runs_per_task = entry.runs_per_task.unwrap_or(1);
        ensure!(
            (1..=MOST_RUNS_PER_TASK).contains(&runs_per_task),
            "`runs_per_task` is {runs_per_task}, expected 1 to {MOST_RUNS_PER_TASK}"
        );
        let poll = Duration::from_secs_f64(seconds);
        Ok(Self { section, submit, list, cancel, options, poll, tries, runs_per_task })
    }
}

/// Submit, list and cancel: as given, or else as usual for a kind of scheduler. Only cancel may be missing.
fn chosen(kind: Option<QueueKind>, given: [Option<Vec<String>>; 3]) -> Result<[Vec<String>; 3]> {
    let usual = kind.map(|kind| commands(kind).map(|command| command.iter().map(|word| (*word).to_owned()).collect()));
    let usual: [Vec<String>; 3] = usual.unwrap_or_default();
    let mut usual = usual.into_iter();
    let chosen = given.map(|given| {
        let usual = usual.next().unwrap_or_default();
        given.unwrap_or(usual)
    });
    for (key, command) in ["submit", "list"].into_iter().zip(&chosen) {
        ensure!(
            command.first().is_some_and(|word| !word.is_empty()),
            "needs `{key}` = [\"program\", \"argument\", ...], or `kind` = \"slurm\", \"hyperqueue\", \"pbs\", \"lsf\" or \
             \"parallel\""
        );
    }
    Ok(chosen)
}

/// That the scheduler is told what to run, and which tasks.
fn check_placeholders(submit: &[String], has_options: bool) -> Result<()> {
    let has = |name: &str| submit.iter().any(|word| word.contains(name));
    ensure!(has("{script}"), "`submit` has no {{script}}, so the scheduler cannot know what to run");
    ensure!(
        ["{tasks}", "{range}", "{first}"].iter().any(|name| has(name)),
        "`submit` has none of {{tasks}} (\"1-4,7\"), {{range}} (\"1-7\"), {{first}} with {{last}}: the scheduler cannot know \
         which tasks to run"
    );
    ensure!(!has_options || has("{options}"), "`options` are given, but `submit` has no {{options}} where they belong");
    Ok(())
}

/// Submit, list and cancel of a scheduler.
fn commands(kind: QueueKind) -> [&'static [&'static str]; 3] {
    match kind {
        QueueKind::Slurm => [
            &[
                "sbatch",
                "--parsable",
                "--job-name={name}",
                "--output=/dev/null",
                "--array={tasks}",
                "{options}",
                "{script}",
            ],
            &["squeue", "--me", "--noheader", "--format=%j"],
            &["scancel", "--name={name}"],
        ],
        QueueKind::HyperQueue => [
            &[
                "hq",
                "submit",
                "--name={name}",
                "--array={tasks}",
                "--stdout=none",
                "--stderr=none",
                "{options}",
                "sh",
                "{script}",
            ],
            &["hq", "job", "list", "--output-mode=json"],
            &["hq", "job", "cancel", "{job}"],
        ],
        QueueKind::Pbs => [
            &[
                "qsub",
                "-N",
                "{name}",
                "-J",
                "{range}",
                "-S",
                "/bin/sh",
                "-o",
                "/dev/null",
                "-e",
                "/dev/null",
                "{options}",
                "{script}",
            ],
            &["qstat", "-f"],
            &["qdel", "{job}"],
        ],
        QueueKind::Lsf => [
            &["bsub", "-J", "{name}[{tasks}]", "-o", "/dev/null", "-e", "/dev/null", "{options}", "sh", "{script}"],
            // An empty queue is an error to it, with these words.
            &[
                "sh",
                "-c",
                "said=$(bjobs -noheader -o job_name 2>&1); code=$?; printf '%s\\n' \"$said\"; case $said in *'No unfinished job \
                 found'*) exit 0 ;; esac; [ $code = 0 ] || printf '%s\\n' \"$said\" >&2; exit $code",
            ],
            &["bkill", "-J", "{name}", "0"],
        ],
        QueueKind::Parallel => [
            &[
                "sh",
                "-c",
                "script=$1; first=$2; last=$3; shift 3; seq \"$first\" \"$last\" | nohup parallel \"$@\" sh \
                 \"$script\" {} > /dev/null 2>&1 & echo $!",
                "parallel",
                "{script}",
                "{first}",
                "{last}",
                "{options}",
            ],
            &["ps", "-e", "-o", "args="],
            // It takes what is under way with it.
            &["kill", "{job}"],
        ],
    }
}
