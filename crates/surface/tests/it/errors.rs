//! One refusal per variant, with its message.

use doe::{Axis, Forbidden, Model, Space};
use surface::{
    Confounded, Data, Error, GridPoints, InverseDistance, Kind, PointSource, Regression, Rows, SquaredExponential,
    Surface,
};

#[track_caller]
fn check<T: std::fmt::Debug>(refused: Result<T, Error>, message: &str) {
    let error = refused.expect_err("refused");
    assert_eq!(error.to_string(), message, "{error:?}");
}

fn line() -> Data {
    Data::new(1, vec![-1.0, 0.0, 1.0], vec![1.0, 2.0, 3.0]).expect("valid data")
}

#[test]
fn refuses_numbers_of_factors_and_points() {
    check(Data::new(0, vec![], vec![]), "number of factors: 0, expected 1 to 12");
    check(Data::new(13, vec![0.0; 13], vec![0.0]), "number of factors: 13, expected 1 to 12");
    check(Data::new(2, vec![0.0; 3], vec![0.0]), "3 coordinates do not fill points of 2 coordinates each");
    check(Data::new(2, vec![], vec![]), "number of data points: 0, expected at least 1");
    check(Data::new(1, vec![0.0; 3], vec![0.0; 2]), "number of values of data points: 2, expected 3");
    check(line().with_weights(vec![1.0]), "number of weights: 1, expected 3");
    let other = Data::new(2, vec![0.0; 2], vec![0.0]).expect("valid data");
    check(line().followed_by(&other), "number of factors of the second set of data: 2, expected 1");
}

#[test]
fn refuses_numbers_that_are_not_finite_or_too_large() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1.1e100] {
        check(
            Data::new(2, vec![0.0, 0.0, 0.0, bad], vec![0.0; 2]),
            &format!("coordinate 1 of point 1 is {bad:?}, expected a finite number of magnitude at most 1e100"),
        );
        check(
            Data::new(1, vec![0.0, 1.0], vec![0.0, bad]),
            &format!("the value at point 1 is {bad:?}, expected a finite number of magnitude at most 1e100"),
        );
        check(
            line().with_weights(vec![1.0, bad, 1.0]),
            &format!("the weight of point 1 is {bad:?}, expected 0 (not used) or 1e-100 to 1e100"),
        );
    }
}

#[test]
fn refuses_weights_that_are_negative_or_all_zero() {
    check(line().weighted(-0.5), "the weight of point 0 is -0.5, expected 0 (not used) or 1e-100 to 1e100");
    check(line().weighted(1e-101), "the weight of point 0 is 1e-101, expected 0 (not used) or 1e-100 to 1e100");
    check(line().weighted(0.0), "all 3 weights are 0, expected at least one above");
    assert!(line().with_weights(vec![0.0, -0.0, 1.0]).is_ok(), "a zero is a zero");
}

#[test]
fn refuses_powers_and_scales() {
    for bad in [0.0, -2.0, f64::NAN, f64::INFINITY, 100.5] {
        let message = format!("`power` is {bad:?}, expected a number above 0, at most 100");
        check(InverseDistance::fit(line(), bad), &message);
    }
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e101] {
        let message = format!("`scale` is {bad:?}, expected a number from 1e-100 to 1e100");
        check(SquaredExponential::fit(line(), bad), &message);
    }
}

#[test]
fn refuses_a_model_that_the_data_do_not_determine() {
    let quadratic = Model::quadratic(1).expect("a valid model");
    let two = line().with_weights(vec![1.0, 0.0, 1.0]).expect("valid weights");
    check(
        Regression::fit(&quadratic, &two),
        "2 points of positive weight cannot determine 3 terms, expected at least 3",
    );
    let two_levels = Data::new(1, vec![-1.0, 1.0, -1.0, 1.0], vec![0.0; 4]).expect("valid data");
    check(Regression::fit(&quadratic, &two_levels), "the data cannot tell the terms apart: x1^2 = 1");
    let plane = Model::linear(2).expect("a valid model");
    check(Regression::fit(&plane, &line()), "number of factors of the data: 1, expected 2");
    let diagonal = Data::new(2, vec![-1.0, 2.0, 0.0, 0.0, 1.0, -2.0], vec![0.0; 3]).expect("valid data");
    check(Regression::fit(&plane, &diagonal), "the data cannot tell the terms apart: x2 = -2 x1");
    let slanted = Data::new(2, vec![-1.0, 0.0, 0.0, 1.0, 1.0, 2.0], vec![0.0; 3]).expect("valid data");
    check(Regression::fit(&plane, &slanted), "the data cannot tell the terms apart: x2 = 1 + x1");
    let flat = Data::new(2, vec![-1.0, 0.0, 0.0, 0.0, 1.0, 0.0], vec![0.0; 3]).expect("valid data");
    check(Regression::fit(&plane, &flat), "the data cannot tell the terms apart: x2 = 0");
}

#[test]
fn refuses_weights_that_make_regressors_dependent() {
    // The third point decides about the slope, and hardly counts.
    let data =
        Data::new(1, vec![0.0, 0.0, 1.0], vec![0.0; 3]).and_then(|data| data.with_weights(vec![1.0, 1.0, 1e-30]));
    let model = Model::additive_quadratic(1).expect("a valid model");
    let line = Model::linear(1).expect("a valid model");
    let data = data.expect("valid data");
    assert!(Regression::fit(&line, &data).is_ok(), "columns of unit length: one point may decide");
    let data =
        data.followed_by(&Data::new(1, vec![2.0], vec![0.0]).and_then(|data| data.weighted(1e-60)).expect("valid"));
    let refused = Regression::fit(&model, &data.expect("one factor each")).expect_err("refused");
    assert!(matches!(refused, Error::IllConditioned { ratio, least } if ratio < least), "{refused}");
    assert!(refused.to_string().ends_with("look at the spread of the weights"), "{refused}");
}

#[test]
fn refuses_regressors_that_overflow() {
    let data = Data::new(1, vec![0.0, 1.0, 2.0_f64.powi(200)], vec![0.0; 3]).expect("valid data");
    check(
        Regression::fit(&Model::quadratic(1).expect("a valid model"), &data),
        "the term `x1^2` is 2.5822498780869086e120 at point 2, expected a magnitude of at most 1e100: code the coordinates",
    );
}

#[test]
fn refuses_to_leave_out_what_nothing_else_replaces() {
    let fit = Regression::fit(&Model::quadratic(1).expect("a valid model"), &line()).expect("three points");
    check(fit.leave_one_out(), "the leverage of point 0 is 1: without it the other points cannot determine the model");
    let one = line().with_weights(vec![0.0, 2.0, 0.0]).expect("valid weights");
    let message = "1 different points of positive weight, expected at least 2 to leave one out";
    check(InverseDistance::fit(one.clone(), 2.0).and_then(|surface| surface.leave_one_out()), message);
    check(SquaredExponential::fit(one, 2.0).and_then(|surface| surface.leave_one_out()), message);
    let same = Data::new(1, vec![0.5; 3], vec![1.0, 2.0, 3.0]).expect("valid data");
    check(
        SquaredExponential::fit_scale(same),
        "1 different points of positive weight, expected at least 2 to choose a scale",
    );
}

#[test]
fn refuses_a_test_for_lack_of_fit_without_degrees_of_freedom() {
    let fit = Regression::fit(&Model::linear(1).expect("a valid model"), &line()).expect("three points");
    check(
        fit.lack_of_fit(),
        "3 points at 3 places and 2 terms leave no test for lack of fit, expected more points than places \
         (repeats) and more places than terms",
    );
    let two_places = Data::new(1, vec![0.0, 1.0, 1.0], vec![0.0, 1.0, 2.0]).expect("valid data");
    let fit = Regression::fit(&Model::linear(1).expect("a valid model"), &two_places).expect("three points");
    assert!(matches!(fit.lack_of_fit(), Err(Error::NoLackOfFitTest { n_sites: 2, .. })));
}

#[test]
fn refuses_tests_and_intervals_that_cannot_be() {
    let fit = Regression::fit(&Model::linear(1).expect("a valid model"), &line()).expect("three points");
    for bad in [0.0, 1.0, -0.1, 95.0, f64::NAN] {
        let message = format!("`probability` is {bad:?}, expected between 0 and 1");
        check(fit.coefficient_tests(bad), &message);
        check(fit.mean_interval(&[0.0], bad), &message);
        check(fit.observation_interval(&[0.0], 1.0, bad), &message);
    }
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let message = format!("`weight` is {bad:?}, expected a finite number above 0");
        check(fit.observation_interval(&[0.0], bad, 0.9), &message);
    }
    check(fit.mean_interval(&[0.0, 1.0], 0.9), "number of coordinates of a point: 2, expected 1");
    check(
        fit.observation_interval(&[f64::INFINITY], 1.0, 0.9),
        "coordinate 0 of point 0 is inf, expected a finite number of magnitude at most 1.7976931348623157e308",
    );
    let through = Data::new(1, vec![0.0, 1.0], vec![1.0, 2.0]).expect("valid data");
    let through = Regression::fit(&Model::linear(1).expect("a valid model"), &through).expect("two points");
    let message = "2 points of positive weight and 2 terms leave no degree of freedom, expected more points than terms";
    check(through.coefficient_tests(0.9), message);
    check(through.mean_interval(&[0.0], 0.9), message);
}

#[test]
fn refuses_points_that_do_not_fit() {
    let surface = InverseDistance::fit(line(), 2.0).expect("a valid power");
    check(surface.try_predict(&[0.0, 1.0]), "number of coordinates of a point: 2, expected 1");
    check(
        surface.try_predict(&[f64::NAN]),
        "coordinate 0 of point 0 is NaN, expected a finite number of magnitude at most 1.7976931348623157e308",
    );
    assert_eq!(surface.try_predict(&[0.0]), Ok(2.0));
    check(surface.predict_into(&[0.0; 3], &mut [0.0; 2]), "number of places for estimates: 2, expected 3");
    let grid = GridPoints::of_space(&Space::grid(&[3, 3]).expect("a grid")).expect("a grid");
    check(surface.predict_range(&grid, 0, &mut [0.0; 9]), "number of factors of the source of points: 2, expected 1");
    check(surface.minimum_over(&grid), "number of factors of the source of points: 2, expected 1");
    let grid = GridPoints::of_space(&Space::grid(&[3]).expect("a grid")).expect("a grid");
    let message = |first: u64| format!("3 points from index {first}, expected to end at 3 at most");
    check(surface.predict_range(&grid, 1, &mut [0.0; 3]), &message(1));
    check(surface.predict_range(&grid, u64::MAX, &mut [0.0; 3]), &message(u64::MAX));
    check(Rows::new(2, &[0.0; 3]), "3 coordinates do not fill points of 2 coordinates each");
    check(Rows::new(0, &[]), "number of factors: 0, expected 1 to 12");
}

#[test]
fn refuses_what_is_not_a_grid() {
    check(
        GridPoints::of_space(&Space::of_axes(vec![Axis::Continuous]).expect("a box")),
        "a continuous axis has no levels, expected a grid",
    );
    check(
        GridPoints::of_space(&Space::list(1, vec![0.0]).expect("a list")),
        "a list of candidates has no levels, expected a grid",
    );
    check(GridPoints::new(vec![vec![]]), "number of levels of an axis: 0, expected at least 1");
    let axis = vec![0.0; 1 << 6];
    check(GridPoints::new(vec![axis; 11]), "a grid of 11 axes has more than 2^64 - 1 points, expected fewer levels");
    // Forbidden boxes leave no gap in the indices.
    let forbidden = Forbidden::new(vec![Some([0.5, 1.0])]).expect("a range");
    let space = Space::grid(&[3]).and_then(|space| space.forbid(vec![forbidden])).expect("two cells are left");
    assert_eq!(GridPoints::of_space(&space).expect("a grid").n_points(), 3);
}

#[test]
fn passes_on_what_is_wrong_with_a_model() {
    // Nothing is left of a model once its only term is dropped.
    let model = Model::linear(1).and_then(|model| model.without_terms(&[0])).expect("x alone");
    let zero = Data::new(1, vec![0.0], vec![1.0]).expect("valid data");
    let refused = Kind::Regression { model, confounded: Confounded::Drop }.fit(&zero).expect_err("refused");
    assert!(matches!(refused, Error::Model(doe::DesignSpaceError::Count { found: 0, .. })), "{refused:?}");
}
