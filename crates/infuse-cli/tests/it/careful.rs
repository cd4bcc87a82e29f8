//! What speaks against a campaign of the pooled loop is said: spoilt runs, wrong noise, dead sensors, nothing but failures.

use serde_json::{Value, json};

use crate::pooled::{ask, batch, best, rig_of, tell, wells, wobble};
use crate::rig::Rig;

const DEPTHS: [f64; 2] = [40.0, 60.0];

fn measure(a: f64, b: f64, id: u64) -> Result<f64, String> {
    Ok(wells(a, b, DEPTHS) + 0.2 * wobble(id))
}

#[test]
fn a_spoilt_run_is_set_aside_once_it_was_run_again() {
    let rig = rig_of(|a, b| wells(a, b, DEPTHS), "");
    let spoilt = 4;
    let mut at = None;
    for _ in 0..3 {
        batch(&rig, |a, b, id| {
            at = at.or((id == spoilt).then_some((a, b)));
            if id == spoilt { Ok(5.0) } else { measure(a, b, id) }
        });
    }
    let text = rig.infuse(&["status"]).ok();
    assert!(
        text.contains("Set aside, because other runs of the same settings") && text.contains("experiment 4 ("),
        "{text}"
    );
    assert!(!text.contains("Best measured: 5 N"), "{text}");
    assert_ne!(rig.status()["best_measured"]["id"], json!(spoilt));
    let noise = rig.status()["noise"]["standard_deviation"].as_f64().unwrap();
    assert!((0.05..1.0).contains(&noise), "{noise}");
    let (a, b) = best(&rig);
    assert!(wells(a, b, DEPTHS) < wells(6.0, 11.0, DEPTHS) + 1.0, "{a}, {b}");
    // What is run to compare designs is not compared with a spoilt run.
    let asked: Value = serde_json::from_str(&rig.infuse(&["confirm", "--json"]).ok()).unwrap();
    let (a, b) = at.unwrap();
    let is_there = |one: &Value| one["settings"] == json!({ "a": a, "b": b });
    assert!(!asked["experiments"].as_array().unwrap().iter().any(is_there), "{asked}");
}

/// A spoilt run that was run again differs from its repeat by far more than the noise that was given, which is right all the same.
#[test]
fn a_run_that_is_set_aside_says_nothing_of_the_noise() {
    let rig = rig_of(|a, b| wells(a, b, DEPTHS), "noise = 0.2\n");
    for _ in 0..3 {
        batch(&rig, |a, b, id| if id == 4 { Ok(5.0) } else { measure(a, b, id) });
    }
    let text = rig.infuse(&["status"]).ok();
    assert!(text.contains("Set aside, because") && !text.contains("`noise` in [loop] is"), "{text}");
    assert_eq!(rig.status()["noise"]["is_contradicted"], json!(false));
}

#[test]
fn earlier_experiments_may_be_the_best_or_spoilt_or_failed() {
    let rig = rig_of(|a, b| wells(a, b, DEPTHS), "");
    let row = |a: u32, b: u32| format!("{a},{b},{:.3},,\n", wells(f64::from(a), f64::from(b), DEPTHS));
    let measured: String = (0..20).map(|index| row(2 * (index % 5), 3 * (index / 5))).collect();
    let heading = "a [mm],b [mm],y [N],source,failed\n";
    rig.write(
        "old.csv",
        &format!("{heading}{measured}6,11,30.5,page 7,\n8,14,,page 8,it fell over\n7,14,,page 8,it fell over\n"),
    );
    let said = rig.infuse(&["import", "old.csv", "--source", "notebook"]).ok();
    assert!(said.contains("Imported: 23 experiments"), "{said}");
    let text = rig.infuse(&["status"]).ok();
    assert!(text.contains("Best measured: 30.5 N, an experiment of `notebook: page 7` at a 6 mm, b 11 mm"), "{text}");
    let why = rig.infuse(&["status", "--why", "a=8,b=14"]).ok();
    assert!(why.contains("it fell over") || why.contains("a run there gives a value with 0 %"), "{why}");
    rig.infuse(&["report"]).ok();
    assert!(rig.read("report.html").contains("failed: it fell over"));
    let asked = ask(&rig);
    let fell = |one: &Value| one["settings"] == json!({ "a": 8.0, "b": 14.0 });
    assert!(!asked["experiments"].as_array().unwrap().iter().any(fell), "{asked}");
    // A row says one thing.
    rig.write("both.csv", &format!("{heading}1,1,3,page 9,it fell over\n"));
    assert!(rig.infuse(&["import", "both.csv", "--source", "x"]).error().contains("nothing, as there is a value"));
    rig.write("none.csv", &format!("{heading}1,1,,page 9,\n"));
    assert!(rig.infuse(&["import", "none.csv", "--source", "x"]).error().contains("expected a number"));
    rig.write("none.csv", &format!("{heading}1,1,NaN,page 9,\n"));
    assert!(rig.infuse(&["import", "none.csv", "--source", "x"]).error().contains("reported as failed"));
    // What is far off is named with its settings, and how it is taken back.
    rig.write("spoilt.csv", &format!("{heading}4,6,-900,page 3,\n"));
    rig.infuse(&["import", "spoilt.csv", "--source", "diary"]).ok();
    let text = rig.infuse(&["status"]).ok();
    assert!(
        text.contains("an experiment of `diary: page 3` at a 4 mm, b 6 mm") && text.contains("--withdraw"),
        "{text}"
    );
}

#[test]
fn noise_that_repeats_contradict_is_said() {
    let rig = rig_of(|a, b| wells(a, b, DEPTHS), "noise = 0\n");
    let rows: String = (0..8).map(|k| format!("4,7,{:.3}\n", 95.0 + wobble(k))).collect();
    rig.write("old.csv", &format!("a [mm],b [mm],y [N]\n{rows}"));
    rig.infuse(&["import", "old.csv", "--source", "repeats"]).ok();
    let text = rig.infuse(&["status"]).ok();
    assert!(
        text.contains(
            "Careful: `noise` in [loop] is 0 N, but 7 repeats of 1 design scatter by 0.663 N (standard deviation)."
        ) && text.contains("is too sure: take `noise` out, and it is learnt, or give what was measured."),
        "{text}"
    );
    assert!(text.find("Careful") < text.find("Recommended"), "before anything that sounds good: {text}");
    let said =
        "Noise of one run: 0 N (standard deviation), as `noise` in [loop] says. Repeats contradict that: 0.663 N.";
    assert!(text.contains(said), "{text}");
    assert!(!text.contains("Nothing was run twice"), "{text}");
    for (noise, is_wrong) in [("0.8", false), ("0.01", true), ("50", true)] {
        let now = rig.read("campaign.toml");
        let line = now.lines().find(|line| line.starts_with("noise")).unwrap().to_owned();
        rig.edit(&line, &format!("noise = {noise}"));
        let text = rig.infuse(&["status"]).ok();
        assert_eq!(text.contains("Careful: `noise` in [loop]"), is_wrong, "{noise}: {text}");
        assert_eq!(rig.status()["noise"]["is_contradicted"], json!(is_wrong), "{noise}");
        let is_too_large = text.contains("Bands and bounds are wider than they need be");
        assert_eq!(is_too_large, noise == "50", "{noise}: {text}");
    }
}

/// A file that gives the noise as none, and a rig whose further runs of an experiment, and those that confirm, scatter.
#[test]
fn noise_of_zero_is_contradicted_by_the_first_run_that_is_made_again() {
    let rig = rig_of(|a, b| wells(a, b, DEPTHS), "noise = 0\n");
    batch(&rig, |a, b, _| Ok(wells(a, b, DEPTHS)));
    let (text, noise) = (rig.infuse(&["status"]).ok(), rig.status()["noise"].clone());
    assert!(!text.contains("Careful: `noise`"), "nothing has put it to the test: {text}");
    assert_eq!((&noise["of_repeats"], &noise["is_contradicted"]), (&Value::Null, &json!(false)));
    let first = rig.journal().into_iter().find(|line| line["event"] == json!("told")).expect("a result");
    let (id, value) = (first["id"].to_string(), first["value"].as_f64().expect("a value"));
    rig.infuse(&["tell", "--id", &id, "--value", &format!("{value}"), "--again"]).ok();
    assert!(!rig.infuse(&["status"]).ok().contains("Careful: `noise`"), "the same again is no noise");
    rig.infuse(&["tell", "--id", &id, "--value", &format!("{}", value + 3.0), "--again"]).ok();
    let text = rig.infuse(&["status"]).ok();
    let said = "Careful: `noise` in [loop] is 0 N, but 2 repeats of 1 design scatter by 1.732 N (standard deviation).";
    assert!(text.contains(said), "{text}");
    assert!((rig.status()["noise"]["of_repeats"].as_f64().expect("repeats") - 3_f64.sqrt()).abs() < 1e-9);
}

#[test]
fn noise_of_a_constraint_that_repeats_contradict_is_said_too() {
    let rig = rig_of(|a, b| a + b, "[[constraint]]\nname = \"travel\"\nunit = \"mm\"\nupper = 12\nnoise = 0.01\n");
    let row = |k: u32| format!("{},{},{},{}\n", k % 5, k / 5, k, 5.0 + wobble(u64::from(k)));
    let again = |k: u64| format!("4,4,8,{}\n", 6.0 + wobble(k));
    let rows: String = (0..10).map(row).chain((0..4).map(again)).collect();
    rig.write("old.csv", &format!("a [mm],b [mm],y [N],travel [mm]\n{rows}"));
    rig.infuse(&["import", "old.csv", "--source", "notebook"]).ok();
    let text = rig.infuse(&["status"]).ok();
    let said = "Careful: `noise` in [[constraint]] `travel` is 0.01 mm, but 3 repeats of 1 design scatter by";
    assert!(text.contains(said), "{text}");
    rig.edit("noise = 0.01", "noise = 1");
    assert!(!rig.infuse(&["status"]).ok().contains("Careful: `noise`"));
}

#[test]
fn a_dead_sensor_and_nothing_but_failures_are_said() {
    let rig = rig_of(|a, b| wells(a, b, DEPTHS), "");
    batch(&rig, |_, _, _| Ok(3.0));
    let text = rig.infuse(&["status"]).ok();
    assert!(text.contains("Careful: all 10 results are 3 N: nothing can be learnt from them."), "{text}");
    let rig = rig_of(|a, b| wells(a, b, DEPTHS), "");
    batch(&rig, |_, _, _| Err("no signal".to_owned()));
    let text = rig.infuse(&["status"]).ok();
    assert!(text.contains("Careful: not one of 10 runs gave a value; the first one: no signal."), "{text}");
    let text = rig.infuse(&["ask"]).ok();
    assert!(text.contains("No experiment gave a value yet, so it is spread over what was not tried."), "{text}");
}

#[test]
fn nothing_but_failures_before_the_campaign_is_said_too() {
    let rig = rig_of(|a, b| wells(a, b, DEPTHS), "");
    rig.write("old.csv", "a [mm],b [mm],y [N],failed\n6,11,,it leaked\n2,3,,it leaked\n");
    rig.infuse(&["import", "old.csv", "--source", "notebook"]).ok();
    let text = rig.infuse(&["status"]).ok();
    assert!(text.contains("Careful: not one of 2 runs gave a value; the first one: it leaked."), "{text}");
    batch(&rig, |_, _, id| if id == 1 { Ok(3.0) } else { Err("no signal".to_owned()) });
    let text = rig.infuse(&["status"]).ok();
    assert!(!text.contains("Careful: not one of"), "{text}");
}

/// Repeats that are all equal do not make the noise known, and no worth is reached or missed by such results.
#[test]
fn equal_results_tell_neither_the_noise_nor_whether_to_go_on() {
    let rig = rig_of(|a, b| wells(a, b, DEPTHS), "noise = 1\n[stop]\nworth = 2\n");
    for _ in 0..2 {
        batch(&rig, |_, _, _| Ok(3.0));
    }
    let text = rig.infuse(&["status"]).ok();
    assert_eq!(rig.status()["stage"], json!("ready"), "no bound on equal results is a reason to stop: {text}");
    assert!(
        text.contains("All results are equal: whether to go on, they cannot tell.")
            && !text.contains("go on;")
            && !text.contains("probability no design is better"),
        "{text}"
    );
    rig.edit("noise = 1\n", "");
    rig.write("old.csv", "a [mm],b [mm],y [N]\n4,7,3\n4,7,3\n4,7,3\n4,7,3\n4,7,3\n4,7,3\n");
    rig.infuse(&["import", "old.csv", "--source", "repeats"]).ok();
    let text = rig.infuse(&["status"]).ok();
    assert!(text.contains("by the surface; it is not known, the 7 repeats do not differ at all."), "{text}");
}

/// Whether repeats are few or equal: what they don't tell is said in the same words.
#[test]
fn noise_that_repeats_do_not_tell_is_said_not_to_be_known() {
    for (repeats, words) in [
        ("4,7,3\n4,7,3\n", "it is not known, the one repeat does not differ at all."),
        ("4,7,3\n4,7,3\n4,7,3\n", "it is not known, the 2 repeats do not differ at all."),
        (
            "4,7,3\n4,7,3\n4,7,3\n4,7,3\n",
            "taken for none, as the 3 repeats do not differ at all, until one does. If that may be chance, give `noise` in [loop].",
        ),
        (
            "4,7,3.0000001\n4,7,3.0000001\n",
            "taken for none, as the one repeat does not differ at all, until one does. If that may be chance, give `noise` in [loop].",
        ),
        ("4,7,3\n4,7,3.1\n", "it is not known, one repeat is too few."),
        ("4,7,3\n4,7,3.1\n4,7,2.9\n", "it is not known, 2 repeats are too few."),
        ("4,7,3\n3,3,7\n1,2,11\n", "it is not known, nothing was run twice."),
    ] {
        let rig = rig_of(|a, b| wells(a, b, DEPTHS), "");
        rig.write("old.csv", &format!("a [mm],b [mm],y [N]\n6,11,9\n2,3,8\n8,14,30\n{repeats}"));
        rig.infuse(&["import", "old.csv", "--source", "notebook"]).ok();
        let text = rig.infuse(&["status"]).ok();
        assert!(text.contains("Noise of one run: ") && text.contains(words), "{words}: {text}");
    }
}

/// One result a batch, and a `worth` that any bound would meet: nothing is promised before there are six results.
#[test]
fn too_few_results_promise_nothing_and_end_nothing() {
    let rig = rig_of(|a, b| wells(a, b, DEPTHS), "[stop]\nworth = 1e6\nsmooth = true\n");
    let file =
        rig.read("campaign.toml").replace("experiments = 10", "experiments = 1").replace("batches = 5", "batches = 7");
    rig.write("campaign.toml", &file);
    for n in 1..=6_usize {
        assert_eq!(ask(&rig)["experiments"].as_array().unwrap().len(), 1, "{n}");
        rig.infuse(&["tell", "--id", &n.to_string(), "--value", &(7 + n % 2).to_string()]).ok();
        let (text, log) = (rig.infuse(&["status"]).ok(), rig.infuse(&["log"]).ok());
        let is_said = text.contains(&format!("cannot be said before there are 6 results: {n} so far. Go on."));
        assert_eq!(is_said, n < 6, "{text}");
        let results = if n == 1 { "one result".to_owned() } else { format!("{n} results") };
        assert_eq!(text.contains(&format!("how far off that may be, {results} cannot tell.")), n < 6, "{text}");
        assert_eq!(text.contains("expected, give or take "), n == 6, "{text}");
        assert_eq!(log.matches("by how much others may be better cannot be said yet").count(), n.min(5), "{log}");
        let status = rig.status();
        assert_eq!([status["bound"].is_null(), status["needed"] == json!({ "readings": 6 })], [n < 6; 2], "{status}");
        rig.infuse(&["report"]).ok();
    }
}

/// Ten results that may be noise alone promise nothing, whatever another batch has to be worth.
#[test]
fn results_that_may_be_noise_alone_promise_nothing() {
    let rig = rig_of(|a, b| wells(a, b, DEPTHS), "[stop]\nworth = 1e6\n");
    let n = ask(&rig)["experiments"].as_array().unwrap().len();
    for id in 1..=n {
        let off = [0.3, -1.1, 0.6, 0.2, -0.4, 1.4, -0.7, -0.1, 0.9, -1.2][id % 10];
        rig.infuse(&["tell", "--id", &id.to_string(), "--value", &(7.0 + 0.1 * off).to_string()]).ok();
    }
    let (text, status) = (rig.infuse(&["status"]).ok(), rig.status());
    let said = "cannot be said before results tell of the parameters: these may be noise alone. Go on.";
    assert!(text.contains(said), "{text}");
    assert_eq!((status["bound"].is_null(), &status["needed"]), (true, &json!("signal")), "{status}");
}

/// Two of 24 settings are far off, and were run once; eight runs of another differ by 0.1.
#[test]
fn repeats_that_scatter_less_than_what_the_surface_calls_noise_are_said() {
    let told = |step: f64| {
        let rig = rig_of(|a, b| wells(a, b, DEPTHS), "");
        let rows = (0..31).map(|run| {
            let (site, second) = (if run < 24 { run } else { 12 }, f64::from(run % 2));
            let (a, b) = (site % 6 + 2, site / 6 * 4 + 1);
            let off = if site == 8 || site == 15 { step } else { 0.0 };
            format!("{a},{b},{}\n", 50.0 + 2.0 * f64::from(a) + f64::from(b) + off + 0.1 * second)
        });
        rig.write("old.csv", &format!("a [mm],b [mm],y [N]\n{}", rows.collect::<String>()));
        rig.infuse(&["import", "old.csv", "--source", "notebook"]).ok();
        let text = rig.infuse(&["status"]).ok();
        text.lines().find(|line| line.starts_with("Noise of one run: ")).expect(&text).to_owned()
    };
    let rough = told(8.0);
    assert!(rough.contains("by the surface, though the 7 repeats say 0.05"), "{rough}");
    let smooth = told(0.0);
    assert!(smooth.ends_with("from 7 repeats and what the surface leaves."), "{smooth}");
}

/// Runs of the same settings that agree are named once, by these, with how many they are and what they measured.
#[test]
fn settings_that_are_far_off_whenever_they_are_run_are_named_once() {
    let bowl = |a: f64, b: f64| 100.0 + 2.0 * (a - 4.0).powi(2) + 0.5 * (b - 7.0).powi(2);
    let rig = rig_of(bowl, "");
    for _ in 0..3 {
        batch(&rig, |a, b, id| Ok(bowl(a, b) + 0.2 * wobble(id)));
    }
    rig.write("old.csv", "a [mm],b [mm],y [N]\n7,13,60.1\n7,13,60.3\n7,13,60.2\n");
    rig.infuse(&["import", "old.csv", "--source", "notebook"]).ok();
    let text = rig.infuse(&["status"]).ok();
    let line = text.lines().find(|line| line.starts_with("Seen more than once")).expect(&text);
    assert_eq!(line.matches("a 7 mm, b 13 mm (3 runs, mean 60.2 N, ").count(), 1, "{line}");
    assert!(line.contains(" standard deviations below)") && !line.contains("notebook"), "{line}");
}

/// A run at the settings of an earlier batch is one more repeat, and the sheet says of what.
#[test]
fn runs_at_settings_of_an_earlier_batch_are_called_repeats() {
    let rig = rig_of(|a, b| wells(a, b, DEPTHS), "");
    batch(&rig, measure);
    let first = best(&rig);
    let asked: Value = serde_json::from_str(&rig.infuse(&["confirm", "--runs", "1", "--json"]).ok()).unwrap();
    let runs = asked["experiments"].as_array().unwrap();
    let there = |run: &Value| run["settings"] == json!({ "a": first.0, "b": first.1 });
    let log = rig.read("sheet-1.csv");
    for run in runs.iter().filter(|run| there(run)) {
        let earlier = run["repeats"].as_u64();
        let line =
            log.lines().find(|line| line.contains(&format!(",{},,{},{},", earlier.unwrap_or(0), first.0, first.1)));
        assert_eq!(earlier.is_some(), line.is_some(), "{run}\n{log}");
    }
    assert!(runs.iter().any(|run| run["repeats"].is_u64()), "the best measured was run before: {asked}");
}

#[test]
fn who_goes_on_without_a_simulation_is_asked_once() {
    let rig = Rig::pooled();
    let broken = "command = [\"sh\", \"-c\", \"echo no license for {spring} {damper gain} >&2; exit 3\"]";
    rig.edit("table = \"simulation.csv\"", broken);
    rig.edit("experiments = 10", "experiments = 4\nsimulations = 5");
    let error = rig.infuse(&["ask"]).error();
    assert!(error.contains("simulations failed"), "{error}");
    tell(&rig, anyway(&rig).as_array().unwrap(), measure);
    assert!(rig.infuse(&["ask"]).ok().contains("Batch 2"));
}

fn anyway(rig: &Rig) -> Value {
    let asked: Value = serde_json::from_str(&rig.infuse(&["ask", "--anyway", "--json"]).ok()).unwrap();
    asked["experiments"].clone()
}

#[test]
fn of_dear_simulations_the_best_so_far_is_not_called_the_choice_of_all() {
    let rig = Rig::pooled();
    rig.edit("table = \"simulation.csv\"", "command = [\"echo\", \"{spring}{damper gain}\"]");
    rig.edit("experiments = 10", "experiments = 4\nsimulations = 5");
    tell(&rig, ask(&rig)["experiments"].as_array().unwrap(), |a, b, _| Ok(a * b));
    let text = rig.infuse(&["status"]).ok();
    assert!(text.contains("designs simulated so far, the simulation alone would choose"), "{text}");
}

/// The same campaign far from zero ends where it ends near zero, and its differences are shown.
#[test]
fn an_offset_changes_nothing_but_the_numbers() {
    let run = |offset: f64| {
        let rig = rig_of(|a, b| wells(a, b, DEPTHS) + offset, "");
        for _ in 0..3 {
            batch(&rig, |a, b, id| Ok(measure(a, b, id)? + offset));
        }
        (best(&rig), rig.infuse(&["status"]).ok())
    };
    let (near, _) = run(0.0);
    for offset in [1e8, 1e12] {
        let (far, text) = run(offset);
        assert_eq!(near, far, "{text}");
        let best = wells(near.0, near.1, DEPTHS).round();
        assert!(text.contains(&format!("{}", offset + best)), "{best} {text}");
    }
}

/// A batch is told in thousandths of the unit, and one in thousands of it; a batch that is ten times as large may be true.
#[test]
fn a_batch_in_another_unit_is_said() {
    for (factor, words) in
        [(1000.0, Some("times larger than any before: are they in N?")), (0.001, Some("times smaller")), (10.0, None)]
    {
        let rig = rig_of(|a, b| wells(a, b, DEPTHS), "");
        batch(&rig, |a, b, id| Ok(100.0 + a + b + 0.1 * wobble(id)));
        batch(&rig, |a, b, id| Ok(factor * (100.0 + a + b + 0.1 * wobble(id))));
        let text = rig.infuse(&["status"]).ok();
        match words {
            Some(words) => assert!(
                text.contains("Careful: all 10 results of batch 2 are at least ") && text.contains(words),
                "{text}"
            ),
            None => assert!(!text.contains("are they in N?"), "{text}"),
        }
    }
}

/// All batches are made, and the certificate would do: what is in the way of another is `batches`.
#[test]
fn what_is_in_the_way_of_another_batch_is_named() {
    let rig = rig_of(|a, b| 20.0 + a + b, "[stop]\nworth = 1e6\nsmooth = true\n");
    let file = rig.read("campaign.toml").replace("batches = 5", "batches = 1");
    rig.write("campaign.toml", &file);
    batch(&rig, |a, b, id| Ok(10.0 + 3.0 * a + 2.0 * b + 0.05 * wobble(id)));
    assert!(rig.infuse(&["ask"]).ok().starts_with("Ended: "));
    let error = rig.infuse(&["ask", "--anyway"]).error();
    assert!(error.contains("--anyway: all 1 batch that `batches` in [loop] allows are made; raise it"), "{error}");
    rig.edit("batches = 1", "batches = 2");
    assert!(rig.infuse(&["ask", "--anyway"]).ok().starts_with("Batch 2"));
}

/// Two foams that differ by less than their noise, twelve runs of which say by how much one may be better: by Student, not by what a
/// surface between names would be unsure of.
#[test]
fn of_two_choices_the_bound_is_that_of_their_runs() {
    let rig = rig_of(|a, b| a + b, "");
    rig.write(
        "campaign.toml",
        "title = \"Foams\"\nseed = 1\n[[parameter]]\nname = \"foam\"\nchoices = [\"hard\", \"soft\"]\n[response]\nname = \"y\"\n\
         unit = \"N\"\ngoal = \"maximize\"\n[loop]\nexperiments = 4\nbatches = 5\n",
    );
    let (mut runs, mut bounds) = ([Vec::new(), Vec::new()], Vec::new());
    for _ in 0..5 {
        let asked = ask(&rig);
        for experiment in asked["experiments"].as_array().unwrap() {
            let (id, is_hard) = (experiment["id"].as_u64().unwrap(), experiment["settings"]["foam"] == "hard");
            let value = 400.0 + if is_hard { 1.0 } else { 0.0 } + 5.0 * wobble(id);
            runs[usize::from(is_hard)].push(value);
            rig.infuse(&["tell", "--id", &id.to_string(), "--value", &value.to_string()]).ok();
        }
        bounds.push(rig.status()["bound"].as_f64());
    }
    assert_eq!(bounds[0], None, "four results are too few");
    let mean = |runs: &[f64]| runs.iter().sum::<f64>() / runs.len() as f64;
    let squares = |runs: &Vec<f64>| runs.iter().map(|value| (value - mean(runs)).powi(2)).sum::<f64>();
    let deviation = (runs.iter().map(squares).sum::<f64>() / 18.0).sqrt();
    let error = deviation * (1.0 / runs[0].len() as f64 + 1.0 / runs[1].len() as f64).sqrt();
    // scipy: stats.t.ppf(0.9, 18) = 1.3304. The recommended one may be the one whose mean is lower.
    let apart = (mean(&runs[1]) - mean(&runs[0])).abs();
    let last = bounds[4].unwrap();
    assert!([-apart, apart].iter().any(|by| (last - (by + 1.3304 * error)).abs() < 0.01 * deviation), "{bounds:?}");
    let text = rig.infuse(&["status"]).ok();
    assert!(!text.contains("narrow"), "every design was run: {text}");
}

/// A bound that nothing was measured of says nothing for or against a design: the one with the best response stays recommended.
#[test]
fn a_constraint_that_was_never_measured_does_not_move_what_is_recommended() {
    let rig = rig_of(|a, b| 20.0 + a + b, "");
    batch(&rig, |a, b, id| Ok(10.0 + (a - 5.0).powi(2) + (b - 9.0).powi(2) + 0.05 * wobble(id)));
    let before = best(&rig);
    let file = rig.read("campaign.toml");
    rig.write("campaign.toml", &format!("{file}\n[[constraint]]\nname = \"t\"\nunit = \"mm\"\nupper = 3\n"));
    assert_eq!(best(&rig), before);
    assert!(rig.infuse(&["status"]).ok().contains("Careful: no design is known to keep to what is asked for"));
}
