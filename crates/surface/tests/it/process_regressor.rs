//! How well a regressor explains responses, against dense algebra with 40 digits.

use ::serde::Deserialize;
use surface::process::RegressorEvidence;
use surface::{Data, Error};

use crate::check_close;

#[derive(Deserialize)]
struct Fixture {
    cases: Vec<Case>,
}

#[derive(Clone, Deserialize)]
struct Case {
    points: Vec<Vec<f64>>,
    values: Vec<f64>,
    regressors: Vec<Vec<f64>>,
    log_likelihoods: Vec<f64>,
    unknown: Vec<f64>,
    log_likelihoods_in_part: Vec<f64>,
}

impl Case {
    fn evidence(&self) -> RegressorEvidence {
        let data = Data::new(self.points[0].len(), self.points.concat(), self.values.clone()).expect("valid data");
        RegressorEvidence::of(&data).expect("two points or more")
    }
}

fn cases() -> Vec<Case> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/surface/regressor.json");
    let text = std::fs::read_to_string(path).expect("the fixture is there");
    serde_json::from_str::<Fixture>(&text).expect("the fixture has the expected form").cases
}

#[test]
fn likelihood_is_that_of_dense_algebra() {
    for case in cases() {
        let evidence = case.evidence();
        for (regressor, expected) in case.regressors.iter().zip(&case.log_likelihoods) {
            let found = evidence.log_likelihood(regressor).expect("one value per response");
            check_close(found, *expected, 1e-9 * (1.0 + expected.abs()), "log likelihood");
        }
    }
}

/// A part of each regressor is missing at a third of the points.
#[test]
fn likelihood_with_unknown_parts_is_that_of_dense_algebra() {
    for case in cases() {
        let evidence = case.evidence();
        for (regressor, expected) in case.regressors.iter().zip(&case.log_likelihoods_in_part) {
            let found = evidence.log_likelihood_in_part(regressor, &case.unknown).expect("one value per response");
            check_close(found, *expected, 1e-7 * (1.0 + expected.abs()), "log likelihood");
        }
        let known = vec![0.0; case.values.len()];
        let found = evidence.log_likelihood_in_part(&case.regressors[0], &known).unwrap();
        assert_eq!(found.to_bits(), evidence.log_likelihood(&case.regressors[0]).unwrap().to_bits(), "all is known");
    }
}

/// Repeats lack the same, however large it is.
#[test]
fn repeats_lack_the_same() {
    let data = Data::new(1, vec![0.2, 0.2, 0.2, -0.6, 0.9], vec![1.0, 1.1, 0.9, 3.0, -2.0]).unwrap();
    let evidence = RegressorEvidence::of(&data).unwrap();
    let found = [1.0, 30.0].map(|unknown| {
        evidence.log_likelihood_in_part(&[0.3, 0.3, 0.3, 1.0, -1.0], &[unknown, unknown, unknown, 0.0, 0.0]).unwrap()
    });
    // One value that may be anything costs its logarithm, not three times that.
    check_close(found[0] - found[1], 30.0_f64.ln(), 0.8, "cost");
}

/// The responses were drawn with the first; of two points any will do.
#[test]
fn what_explains_the_responses_is_most_likely() {
    for case in cases().iter().filter(|case| case.values.len() > 2) {
        let found = case.regressors.iter().map(|regressor| case.evidence().log_likelihood(regressor).unwrap());
        let found: Vec<f64> = found.collect();
        assert!(found[0] > found[1] + 3.0 && found[0] > found[2] + 3.0, "{found:?}");
    }
}

/// A constant added to the responses, and their unit, say nothing of the regressor.
#[test]
fn neither_a_constant_nor_the_unit_of_the_responses_matters() {
    let case = &cases()[2];
    let other = Case {
        points: case.points.clone(),
        values: case.values.iter().map(|value| 1e3 * value - 4e3).collect(),
        regressors: Vec::new(),
        log_likelihoods: Vec::new(),
        unknown: Vec::new(),
        log_likelihoods_in_part: Vec::new(),
    };
    let gain = |case: &Case, by: usize| {
        let of = |regressor: &[f64]| case.evidence().log_likelihood(regressor).unwrap();
        of(&cases()[2].regressors[0]) - of(&cases()[2].regressors[by])
    };
    for by in [1, 2] {
        check_close(gain(&other, by), gain(case, by), 1e-8, "gain");
    }
}

#[test]
fn errors_say_what_was_allowed() {
    let one = Data::new(1, vec![0.5], vec![2.0]).unwrap();
    let error = RegressorEvidence::of(&one).unwrap_err();
    assert_eq!(error, Error::Count { name: "points", found: 1, least: 2, most: usize::MAX });
    let error = cases()[1].evidence().log_likelihood(&[1.0]).unwrap_err();
    assert_eq!(error, Error::Length { name: "values", expected: 5, found: 1 });
    // Responses that do not differ: one regressor is as good as another, by what it costs.
    let same = Data::new(1, vec![-1.0, 0.0, 1.0], vec![2.0; 3]).unwrap();
    let evidence = RegressorEvidence::of(&same).unwrap();
    assert!(evidence.log_likelihood(&[1.0, -2.0, 1.0]).unwrap().is_finite());
}

/// As if it had never been there: shown where the response that is left out is the mean of the others, so that the mean stays what it was.
#[test]
fn likelihoods_without_each_are_those_of_all_others() {
    for case in cases().into_iter().filter(|case| case.values.len() > 2) {
        let n = case.values.len();
        for left_out in 0..n {
            let of_others = |all: &[f64]| -> Vec<f64> {
                all.iter().enumerate().filter(|(place, _)| *place != left_out).map(|(_, value)| *value).collect()
            };
            let others = of_others(&case.values);
            let mut values = case.values.clone();
            values[left_out] = others.iter().sum::<f64>() / others.len() as f64;
            let all = Case { values, ..case.clone() };
            let mut points = case.points.clone();
            points.remove(left_out);
            let fewer = Case { points, values: others, ..case.clone() };
            let [all, fewer] = [all.evidence(), fewer.evidence()];
            for regressor in &case.regressors {
                let found = all.log_likelihoods_without_each(regressor, &case.unknown).expect("one value per response");
                let expected =
                    fewer.log_likelihood_in_part(&of_others(regressor), &of_others(&case.unknown)).expect("as many");
                check_close(found[left_out], expected, 1e-7 * (1.0 + expected.abs()), "log likelihood without one");
            }
        }
    }
}
