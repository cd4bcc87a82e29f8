//! Parameters and state survive a file, and a file cannot bring in what the constructors refuse.

use tether_control::{
    Command, Controller, ControllerParameters, ControllerState, FilteredPd, Measurement, TetherLayout, TrackingErrors,
};

use crate::{controller, parameters};

#[test]
fn parameters_round_trip() {
    let written = serde_json::to_string(&parameters().expect("valid")).expect("plain numbers");
    let read: ControllerParameters = serde_json::from_str(&written).expect("just written");
    assert_eq!(Controller::new(read).expect("valid"), controller());
}

#[test]
fn saved_state_resumes_bit_for_bit() {
    let controller = controller();
    let measured = Measurement { altitude_m: 0.57, pitch_rad: 0.21, roll_rad: -0.13 };
    let mut state = ControllerState::default();
    for _ in 0..17 {
        controller.command(&mut state, &measured);
    }
    let saved = serde_json::to_string(&state).expect("plain numbers");
    let mut resumed: ControllerState = serde_json::from_str(&saved).expect("just written");
    for _ in 0..17 {
        let command = controller.command(&mut state, &measured);
        assert_eq!(command, controller.command(&mut resumed, &measured));
    }
}

#[test]
fn file_cannot_bypass_the_constructor() {
    let refused =
        serde_json::from_str::<FilteredPd>(r#"{"proportional": 1.0, "derivative": 0.0, "time_constant_s": 0.0}"#)
            .expect_err("no time constant");
    assert!(refused.to_string().starts_with("`time_constant_s` is 0"), "{refused}");
}

#[test]
fn file_with_an_unknown_key_is_refused() {
    let refused = serde_json::from_str::<FilteredPd>(
        r#"{"proportional": 1.0, "derivative": 0.0, "time_constant_s": 1.0, "integral": 1.0}"#,
    )
    .expect_err("no such gain");
    assert!(refused.to_string().contains("integral"), "{refused}");
}

#[test]
fn layouts_have_names_in_files() {
    for (layout, name) in [
        (TetherLayout::OneForwardTwoAft, r#""one-forward-two-aft""#),
        (TetherLayout::TwoForwardOneAft, r#""two-forward-one-aft""#),
    ] {
        assert_eq!(serde_json::to_string(&layout).expect("a name"), name);
        let read: TetherLayout = serde_json::from_str(name).expect("a name");
        assert_eq!(read, layout);
    }
}

#[test]
fn what_a_sample_gives_round_trips() {
    let measured = Measurement { altitude_m: 0.57, pitch_rad: 0.21, roll_rad: -0.13 };
    let errors = controller().errors(&measured);
    let command = controller().command(&mut ControllerState::default(), &measured);
    assert!(command.saturated_lines().contains(&true), "the limit is seen in the file");
    let [errors_read, command_read] =
        [serde_json::to_string(&errors), serde_json::to_string(&command)].map(|text| text.expect("plain numbers"));
    assert_eq!(serde_json::from_str::<TrackingErrors>(&errors_read).expect("just written"), errors);
    assert_eq!(serde_json::from_str::<Command>(&command_read).expect("just written"), command);
}

/// A key that nobody reads is a slip, in a state as well.
#[test]
fn states_and_measurements_with_an_unknown_key_are_refused() {
    let refused = |error: serde_json::Error| error.to_string();
    let state = r#"{"altitude":{"filtered_error":0.1},"pitch":{"filtered_error":0.1},"roll":{"filtered_error":0.1}}"#;
    assert!(serde_json::from_str::<ControllerState>(state).is_ok(), "without one");
    let other = state.replacen(r#""filtered_error":0.1"#, r#""filtered_error":0.1,"integral":0.2"#, 1);
    let said = serde_json::from_str::<ControllerState>(&other).map_err(refused).expect_err("no such memory");
    assert!(said.contains("integral"), "{said}");
    let measured = r#"{"altitude_m":0.6,"pitch_rad":0.3,"roll_rad":0.0,"yaw_rad":0.1}"#;
    let said = serde_json::from_str::<Measurement>(measured).map_err(refused).expect_err("not looked at");
    assert!(said.contains("yaw_rad"), "{said}");
}
