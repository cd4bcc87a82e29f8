//! Flights that have no result say why, where and when.

use bat_dynamics::Error as PlantError;
use tether_control::FilteredPd;
use water_channel::{
    Error, FlightError, FlightRequest, FlightSettings, SlackPolicy, TestProfile, Window, fly, fly_all, fly_all_logged,
    fly_logged,
};

use crate::rigs::{assert_close, first_row, full_test, short_test, steps};

#[track_caller]
fn failure(request: &FlightRequest, profile: &TestProfile) -> FlightError {
    let mut settings = FlightSettings::with_steps(1);
    settings.slack = SlackPolicy::Warn;
    fly(request, profile, &settings).unwrap_err()
}

#[track_caller]
fn assert_start(request: &FlightRequest, message: &str) {
    let error = failure(request, &short_test(1.0));
    assert!(matches!(error, FlightError::Start(_)), "{error:?}");
    assert!(error.to_string().contains(message), "{error}");
}

#[test]
fn diverging_flight_tells_time_and_state() {
    let mut request = first_row();
    let pitch = request.rig.pitch;
    request.rig.pitch = FilteredPd::new(-20.0 * pitch.proportional(), 0.0, 0.1).unwrap();
    request.rig.plant.winch.speed_limit_m_s = 0.5;
    let error = failure(&request, &short_test(60.0));
    let FlightError::LeftTheModel(PlantError::State { name, value, time_s, .. }) = &error else {
        panic!("another failure: {error:?}");
    };
    assert!(*time_s > 0.0 && *time_s < 60.0, "when: {error}");
    assert!(!name.is_empty() && !(0.01..1.0).contains(value), "what: {error}");
    let message = error.to_string();
    assert!(message.starts_with("left the model: ") && message.contains(" at t = "), "{message}");
    assert!(message.contains("it must be "), "{message}");
}

#[test]
fn log_of_a_diverging_flight_ends_at_the_failure() {
    let mut request = first_row();
    request.rig.pitch = FilteredPd::new(-0.8, 0.0, 0.1).unwrap();
    request.rig.plant.winch.speed_limit_m_s = 0.5;
    let mut settings = FlightSettings::with_steps(1);
    settings.slack = SlackPolicy::Warn;
    let (outcome, log) = fly_logged(&request, &short_test(60.0), &settings, 1).unwrap();
    let Err(FlightError::LeftTheModel(PlantError::State { time_s, .. })) = outcome else {
        panic!("it must leave the model: {outcome:?}");
    };
    assert_close(log.rows.last().unwrap().time_s, time_s, 0.0, "last row");
}

#[test]
fn line_reeled_in_to_nothing_is_an_error() {
    let mut request = first_row();
    request.rig.plant.winch.speed_limit_m_s = 0.05;
    let windows = vec![Window { from_s: 0.0, to_s: 20.0, commands: [-1.0; 3] }];
    let profile = TestProfile::new(20.0, steps(&[(0.0, 0.4, 0.0)]), windows).unwrap();
    let error = failure(&request, &profile);
    let FlightError::LeftTheModel(PlantError::State { name, value, time_s, .. }) = &error else {
        panic!("another failure: {error:?}");
    };
    assert!(["line_center", "line_starboard", "line_port"].contains(name), "{error}");
    assert!(*value <= 0.0, "{error}");
    // The shorter aft lines of 0.57 m at 0.05 m/s, after the winch's lag.
    assert!((11.0..12.0).contains(time_s), "{error}");
}

#[test]
fn trim_that_does_not_exist_says_why() {
    let mut heavy = first_row();
    heavy.rig.plant.body.volume_m3 = 1e-5;
    assert_start(&heavy, "cannot start: no trim: ");

    let mut still = first_row();
    still.rig.plant.body.center_of_mass_x = 0.3;
    let profile = TestProfile::new(1.0, steps(&[(0.0, 0.0, 0.0)]), Vec::new()).unwrap();
    let error = failure(&still, &profile).to_string();
    assert!(error.contains("at 0 m/s the flow does not push the tether away from the vertical"), "{error}");
}

#[test]
fn unreachable_pitch_set_point_is_named_with_its_reach() {
    let mut steep = first_row();
    steep.rig.set_points.pitch_rad = 1.5;
    steep.rig.plant.tether.separation_longitudinal_m = 3.0;
    assert_start(&steep, "pitch 1.5 rad is out of the bridle's reach");
    steep.rig.set_points.pitch_rad = 1.6;
    assert_start(&steep, "pitch set point in rad = 1.6: it must be finite and within pi/2");
}

#[test]
fn numbers_out_of_range_are_named() {
    let mut request = first_row();
    request.rig.plant.body.mass_kg = -0.18;
    assert_start(&request, "body.mass = -0.18 kg: it must be finite and more than zero");
    let mut request = first_row();
    request.rig.plant.body.mass_kg = f64::NAN;
    assert_start(&request, "body.mass = NaN kg");
    let mut request = first_row();
    request.rig.set_points.altitude_m = -0.1;
    assert_start(&request, "altitude set point in m = -0.1: it must be finite and more than zero");
    let mut request = first_row();
    request.rig.set_points.roll_rad = f64::NAN;
    assert_start(&request, "controller: `roll_rad` is NaN, but must be finite");
    let mut request = first_row();
    request.rig.sample_time_s = 0.0;
    assert_start(&request, "controller: `sample_time_s` is 0, but must be greater than 0");
}

#[test]
fn settings_out_of_range_are_named() {
    for (steps_per_sample, written) in [(0, "0"), (1001, "1001")] {
        let error = FlightSettings::with_steps(steps_per_sample).validate().unwrap_err();
        let expected = format!("steps per sample = {written}: it must be a whole number from 1 to 1000");
        assert_eq!(error.to_string(), expected);
    }
    let error = fly_logged(&first_row(), &full_test(), &FlightSettings::default(), 0).unwrap_err();
    let FlightError::Start(Error::Argument { name, .. }) = &error else { panic!("{error:?}") };
    assert_eq!(*name, "samples per log row");
}

/// By hand: 1e13 s with a sample every 0.1 s are 1e14 samples, 1.5e6 s are 1.5e7. Nothing is flown, or the test would not end.
#[test]
fn tests_of_too_many_samples_are_refused_before_they_fly() {
    let mut request = first_row();
    request.rig.sample_time_s = 0.1;
    let settings = FlightSettings::with_steps(1);
    let expected = "cannot start: number of samples of the test = 100000000000000: it must be at most 1e8: a shorter test, or a \
                    longer sample time";
    let endless = short_test(1e13);
    assert_eq!(fly(&request, &endless, &settings).unwrap_err().to_string(), expected);
    assert_eq!(fly_logged(&request, &endless, &settings, 1_000_000_000).unwrap_err().to_string(), expected);
    let requests = vec![request.clone(); 2];
    for result in fly_all(&requests, &endless, &settings, |_| {}) {
        assert_eq!(result.unwrap_err().to_string(), expected, "side by side");
    }
    let expected =
        "cannot start: number of log rows = 15000000: it must be at most 1e7: more samples per row, or a shorter test";
    let long = short_test(1.5e6);
    assert_eq!(fly_logged(&request, &long, &settings, 1).unwrap_err().to_string(), expected);
    for result in fly_all_logged(&requests, &long, &settings, 1) {
        assert_eq!(result.unwrap_err().to_string(), expected, "side by side");
    }
}
