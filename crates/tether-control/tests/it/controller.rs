//! The three loops together.

use proptest::prelude::*;
use tether_control::{Command, Controller, ControllerState, Measurement, Mixing, PdState, SetPoints};

use crate::{LAYOUTS, controller, parameters};

fn measurements() -> impl Strategy<Value = Vec<Measurement>> {
    let one = (0.4..0.8_f64, -0.2..0.6_f64, -0.5..0.5_f64).prop_map(|(altitude_m, pitch_rad, roll_rad)| Measurement {
        altitude_m,
        pitch_rad,
        roll_rad,
    });
    prop::collection::vec(one, 1..60)
}

fn fly(controller: &Controller, measured: &[Measurement]) -> Vec<Command> {
    let mut state = ControllerState::default();
    measured.iter().map(|measured| controller.command(&mut state, measured)).collect()
}

fn bits(command: &Command) -> [u64; 3] {
    command.unsaturated_m_s.map(f64::to_bits)
}

#[test]
fn body_at_its_set_points_gets_no_command() {
    let mut state = ControllerState::default();
    let measured = Measurement { altitude_m: 0.6, pitch_rad: 0.3, roll_rad: 0.0 };
    for _ in 0..100 {
        let command = controller().command(&mut state, &measured);
        for speed in command.unsaturated_m_s.iter().chain(&command.saturated_m_s) {
            assert!(speed.abs() <= 0.0, "{command:?}");
        }
        assert_eq!(command.saturated_lines(), [false; 3]);
    }
    assert_eq!(state, ControllerState::default());
}

#[test]
fn only_the_line_beyond_the_limit_is_held_back() {
    // A low and nose-low body: v_z > 0 > v_theta, so the center line asks for the sum, the others for the difference.
    let mut state = ControllerState::default();
    let measured = Measurement { altitude_m: 0.56, pitch_rad: 0.25, roll_rad: 0.0 };
    let command = controller().command(&mut state, &measured);
    let v_z = 0.006 / 0.7 * 0.04;
    let v_theta = -0.016 / 0.1 * 0.05;
    let asked = [v_z - v_theta, v_z + v_theta, v_z + v_theta];
    for (line, (asked, expected)) in asked.iter().zip(command.unsaturated_m_s).enumerate() {
        assert!((asked - expected).abs() < 1e-16, "line {line}");
    }
    assert_eq!(command.saturated_lines(), [false; 3], "below 0.011 m/s");

    let command = controller().command(&mut ControllerState::default(), &Measurement { roll_rad: 0.02, ..measured });
    assert_eq!(command.saturated_lines(), [false, false, true]);
    assert_eq!(command.saturated_m_s[2].to_bits(), (-0.011_f64).to_bits());
    assert_eq!(command.saturated_m_s[..2], command.unsaturated_m_s[..2]);
}

#[test]
fn broken_measurement_is_seen_in_the_command() {
    let mut state = ControllerState::default();
    let measured = Measurement { altitude_m: f64::NAN, pitch_rad: 0.3, roll_rad: 0.0 };
    let command = controller().command(&mut state, &measured);
    assert!(command.saturated_m_s.iter().all(|speed| speed.is_nan()), "never clamped to a number");
}

proptest! {
    #[test]
    fn command_is_within_the_limit_and_moved_only_by_it(measured in measurements()) {
        for command in fly(&controller(), &measured) {
            for line in 0..3 {
                let (asked, given) = (command.unsaturated_m_s[line], command.saturated_m_s[line]);
                prop_assert!(given.abs() <= 0.011, "{:?}", command);
                if command.saturated_lines()[line] {
                    prop_assert!(asked.abs() > 0.011 && given.abs() >= 0.011, "{:?}", command);
                    prop_assert!(asked * given > 0.0, "{:?}", command);
                } else {
                    prop_assert_eq!(asked.to_bits(), given.to_bits());
                }
            }
        }
    }

    #[test]
    fn limit_does_not_change_what_the_filters_see(measured in measurements()) {
        let mut wide = parameters().unwrap();
        wide.speed_limit_m_s = 1e9;
        let wide = fly(&Controller::new(wide).unwrap(), &measured);
        for (narrow, wide) in fly(&controller(), &measured).iter().zip(wide) {
            prop_assert_eq!(bits(narrow), bits(&wide));
        }
    }

    #[test]
    fn command_is_the_three_loops_mixed(measured in measurements()) {
        for layout in LAYOUTS {
            let mut with = parameters().unwrap();
            with.layout = layout;
            let loops = [with.altitude, with.pitch, with.roll]
                .map(|pd| pd.sampled(with.sample_time_s).unwrap());
            let mut states = [PdState::default(); 3];
            let commands = fly(&Controller::new(with).unwrap(), &measured);
            for (measured, command) in measured.iter().zip(commands) {
                let errors = [
                    0.6 - measured.altitude_m,
                    measured.pitch_rad - 0.3,
                    measured.roll_rad,
                ];
                let v = std::array::from_fn(|i| loops[i].output(&mut states[i], errors[i]));
                let u = Mixing::new(layout).line_speeds_m_s(v);
                prop_assert_eq!(bits(&command), u.map(f64::to_bits));
            }
        }
    }

    #[test]
    fn commands_superpose_below_the_limit(
        first in measurements(),
        second in measurements(),
        share in 0.0..1.0_f64,
    ) {
        // Errors are affine in the measurement, so a mixture of measurements gives the mixture of commands.
        let controller = controller();
        let length = first.len().min(second.len());
        let mixture: Vec<Measurement> = first.iter().zip(&second).map(|(a, b)| Measurement {
            altitude_m: share * a.altitude_m + (1.0 - share) * b.altitude_m,
            pitch_rad: share * a.pitch_rad + (1.0 - share) * b.pitch_rad,
            roll_rad: share * a.roll_rad + (1.0 - share) * b.roll_rad,
        }).collect();
        let (first, second) = (fly(&controller, &first), fly(&controller, &second));
        let mixture = fly(&controller, &mixture);
        for k in 0..length {
            for line in 0..3 {
                let expected = share * first[k].unsaturated_m_s[line]
                    + (1.0 - share) * second[k].unsaturated_m_s[line];
                prop_assert!((mixture[k].unsaturated_m_s[line] - expected).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn moving_set_point_and_measurement_together_changes_nothing(
        measured in measurements(),
        shift in -1.0..1.0_f64,
    ) {
        let mut moved = parameters().unwrap();
        let at = moved.set_points;
        moved.set_points = SetPoints {
            altitude_m: at.altitude_m + shift,
            pitch_rad: at.pitch_rad + shift,
            roll_rad: at.roll_rad + shift,
        };
        let shifted: Vec<Measurement> = measured.iter().map(|at| Measurement {
            altitude_m: at.altitude_m + shift,
            pitch_rad: at.pitch_rad + shift,
            roll_rad: at.roll_rad + shift,
        }).collect();
        let moved = fly(&Controller::new(moved).unwrap(), &shifted);
        for (here, there) in fly(&controller(), &measured).iter().zip(moved) {
            for line in 0..3 {
                prop_assert!((here.unsaturated_m_s[line] - there.unsaturated_m_s[line]).abs() < 1e-14);
            }
        }
    }
}
