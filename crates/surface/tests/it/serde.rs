//! Surfaces and data in files.

use doe::Model;
use surface::process::{Contrast, Marginals};
use surface::{
    Confounded, Data, InverseDistance, Kind, LeaveOneOut, Regression, Rows, SquaredExponential, Surface as _,
};

fn data() -> Data {
    let data = Data::new(1, vec![-1.0, 0.0, 0.1, 1.0], vec![1.0 / 3.0, 0.1, 0.7, 2.0]);
    data.and_then(|data| data.with_weights(vec![0.7, 0.3, 0.3, 0.0])).expect("valid data")
}

#[track_caller]
fn check<T: ::serde::Serialize + for<'a> ::serde::Deserialize<'a> + PartialEq + std::fmt::Debug>(value: &T) {
    let text = serde_json::to_string(value).expect("it can be written");
    let read: T = serde_json::from_str(&text).expect("it can be read");
    assert_eq!(&read, value, "{text}");
}

#[test]
fn everything_fitted_comes_back_the_same() {
    let line = Model::linear(1).expect("a valid model");
    check(&data());
    check(&InverseDistance::fit(data(), 2.5).expect("a valid power"));
    check(&SquaredExponential::fit(data(), 0.3).expect("a valid scale"));
    check(&SquaredExponential::fit_scale(data()).expect("three places"));
    check(&Regression::fit(&line, &data()).expect("three points"));
    let two = data().with_weights(vec![1.0, 1.0, 0.0, 0.0]).expect("valid weights");
    let quadratic = Model::quadratic(1).expect("a valid model");
    check(&Regression::fit_with(&quadratic, &two, Confounded::Drop).expect("a line is left"));
    check(&Kind::Regression { model: line, confounded: Confounded::Drop });
    check(&Kind::SquaredExponential { scale: None });
}

/// What a regression reports may be written with it.
#[test]
fn tests_of_a_regression_serialize() {
    let data = Data::new(1, vec![-1.0, 0.0, 0.0, 1.0], vec![1.0, 2.0, 3.0, 6.0]).expect("valid data");
    let line = Regression::fit(&Model::linear(1).expect("a valid model"), &data).expect("four points");
    let lack = line.lack_of_fit().expect("a repeat");
    let written = serde_json::to_value(lack).expect("it can be written");
    assert_eq!((&written["f"], &written["pure_error_degrees"]), (&lack.f.into(), &1.into()));
    let slope = line.coefficient_tests(0.95).expect("two degrees of freedom")[1];
    let written = serde_json::to_value(slope).expect("it can be written");
    assert_eq!((&written["t"], &written["interval"][1]), (&slope.t.into(), &slope.interval[1].into()));
}

#[test]
fn data_are_readable_and_weights_may_be_left_out() {
    let read: Data = serde_json::from_str(r#"{"points":[[0,1],[2,3]],"values":[4,5]}"#).expect("valid data");
    assert_eq!(read, Data::new(2, vec![0.0, 1.0, 2.0, 3.0], vec![4.0, 5.0]).expect("valid data"));
    assert_eq!(serde_json::to_string(&read).expect("text"), r#"{"points":[[0.0,1.0],[2.0,3.0]],"values":[4.0,5.0]}"#);
    let kind: Kind = serde_json::from_str(r#"{"inverse_distance":{"power":2}}"#).expect("a kind");
    crate::check_exact(kind.fit(&read).expect("a surface").predict(&[0.0, 1.0]), 4.0, "at a datum");
}

#[test]
fn what_is_read_is_checked() {
    let refused = |text: &str| serde_json::from_str::<InverseDistance>(text).expect_err("refused").to_string();
    let power = refused(r#"{"data":{"points":[[0]],"values":[4]},"power":-1}"#);
    assert!(power.starts_with("`power` is -1.0"), "{power}");
    let weight = refused(r#"{"data":{"points":[[0]],"values":[4],"weights":[-2]},"power":1}"#);
    assert!(weight.contains("the weight of point 0 is -2.0"), "{weight}");
    let ragged = refused(r#"{"data":{"points":[[0],[0,1]],"values":[4,5]},"power":1}"#);
    assert!(ragged.contains("number of coordinates of a point: 2, expected 1"), "{ragged}");
    let unknown = refused(r#"{"data":{"points":[[0]],"values":[4]},"power":1,"exponent":2}"#);
    assert!(unknown.contains("unknown field `exponent`"), "{unknown}");
}

/// What a surface says of points comes back as it was, and what cannot be is refused.
#[test]
fn what_a_surface_says_comes_back_the_same() {
    let surface = InverseDistance::fit(data(), 2.5).expect("a valid power");
    check(&surface.leave_one_out().expect("three points"));
    check(&Marginals { means: vec![1.0 / 3.0, -0.1], variances: vec![0.1, 0.0] });
    check(&Contrast { means: vec![0.0, 0.7], variances: vec![0.0, 1.0 / 7.0] });
    let rows = Rows::new(1, &[-1.0, 0.3]).expect("two points");
    check(&surface.minimum_over(&rows).expect("one factor").expect("an estimate"));
    let short = serde_json::from_str::<LeaveOneOut>(r#"{"residuals":[0.1,0.2],"weights":[1.0]}"#);
    assert!(
        short.is_err_and(|error| error.to_string().starts_with("number of weights: 1, expected 2")),
        "a weight is missing"
    );
    let short = serde_json::from_str::<Contrast>(r#"{"means":[0.1,0.2],"variances":[1.0]}"#);
    assert!(
        short.is_err_and(|error| error.to_string().starts_with("number of variances: 1, expected 2")),
        "one is missing"
    );
    let negative = serde_json::from_str::<Marginals>(r#"{"means":[0.1],"variances":[-1.0]}"#);
    assert!(negative.is_err_and(|error| error.to_string().contains("is -1.0, expected 0 or more")), "no variance");
}
