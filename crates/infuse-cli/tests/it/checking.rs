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

/// What is next is that of `status`, whatever the campaign has come to.
#[test]
fn what_is_next_follows_from_where_the_campaign_stands() {
    let rig = Rig::pooled();
    rig.edit("batches = 6", "batches = 1");
    let last = |command: &str| {
        let said = rig.infuse(&[command]).ok();
        said.lines().last().map(str::to_owned).unwrap_or_default()
    };
    assert_eq!(last("check"), "Next: infuse ask");
    rig.infuse(&["ask"]).ok();
    assert_eq!(last("check"), "Next: run what is left in sheet-1.csv, then: infuse tell sheet-1.csv");
    rig.fill("sheet-1.csv", |_| true);
    rig.infuse(&["tell", "sheet-1.csv"]).ok();
    assert_eq!(last("check"), last("status"));
    let said = rig.infuse(&["check"]).ok();
    assert!(said.contains("Ended: ") && said.contains("  Next: infuse confirm"), "{said}");
    assert!(!said.contains("infuse ask"), "{said}");
}

/// In the middle of a campaign the budget is that of what is left.
#[test]
fn what_was_done_is_not_advised_again() {
    let rig = Rig::pooled();
    let command = "command = [\"sh\", \"-c\", \"echo {spring} {damper gain} | awk '{print $1 / 7 + $2}'\"]\njobs = 4";
    rig.edit("table = \"simulation.csv\"", command);
    rig.edit("experiments = 10", "experiments = 10\nsimulations = \"all\"");
    let text = rig.infuse(&["check"]).ok();
    assert!(text.contains("Before the first batch all 169 designs are simulated"), "{text}");
    assert!(text.contains("Until 40 designs were run, a repeat counting half, in 4 batches or more, what"), "{text}");
    rig.batch();
    let text = rig.infuse(&["check"]).ok();
    assert!(text.contains("A batch costs no simulation any more: all designs were simulated."), "{text}");
    assert!(!text.contains("Before the first batch"), "{text}");
    let counted = rig.status()["designs_counted"].as_f64().unwrap();
    let needed = ((40.0 - counted) / 10.0).ceil();
    let said = format!("Until 40 designs were run ({counted} so far, a repeat counting half), in {needed} more batch");
    assert!(text.contains(&said), "{said} is not in {text}");
    for _ in 0..4 {
        rig.infuse(&["ask", "--anyway"]).ok();
        let sheet = format!("sheet-{}.csv", rig.status()["batches"].as_array().unwrap().len() + 1);
        rig.fill(&sheet, |_| true);
        rig.infuse(&["tell", &sheet]).ok();
    }
    let text = rig.infuse(&["check"]).ok();
    assert!(!text.contains("leaves room for a narrow"), "nothing is held for one any more: {text}");
}

/// What the journal has of a simulator is not run again, and what is to come is less that: before, in the middle and after.
#[test]
fn simulations_that_were_made_are_neither_tried_nor_counted_again() {
    let rig = Rig::pooled();
    let command = "command = [\"sh\", \"-c\", \"echo x >> ran; echo {spring} {damper gain} | awk '{print $1 / 7 + $2}'\"]\njobs = 1";
    rig.edit("table = \"simulation.csv\"", command);
    rig.edit("experiments = 10", "experiments = 10\nsimulations = 15");
    rig.edit("batches = 6", "batches = 2");
    let n_ran = || std::fs::read_to_string(rig.path("ran")).map_or(0, |ran| ran.lines().count());
    let n_made = || rig.journal().iter().filter(|line| line["event"] == "simulated").count();
    let before = check(&rig);
    assert_eq!((n_ran(), &before["simulations_made"]), (2, &json!(0)), "tried, and once more elsewhere");
    assert_eq!((&before["simulations_to_come"], &before["simulations_at_most"]), (&json!(40), &json!(40)));
    rig.batch();
    let (ran, made) = (n_ran(), n_made());
    let (middle, text) = (check(&rig), rig.infuse(&["check"]).ok());
    assert_eq!((n_ran(), &middle["simulations_made"], &middle["simulations_to_come"]), (ran, &json!(made), &json!(15)));
    assert!(
        text.contains(&format!("The journal has {made} simulations by this command, so it was not tried")),
        "{text}"
    );
    assert!(text.contains(&format!("  {made} simulations were made, and up to 15 are to come.")), "{text}");
    assert!(!text.contains("40 simulations"), "{text}");
    rig.batch();
    let (ran, made) = (n_ran(), n_made());
    let (after, text) = (check(&rig), rig.infuse(&["check"]).ok());
    assert_eq!((n_ran(), &after["simulations_made"], &after["simulations_to_come"]), (ran, &json!(made), &json!(0)));
    assert!(text.contains(&format!("No simulation is to come any more: {made} were made.")), "{text}");
    // Another command is tried.
    rig.edit("$1 / 7", "$1 / 8");
    assert_eq!(check(&rig)["simulations_made"], json!(0));
    assert_eq!(n_ran(), ran + 2);
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
fn a_simulation_is_run_and_what_a_batch_costs_follows_from_it() {
    let rig = Rig::pooled();
    let command = "command = [\"sh\", \"-c\", \"echo x >> ran; sleep 0.2; echo {spring}{damper gain}\"]\njobs = 4";
    rig.edit("table = \"simulation.csv\"", command);
    rig.edit("experiments = 10", "experiments = 10\nsimulations = 40");
    let checked = check(&rig);
    // And a second one, as it is quick, which shows whether it takes its settings.
    assert_eq!(rig.read("ran").lines().count(), 2);
    // In the middle of 10 to 34 and of 0.5 to 2.9.
    assert_eq!(checked["simulation"]["settings"], json!({ "spring": 22.0, "damper gain": 1.7 }));
    assert_eq!((&checked["simulation"]["value"], &checked["simulations_per_batch"]), (&json!(221.7), &json!(40)));
    assert!(checked["seconds_per_simulation"].as_f64() > Some(0.2));
    // Ten rounds of four, of as long as one took.
    let text = rig.infuse(&["check"]).ok();
    let seconds = |before: &str| -> f64 {
        let rest = text.split(before).nth(1).unwrap_or_else(|| panic!("{text}"));
        rest.split(' ').next().and_then(|seconds| seconds.parse().ok()).unwrap_or_else(|| panic!("{text}"))
    };
    let (one, all) = (seconds("gives 221.7 mm/s, in "), seconds("A batch costs up to 40 simulations, some "));
    assert!((all / (10.0 * one) - 1.0).abs() < 0.05 && text.contains("4 at once"), "{text}");
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

#[test]
fn the_budget_knows_of_plants_constraints_and_the_time_of_a_choice() {
    let rig = Rig::pooled();
    let command = "command = [\"sh\", \"-c\", \"echo '{\\\"value\\\": 5, \\\"travel\\\": 3}'\", \"{spring}{damper gain}\"]\njobs = 2";
    rig.edit("table = \"simulation.csv\"", command);
    rig.edit(
        "experiments = 10",
        "experiments = 10\nsimulations = 20\nplants = 3\nexperiment_cost = 0.5\ncost_unit = \"h\"",
    );
    rig.edit("role = \"plant\"", "role = \"plant\"\nchange_cost = 6");
    let constraint = |name: &str| format!("[[constraint]]\nname = \"{name}\"\nunit = \"mm\"\nupper = 4\n");
    // Of 13 settings each, 10 to 34 and 0.5 to 2.9: those with spring + 10 gain at most 39 lie on or below a diagonal.
    let linear = "[[linear_constraint]]\nsum = { spring = 1, \"damper gain\" = 10 }\nupper = 39\n";
    rig.edit(
        "[loop]",
        &format!(
            "{}{}{linear}[can_be_built]\ncommand = [\"echo\", \"1\", \"{{spring}}{{damper gain}}\"]\n[loop]",
            constraint("travel"),
            constraint("force")
        ),
    );
    rig.edit("[can_be_built]\ncommand = [\"echo\", \"1\"", "[can_be_built]\ncommand = [\"sh\", \"-c\", \"echo 1\"");
    let checked = check(&rig);
    let levels = |n: i32| (0..13).map(move |k| (k, n));
    let kept =
        levels(13).flat_map(|(a, n)| (0..n).map(move |b| (a, b))).filter(|(a, b)| 10 + 2 * a + 5 + 2 * b <= 39).count();
    assert_eq!(checked["designs_allowed"], json!(kept), "{checked}");
    assert!((30..130).contains(&kept), "more than a batch, and less than the 130 that all batches may cost");
    // Ten runs of half an hour, on up to three plants of six hours.
    assert_eq!((&checked["costs"]["batch"], &checked["costs"]["all"]), (&json!(23.0), &json!(138.0)));
    assert_eq!((&checked["simulations_at_most"], &checked["can_be_built"]), (&json!(kept), &json!(true)));
    assert!(checked["seconds_to_choose"].as_f64() > Some(0.0));
    let text = rig.infuse(&["check"]).ok();
    for words in [
        &format!("169 designs, of which the linear constraints leave {kept};"),
        "A batch costs up to 23 h: 10 runs on up to 3 plants; all of them up to 138 h.",
        "gives 5 mm/s, travel 3 mm, in",
        "It says nothing of force: experiments alone will.",
        "spring + 10 damper gain at most 39.",
        "travel at most 4 mm with 90 % probability.",
        &format!("That is up to {kept} simulations in all"),
        "the first up to 30, as its experiments are simulated, too",
        "To choose a batch takes some",
        "can be built, in",
    ] {
        assert!(text.contains(words), "{words} is not in {text}");
    }
    assert!(!rig.path("journal.jsonl").exists(), "nothing is written down");
    assert!(Rig::new().infuse(&["check"]).ok().contains("is not known beforehand"));
}
