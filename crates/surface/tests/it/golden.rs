//! Against statsmodels, scipy and mpmath.

use ::serde::Deserialize;
use doe::{Model, Term};
use surface::{Data, LeaveOneOut, Regression, Surface};

use crate::{check_close, check_list, inverse_distance, squared_exponential};

/// Both sides lose the condition of the regressors, at most 1e5.
const REGRESSION: f64 = 1e-9;
/// Exponents of up to 600 carry 600 times their rounding into a weight.
const AVERAGE: f64 = 1e-12;
/// The gradient of a smooth average cancels to a part of the size of its terms.
const GRADIENT: f64 = 1e-9;

#[derive(Deserialize)]
struct Fixture<T> {
    cases: Vec<T>,
}

fn read<T: for<'a> Deserialize<'a>>(name: &str) -> Vec<T> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/surface/").to_owned() + name;
    let text = std::fs::read_to_string(&path).expect("the fixture is there");
    let fixture: Fixture<T> = serde_json::from_str(&text).expect("the fixture has the expected form");
    fixture.cases
}

fn data(points: &[Vec<f64>], values: &[f64], weights: &[f64]) -> Data {
    let data = Data::new(points[0].len(), points.concat(), values.to_vec());
    data.and_then(|data| data.with_weights(weights.to_vec())).expect("valid data")
}

#[derive(Deserialize)]
struct RegressionCase {
    points: Vec<Vec<f64>>,
    values: Vec<f64>,
    weights: Vec<f64>,
    terms: Vec<Vec<u8>>,
    coefficients: Vec<f64>,
    standard_errors: Vec<f64>,
    covariance: Vec<Vec<f64>>,
    sigma_squared: f64,
    residual_sum_of_squares: f64,
    r_squared: f64,
    adjusted_r_squared: f64,
    has_constant: bool,
    leverages: Vec<f64>,
    leave_one_out: Vec<f64>,
    queries: Vec<Vec<f64>>,
    predictions: Vec<f64>,
    variances: Vec<f64>,
    lack_of_fit: Option<LackOfFit>,
}

#[derive(Deserialize)]
struct LackOfFit {
    pure_error: f64,
    lack_of_fit: f64,
    degrees: [usize; 2],
    f: f64,
    p_value: f64,
}

#[test]
fn regression_matches_statsmodels() {
    let cases: Vec<RegressionCase> = read("regression.json");
    assert_eq!(cases.len(), 30);
    let mut n_tests = 0;
    for case in &cases {
        let terms = case.terms.iter().map(|term| Term::new(term.clone())).collect();
        let model = Model::new(case.points[0].len(), terms).expect("a valid model");
        let data = data(&case.points, &case.values, &case.weights);
        let fit = Regression::fit(&model, &data).expect("the data determine the model");
        check_list(fit.coefficients(), &case.coefficients, REGRESSION, "coefficients");
        let covariance = fit.covariance().expect("degrees of freedom");
        check_list(&covariance, &case.covariance.concat(), REGRESSION, "covariance");
        let errors = fit.standard_errors().expect("degrees of freedom");
        check_list(&errors, &case.standard_errors, REGRESSION, "standard errors");
        let sigma_squared = fit.sigma_squared().expect("degrees of freedom");
        check_list(&[sigma_squared], &[case.sigma_squared], REGRESSION, "sigma squared");
        check_list(&[fit.residual_sum_of_squares()], &[case.residual_sum_of_squares], REGRESSION, "sum of squares");
        check_list(fit.leverages(), &case.leverages, REGRESSION, "leverages");
        let left_out = fit.leave_one_out().expect("no leverage of one");
        check_list(left_out.residuals(), &case.leave_one_out, REGRESSION, "leave one out");
        // statsmodels takes a constant that the terms merely span for one; the crate looks for the term.
        assert_eq!(case.has_constant, model.terms().iter().any(|term| term.degree() == 0));
        check_close(fit.r_squared().expect("variation"), case.r_squared, REGRESSION, "R^2");
        let adjusted = fit.adjusted_r_squared().expect("variation");
        check_close(adjusted, case.adjusted_r_squared, REGRESSION, "adjusted R^2");
        let predictions: Vec<f64> = case.queries.iter().map(|x| fit.predict(x)).collect();
        check_list(&predictions, &case.predictions, REGRESSION, "predictions");
        let variances: Vec<f64> = case.queries.iter().filter_map(|x| fit.variance(x)).collect();
        check_list(&variances, &case.variances, REGRESSION, "variances");
        match (&case.lack_of_fit, fit.lack_of_fit()) {
            (Some(expected), Ok(found)) => {
                n_tests += 1;
                assert_eq!([found.lack_of_fit_degrees, found.pure_error_degrees], expected.degrees);
                check_list(&[found.pure_error], &[expected.pure_error], REGRESSION, "pure error");
                check_list(&[found.lack_of_fit], &[expected.lack_of_fit], 1e-8, "lack of fit, a difference of sums");
                check_list(&[found.f], &[expected.f], 1e-8, "F");
                check_close(found.p_value, expected.p_value, 1e-9, "p value");
            }
            (None, Err(_)) => {}
            (expected, found) => {
                panic!("a test is {}: {found:?}", if expected.is_some() { "missing" } else { "too much" })
            }
        }
    }
    assert!(n_tests > 10, "{n_tests} tests for lack of fit");
}

#[derive(Deserialize)]
struct AveragesCase {
    points: Vec<Vec<f64>>,
    values: Vec<f64>,
    weights: Vec<f64>,
    power: f64,
    scale: f64,
    queries: Vec<Vec<f64>>,
    inverse_distance: Average,
    squared_exponential: Average,
}

#[derive(Deserialize)]
struct Average {
    predictions: Vec<f64>,
    gradients: Vec<Vec<f64>>,
    leave_one_out: Vec<f64>,
}

#[track_caller]
fn check_average(surface: &dyn Surface, left_out: &LeaveOneOut, expected: &Average, queries: &[Vec<f64>]) {
    let estimates: Vec<f64> = queries.iter().map(|x| surface.predict(x)).collect();
    check_list(&estimates, &expected.predictions, AVERAGE, "predictions");
    check_list(left_out.residuals(), &expected.leave_one_out, AVERAGE, "leave one out");
    for (x, expected) in queries.iter().zip(&expected.gradients) {
        let gradient = surface.gradient(x).expect("a gradient off the data");
        for (&found, &expected) in gradient.iter().zip(expected) {
            check_close(found, expected, GRADIENT * expected.abs() + 1e-12, &format!("gradient at {x:?}"));
        }
    }
}

#[test]
fn averages_match_sixty_digits() {
    let cases: Vec<AveragesCase> = read("averages.json");
    assert_eq!(cases.len(), 24);
    for case in &cases {
        let data = data(&case.points, &case.values, &case.weights);
        let surface = inverse_distance(&data, case.power);
        let left_out = surface.leave_one_out().expect("more than one point");
        check_average(&surface, &left_out, &case.inverse_distance, &case.queries);
        let surface = squared_exponential(&data, case.scale);
        let left_out = surface.leave_one_out().expect("more than one point");
        check_average(&surface, &left_out, &case.squared_exponential, &case.queries);
    }
}
