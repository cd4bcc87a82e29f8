//! A saved campaign goes on as if it had never been put away, or is refused.

use infuse::{Outcome, gradient};
use serde_json::{Value, json};

use crate::problems::{failed, json as save, measured, pair_loop, simulated, trials};

fn load(text: &str) -> gradient::Loop {
    serde_json::from_str(text).unwrap()
}

/// An awkward rig: some trials fail, one is set elsewhere, values have many digits.
fn answer(campaign: &mut gradient::Loop, trial: &gradient::Trial) {
    let cost = measured(&trial.point).unwrap() / 3.0 + 1e-3 * (trial.id.number() as f64).sin();
    let result = match trial.id.number() {
        4 => campaign.tell(trial.id, failed("ballast lost")),
        8 => campaign.tell_at(trial.id, trial.point[0] - 0.0123, Outcome::Value(cost)),
        _ => campaign.tell(trial.id, Outcome::Value(cost)),
    };
    result.unwrap();
}

#[test]
fn saving_and_loading_at_every_point_changes_no_bit() {
    let mut kept = pair_loop();
    let mut restored = pair_loop();
    for _ in 0..4 {
        let gradient::Ask::Trials(asked) = kept.ask(&mut simulated).unwrap() else {
            break;
        };
        restored = load(&save(&restored));
        assert_eq!(restored.ask(&mut simulated).unwrap(), gradient::Ask::Trials(asked.clone()));
        for trial in asked.iter().rev() {
            restored = load(&save(&restored));
            answer(&mut kept, trial);
            answer(&mut restored, trial);
            assert_eq!(save(&restored), save(&kept), "after trial {}", trial.id);
        }
    }
    assert!(kept.reports().len() >= 3, "long enough to mean something");
}

#[test]
fn a_replayed_log_gets_every_ask_bit_for_bit() {
    let mut recorded = pair_loop();
    let mut log = Vec::new();
    recorded
        .run(&mut simulated, &mut |trial| {
            let cost = measured(&trial.point)?;
            log.push((serde_json::to_string(trial).unwrap(), cost));
            Ok(cost)
        })
        .unwrap();
    let mut replayed = pair_loop();
    let mut entries = log.iter();
    while let gradient::Ask::Trials(asked) = replayed.ask(&mut simulated).unwrap() {
        for trial in asked {
            let (text, cost) = entries.next().expect("as many trials as recorded");
            assert_eq!(&serde_json::to_string(&trial).unwrap(), text);
            replayed.tell(trial.id, Outcome::Value(*cost)).unwrap();
        }
    }
    assert!(entries.next().is_none(), "as many trials as recorded");
    assert_eq!(save(&replayed), save(&recorded));
}

/// One closed iteration and one open with two trials told.
fn in_the_middle() -> gradient::Loop {
    let mut campaign = pair_loop();
    for trial in trials(campaign.ask(&mut simulated).unwrap()) {
        answer(&mut campaign, &trial);
    }
    for trial in &trials(campaign.ask(&mut simulated).unwrap())[..2] {
        answer(&mut campaign, trial);
    }
    campaign
}

#[track_caller]
fn check_refused(pointer: &str, value: Value, message: &str) {
    let mut state = serde_json::to_value(in_the_middle()).unwrap();
    *state.pointer_mut(pointer).expect("the field is there") = value;
    let error = serde_json::from_str::<gradient::Loop>(&state.to_string()).unwrap_err();
    assert!(error.to_string().contains(message), "{pointer}: {error}");
}

#[test]
fn a_state_that_was_tampered_with_is_refused() {
    check_refused("/format", json!(2), "format 2, expected 1");
    check_refused("/problem/roles", json!(["plant"]), "`roles` has 1 entries");
    check_refused("/problem/region/parameters/0/lower", json!(5.0), "is above the upper bound");
    check_refused("/settings/trust/0", json!(3.0), "expected 0 < R < 2");
    check_refused("/settings/trust/0", json!(0.4), "follows from its optimum");
    check_refused("/settings/trust", json!([0.5]), "`trust` has 1 entries");
    check_refused("/history/0/numerical/model_cost", json!(null), "invalid type: null");
    check_refused("/history/0/numerical/model_cost", json!(7.0), "its sum with the model cost");
    check_refused("/history/0/numerical/correction_value", json!(0.5), "the correction that was known");
    check_refused("/history/0/numerical/point", json!([0.1]), "coordinates of a point: 1, expected 2");
    check_refused("/history/0/numerical/point/0", json!(2.0), "the value is 2.0, expected -1.0 to 1.0");
    check_refused("/history/0/numerical/point/0", json!(0.1), "handed out around its optimum");
    check_refused("/history/0/numerical/model_gradient", json!([0.0]), "one entry per parameter");
    check_refused("/history/0/numerical/failures", json!([{"point": [], "reason": ""}]), "`failures`");
    check_refused("/history/0/trials/1/outcome", json!({"value": 9.0}), "follows from its optimum");
    check_refused("/history/0/trials/1/outcome", json!(null), "the outcomes of all its trials");
    check_refused("/history/0/trials/1/trial/id", json!(7), "the trials that were handed out");
    check_refused("/history/0/trials/1/trial/point/1", json!(0.0), "the trials that were handed out");
    check_refused("/history/0/trials/0/actual", json!(0.3), "the center varies no parameter");
    check_refused("/history/0/correction/offset", json!(1.0), "follows from its optimum");
    check_refused("/history/0/iteration", json!(2), "follows from its optimum");
    check_refused("/open/trials/4/actual", json!(0.3), "nothing while the trial is outstanding");
    check_refused("/open/trials/4/outcome", json!({"lost": 1.0}), "unknown variant `lost`");
    check_refused("/open/trials", json!([]), "the trials that were handed out");
}

#[test]
fn unknown_and_missing_keys_are_refused_everywhere() {
    for pointer in [
        "",
        "/problem",
        "/problem/region",
        "/problem/region/parameters/0",
        "/settings",
        "/settings/optimizer",
        "/history/0",
        "/history/0/numerical",
        "/history/0/correction",
        "/history/0/trials/0",
        "/history/0/trials/0/trial",
        "/open",
    ] {
        let mut state = serde_json::to_value(in_the_middle()).unwrap();
        let map = state.pointer_mut(pointer).and_then(Value::as_object_mut).unwrap();
        map.insert("surprise".to_owned(), json!(1));
        let error = serde_json::from_str::<gradient::Loop>(&state.to_string()).unwrap_err();
        assert!(error.to_string().contains("unknown field `surprise`"), "{pointer}: {error}");
    }
    let mut state = serde_json::to_value(in_the_middle()).unwrap();
    state.as_object_mut().unwrap().remove("settings");
    let error = serde_json::from_str::<gradient::Loop>(&state.to_string()).unwrap_err();
    assert!(error.to_string().contains("missing field `settings`"), "{error}");
}

#[test]
fn a_number_no_double_can_hold_is_refused() {
    let text = save(&in_the_middle()).replacen("\"trust\":[0.5", "\"trust\":[1e999", 1);
    let error = serde_json::from_str::<gradient::Loop>(&text).unwrap_err();
    assert!(error.to_string().contains("number out of range"), "{error}");
}

#[test]
fn a_closed_iteration_left_open_or_one_too_many_is_refused() {
    let mut campaign = pair_loop();
    campaign.run(&mut simulated, &mut |trial| measured(&trial.point)).unwrap();
    let mut state = serde_json::to_value(&campaign).unwrap();
    let last = state["history"].as_array_mut().unwrap().pop().unwrap();
    state["open"] = json!({"numerical": last["numerical"], "trials": last["trials"]});
    let error = serde_json::from_str::<gradient::Loop>(&state.to_string()).unwrap_err();
    assert!(error.to_string().contains("at least one trial without an outcome"), "{error}");

    let mut state = serde_json::to_value(&campaign).unwrap();
    let history = state["history"].as_array_mut().unwrap();
    history.push(history[0].clone());
    let error = serde_json::from_str::<gradient::Loop>(&state.to_string()).unwrap_err();
    assert!(error.to_string().contains("none after the campaign had ended"), "{error}");
}

#[test]
fn the_limit_on_iterations_may_be_raised_in_the_file() {
    let mut campaign = pair_loop();
    let mut state = serde_json::to_value(&campaign).unwrap();
    state["settings"]["max_iterations"] = json!(1);
    campaign = load(&state.to_string());
    campaign.run(&mut simulated, &mut |trial| measured(&trial.point)).unwrap();
    assert_eq!(campaign.reports().len(), 1);
    let mut state = serde_json::to_value(&campaign).unwrap();
    state["settings"]["max_iterations"] = json!(3);
    let mut longer = load(&state.to_string());
    assert_eq!(longer.stop(), None, "it goes on");
    assert_eq!(trials(longer.ask(&mut simulated).unwrap()).len(), 5);
}
