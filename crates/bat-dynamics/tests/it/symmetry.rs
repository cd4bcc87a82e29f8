//! What does not change when the whole experiment is turned, mirrored or carried along.
//!
//! A Galilean change of frame in full would need winches that move: the crate has none. What it can show is that fluid
//! forces depend on the motion relative to the flow alone, and that a body carried by the flow feels none.

use bat_dynamics::{
    Evaluation, Fidelity, FlightState, Flow, Plant, Tensions, aerodynamic_wrench, evaluate, generalized_forces,
};
use nalgebra::{Matrix3, Vector3};

use crate::oracle::{self, fly};
use crate::plants::{Sample, everything};

#[test]
fn turning_the_flow_and_the_azimuth_together_changes_nothing() {
    let mut sample = Sample(21);
    let plant = Plant::new(&everything(), Fidelity::STALLED_WITH_ADDED_MASS).unwrap();
    for _ in 0..500 {
        let (state, command) = (sample.state(), sample.array(-0.02, 0.02));
        let flow = Flow { speed_m_s: sample.within(0.1, 0.4), direction_rad: sample.within(-1.0, 1.0) };
        let turn = sample.within(-3.0, 3.0);
        let mut turned = state;
        turned[1] += turn;
        let before = evaluate(&plant, &state, command, &flow);
        let after = evaluate(&plant, &turned, command, &Flow { direction_rad: flow.direction_rad + turn, ..flow });
        for (k, (a, b)) in before.derivative.iter().zip(after.derivative).enumerate() {
            assert!((a - b).abs() < 1e-12 * a.abs().max(10.0), "rate {k}: {a} and {b} at {state:?}");
        }
        for ((line, a), (_, b)) in before.tensions.named().iter().zip(after.tensions.named()) {
            assert!((a - b).abs() < 1e-12, "{line}: {a} N and {b} N");
        }
        assert!((before.sight.heading_rad - after.sight.heading_rad).abs() < 1e-12, "heading from the flow");
        assert!((before.sight.altitude_m - after.sight.altitude_m).abs() < 1e-12, "altitude");
    }
}

pub(crate) fn mirrored(state: &FlightState) -> FlightState {
    let [zenith, azimuth, twist, zenith_rate, azimuth_rate, twist_rate, l1, l2, l3, u1, u2, u3] = *state;
    [zenith, -azimuth, -twist, zenith_rate, -azimuth_rate, -twist_rate, l1, l3, l2, u1, u3, u2]
}

/// That an evaluation is the mirror image of another, bit for bit.
#[track_caller]
pub(crate) fn assert_mirrored(left: &Evaluation, right: &Evaluation, state: &FlightState) {
    assert_eq!(left.derivative, mirrored(&right.derivative), "at {state:?}");
    let Tensions { center_n, starboard_n, port_n } = right.tensions;
    assert_eq!(left.tensions, Tensions { center_n, starboard_n: port_n, port_n: starboard_n }, "at {state:?}");
    let (l, r) = (left.sight, right.sight);
    assert_eq!([l.forward_m, l.right_m, l.altitude_m], [r.forward_m, -r.right_m, r.altitude_m], "at {state:?}");
    assert_eq!([l.roll_rad, l.pitch_rad, l.heading_rad], [-r.roll_rad, r.pitch_rad, -r.heading_rad], "at {state:?}");
}

#[test]
fn mirrored_states_have_mirrored_rates_bit_for_bit() {
    let mut sample = Sample(22);
    let plant = Plant::new(&everything(), Fidelity::STALLED_WITH_ADDED_MASS).unwrap();
    for _ in 0..500 {
        let (state, [a, b, c]) = (sample.state(), sample.array(-0.02, 0.02));
        let (speed_m_s, direction_rad) = (sample.within(0.1, 0.4), sample.within(-1.0, 1.0));
        let right = evaluate(&plant, &state, [a, b, c], &Flow { speed_m_s, direction_rad });
        let left = evaluate(&plant, &mirrored(&state), [a, c, b], &Flow { speed_m_s, direction_rad: -direction_rad });
        assert_mirrored(&left, &right, &state);
    }
}

#[test]
fn flight_in_the_plane_of_symmetry_stays_exactly_there() {
    let plant = Plant::new(&everything(), Fidelity::STALLED_WITH_ADDED_MASS).unwrap();
    let start = [0.3, 0.0, 0.0, 0.4, 0.0, 0.0, 0.62, 0.605, 0.605, 0.0, 0.0, 0.0];
    let end = fly(start, 5e-3, 4000, |t, x| {
        evaluate(&plant, x, [0.004 * t.sin(), -0.002 * t.cos(), -0.002 * t.cos()], &Flow::straight(0.25)).derivative
    });
    assert_eq!([end[1], end[2], end[4], end[5], end[7] - end[8]], [0.0; 5], "{end:?}");
    assert!((end[0] - start[0]).abs() > 1e-3, "the case moves: {end:?}");
}

#[test]
fn body_carried_along_by_the_flow_feels_no_force() {
    let mut sample = Sample(23);
    let mut p = everything();
    p.tether.drag_coefficient = 0.0;
    let plant = Plant::new(&p, Fidelity::STALLED).unwrap();
    for _ in 0..100 {
        let q = sample.coordinates();
        let flow = Flow { speed_m_s: sample.within(0.1, 0.4), direction_rad: sample.within(-3.0, 3.0) };
        // Rates of Phi, Theta, L_t for the velocity of the flow at the joint, of the others for no rotation.
        let unit = |k: usize| core::array::from_fn(|i| if i == k { 1.0 } else { 0.0 });
        let joint = |k| oracle::velocity(&q, &unit(k), Vector3::zeros());
        let turn = |k| oracle::angular_velocity(&q, &unit(k));
        let of_joint = Matrix3::from_columns(&[joint(0), joint(1), joint(3)]);
        let [zenith, azimuth, length]: [f64; 3] = of_joint.lu().solve(&oracle::flow_velocity(&flow)).unwrap().into();
        let left = -(turn(0) * zenith + turn(1) * azimuth);
        let of_body = Matrix3::from_columns(&[turn(2), turn(4), turn(5)]);
        let [twist, pitch, roll]: [f64; 3] = of_body.lu().solve(&left).unwrap().into();
        let tau = generalized_forces(&plant, &q, &[zenith, azimuth, twist, length, pitch, roll], &flow);
        // Rounding of the relative velocity is all that is left: it enters squared.
        assert!(tau.amax() < 1e-14, "{tau} at {q:?}");
    }
}

#[test]
fn fluid_forces_depend_on_relative_motion_alone() {
    let mut sample = Sample(24);
    let mut p = everything();
    p.tether.drag_coefficient = 0.0;
    let plant = Plant::new(&p, Fidelity::STALLED).unwrap();
    for _ in 0..100 {
        let (q, rate) = (sample.coordinates(), sample.rates());
        let r = oracle::rotation(&q);
        let flow = Flow { speed_m_s: sample.within(0.1, 0.4), direction_rad: sample.within(-3.0, 3.0) };
        let relative = oracle::velocity(&q, &rate, Vector3::zeros()) - oracle::flow_velocity(&flow);
        let (force, moment) =
            aerodynamic_wrench(&plant, (r.transpose() * relative).into(), oracle::angular_velocity(&q, &rate).into());
        let found = generalized_forces(&plant, &q, &rate, &flow);
        for k in 0..6 {
            let unit = core::array::from_fn(|i| if i == k { 1.0 } else { 0.0 });
            let expected = oracle::velocity(&q, &unit, Vector3::zeros()).dot(&(r * Vector3::from(force)))
                + oracle::angular_velocity(&q, &unit).dot(&Vector3::from(moment));
            assert!((found[k] - expected).abs() < 1e-11, "row {k}: {} against {expected}", found[k]);
        }
    }
}
