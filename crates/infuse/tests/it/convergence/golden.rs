//! Factors and bounds against the laws run on exact fractions (`fixtures/infuse/corrections.json`).

use std::fs;

use infuse::{
    convergence::{Amplification, Bound},
    correction::{Gain, Law, ModelStage, Rule},
};
use serde_json::Value;

const FIXTURE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/infuse/corrections.json");

/// Relative to the largest factor: both sides round what is exact.
const TOLERANCE: f64 = 1e-13;

fn fixture() -> Value {
    serde_json::from_str(&fs::read_to_string(FIXTURE).unwrap()).unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|number| number.as_f64().unwrap()).collect()
}

fn rule_of(case: &Value) -> Rule {
    let law: Law = serde_json::from_value(case["law"].clone()).unwrap();
    let gain = match case["gain"].as_str().unwrap() {
        "harmonic" => Gain::harmonic(),
        fraction => {
            let mut parts = fraction.split('/').map(|part| part.parse::<f64>().unwrap());
            Gain::constant(parts.next().unwrap() / parts.next().unwrap_or(1.0)).unwrap()
        }
    };
    Rule::new(law, gain)
}

#[track_caller]
fn check(what: &str, case: &Value, found: &[f64], expected: &[f64]) {
    let place = format!("{what} of {} with gain {}, n = {}", case["law"], case["gain"], case["n"]);
    assert_eq!(found.len(), expected.len(), "{place}");
    let scale = expected.iter().fold(1.0, |largest: f64, value| largest.max(value.abs()));
    for (found_one, expected_one) in found.iter().zip(expected) {
        assert!((found_one - expected_one).abs() <= TOLERANCE * scale, "{place}: {found:?}, exact {expected:?}");
    }
}

fn listed(amplification: Amplification) -> [f64; 3] {
    [amplification.gap, amplification.simulation, amplification.experiment]
}

const STAGES: [(&str, ModelStage); 2] = [("corrected", ModelStage::Corrected), ("onset", ModelStage::Onset)];

#[test]
fn factors_and_bounds_match_the_laws_run_on_fractions() {
    let fixture = fixture();
    let inputs = &fixture["inputs"];
    let gap = inputs["gap"].as_f64().unwrap();
    let (e1, e2) = (numbers(&inputs["simulation_bounds"]), numbers(&inputs["experiment_bounds"]));
    let cases = fixture["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 3 * 8 * 9, "laws, gains, rounds");
    for case in cases {
        let (rule, n) = (rule_of(case), usize::try_from(case["n"].as_u64().unwrap()).unwrap());
        let correction = rule.correction(n);
        check("correction", case, &correction.experiment, &numbers(&case["correction"]["experiment"]));
        check("correction", case, &correction.simulation, &numbers(&case["correction"]["simulation"]));
        for (name, stage) in STAGES {
            let expected = &case[name];
            let model = rule.model(stage, n);
            check(name, case, &model.experiment, &numbers(&expected["model"]["experiment"]));
            check(name, case, &model.simulation, &numbers(&expected["model"]["simulation"]));
            let bound = Bound::new(rule, stage);
            check(name, case, &listed(bound.after(n)), &numbers(&expected["amplification"]));
            let finite = bound.finite(gap, &e1[..model.simulation.len()], &e2[..n]).unwrap();
            check(name, case, &[finite], &[expected["bound"].as_f64().unwrap()]);
        }
    }
}

#[test]
fn bounds_after_many_rounds_match_the_laws_run_with_fifty_digits() {
    let fixture = fixture();
    let far = fixture["far"].as_array().unwrap();
    assert_eq!(far.len(), 2 * 8, "laws that converge, gains");
    for case in far {
        let n = usize::try_from(case["n"].as_u64().unwrap()).unwrap();
        for (name, stage) in STAGES {
            let bound = Bound::new(rule_of(case), stage);
            check(name, case, &listed(bound.after(n)), &numbers(&case[name]));
        }
    }
}
