//! Windows, flow and its direction: what a test tells the rig is what the rig does.

use bat_dynamics::{Fidelity, Transition};
use proptest::prelude::*;
use tether_control::{ControllerState, Measurement};
use water_channel::{TestProfile, Window};

use crate::rigs::{assert_close, cost, first_row, flow, flown, full_test, kick, logged, request, steps};

/// A flight seen from a turned frame goes through other roundings.
const TURNED: f64 = 1e-9;

/// (22)–(26) as printed: 41 samples pull, 80 hold, in each of the three windows.
#[test]
fn pull_covers_samples_800_to_840_and_hold_samples_841_to_920() {
    let request = first_row();
    let limit = request.rig.plant.winch.speed_limit_m_s;
    let log = logged(&request, &full_test());
    assert_eq!(log.rows.len(), 12_000, "samples of 300 s");
    for offset in [0, 4000, 8000] {
        for (k, row) in log.rows.iter().enumerate().skip(offset).take(4000) {
            let command = row.commands_m_s;
            let is = |expected: [f64; 3]| command.map(f64::to_bits) == expected.map(f64::to_bits);
            match k - offset {
                800..=840 => assert!(is([0.0, 0.0, -limit]), "sample {k} pulls: {command:?}"),
                841..=920 => assert!(is([0.0; 3]), "sample {k} holds: {command:?}"),
                _ => assert!(!is([0.0, 0.0, -limit]), "sample {k} is the controller's: {command:?}"),
            }
        }
        assert!(log.rows[offset + 921].commands_m_s[2] > 0.0, "after the hold the port line goes out again");
    }
    let switches =
        log.rows.windows(2).filter(|pair| pair[0].commands_m_s[2] > -limit && pair[1].commands_m_s[2] <= -limit);
    assert_eq!(switches.count(), 3, "pulls in the test");
}

#[test]
fn earlier_window_wins_where_two_share_a_sample() {
    let window = |from_s, to_s, commands| Window { from_s, to_s, commands };
    let pull = window(1.0, 2.0, [0.0, 0.0, -1.0]);
    let out = window(1.5, 2.5, [0.5, 0.5, 0.5]);
    let windows = |windows: Vec<Window>| TestProfile::new(5.0, steps(&[(0.0, 0.245, 0.0)]), windows).unwrap();
    let first = windows(vec![pull, out]);
    assert_eq!(first.override_at(1.75, 0.025), Some(pull.commands), "both hold, the first is listed earlier");
    assert_eq!(first.override_at(2.025, 0.025), Some(out.commands), "the first is over");
    let second = windows(vec![out, pull]);
    assert_eq!(second.override_at(1.75, 0.025), Some(out.commands), "the other order");
    assert_eq!(second.override_at(1.0, 0.025), Some(pull.commands), "only one holds");
    assert_eq!(second.override_at(2.525, 0.025), None, "none holds");
}

/// Samples are found by index, so that sums of sample times cannot miss the end of a window.
#[test]
fn window_ends_are_sharp_at_any_sample_time() {
    for sample_time_s in [0.01, 0.02, 0.025, 0.05, 0.1] {
        let mut request = first_row();
        request.rig.sample_time_s = sample_time_s;
        let profile = TestProfile::new(4.0, steps(&[(0.0, 0.245, 0.0)]), vec![kick(1.0)[0]]).unwrap();
        let limit = request.rig.plant.winch.speed_limit_m_s;
        let pulled = |row: &&water_channel::LogRow| row.commands_m_s[2].to_bits() == (-limit).to_bits();
        let n_pulled = logged(&request, &profile).rows.iter().filter(pulled).count();
        assert_eq!(n_pulled, (1.0 / sample_time_s).round() as usize + 1, "both ends at {sample_time_s} s");
    }
}

/// The filters see the errors during a window too: the first command after it is that of a controller that ran on.
#[test]
fn filters_keep_running_inside_a_window() {
    let request = first_row();
    let log = logged(&request, &crate::rigs::short_test(6.0));
    let controller = request.rig.controller().unwrap();
    let mut memory = ControllerState::default();
    for (k, row) in log.rows.iter().enumerate() {
        let measured = Measurement { altitude_m: row.altitude_m, pitch_rad: row.pitch_rad, roll_rad: row.roll_rad };
        let command = controller.command(&mut memory, &measured).saturated_m_s;
        if !(40..=160).contains(&k) {
            assert_eq!(row.commands_m_s.map(f64::to_bits), command.map(f64::to_bits), "sample {k}");
        }
    }
}

#[test]
fn winches_lag_behind_the_window_and_stay_within_their_speed() {
    let request = first_row();
    let limit = request.rig.plant.winch.speed_limit_m_s;
    let lag = request.rig.plant.winch.time_constant_s;
    let log = logged(&request, &crate::rigs::short_test(3.0));
    let first = &log.rows[40];
    assert_close(first.state[11], 0.0, 1e-12, "still at rest when the pull begins");
    for (k, row) in log.rows.iter().enumerate().skip(40).take(41) {
        let expected = -limit * (1.0 - (-0.025 * (k - 40) as f64 / lag).exp());
        // RK4 of a first-order lag at 0.19 time constants a step.
        assert_close(row.state[11], expected, 1e-4 * limit, "reel speed of the port line");
    }
}

/// The same test in a channel turned by 40 degrees is the same flight: Theta follows, all else is relative to the flow.
#[test]
fn flight_is_the_same_relative_to_a_turned_flow() {
    let request = request(Fidelity::STALLED_WITH_ADDED_MASS, 48.0, 12.0);
    let at = |direction_deg: f64| {
        let history = steps(&[(0.0, 0.205, direction_deg), (7.3, 0.245, direction_deg)]);
        TestProfile::new(20.0, history, kick(1.0)).unwrap()
    };
    let straight = flown(&request, &at(0.0), 2);
    for direction_deg in [40.0, -170.0, 360.0] {
        let turned = flown(&request, &at(direction_deg), 2);
        assert_close(cost(&turned), cost(&straight), TURNED * cost(&straight), "cost");
        for (k, (found, expected)) in turned.final_state.iter().zip(straight.final_state).enumerate() {
            let shift = if k == 1 { direction_deg.to_radians() } else { 0.0 };
            assert_close(*found, expected + shift, TURNED, "final state");
        }
    }
}

/// After the flow has turned, the aerostat swings round until it points into it again.
#[test]
fn azimuth_follows_a_turn_of_the_flow() {
    let turn = 20f64.to_radians();
    let history = steps(&[(0.0, 0.245, 0.0), (5.0, 0.245, 20.0)]);
    let profile = TestProfile::new(100.0, history, Vec::new()).unwrap();
    let log = logged(&first_row(), &profile);
    let turned = log.rows.iter().find(|row| row.time_s >= 5.0).unwrap();
    assert_close(turned.heading_rad, -turn, 1e-9, "heading from the flow right after the turn");
    let last = log.rows.last().unwrap();
    assert_close(last.state[1], turn, 1e-3, "azimuth");
    assert_close(last.heading_rad, 0.0, 1e-3, "heading from the flow");
    assert_close(last.flow_direction_rad, turn, 1e-12, "direction of the flow in the log");
}

#[test]
fn turn_across_the_half_turn_is_a_turn_by_the_short_way() {
    let profile = |from_deg: f64, to_deg: f64| {
        TestProfile::new(30.0, steps(&[(0.0, 0.245, from_deg), (5.0, 0.245, to_deg)]), Vec::new()).unwrap()
    };
    let plain = flown(&first_row(), &profile(0.0, 20.0), 1);
    let across = flown(&first_row(), &profile(170.0, -170.0), 1);
    assert_close(cost(&across), cost(&plain), TURNED * cost(&plain), "cost");
}

/// The lateral position is that in the channel, as (20) wants it: it does not turn with the flow.
#[test]
fn lateral_position_is_measured_in_the_ground_frame() {
    let at = |direction_deg: f64| {
        let profile = TestProfile::new(1.0, steps(&[(0.0, 0.245, direction_deg)]), Vec::new()).unwrap();
        logged(&first_row(), &profile).rows[0]
    };
    let (along, across) = (at(0.0), at(90.0));
    assert_close(along.lateral_m, 0.0, 1e-15, "on the centerline");
    // With the flow from starboard of the channel the body lies to port, as far as it lay downstream.
    let [zenith, _, _, ..] = across.state;
    let length = across.state[6..9].iter().sum::<f64>() / 3.0;
    assert!(across.lateral_m < -0.5 * length * zenith.sin(), "downstream is now to port: {}", across.lateral_m);
    assert_close(across.heading_rad, 0.0, 1e-12, "the heading turns with the flow");
}

#[test]
fn ramp_is_logged_as_a_ramp() {
    let history = flow(&[(0.0, 0.205, 0.0), (2.0, 0.245, 10.0)], Transition::Linear);
    let profile = TestProfile::new(4.0, history, Vec::new()).unwrap();
    for row in &logged(&first_row(), &profile).rows {
        let share = (row.time_s / 2.0).min(1.0);
        assert_close(row.flow_speed_m_s, 0.205 + 0.04 * share, 1e-12, "speed");
        assert_close(row.flow_direction_rad, 10f64.to_radians() * share, 1e-12, "direction");
    }
}

proptest! {
    #[test]
    fn flow_of_the_log_is_that_of_the_profile(
        gaps in prop::collection::vec(0.01..1.0_f64, 1..5),
        speeds in prop::collection::vec(0.15..0.3_f64, 5),
    ) {
        let mut at_s = 0.0;
        let knots: Vec<(f64, f64, f64)> = gaps.iter().zip(&speeds).map(|(gap, speed)| {
            let from_s = at_s;
            at_s += gap;
            (from_s, *speed, 0.0)
        }).collect();
        let profile = TestProfile::new(at_s + 0.5, steps(&knots), Vec::new()).unwrap();
        for row in &logged(&first_row(), &profile).rows {
            let (_, speed, _) = knots.iter().rev().find(|knot| knot.0 <= row.time_s + 1e-9).unwrap();
            prop_assert_eq!(row.flow_speed_m_s.to_bits(), speed.to_bits());
        }
    }
}

#[test]
fn impossible_profiles_are_refused() {
    #[track_caller]
    fn check(duration_s: f64, window: Window, message: &str) {
        let error = TestProfile::new(duration_s, steps(&[(0.0, 0.245, 0.0)]), vec![window]).unwrap_err();
        assert_eq!(error.to_string(), message);
    }
    let good = Window { from_s: 1.0, to_s: 2.0, commands: [0.0; 3] };
    check(f64::NAN, good, "duration in s = NaN: it must be finite and more than zero");
    check(-1.0, good, "duration in s = -1: it must be finite and more than zero");
    check(0.5, good, "start of a window in s = 1: it must be within the test");
    check(3.0, Window { to_s: 0.5, ..good }, "end of a window in s = 0.5: it must be finite and not before its start");
    let beyond = Window { commands: [0.0, 1.5, 0.0], ..good };
    check(3.0, beyond, "command of a window = 1.5: it must be a fraction of the speed limit within -1 and 1");
    let late = steps(&[(0.0, 0.245, 0.0), (9.0, 0.2, 0.0)]);
    let error = TestProfile::new(3.0, late, vec![good]).unwrap_err().to_string();
    assert_eq!(error, "time of a flow knot in s = 9: it must be within the test");
}
