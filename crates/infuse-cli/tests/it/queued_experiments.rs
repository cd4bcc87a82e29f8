//! Experiments through a queue, by the same words as simulations: nothing lost, nothing twice, whoever is killed.
#![cfg(unix)]

use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::queues::{KEYS, LIST, SUBMIT, lines};
use crate::rig::Rig;

/// An experiment that notes that it was made, and says no more than the rig would.
const MAKE: &str = "\
echo $1 $2 $3 >> made.log
[ -e slow ] && sleep 0.1
awk \"BEGIN { print ($1 - 22) ^ 2 / 144 + ($2 - 1.9) ^ 2 + sin($3) / 10 }\"
";

/// The template, of which the experiments are a command; four a batch, at most two batches.
fn local() -> Rig {
    let rig = Rig::pooled();
    rig.write("make.sh", MAKE);
    let made = "[experiment]\ncommand = [\"sh\", \"make.sh\", \"{spring}\", \"{damper gain}\", \"{run}\"]\n[loop]";
    rig.edit("[loop]", made);
    rig.edit("experiments = 10", "experiments = 4");
    rig.edit("batches = 6", "batches = 2");
    rig
}

/// The same in a queue.
pub(crate) fn queued(keys: &str) -> Rig {
    let rig = local();
    rig.write("submit.sh", SUBMIT);
    rig.write("list.sh", LIST);
    rig.edit("[loop]", &format!("[experiment.queue]\n{keys}\n[loop]"));
    rig
}

/// Every experiment that was told was made once.
pub(crate) fn check_each_once(rig: &Rig, n: usize) {
    let mut ids: Vec<String> =
        lines(rig, "made.log").iter().filter_map(|line| Some(line.split(' ').nth(2)?.to_owned())).collect();
    ids.sort();
    let n_made = ids.len();
    ids.dedup();
    assert_eq!((n_made, ids.len()), (n, n), "{ids:?}");
    assert_eq!(rig.journal().iter().filter(|line| line["event"] == "told").count(), n);
}

/// Starts `infuse run` and ends it as soon as so many experiments were begun.
fn stopped_after(rig: &Rig, n_begun: usize, signal: &str) -> String {
    let mut child = rig.command(&["run"]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let start = Instant::now();
    while lines(rig, "made.log").len() < n_begun && start.elapsed() < Duration::from_secs(20) {
        std::thread::sleep(Duration::from_millis(5));
    }
    assert!(child.try_wait().unwrap().is_none(), "it is still at work");
    Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap();
    let said = child.wait_with_output().unwrap();
    String::from_utf8_lossy(&said.stderr).into_owned()
}

#[test]
fn a_queue_gives_the_same_campaign_as_this_machine() {
    let (here, there, per_task) = (local(), queued(KEYS), queued(&format!("{KEYS}runs_per_task = 3\n")));
    for rig in [&here, &there, &per_task] {
        let said = rig.infuse(&["run"]).ok();
        assert!(said.contains("Ended: "), "{said}");
        check_each_once(rig, 8);
    }
    assert_eq!(lines(&there, "submissions.log").len(), 2, "one submission a batch");
    for key in ["best", "bound", "best_measured"] {
        assert_eq!(here.status()[key], there.status()[key], "{key}");
        assert_eq!(here.status()[key], per_task.status()[key], "{key}");
    }
    assert!(there.infuse(&["log"]).ok().contains("4 experiments to the queue, as infuse-"));
}

#[test]
fn whoever_is_killed_nothing_is_lost_and_nothing_runs_twice() {
    for n_begun in [1, 3, 6] {
        let rig = queued(KEYS);
        rig.write("slow", "");
        stopped_after(&rig, n_begun, "-KILL");
        let text = rig.infuse(&["status"]).ok();
        assert!(text.contains("`infuse run` takes what has ended"), "{text}");
        // On a busy machine all of them may have ended by now.
        let is_begun = text.contains(" begun: ");
        assert!(!is_begun || text.contains("`infuse cancel` stops those in the queue"), "{text}");
        assert!(rig.infuse(&["run"]).ok().contains("Ended: "));
        check_each_once(&rig, 8);
    }
}

#[test]
fn an_interrupt_leaves_the_queue_at_work_and_cancel_stops_it() {
    let rig = queued(KEYS);
    rig.write("slow", "");
    let said = stopped_after(&rig, 2, "-INT");
    assert!(said.contains("what is in the queue goes on; run again to wait for it"), "{said}");
    let said = rig.infuse(&["cancel"]).ok();
    assert!(
        said.contains("Stopped: 1 submission.") && said.contains("`infuse run` submits the others again"),
        "{said}"
    );
    // The run that was under way ends by itself.
    std::thread::sleep(Duration::from_millis(400));
    rig.infuse(&["run"]).ok();
    check_each_once(&rig, 8);
}

#[test]
fn what_the_queue_loses_and_what_fails_is_told_as_failed() {
    let rig = queued(&format!("{KEYS}tries = 2\n"));
    rig.write(
        "submit.sh",
        &SUBMIT
            .replace("(for task", "(sleep 0.3; for task")
            .replace("sh $script $task;", "[ $((task % 2)) = 0 ] || sh $script $task;"),
    );
    rig.write("make.sh", "[ $3 = 1 ] && { echo 'no cable' >&2; exit 3; }\necho $1\n");
    rig.infuse(&["run", "--batches", "1"]).ok();
    let why: Vec<String> = rig.journal().iter().filter_map(|line| line["failed"].as_str().map(str::to_owned)).collect();
    assert_eq!(why.iter().filter(|why| why.contains("the queue lost it 2 times")).count(), 2, "{why:?}");
    let text = rig.infuse(&["status"]).ok();
    assert!(text.contains("of them without a result"), "{text}");
}

#[test]
fn what_was_taken_back_is_made_anew() {
    let rig = queued(KEYS);
    rig.infuse(&["run", "--batches", "1"]).ok();
    check_each_once(&rig, 4);
    // The last result is taken back, and made once more.
    assert!(rig.infuse(&["undo"]).ok().contains("1 result from infuse run"));
    rig.infuse(&["run", "--batches", "1"]).ok();
    let made = lines(&rig, "made.log");
    assert_eq!((made.len(), made.iter().filter(|line| **line == made[4]).count()), (5, 2), "{made:?}");
    // All of it, with the batch itself; another seed asks for other settings under the same ids.
    for _ in 0..5 {
        rig.infuse(&["undo"]).ok();
    }
    let ask = rig.infuse(&["undo"]).error();
    assert!(ask.contains("nothing can be taken back"), "{ask}");
    std::fs::remove_file(rig.path("sheet-1.csv")).unwrap();
    rig.infuse(&["run", "--batches", "1"]).ok();
    assert_eq!(lines(&rig, "made.log").len(), 9);
}

#[test]
fn wrong_keys_are_named_with_their_table() {
    let error = queued("kind = \"slurm\"\ntries = 0").infuse(&["run"]).error();
    assert!(error.contains("[experiment]") && error.contains("`tries` is 0, expected 1 to 100"), "{error}");
    let rig = local();
    rig.edit("command = [\"sh\", \"make.sh\"", "command = [\"sbatch\", \"make.sh\"");
    assert!(rig.infuse(&["run"]).error().contains("under [experiment.queue]"));
    assert!(local().infuse(&["cancel"]).error().contains("no [simulator.queue] and no [experiment.queue]"));
    let rig = queued(KEYS);
    rig.write("submit.sh", "echo 'no such partition' >&2; exit 1\n");
    let error = rig.infuse(&["run"]).error();
    assert!(error.contains("[experiment.queue] `submit` failed: nothing is lost, run again"), "{error}");
    // Both may be queued, and are told apart.
    let rig = crate::queues::queued(KEYS);
    rig.write("make.sh", MAKE);
    let keys = "[experiment]\ncommand = [\"sh\", \"make.sh\", \"{spring}\", \"{damper gain}\", \"{run}\"]\n[experiment.queue]\n";
    rig.edit("[loop]", &format!("{keys}{KEYS}\n[loop]"));
    rig.infuse(&["run", "--batches", "2"]).ok();
    crate::queues::check_each_once(&rig);
    check_each_once(&rig, 8);
}
