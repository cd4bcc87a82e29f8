//! Equilibria: that they are, that they stay, and why there is none.

use bat_dynamics::{
    Error, Fidelity, Flow, NoTrim, Parameters, Plant, Trim, TrimHeight, TrimRequest, evaluate, sight, trim,
    trim_with_lines,
};

use crate::oracle::{self, fly};
use crate::plants::{everything, point_body, rig};

const FIDELITIES: [Fidelity; 4] =
    [Fidelity::NUMERICAL, Fidelity::STALLED, Fidelity::ADDED_MASS, Fidelity::STALLED_WITH_ADDED_MASS];

fn request(speed_m_s: f64, pitch_deg: f64, altitude_m: f64) -> TrimRequest {
    TrimRequest {
        flow: Flow { speed_m_s, direction_rad: 0.3 },
        pitch_rad: pitch_deg.to_radians(),
        height: TrimHeight::Altitude(altitude_m),
    }
}

#[track_caller]
fn no_trim(p: &Parameters, request: TrimRequest) -> NoTrim {
    match trim(&Plant::new(p, Fidelity::NUMERICAL).unwrap(), &request) {
        Err(Error::NoTrim(reason)) => reason,
        other => panic!("expected no trim, found {other:?}"),
    }
}

#[test]
fn trim_leaves_no_residual_and_holds_what_was_asked() {
    for p in [rig(), everything()] {
        for fidelity in FIDELITIES {
            let plant = Plant::new(&p, fidelity).unwrap();
            for (speed, pitch) in [(0.205, 5.0), (0.245, 17.3), (0.285, 22.0)] {
                let asked = request(speed, pitch, 0.61);
                let Trim { state, residual, tensions, coordinates } = trim(&plant, &asked).unwrap();
                let lift = 9.81 * (1000.0 * p.body.volume_m3 - p.body.mass_kg);
                for (row, left) in residual.into_iter().enumerate() {
                    assert!(left.abs() < 1e-12 * lift, "row {row}: {left}");
                }
                for (k, rate) in evaluate(&plant, &state, [0.0; 3], &asked.flow).derivative.into_iter().enumerate() {
                    assert!(rate.abs() < 1e-10, "rate {k} at trim: {rate}");
                }
                let seen = sight(&plant, &state, &asked.flow);
                assert!((seen.pitch_rad - asked.pitch_rad).abs() < 1e-14, "pitch {}", seen.pitch_rad);
                assert!((seen.altitude_m - 0.61).abs() < 1e-14, "altitude {}", seen.altitude_m);
                assert!(seen.roll_rad.abs() < 1e-14 && seen.heading_rad.abs() < 1e-14, "{seen:?}");
                assert!(tensions.margin_n() > 0.0, "tensions {tensions:?}");
                let (q, _) = oracle::coordinates(&p, &state);
                for k in 0..6 {
                    assert!((q[k] - coordinates[k]).abs() < 1e-14, "coordinate {k}: {} and {}", q[k], coordinates[k]);
                }
            }
        }
    }
}

#[test]
fn trim_is_the_first_fall_of_the_moment_through_zero() {
    let p = rig();
    let plant = Plant::new(&p, Fidelity::NUMERICAL).unwrap();
    let asked = request(0.245, 12.0, 0.61);
    let found = trim(&plant, &asked).unwrap().coordinates;
    // The moment on Phi from the second description of the plant.
    let moment = |zenith: f64| {
        let center = |q: &[f64; 6]| {
            -oracle::position(q, oracle::point(&p, p.body.center_of_mass_x, p.body.center_of_mass_height_m)).z
        };
        let mut q = [zenith, 0.3, 0.0, 0.6, asked.pitch_rad - zenith, 0.0];
        q[3] += (0.61 - center(&q)) / zenith.cos();
        let unit = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        let moved = |t: f64| core::array::from_fn(|k| q[k] + t * unit[k]);
        oracle::generalized_forces(&p, &q, &[0.0; 6], &asked.flow)[0]
            - oracle::slope(1e-2, |t| oracle::potential_energy(&p, &moved(t)))
    };
    assert!(moment(found[0]).abs() < 1e-12, "moment at the trim: {}", moment(found[0]));
    for k in 1..100 {
        let zenith = found[0] * f64::from(k) / 100.0;
        assert!(moment(zenith) > 0.0, "moment {} at Phi = {zenith}, before the trim", moment(zenith));
    }
    assert!(moment(found[0] + 1e-3) < 0.0, "moment after the trim");
}

#[test]
fn trimmed_flight_stays_where_it_is_for_100_seconds() {
    // A stable design: an unstable one leaves its equilibrium from rounding alone.
    let mut p = rig();
    p.body.center_of_mass_x = 0.48;
    for fidelity in FIDELITIES {
        let plant = Plant::new(&p, fidelity).unwrap();
        let asked = request(0.245, 8.0, 0.61);
        let start = trim(&plant, &asked).unwrap().state;
        let end = fly(start, 0.0125, 8000, |_, x| evaluate(&plant, x, [0.0; 3], &asked.flow).derivative);
        for k in 0..12 {
            assert!((end[k] - start[k]).abs() < 1e-8, "state {k} moved from {} to {}", start[k], end[k]);
        }
    }
}

#[test]
fn lighter_flow_leaves_no_zenith_angle() {
    let reason = no_trim(&point_body(), request(0.0, 0.0, 0.6));
    assert!(matches!(reason, NoTrim::AtZenith { flow_speed_m_s, .. } if flow_speed_m_s == 0.0), "{reason:?}");
    assert!(reason.to_string().contains("Phi = 0"), "{reason}");
}

#[test]
fn heavy_body_is_blown_down() {
    let mut p = rig();
    p.body.mass_kg = 0.3;
    let reason = no_trim(&p, request(0.2, 0.0, 0.6));
    assert!(matches!(reason, NoTrim::BlownDown { .. }), "{reason:?}");
    assert!(reason.to_string().contains("too little lift"), "{reason}");
}

#[test]
fn pitch_beyond_the_bridle_is_out_of_reach() {
    // More than a quarter turn of induced pitch.
    let mut p = point_body();
    p.hull.area_m2 = 0.05;
    p.hull.drag_zero_lift = 1.0;
    let reason = no_trim(&p, request(0.3, -50.0, 0.6));
    assert!(matches!(reason, NoTrim::PitchOutOfReach { induced_rad, .. } if induced_rad < -1.57), "{reason:?}");
    // Lines too short for the difference that the angle takes.
    let reason = no_trim(&p, TrimRequest { height: TrimHeight::TetherLength(0.02), ..request(0.1, -30.0, 0.6) });
    assert!(
        matches!(reason, NoTrim::PitchOutOfReach { shortest_line_m, induced_rad, .. } if shortest_line_m < 0.0 && induced_rad > -1.57),
        "{reason:?}"
    );
    assert!(reason.to_string().contains("out of the bridle's reach"), "{reason}");
}

#[test]
fn altitude_below_the_depth_of_the_joint_is_out_of_reach() {
    // The center of mass is 0.04 m above the joint: at 0.03 m the joint would be below the winches.
    let p = rig();
    let reason = no_trim(&p, request(0.245, 0.0, 0.03));
    let joint = 0.03 - p.body.center_of_mass_height_m;
    assert!(
        matches!(reason, NoTrim::AltitudeOutOfReach { altitude_m, joint_m } if altitude_m == 0.03 && (joint_m - joint).abs() < 1e-12),
        "{reason:?}"
    );
    assert!(reason.to_string().contains("altitude 0.03 m"), "{reason}");
}

#[test]
fn meaningless_requests_are_refused_by_name() {
    let plant = Plant::new(&rig(), Fidelity::NUMERICAL).unwrap();
    let good = request(0.245, 8.0, 0.61);
    let cases = [
        (TrimRequest { flow: Flow::straight(-0.1), ..good }, "flow speed"),
        (TrimRequest { flow: Flow::straight(f64::NAN), ..good }, "flow speed"),
        (TrimRequest { flow: Flow { speed_m_s: 0.2, direction_rad: f64::INFINITY }, ..good }, "flow direction"),
        (TrimRequest { pitch_rad: f64::NAN, ..good }, "pitch set point"),
        (TrimRequest { pitch_rad: 1.6, ..good }, "pitch set point"),
        (TrimRequest { pitch_rad: core::f64::consts::FRAC_PI_2, ..good }, "pitch set point"),
        (TrimRequest { height: TrimHeight::TetherLength(0.0), ..good }, "tether length"),
        (TrimRequest { height: TrimHeight::Altitude(f64::NAN), ..good }, "altitude set point"),
    ];
    for (request, name) in cases {
        let error = trim(&plant, &request).unwrap_err();
        assert!(matches!(error, Error::Argument { .. }) && error.to_string().contains(name), "{name}: {error}");
    }
}

/// Lines that were trimmed at one speed, held at that and at another.
#[test]
fn trim_with_held_lines_is_the_trim_they_came_from_and_an_equilibrium_elsewhere() {
    for p in [rig(), everything()] {
        for fidelity in FIDELITIES {
            let plant = Plant::new(&p, fidelity).unwrap();
            let asked = request(0.205, 12.0, 0.61);
            let first = trim(&plant, &asked).unwrap();
            let lines = [first.state[6], first.state[7], first.state[8]];
            let again = trim_with_lines(&plant, lines, &asked.flow).unwrap();
            for k in 0..12 {
                assert!((again.state[k] - first.state[k]).abs() < 1e-12, "state {k} of the same trim");
            }
            let faster = Flow { speed_m_s: 0.285, ..asked.flow };
            let held = trim_with_lines(&plant, lines, &faster).unwrap();
            assert_eq!(
                held.coordinates[4].to_bits(),
                again.coordinates[4].to_bits(),
                "the induced pitch is the lines'"
            );
            assert!(
                (held.coordinates[0] - first.coordinates[0]).abs() > 1e-3,
                "the body moves to another zenith angle"
            );
            for (k, line) in lines.iter().enumerate() {
                assert!((held.state[6 + k] - line).abs() < 1e-14, "line {k}");
            }
            for (k, rate) in evaluate(&plant, &held.state, [0.0; 3], &faster).derivative.into_iter().enumerate() {
                assert!(rate.abs() < 1e-10, "rate {k} at the trim with held lines: {rate}");
            }
        }
    }
}

#[test]
fn trim_with_held_lines_refuses_what_would_rest_rolled() {
    let plant = Plant::new(&rig(), Fidelity::NUMERICAL).unwrap();
    let flow = Flow { speed_m_s: 0.245, direction_rad: 0.0 };
    for (lines, words) in [
        ([0.6, 0.6, 0.61], "starboard line less port line"),
        ([0.6, -0.6, 0.6], "length of a line"),
        ([f64::NAN, 0.6, 0.6], "length of a line"),
    ] {
        let error = trim_with_lines(&plant, lines, &flow).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
}
