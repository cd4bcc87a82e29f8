//! Check 26: where the flow steps or ramps between samples, the method keeps its order.

use bat_dynamics::{Flow, FlowHistory, Transition};
use water_channel::{TestProfile, Window};

use crate::reference::{Telling, reference};
use crate::rigs::{assert_close, cost, first_row, flow, flown, kick, steps, weights};

const DURATION_S: f64 = 12.0;
/// Knots that no sample of 0.025 s meets.
const FIRST_S: f64 = 3.011_7;
const SECOND_S: f64 = 6.013_1;
/// DOP853 at 1e-12 over a few hundred restarts, and RK4 at 1.6 ms: both below it.
const SAME: f64 = 1e-9;

fn speed(speed_m_s: f64) -> Flow {
    Flow::straight(speed_m_s)
}

fn stepping(_: f64, piece_s: f64) -> Flow {
    match piece_s {
        t if t < FIRST_S => speed(0.205),
        t if t < SECOND_S => speed(0.245),
        _ => speed(0.225),
    }
}

fn ramping(time_s: f64, piece_s: f64) -> Flow {
    let share = |from_s: f64, to_s: f64| (time_s - from_s) / (to_s - from_s);
    match piece_s {
        t if t < FIRST_S => speed(0.205 + 0.04 * share(0.0, FIRST_S)),
        t if t < SECOND_S => {
            Flow { speed_m_s: 0.245 - 0.02 * share(FIRST_S, SECOND_S), direction_rad: 0.2 * share(FIRST_S, SECOND_S) }
        }
        _ => Flow { speed_m_s: 0.225, direction_rad: 0.2 },
    }
}

fn turning(_: f64, piece_s: f64) -> Flow {
    match piece_s {
        t if t < FIRST_S => Flow { speed_m_s: 0.245, direction_rad: 0.0 },
        t if t < SECOND_S => Flow { speed_m_s: 0.245, direction_rad: 10f64.to_radians() },
        _ => Flow { speed_m_s: 0.245, direction_rad: -5f64.to_radians() },
    }
}

/// Costs at 1, 2 and 4 steps per sample approach the reference with order 4, and a fine step meets it.
#[track_caller]
fn check(history: FlowHistory, telling: fn(f64, f64) -> Flow, sample_time_s: f64) {
    let windows: Vec<Window> = kick(1.0);
    let mut request = first_row();
    request.rig.sample_time_s = sample_time_s;
    let profile = TestProfile::new(DURATION_S, history, windows.clone()).unwrap();
    // The same step of 1.6 ms at every sample time.
    let fine = flown(&request, &profile, (sample_time_s / 0.025 * 16.0).ceil() as usize);
    let test = Telling { duration_s: DURATION_S, knots_s: &[FIRST_S, SECOND_S], flow: telling, windows: &windows };
    let truth = reference(&request, &test, &fine.trim.state, &weights());

    assert_close(cost(&fine), truth.cost, SAME * truth.cost, "cost with a fine step");
    for (found, expected) in fine.final_state.iter().zip(truth.final_state) {
        assert_close(*found, expected, SAME, "final state");
    }
    let errors = [1, 2, 4].map(|steps| (cost(&flown(&request, &profile, steps)) - truth.cost).abs());
    for pair in errors.windows(2) {
        let slope = (pair[0] / pair[1]).log2();
        assert!((3.5..5.0).contains(&slope), "slope {slope} of the errors {errors:?}");
    }
}

#[test]
fn flow_steps_between_samples_keep_the_order() {
    check(steps(&[(0.0, 0.205, 0.0), (FIRST_S, 0.245, 0.0), (SECOND_S, 0.225, 0.0)]), stepping, 0.025);
}

#[test]
fn flow_ramps_keep_the_order() {
    let knots = [(0.0, 0.205, 0.0), (FIRST_S, 0.245, 0.0), (SECOND_S, 0.225, 0.2_f64.to_degrees())];
    check(flow(&knots, Transition::Linear), ramping, 0.025);
}

#[test]
fn flow_turns_between_samples_keep_the_order() {
    check(steps(&[(0.0, 0.245, 0.0), (FIRST_S, 0.245, 10.0), (SECOND_S, 0.245, -5.0)]), turning, 0.025);
}

#[test]
fn order_holds_at_other_sample_times() {
    let knots = [(0.0, 0.205, 0.0), (FIRST_S, 0.245, 0.0), (SECOND_S, 0.225, 0.0)];
    check(steps(&knots), stepping, 0.05);
    check(steps(&knots), stepping, 0.01);
}

#[test]
fn test_that_ends_between_samples_ends_there() {
    let request = first_row();
    let windows = kick(1.0);
    let profile = TestProfile::new(2.512, steps(&[(0.0, 0.245, 0.0)]), windows.clone()).unwrap();
    let fine = flown(&request, &profile, 16);
    let test = Telling { duration_s: 2.512, knots_s: &[], flow: |_, _| Flow::straight(0.245), windows: &windows };
    let truth = reference(&request, &test, &fine.trim.state, &weights());
    assert_close(cost(&fine), truth.cost, SAME * truth.cost, "cost");
    assert_close(fine.integrals.duration_s, 2.512, 0.0, "duration");
}
