//! Line lengths, line tensions, slack.

use bat_dynamics::{
    Fidelity, Flow, Parameters, Plant, Slack, Tensions, TetherLayout, TrimHeight, TrimRequest, accelerations,
    driven_of_lines, evaluate, lines_of_driven, trim,
};
use nalgebra::Vector3;

use crate::oracle::{self, fly};
use crate::plants::{POINT_LIFT_N, POINT_MASS_KG, Sample, everything, point_body};

const LAYOUTS: [TetherLayout; 2] = [TetherLayout::OneForwardTwoAft, TetherLayout::TwoForwardOneAft];

#[test]
fn longer_forward_lines_raise_the_nose_and_a_longer_port_line_lowers_starboard() {
    let mut p = everything();
    let plant = |p: &Parameters| Plant::new(p, Fidelity::NUMERICAL).unwrap();
    // One forward: its excess over the mean of the aft pair, over the separation. (1), (2)
    let [length, pitch, roll] = driven_of_lines(&plant(&p), [0.64, 0.60, 0.62]);
    assert!((length - 0.62).abs() < 1e-15, "length {length}");
    assert!((pitch.tan() - 0.03 / p.tether.separation_longitudinal_m).abs() < 1e-14, "pitch {pitch}");
    assert!((roll.tan() - 0.02 / p.tether.separation_lateral_m).abs() < 1e-14, "roll {roll}");
    // Line 1 aft: the same excess lowers the nose.
    p.layout = TetherLayout::TwoForwardOneAft;
    let [_, other_pitch, other_roll] = driven_of_lines(&plant(&p), [0.64, 0.60, 0.62]);
    assert!((other_pitch + pitch).abs() < 1e-15 && (other_roll - roll).abs() < 1e-15, "{other_pitch}, {other_roll}");
}

#[test]
fn lines_and_driven_coordinates_are_inverse() {
    let mut sample = Sample(31);
    for layout in LAYOUTS {
        let mut p = everything();
        p.layout = layout;
        let plant = Plant::new(&p, Fidelity::NUMERICAL).unwrap();
        for _ in 0..100 {
            let driven = [sample.within(0.2, 2.0), sample.within(-1.4, 1.4), sample.within(-1.4, 1.4)];
            let back = driven_of_lines(&plant, lines_of_driven(&plant, driven));
            for k in 0..3 {
                assert!((back[k] - driven[k]).abs() < 1e-14, "{driven:?} became {back:?}");
            }
        }
    }
}

#[test]
fn tensions_do_the_virtual_work_of_the_driven_coordinates() {
    let mut sample = Sample(32);
    for layout in LAYOUTS {
        let mut p = everything();
        p.layout = layout;
        let plant = Plant::new(&p, Fidelity::STALLED).unwrap();
        for _ in 0..100 {
            let (q, rate, driven) = (sample.coordinates(), sample.rates(), sample.array(-1.0, 1.0));
            let at = accelerations(&plant, &q, &rate, driven, &Flow::straight(0.3)).unwrap();
            let lines = lines_of_driven(&plant, [q[3], q[4], q[5]]);
            for (k, (line, found)) in at.tensions.named().into_iter().enumerate() {
                // T_i = -sum over j of (dq_j/dl_i) f_j
                let slope = oracle::slope(1e-4, |t| {
                    let mut moved = lines;
                    moved[k] += t;
                    Vector3::from(driven_of_lines(&plant, moved))
                });
                let expected = -slope.dot(&Vector3::from(at.supplied));
                assert!((found - expected).abs() < 1e-9, "{line}: {found} N against {expected} N at {q:?}");
            }
            let sum: f64 = at.tensions.named().iter().map(|line| line.1).sum();
            assert!(
                (sum + at.supplied[0]).abs() < 1e-13,
                "tensions add to {sum} N, the length takes {:?}",
                at.supplied
            );
        }
    }
}

#[test]
fn tensions_hold_the_moments_at_their_attachments() {
    // With the bridle square to the tether (theta' = phi' = 0) the lines pull along it at three points around the joint.
    let mut p = everything();
    p.tether.linear_density_kg_m = 0.0;
    p.tether.line_diameter_m = 0.0;
    let plant = Plant::new(&p, Fidelity::STALLED).unwrap();
    let flow = Flow::straight(0.3);
    // The pitch at which the induced pitch of the trim is zero.
    let at_pitch =
        |pitch_rad| trim(&plant, &TrimRequest { flow, pitch_rad, height: TrimHeight::TetherLength(0.6) }).unwrap();
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if at_pitch(middle).coordinates[4] < 0.0 { low = middle } else { high = middle }
    }
    let found = at_pitch(low);
    let q = found.coordinates;
    assert!(q[4].abs() < 1e-14, "induced pitch {}", q[4]);

    let down = oracle::rotation(&q).transpose() * Vector3::z();
    let weight = p.body.mass_kg * p.fluid.gravity_m_s2 * down;
    let buoyancy = -p.fluid.density_kg_m3 * p.body.volume_m3 * p.fluid.gravity_m_s2 * down;
    let relative = oracle::rotation(&q).transpose() * -oracle::flow_velocity(&flow);
    let (forces, mut moment) = oracle::aerodynamics(&p, relative, Vector3::zeros());
    let mut force = Vector3::zeros();
    let mut act = |at: Vector3<f64>, f: Vector3<f64>| {
        force += f;
        moment += at.cross(&f);
    };
    act(oracle::point(&p, p.body.center_of_mass_x, p.body.center_of_mass_height_m), weight);
    act(oracle::point(&p, p.body.center_of_buoyancy_x, p.body.center_of_buoyancy_height_m), buoyancy);
    for (at, f) in oracle::centers(&p).into_iter().zip(forces) {
        act(at, f);
    }
    let (long, lateral) = (p.tether.separation_longitudinal_m, p.tether.separation_lateral_m);
    let Tensions { center_n, starboard_n, port_n } = found.tensions;
    act(Vector3::new(2.0 / 3.0 * long, 0.0, 0.0), center_n * Vector3::z());
    act(Vector3::new(-1.0 / 3.0 * long, 0.5 * lateral, 0.0), starboard_n * Vector3::z());
    act(Vector3::new(-1.0 / 3.0 * long, -0.5 * lateral, 0.0), port_n * Vector3::z());
    assert!(force.z.abs() < 1e-12, "left along the tether: {} N", force.z);
    assert!(moment.amax() < 1e-12, "left about the joint: {moment}");
    // In still air and at rest the sum of the lines would be the excess buoyancy; here the lift is added to it.
    assert!(center_n + starboard_n + port_n > 0.0, "tensions {:?}", found.tensions);
}

#[test]
fn winches_follow_their_commands_with_lag_and_limit() {
    let p = everything();
    let plant = Plant::new(&p, Fidelity::NUMERICAL).unwrap();
    let limit = p.winch.speed_limit_m_s;
    assert_eq!(plant.speed_limit_m_s(), limit, "limit");
    let mut sample = Sample(33);
    for _ in 0..100 {
        let (state, command) = (sample.state(), sample.array(-2.0 * limit, 2.0 * limit));
        let at = evaluate(&plant, &state, command, &Flow::straight(0.2)).derivative;
        for k in 0..3 {
            assert_eq!(at[k], state[k + 3], "rate of a free coordinate");
            assert_eq!(at[k + 6], state[k + 9], "line speed");
            let expected = (command[k].clamp(-limit, limit) - state[k + 9]) / p.winch.time_constant_s;
            assert!((at[k + 9] - expected).abs() < 1e-14, "line {k}: {} against {expected}", at[k + 9]);
        }
    }
}

#[test]
fn flight_state_and_coordinates_have_the_same_accelerations() {
    let mut sample = Sample(34);
    for layout in LAYOUTS {
        let mut p = everything();
        p.layout = layout;
        let plant = Plant::new(&p, Fidelity::STALLED_WITH_ADDED_MASS).unwrap();
        for _ in 0..100 {
            let (state, command) = (sample.state(), sample.array(-0.02, 0.02));
            let flow = Flow { speed_m_s: 0.3, direction_rad: sample.within(-1.0, 1.0) };
            let found = evaluate(&plant, &state, command, &flow);
            let (q, rate) = oracle::coordinates(&p, &state);
            // The driven accelerations as the slope of the driven rates along the winches' motion.
            let driven = oracle::slope(1e-3, |t| {
                let moved = core::array::from_fn(|k| {
                    let bend = if (6..9).contains(&k) { 0.5 * t * t * found.derivative[k + 3] } else { 0.0 };
                    state[k] + t * found.derivative[k] + bend
                });
                let rate = oracle::coordinates(&p, &moved).1;
                Vector3::new(rate[3], rate[4], rate[5])
            });
            let at = accelerations(&plant, &q, &rate, driven.into(), &flow).unwrap();
            for k in 0..3 {
                let (a, b) = (found.derivative[k + 3], at.free_rad_s2[k]);
                assert!((a - b).abs() < 1e-9 * b.abs().max(10.0), "acceleration {k}: {a} against {b}");
            }
            for ((line, a), (_, b)) in found.tensions.named().into_iter().zip(at.tensions.named()) {
                assert!((a - b).abs() < 1e-9, "{line}: {a} N against {b} N");
            }
        }
    }
}

#[test]
fn slack_is_found_at_the_time_of_its_closed_form() {
    // Near the vertical and from rest, all lines paid out at once: L'' = (u/tau) exp(-t/tau) and the lines have
    // F - m L'' together, so that they become taut at t = tau ln(m u / (tau F)).
    let mut p = point_body();
    p.winch.time_constant_s = 0.1;
    p.winch.speed_limit_m_s = 1.0;
    let plant = Plant::new(&p, Fidelity::NUMERICAL).unwrap();
    let crossing = 0.1 * (POINT_MASS_KG * 1.0 / (0.1 * POINT_LIFT_N)).ln();
    assert!((0.05..0.2).contains(&crossing), "the case crosses at {crossing} s");
    let mut state = [1e-5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.6, 0.6, 0.6, 0.0, 0.0, 0.0];
    let mut first_taut = None;
    for step in 0..300 {
        let at = evaluate(&plant, &state, [1.0; 3], &Flow::straight(0.0));
        match (at.tensions.slack(), first_taut) {
            (None, None) => first_taut = Some(f64::from(step) * 1e-3),
            (Some(slack), Some(_)) => panic!("slack again: {slack:?}"),
            (Some(slack), None) => assert_eq!(slack.tension_n, at.tensions.margin_n(), "margin"),
            _ => {}
        }
        state = fly(state, 1e-3, 1, |_, x| evaluate(&plant, x, [1.0; 3], &Flow::straight(0.0)).derivative);
    }
    let found = first_taut.unwrap();
    assert!((0.0..1e-3).contains(&(found - crossing)), "taut from {found} s, closed form {crossing} s");
}

#[test]
fn slack_names_the_slackest_line() {
    let taut = Tensions { center_n: 0.1, starboard_n: 0.0, port_n: 0.2 };
    assert_eq!(taut.slack(), None);
    assert_eq!(taut.margin_n(), 0.0);
    let two = Tensions { center_n: 0.1, starboard_n: -0.2, port_n: -0.3 };
    assert_eq!(two.slack(), Some(Slack { line: "port", tension_n: -0.3 }));
    assert_eq!(two.margin_n(), -0.3);
}
