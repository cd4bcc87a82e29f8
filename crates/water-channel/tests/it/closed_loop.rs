//! Modes of the sampled loop: independent eigenvalues, and the flight itself as the judge.

use bat_dynamics::{Fidelity, Flow, Plant, TetherLayout, driven_of_lines};
use nalgebra::{Complex, SVector};
use serde_json::Value;
use tether_control::{ControllerState, Measurement, Mixing};
use water_channel::{ClosedLoop, TestProfile, closed_loop_modes};

use crate::rigs::{assert_close, first_row, golden, kick, logged, numbers, request, request_of, steps};

/// What the golden file promises of its eigenvalues, with a decade for the multiplier's logarithm.
const EIGENVALUES: f64 = 1e-7;
/// The largest entry of the golden A is of order 100, its tolerance 1e-10 of that.
const MAP: f64 = 1e-9;

fn complex(pairs: &Value) -> Vec<Complex<f64>> {
    pairs.as_array().unwrap().iter().map(numbers).map(|pair| Complex::new(pair[0], pair[1])).collect()
}

/// Every eigenvalue of the loop, conjugates included.
fn all(of: &ClosedLoop, value: fn(&water_channel::SampledMode) -> Complex<f64>) -> Vec<Complex<f64>> {
    let both = |one: Complex<f64>| if one.im > 0.0 { vec![one, one.conj()] } else { vec![one] };
    of.modes.iter().flat_map(|mode| both(value(mode))).collect()
}

#[track_caller]
fn assert_same_set(found: &[Complex<f64>], expected: &[Complex<f64>], tolerance: f64, what: &str) {
    assert_eq!(found.len(), expected.len(), "{what}: number of eigenvalues");
    let mut left = found.to_vec();
    for one in expected {
        let nearest =
            (0..left.len()).min_by(|a, b| (left[*a] - one).norm().total_cmp(&(left[*b] - one).norm())).unwrap();
        let nearest = left.swap_remove(nearest);
        assert!((nearest - one).norm() <= tolerance, "{what}: {nearest}, expected {one} within {tolerance:e}");
    }
}

fn loop_of(case: &Value) -> ClosedLoop {
    closed_loop_modes(&request_of(case), &Flow::straight(case["flow_speed"].as_f64().unwrap())).unwrap()
}

#[test]
fn eigenvalues_match_an_independent_linearization() {
    let golden = golden("water-channel/eigenvalues.json");
    let cases = golden["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 5, "cases in the golden file");
    for case in cases {
        let found = loop_of(case);
        let name = case["name"].as_str().unwrap();
        assert_close(found.trim.coordinates[0], case["trim"]["Phi"].as_f64().unwrap(), 1e-10, name);
        let multipliers = all(&found, |mode| mode.multiplier);
        assert_same_set(&multipliers, &complex(&case["sampled_loop_multipliers"]), MAP, name);
        let rates = all(&found, |mode| mode.mode.eigenvalue);
        assert_same_set(&rates, &complex(&case["sampled_loop"]), EIGENVALUES, name);
        assert!(found.is_stable(), "{name}: every golden loop is stable");
    }
}

#[test]
fn modes_are_sorted_and_their_shares_are_by_name() {
    let found = closed_loop_modes(&request(Fidelity::NUMERICAL, 48.0, 8.0), &Flow::straight(0.245)).unwrap();
    let rates: Vec<f64> = found.modes.iter().map(|mode| mode.mode.eigenvalue.re).collect();
    assert!(rates.is_sorted_by(|a, b| a >= b), "slowest decay first: {rates:?}");
    for mode in &found.modes {
        let shares = mode.shares().unwrap();
        assert_eq!(shares.len(), ClosedLoop::STATES.len(), "a share per state");
        assert_close(shares.iter().map(|share| share.1).sum(), 1.0, 1e-12, "sum of the shares");
        assert!(shares.is_sorted_by(|a, b| a.1 >= b.1), "largest first: {shares:?}");
        let all = ClosedLoop::STATES.map(|state| state.name);
        assert_close(mode.share_of(&all).unwrap(), 1.0, 1e-12, "share of all states");
        assert_close(mode.share_of(&["no such state"]).unwrap(), 0.0, 0.0, "share of an unknown state");
    }
}

#[test]
fn least_damped_oscillation_is_the_yaw_mode_and_is_lateral() {
    let found = closed_loop_modes(&request(Fidelity::NUMERICAL, 48.0, 8.0), &Flow::straight(0.245)).unwrap();
    let yaw = found.least_damped_oscillation().unwrap();
    // −0.374 ± 1.710i by `generate/eigenvalues.py`, damping ratio 0.21: seen in the flights as the heading that swings after a kick.
    assert_close(yaw.mode.eigenvalue.re, -0.374, 0.001, "real part");
    assert_close(yaw.mode.eigenvalue.im, 1.710, 0.001, "imaginary part");
    assert_close(yaw.mode.damping_ratio(), 0.21, 0.005, "damping ratio");
    assert_close(yaw.mode.natural_frequency_rad_s(), 1.75, 0.005, "natural frequency");
    let longitudinal = ["zenith", "zenith_rate", "line_center", "reel_center", "filter_altitude", "filter_pitch"];
    assert!(yaw.share_of(&longitudinal).unwrap() < 1e-9, "share of the longitudinal states");
    let turning = yaw.share_of(&["azimuth", "twist", "azimuth_rate", "twist_rate"]).unwrap();
    assert!(turning > 0.8, "share of azimuth, twist and their rates: {turning}");
}

/// Plant and controller know nothing of each other's layouts: what is called the same is the same.
#[test]
fn a_layout_is_the_same_to_plant_and_controller() {
    let mut rig = request(Fidelity::NUMERICAL, 48.0, 17.3).rig;
    let default = (TetherLayout::default(), tether_control::TetherLayout::default());
    assert_eq!(format!("{:?}", default.0), format!("{:?}", default.1), "where a file has none");
    for layout in [TetherLayout::OneForwardTwoAft, TetherLayout::TwoForwardOneAft] {
        rig.plant.layout = layout;
        let of_controller = rig.controller().unwrap().parameters().layout;
        let in_files = [serde_json::to_string(&layout).unwrap(), serde_json::to_string(&of_controller).unwrap()];
        assert_eq!(in_files[0], in_files[1], "in files");
        let nose_down_m = Mixing::new(of_controller).line_speeds_m_s([0.0, 0.01, 0.0]);
        let plant = Plant::new(&rig.plant, Fidelity::NUMERICAL).unwrap();
        let [_, induced_pitch, induced_roll] = driven_of_lines(&plant, nose_down_m.map(|line_m| 0.6 + line_m));
        assert!(induced_pitch < -0.1 && induced_roll == 0.0, "{layout:?}: {induced_pitch} rad, {induced_roll} rad");
    }
}

/// The flight itself is the judge of the whole map: filters, mixing, signs, hold and sampling.
#[test]
fn map_predicts_the_next_sample_of_a_flight_near_trim() {
    for (pitch_deg, layout) in [(17.3, TetherLayout::OneForwardTwoAft), (8.0, TetherLayout::TwoForwardOneAft)] {
        let mut request = request(Fidelity::STALLED_WITH_ADDED_MASS, 48.0, pitch_deg);
        request.rig.plant.layout = layout;
        // A gentle kick: a twentieth of the speed for half a second, far from any limit.
        let mut windows = kick(1.0);
        windows.truncate(1);
        windows[0].commands = [0.02, 0.0, -0.05];
        windows[0].to_s = 1.5;
        let profile = TestProfile::new(12.0, steps(&[(0.0, 0.245, 0.0)]), windows).unwrap();
        let log = logged(&request, &profile);
        let found = closed_loop_modes(&request, &Flow::straight(0.245)).unwrap();

        let controller = request.rig.controller().unwrap();
        let mut memory = ControllerState::default();
        let states: Vec<SVector<f64, 15>> = log
            .rows
            .iter()
            .map(|row| {
                let filters = [memory.altitude, memory.pitch, memory.roll].map(|filter| filter.filtered_error);
                let measured =
                    Measurement { altitude_m: row.altitude_m, pitch_rad: row.pitch_rad, roll_rad: row.roll_rad };
                controller.command(&mut memory, &measured);
                SVector::from_fn(|k, _| if k < 12 { row.state[k] - found.trim.state[k] } else { filters[k - 12] })
            })
            .collect();
        let mut compared = 0;
        for (row, pair) in log.rows.iter().zip(states.windows(2)) {
            if row.time_s < 2.0 {
                continue;
            }
            let size = pair[0].norm();
            let wrong = (pair[1] - found.map * pair[0]).norm();
            // What is left is of second order in the departure; its curvature is of order ten.
            assert!(wrong <= 10.0 * size * size + 1e-9, "t = {}: off by {wrong:e} at {size:e}", row.time_s);
            assert!(size > 1e-5, "the disturbance is still there at t = {}: {size:e}", row.time_s);
            compared += 1;
        }
        assert_eq!(compared, 399, "samples compared");
    }
}

#[test]
fn loop_with_a_wrong_sign_is_unstable() {
    let mut wrong = first_row();
    let pitch = wrong.rig.pitch;
    wrong.rig.pitch =
        tether_control::FilteredPd::new(-pitch.proportional(), -pitch.derivative(), pitch.time_constant_s()).unwrap();
    let found = closed_loop_modes(&wrong, &Flow::straight(0.245)).unwrap();
    assert!(!found.is_stable(), "a pitch loop of the wrong sign");
    assert!(found.modes[0].mode.is_unstable(), "the slowest decay is a growth: {:?}", found.modes[0]);
    assert!(
        found.modes[0].share_of(&["line_center", "line_starboard", "line_port"]).unwrap() > 0.5,
        "it is the lines'"
    );
}

#[test]
fn modes_do_not_depend_on_the_direction_of_the_flow() {
    let along = closed_loop_modes(&first_row(), &Flow::straight(0.245)).unwrap();
    let across = closed_loop_modes(&first_row(), &Flow { speed_m_s: 0.245, direction_rad: 2.0 }).unwrap();
    let rates = |of: &ClosedLoop| all(of, |mode| mode.mode.eigenvalue);
    assert_same_set(&rates(&across), &rates(&along), 1e-9, "flow from another side");
}

#[test]
fn rates_tend_to_a_limit_as_the_sample_time_falls() {
    let slowest = |sample_time_s: f64| {
        let mut request = first_row();
        request.rig.sample_time_s = sample_time_s;
        let found = closed_loop_modes(&request, &Flow::straight(0.245)).unwrap();
        found.least_damped_oscillation().unwrap().mode.eigenvalue
    };
    let [coarse, middle, fine] = [0.02, 0.01, 0.005].map(slowest);
    let ratio = (coarse - middle).norm() / (middle - fine).norm();
    // The hold delays by half a sample: an effect of first order.
    assert!((1.8..2.2).contains(&ratio), "halving the sample time halves the effect: {ratio}");
}

#[test]
fn slow_sampling_gives_modes_and_not_nan() {
    let mut request = first_row();
    request.rig.sample_time_s = 200.0;
    let found = closed_loop_modes(&request, &Flow::straight(0.245)).unwrap();
    for mode in &found.modes {
        let rate = mode.mode.eigenvalue;
        assert!(rate.re.is_finite() && rate.im.is_finite() && mode.mode.damping_ratio().is_finite(), "{mode:?}");
        assert!(rate.im <= core::f64::consts::PI / 200.0 * (1.0 + 1e-12), "beyond half the sample rate: {rate}");
    }
}

#[test]
fn modes_of_an_impossible_rig_are_an_error() {
    let mut upright = first_row();
    upright.rig.set_points.pitch_rad = 1.5;
    upright.rig.plant.tether.separation_longitudinal_m = 3.0;
    let error = closed_loop_modes(&upright, &Flow::straight(0.245)).unwrap_err().to_string();
    assert!(error.contains("pitch 1.5 rad is out of the bridle's reach"), "{error}");
    let error = closed_loop_modes(&first_row(), &Flow::straight(-1.0)).unwrap_err().to_string();
    assert_eq!(error, "flow speed in m/s = -1: it must be finite and zero or more");
}
