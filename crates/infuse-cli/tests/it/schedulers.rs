//! The commands that `kind` fills in, with GNU parallel where it is installed, and with stand-ins for PBS and LSF that take the
//! options and print the words of the manuals of OpenPBS and LSF.
#![cfg(unix)]

use std::os::unix::fs::PermissionsExt as _;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::queues::{check_each_once, lines, local};
use crate::rig::{Rig, Said};

/// An array job is one job of PBS, `123[].server`; what has ended is not listed.
const QSUB: &str = r#"#!/bin/sh
echo "$@" >> submissions.log
while [ $# -gt 1 ]; do
    case $1 in
    -N) name=$2 ;;
    -J) first=${2%-*} last=${2#*-} ;;
    -S | -o | -e) ;;
    *) echo "qsub: illegal option $1" >&2; exit 2 ;;
    esac
    shift 2
done
[ "$first" -lt "$last" ] || { echo 'qsub: illegal -J value' >&2; exit 2; }
mkdir -p jobs
n=$(($(ls jobs | wc -l) + $(wc -l < submissions.log) + 122))
echo "$name" > "jobs/$n"
script=$1
(for k in $(seq "$first" "$last"); do [ -e "jobs/$n" ] && PBS_ARRAY_INDEX=$k sh "$script"; done; rm -f "jobs/$n") > /dev/null 2>&1 &
echo "$n[].server"
"#;
const QSTAT: &str = r#"#!/bin/sh
mkdir -p jobs
for n in $(ls jobs); do
    printf 'Job Id: %s[].server\n    Job_Name = %s\n    Job_Owner = me@login\n    job_state = B\n    queue = workq\n    array = True\n' \
        "$n" "$(cat "jobs/$n")"
done
"#;
const QDEL: &str = r#"#!/bin/sh
case $1 in
*'[].server') rm -f "jobs/${1%??.server}" ;;
*) echo "qdel: illegally formed job identifier: $1" >&2; exit 2 ;;
esac
"#;

/// The elements of an array are listed one by one, `name[3]`; an empty queue is an error.
const BSUB: &str = r#"#!/bin/sh
echo "$@" >> submissions.log
[ "$1" = -J ] || exit 2
name=${2%%[[]*} tasks=${2#*[[]} tasks=${tasks%]}
shift 2
while [ "$1" = -o ] || [ "$1" = -e ]; do shift 2; done
mkdir -p jobs
all=$(for range in $(echo "$tasks" | tr , ' '); do seq "${range%-*}" "${range#*-}"; done)
for k in $all; do touch "jobs/$name[$k]"; done
(for k in $all; do [ -e "jobs/$name[$k]" ] && LSB_JOBINDEX=$k "$@"; rm -f "jobs/$name[$k]"; done) > /dev/null 2>&1 &
echo "Job <$(($(wc -l < submissions.log) + 122))> is submitted to queue <normal>."
"#;
const BJOBS: &str = r#"#!/bin/sh
[ "$*" = '-noheader -o job_name' ] || exit 2
[ -e down ] && { echo 'LSF is down. Please wait ...' >&2; exit 255; }
mkdir -p jobs
[ -n "$(ls jobs)" ] || { echo 'No unfinished job found' >&2; exit 255; }
ls jobs
"#;
const BKILL: &str = r#"#!/bin/sh
[ "$1" = -J ] && [ "$3" = 0 ] || exit 2
# A name that nobody knows is an error.
ls jobs | grep -qF "$2[" || { echo "Job <$2> is not found" >&2; exit 255; }
rm -f jobs/"$2"[[]*
"#;

/// Programs of a scheduler, found first.
struct Scheduler {
    rig: Rig,
}

impl Scheduler {
    fn new(kind: &str, programs: &[(&str, &str)]) -> Self {
        let rig = local();
        rig.edit("[loop]", &format!("[simulator.queue]\nkind = \"{kind}\"\npoll_seconds = 0.05\n[loop]"));
        std::fs::create_dir(rig.path("bin")).unwrap();
        for (name, script) in programs {
            let path = rig.path("bin").join(name);
            std::fs::write(&path, script).unwrap();
            std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
        }
        Self { rig }
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = self.rig.command(arguments);
        let path = std::env::var("PATH").unwrap_or_default();
        command.env("PATH", format!("{}:{path}", self.rig.path("bin").display()));
        command
    }

    fn infuse(&self, arguments: &[&str]) -> Said {
        self.command(arguments).output().unwrap().into()
    }

    /// A batch, of which the first call is killed, and another is cancelled.
    fn check(&self) {
        self.rig.write("slow", "");
        for (n, signal) in [(2, "-KILL"), (4, "-INT")] {
            let mut child = self.command(&["ask"]).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
            let start = Instant::now();
            while lines(&self.rig, "ran.log").len() < n && start.elapsed() < Duration::from_secs(20) {
                std::thread::sleep(Duration::from_millis(5));
            }
            Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap();
            child.wait().unwrap();
        }
        let said = self.infuse(&["cancel"]).ok();
        assert!(said.contains("Stopped: 1 submission."), "{said}");
        // What was under way ends, here by itself.
        std::thread::sleep(Duration::from_millis(500));
        assert!(self.infuse(&["cancel"]).ok().contains("Nothing of this campaign is in the queue"));
        let said = self.infuse(&["ask"]).ok();
        assert!(said.contains("Batch 1: 4 experiments"), "{said}");
        assert!(!self.rig.journal().iter().any(|line| line.get("failed").is_some()));
    }
}

#[test]
fn pbs_takes_what_its_kind_says() {
    let pbs = Scheduler::new("pbs", &[("qsub", QSUB), ("qstat", QSTAT), ("qdel", QDEL)]);
    pbs.check();
    check_each_once(&pbs.rig);
    let first = &lines(&pbs.rig, "submissions.log")[0];
    assert!(first.contains(" -J 1-9 -S /bin/sh -o /dev/null -e /dev/null /"), "{first}");
}

/// Between the list and the order to stop a job may end; one that cannot be stopped is another matter.
#[test]
fn what_ends_before_it_is_stopped_is_no_error() {
    let gone = "echo \"qdel: Unknown Job Id $1\" >&2; exit 153\n";
    let refusing = format!("#!/bin/sh\n{gone}");
    let late = format!("#!/bin/sh\nrm -f jobs/*; {gone}");
    for (qdel, is_gone) in [(&refusing, false), (&late, true)] {
        let pbs = Scheduler::new("pbs", &[("qsub", QSUB), ("qstat", QSTAT), ("qdel", qdel)]);
        pbs.rig.write("slow", "");
        let mut child = pbs.command(&["ask"]).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        let start = Instant::now();
        while lines(&pbs.rig, "ran.log").is_empty() && start.elapsed() < Duration::from_secs(20) {
            std::thread::sleep(Duration::from_millis(5));
        }
        child.kill().unwrap();
        child.wait().unwrap();
        let said = pbs.infuse(&["cancel"]);
        if is_gone {
            let said = said.ok();
            assert!(said.contains("Nothing of this campaign is in the queue"), "{said}");
        } else {
            let error = said.error();
            assert!(error.contains("qdel: Unknown Job Id 12"), "{error}");
        }
    }
}

#[test]
fn lsf_takes_what_its_kind_says_and_its_empty_queue_is_no_error() {
    let lsf = Scheduler::new("lsf", &[("bsub", BSUB), ("bjobs", BJOBS), ("bkill", BKILL)]);
    lsf.check();
    check_each_once(&lsf.rig);
    let first = &lines(&lsf.rig, "submissions.log")[0];
    assert!(first.contains("[1-9] -o /dev/null -e /dev/null sh /"), "{first}");
    // Any other error means that nobody knows.
    lsf.rig.write("down", "");
    let error = lsf.infuse(&["cancel"]).error();
    assert!(error.contains("LSF is down. Please wait"), "{error}");
}

#[test]
#[expect(clippy::print_stdout, reason = "a test that was not made is said")]
fn gnu_parallel_takes_what_its_kind_says() {
    if !Command::new("parallel").arg("--version").output().is_ok_and(|said| said.stdout.starts_with(b"GNU parallel")) {
        println!("not tried: GNU parallel is not installed");
        return;
    }
    let parallel = Scheduler::new("parallel", &[]);
    parallel.rig.edit("[loop]", "options = [\"--jobs=2\"]\n[loop]");
    parallel.check();
    // A run that was under way when the others were stopped is made again: no more than two were.
    let simulated = parallel.rig.journal().iter().filter(|line| line["event"] == "simulated").count();
    let n = lines(&parallel.rig, "ran.log").len();
    assert!((simulated..=simulated + 2).contains(&n), "{n} for {simulated}");
}
