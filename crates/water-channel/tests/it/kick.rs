//! Check 37: what a pull at the port line does, as Section 3.2 tells it.

use bat_dynamics::{Fidelity, TetherLayout};
use water_channel::LogRow;

use crate::rigs::{logged, request, short_test};

/// The rows of a flight with the pull at 1–2 s and the hold to 4 s, from the pull on.
fn response(fidelity: Fidelity, layout: TetherLayout) -> (LogRow, Vec<LogRow>) {
    let mut request = request(fidelity, 46.1, 17.3);
    request.rig.plant.layout = layout;
    let mut rows = logged(&request, &short_test(30.0)).rows;
    let pulled = rows.split_off(40);
    (pulled[0], pulled)
}

#[test]
fn pull_at_the_port_line_rolls_to_port_lifts_the_nose_and_lowers_the_body() {
    for fidelity in [Fidelity::NUMERICAL, Fidelity::STALLED_WITH_ADDED_MASS] {
        let (before, rows) = response(fidelity, TetherLayout::OneForwardTwoAft);
        let at_the_end_of_the_pull = &rows[40];
        assert!(at_the_end_of_the_pull.roll_rad < -0.05, "port side down: {}", at_the_end_of_the_pull.roll_rad);
        let nose = at_the_end_of_the_pull.pitch_rad - before.pitch_rad;
        assert!(nose > 0.03, "nose up: {nose}");
        let rise = at_the_end_of_the_pull.altitude_m - before.altitude_m;
        assert!(rise < -0.001, "lower: {rise}");
        let swing = rows.iter().fold(0.0_f64, |peak, row| peak.max(row.heading_rad.abs()));
        assert!(swing > 0.05, "the heading swings: {swing}");
    }
}

#[test]
fn controller_brings_the_body_back_to_its_set_points() {
    for layout in [TetherLayout::OneForwardTwoAft, TetherLayout::TwoForwardOneAft] {
        let (_, rows) = response(Fidelity::NUMERICAL, layout);
        let last = rows.last().unwrap();
        assert!(last.roll_error_rad.abs() < 1e-3, "roll: {}", last.roll_error_rad);
        assert!(last.pitch_error_rad.abs() < 1e-3, "pitch: {}", last.pitch_error_rad);
        assert!(last.altitude_error_m.abs() < 1e-3, "altitude: {}", last.altitude_error_m);
        assert!(last.heading_rad.abs() < 2e-3, "heading: {}", last.heading_rad);
    }
}

/// With two lines forward the port line pulls the nose down; roll and altitude go as before.
#[test]
fn pull_at_a_forward_port_line_lowers_the_nose() {
    let (before, rows) = response(Fidelity::NUMERICAL, TetherLayout::TwoForwardOneAft);
    let after = &rows[40];
    assert!(after.roll_rad < -0.05, "port side down: {}", after.roll_rad);
    assert!(after.pitch_rad - before.pitch_rad < -0.03, "nose down: {}", after.pitch_rad - before.pitch_rad);
    assert!(after.altitude_m - before.altitude_m < -0.001, "lower: {}", after.altitude_m - before.altitude_m);
}

/// A pull at the other line is the mirror image, number by number.
#[test]
fn pull_at_the_starboard_line_mirrors_the_flight() {
    let request = request(Fidelity::STALLED_WITH_ADDED_MASS, 46.1, 17.3);
    let port = short_test(10.0);
    let mut windows = port.windows().to_vec();
    for window in &mut windows {
        window.commands.swap(1, 2);
    }
    let starboard = water_channel::TestProfile::new(10.0, port.flow().clone(), windows).unwrap();
    let (left, right) = (logged(&request, &port), logged(&request, &starboard));
    for (left, right) in left.rows.iter().zip(&right.rows) {
        // Rounding of sums taken in another order, over ten seconds.
        let same = |a: f64, b: f64| (a - b).abs() < 1e-12;
        assert!(same(left.roll_rad, -right.roll_rad), "roll at t = {}", left.time_s);
        assert!(same(left.heading_rad, -right.heading_rad), "heading at t = {}", left.time_s);
        assert!(same(left.lateral_m, -right.lateral_m), "lateral at t = {}", left.time_s);
        assert!(same(left.pitch_rad, right.pitch_rad), "pitch at t = {}", left.time_s);
        assert!(same(left.altitude_m, right.altitude_m), "altitude at t = {}", left.time_s);
        assert!(same(left.tensions_n[1], right.tensions_n[2]), "tensions at t = {}", left.time_s);
    }
}
