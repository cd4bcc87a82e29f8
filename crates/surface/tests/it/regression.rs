//! Weighted least squares in closed forms.

use doe::{Model, Term};
use proptest::prelude::*;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use surface::{CoefficientTest, Confounded, Data, Error, Regression, Surface};

use crate::{any_data, check_close, check_list};

fn quadratic(n_factors: usize) -> Model {
    Model::quadratic(n_factors).expect("a valid model")
}

#[test]
fn weighted_mean_is_the_regression_on_a_constant() {
    let model = Model::new(1, vec![Term::new([0])]).expect("a valid model");
    let data =
        Data::new(1, vec![0.0, 1.0, 2.0], vec![1.0, 4.0, 7.0]).and_then(|data| data.with_weights(vec![1.0, 2.0, 3.0]));
    let fit = Regression::fit(&model, &data.expect("valid data")).expect("enough data");
    // Mean 5; residuals -4, -1, 2; Σ w e² = 16 + 2 + 12 = 30; σ² = 15; variance of the mean 15/6.
    check_list(fit.coefficients(), &[5.0], 1e-15, "mean");
    check_list(fit.residuals(), &[-4.0, -1.0, 2.0], 1e-15, "residuals");
    check_close(fit.sigma_squared().expect("two degrees of freedom"), 15.0, 1e-13, "sigma squared");
    check_close(fit.variance(&[0.3]).expect("two degrees of freedom"), 2.5, 1e-14, "variance of the mean");
    check_list(fit.leverages(), &[1.0 / 6.0, 1.0 / 3.0, 0.5], 1e-15, "leverages");
    check_close(fit.r_squared().expect("variation"), 0.0, 1e-15, "a mean explains nothing");
    // A factor in no term has no slope, but must be a number.
    assert_eq!(fit.gradient(&[0.3]), Some(vec![0.0]));
    assert!(fit.predict(&[f64::INFINITY]).is_nan() && fit.predict(&[f64::NAN]).is_nan());
}

#[test]
fn draws_have_the_variance_of_the_prediction() {
    let coordinates = vec![-1.0, -0.6, -0.1, 0.4, 0.7, 1.0];
    let data = Data::new(1, coordinates, vec![3.0, 1.2, 0.7, 1.1, 2.2, 2.9]).expect("valid data");
    let data = data.with_weights(vec![1.0, 2.0, 0.5, 1.0, 3.0, 0.7]).expect("valid weights");
    let fit = Regression::fit(&quadratic(1), &data).expect("enough data");
    let drawn = |z: [f64; 3]| fit.drawn(&z).expect("three terms").expect("degrees of freedom");
    for x in [-0.9, 0.0, 0.35, 1.0] {
        let mean = fit.predict(&[x]);
        check_close(drawn([0.0; 3]).predict(&[x]), mean, 1e-14, "without noise");
        // The variance of a linear function of independent standard normals is the sum of its squared coefficients.
        let units = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let variance: f64 = units.iter().map(|&z| (drawn(z).predict(&[x]) - mean).powi(2)).sum();
        check_close(variance, fit.variance(&[x]).expect("degrees of freedom"), 1e-12, "variance");
    }
    assert!(fit.drawn(&[0.0; 2]).is_err(), "one number per term");
}

#[test]
fn no_degrees_of_freedom_means_no_variance() {
    let data = Data::new(1, vec![-1.0, 0.0, 1.0], vec![3.0, 1.0, 2.0]).expect("valid data");
    let fit = Regression::fit(&quadratic(1), &data).expect("as many data as terms");
    assert_eq!(fit.degrees_of_freedom(), 0);
    assert_eq!((fit.sigma_squared(), fit.covariance(), fit.standard_errors()), (None, None, None));
    assert_eq!((fit.variance(&[0.0]), fit.adjusted_r_squared()), (None, None));
    assert_eq!(fit.drawn(&[0.0; 3]).expect("three terms"), None);
    let nothing = Error::NoDegreesOfFreedom { n_points: 3, n_terms: 3 };
    assert_eq!(fit.coefficient_tests(0.95), Err(nothing.clone()));
    assert_eq!(fit.mean_interval(&[0.0], 0.95), Err(nothing.clone()));
    assert_eq!(fit.observation_interval(&[0.0], 1.0, 0.95), Err(nothing));
    check_list(fit.coefficients(), &[1.0, -0.5, 1.5], 1e-14, "through the points");
}

#[test]
fn constants_of_any_size_leave_nothing_to_explain_whatever_rounding_says() {
    for index in 0..500 {
        let constant = 1e3 * (f64::from(index) * 0.7).sin();
        let points: Vec<f64> = (0..5 + index % 8).map(|at| f64::from(at) / 6.0 - 1.0).collect();
        let values = vec![constant; points.len()];
        let fit =
            Regression::fit(&quadratic(1), &Data::new(1, points, values).expect("valid data")).expect("enough data");
        assert_eq!((fit.r_squared(), fit.adjusted_r_squared()), (None, None), "{constant}");
    }
}

#[test]
fn constant_values_leave_nothing_to_explain() {
    let data = Data::new(1, vec![-1.0, 0.0, 1.0], vec![0.0; 3]).expect("valid data");
    let fit = Regression::fit(&Model::linear(1).expect("a valid model"), &data).expect("enough data");
    assert_eq!((fit.r_squared(), fit.adjusted_r_squared()), (None, None));
}

#[test]
fn confounded_terms_are_dropped_on_request_and_reported() {
    // Two levels of the second factor: its square is the constant. The truth has none of it.
    let points: Vec<f64> = [-1.0, 0.0, 1.0].iter().flat_map(|&x| [x, -1.0, x, 1.0]).collect();
    let values =
        points.chunks_exact(2).map(|x| 1.0 + 2.0 * x[0] - x[1] + 0.5 * x[0] * x[1] + 3.0 * x[0] * x[0]).collect();
    let data = Data::new(2, points, values).expect("valid data");
    assert!(Regression::fit(&quadratic(2), &data).is_err());
    let fit = Regression::fit_with(&quadratic(2), &data, Confounded::Drop).expect("five terms are left");
    assert_eq!(fit.dropped().len(), 1);
    assert_eq!((fit.dropped()[0].term, fit.model().n_terms()), (5, 5));
    check_list(fit.coefficients(), &[1.0, 2.0, -1.0, 0.5, 3.0], 1e-14, "coefficients");
    // With nothing to drop, the request changes nothing.
    let line = Model::linear(2).expect("a valid model");
    let dropped = Regression::fit_with(&line, &data, Confounded::Drop).expect("enough data");
    assert_eq!(dropped.coefficients(), Regression::fit(&line, &data).expect("enough data").coefficients());
    // Fewer points than terms is a case of it too.
    let few = Data::new(1, vec![-1.0, 1.0], vec![1.0, 5.0]).expect("valid data");
    let fit = Regression::fit_with(&quadratic(1), &few, Confounded::Drop).expect("a line is left");
    check_list(fit.coefficients(), &[3.0, 2.0], 1e-14, "the line");
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn polynomial_in_the_model_is_reproduced(
        data in any_data(2, 20, 30),
        b in prop::collection::vec(-3.0..3.0_f64, 6),
        x in prop::collection::vec(-1.0..1.0_f64, 2),
    ) {
        let truth = |x: &[f64]| {
            b[0] + b[1] * x[0] + b[2] * x[1] + b[3] * x[0] * x[1] + b[4] * x[0] * x[0] + b[5] * x[1] * x[1]
        };
        let values = data.points().map(truth).collect();
        let exact = Data::new(2, data.coordinates().to_vec(), values).expect("valid data");
        let exact = exact.with_weights(data.weights().to_vec()).expect("valid weights");
        prop_assume!(exact.n_used() >= 10);
        let fit = Regression::fit(&quadratic(2), &exact).expect("points in general position");
        let scale = 1.0 + b.iter().map(|b| b.abs()).sum::<f64>();
        check_list(fit.coefficients(), &b, 1e-10, "coefficients");
        check_close(fit.predict(&x), truth(&x), 1e-11 * scale, "prediction");
        let slopes = [b[1] + b[3] * x[1] + 2.0 * b[4] * x[0], b[2] + b[3] * x[0] + 2.0 * b[5] * x[1]];
        let gradient = fit.gradient(&x).expect("a polynomial has one");
        for (found, expected) in gradient.iter().zip(slopes) {
            check_close(*found, expected, 1e-10 * scale, "slope");
        }
    }

    #[test]
    fn scaling_the_weights_scales_sigma_squared_and_nothing_else(
        data in any_data(2, 12, 20), exponent in -30..30_i32, x in prop::collection::vec(-1.0..1.0_f64, 2),
    ) {
        prop_assume!(data.n_used() >= 8);
        let factor = 10.0_f64.powi(exponent);
        let weights = data.weights().iter().map(|weight| weight * factor).collect();
        let scaled = data.clone().with_weights(weights).expect("valid weights");
        let fit = |data: &Data| Regression::fit(&quadratic(2), data).expect("points in general position");
        let (plain, scaled) = (fit(&data), fit(&scaled));
        check_list(scaled.coefficients(), plain.coefficients(), 1e-9, "coefficients");
        check_list(&scaled.covariance().expect("freedom"), &plain.covariance().expect("freedom"), 1e-8, "covariance");
        let variance = |fit: &Regression| fit.variance(&x).expect("freedom");
        check_list(&[variance(&scaled)], &[variance(&plain)], 1e-8, "variance");
        let sigma_squared = |fit: &Regression| fit.sigma_squared().expect("freedom");
        check_list(&[sigma_squared(&scaled)], &[factor * sigma_squared(&plain)], 1e-8, "sigma squared");
    }

    #[test]
    fn leverages_sum_to_the_number_of_terms_and_residuals_are_orthogonal(data in any_data(3, 16, 30)) {
        prop_assume!(data.n_used() >= 12);
        let model = quadratic(3);
        let fit = Regression::fit(&model, &data).expect("points in general position");
        check_close(fit.leverages().iter().sum(), 10.0, 1e-10, "sum of the leverages");
        prop_assert!(fit.leverages().iter().all(|h| (0.0..=1.0).contains(h)));
        for term in model.terms() {
            let residuals = data.points().zip(fit.residuals()).zip(data.weights());
            let product: f64 = residuals.map(|((x, e), w)| w * e * term.value(x)).sum();
            check_close(product, 0.0, 1e-9, "weighted residuals times a term");
        }
    }

    #[test]
    fn variance_is_that_of_a_sum_of_coefficients(data in any_data(2, 14, 20), x in prop::collection::vec(-1.5..1.5_f64, 2)) {
        prop_assume!(data.n_used() >= 9);
        let fit = Regression::fit(&quadratic(2), &data).expect("points in general position");
        let covariance = fit.covariance().expect("freedom");
        let r = fit.model().regressor(&x).expect("two coordinates");
        let expected: f64 = (0..36).map(|at| r[at / 6] * covariance[at] * r[at % 6]).sum();
        let size: f64 = (0..36).map(|at| (r[at / 6] * covariance[at] * r[at % 6]).abs()).sum();
        check_close(fit.variance(&x).expect("freedom"), expected, 1e-12 * size, "r' C r");
    }
}

/// The data of `draws_have_the_variance_of_the_prediction`, weights and all.
fn weighted_quadratic() -> Regression {
    let data =
        Data::new(1, vec![-1.0, -0.6, -0.1, 0.4, 0.7, 1.0], vec![3.0, 1.2, 0.7, 1.1, 2.2, 2.9]).expect("valid data");
    let data = data.with_weights(vec![1.0, 2.0, 0.5, 1.0, 3.0, 0.7]).expect("valid weights");
    Regression::fit(&quadratic(1), &data).expect("enough data")
}

/// statsmodels 0.15: `f = WLS(y, [1, x, x²], weights=w).fit()`, then `tvalues`, `pvalues`, `conf_int(0.05)`, `conf_int(0.2)`.
#[test]
fn tests_of_coefficients_are_those_of_statsmodels() {
    let fit = weighted_quadratic();
    let of_each = |number: fn(&CoefficientTest) -> f64, probability: f64| {
        fit.coefficient_tests(probability).expect("degrees of freedom").iter().map(number).collect::<Vec<_>>()
    };
    let t = [2.943117855370053, 1.6662166115267558, 6.138132838039379];
    check_list(&of_each(|test| test.t, 0.95), &t, 1e-12, "t");
    let p = [0.06035828566363506, 0.19426056286073523, 0.00869654808938515];
    check_list(&of_each(|test| test.p_value, 0.95), &p, 1e-12, "p");
    let low = [-0.05425609530546427, -0.25011629767852916, 1.15754150319354];
    check_list(&of_each(|test| test.interval[0], 0.95), &low, 1e-10, "lower ends of 95 %");
    let high = [1.3886739876519976, 0.7998323884812462, 3.650237287557591];
    check_list(&of_each(|test| test.interval[1], 0.95), &high, 1e-10, "upper ends of 95 %");
    let low = [0.29593000389880836, 0.0046967657634242, 1.762496257092808];
    check_list(&of_each(|test| test.interval[0], 0.8), &low, 1e-10, "lower ends of 80 %");
    assert_eq!(of_each(|test| test.coefficient, 0.8), fit.coefficients(), "coefficients");
    assert_eq!(Some(of_each(|test| test.standard_error, 0.8)), fit.standard_errors(), "standard errors");
}

/// statsmodels 0.15: `f.get_prediction([1, x, x²], weights=w)`, then `conf_int(alpha=0.05)` and `conf_int(obs=True, alpha=...)`.
#[test]
fn intervals_of_the_response_are_those_of_statsmodels() {
    let fit = weighted_quadratic();
    let observed = |x: f64, weight: f64, probability: f64| {
        fit.observation_interval(&[x], weight, probability).expect("degrees of freedom")
    };
    for (x, mean, one, of_weight, half) in [
        (
            -0.9,
            [1.6297975224647554, 3.1041767086677488],
            [1.0918545444002798, 3.642119686732224],
            [1.3788300798044117, 3.3551441513280924],
            [2.060512464363485, 2.673461766769019],
        ),
        (
            0.35,
            [0.4623992787040869, 1.653372147290411],
            [-0.1409131322217383, 2.2566845582162363],
            [0.17041181221161927, 1.9453596137828786],
            [0.7697576655622912, 1.3460137604322067],
        ),
    ] {
        let found = fit.mean_interval(&[x], 0.95).expect("degrees of freedom");
        check_list(&found, &mean, 1e-10, "of the mean");
        check_list(&observed(x, 1.0, 0.95), &one, 1e-10, "of an observation of weight 1");
        check_list(&observed(x, 2.5, 0.95), &of_weight, 1e-10, "of an observation of weight 2.5");
        check_list(&observed(x, 1.0, 0.5), &half, 1e-10, "of one half");
    }
}

/// What a 95 % interval of a line promises, over 4000 sets of seven normal errors: a share of 0.95 ± 0.014, four standard errors.
#[test]
fn intervals_of_a_line_hold_as_often_as_they_say() {
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    let points = [-1.0, -0.7, -0.2, 0.1, 0.3, 0.8, 1.0];
    let (model, mut held) = (Model::linear(1).expect("a valid model"), [0; 3]);
    let mut normal = || Distribution::<f64>::sample(&StandardNormal, &mut rng);
    for _ in 0..4000 {
        let values = points.iter().map(|x| 2.0 - 3.0 * x + 0.5 * normal()).collect();
        let fit = Regression::fit(&model, &Data::new(1, points.to_vec(), values).expect("valid data")).expect("a fit");
        let holds = |[low, high]: [f64; 2], truth: f64| usize::from(low <= truth && truth <= high);
        held[0] += holds(fit.coefficient_tests(0.95).expect("degrees of freedom")[1].interval, -3.0);
        held[1] += holds(fit.mean_interval(&[0.5], 0.95).expect("degrees of freedom"), 0.5);
        let new = 0.5 + 0.5 * normal();
        held[2] += holds(fit.observation_interval(&[0.5], 1.0, 0.95).expect("degrees of freedom"), new);
    }
    for (held, what) in held.iter().zip(["slope", "mean", "observation"]) {
        check_close(*held as f64 / 4000.0, 0.95, 0.014, what);
    }
}

/// A model that meets the data exactly leaves no doubt of what is other than zero.
#[test]
fn exact_data_leave_no_doubt() {
    let data = Data::new(1, vec![-1.0, 0.0, 1.0], vec![0.0; 3]).expect("valid data");
    let line = Regression::fit(&Model::linear(1).expect("a valid model"), &data).expect("enough data");
    for test in line.coefficient_tests(0.9).expect("a degree of freedom") {
        assert_eq!((test.t, test.p_value, test.interval), (0.0, 1.0, [0.0; 2]), "nothing against zero");
    }
    assert_eq!(line.observation_interval(&[7.0], 1.0, 0.9), Ok([0.0; 2]), "no error");
    let data = Data::new(1, vec![-1.0, 0.0, 1.0], vec![1.0, 2.0, 3.0]).expect("valid data");
    let line = Regression::fit(&Model::linear(1).expect("a valid model"), &data).expect("enough data");
    for test in line.coefficient_tests(0.9).expect("a degree of freedom") {
        assert!(test.p_value < 1e-10, "{test:?}");
    }
}
