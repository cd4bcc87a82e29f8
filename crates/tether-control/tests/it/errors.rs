//! Every refusal, with the parameter it names.

use tether_control::{Controller, ControllerParameters, Error, FilteredPd};

use crate::parameters;

#[track_caller]
fn check_message(error: Error, message: &str) {
    assert_eq!(error.to_string(), message, "{error:?}");
}

#[test]
fn rejects_gains_that_are_not_finite() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for (name, refused) in [
            ("proportional", FilteredPd::new(bad, 0.0, 1.0)),
            ("derivative", FilteredPd::new(0.0, bad, 1.0)),
            ("time_constant_s", FilteredPd::new(0.0, 0.0, bad)),
        ] {
            let Err(Error::NonFinite { name: named, value }) = refused else {
                panic!("{name} = {bad} was accepted: {refused:?}");
            };
            assert_eq!(named, name);
            assert_eq!(value.to_bits(), bad.to_bits());
        }
    }
}

#[test]
fn rejects_a_time_constant_that_is_not_positive() {
    for bad in [0.0, -0.0, -0.1] {
        let refused = FilteredPd::new(1.0, 1.0, bad).expect_err("not positive");
        assert_eq!(refused, Error::NotPositive { name: "time_constant_s", value: bad });
    }
    check_message(
        FilteredPd::new(1.0, 1.0, -0.1).expect_err("not positive"),
        "`time_constant_s` is -0.1, but must be greater than 0",
    );
}

#[test]
fn rejects_gains_whose_first_output_overflows() {
    check_message(
        FilteredPd::new(0.0, 1e300, 1e-300).expect_err("overflow"),
        "`derivative / time_constant_s` is inf, but must be finite",
    );
    check_message(
        FilteredPd::new(1.7e308, -1.7e308, 1.0).expect_err("overflow"),
        "`proportional - derivative / time_constant_s` is inf, but must be finite",
    );
}

#[test]
fn rejects_a_sample_time_that_is_not_positive_and_finite() {
    let pd = FilteredPd::new(1.0, 1.0, 1.0).expect("valid");
    for bad in [0.0, -0.025] {
        assert_eq!(
            pd.sampled(bad).expect_err("not positive"),
            Error::NotPositive { name: "sample_time_s", value: bad }
        );
    }
    check_message(pd.sampled(f64::NAN).expect_err("not a number"), "`sample_time_s` is NaN, but must be finite");
}

#[track_caller]
fn check_controller(change: impl FnOnce(&mut ControllerParameters), message: &str) {
    let mut changed = parameters().expect("valid");
    change(&mut changed);
    check_message(Controller::new(changed).expect_err("invalid"), message);
}

#[test]
fn rejects_controller_parameters_by_name() {
    let finite = "must be finite";
    let positive = "must be greater than 0";
    check_controller(|with| with.set_points.altitude_m = f64::NAN, &format!("`altitude_m` is NaN, but {finite}"));
    check_controller(|with| with.set_points.pitch_rad = f64::INFINITY, &format!("`pitch_rad` is inf, but {finite}"));
    check_controller(|with| with.set_points.roll_rad = f64::NEG_INFINITY, &format!("`roll_rad` is -inf, but {finite}"));
    check_controller(|with| with.sample_time_s = 0.0, &format!("`sample_time_s` is 0, but {positive}"));
    check_controller(|with| with.speed_limit_m_s = f64::INFINITY, &format!("`speed_limit_m_s` is inf, but {finite}"));
    check_controller(|with| with.speed_limit_m_s = -0.01, &format!("`speed_limit_m_s` is -0.01, but {positive}"));
}
