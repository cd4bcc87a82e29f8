//! Simulations through a queue: nothing lost, nothing twice, whoever is killed.
//!
//! The scheduler here is a shell loop; `slurm.rs` does the same with a real one.
#![cfg(unix)]

use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::rig::Rig;

/// Takes a submission, and runs its tasks in the background; what is in `jobs` is in the queue.
pub(crate) const SUBMIT: &str = "\
name=$1 script=$2 first=$3 last=$4
mkdir -p jobs
touch jobs/$name
echo $name >> submissions.log
(for task in $(seq $first $last); do [ -e jobs/$name ] && sh $script $task; done; rm -f jobs/$name) > /dev/null 2>&1 &
echo job $name
";

/// Prints what is in the queue.
pub(crate) const LIST: &str = "mkdir -p jobs; ls jobs\n";

/// A simulation that notes that it was run.
const SIMULATE: &str = "\
echo $1 $2 >> ran.log
[ -e slow ] && sleep 0.1
awk \"BEGIN { print ($1 - 30) ^ 2 / 100 + ($2 - 2) ^ 2 }\"
";

pub(crate) const KEYS: &str = "submit = [\"sh\", \"submit.sh\", \"{name}\", \"{script}\", \"{first}\", \"{last}\", \"{options}\"]\n\
                    list = [\"sh\", \"list.sh\"]\ncancel = [\"rm\", \"jobs/{name}\"]\npoll_seconds = 0.05\n";

/// The template with five dear simulations a batch of four experiments, in a queue.
pub(crate) fn queued(keys: &str) -> Rig {
    let rig = local();
    rig.write("submit.sh", SUBMIT);
    rig.write("list.sh", LIST);
    rig.edit("[loop]", &format!("[simulator.queue]\n{keys}\n[loop]"));
    rig
}

/// The same, run here.
pub(crate) fn local() -> Rig {
    let rig = Rig::pooled();
    rig.write("simulate.sh", SIMULATE);
    let command = "command = [\"sh\", \"simulate.sh\", \"{spring}\", \"{damper gain}\"]";
    rig.edit("table = \"simulation.csv\"", command);
    rig.edit("experiments = 10", "experiments = 4\nsimulations = 9");
    rig
}

pub(crate) fn lines(rig: &Rig, name: &str) -> Vec<String> {
    let text = std::fs::read_to_string(rig.path(name)).unwrap_or_default();
    text.lines().map(str::to_owned).collect()
}

/// Every simulation was run once.
pub(crate) fn check_each_once(rig: &Rig) {
    let ran = lines(rig, "ran.log");
    let different: std::collections::BTreeSet<&String> = ran.iter().collect();
    assert_eq!(ran.len(), different.len(), "{ran:?}");
    let simulated = rig.journal().iter().filter(|line| line["event"] == "simulated").count();
    assert_eq!(ran.len(), simulated, "{ran:?}");
}

#[test]
fn a_queue_gives_the_same_campaign_as_this_machine() {
    let (here, there) = (local(), queued(KEYS));
    for rig in [&here, &there] {
        assert!(rig.batch() && rig.batch());
        check_each_once(rig);
    }
    assert_eq!(here.status()["best"], there.status()["best"]);
    assert_eq!(here.status()["bound"], there.status()["bound"]);
    // Some before the first batch, and some with each.
    assert!(lines(&there, "submissions.log").len() >= 2);
    let per_task = queued(&format!("{KEYS}runs_per_task = 4\n"));
    assert!(per_task.batch() && per_task.batch());
    check_each_once(&per_task);
    assert_eq!(here.status()["bound"], per_task.status()["bound"]);
}

/// Starts `infuse ask` and ends it as soon as so many simulations were begun.
fn stopped_after(rig: &Rig, n_begun: usize, signal: &str) -> String {
    let mut child = rig.command(&["ask"]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let start = Instant::now();
    while lines(rig, "ran.log").len() < n_begun && start.elapsed() < Duration::from_secs(20) {
        std::thread::sleep(Duration::from_millis(5));
    }
    assert!(child.try_wait().unwrap().is_none(), "it is still at work");
    Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap();
    let said = child.wait_with_output().unwrap();
    String::from_utf8_lossy(&said.stderr).into_owned()
}

#[test]
fn whoever_is_killed_nothing_is_lost_and_nothing_runs_twice() {
    for n_begun in [1, 3, 6] {
        let rig = queued(KEYS);
        rig.write("slow", "");
        stopped_after(&rig, n_begun, "-KILL");
        let text = rig.infuse(&["status"]).ok();
        assert!(text.contains(" in the queue or to be queued, "), "{text}");
        assert!(text.contains(" begun: `infuse ask` takes what has ended"), "{text}");
        let asked = rig.infuse(&["ask"]).ok();
        assert!(asked.contains("Batch 1: 4 experiments"), "{asked}");
        check_each_once(&rig);
    }
}

#[test]
fn an_interrupt_leaves_the_queue_at_work_and_says_so() {
    let rig = queued(KEYS);
    rig.write("slow", "");
    let said = stopped_after(&rig, 2, "-INT");
    assert!(said.contains("what is in the queue goes on") && said.contains("`infuse cancel`"), "{said}");
    rig.infuse(&["ask"]).ok();
    check_each_once(&rig);
}

#[test]
fn what_is_cancelled_is_submitted_again_without_what_had_ended() {
    let rig = queued(KEYS);
    rig.write("slow", "");
    stopped_after(&rig, 3, "-KILL");
    let said = rig.infuse(&["cancel"]).ok();
    assert!(said.contains("Stopped: 1 submission. What was finished counts"), "{said}");
    assert!(rig.infuse(&["cancel"]).ok().contains("Nothing of this campaign is in the queue"));
    // The run that was under way ends by itself.
    std::thread::sleep(Duration::from_millis(400));
    let n_before = lines(&rig, "submissions.log").len();
    let text = rig.infuse(&["status"]).ok();
    assert!(text.contains(" stopped by `infuse cancel`: `infuse ask` takes what has ended"), "{text}");
    assert!(!text.contains("stops those in the queue"), "nothing is left to stop: {text}");
    let (known, findings) = (rig.journal(), rig.status()["findings"].clone());
    let n_of = |label: &str| {
        let values =
            findings.as_array().unwrap().iter().flat_map(|one| one["numbers"].as_array().cloned().unwrap_or_default());
        values.into_iter().find(|value| value["name"] == label).unwrap()["value"].as_f64().unwrap() as u64
    };
    let n_taken = known.iter().filter(|line| line["event"] == "simulated").count() as u64;
    let n_run = lines(&rig, "ran.log").len() as u64;
    assert_eq!(n_of("simulations ended"), n_run - n_taken, "what has run and is not in the journal");
    assert_eq!(n_of("simulations stopped") + n_of("simulations ended"), n_of("simulations waited for"));
    rig.infuse(&["ask"]).ok();
    assert!(lines(&rig, "submissions.log").len() > n_before);
    check_each_once(&rig);
}

/// A scheduler ends the processes of a task one after the other, here the run well before the shell that waits for it.
#[test]
fn a_run_that_is_stopped_with_its_task_has_not_failed_and_one_that_ends_alone_has() {
    for signal in ["TERM", "KILL"] {
        let rig = queued(&KEYS.replace("\"rm\", \"jobs/{name}\"", "\"sh\", \"stop.sh\", \"{name}\""));
        rig.write("simulate.sh", &format!("[ -e slow ] && {{ echo $$ > run.pid; exec sleep 30; }}\n{SIMULATE}"));
        rig.write("slow", "");
        rig.write(
            "submit.sh",
            &SUBMIT.replace("sh $script $task;", "{ sh $script $task & echo $! > job.pid; wait; };"),
        );
        rig.write(
            "stop.sh",
            &format!("rm jobs/$1\nkill -{signal} $(cat run.pid)\nsleep 0.3\nkill -{signal} $(cat job.pid)\n"),
        );
        let mut child = rig.command(&["ask"]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let start = Instant::now();
        while lines(&rig, "run.pid").is_empty() && start.elapsed() < Duration::from_secs(20) {
            std::thread::sleep(Duration::from_millis(5));
        }
        child.kill().unwrap();
        child.wait().unwrap();
        let said = rig.infuse(&["cancel"]).ok();
        assert!(said.contains("Stopped: 1 submission"), "{said}");
        std::fs::remove_file(rig.path("slow")).unwrap();
        rig.infuse(&["ask"]).ok();
        check_each_once(&rig);
        assert!(rig.journal().iter().all(|line| line.get("failed").is_none()), "{signal}: nothing has failed");
    }
    // Out of memory, say.
    let rig = queued(KEYS);
    rig.write("simulate.sh", &format!("{SIMULATE}[ -e once ] || {{ touch once; kill -9 $$; }}\n"));
    rig.infuse(&["ask"]).ok();
    check_each_once(&rig);
    assert_eq!(rig.journal().iter().filter(|line| line.get("failed").is_some()).count(), 1);
}

#[test]
fn a_list_that_cannot_be_had_means_that_nobody_knows() {
    let rig = queued(KEYS);
    rig.write("slow", "");
    // The controller is down for the first looks.
    rig.write(
        "list.sh",
        "echo x >> looks\n[ $(wc -l < looks) -gt 12 ] || { echo 'controller down' >&2; exit 1; }\nls jobs\n",
    );
    rig.infuse(&["ask"]).ok();
    check_each_once(&rig);
    assert!(lines(&rig, "looks").len() > 12);
    let names = lines(&rig, "submissions.log");
    assert!(names.iter().all(|name| name.ends_with("-1")), "no second try: {names:?}");
}

#[test]
fn a_submission_that_is_refused_is_made_again_and_counts_as_no_try() {
    let rig = queued(&format!("{KEYS}tries = 1\n"));
    let working = rig.read("submit.sh");
    rig.write("submit.sh", "echo 'sbatch: error: no partition' >&2; exit 1\n");
    for _ in 0..3 {
        let error = rig.infuse(&["ask"]).error();
        assert!(
            error.contains("`submit` failed: nothing is lost, ask again") && error.contains("no partition"),
            "{error}"
        );
    }
    rig.write("submit.sh", &working);
    rig.infuse(&["ask"]).ok();
    check_each_once(&rig);
    assert_eq!(rig.journal().iter().filter(|line| line.get("failed").is_some()).count(), 0);
}

#[test]
fn what_the_queue_loses_is_submitted_again_and_in_the_end_has_failed() {
    // Long enough in the list to be seen there.
    let lossy = SUBMIT
        .replace("(for task", "(sleep 0.3; for task")
        .replace("sh $script $task;", "[ $((task % 2)) = 0 ] || case $name in LOST) ;; *) sh $script $task ;; esac;");
    let rig = queued(&format!("{KEYS}tries = 2\n"));
    rig.write("submit.sh", &lossy.replace("LOST", "*-1"));
    rig.write("submit.sh", &rig.read("submit.sh").replace("[ $((task % 2)) = 0 ] ||", "true &&"));
    rig.infuse(&["ask"]).ok();
    check_each_once(&rig);
    let names = lines(&rig, "submissions.log");
    assert!(names.iter().any(|name| name.ends_with("-2")), "{names:?}");
    // Even tasks are lost every time.
    let rig = queued(&format!("{KEYS}tries = 2\n"));
    rig.write("submit.sh", &lossy.replace("LOST", "never"));
    rig.infuse(&["ask"]).ok();
    let lost = rig
        .journal()
        .iter()
        .filter(|line| line["failed"].as_str().is_some_and(|why| why.contains("the queue lost it 2 times")))
        .count();
    assert!(lost >= 3, "{lost}");
}

#[test]
fn a_job_that_dies_after_some_runs_is_tried_as_long_as_it_gives_results() {
    let rig = queued(&format!("{KEYS}tries = 2\nruns_per_task = 9\n"));
    rig.edit("simulations = 9", "simulations = \"all\"");
    rig.edit("step = 2", "levels = 3");
    rig.edit("step = 0.2", "levels = 3");
    // Every third run ends the job that it belongs to, and gives nothing.
    let dies = "echo x >> count\n[ $(($(wc -l < count) % 3)) = 0 ] && kill -9 $(cat job.pid) && exit 1\n";
    rig.write("simulate.sh", &format!("{dies}{SIMULATE}"));
    let submit = SUBMIT
        .replace("(for task", "(sleep 0.3; for task")
        .replace("sh $script $task;", "{ sh $script $task & echo $! > job.pid; wait; };");
    rig.write("submit.sh", &submit);
    rig.infuse(&["ask"]).ok();
    let journal = rig.journal();
    assert!(journal.iter().all(|line| line.get("failed").is_none()), "nothing has failed");
    assert!(lines(&rig, "submissions.log").len() > 2, "more than `tries` submissions");
    // The log says what each submission was to run.
    let log = rig.infuse(&["log"]).ok();
    let counts: Vec<usize> = log
        .lines()
        .filter_map(|line| line.split_once("submitted")?.1.split_whitespace().next()?.parse().ok())
        .collect();
    assert!(counts[0] == 9 && counts.windows(2).all(|pair| pair[1] < pair[0]), "{log}");
}

#[test]
fn a_list_that_never_shows_a_name_has_nothing_submitted_again() {
    // `squeue --me` cuts names to eight characters.
    for list in ["ls jobs | cut -c1-8\n", "true\n"] {
        let rig = queued(KEYS);
        rig.write("slow", "");
        // Each task takes longer than the patience of the call.
        rig.write("simulate.sh", &rig.read("simulate.sh").replace("sleep 0.1", "sleep 0.8"));
        rig.write("list.sh", list);
        let error = rig.infuse(&["ask"]).error();
        assert!(error.contains("`list` has not shown it once") && error.contains("whole names"), "{error}");
        assert!(
            error.contains(if list.contains("cut") { "It printed `infuse-" } else { "It printed nothing" }),
            "{error}"
        );
        assert_eq!(lines(&rig, "submissions.log").len(), 1, "submitted once");
        assert!(rig.journal().iter().all(|line| line.get("failed").is_none()), "nothing has failed");
        rig.write("list.sh", LIST);
        rig.infuse(&["ask"]).ok();
        check_each_once(&rig);
        assert!(lines(&rig, "submissions.log").iter().all(|name| name.ends_with("-1")), "each once");
    }
    // What it has truly lost is submitted again if somebody says so.
    let rig = queued(KEYS);
    rig.write("submit.sh", "echo $1 >> submissions.log; echo job $1\n");
    let error = rig.infuse(&["ask"]).error();
    let taken = error.split_once("remove ").and_then(|(_, rest)| rest.split_once(" and call again")).unwrap().0;
    std::fs::remove_file(taken).unwrap();
    rig.write("submit.sh", SUBMIT);
    rig.infuse(&["ask"]).ok();
    check_each_once(&rig);
    assert!(lines(&rig, "submissions.log").iter().any(|name| name.ends_with("-2")), "once more");
}

#[test]
fn failing_and_hanging_runs_are_failures_with_their_reason() {
    let rig = queued(KEYS);
    let failing = "echo $1 $2 >> ran.log\n[ $1 -gt 30 ] && { echo 'no license' >&2; exit 3; }\n[ $1 -lt 20 ] && exec sleep 60\necho 5\n";
    rig.write("simulate.sh", failing);
    rig.edit("[simulator.queue]", "timeout_seconds = 0.3\n[simulator.queue]");
    rig.infuse(&["ask"]).ok();
    let reasons: Vec<String> =
        rig.journal().iter().filter_map(|line| line["failed"].as_str().map(str::to_owned)).collect();
    assert!(reasons.iter().any(|why| why == "exit status: 3: no license"), "{reasons:?}");
    assert!(reasons.iter().any(|why| why.contains("see `timeout_seconds`")), "{reasons:?}");
    check_each_once(&rig);
}

#[test]
fn what_is_to_be_simulated_again_is_not_read_from_old_runs() {
    let rig = queued(KEYS);
    rig.batch();
    let n = lines(&rig, "ran.log").len();
    rig.infuse(&["ask", "--resimulate"]).ok();
    assert!(lines(&rig, "ran.log").len() > n + 8, "all of them are run anew");
}

/// A wrapper hides the scheduler, but not what it prints.
#[test]
fn numbers_of_jobs_never_become_values() {
    let rig = local();
    rig.write("simulate.sh", "n=$(cat job 2>/dev/null || echo 4711); n=$((n + 1)); echo $n > job; echo $n\n");
    rig.edit("command = [\"sh\", \"simulate.sh\"", "jobs = 1\ncommand = [\"sh\", \"simulate.sh\"");
    let error = rig.infuse(&["ask"]).error();
    assert!(
        error.contains("4712, 4713, 4714, 4715, 4716") && error.contains("numbers of jobs and no values"),
        "{error}"
    );
    let journal = std::fs::read_to_string(rig.path("journal.jsonl")).unwrap_or_default();
    assert!(!journal.contains("simulated"), "none was taken: {journal}");
    // Whole responses that are told from numbers of jobs by how they are printed.
    rig.write("simulate.sh", "n=$(cat job); n=$((n + 1)); echo $n > job; echo \"{\\\"value\\\": $n}\"\n");
    rig.infuse(&["ask"]).ok();
}

#[test]
fn a_scheduler_as_the_simulator_is_refused_and_so_is_every_wrong_key() {
    for command in [
        "\"env\", \"sbatch\", \"--parsable\"",
        "\"sh\", \"-c\", \"sbatch x.sh\"",
        "\"sbatch\", \"--wait\", \"--parsable\", \"x.sh\"",
        "\"/opt/hq\", \"submit\", \"--wait\"",
        "\"qsub\", \"x\"",
    ] {
        let rig = local();
        rig.edit("command = [\"sh\", \"simulate.sh\"", &format!("command = [{command}"));
        let error = rig.infuse(&["ask"]).error();
        assert!(
            error.contains("which prints the number of a job and no value") && error.contains("[simulator.queue]"),
            "{error}"
        );
    }
    let wrong = [
        ("", "needs `submit`"),
        ("kind = \"slurmy\"", "slurmy"),
        ("kind = \"slurm\"\nsubmit = [\"sbatch\", \"{tasks}\"]", "no {script}"),
        ("kind = \"slurm\"\nsubmit = [\"sbatch\", \"{script}\", \"{name}\"]", "which tasks to run"),
        ("submit = [\"a\", \"{script}\", \"{tasks}\", \"{name}\"]\nlist = [\"b\"]\noptions = [\"-x\"]", "no {options}"),
        ("kind = \"slurm\"\npoll_seconds = 0", "`poll_seconds` is 0.0, expected a positive number"),
        ("kind = \"slurm\"\ntries = 0", "`tries` is 0, expected 1 to 100"),
        ("kind = \"slurm\"\nruns_per_task = 0", "`runs_per_task` is 0"),
        ("kind = \"slurm\"\npoll = 3", "unknown field `poll`"),
    ];
    for (keys, said) in wrong {
        let error = queued(keys).infuse(&["ask"]).error();
        assert!(error.contains(said), "{keys}: {error}");
    }
    let rig = queued(KEYS);
    rig.edit("[simulator.queue]", "jobs = 2\n[simulator.queue]");
    assert!(rig.infuse(&["ask"]).error().contains("`jobs` is for runs on this machine"));
    let table = Rig::pooled();
    table.edit("[loop]", "[simulator.queue]\nkind = \"slurm\"\n[loop]");
    assert!(table.infuse(&["ask"]).error().contains("a `table` is not run"));
    assert!(local().infuse(&["cancel"]).error().contains("no [simulator.queue]"));
}
