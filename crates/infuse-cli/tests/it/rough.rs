//! What a first user met: nothing of it happens again.

use crate::rig::Rig;

#[test]
fn sheets_of_any_batch_without_their_journal_are_noticed() {
    for name in ["sheet-1.csv", "sheet-3.csv", "sheet-2.xlsx"] {
        let rig = Rig::pooled();
        rig.write(name, "");
        let said = rig.infuse(&["status"]);
        assert!(
            said.stderr.contains(&format!("there is ./{name}, but no journal.jsonl"))
                || said.stderr.contains(&format!("there is {name}, but no journal.jsonl")),
            "{}",
            said.stderr
        );
    }
}

#[test]
fn another_seed_does_not_make_a_stale_sheet_that_of_the_batch() {
    let rig = Rig::pooled();
    rig.infuse(&["ask"]).ok();
    std::fs::remove_file(rig.path("journal.jsonl")).unwrap();
    rig.edit("seed = 1", "seed = 5");
    for call in [["ask"], ["status"], ["report"], ["log"], ["check"]] {
        assert!(rig.infuse(&call).error().contains("sheet-1.csv, but no journal.jsonl"), "{call:?}");
    }
    rig.infuse(&["tell", "sheet-1.csv"]).error();
    assert!(!rig.path("journal.jsonl").exists(), "a call that was refused leaves nothing");
    std::fs::remove_file(rig.path("sheet-1.csv")).unwrap();
    for foreign in ["simulation.csv", "."] {
        assert!(rig.infuse(&["ask", "--sheet", foreign]).error().contains("is no sheet of this campaign"));
    }
}

#[test]
fn a_slip_on_the_command_line_is_json_for_who_asked_for_it() {
    let rig = Rig::pooled();
    for words in [&["--json", "aks"][..], &["tell", "--json"], &["status", "--json", "--nonsense"]] {
        let said = rig.infuse(words);
        assert!(!said.is_success && said.stderr.is_empty(), "{words:?}: {}", said.stderr);
        let json: serde_json::Value = serde_json::from_str(&said.stdout).unwrap();
        assert!(json["error"].as_str().is_some_and(|error| !error.starts_with("error")), "{json}");
    }
    assert!(rig.infuse(&["aks"]).error().contains("unrecognized subcommand"), "in words for all others");
    assert!(rig.infuse(&["--json", "--help"]).ok().contains("Usage"), "help is text");
}

#[test]
fn a_simulator_that_removes_the_journal_is_noticed() {
    let rig = Rig::pooled();
    rig.edit(
        "table = \"simulation.csv\"",
        "command = [\"sh\", \"-c\", \"rm -f journal.jsonl; echo {spring}{damper gain}\"]",
    );
    assert!(rig.infuse(&["ask"]).error().contains("another program has removed or cut it"));
}

#[test]
fn one_more_run_of_what_was_not_told_is_refused() {
    let rig = Rig::pooled();
    rig.infuse(&["ask"]).ok();
    assert!(rig.infuse(&["tell", "--id", "1", "--value", "5", "--again"]).error().contains("has no result yet"));
}

#[test]
fn a_value_beyond_all_sense_is_remarked_on_when_it_is_told() {
    let rig = Rig::pooled();
    rig.infuse(&["ask"]).ok();
    for id in 1..=9 {
        rig.infuse(&["tell", "--id", &id.to_string(), "--value", &format!("7.{id}")]).ok();
    }
    let said = rig.infuse(&["tell", "--id", "10", "--value", "1e20"]).ok();
    assert!(said.contains("Careful: far from what all others say: experiment 10"), "{said}");
    rig.infuse(&["undo"]).ok();
    assert!(!rig.infuse(&["status"]).ok().contains("Careful"));
}

/// A value ten times too low is recommended until it was run again; what the others say is said beside it, in their unit.
#[test]
fn a_recommendation_that_stands_on_a_slip_says_what_is_expected_without_it() {
    let rig = Rig::pooled();
    rig.infuse(&["ask"]).ok();
    for id in 1..=9 {
        rig.infuse(&["tell", "--id", &id.to_string(), "--value", &format!("70.{id}")]).ok();
    }
    assert!(!rig.infuse(&["status"]).ok().contains("It stands on"));
    rig.infuse(&["tell", "--id", "10", "--value", "7.04"]).ok();
    let said = rig.infuse(&["status"]).ok();
    let from = said.find("It stands on experiment 10 alone (7.0").unwrap_or_else(|| panic!("{said}"));
    let without = said[from..].split("without that ").nth(1).expect("what would be expected");
    assert!(without.starts_with("70."), "the others lie between 70.1 and 70.9: {said}");
    assert!(rig.infuse(&["status", "--json"]).ok().contains("\"expected without it\""));
}

/// What a whole sheet would have said is said of one result that is put right, and of one more run, too.
#[test]
fn a_result_that_is_put_right_is_remarked_on() {
    let rig = Rig::pooled();
    rig.infuse(&["ask"]).ok();
    for id in 1..=10 {
        rig.infuse(&["tell", "--id", &id.to_string(), "--value", &format!("7.{id}")]).ok();
    }
    let said = rig.infuse(&["tell", "--id", "2", "--value", "1e9", "--correct"]).ok();
    assert!(said.contains("Careful: far from what all others say: experiment 2"), "{said}");
    let said = rig.infuse(&["tell", "--id", "2", "--value", "7.2", "--correct"]).ok();
    assert!(said.contains("Recommended: ") && !said.contains("Careful"), "{said}");
    assert!(rig.infuse(&["tell", "--id", "3", "--value", "7.31", "--again"]).ok().contains("Recommended: "));
}

#[test]
fn what_is_imported_from_beyond_the_bounds_is_named() {
    let rig = Rig::pooled();
    let rows = "spring [N/mm],damper gain [N s/mm],vibration [mm/s]\n36,0.5,7\n34,0.5,7.1\n";
    rig.write("old.csv", rows);
    let said = rig.infuse(&["import", "old.csv", "--source", "notebook"]).ok();
    assert!(said.contains("1 row lies outside of the bounds of the parameters; the first: spring 36 N/mm"), "{said}");
    rig.write("new.csv", &rows.replace("36,", "33,"));
    let said = rig.infuse(&["import", "new.csv", "--source", "another"]).ok();
    assert!(!said.contains("outside of the bounds"), "{said}");
}

/// Bounds are widened by a campaign in another folder, which takes all experiments over: the same readings, the same surface.
#[test]
fn another_campaign_takes_all_experiments_over() {
    let first = Rig::pooled();
    first.infuse(&["ask"]).ok();
    first.fill("sheet-1.csv", |id| id != 3);
    first.infuse(&["tell", "sheet-1.csv"]).ok();
    first.infuse(&["tell", "--id", "3", "--failed", "the spring broke"]).ok();
    first.infuse(&["tell", "--id", "1", "--value", "9.5", "--again"]).ok();
    first.write("old.csv", "spring [N/mm],damper gain [N s/mm],vibration [mm/s]\n20,0.7,9\n");
    first.infuse(&["import", "old.csv", "--source", "notebook"]).ok();
    let folder = first.folder().to_str().unwrap();
    let second = Rig::pooled();
    let said = second.infuse(&["import", folder, "--source", "first"]).ok();
    assert!(said.contains("12 experiments"), "{said}");
    let [then, now] = [&first, &second].map(|rig| rig.status());
    for key in ["best", "left_share"] {
        assert_eq!(then[key], now[key], "{key}");
    }
    let expected = |status: &serde_json::Value| status["predicted"].as_f64().unwrap();
    assert!((expected(&then) - expected(&now)).abs() < 1e-9 * expected(&then).abs());
    let sources: Vec<_> =
        second.journal().iter().filter_map(|line| line["source"].as_str().map(str::to_owned)).collect();
    assert!(sources.contains(&"first: notebook".to_owned()), "{sources:?}");
    let third = Rig::pooled();
    third.edit("upper = 34", "upper = 14");
    let said = third.infuse(&["import", folder, "--source", "first"]).ok();
    assert!(said.contains("were left out: farther outside of the bounds than half their width"), "{said}");
    assert!(third.infuse(&["import", ".", "--source", "x"]).error().contains("is the folder of this campaign"));
    let fourth = Rig::pooled();
    fourth.edit("unit = \"N/mm\"", "unit = \"N/m\"");
    let error = fourth.infuse(&["import", folder, "--source", "first"]).error();
    assert!(error.contains("has as the unit of `spring` \"N/mm\" and this one \"N/m\""), "{error}");
}

#[test]
fn settings_may_be_typed_with_their_units() {
    let rig = Rig::pooled();
    rig.infuse(&["ask"]).ok();
    rig.fill("sheet-1.csv", |_| true);
    rig.infuse(&["tell", "sheet-1.csv"]).ok();
    let [with, without] = ["spring=22 N/mm, damper gain=1.9N s/mm", "spring=22,damper gain=1.9"]
        .map(|settings| rig.infuse(&["what-if", settings]).ok());
    assert_eq!(with, without);
    assert!(
        rig.infuse(&["what-if", "spring=22 kN/mm, damper gain=1.9"]).error().contains("expected a number like 12.5")
    );
}

#[test]
fn results_that_span_powers_of_ten_are_remarked_on() {
    for is_remarked_on in [true, false] {
        let rig = Rig::pooled();
        rig.infuse(&["ask"]).ok();
        for id in 1..=10 {
            let value = if is_remarked_on { 10.0_f64.powi(-id) } else { 5.0 + f64::from(id) };
            rig.infuse(&["tell", "--id", &id.to_string(), "--value", &value.to_string()]).ok();
        }
        let said = rig.infuse(&["status"]).ok();
        assert_eq!(said.contains("Results span powers of ten, 1e-10 mm/s to 0.1 mm/s"), is_remarked_on, "{said}");
    }
}

#[test]
fn a_simulation_that_is_the_same_everywhere_is_remarked_on() {
    let rig = Rig::pooled();
    rig.edit("table = \"simulation.csv\"", "command = [\"sh\", \"-c\", \"echo 5 # {spring}{damper gain}\"]");
    rig.edit("experiments = 10", "experiments = 4\nsimulations = 20");
    rig.infuse(&["ask"]).ok();
    rig.fill("sheet-1.csv", |_| true);
    rig.infuse(&["tell", "sheet-1.csv"]).ok();
    assert!(rig.infuse(&["status"]).ok().contains("gives the same value everywhere"));
}

#[test]
fn failing_designs_are_named_with_their_parameters() {
    let rig = Rig::new();
    rig.edit(
        "table = \"simulation.csv\"",
        "command = [\"sh\", \"-c\", \"echo broken {spring} {damper gain} >&2; exit 3\"]",
    );
    let error = rig.infuse(&["ask"]).error();
    assert!(error.contains("the first at spring ") && error.contains(" N/mm, damper gain "), "{error}");
    assert!(!error.contains("at ["), "{error}");
}

#[test]
fn a_unit_of_one_is_not_said() {
    let rig = Rig::pooled();
    rig.edit("unit = \"mm/s\"", "unit = \"1\"");
    rig.write("simulation.csv", &rig.read("simulation.csv").replace("[mm/s]", "[1]"));
    rig.infuse(&["ask"]).ok();
    for id in 1..=10 {
        rig.infuse(&["tell", "--id", &id.to_string(), "--value", &format!("7.{id}")]).ok();
    }
    let text = rig.infuse(&["status"]).ok();
    assert!(text.contains("Best measured: 7.1, experiment 1"), "{text}");
}

#[test]
fn with_surfaces_that_promise_nothing_it_is_said_that_nothing_is_promised() {
    for (surfaces, is_said) in [
        ("", false),
        ("surfaces = { experiment = { inverse_distance = { power = 2 } } }", true),
        ("surfaces = { combined = { squared_exponential = {} } }", false),
    ] {
        let rig = Rig::new();
        rig.edit("[loop]", &format!("[loop]\n{surfaces}"));
        rig.batch();
        let text = rig.infuse(&["status"]).ok();
        assert_eq!(text.contains("not known with these `surfaces`"), is_said, "{surfaces}: {text}");
        assert_eq!(text.contains("More experiments may still gain"), !is_said, "{surfaces}: {text}");
    }
}

/// 3^13 points of a lattice would be gigabytes; the list of designs is small.
#[cfg(target_os = "linux")]
#[test]
fn many_parameters_take_no_gigabytes() {
    let rig = Rig::empty();
    let parameter = |index: usize| {
        format!(
            "[[parameter]]\nname = \"p{index}\"\nunit = \"mm\"\nlower = 0\nupper = 1\nlevels = 2\nrole = \"plant\"\n"
        )
    };
    let parameters: String = (0..12).map(parameter).collect();
    let settings: String = (0..12).map(|index| format!("{{p{index}}}")).collect();
    rig.write(
        "campaign.toml",
        &format!(
            "title = \"many\"\n{parameters}[response]\nname = \"y\"\nunit = \"\"\ngoal = \"minimize\"\n[simulator]\n\
             command = [\"sh\", \"-c\", \"echo 1{settings}\"]\n[loop]\nmethod = \"dissertation\"\nmodel = \"linear\"\n"
        ),
    );
    let mut command = std::process::Command::new("sh");
    let script = "ulimit -v 700000; exec \"$0\" ask";
    command.args(["-c", script, env!("CARGO_BIN_EXE_infuse")]).current_dir(rig.folder());
    crate::rig::Said::from(command.output().unwrap()).ok();
}

/// Of what a simulator prints its end is read, and the rest is never in memory.
#[cfg(target_os = "linux")]
#[test]
fn a_long_output_takes_no_memory() {
    let rig = Rig::pooled();
    let command =
        "command = [\"sh\", \"-c\", \"head -c 300000000 /dev/zero; echo; echo {spring}{damper gain}\"]\njobs = 1";
    rig.edit("table = \"simulation.csv\"", command);
    rig.edit("experiments = 10", "experiments = 1\nsimulations = 2");
    let mut command = std::process::Command::new("sh");
    let script = "ulimit -v 250000; exec \"$0\" ask";
    command.args(["-c", script, env!("CARGO_BIN_EXE_infuse")]).current_dir(rig.folder());
    crate::rig::Said::from(command.output().unwrap()).ok();
}
