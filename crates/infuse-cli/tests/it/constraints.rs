//! Responses within bounds, settings that go together, choices, and designs that nobody can build.

use serde_json::{Value, json};

use crate::pooled::{ask, wobble};
use crate::rig::Rig;

/// A spring and a damper: `cost` is lowest where `travel` is too long. The simulation is a command that knows both roughly.
fn rig_of(more: &str, parameters: &str) -> Rig {
    let rig = Rig::empty();
    rig.write(
        "campaign.toml",
        &format!(
            "title = \"Travel\"\nseed = 1\n{parameters}[response]\nname = \"cost\"\nunit = \"EUR\"\ngoal = \"minimize\"\n\
             [simulator]\ncommand = [\"sh\", \"simulate.sh\", \"{{a}}\", \"{{b}}\"]\n[loop]\nexperiments = 8\nbatches = 4\n\
             simulations = \"all\"\n{more}"
        ),
    );
    rig.write(
        "simulate.sh",
        "awk -v a=\"$1\" -v b=\"$2\" 'BEGIN { printf \"{\\\"value\\\": %.6f, \\\"travel\\\": %.6f}\\n\", \
         (a-7)^2 + (b-8)^2, 0.8*(a+b) }'\n",
    );
    rig
}

fn parameter(name: &str) -> String {
    format!("[[parameter]]\nname = \"{name}\"\nunit = \"mm\"\nlower = 0\nupper = 10\nstep = 1\nrole = \"plant\"\n")
}

fn cost(a: f64, b: f64) -> f64 {
    (a - 9.0).powi(2) + (b - 9.0).powi(2)
}

fn travel(a: f64, b: f64) -> f64 {
    a + b + 0.03 * (a - b).powi(2)
}

fn settings(experiment: &Value) -> (f64, f64) {
    let of = |name: &str| experiment["settings"][name].as_f64().unwrap();
    (of("a"), of("b"))
}

/// Fills the sheet of a batch: the cost and the travel. False at the end.
fn batch(rig: &Rig) -> bool {
    batch_above(rig, |_| 0.0)
}

/// The same where the sensor of the travel reads so much more, by the number of the experiment.
fn batch_above(rig: &Rig, above: impl Fn(u64) -> f64) -> bool {
    let asked = ask(rig);
    let Some(experiments) = asked["experiments"].as_array() else { return false };
    let rows = experiments.iter().map(|experiment| {
        let (a, b) = settings(experiment);
        format!("{},{},{}\n", experiment["id"], cost(a, b), travel(a, b) + above(experiment["id"].as_u64().unwrap()))
    });
    rig.write("filled.csv", &format!("id,cost [EUR],travel [mm]\n{}", rows.collect::<String>()));
    rig.infuse(&["tell", "filled.csv"]).ok();
    true
}

const TRAVEL: &str = "[[constraint]]\nname = \"travel\"\nunit = \"mm\"\nupper = 10.2\n";

#[test]
fn a_simulated_constraint_that_is_no_number_is_never_dropped_in_silence() {
    let rig = rig_of(TRAVEL, &format!("{}{}", parameter("a"), parameter("b")));
    let simulate =
        |travel: &str| rig.write("simulate.sh", &format!("echo '{{\"value\": 1.5, \"travel\": {travel}}}'\n"));
    for travel in ["\"11.2\"", "true", "[1]"] {
        simulate(travel);
        let checked = rig.infuse(&["check"]).error();
        assert!(checked.contains("what it gave as `travel` is no number"), "{travel}: {checked}");
        let refused = rig.infuse(&["ask"]).error();
        assert!(refused.contains("what it gave as `travel` is no number"), "{travel}: {refused}");
    }
    // Nothing is nothing, and is said by `check`.
    simulate("null");
    let text = rig.infuse(&["check"]).stdout;
    assert!(text.contains("It says nothing of travel: experiments alone will."), "{text}");
    assert!(!text.contains("is no number"), "{text}");
}

/// The sensor of what is constrained reads otherwise from batch to batch, and that of the cost does not.
#[test]
fn a_constraint_whose_sensor_drifts_is_said_to_and_allowed_for() {
    let rig = rig_of(TRAVEL, &(parameter("a") + &parameter("b")));
    for above in [0.0, 1.5, -1.5, 0.5] {
        assert!(batch_above(&rig, |id| above + 0.05 * wobble(id)));
    }
    let status = rig.infuse(&["status"]).ok();
    assert!(status.contains("read alike in `travel`, beyond what their settings explain: batch 1 "), "{status}");
    let json = rig.status();
    let (of_travel, of_cost) = (&json["drift_of_constraints"]["travel"], &json["drift"]);
    assert_eq!((&of_travel["is_sure"], &of_cost["is_sure"]), (&json!(true), &json!(false)), "{json}");
    let by = |at: usize| of_travel["shifts"][at]["by"].as_f64().unwrap();
    assert!((by(1) - by(2) - 3.0).abs() < 0.5, "{of_travel}");
    assert!(status.contains("That is taken in: they share an error of 1."), "{status}");
    assert!(json["shared_error_of_a_batch"].is_null(), "that of the cost shares none: {json}");
    rig.edit("[loop]", "[loop]\nblocks = true");
    let status = rig.infuse(&["status"]).ok();
    assert!(!status.contains("read alike") && status.contains("travel: 1."), "what its readings share: {status}");
    let said = status.lines().find(|line| line.contains("travel: 1.")).unwrap_or_else(|| panic!("{status}"));
    assert!(
        said.contains("In the mean batch 1 ") && said.contains(", batch 4 "),
        "by how much each batch is off: {said}"
    );
    assert!(said.contains("By themselves, too, the results are sure of it."), "{said}");
}

#[test]
fn a_constraint_that_was_measured_keeps_its_unit() {
    let rig = rig_of(TRAVEL, &(parameter("a") + &parameter("b")));
    assert!(batch(&rig));
    rig.edit("name = \"travel\"\nunit = \"mm\"", "name = \"travel\"\nunit = \"m\"");
    for call in ["status", "ask", "report"] {
        let error = rig.infuse(&[call]).error();
        assert!(error.contains("after `travel` was measured: its `unit` was \"mm\" and is \"m\""), "{error}");
    }
    rig.edit("name = \"travel\"\nunit = \"m\"", "name = \"travel\"\nunit = \"mm\"");
    rig.infuse(&["status"]).ok();
}

#[test]
fn recommended_design_keeps_to_the_bound_and_the_page_and_the_tables_say_so() {
    let rig = rig_of(TRAVEL, &(parameter("a") + &parameter("b")));
    while batch(&rig) {}
    let status = rig.status();
    let (a, b) = (status["best"]["a"].as_f64().unwrap(), status["best"]["b"].as_f64().unwrap());
    // Of the 121 designs the best that keeps to it is (5, 5), with a cost of 32.
    assert!(travel(a, b) <= 10.2 && cost(a, b) <= 36.0, "{a} {b}");
    assert_eq!(status["keeps_to_the_constraints"], json!(true));
    assert!(status["constraints"]["travel"]["probability"].as_f64().unwrap() >= 0.9);
    let best_measured = &status["best_measured"]["settings"];
    assert!(travel(best_measured["a"].as_f64().unwrap(), best_measured["b"].as_f64().unwrap()) <= 10.0);
    let text = rig.infuse(&["status"]).ok();
    assert!(text.contains("travel there:") && text.contains("at most 10.2 mm with"), "{text}");
    assert!(text.contains("no design that keeps to the bounds is better"), "{text}");
    let asked = rig.infuse(&["what-if", "a=9,b=9", "--json"]).ok();
    let asked: Value = serde_json::from_str(&asked).unwrap();
    assert!(asked["constraints"]["travel"]["probability"].as_f64().unwrap() < 0.1, "{asked}");
    rig.infuse(&["what-if", "--grid", "all.csv"]).ok();
    let table = rig.read("all.csv");
    assert!(table.lines().next().unwrap().contains("probability of travel at most 10.2 mm"), "{table}");
    rig.infuse(&["report"]).ok();
    let page = rig.read("report.html");
    let page = page.replace('\u{a0}', " ");
    assert!(page.contains("travel at most 10.2 mm with 90 % probability"), "the page says what is asked for");
}

#[test]
fn a_bound_that_nothing_meets_is_said_and_a_name_that_is_dropped_is_noticed() {
    let rig =
        rig_of("[[constraint]]\nname = \"travel\"\nunit = \"mm\"\nupper = -50\n", &(parameter("a") + &parameter("b")));
    assert!(batch(&rig));
    let text = rig.infuse(&["status"]).ok();
    assert!(text.contains("no design is known to keep to what is asked for (travel at most -50 mm"), "{text}");
    let toml = rig.read("campaign.toml").replace("\"travel\"", "\"stroke\"");
    rig.write("campaign.toml", &toml);
    let said = rig.infuse(&["status"]);
    let said = said.stderr + &said.stdout;
    assert!(said.contains("`travel` was measured, but campaign.toml has no [[constraint]] of that name"), "{said}");
}

#[test]
fn values_of_constraints_come_by_command_line_table_and_not_with_another_name() {
    let rig = rig_of(TRAVEL, &(parameter("a") + &parameter("b")));
    ask(&rig);
    rig.infuse(&["tell", "--id", "1", "--value", "5", "--constrained", "travel=11"]).ok();
    let said = rig.infuse(&["tell", "--id", "2", "--value", "5", "--constrained", "stroke=11"]).error();
    assert!(said.contains("no constraint is called `stroke`, expected `travel`"), "{said}");
    let said = rig.infuse(&["tell", "--id", "2", "--value", "5", "--constrained", "travel=long"]).error();
    assert!(said.contains("`travel` is `long`, expected a number"), "{said}");
    // The same again is known; another travel is a correction.
    rig.infuse(&["tell", "--id", "1", "--value", "5", "--constrained", "travel=11"]).ok();
    let said = rig.infuse(&["tell", "--id", "1", "--value", "5", "--constrained", "travel=12"]).error();
    assert!(said.contains("--correct"), "{said}");
    rig.infuse(&["tell", "--id", "1", "--value", "5", "--constrained", "travel=12", "--correct"]).ok();
    rig.write("old.csv", "a [mm],b [mm],cost [EUR],travel [mm]\n1,2,30,4\n2,2,25,\n");
    rig.infuse(&["import", "old.csv", "--source", "last year"]).ok();
    let journal = rig.read("journal.jsonl");
    assert!(journal.contains(r#""constrained":{"travel":4.0}"#), "{journal}");
    rig.write("bad.csv", "id,cost [EUR],travel [mm]\n2,5,far\n");
    let said = rig.infuse(&["tell", "bad.csv"]).error();
    assert!(said.contains("row 2, column `travel [mm]`: is `far`"), "{said}");
}

/// As of a sheet that was written before the constraint came.
#[test]
fn a_sheet_without_the_column_of_a_constraint_is_said_to_say_nothing_of_it() {
    let rig = rig_of(TRAVEL, &(parameter("a") + &parameter("b")));
    ask(&rig);
    rig.write("old.csv", "id,cost [EUR]\n1,5\n2,7\n");
    let said = rig.infuse(&["tell", "old.csv"]).ok();
    assert!(said.contains("The sheet has no column `travel [mm]`: 2 results say nothing of it."), "{said}");
    assert!(said.contains("infuse tell old.csv --correct"), "{said}");
    rig.write("old.csv", "id,cost [EUR],travel [mm]\n1,5,11\n2,7,\n");
    let said = rig.infuse(&["tell", "old.csv", "--correct"]).ok();
    assert!(!said.contains("has no column"), "{said}");
    let journal = rig.read("journal.jsonl");
    assert!(journal.contains(r#""constrained":{"travel":11.0}"#), "{journal}");
}

#[test]
fn settings_that_do_not_go_together_are_never_asked_for() {
    let linear = "[[linear_constraint]]\nsum = { a = 1, b = 1 }\nupper = 9\nlower = 3\n";
    let rig = rig_of(linear, &(parameter("a") + &parameter("b")));
    for _ in 0..2 {
        let asked = ask(&rig);
        for experiment in asked["experiments"].as_array().unwrap() {
            let (a, b) = settings(experiment);
            assert!((3.0..=9.0).contains(&(a + b)), "{a} {b}");
            let id = experiment["id"].to_string();
            rig.infuse(&["tell", "--id", &id, "--value", &cost(a, b).to_string()]).ok();
        }
    }
    let status = rig.status();
    let (a, b) = (status["best"]["a"].as_f64().unwrap(), status["best"]["b"].as_f64().unwrap());
    assert!(a + b <= 9.0, "{a} {b}");
    let said = rig.infuse(&["status", "--why", "a=9,b=9"]).ok();
    assert!(said.contains("[[linear_constraint]]"), "{said}");
}

#[test]
fn what_cannot_be_built_is_neither_asked_for_nor_recommended() {
    let check = "[can_be_built]\ncommand = [\"sh\", \"check.sh\", \"{a}\", \"{b}\"]\n";
    let rig = rig_of(check, &(parameter("a") + &parameter("b")));
    // No thick one that is wide, too.
    rig.write(
        "check.sh",
        "echo \"$1 $2\" >> asked.txt\nif [ \"$1\" -gt 6 ] && [ \"$2\" -gt 6 ]; then echo 0; else echo 1; fi\n",
    );
    for _ in 0..3 {
        let asked = ask(&rig);
        for experiment in asked["experiments"].as_array().unwrap() {
            let (a, b) = settings(experiment);
            assert!(!(a > 6.0 && b > 6.0), "{a} {b}");
            let id = experiment["id"].to_string();
            rig.infuse(&["tell", "--id", &id, "--value", &cost(a, b).to_string()]).ok();
        }
        let best = rig.status()["best"].clone();
        assert!(!(best["a"].as_f64().unwrap() > 6.0 && best["b"].as_f64().unwrap() > 6.0), "{best}");
    }
    let asked = rig.read("asked.txt");
    let mut once: Vec<&str> = asked.lines().collect();
    let n = once.len();
    once.sort_unstable();
    once.dedup();
    assert_eq!(once.len(), n, "no design is asked about twice");
    rig.write("check.sh", "echo maybe\n");
    let toml = rig.read("campaign.toml").replace("check.sh", "./check.sh");
    rig.write("campaign.toml", &toml);
    let said = rig.infuse(&["ask"]).error();
    assert!(said.contains("[can_be_built]") && said.contains("expected 1 on its last line"), "{said}");
}

#[test]
fn a_choice_goes_by_its_name_in_sheets_programs_and_answers() {
    let material = "[[parameter]]\nname = \"b\"\nchoices = [\"foam\", \"film\", \"wood\"]\nrole = \"plant\"\n";
    let rig = rig_of("", &(parameter("a") + material));
    rig.write(
        "simulate.sh",
        "case \"$2\" in foam) o=5;; film) o=0;; wood) o=8;; *) exit 3;; esac\n\
         awk -v a=\"$1\" -v o=$o 'BEGIN { print (a-7)^2 + o }'\n",
    );
    let truth = |a: f64, b: &str| (a - 6.0).powi(2) + if b == "foam" { 0.0 } else { 10.0 };
    for _ in 0..3 {
        let asked = ask(&rig);
        for experiment in asked["experiments"].as_array().unwrap() {
            let (a, b) = (experiment["settings"]["a"].as_f64().unwrap(), experiment["settings"]["b"].as_str().unwrap());
            let id = experiment["id"].to_string();
            rig.infuse(&["tell", "--id", &id, "--value", &truth(a, b).to_string()]).ok();
        }
    }
    let sheet = rig.read("sheet-1.csv");
    assert!(sheet.contains("foam") || sheet.contains("film"), "{sheet}");
    let best = rig.status()["best"].clone();
    assert_eq!((best["a"].as_f64(), best["b"].as_str()), (Some(6.0), Some("foam")), "{best}");
    assert!(rig.infuse(&["what-if", "a=6,b=wood"]).ok().contains("b wood"));
    let said = rig.infuse(&["what-if", "a=6,b=steel"]).error();
    assert!(said.contains("expected one of `foam`, `film`, `wood`"), "{said}");
    rig.infuse(&["what-if", "--grid", "all.csv"]).ok();
    assert!(rig.read("all.csv").contains("wood"));
    rig.infuse(&["report"]).ok();
    let page = rig.read("report.html");
    for choice in ["foam", "film", "wood"] {
        assert!(page.contains(&format!(">{choice}</text>")), "{choice} stands at its place on the axis");
    }
}

#[test]
fn every_key_can_be_got_wrong_in_a_way_that_is_said() {
    let two = parameter("a") + &parameter("b");
    let constraint = |keys: &str| format!("[[constraint]]\nname = \"travel\"\nunit = \"mm\"\n{keys}");
    let choice = |keys: &str| format!("{}[[parameter]]\nname = \"b\"\nrole = \"plant\"\n{keys}", parameter("a"));
    for (more, parameters, expected) in [
        (constraint(""), two.clone(), "neither `lower` nor `upper`"),
        (constraint("lower = 5\nupper = 4\n"), two.clone(), "a bound above the lower one"),
        (constraint("upper = nan\n"), two.clone(), "`upper` is NaN"),
        (constraint("upper = 4\nprobability = 1\n"), two.clone(), "`probability` is 1, expected 0.5 to 0.999"),
        (constraint("upper = 4\nnoise = -1\n"), two.clone(), "`noise` is -1"),
        (constraint("upper = 4\nlimit = 5\n"), two.clone(), "unknown field `limit`"),
        (constraint("upper = 4\n").replace("travel", "a"), two.clone(), "also the name of a parameter"),
        (constraint("upper = 4\n").replace("travel", "cost"), two.clone(), "or of the response"),
        (constraint("upper = 4\n").replace("travel", "failed"), two.clone(), "is a heading of sheets"),
        (constraint("upper = 4\n").repeat(2), two.clone(), "`travel` comes twice"),
        ("[[linear_constraint]]\nsum = { c = 1 }\nupper = 1\n".to_owned(), two.clone(), "`c`, which is no parameter"),
        (
            "[[linear_constraint]]\nsum = {}\nupper = 1\n".to_owned(),
            two.clone(),
            "`sum` is empty, expected some of `a`, `b`",
        ),
        (constraint("upper = nan\n"), two.clone(), "[[constraint]]: constraint `travel`"),
        ("[[linear_constraint]]\nsum = { a = 1 }\n".to_owned(), two.clone(), "neither `lower` nor `upper`"),
        (
            "[[linear_constraint]]\nsum = { a = 1 }\nlower = 2\nupper = 1\n".to_owned(),
            two.clone(),
            "expected at most `upper`",
        ),
        (
            "[[linear_constraint]]\nsum = { a = 1 }\nlower = 11\n".to_owned(),
            two.clone(),
            "no design was found with a at least 11",
        ),
        (
            "[[linear_constraint]]\nsum = { b = 1 }\nupper = 1\n".to_owned(),
            choice("choices = [\"x\", \"y\"]\n"),
            "is a choice",
        ),
        (String::new(), choice("choices = [\"x\"]\n"), "`choices` has 1, expected 2 to 1000"),
        (String::new(), choice("choices = [\"x\", \"x\"]\n"), "each choice once"),
        (String::new(), choice("choices = [\"x\", \"1.5\"]\n"), "no number"),
        (String::new(), choice("choices = [\"x\", \"y\"]\nlower = 1\n"), "`lower` beside `choices`"),
        (String::new(), choice("unit = \"mm\"\nlower = 1\n"), "has no `upper`"),
        ("method = \"dissertation\"\n".to_owned(), choice("choices = [\"x\", \"y\"]\n"), "has `choices`"),
        (format!("method = \"dissertation\"\n{}", constraint("upper = 4\n")), two.clone(), "belongs to `method`"),
    ] {
        let rig = rig_of(&more, &parameters);
        let said = rig.infuse(&["ask"]).error();
        assert!(said.contains(expected), "{more}{parameters}: {said}\nexpected {expected}");
    }
}

/// Nothing that sounds like a promise stands before the sentence that there is none.
#[test]
fn where_no_design_is_known_to_keep_to_the_bounds_that_is_what_is_said_first() {
    let never = TRAVEL.lines().map(|line| if line.starts_with("upper") { "upper = -5" } else { line });
    let rig = rig_of(&(never.collect::<Vec<_>>().join("\n") + "\n"), &(parameter("a") + &parameter("b")));
    let asked = ask(&rig);
    for experiment in asked["experiments"].as_array().unwrap() {
        let (a, b) = settings(experiment);
        let (id, cost, travel) = (experiment["id"].to_string(), cost(a, b).to_string(), travel(a, b));
        rig.infuse(&["tell", "--id", &id, "--value", &cost, "--constrained", &format!("travel={travel}")]).ok();
    }
    let said = rig.infuse(&["status"]).ok();
    let place = |text: &str| said.find(text).unwrap_or_else(|| panic!("{text}: {said}"));
    assert!(place("Careful: no design is known to keep to what is asked for") < place("Recommended:"), "{said}");
    assert!(said.contains("How far it is from the best is not said"), "{said}");
    assert!(
        !said.contains("no design that keeps to the bounds is better") && !said.contains("may still be the best"),
        "{said}"
    );
}

/// A command that is told of one parameter is asked once for each of its values.
#[test]
fn what_the_command_is_not_told_of_makes_no_difference_to_it() {
    let check = "[can_be_built]\ncommand = [\"sh\", \"check.sh\", \"{a}\"]\n";
    let rig = rig_of(check, &(parameter("a") + &parameter("b").replace("role = \"plant\"\n", "")));
    rig.write("check.sh", "echo $1 >> asked.txt\nif [ \"$1\" -gt 6 ]; then echo 0; else echo 1; fi\n");
    for _ in 0..2 {
        let asked = ask(&rig);
        for experiment in asked["experiments"].as_array().unwrap() {
            let (a, b) = settings(experiment);
            assert!(a <= 6.0, "{a} {b}");
            rig.infuse(&["tell", "--id", &experiment["id"].to_string(), "--value", &cost(a, b).to_string()]).ok();
        }
    }
    let asked = rig.read("asked.txt");
    let mut values: Vec<&str> = asked.lines().collect();
    let n = values.len();
    values.sort_unstable();
    values.dedup();
    assert_eq!(n, values.len(), "{asked}");
    let none =
        rig_of("[can_be_built]\ncommand = [\"sh\", \"check.sh\", \"{c}\"]\n", &(parameter("a") + &parameter("b")));
    let said = none.infuse(&["ask"]).error();
    assert!(said.contains("has {c}, but no {a}, {b}") && said.contains("{c} is no parameter"), "{said}");
}
