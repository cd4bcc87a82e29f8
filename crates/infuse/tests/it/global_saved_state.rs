//! A saved campaign goes on bit for bit, or is refused.

use infuse::{Outcome, global};
use proptest::prelude::*;
use serde_json::{Value, json};

use crate::global_problems::{asked, experiment, grid, planar, save, settings, simulation};

fn load(text: &str) -> global::Loop {
    serde_json::from_str(text).unwrap()
}

/// An awkward rig: some trials fail, one is set elsewhere.
fn answer(campaign: &mut global::Loop, trial: &global::Trial) {
    let value = Outcome::Value(experiment(trial) / 3.0);
    let result = match trial.id.number() {
        4 => campaign.tell(trial.id, Outcome::Failed { reason: "ballast lost".to_owned() }),
        7 => campaign.tell_at(trial.id, &[trial.point[0] - 0.0123, trial.point[1] + 0.2], value),
        _ => campaign.tell(trial.id, value),
    };
    result.unwrap();
}

fn small(seed: u64) -> global::Loop {
    let mut settings = settings(design_space::Model::quadratic(2).unwrap(), 8, 10);
    settings.seed = seed;
    settings.max_batches = 3;
    global::Loop::new(&grid(&[10, 9]), settings).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(6))]
    #[test]
    fn saving_and_loading_at_every_point_changes_no_bit(seed in any::<u64>()) {
        let mut kept = small(seed);
        let mut restored = small(seed);
        while let global::Ask::Trials(trials) = kept.ask(&mut simulation).unwrap() {
            restored = load(&save(&restored));
            prop_assert_eq!(asked(restored.ask(&mut simulation).unwrap()), trials.clone());
            for trial in trials.iter().rev() {
                restored = load(&save(&restored));
                answer(&mut kept, trial);
                answer(&mut restored, trial);
                prop_assert_eq!(save(&restored), save(&kept));
                prop_assert_eq!(restored.retained(), kept.retained());
            }
        }
        prop_assert_eq!(kept.reports().len(), 3);
    }

    #[test]
    fn the_order_of_telling_does_not_matter(seed in any::<u64>(), order in any::<u64>()) {
        let mut forward = small(seed);
        let mut shuffled = small(seed);
        while let global::Ask::Trials(trials) = forward.ask(&mut simulation).unwrap() {
            let mut others = asked(shuffled.ask(&mut simulation).unwrap());
            prop_assert_eq!(&trials, &others);
            others.sort_by_key(|trial| (trial.id.number() ^ order).wrapping_mul(0x9E37_79B9_7F4A_7C15));
            trials.iter().for_each(|trial| answer(&mut forward, trial));
            others.iter().for_each(|trial| answer(&mut shuffled, trial));
        }
        prop_assert_eq!(save(&forward), save(&shuffled));
    }
}

/// A careful campaign is told of experiments from outside, at cells of the batch that is open, and forgets them again: what each trial is used
/// for was chosen before, and the file is read.
#[test]
fn a_careful_campaign_that_was_told_of_earlier_experiments_is_read() {
    for index in 0..8 {
        let mut settings = settings(design_space::Model::quadratic(2).unwrap(), 8, 10);
        (settings.careful, settings.max_batches) = (true, 2);
        let mut campaign = global::Loop::new(&grid(&[10, 9]), settings).unwrap();
        let trials = asked(campaign.ask(&mut simulation).unwrap());
        campaign.add_earlier(&trials[index].point, 1.0, "last year").unwrap();
        assert_eq!(save(&load(&save(&campaign))), save(&campaign), "{index}: open");
        trials.iter().for_each(|trial| answer(&mut campaign, trial));
        assert_eq!(save(&load(&save(&campaign))), save(&campaign), "{index}: closed");
        for trial in asked(campaign.ask(&mut simulation).unwrap()) {
            campaign.withdraw_earlier("last year");
            answer(&mut campaign, &trial);
            assert_eq!(save(&load(&save(&campaign))), save(&campaign), "{index}: withdrawn");
        }
    }
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let campaign = || {
        let (region, mut settings) = planar();
        settings.design_starts = 4;
        settings.max_batches = 3;
        settings.candidate_limit = Some(1000);
        let mut campaign = global::Loop::new(&region, settings).unwrap();
        campaign.run(&mut simulation, &mut |trial| Ok(experiment(trial))).unwrap();
        save(&campaign)
    };
    let with = |n| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap().install(campaign);
    let one = with(1);
    assert_eq!(with(2), one);
    assert_eq!(with(5), one);
}

/// One closed batch and one open with two trials told.
fn in_the_middle() -> global::Loop {
    let mut campaign = small(3);
    for trial in asked(campaign.ask(&mut simulation).unwrap()) {
        answer(&mut campaign, &trial);
    }
    for trial in &asked(campaign.ask(&mut simulation).unwrap())[..2] {
        answer(&mut campaign, trial);
    }
    campaign
}

#[track_caller]
fn check_refused(pointer: &str, value: Value, message: &str) {
    let mut state = serde_json::to_value(in_the_middle()).unwrap();
    *state.pointer_mut(pointer).expect("the field is there") = value;
    let error = serde_json::from_str::<global::Loop>(&state.to_string()).unwrap_err();
    assert!(error.to_string().contains(message), "{pointer}: {error}");
}

#[test]
fn a_state_that_was_tampered_with_is_refused() {
    check_refused("/format", json!(2), "format 2, expected 1");
    check_refused("/region/parameters/0/lower", json!(25.0), "is above the upper bound");
    check_refused("/region/parameters/0/lower", json!(9.0), "`trials.trial.point` of turn 1 is [10.0, ");
    check_refused("/region/parameters/1/levels", json!("continuous"), "`p1`");
    check_refused("/settings/confidence", json!(0.95), "`screening.threshold` of turn 1 is 1.28");
    check_refused("/settings/experiment_weight", json!(0.6), "`screening.optimum");
    check_refused("/settings/correction/gain", json!({"constant": 0.4}), "`changes.model`");
    check_refused("/settings/split", json!("alternating_from_mean"), "`trials.trial.used_for`");
    check_refused("/settings/n_experiments", json!(9), "as many experiments and simulations");
    check_refused("/settings/n_experiments", json!(3), "`n_experiments` is 3");
    check_refused("/history/0/number", json!(2), "`number` of turn 1 is 2, found 1");
    check_refused("/history/0/batch/n_candidates", json!(3), "`batch.n_candidates` of turn 1 is 3, found 90");
    check_refused("/history/0/batch/constant_instead", json!(true), "`batch.constant_instead`");
    check_refused("/history/0/batch/experiment_efficiency", json!(99.0), "`batch.experiment_efficiency` of turn 1");
    check_refused("/history/0/simulations/0/outcome", json!({"value": 1.0}), "of turn 1 is");
    check_refused("/history/0/simulations/0/point", json!([11.0, 12.0]), "`simulations.point`");
    check_refused("/history/0/simulations/0/cell", json!(90), "a cell that was left");
    check_refused("/history/0/trials/0/outcome", json!({"value": 9.0}), "of turn 1 is");
    check_refused("/history/0/trials/0/outcome", json!(null), "an outcome for each of its trials");
    check_refused("/history/0/trials/0/trial/id", json!(9), "`trials.trial.id`");
    check_refused("/history/0/trials/0/trial/point/0", json!(11.1), "`trials.trial.point`");
    check_refused("/history/0/trials/0/actual", json!([12.0, 17.0]), "`p1` is 17.0");
    check_refused("/history/0/screening/optimum_cell", json!(5), "`screening.optimum_cell` of turn 1 is 5");
    check_refused("/history/0/screening/n_after", json!(5), "`screening.n_after` of turn 1 is 5");
    check_refused("/history/0/screening/spread/estimated/n_validation", json!(9), "`screening.spread.n_validation`");
    check_refused("/history/0/screening/spread", json!({"undefined": {"because": "zero"}}), "`screening.spread`");
    check_refused("/history/0/changes/gap", json!(null), "`changes.gap` of turn 1 is None");
    check_refused("/history/0/not_corrected", json!("no"), "`not_corrected`");
    check_refused("/failed_cells", json!([1]), "`failed_cells`");
    check_refused("/open/trials/7/actual", json!([12.0, 12.0]), "nothing while the trial is outstanding");
    check_refused("/open/trials/7/trial/cell", json!(90), "a cell that was left");
    check_refused("/open/trials", json!([]), "as many experiments and simulations");
}

/// Two closed batches.
fn of_two_batches() -> global::Loop {
    let mut campaign = small(3);
    for _ in 0..2 {
        for trial in asked(campaign.ask(&mut simulation).unwrap()) {
            answer(&mut campaign, &trial);
        }
    }
    campaign
}

/// What was computed comes from factorizations, which round differently with other instruction sets.
#[test]
fn numbers_that_follow_may_differ_by_rounding_and_not_by_more() {
    let campaign = of_two_batches();
    let state = serde_json::to_value(&campaign).unwrap();
    for (pointer, field) in [
        ("/history/0/batch/experiment_efficiency", "`batch.experiment_efficiency`"),
        ("/history/1/batch/simulation_efficiency", "`batch.simulation_efficiency`"),
        ("/history/0/screening/optimum_value", "`screening.optimum_value`"),
        ("/history/0/screening/spread/estimated/s", "`screening.spread.s`"),
        ("/history/1/screening/threshold", "`screening.threshold`"),
        ("/history/0/changes/gap", "`changes.gap`"),
        ("/history/0/changes/innovation", "`changes.innovation`"),
        ("/history/1/changes/model", "`changes.model`"),
        ("/history/1/changes/experiment", "`changes.experiment`"),
    ] {
        let with = |factor: f64| {
            let mut state = state.clone();
            let value = state.pointer_mut(pointer).expect("the field is there");
            *value = json!(value.as_f64().expect("a number") * factor);
            serde_json::from_str::<global::Loop>(&state.to_string())
        };
        for slight in [1.0 - 1e-12, 1.0 + 1e-12] {
            let read = with(slight).unwrap_or_else(|error| panic!("{pointer}: {error}"));
            assert!(read == campaign, "{pointer}: what was found stays");
            assert_eq!(read.retained(), campaign.retained());
        }
        let error = with(1.0 + 1e-4).unwrap_err().to_string();
        assert!(error.contains(field) && error.contains(", found "), "{pointer}: {error}");
    }
}

#[test]
fn the_seed_may_be_changed_and_counts_from_the_next_batch_on() {
    let campaign = of_two_batches();
    let mut state = serde_json::to_value(&campaign).unwrap();
    state["settings"]["seed"] = json!(77);
    let read = load(&state.to_string());
    assert_eq!(read.reports(), campaign.reports());
    assert_eq!(read.settings().seed, 77);
}

#[test]
fn unknown_keys_are_refused_everywhere() {
    for pointer in [
        "",
        "/region",
        "/settings",
        "/settings/surfaces",
        "/settings/correction",
        "/history/0",
        "/history/0/batch",
        "/history/0/simulations/0",
        "/history/0/trials/0",
        "/history/0/trials/0/trial",
        "/history/0/screening",
        "/history/0/changes",
        "/open",
    ] {
        let mut state = serde_json::to_value(in_the_middle()).unwrap();
        let map = state.pointer_mut(pointer).and_then(Value::as_object_mut).unwrap();
        map.insert("surprise".to_owned(), json!(1));
        let error = serde_json::from_str::<global::Loop>(&state.to_string()).unwrap_err();
        assert!(error.to_string().contains("unknown field `surprise`"), "{pointer}: {error}");
    }
}

/// The same with the names that fields had when batches were called iterations.
fn as_named_before(text: &str) -> String {
    let mut state: Value = serde_json::from_str(text).unwrap();
    let rename = |value: &mut Value, now: &str, before: &str| {
        let map = value.as_object_mut().unwrap();
        let field = map.remove(now).unwrap();
        map.insert(before.to_owned(), field);
    };
    rename(&mut state["settings"], "max_batches", "max_iterations");
    for report in state["history"].as_array_mut().unwrap() {
        rename(report, "number", "iteration");
        report["trials"]
            .as_array_mut()
            .unwrap()
            .iter_mut()
            .for_each(|one| rename(&mut one["trial"], "batch", "iteration"));
    }
    for record in state["open"]["trials"].as_array_mut().unwrap() {
        rename(&mut record["trial"], "batch", "iteration");
    }
    state.to_string()
}

#[test]
fn a_state_that_was_saved_when_batches_were_called_iterations_is_read() {
    let campaign = in_the_middle();
    let before = as_named_before(&save(&campaign));
    assert_eq!(before.matches("iteration").count(), 1 + 1 + 8 + 8, "{before}");
    assert_eq!(save(&load(&before)), save(&campaign));
    let limit: infuse::global::StopReason = serde_json::from_str("\"iteration_limit\"").unwrap();
    assert_eq!(limit, infuse::global::StopReason::BatchLimit);
}

#[test]
fn one_batch_too_many_is_refused_and_the_limit_may_be_raised() {
    let mut campaign = small(1);
    campaign.run(&mut simulation, &mut |trial| Ok(experiment(trial))).unwrap();
    assert_eq!(campaign.stop(), Some(infuse::global::StopReason::BatchLimit));
    let mut state = serde_json::to_value(&campaign).unwrap();
    state["settings"]["max_batches"] = json!(4);
    let mut longer = load(&state.to_string());
    assert_eq!(longer.stop(), None);
    assert_eq!(asked(longer.ask(&mut simulation).unwrap()).len(), 8);
    let mut ended = small(1);
    ended.run(&mut simulation, &mut |_| Err("no water".to_owned())).unwrap();
    let mut state = serde_json::to_value(&ended).unwrap();
    let history = state["history"].as_array_mut().unwrap();
    history.push(history[0].clone());
    let error = serde_json::from_str::<global::Loop>(&state.to_string()).unwrap_err();
    assert!(error.to_string().contains("none after the campaign had ended"), "{error}");
}

/// What a campaign in a file and the journal of one are compared by.
#[test]
fn campaigns_with_other_settings_are_not_equal() {
    let (region, settings) = planar();
    let of = |settings: &global::Settings| global::Loop::new(&region, settings.clone()).unwrap();
    let mut others = settings.clone();
    others.seed += 1;
    assert_eq!(of(&settings), of(&settings));
    assert_ne!(of(&settings), of(&others));
}

#[test]
fn numbers_agree_to_a_billionth_of_the_scale_or_of_themselves() {
    assert!(global::agrees(1.0 + 0.9e-9, 1.0, 0.0) && !global::agrees(1.0 + 1.1e-9, 1.0, 0.0));
    assert!(global::agrees(0.9e-7, 0.0, 100.0) && !global::agrees(1.1e-7, 0.0, 100.0));
    assert!(global::agrees(f64::NAN, f64::NAN, 1.0) && global::agrees(f64::INFINITY, f64::INFINITY, 1.0));
    assert!(!global::agrees(f64::NAN, 1.0, 1.0) && !global::agrees(f64::INFINITY, f64::NEG_INFINITY, 1.0));
}
