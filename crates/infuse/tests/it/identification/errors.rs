//! Bad input is refused by name, value and what is allowed.

use design_space::{Parameter, Region};
use infuse::Error;
use infuse::identification::{Answer, Measurements, Noise, Settings, Unknowns, identify};

use super::{each, readings, unknowns};

fn constant(theta: &[f64], _: &[f64]) -> Answer {
    Ok(vec![theta[0]])
}

#[track_caller]
fn says(error: Error, words: &[&str]) {
    let message = error.to_string();
    for word in words {
        assert!(message.contains(word), "`{word}` is not in: {message}");
    }
}

#[test]
fn unknowns_that_cannot_be_are_refused() {
    assert!(Parameter::continuous("a", "m", 2.0, 1.0).is_err(), "upside down");
    let parameter = || Parameter::continuous("a", "m", 1.0, 2.0).unwrap();
    assert!(Region::new(vec![parameter(), parameter()]).is_err(), "two of one name");
    let region = || Region::new(vec![parameter()]).unwrap();
    says(Unknowns::new(region(), vec![3.0]).unwrap_err(), &["`a`", "3.0", "1.0 to 2.0 m"]);
    says(Unknowns::new(region(), vec![f64::NAN]).unwrap_err(), &["`a`", "NaN"]);
    says(Unknowns::new(region(), vec![]).unwrap_err(), &["0", "expected 1"]);
}

#[test]
fn measurements_that_cannot_be_are_refused() {
    says(Measurements::new(vec![]).unwrap_err(), &["at least one response"]);
    says(Measurements::new(vec!["y".into(), "y".into()]).unwrap_err(), &["`y`", "a name of its own"]);
    says(Measurements::new(vec![" ".into()]).unwrap_err(), &["a name for every response"]);
    let mut measurements = readings(&[(0.0, 1.0)], 1.0);
    says(measurements.push(&[1.0, 2.0], &[1.0], &[1.0]).unwrap_err(), &["`design`", "2 entries", "expected 1"]);
    says(measurements.push(&[1.0], &[1.0, 2.0], &[1.0]).unwrap_err(), &["`values`", "2 entries"]);
    says(measurements.push(&[1.0], &[f64::NAN], &[1.0]).unwrap_err(), &["`values`", "NaN", "finite"]);
    says(measurements.push(&[1.0], &[1.0], &[0.0]).unwrap_err(), &["`standard_deviations`", "0.0", "positive"]);
    says(measurements.push(&[f64::INFINITY], &[1.0], &[1.0]).unwrap_err(), &["`design`", "inf"]);
    assert_eq!(measurements.n_experiments(), 1, "what is refused changes nothing");
}

#[test]
fn too_little_is_refused_and_failed_experiments_do_not_count() {
    let theta = unknowns(&[(0.0, 1.0, 0.5), (0.0, 1.0, 0.5)]);
    let mut empty = Measurements::new(vec!["y".into()]).unwrap();
    empty.push_failed();
    let fit = |measurements: &Measurements, settings: &Settings| {
        identify(&theta, measurements, settings, &mut each(constant))
    };
    says(fit(&empty, &Settings::default()).unwrap_err(), &["no measurement", "failed: 1"]);
    let mut settings = Settings::default();
    settings.noise = Noise::Estimated;
    says(fit(&readings(&[(0.0, 1.0), (1.0, 1.0)], 1.0), &settings).unwrap_err(), &["2 readings of 2 unknowns"]);
    let mut some = readings(&[(0.0, 0.3), (1.0, 0.3), (2.0, 0.3)], 1e-3);
    some.push_failed();
    let found = fit(&some, &settings).unwrap();
    assert_eq!((found.n_experiments, found.n_failed_experiments), (3, 1));
    assert!(found.warnings().iter().any(|warning| warning.starts_with("1 experiments had failed")));
}

#[test]
fn settings_that_cannot_be_are_refused() {
    let refuse = |change: fn(&mut Settings), words: &[&str]| {
        let mut settings = Settings::default();
        change(&mut settings);
        says(settings.validate().unwrap_err(), words);
    };
    refuse(|s| s.largest_error = 0.0, &["largest_error", "0.0"]);
    refuse(|s| s.difference_step = f64::NAN, &["difference_step", "NaN", "1e-9 to 0.1"]);
    refuse(|s| s.largest_error = 1.1, &["largest_error", "1.1"]);
    refuse(|s| s.tolerance = 1.0, &["tolerance", "1.0"]);
    refuse(|s| s.tolerance = 0.0, &["tolerance", "0.0"]);
    refuse(|s| s.max_steps = 0, &["max_steps", "at least 1"]);
    let unknown = serde_json::from_str::<Settings>("{\"tolerence\": 0.1}").unwrap_err();
    assert!(unknown.to_string().contains("tolerence"));
}

#[test]
fn models_that_fail_or_answer_in_another_shape_are_named() {
    let theta = unknowns(&[(0.0, 1.0, 0.5)]);
    let some = readings(&[(2.0, 0.3)], 1.0);
    let fit = |model: fn(&[f64], &[f64]) -> Answer| {
        identify(&theta, &some, &Settings::default(), &mut each(model)).unwrap_err()
    };
    says(fit(|_, _| Err("no trim".into())), &["start", "[2.0]", "no trim"]);
    says(fit(|_, _| Ok(vec![f64::NAN])), &["start", "`y`", "NaN"]);
    says(fit(|_, _| Ok(vec![1.0, 2.0])), &["responses of the model", "2 entries", "expected 1"]);
    let none = identify(&theta, &some, &Settings::default(), &mut |_: &[Vec<f64>], _: &[Vec<f64>]| vec![]);
    says(none.unwrap_err(), &["answers of the model", "0 entries"]);
}

#[test]
fn probabilities_are_between_0_and_1() {
    let found = identify(
        &unknowns(&[(0.0, 1.0, 0.5)]),
        &readings(&[(0.0, 0.3)], 0.1),
        &Settings::default(),
        &mut each(constant),
    );
    let found = found.unwrap();
    for probability in [0.0, 1.0] {
        let error = found.estimates[0].interval(probability).unwrap_err();
        says(error, &["probability", &format!("{probability:?}")]);
    }
    // 1.645 standard errors to each side.
    let [lower, upper] = found.estimates[0].interval(0.9).unwrap().unwrap();
    assert!((lower - (0.3 - 0.164_485)).abs() < 1e-5 && (upper - (0.3 + 0.164_485)).abs() < 1e-5);
}
