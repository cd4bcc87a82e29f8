//! Against scipy's bounded least squares (`fixtures/infuse/identification.json`).

use design_space::{Parameter, Region};
use infuse::identification::{Answer, Measurements, Noise, RangeEnd, Settings, Unknowns, identify};
use serde::Deserialize;

use super::each;

const FIXTURE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/infuse/identification.json");

#[derive(Deserialize)]
struct Fixture {
    cases: Vec<Case>,
}

#[derive(Deserialize)]
struct Case {
    model: String,
    start: Vec<f64>,
    lower: Vec<f64>,
    upper: Vec<f64>,
    designs: Vec<Vec<f64>>,
    readings: Vec<Vec<f64>>,
    deviations: Vec<Vec<f64>>,
    estimate: Vec<f64>,
    bound: Vec<Option<String>>,
    standard_error: Vec<Option<f64>>,
    sum_of_squares: f64,
    degrees_of_freedom: usize,
    sigma: f64,
    t95: f64,
    p: f64,
    singular_values: Vec<f64>,
}

fn decay(t: &[f64], x: f64) -> Vec<f64> {
    vec![t[0] * (-t[1] * x).exp() + t[2]]
}

fn saturation(t: &[f64], x: f64) -> Vec<f64> {
    let rate = t[0] * x / (t[1] + x);
    vec![rate, x * (-t[2] * rate).exp()]
}

fn oscillation(t: &[f64], x: f64) -> Vec<f64> {
    let stiff = t[0] - t[2] * x * x;
    vec![1.0 / stiff.hypot(t[1] * x), t[1] * x / stiff]
}

#[track_caller]
fn close(found: f64, expected: f64, within: f64, what: &str) {
    assert!((found - expected).abs() <= within, "{what}: {found} is not {expected}");
}

#[test]
fn estimates_and_standard_errors_are_those_of_scipy() {
    let fixture: Fixture = serde_json::from_str(&std::fs::read_to_string(FIXTURE).unwrap()).unwrap();
    assert!(fixture.cases.iter().any(|case| case.bound.iter().any(Option::is_some)), "a case with a bound");
    for (number, case) in fixture.cases.iter().enumerate() {
        for noise in [Noise::Known, Noise::Estimated] {
            check(case, noise, &format!("case {number}, {}", case.model));
        }
    }
}

fn check(case: &Case, noise: Noise, name: &str) {
    let formula = match &*case.model {
        "decay" => decay,
        "saturation" => saturation,
        _ => oscillation,
    };
    let bounds = case.lower.iter().zip(&case.upper).enumerate();
    let parameters = bounds.map(|(j, (l, u))| Parameter::continuous(format!("t{j}"), "", *l, *u).unwrap());
    let unknowns = Unknowns::new(Region::new(parameters.collect()).unwrap(), case.start.clone()).unwrap();
    let names = (0..case.readings[0].len()).map(|k| format!("y{k}")).collect();
    let mut measurements = Measurements::new(names).unwrap();
    for ((design, values), deviations) in case.designs.iter().zip(&case.readings).zip(&case.deviations) {
        measurements.push(design, values, deviations).unwrap();
    }
    let mut settings = Settings::default();
    (settings.noise, settings.difference_step, settings.tolerance) = (noise, 1e-6, 1e-14);
    let mut model = each(|t: &[f64], p: &[f64]| -> Answer { Ok(formula(t, p[0])) });
    let found = identify(&unknowns, &measurements, &settings, &mut model).unwrap();
    let sigma = if noise == Noise::Known { 1.0 } else { case.sigma };
    close(found.sum_of_squares, case.sum_of_squares, 1e-8 * case.sum_of_squares + 1e-12, name);
    assert_eq!(found.degrees_of_freedom, case.degrees_of_freedom, "{name}: {found:#?}");
    assert!(found.undetermined.is_empty(), "{name}: {:?}", found.undetermined);
    for (j, estimate) in found.estimates.iter().enumerate() {
        close(estimate.value, case.estimate[j], 1e-6 * (case.upper[j] - case.lower[j]), &format!("{name}, t{j}"));
        let bound =
            case.bound[j].as_ref().map(|bound| if bound == "lower" { RangeEnd::Lower } else { RangeEnd::Upper });
        assert_eq!(estimate.bound, bound, "{name}, t{j}");
        assert_eq!(estimate.standard_error.is_some(), case.standard_error[j].is_some(), "{name}, t{j}");
        if let (Some(found), Some(expected)) = (estimate.standard_error, case.standard_error[j]) {
            close(found, expected * sigma, 1e-5 * expected * sigma + 1e-9, &format!("{name}, error of t{j}"));
            let quantile = if noise == Noise::Known { 1.959_963_984_540_054 } else { case.t95 };
            let [lower, upper] = estimate.interval(0.95).unwrap().unwrap();
            close(0.5 * (upper - lower), quantile * found, 1e-6 * (found + 1e-9), &format!("{name}, interval of t{j}"));
        }
    }
    for (found, expected) in found.singular_values.iter().zip(&case.singular_values) {
        close(*found, *expected, 1e-5 * expected, &format!("{name}, singular values"));
    }
    if noise == Noise::Known {
        close(found.p_of_misfit().unwrap(), case.p, 1e-6, name);
    }
}
