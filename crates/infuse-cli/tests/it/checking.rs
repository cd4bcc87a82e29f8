//! What a campaign will cost is said before anything runs, and what is wrong with it.

use serde_json::{Value, json};

use crate::rig::Rig;

fn check(rig: &Rig) -> Value {
    serde_json::from_str(&rig.infuse(&["check", "--json"]).ok()).unwrap()
}

#[test]
fn the_budget_is_that_of_the_file() {
    let rig = Rig::pooled();
    let text = rig.infuse(&["check"]).ok();
    for words in
        ["169 designs; 10 experiments a batch, at most 6 batches, so at most 60 runs", "169 of 169", "sheet-1.csv"]
    {
        assert!(text.contains(words), "{words} is not in {text}");
    }
    assert!(!rig.path("journal.jsonl").exists() && !rig.path("sheet-1.csv").exists(), "nothing is written down");
    // A quadratic in two parameters has six terms.
    let text = Rig::new().infuse(&["check"]).ok();
    assert!(
        text.contains("169 designs; 6 terms, 10 experiments a batch, at most 6 batches, so at most 60 runs"),
        "{text}"
    );
    assert_eq!(check(&Rig::new())["terms"], json!(6));
}

#[test]
fn choices_are_named() {
    let rig = Rig::pooled();
    let material = "[[parameter]]\nname = \"pad\"\nchoices = [\"foam\", \"film\"]\nrole = \"plant\"\n\n[response]";
    rig.edit("[response]", material);
    rig.edit("table = \"simulation.csv\"", "command = [\"sh\", \"-c\", \"echo 1\", \"{spring} {damper gain} {pad}\"]");
    let text = rig.infuse(&["check"]).ok();
    assert!(text.contains("  pad: foam, film.\n") && !text.contains("0 to 1"), "{text}");
}

#[test]
fn one_simulation_is_run_and_what_a_batch_costs_follows_from_it() {
    let rig = Rig::pooled();
    let command = "command = [\"sh\", \"-c\", \"echo x >> ran; sleep 0.2; echo {spring}{damper gain}\"]\njobs = 4";
    rig.edit("table = \"simulation.csv\"", command);
    rig.edit("experiments = 10", "experiments = 10\nsimulations = 40");
    let checked = check(&rig);
    assert_eq!(rig.read("ran").lines().count(), 1);
    // In the middle of 10 to 34 and of 0.5 to 2.9.
    assert_eq!(checked["simulation"]["settings"], json!({ "spring": 22.0, "damper gain": 1.7 }));
    assert_eq!((&checked["simulation"]["value"], &checked["simulations_per_batch"]), (&json!(221.7), &json!(40)));
    assert!(checked["seconds_per_simulation"].as_f64() > Some(0.2));
    // Ten rounds of four, of 0.2 s and a little each.
    let text = rig.infuse(&["check"]).ok();
    assert!(text.contains("A batch costs up to 40 simulations, some 2.") && text.contains("4 at once"), "{text}");
    rig.edit("simulations = 40", "simulations = \"all\"");
    assert!(rig.infuse(&["check"]).ok().contains("Before the first batch all 169 designs are simulated"));
}

#[test]
fn what_is_wrong_is_said() {
    let rig = Rig::pooled();
    rig.edit(
        "table = \"simulation.csv\"",
        "command = [\"sh\", \"-c\", \"echo no license {spring} {damper gain} >&2; exit 3\"]",
    );
    let error = rig.infuse(&["check"]).error();
    assert!(error.contains("no value at 3 designs") && error.contains("no license 22 1.7"), "{error}");
    let error = rig.infuse(&["check", "--json"]);
    assert!(!error.is_success && error.stdout.contains("\"error\""), "{}", error.stdout);
    rig.edit("\"sh\"", "\"no-such-program\"");
    assert!(rig.infuse(&["check"]).error().contains("cannot start `no-such-program`"));
    rig.edit("lower = 10", "lower = 40");
    assert!(rig.infuse(&["check"]).error().contains("spring"));
    assert!(Rig::empty().infuse(&["check"]).error().contains("no such file"));
    // A simulator that fails in the middle only.
    let rig = Rig::pooled();
    rig.edit(
        "table = \"simulation.csv\"",
        "command = [\"sh\", \"-c\", \"test {spring} != 22 && echo 5 {damper gain} | cut -c1\"]",
    );
    let text = rig.infuse(&["check"]).ok();
    assert!(text.contains("Careful: the simulation of spring 22 N/mm") && text.contains("gives 5 mm/s"), "{text}");
}
