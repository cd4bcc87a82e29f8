//! A rig that drifts from batch to batch: what is said of single results, and of the noise.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use crate::pooled::{ask, batch, rig_of, tell, wobble};
use crate::rig::Rig;

/// Lowest at (4, 9), where it is 50.
fn bowl(a: f64, b: f64) -> f64 {
    50.0 + (a - 4.0).powi(2) + (b - 9.0).powi(2)
}

/// A campaign without a simulation, after batches that read so much more than they should.
fn drifted(shifts: &[f64], more: &str) -> Rig {
    let rig = rig_of(bowl, more);
    rig.edit("[simulator]\ntable = \"simulation.csv\"\n", "");
    for shift in shifts {
        assert!(batch(&rig, |a, b, id| Ok(bowl(a, b) + wobble(id) + shift)), "a batch of the campaign");
    }
    rig
}

/// The mean of what was told of each design, each result less the shift of its batch as `status` has it.
fn means_without_shifts(rig: &Rig, status: &Value) -> BTreeMap<(u64, u64), f64> {
    let shifts: Vec<f64> = status["shifts"].as_array().unwrap().iter().map(|one| one["by"].as_f64().unwrap()).collect();
    let sheets = (1..=shifts.len()).map(|batch| rig.read(&format!("sheet-{batch}.csv"))).collect::<Vec<_>>();
    let told = crate::rig::told(&rig.journal());
    let mut all: BTreeMap<(u64, u64), Vec<f64>> = BTreeMap::new();
    for (sheet, shift) in sheets.iter().zip(shifts) {
        for cells in sheet.lines().skip(1).map(|row| row.split(',').collect::<Vec<_>>()) {
            let settings = (cells[3].parse().unwrap(), cells[4].parse().unwrap());
            all.entry(settings).or_default().push(told[&cells[1].parse().unwrap()] - shift);
        }
    }
    all.into_iter().map(|(settings, all)| (settings, all.iter().sum::<f64>() / all.len() as f64)).collect()
}

/// The third batch reads 12 too low, and so has the lowest numbers: the design that measured best is not taken from it for that.
#[test]
fn the_best_measured_design_is_chosen_without_the_shifts_of_batches() {
    let rig = drifted(&[0.0, 12.0, -12.0], "");
    let status = rig.status();
    let best = &status["best_measured"];
    let at = |of: &Value| (of["a"].as_f64().unwrap() as u64, of["b"].as_f64().unwrap() as u64);
    let means = means_without_shifts(&rig, &status);
    let (expected, least) = means.iter().min_by(|a, b| a.1.total_cmp(b.1)).expect("a design was run");
    assert_eq!(&at(&best["settings"]), expected, "the least mean by hand: {means:?}\n{status}");
    assert!((best["value_without_shift"].as_f64().unwrap() - least).abs() < 1e-6, "{least} by hand: {best}");
    let lowest = crate::rig::told(&rig.journal()).into_values().fold(f64::INFINITY, f64::min);
    assert!(
        lowest < 45.0 && best["value"].as_f64() > Some(lowest),
        "what is lowest is of the batch that reads low: {best}"
    );
    let (a, b) = at(&best["settings"]);
    assert!(bowl(a as f64, b as f64) < 53.0, "it is one of the best of the rig: {best}");
    let text = rig.infuse(&["status"]).ok();
    let said = text.lines().find(|line| line.contains("Best measured: ")).unwrap_or_else(|| panic!("{text}"));
    assert!(said.contains(", which read") && said.contains(" without that, by which it is chosen."), "{said}");
    // It is what is run to confirm, under its name, unless it is recommended.
    let planned = rig.infuse(&["confirm"]).ok();
    let is_recommended = at(&status["best"]) == (a, b);
    let name = "what had measured best (without the shift of its batch), ";
    assert_eq!(planned.contains(&format!("{name}a {a} mm, b {b} mm.")), !is_recommended, "{planned}");
    rig.infuse(&["undo"]).ok();
    std::fs::remove_file(rig.path("sheet-4.csv")).unwrap();
    rig.infuse(&["report"]).ok();
    let page = rig.read("report.html");
    assert!(page.contains("without shift") && page.contains("measured, less shifts"), "the page says it, too");
    // Wherever results stand as they were read, beside what is expected: tables, curves, fit, and the best of each batch.
    for (words, n) in [
        ("as it was read, with what its batch or source is off by", 3),
        ("as it was read, with what the batch is off by", 2),
    ] {
        assert!(page.matches(words).count() >= n, "{} times: {words}", page.matches(words).count());
    }
    // Where the loop leaves a drift in the surface, results are compared as they are.
    rig.edit("[loop]", "[loop]\nblocks = false");
    let left = rig.status();
    assert!(left["best_measured"]["value_without_shift"].is_null(), "nothing is taken in: {left}");
    let text = rig.infuse(&["status"]).ok();
    assert!(!text.contains("without that, by which it is chosen"), "{text}");
    let still = drifted(&[0.0, 0.0, 0.0], "");
    assert!(still.status()["best_measured"]["value_without_shift"].is_null(), "nothing drifts: {}", still.status());
}

/// One run of the batch that reads low is lower still, by far: how low without the shift stands beside it.
#[test]
fn a_result_that_contradicts_is_said_with_the_shift_of_its_batch() {
    let rig = drifted(&[0.0, 12.0], "");
    assert!(batch(&rig, |a, b, id| Ok(bowl(a, b) + wobble(id) - if id == 28 { 82.0 } else { 12.0 })), "a batch");
    let text = rig.infuse(&["status"]).ok();
    let said = text.lines().find(|line| line.contains("standard errors better")).unwrap_or_else(|| panic!("{text}"));
    assert!(
        said.contains(" N, in batch 3, which reads ") && said.contains(" N below what is expected of it ("),
        "{said}"
    );
    assert!(said.contains(" N without that), "), "{said}");
}

/// The mean of a batch has in it what the whole batch is off by, and its band says so; the difference of two designs of it does not.
#[test]
fn the_level_that_a_confirming_batch_measures_is_known_no_better_than_the_batch() {
    let rig = drifted(&[0.0, 12.0, -12.0], "");
    let asked: Value = serde_json::from_str(&rig.infuse(&["confirm", "--json"]).ok()).unwrap();
    tell(&rig, asked["experiments"].as_array().unwrap(), |a, b, id| Ok(bowl(a, b) + wobble(id) + 5.0));
    let status = rig.status();
    let designs = status["confirmed"]["designs"].as_array().unwrap().clone();
    let shared = status["shared_error_of_a_batch"].as_f64().unwrap();
    for design in &designs {
        let half = design["mean_give_or_take"].as_f64().unwrap();
        assert!(half > 1.6 * shared, "{half} is less than the error of a batch, {shared}, allows");
    }
    let text = rig.infuse(&["status"]).ok();
    let said = text.lines().filter(|line| line.starts_with("  what ") && line.contains(" N, give or take ")).count();
    assert_eq!(said, designs.len(), "each mean has its band: {text}");
    assert!(text.contains("is what all runs of a batch share: "), "{text}");
    if let Some(half) = designs.get(1).and_then(|design| design["give_or_take"].as_f64()) {
        assert!(half < shared, "both are of one batch: {half}");
        assert!(text.contains("In the bands of the means, and not in those of the differences, is "), "{text}");
    }
    // Left in the surface it is in the level all the same.
    rig.edit("[loop]", "[loop]\nblocks = false");
    let left = rig.status()["confirmed"]["designs"][0]["mean_give_or_take"].as_f64().unwrap();
    assert!(left > shared, "{left}");
}

/// What the file says is put to the results, too; and where it forbids to take a drift in, one noise is said.
#[test]
fn whether_results_speak_for_a_drift_is_said_where_the_file_says_so() {
    let rig = drifted(&[0.0], "blocks = true\n");
    let said = |words: &str| {
        let text = rig.infuse(&["status"]).ok();
        assert!(text.contains(words), "{words} is not in {text}");
    };
    said("Whether there is one, results tell from two batches, or sources, of several designs on.");
    for shift in [12.0, -12.0] {
        assert!(batch(&rig, |a, b, id| Ok(bowl(a, b) + wobble(id) + shift)), "a batch");
    }
    said("By themselves, too, the results are sure of it.");
    let still = drifted(&[0.0, 0.0, 0.0], "blocks = true\n").infuse(&["status"]).ok();
    assert!(still.contains("By themselves the results do not speak for it."), "{still}");
    rig.edit("blocks = true", "blocks = false");
    let noise = rig.status()["noise"]["standard_deviation"].as_f64().unwrap();
    let text = rig.infuse(&["status"]).ok();
    let of_one_run = |before: &str| -> f64 {
        let rest = text.split(before).nth(1).unwrap_or_else(|| panic!("{before} is not in {text}"));
        rest.split(' ').next().and_then(|number| number.parse().ok()).unwrap_or_else(|| panic!("{rest}"))
    };
    let beside_the_drift = of_one_run("the noise of one run is about ");
    assert!((beside_the_drift / noise - 1.0).abs() < 1e-3, "{beside_the_drift} and {noise}");
    assert!(text.contains(" N, with that in it. Does the rig drift"), "{text}");
    assert!(text.contains("leaves it so: bands and bounds are narrower than they should be"), "{text}");
    assert_eq!(rig.status()["drift"]["is_taken_in"], json!(false), "{}", rig.status());
}

/// Equal repeats of one batch are no proof that there is no noise, as those of other batches differ: that is the reason that is said.
#[test]
fn on_a_rig_that_drifts_equal_repeats_do_not_make_the_noise_none_and_it_is_said_why() {
    let rig = rig_of(bowl, "");
    rig.edit("[simulator]\ntable = \"simulation.csv\"\n", "");
    for shift in [0.0, 12.0, -12.0, 4.0] {
        assert!(batch(&rig, |a, b, _| Ok(bowl(a, b) + shift)), "a batch");
    }
    let text = rig.infuse(&["status"]).ok();
    let said = "do not differ at all, but runs of one design in different batches do, and only where none differ the noise is taken for none.";
    assert!(text.contains("it is not known. Within a batch the ") && text.contains(said), "{text}");
    rig.edit("[loop]", "[loop]\nnoise = 0\nblocks = true");
    let text = rig.infuse(&["status"]).ok();
    assert!(text.contains("Noise of one run: 0 N (standard deviation), as `noise` in [loop] says."), "{text}");
    assert_eq!(rig.status()["noise"]["is_contradicted"], json!(false), "{text}");
    assert!(text.contains("By themselves, too, the results are sure of it."), "{text}");
    assert!(ask(&rig)["experiments"].is_array(), "it goes on");
}

/// Runs of one design on two days that are off by different amounts say nothing of the noise: that is said, and not that there are none.
#[test]
fn a_given_noise_is_tested_by_repeats_within_a_batch_alone() {
    let rig = rig_of(bowl, "noise = 1\nblocks = true\n");
    rig.edit("[simulator]\ntable = \"simulation.csv\"\n", "");
    let row = |at: u64, day: &str, shift: f64| {
        let (a, b) = ((at % 4) as f64 * 2.0 + 1.0, (at / 4) as f64 * 3.0 + 1.0);
        format!("{a},{b},{:.3},{day}\n", bowl(a, b) + wobble(100 + at) + shift)
    };
    let monday: String = (0..9).map(|at| row(at, "monday", 0.0)).collect();
    let of_noise = || {
        let text = rig.infuse(&["status"]).ok();
        text.lines().find(|line| line.starts_with("Noise of one run: ")).unwrap_or_else(|| panic!("{text}")).to_owned()
    };
    rig.write("old.csv", &format!("a [mm],b [mm],y [N],source\n{monday}"));
    rig.infuse(&["import", "old.csv"]).ok();
    assert!(of_noise().contains(" Nothing was run twice, so nothing has put it to the test."), "{}", of_noise());
    // One design of them again.
    let tuesday: String = (8..17).map(|at| row(at, "tuesday", 12.0)).collect();
    rig.write("old.csv", &format!("a [mm],b [mm],y [N],source\n{tuesday}"));
    rig.infuse(&["import", "old.csv"]).ok();
    assert_eq!(rig.status()["noise"]["degrees_of_freedom"], json!(0), "the one repeat is of another day");
    let said = " No design was run twice within a batch or source, and runs of two of these differ by what they are off by, so nothing has put";
    assert!(of_noise().contains(said), "{}", of_noise());
    let twice = row(16, "tuesday", 12.9);
    rig.write("old.csv", &format!("a [mm],b [mm],y [N],source\n{twice}"));
    rig.infuse(&["import", "old.csv"]).ok();
    assert_eq!(rig.status()["noise"]["degrees_of_freedom"], json!(1), "of one day");
    assert!(!of_noise().contains("put it to the test"), "{}", of_noise());
}

/// The numbers of a finding and of what belongs to it, by their names.
fn numbers(finding: &Value) -> BTreeMap<String, f64> {
    let own = finding["numbers"].as_array().cloned().unwrap_or_default();
    let own = own.into_iter().filter_map(|one| Some((one["name"].as_str()?.to_owned(), one["value"].as_f64()?)));
    let details = finding["details"].as_array().cloned().unwrap_or_default();
    own.chain(details.iter().flat_map(numbers).collect::<Vec<_>>()).collect()
}

/// Whatever the file says of a drift, `--json` has it, and each finding by how much each batch is off; the log says when it was found.
#[test]
fn json_and_log_have_a_drift_whatever_the_file_says() {
    for blocks in ["", "blocks = true\n", "blocks = false\n"] {
        let rig = drifted(&[0.0, 12.0, -12.0], blocks);
        let status = rig.status();
        assert_eq!(status["drift"]["is_sure"], json!(true), "{blocks}: {status}");
        assert_eq!(status["drift"]["is_taken_in"], json!(blocks != "blocks = false\n"), "{blocks}");
        let findings = status["findings"].as_array().unwrap().clone();
        let of_each = findings.iter().map(numbers).find(|numbers| numbers.contains_key("batch 1 above"));
        let of_each = of_each.unwrap_or_else(|| panic!("{blocks}: no finding has the shifts: {status}"));
        for (at, shift) in status["shifts"].as_array().unwrap().iter().enumerate() {
            let by = of_each[&format!("batch {} above", at + 1)];
            assert!((by - shift["by"].as_f64().unwrap()).abs() < 1e-9, "{blocks}: {shift} and {by}");
        }
        let log = rig.infuse(&["log"]).ok();
        assert!(log.contains(": `y` drifts, runs of one batch read alike."), "{blocks}: {log}");
    }
}

/// What was imported reads 15 higher, and is withdrawn: that is why nothing drifts any more, and no single result.
#[test]
fn a_drift_that_went_with_what_was_withdrawn_is_said_to() {
    let rig = rig_of(bowl, "");
    rig.edit("[simulator]\ntable = \"simulation.csv\"\n", "");
    let row = |at: u64| {
        let (a, b) = ((at % 4) as f64 * 2.0 + 1.0, (at / 4) as f64 * 5.0 + 2.0);
        format!("{a},{b},{:.3}\n", bowl(a, b) + wobble(100 + at) + 15.0)
    };
    rig.write("old.csv", &format!("a [mm],b [mm],y [N]\n{}", (0..12).map(row).collect::<String>()));
    rig.infuse(&["import", "old.csv", "--source", "notebook"]).ok();
    assert!(batch(&rig, |a, b, id| Ok(bowl(a, b) + wobble(id))), "a batch");
    assert_eq!(rig.status()["drift"]["is_sure"], json!(true), "{}", rig.status());
    rig.infuse(&["import", "--withdraw", "notebook"]).ok();
    let text = rig.infuse(&["status"]).ok();
    let said = "Since then what had been imported was withdrawn, 12 experiments of `notebook`. `blocks = true` in [loop] keeps it.";
    assert!(text.contains("after batch 1 the results were sure that runs of one batch read alike in `y`"), "{text}");
    assert!(text.contains(said) && !text.contains("One result far"), "{text}");
    if let Some(risen) = text.lines().find(|line| line.contains("It has risen: ")) {
        assert!(risen.contains("results are not sure any more that runs of one batch read alike in `y`"), "{risen}");
    }
    let log = rig.infuse(&["log"]).ok();
    assert!(log.contains("12 experiments that had been imported from `notebook`."), "{log}");
}

/// The bound is larger once a drift is taken in: that is why, and not what results differ by.
#[test]
fn a_bound_that_has_risen_as_a_drift_is_taken_in_is_said_to() {
    let mut n_risen = 0;
    for seed in 1..=4 {
        let rig = rig_of(bowl, "");
        rig.edit("[simulator]\ntable = \"simulation.csv\"\n", "");
        rig.edit("seed = 1", &format!("seed = {seed}"));
        for shift in [0.0, 12.0] {
            batch(&rig, |a, b, id| Ok(bowl(a, b) + wobble(id) + shift));
        }
        let text = rig.infuse(&["status"]).ok();
        let Some(risen) = text.lines().find(|line| line.contains("It has risen: ")) else { continue };
        if rig.status()["drift"]["is_taken_in"] == json!(true) {
            let said = "It has risen: an error that runs of one batch share in `y` is taken in by now, as results are sure of it";
            assert!(risen.contains(said), "seed {seed}: {risen}");
            n_risen += 1;
        }
    }
    assert!(n_risen > 0, "of four campaigns one has a bound that rose with a drift");
}
