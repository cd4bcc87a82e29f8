//! The sign trap: every error drives the body back, through the geometry of the lines, in both layouts.

use tether_control::{Controller, ControllerState, Measurement, Mixing, SetPoints, TetherLayout};

use crate::{LAYOUTS, parameters};

const SEPARATION_LONGITUDINAL_M: f64 = 0.07;
const SEPARATION_LATERAL_M: f64 = 0.096;

/// What three line lengths [center, starboard, port] do to a body that follows them: (1), (2) and the mean length.
struct Pose {
    length_m: f64,
    pitch_rad: f64,
    roll_rad: f64,
}

fn pose(layout: TetherLayout, [l1, l2, l3]: [f64; 3]) -> Pose {
    let center_ahead_m = match layout {
        TetherLayout::OneForwardTwoAft => l1 - 0.5 * (l2 + l3),
        TetherLayout::TwoForwardOneAft => 0.5 * (l2 + l3) - l1,
    };
    Pose {
        length_m: (l1 + l2 + l3) / 3.0,
        pitch_rad: (center_ahead_m / SEPARATION_LONGITUDINAL_M).atan(),
        roll_rad: ((l3 - l2) / SEPARATION_LATERAL_M).atan(),
    }
}

/// The change of the pose after the first command, from level lines.
fn first_motion(layout: TetherLayout, measured: Measurement) -> Pose {
    let mut with = parameters().expect("valid");
    with.layout = layout;
    with.set_points = SetPoints { altitude_m: 0.6, pitch_rad: 0.0, roll_rad: 0.0 };
    let controller = Controller::new(with).expect("valid");
    let command = controller.command(&mut ControllerState::default(), &measured);
    let moved = pose(layout, command.saturated_m_s.map(|speed| 0.6 + 0.025 * speed));
    Pose { length_m: moved.length_m - 0.6, ..moved }
}

const LEVEL: Measurement = Measurement { altitude_m: 0.6, pitch_rad: 0.0, roll_rad: 0.0 };

/// Rounding of lengths near 0.6 m, over the separations.
const ROUNDING: f64 = 1e-14;

#[test]
fn nose_low_raises_the_nose() {
    for layout in LAYOUTS {
        for pitch_rad in [-0.05, 0.05] {
            let motion = first_motion(layout, Measurement { pitch_rad, ..LEVEL });
            assert!(
                motion.pitch_rad * pitch_rad < 0.0,
                "{layout:?}: from {pitch_rad} the pitch moves by {}",
                motion.pitch_rad
            );
            assert!(motion.roll_rad.abs() < ROUNDING, "{layout:?}: no roll");
        }
    }
}

#[test]
fn port_low_raises_the_port_side() {
    for layout in LAYOUTS {
        for roll_rad in [-0.05, 0.05] {
            let motion = first_motion(layout, Measurement { roll_rad, ..LEVEL });
            assert!(
                motion.roll_rad * roll_rad < 0.0,
                "{layout:?}: from {roll_rad} the roll moves by {}",
                motion.roll_rad
            );
            assert!(motion.pitch_rad.abs() < ROUNDING, "{layout:?}: no pitch");
            assert!(motion.length_m.abs() < ROUNDING, "{layout:?}: no climb");
        }
    }
}

#[test]
fn low_body_goes_up() {
    for layout in LAYOUTS {
        for error_m in [-0.05, 0.05] {
            let altitude_m = LEVEL.altitude_m - error_m;
            let motion = first_motion(layout, Measurement { altitude_m, ..LEVEL });
            assert!(
                motion.length_m * error_m > 0.0,
                "{layout:?}: {error_m} m too low moves it up by {}",
                motion.length_m
            );
            assert!(motion.pitch_rad.abs() < ROUNDING, "{layout:?}: no pitch");
            assert!(motion.roll_rad.abs() < ROUNDING, "{layout:?}: no roll");
        }
    }
}

#[test]
fn pitch_error_taken_as_set_point_minus_pitch_would_lower_the_nose() {
    // The laboratory's convention with (14) as printed: it needs another sign, which is why this test exists.
    let layout = TetherLayout::OneForwardTwoAft;
    let nose_low_by_rad = 0.05;
    let speeds = Mixing::new(layout).line_speeds_m_s([0.0, 0.16 * nose_low_by_rad, 0.0]);
    assert!(pose(layout, speeds.map(|speed| 0.6 + 0.025 * speed)).pitch_rad < 0.0, "further down");
}

#[test]
fn pull_at_the_port_line_rolls_to_port_raises_the_nose_and_lowers_the_body() {
    let layout = TetherLayout::OneForwardTwoAft;
    let pulled = pose(layout, [0.6, 0.6, 0.6 - 0.011]);
    assert!(pulled.roll_rad < 0.0, "port side down");
    assert!(pulled.pitch_rad > 0.0, "nose up");
    assert!(pulled.length_m < 0.6, "lower");
    // The loops that the pull stands for: down, nose-up, starboard-up turned around.
    let [v_z, v_theta, v_phi] = Mixing::new(layout).loop_speeds_m_s([0.0, 0.0, -0.011]);
    assert!(v_z < 0.0 && v_theta < 0.0 && v_phi > 0.0, "{v_z} {v_theta} {v_phi}");
}
