//! Parameters and state survive a file, and a file cannot bring in what the constructors refuse.

use tether_control::{Controller, ControllerParameters, ControllerState, FilteredPd, Measurement, TetherLayout};

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
