//! Campaigns of the dissertation's loop on designs that fail, on two wells, and to the last designs left.

use std::collections::BTreeSet;

use serde_json::{Value, json};

use crate::journals::unchecked;
use crate::pooled::{ask, best, rig_of, wells, wobble};
use crate::report_page::page;
use crate::rig::{Rig, told};

const TWICE: &str = "method = \"dissertation\"\nreplicates = 2\n";
const REAL: [f64; 2] = [25.0, 60.0];
const SIMULATED: [f64; 2] = [60.0, 20.0];

/// A valley, and its simulation beside it.
fn valley(a: f64, b: f64) -> f64 {
    10.0 + (a - 4.0).powi(2) + 0.3 * (b - 8.0).powi(2)
}

fn valley_beside(a: f64, b: f64) -> f64 {
    20.0 + (a - 3.0).powi(2) + 0.3 * (b - 6.0).powi(2)
}

fn seeded(simulated: impl Fn(f64, f64) -> f64, more: &str, seed: u64) -> Rig {
    let rig = rig_of(simulated, &format!("{TWICE}{more}"));
    rig.edit("seed = 1", &format!("seed = {seed}"));
    rig
}

fn design(of: &Value) -> (u64, u64) {
    let setting = |name: &str| of[name].as_f64().unwrap() as u64;
    (setting("a"), setting("b"))
}

/// Tells all experiments of a batch at once; those without a value failed.
fn tell_all(rig: &Rig, asked: &Value, mut measure: impl FnMut(f64, f64, u64) -> Option<f64>) -> String {
    let rows = asked["experiments"].as_array().unwrap().iter().map(|experiment| {
        let ((a, b), id) = (design(&experiment["settings"]), experiment["id"].as_u64().unwrap());
        match measure(a as f64, b as f64, id) {
            Some(value) => format!("{id},{value:.4},\n"),
            None => format!("{id},,it fell over\n"),
        }
    });
    rig.write("results.csv", &format!("id,y [N],failed\n{}", rows.collect::<String>()));
    rig.infuse(&["tell", "results.csv"]).ok()
}

/// The designs of the next batch, once they were run; none at the end.
fn run(rig: &Rig, measure: impl FnMut(f64, f64, u64) -> Option<f64>) -> Option<Vec<(u64, u64)>> {
    let asked = ask(rig);
    let experiments = asked["experiments"].as_array()?;
    tell_all(rig, &asked, measure);
    Some(experiments.iter().map(|experiment| design(&experiment["settings"])).collect())
}

/// The number of this name that stands beside the sentence with these words, as a machine reads it.
fn number(status: &Value, words: &str, name: &str) -> Option<f64> {
    fn find<'a>(findings: &'a Value, words: &str) -> Option<&'a Value> {
        findings.as_array()?.iter().find_map(|finding| {
            let is_here = finding["sentence"].as_str()?.contains(words);
            if is_here { Some(finding) } else { find(&finding["details"], words) }
        })
    }
    let numbers = find(&status["findings"], words)?["numbers"].as_array()?;
    numbers.iter().find(|number| number["name"] == name)?["value"].as_f64()
}

#[test]
fn a_new_campaign_asks_for_no_failed_design_again_and_an_old_journal_goes_on_as_it_began() {
    for is_old in [false, true] {
        let rig = rig_of(valley_beside, TWICE);
        let asked = ask(&rig);
        let experiments = asked["experiments"].as_array().unwrap();
        let (first, failing) = (&experiments[0], design(&experiments[1]["settings"]));
        assert_ne!(design(&first["settings"]), failing);
        let measure =
            |a: f64, b: f64, id: u64| (failing != (a as u64, b as u64)).then(|| valley(a, b) + 0.1 * wobble(id));
        tell_all(&rig, &json!({ "experiments": [first] }), measure);
        if is_old {
            let journal = unchecked(&rig.read("journal.jsonl"));
            rig.write("journal.jsonl", &journal.replacen("\"careful\":true,", "", 1));
        }
        tell_all(&rig, &asked, measure);
        let why = rig.infuse(&["status", "--why", &format!("a={},b={}", failing.0, failing.1)]).ok();
        assert_eq!(why.contains("is not asked for again: every run of it failed, in batch 1"), !is_old, "{why}");
        assert_eq!(why.contains("is still among the designs left"), is_old, "{why}");
        assert!(run(&rig, measure).is_some(), "it goes on");
        assert_eq!(rig.journal()[0]["problem"]["loop"]["careful"], if is_old { Value::Null } else { json!(true) });
    }
}

/// Eight settings make a batch with its repeats: as long as so many of those left were not run, half of its runs are at such.
#[track_caller]
fn assert_is_new(designs: &[(u64, u64)], known: &BTreeSet<(u64, u64)>, left: u64) {
    let n_new = designs.iter().filter(|one| !known.contains(*one)).count();
    assert!(left < known.len() as u64 + 8 || n_new >= 5, "{designs:?} after {known:?}");
}

#[test]
fn no_batch_runs_an_earlier_one_again_where_nothing_is_dropped() {
    for seed in 1..=3 {
        let rig = seeded(valley_beside, "drop_from = 9\n", seed);
        let mut known = BTreeSet::new();
        while let Some(designs) = run(&rig, |a, b, id| Some(valley(a, b) + 0.3 * wobble(id))) {
            assert_is_new(&designs, &known, 135);
            known.extend(designs);
        }
        assert!(known.len() > 25, "five batches: {known:?}");
    }
}

/// A quadratic shows no two wells: in 26 of 42 such campaigns it ended at a design as good as the lowest of the table, in all at one
/// as good as what a surface through the simulations has lowest.
#[test]
fn it_ends_at_no_failed_design_and_nowhere_worse_than_a_surface_through_the_simulations() {
    let real = |a, b| wells(a, b, REAL);
    let of = |(a, b): (u64, u64)| real(a as f64, b as f64);
    let mut n_as_good_as_the_table = 0;
    for seed in 1..=5 {
        let rig = seeded(|a, b| wells(a, b, SIMULATED), "[stop]\nworth = 3\n", seed);
        let mut left = 135;
        let (mut gave, mut failed) = (BTreeSet::new(), BTreeSet::new());
        loop {
            let known: BTreeSet<(u64, u64)> = &gave | &failed;
            let ran = run(&rig, |a, b, id| {
                let fails = [2, 5, 8].contains(&id);
                if fails { &mut failed } else { &mut gave }.insert((a as u64, b as u64));
                (!fails).then(|| real(a, b) + wobble(id))
            });
            let Some(designs) = ran else { break };
            assert_is_new(&designs, &known, left);
            left = rig.status()["left"].as_u64().unwrap();
        }
        let (status, only_failed) = (rig.status(), &failed - &gave);
        let found = design(&status["best"]);
        assert!(!only_failed.is_empty() && !only_failed.contains(&found), "seed {seed}: {found:?} failed");
        assert!(of(found) <= of(design(&status["simulation_alone"])), "seed {seed}: {found:?}");
        // The lowest of the table is the wrong well.
        n_as_good_as_the_table += usize::from(of(found) <= of((2, 3)));
    }
    assert!(n_as_good_as_the_table >= 2, "{n_as_good_as_the_table} of 5");
}

/// One run of the first batch reads 400 too low. Said, unless repeats or validation say that such misses are common here.
#[test]
fn a_measurement_that_contradicts_the_recommendation_is_said_until_it_is_put_right() {
    let words = "times S and noise better than that";
    let mut n_said = 0;
    for spoilt in 0..=10 {
        let rig = rig_of(valley_beside, TWICE);
        let measured = |a, b, id| valley(a, b) + 0.3 * wobble(id);
        run(&rig, |a, b, id| Some(measured(a, b, id) - if id == spoilt { 400.0 } else { 0.0 }));
        let (status, text) = (rig.status(), rig.infuse(&["status"]).ok());
        let is_said = text.contains(words);
        let s = number(&status, "predicted", "S").unwrap();
        let noise = status["noise"]["standard_deviation"].as_f64().unwrap();
        assert_eq!(is_said, spoilt > 0 && s.max(noise) < 130.0, "{spoilt}: {text}");
        if is_said {
            n_said += 1;
            assert!(text.contains(&format!("Careful: experiment {spoilt} measured")), "{text}");
            let times = number(&status, words, "better by, in S and noise").unwrap();
            let better = status["predicted"].as_f64().unwrap() - told(&rig.journal())[&spoilt];
            assert!(times > 3.0 && times * s.max(noise) <= better, "{times} times {s} and {noise} in {better}");
            rig.infuse(&["tell", "--id", &spoilt.to_string(), "--value", "30", "--correct"]).ok();
            assert!(!rig.infuse(&["status"]).ok().contains("Careful:"));
        }
    }
    assert!(n_said > 0);
}

#[test]
fn what_a_surface_through_the_simulations_chose_is_not_called_the_choice_of_the_simulation() {
    let rig = rig_of(|a, b| wells(a, b, SIMULATED), TWICE);
    run(&rig, |a, b, id| Some(wells(a, b, REAL) + wobble(id)));
    let (a, b) = design(&rig.status()["simulation_alone"]);
    // The simulation itself knows better ones: this is why.
    assert!(wells(a as f64, b as f64, SIMULATED) > wells(2.0, 3.0, SIMULATED) + 10.0);
    let sentence = format!("A surface through the simulations alone would have chosen a {a} mm, b {b} mm.");
    for text in [rig.infuse(&["status"]).ok(), page(&rig)] {
        assert!(text.contains(&sentence), "{text}");
        for wrong in ["simulation would have chosen", "simulation alone would have chosen"] {
            assert!(!text.contains(wrong), "{text}");
        }
    }
}

#[test]
fn the_guarantee_is_within_what_was_measured_and_averaging_promises_no_more_than_the_noise() {
    let parts = |status: &Value| {
        let gain = |words: &str, name: &str| number(status, words, name).unwrap_or(0.0);
        let noise = gain("by averaging out the noise", "mean gain");
        let other = gain("has its best at another design", "gain at another design");
        if let Some(total) = number(status, "More experiments may still gain", "total gain") {
            let shape = gain("shape", "gain by a better shape");
            assert!((noise + other + shape - total).abs() <= 1e-9 * total, "{noise} {other} {shape} {total}");
        }
        noise
    };
    for seed in 1..=3 {
        let rig = Rig::new();
        rig.edit("seed = 1", &format!("seed = {seed}"));
        while rig.batch() {
            let status = rig.status();
            let values: Vec<f64> = told(&rig.journal()).into_values().collect();
            let (least, most) = values.iter().fold((f64::MAX, f64::MIN), |(a, b), &v| (a.min(v), b.max(v)));
            let guarantee = number(&status, "Guarantee:", "regret").unwrap();
            assert!(guarantee <= most - least, "{guarantee} of {least} to {most}");
            // No run of this rig is off by more than 0.2.
            assert!(parts(&status) <= 0.2, "{status}");
        }
    }
    // Where the surface has the wrong shape, that is not the noise; its standard deviation is 1.
    for seed in 1..=2 {
        let rig = seeded(|a, b| wells(a, b, SIMULATED), "", seed);
        while run(&rig, |a, b, id| Some(wells(a, b, REAL) + wobble(id))).is_some() {
            assert!(parts(&rig.status()) <= 1.0, "{}", rig.status());
        }
    }
}

#[test]
fn a_recommendation_on_a_bound_or_never_run_is_said_to_be_so() {
    let (mut seen, slope) = (BTreeSet::new(), |a: f64, b: f64| 10.0 + 3.0 * a - 2.0 * b);
    for is_well in [false, true] {
        for seed in 1..=3 {
            let rig = seeded(|a, b| if is_well { wells(a, b, SIMULATED) } else { slope(a, b) + a }, "", seed);
            let mut known = BTreeSet::new();
            for _ in 0..2 {
                let real =
                    |a, b, id| if is_well { wells(a, b, REAL) + wobble(id) } else { slope(a, b) + 0.1 * wobble(id) };
                let Some(designs) = run(&rig, |a, b, id| Some(real(a, b, id))) else { break };
                known.extend(designs);
                let text = rig.infuse(&["status"]).ok();
                let (a, b) = best(&rig);
                let on = |name: &str, word: &str| text.contains(&format!("{name} is on its {word} bound, "));
                for (name, at, upper) in [("a", a, 8.0), ("b", b, 14.0)] {
                    assert_eq!((on(name, "lower"), on(name, "upper")), (at <= 0.0, at >= upper), "{text}");
                }
                let was_run = known.contains(&(a as u64, b as u64));
                assert_eq!(text.contains("It was never run"), !was_run, "{text}");
                seen.insert((a <= 0.0 && b >= 14.0, was_run));
            }
        }
    }
    assert!(seen.contains(&(true, true)) && seen.contains(&(false, false)), "{seen:?}");
}

#[test]
fn settings_may_change_until_there_is_a_result_and_are_then_refused_under_their_names() {
    let changes = [
        ("model = \"quadratic\"", "model = \"linear\"", "`loop.model.terms` was \"quadratic\" and is \"linear\""),
        ("experiments = 10", "experiments = 12", "`loop.experiments` was 10 and is 12"),
        ("replicates = 2\n", "replicates = 1\n", "`loop.replicates` was 2 and is 1"),
        ("replicates = 2\n", "", "`loop.replicates` was 2 and is 0"),
        ("batches = 6", "batches = 6\ndrop_from = 3", "`loop.drop_from` was 2 and is 3"),
    ];
    let begun = Rig::new();
    begun.batch();
    let (problem, journal) = (begun.read("campaign.toml"), begun.read("journal.jsonl"));
    for (before, after, words) in changes {
        begun.edit(before, after);
        for command in ["ask", "status"] {
            let error = begun.infuse(&[command]).error();
            assert!(error.contains(&format!("{words}; change it back")), "{error}");
        }
        begun.write("campaign.toml", &problem);
        let rig = Rig::new();
        rig.infuse(&["ask"]).ok();
        rig.edit(before, after);
        std::fs::remove_file(rig.path("sheet-1.csv")).unwrap();
        let asked = ask(&rig);
        let experiments = asked["experiments"].as_array().unwrap();
        let n_repeats = experiments.iter().filter(|one| one["repeats"].is_u64()).count();
        let begun_with =
            rig.journal().into_iter().rfind(|line| line["event"] == "campaign").unwrap()["problem"]["loop"].clone();
        match before.split(' ').next().unwrap() {
            "experiments" => assert_eq!(experiments.len(), 12),
            "replicates" => assert_eq!(n_repeats, after.len().min(1)),
            "model" => assert_eq!(begun_with["model"]["terms"], "linear"),
            _ => assert_eq!(begun_with["first_screening"], 3),
        }
    }
    assert_eq!(begun.read("journal.jsonl"), journal);
    begun.edit("batches = 6", "batches = 9");
    assert!(begun.infuse(&["ask", "--anyway"]).ok().contains("Batch 2: 10 experiments"), "the one that may change");
}

#[test]
fn repeats_follow_their_originals_on_no_sheet_to_the_last_designs_left() {
    let mut n_few = 0;
    for seed in 1..=7 {
        let rig = seeded(valley_beside, "", seed);
        rig.edit("batches = 5", "batches = 8");
        for batch in 1.. {
            if run(&rig, |a, b, id| Some(valley(a, b) + 0.3 * wobble(id))).is_none() {
                break;
            }
            let sheet = rig.read(&format!("sheet-{batch}.csv"));
            let designs: Vec<Vec<&str>> =
                sheet.lines().skip(1).map(|row| row.split(',').skip(3).take(2).collect()).collect();
            n_few += usize::from(designs.iter().collect::<BTreeSet<_>>().len() < 4);
            assert!(designs.windows(2).all(|pair| pair[0] != pair[1]), "seed {seed}: {sheet}");
        }
    }
    assert!(n_few > 5, "{n_few} sheets of three designs or fewer");
}

#[test]
fn nothing_is_said_in_symbols_that_a_reader_has_to_look_up() {
    let rig = rig_of(valley_beside, TWICE);
    let mut said = String::new();
    for _ in 0..3 {
        said += &rig.infuse(&["ask", "--anyway"]).ok();
        let asked = ask(&rig);
        said += &asked.to_string();
        said += &tell_all(&rig, &asked, |a, b, id| Some(valley(a, b) + 0.3 * wobble(id)));
        said += &(rig.infuse(&["status"]).ok() + &rig.status().to_string());
        // The corner was dropped, the best was not.
        said += &(rig.infuse(&["status", "--why", "a=8,b=0"]).ok() + &page(&rig));
    }
    assert!(said.contains("worse than the best by") && said.contains("was dropped by batch 2"));
    for words in ["S √2", "√2", "nnovation"] {
        assert!(!said.contains(words), "{words}");
    }
}
