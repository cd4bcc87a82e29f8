//! The queue of `queues.rs` with a real Slurm: a controller and two nodes on this machine, no system services.
//!
//! Where Slurm is not installed, or may not be started, the tests say so and do nothing.
#![cfg(unix)]

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use tempfile::TempDir;

use crate::queued_experiments;
use crate::queues::{check_each_once, lines, queued};
use crate::rig::Rig;

/// Of the file that Slurm is configured by; D is its folder, P its first port.
const CONFIGURATION: &str = "\
ClusterName=infuse
SlurmctldHost=localhost
SlurmctldPort=P0
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket=D/munge.socket
CredType=cred/munge
StateSaveLocation=D/state
SlurmdSpoolDir=D/spool-%n
SlurmctldPidFile=D/controller.pid
SlurmdPidFile=D/%n.pid
SlurmctldLogFile=D/controller.log
SlurmdLogFile=D/%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
ReturnToService=2
MpiDefault=none
SwitchType=switch/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
MinJobAge=2
SchedulerParameters=batch_sched_delay=0,sched_min_interval=1,sched_interval=1,bf_interval=1
NodeName=n[1-2] NodeHostname=localhost NodeAddr=127.0.0.1 Port=[P1-P2] CPUs=2 State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
";

const KEYS: &str = "kind = \"slurm\"\npoll_seconds = 0.3\noptions = [\"--time=5\", \"--mem=0\"]\n";
const PATIENCE: Duration = Duration::from_secs(30);

/// One at a time: the machine is small.
static ALONE: Mutex<()> = Mutex::new(());

struct Cluster {
    folder: TempDir,
}

impl Cluster {
    /// None where there is no Slurm.
    #[expect(clippy::print_stdout, reason = "a test that was not made is said")]
    fn start() -> Option<Self> {
        let found = |program: &str| {
            let paths = std::env::var_os("PATH").unwrap_or_default();
            let places = std::env::split_paths(&paths).chain(["/usr/sbin".into(), "/usr/local/sbin".into()]);
            places.map(|place: PathBuf| place.join(program)).find(|path| path.exists())
        };
        let programs = ["munged", "slurmctld", "slurmd", "sbatch", "squeue", "scancel", "sinfo"].map(found);
        let [Some(munged), Some(controller), Some(node), Some(_), Some(_), Some(_), Some(_)] = &programs else {
            println!("not tried: Slurm and munge are not installed here");
            return None;
        };
        let cluster = Self { folder: TempDir::new().unwrap() };
        let place = cluster.folder.path();
        let port = free_ports();
        let mut text = CONFIGURATION.to_owned();
        for (word, value) in [("P0", port), ("P1", port + 1), ("P2", port + 2)] {
            text = text.replace(word, &value.to_string());
        }
        text = text
            .replace("=D/", &format!("={}/", place.display()))
            .replace("socket=D", &format!("socket={}", place.display()));
        std::fs::write(place.join("slurm.conf"), text).unwrap();
        for name in ["state", "spool-n1", "spool-n2"] {
            std::fs::create_dir(place.join(name)).unwrap();
        }
        let key = place.join("key");
        // A key of our own: nobody else is to be let in.
        let random: Vec<u8> = (0..64_u8).flat_map(|_| std::process::id().to_ne_bytes()).collect();
        std::fs::write(&key, random).unwrap();
        std::fs::set_permissions(&key, std::os::unix::fs::PermissionsExt::from_mode(0o400)).unwrap();
        let option = |name: &str, file: &str| format!("--{name}={}", place.join(file).display());
        let files = [("key-file", "key"), ("socket", "munge.socket"), ("pid-file", "munge.pid")];
        let more = [("log-file", "munge.log"), ("seed-file", "munge.seed")];
        let options = files.iter().chain(&more).map(|(name, file)| option(name, file));
        cluster.daemon(munged, options.chain(["--force".to_owned()]));
        cluster.daemon(controller, ["-f".to_owned(), cluster.configuration()]);
        for name in ["n1", "n2"] {
            cluster.daemon(node, ["-N".to_owned(), name.to_owned(), "-f".to_owned(), cluster.configuration()]);
        }
        let start = Instant::now();
        while start.elapsed() < PATIENCE {
            let said =
                Command::new("sinfo").args(["-h", "-o", "%t"]).env("SLURM_CONF", cluster.configuration()).output();
            if said.is_ok_and(|said| String::from_utf8_lossy(&said.stdout).trim() == "idle") {
                return Some(cluster);
            }
            std::thread::sleep(Duration::from_millis(100));
        }
        println!("not tried: Slurm is installed, and does not start here");
        None
    }

    fn configuration(&self) -> String {
        self.folder.path().join("slurm.conf").display().to_string()
    }

    /// They put themselves into the background.
    fn daemon(&self, program: &Path, options: impl IntoIterator<Item = String>) {
        let mut command = Command::new(program);
        command.args(options).env("SLURM_CONF", self.configuration());
        let _ = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).status();
    }

    fn infuse(&self, rig: &Rig, arguments: &[&str]) -> Command {
        let mut command = rig.command(arguments);
        command.env("SLURM_CONF", self.configuration()).stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    #[track_caller]
    fn ask(&self, rig: &Rig) {
        let said = self.infuse(rig, &["ask"]).output().unwrap();
        let text = String::from_utf8_lossy(&said.stdout).into_owned() + &String::from_utf8_lossy(&said.stderr);
        assert!(said.status.success() && text.contains("Batch 1: 4 experiments"), "{text}");
    }
}

impl Drop for Cluster {
    fn drop(&mut self) {
        for name in ["n1.pid", "n2.pid", "controller.pid", "munge.pid"] {
            if let Ok(number) = std::fs::read_to_string(self.folder.path().join(name)) {
                let _ = Command::new("kill").args(["-TERM", number.trim()]).status();
            }
        }
        std::thread::sleep(Duration::from_millis(500));
    }
}

/// Three in a row that nobody listens to.
fn free_ports() -> u16 {
    let is_free = |port: &u16| (0..3).all(|more| std::net::TcpListener::bind(("127.0.0.1", port + more)).is_ok());
    let first = 20_000 + (std::process::id() % 10_000) as u16;
    (first..).step_by(3).find(is_free).unwrap()
}

#[test]
fn a_batch_runs_on_a_cluster_whoever_is_killed() {
    let _alone = ALONE.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    let Some(cluster) = Cluster::start() else { return };
    // A batch.
    let rig = queued(KEYS);
    cluster.ask(&rig);
    check_each_once(&rig);
    // The tool is killed, and called again.
    let rig = queued(KEYS);
    rig.write("slow", "");
    let mut child = cluster.infuse(&rig, &["ask"]).spawn().unwrap();
    let start = Instant::now();
    while lines(&rig, "ran.log").len() < 2 && start.elapsed() < PATIENCE {
        std::thread::sleep(Duration::from_millis(10));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    cluster.ask(&rig);
    check_each_once(&rig);
    // The whole submission is cancelled; what was not run is submitted again.
    let rig = queued(KEYS);
    rig.write("simulate.sh", &format!("[ -e slow ] && exec sleep 30\n{}", rig.read("simulate.sh")));
    rig.write("slow", "");
    let mut child = cluster.infuse(&rig, &["ask"]).spawn().unwrap();
    let start = Instant::now();
    while !rig.journal().iter().any(|line| line["event"] == "submitted") && start.elapsed() < PATIENCE {
        std::thread::sleep(Duration::from_millis(10));
    }
    std::thread::sleep(Duration::from_secs(1));
    child.kill().unwrap();
    child.wait().unwrap();
    let said = cluster.infuse(&rig, &["cancel"]).output().unwrap();
    let text = String::from_utf8_lossy(&said.stdout).into_owned();
    assert!(text.contains("Stopped: 1 submission"), "{text}");
    std::fs::remove_file(rig.path("slow")).unwrap();
    cluster.ask(&rig);
    check_each_once(&rig);
    // A failing and a hanging simulation.
    let rig = queued(KEYS);
    rig.edit("[simulator.queue]", "timeout_seconds = 1\n[simulator.queue]");
    rig.write(
        "simulate.sh",
        "echo $1 $2 >> ran.log\n[ $1 -gt 30 ] && exit 3\n[ $1 -lt 20 ] && exec sleep 60\necho 5\n",
    );
    cluster.ask(&rig);
    let reasons: Vec<String> =
        rig.journal().iter().filter_map(|line| line["failed"].as_str().map(str::to_owned)).collect();
    assert!(reasons.iter().any(|why| why == "exit status: 3"), "{reasons:?}");
    assert!(reasons.iter().any(|why| why.contains("see `timeout_seconds`")), "{reasons:?}");
}

#[test]
fn experiments_run_on_a_cluster_whoever_is_killed() {
    let _alone = ALONE.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    let Some(cluster) = Cluster::start() else { return };
    let rig = queued_experiments::queued(KEYS);
    rig.write("slow", "");
    let mut child = cluster.infuse(&rig, &["run"]).spawn().unwrap();
    let start = Instant::now();
    while lines(&rig, "made.log").len() < 2 && start.elapsed() < PATIENCE {
        std::thread::sleep(Duration::from_millis(10));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let said = cluster.infuse(&rig, &["run"]).output().unwrap();
    let text = String::from_utf8_lossy(&said.stdout).into_owned() + &String::from_utf8_lossy(&said.stderr);
    assert!(said.status.success() && text.contains("Ended: "), "{text}");
    queued_experiments::check_each_once(&rig, 8);
}
