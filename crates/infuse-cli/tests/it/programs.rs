//! Simulators and experiments that are commands, and what can become of them.

use std::time::Instant;

use crate::campaigns::SHELL_SIMULATION;
use crate::rig::{Rig, truth};

/// The template with this simulator.
fn rig(simulator: &str) -> Rig {
    let rig = Rig::new();
    rig.edit("table = \"simulation.csv\"", simulator);
    rig
}

fn shell(script: &str) -> String {
    format!("command = [\"sh\", \"-c\", '''{script}''']")
}

#[test]
fn points_are_handed_over_as_arguments_or_as_json() {
    let arguments = rig(&shell(SHELL_SIMULATION));
    arguments.infuse(&["ask"]).ok();
    let table = Rig::new();
    table.infuse(&["ask"]).ok();
    let values = |rig: &Rig| {
        let mut values: Vec<_> = rig
            .journal()
            .iter()
            .filter(|line| line["event"] == "simulated")
            .map(|line| (line["cell"].as_u64().unwrap(), (line["value"].as_f64().unwrap() * 1e3).round()))
            .collect();
        values.sort_by_key(|value| value.0);
        values
    };
    assert_eq!(values(&arguments), values(&table));
    let script = r#"sed 's/.*"spring":\([0-9.]*\).*/\1/' | awk '{ printf "{\"value\": %s}\n", $1 }'"#;
    let json = rig(&format!("{}\ninput = \"json\"", shell(script)));
    json.infuse(&["ask"]).ok();
    for line in json.journal().iter().filter(|line| line["event"] == "simulated") {
        assert_eq!(line["value"], line["point"][0]);
    }
}

#[test]
fn runs_that_fail_are_written_down_with_their_reason_and_survived() {
    // Stiff springs crash, hang, say so, print nonsense.
    let script = format!(
        "case {{spring}} in 28) echo out of memory >&2; exit 3;; 30) sleep 60;; 32) echo '{{\"failed\": \"no equilibrium\"}}'; exit 0;; \
         34) echo '** done **'; exit 0;; esac; {SHELL_SIMULATION}"
    );
    let rig = rig(&format!("{}\ntimeout_seconds = 0.5\njobs = 4", shell(&script)));
    let start = Instant::now();
    let said = rig.infuse(&["ask"]);
    let (n, stderr) = (said.stderr.split(" simulations failed: ").count(), said.stderr.clone());
    assert!(n == 2 && stderr.contains("spring") && stderr.contains("damper gain"), "{stderr}");
    said.ok();
    assert!(start.elapsed().as_secs() < 50, "nobody waits for a program that was stopped");
    let reasons: Vec<String> =
        rig.journal().iter().filter_map(|line| line["failed"].as_str().map(str::to_owned)).collect();
    let has = |words: &str| reasons.iter().any(|reason| reason.contains(words));
    assert!(has("no equilibrium") || has("out of memory") || has("stopped after 0.5 s"), "{reasons:?}");
    assert!(has("its last line is `** done **`, expected a number"), "{reasons:?}");
}

#[test]
fn a_simulator_that_never_works_is_reported_at_once_and_repaired_later() {
    let rig = rig(&shell("echo no licence for {spring} {damper gain} >&2; exit 1"));
    let error = rig.infuse(&["ask"]).error();
    assert!(error.contains("all 20 simulations failed") && error.contains("no licence for"), "{error}");
    assert!(error.contains("Repair the simulator and ask again"), "{error}");
    rig.edit(&shell("echo no licence for {spring} {damper gain} >&2; exit 1"), "table = \"simulation.csv\"");
    assert!(rig.infuse(&["ask"]).ok().contains("Batch 1: 10 experiments"));
    let rig = self::rig("command = [\"no-such-program\", \"{spring}\", \"{damper gain}\"]");
    let error = rig.infuse(&["ask"]).error();
    assert!(error.contains("cannot start `no-such-program`"), "{error}");
}

#[test]
fn values_that_no_surface_takes_are_failed_runs() {
    let rig = rig(&shell(&format!("if [ {{spring}} = 34 ]; then echo 1e300; else {SHELL_SIMULATION}; fi")));
    rig.infuse(&["ask"]).ok();
    assert!(rig.journal().iter().any(|line| {
        line["failed"]
            .as_str()
            .is_some_and(|why| why == "it returned 1e300, expected a number of at most 1e100 in magnitude")
    }));
    rig.fill("sheet-1.csv", |_| true);
    rig.infuse(&["tell", "sheet-1.csv"]).ok();
    let error = rig.infuse(&["tell", "--id", "1", "--value", "1e200", "--again"]).error();
    assert!(error.contains("expected a number of at most 1e100"), "{error}");
}

#[test]
fn what_was_simulated_is_remembered_until_it_is_to_be_forgotten() {
    let script = format!("echo run >> runs; {SHELL_SIMULATION}");
    let rig = rig(&shell(&script));
    rig.batch();
    let n_runs = || rig.read("runs").lines().count();
    assert_eq!(n_runs(), 20);
    rig.infuse(&["ask"]).ok();
    let n_second = n_runs();
    assert!(n_second < 40, "{n_second}: cells of the first batch are not run again");
    rig.fill("sheet-2.csv", |_| true);
    rig.infuse(&["tell", "sheet-2.csv"]).ok();
    rig.infuse(&["ask", "--anyway", "--resimulate"]).ok();
    let distinct: std::collections::BTreeSet<u64> =
        rig.journal().iter().rfind(|line| line["event"] == "planned").unwrap()["simulations"]
            .as_array()
            .unwrap()
            .iter()
            .filter_map(serde_json::Value::as_u64)
            .collect();
    assert_eq!(n_runs() - n_second, distinct.len());
}

#[test]
fn an_experiment_that_is_a_command_closes_the_loop() {
    let script = "awk 'BEGIN { a = ({spring} - 22) / 12; b = ({damper gain} - 1.9) / 1.2; \
                  print 7 + 4 * a * a + 5 * b * b + 1.5 * a * b + 0.2 * sin(12.9898 * {run}) }'";
    let rig = Rig::new();
    let error = rig.infuse(&["run"]).error();
    assert!(error.contains("has no [experiment]"), "{error}");
    rig.edit("[loop]", &format!("[experiment]\n{}\n[loop]", shell(script)));
    let text = rig.infuse(&["run", "--batches", "1"]).ok();
    assert!(text.contains("batch 1:") && text.contains("1 batch made; infuse run goes on."), "{text}");
    let text = rig.infuse(&["run"]).ok();
    assert!(text.contains("Ended: another batch may gain"), "{text}");
    let status = rig.status();
    let best = |name: &str| status["best"][name].as_f64().unwrap();
    assert!(truth(best("spring"), best("damper gain")) < 7.2, "{status}");
    // Values the response cannot have are failures.
    rig.edit("lower = 0\n", "lower = 1000\n");
    let said = rig.infuse(&["run", "--anyway", "--batches", "1"]);
    assert!(
        rig.journal().iter().any(|line| line["failed"].as_str().is_some_and(|why| why.contains("at least 1000"))),
        "{said:?}"
    );
}

#[test]
fn a_script_that_never_gives_a_value_ends_the_run_after_one_batch() {
    let rig = Rig::pooled();
    rig.edit("# [experiment]", "[experiment]");
    rig.edit(
        "# command = [\"./rig\", \"{spring}\", \"{damper gain}\"]",
        "command = [\"sh\", \"-c\", \"exit 2\", \"{spring}\", \"{damper gain}\"]",
    );
    for _ in 0..2 {
        let error = rig.infuse(&["run"]).error();
        assert!(error.contains("not one of 10 runs gave a value; the first one: "), "{error}");
        assert!(error.contains("infuse run --anyway"), "{error}");
    }
    assert_eq!(rig.journal().iter().filter(|line| line["event"] == "told").count(), 10, "one batch, and no other");
    rig.infuse(&["run", "--anyway", "--batches", "1"]).ok();
    assert_eq!(rig.journal().iter().filter(|line| line["event"] == "told").count(), 20);
}
