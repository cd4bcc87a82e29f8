//! Kills and interrupts at any moment.

use std::collections::BTreeMap;
use std::process::Stdio;
use std::time::Duration;

use rand::{RngExt as _, SeedableRng as _};
use rand_pcg::Pcg64;

use crate::kills::n_kills;
use crate::rig::{Rig, measured, told, truth};

/// The template with a simulator and an experiment that are commands, and this seed.
fn rig(seed: u64) -> Rig {
    let rig = Rig::new();
    let simulator = format!("command = [\"sh\", \"-c\", \"{}\"]\njobs = 2", crate::campaigns::SHELL_SIMULATION);
    rig.edit("table = \"simulation.csv\"", &simulator);
    rig.edit("seed = 1", &format!("seed = {seed}"));
    rig
}

/// The three ways of writing to a campaign, killed again and again at any moment: what a call has confirmed is never
/// lost, what the next calls say is what an undisturbed campaign says.
#[test]
fn kills_lose_nothing_that_was_confirmed() {
    let kills = n_kills(250);
    let mut random = Pcg64::seed_from_u64(7);
    let (mut n_kills, mut n_calls, mut n_campaigns) = (0, 0, 0);
    // The killed calls are those that were still running; how long a call runs is found on the way.
    let mut patience = Duration::from_millis(60);
    while n_kills < kills {
        n_campaigns += 1;
        let rig = rig(n_campaigns);
        let mut confirmed: BTreeMap<u64, f64> = BTreeMap::new();
        let mut n_here = 0;
        while n_kills < kills && n_here < 4000 {
            n_here += 1;
            let sheet = (1..=2).rev().map(|batch| format!("sheet-{batch}.csv")).find(|name| rig.path(name).exists());
            let tells = sheet.filter(|_| random.random::<f64>() < 0.6);
            let arguments: Vec<&str> = match &tells {
                Some(sheet) => {
                    // A few more rows each time, as a person would.
                    rig.fill(sheet, |id| (id * 7 + n_here).is_multiple_of(5) || confirmed.contains_key(&id));
                    vec!["tell", sheet]
                }
                None => vec!["ask", "--anyway"],
            };
            let mut child = rig.command(&arguments).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
            n_calls += 1;
            std::thread::sleep(patience.mul_f64(random.random::<f64>()));
            let ended = child.try_wait().unwrap();
            if ended.is_none() {
                child.kill().unwrap();
                n_kills += 1;
            }
            let output = child.wait_with_output().unwrap();
            if let Some(status) = ended {
                assert!(status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
                patience = patience.mul_f64(0.98).max(Duration::from_millis(2));
                if tells.is_some() {
                    confirmed = told(&rig.journal());
                }
            } else {
                patience = patience.mul_f64(1.02).min(Duration::from_millis(400));
            }
            let journal = told(&rig.journal());
            for (id, value) in &confirmed {
                assert_eq!(journal.get(id), Some(value), "experiment {id} was confirmed");
            }
            if rig.journal().iter().any(|line| line["event"] == "opened" && line["batch"] == 3) {
                break;
            }
        }
        finish_and_compare(&rig, n_campaigns);
    }
    assert!(n_calls > kills, "some calls came to their end");
}

/// Brings two batches to their end and compares with a campaign that nobody disturbed.
fn finish_and_compare(rig: &Rig, seed: u64) {
    let reference = self::rig(seed);
    for rig in [rig, &reference] {
        for sheet in ["sheet-1.csv", "sheet-2.csv"] {
            rig.infuse(&["ask", "--anyway"]).ok();
            rig.fill(sheet, |_| true);
            rig.infuse(&["tell", sheet]).ok();
        }
        rig.infuse(&["ask", "--anyway"]).ok();
    }
    assert_eq!(rig.status(), reference.status());
    assert_eq!(rig.read("sheet-3.csv"), reference.read("sheet-3.csv"));
}

#[cfg(unix)]
#[test]
fn an_interrupt_from_the_keyboard_stops_simulations_and_remembers_those_that_were_done() {
    let rig = Rig::new();
    let script = "echo $$ >> started; if [ -e quick ] || [ $(wc -l < started) -lt 3 ]; then echo {spring} {damper gain} | cut -d' ' -f1; else sleep 100; fi";
    rig.edit("table = \"simulation.csv\"", &format!("command = [\"sh\", \"-c\", '''{script}''']\njobs = 1"));
    let mut asking = rig.command(&["ask"]).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    // Two are remembered and the third, which sleeps, has begun.
    let begun = || std::fs::read_to_string(rig.path("started")).unwrap_or_default().lines().count();
    while begun() < 3 || rig.journal().iter().filter(|line| line["event"] == "simulated").count() < 2 {
        std::thread::sleep(Duration::from_millis(5));
    }
    std::process::Command::new("kill").args(["-INT", &asking.id().to_string()]).status().unwrap();
    let status = asking.wait().unwrap();
    assert_eq!(status.code(), Some(130));
    let said = std::io::read_to_string(asking.stderr.take().unwrap()).unwrap();
    assert!(said.contains("interrupted: 2 of 20 simulations are remembered, ask again to go on"), "{said}");
    rig.write("quick", "");
    assert!(rig.infuse(&["ask"]).ok().contains("18 simulations were made for it."));
    // The one that slept was stopped with what it had started.
    let pid = rig.read("started").lines().nth(2).unwrap().to_owned();
    assert!(!std::path::Path::new("/proc").join(&pid).exists(), "process {pid} still runs");
}

#[cfg(unix)]
#[test]
fn an_interrupt_while_a_batch_is_designed_ends_the_call_at_once() {
    let rig = Rig::new();
    let extra: String = (0..4)
        .map(|i| {
            format!(
                "[[parameter]]\nname = \"x{i}\"\nunit = \"\"\nlower = 0\nupper = 1\nlevels = 13\nrole = \"plant\"\n\n"
            )
        })
        .collect();
    rig.edit("# What is measured.", &format!("{extra}# What is measured."));
    rig.edit("experiments = 10", "experiments = 40");
    rig.edit("simulations = 20", "simulations = 90");
    let mut asking = rig.command(&["ask"]).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    // The lock is taken just before the search.
    while !rig.path(".infuse.lock").exists() {
        std::thread::sleep(Duration::from_millis(5));
    }
    std::thread::sleep(Duration::from_millis(300));
    std::process::Command::new("kill").args(["-INT", &asking.id().to_string()]).status().unwrap();
    assert_eq!(asking.wait().unwrap().code(), Some(130));
    assert!(!rig.journal().iter().any(|line| line["event"] == "planned"), "it was still searching");
}

/// A kill gives no warning; who comes next can tell.
#[cfg(target_os = "linux")]
#[test]
fn a_simulation_that_a_killed_call_has_left_running_is_named_by_the_next_one() {
    let rig = Rig::new();
    let script =
        "echo $$ > started; if [ -e quick ]; then echo {spring} {damper gain} | cut -d' ' -f1; else sleep 100; fi";
    rig.edit("table = \"simulation.csv\"", &format!("command = [\"sh\", \"-c\", '''{script}''']\njobs = 1"));
    let mut asking = rig.command(&["ask"]).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let pid = || std::fs::read_to_string(rig.path("started")).unwrap_or_default().trim().to_owned();
    let note = || rig.path(&format!(".infuse.running-{}", pid()));
    while pid().is_empty() || !std::fs::read_to_string(note()).is_ok_and(|text| !text.is_empty()) {
        assert!(asking.try_wait().unwrap().is_none(), "it asks until it is killed");
        std::thread::sleep(Duration::from_millis(5));
    }
    let (pid, note) = (pid(), note());
    let named = format!("process {pid}, which a killed call has begun, still runs");
    for reading in ["status", "log"] {
        assert!(!rig.infuse(&[reading]).stderr.contains(&named), "nobody has killed it yet");
    }
    asking.kill().unwrap();
    asking.wait().unwrap();
    for reading in ["status", "log"] {
        let said = rig.infuse(&[reading]).stderr;
        assert!(said.contains(&named), "{reading}: {said}");
    }
    rig.write("quick", "");
    let said = rig.infuse(&["ask"]);
    assert!(
        said.stderr.contains(&format!("process {pid}, which a killed call has begun, still runs")),
        "{}",
        said.stderr
    );
    assert!(said.stderr.contains(&format!("`kill -- -{pid}` ends it")), "{}", said.stderr);
    said.ok();
    let kill = |whom: &str| std::process::Command::new("kill").args(["-KILL", "--", whom]).status().unwrap().success();
    // The shell alone: what it waited for goes on.
    assert!(kill(&pid));
    let by_it =
        format!("process {pid}, which a killed call has begun, has ended, but programs that it has begun still run");
    while !rig.infuse(&["status"]).stderr.contains(&by_it) {
        assert!(note.exists(), "its group has members");
        std::thread::sleep(Duration::from_millis(5));
    }
    assert!(kill(&format!("-{pid}")), "what was said ends it");
    while rig.infuse(&["ask"]).stderr.contains("still runs") {
        std::thread::sleep(Duration::from_millis(5));
    }
    assert!(!note.exists(), "said as long as it runs, and then forgotten");
    rig.write(&format!(".infuse.running-{}", std::process::id()), "1");
    assert!(!rig.infuse(&["ask"]).stderr.contains("still runs"), "a program that began at another time is another one");
}

#[test]
fn the_rig_of_these_tests_is_what_it_says() {
    assert_eq!(measured(1, 22.0, 1.9), format!("{:.3}", truth(22.0, 1.9) + 0.2 * 12.9898_f64.sin()));
}
