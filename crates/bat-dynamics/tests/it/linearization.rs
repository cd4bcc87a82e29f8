//! Linearization against differences, against a stored independent one, and where it does not exist.

use bat_dynamics::{
    Error, Fidelity, Flow, Linearization, Parameters, Plant, TetherLayout, TrimHeight, TrimRequest, Variable, evaluate,
    linearize, modes, trim,
};
use nalgebra::{Complex, DMatrix, SMatrix};
use serde_json::Value;

use crate::oracle;
use crate::plants::{everything, rig, without_surfaces};

const STATE: [f64; 12] = [0.3, 0.1, -0.05, 0.1, -0.2, 0.15, 0.62, 0.6, 0.61, 0.004, -0.003, 0.002];
const COMMAND: [f64; 3] = [0.005, -0.004, 0.003];
const FLOW: Flow = Flow { speed_m_s: 0.25, direction_rad: 0.2 };

#[test]
fn derivatives_agree_with_central_differences() {
    for fidelity in [Fidelity::NUMERICAL, Fidelity::STALLED_WITH_ADDED_MASS] {
        let plant = Plant::new(&everything(), fidelity).unwrap();
        let Linearization { a, b, c, d, .. } = linearize(&plant, &STATE, COMMAND, &FLOW).unwrap();
        for direction in 0..17 {
            let slope = oracle::slope(2e-5, |t| {
                let (mut x, mut u, mut flow) = (STATE, COMMAND, FLOW);
                match direction {
                    k @ 0..12 => x[k] += t,
                    k @ 12..15 => u[k - 12] += t,
                    15 => flow.speed_m_s += t,
                    _ => flow.direction_rad += t,
                }
                let at = evaluate(&plant, &x, u, &flow);
                let (s, t) = (at.sight, at.tensions);
                let out = [
                    s.altitude_m,
                    s.pitch_rad,
                    s.roll_rad,
                    s.heading_rad,
                    s.right_m,
                    s.forward_m,
                    t.center_n,
                    t.starboard_n,
                    t.port_n,
                ];
                SMatrix::<f64, 21, 1>::from_fn(|i, _| if i < 12 { at.derivative[i] } else { out[i - 12] })
            });
            for row in 0..21 {
                let found = match (row < 12, direction < 12) {
                    (true, true) => a[(row, direction)],
                    (true, false) => b[(row, direction - 12)],
                    (false, true) => c[(row - 12, direction)],
                    (false, false) => d[(row - 12, direction - 12)],
                };
                let scale = slope[row].abs().max(1.0);
                assert!(
                    (found - slope[row]).abs() < 1e-8 * scale,
                    "row {row}, column {direction}: {found}, {}",
                    slope[row]
                );
            }
        }
    }
}

#[test]
fn names_and_units_go_with_their_rows_and_columns() {
    let plant = Plant::new(&rig(), Fidelity::NUMERICAL).unwrap();
    let linear = linearize(&plant, &STATE, COMMAND, &FLOW).unwrap();
    let index = |variables: &[Variable], name: &str| variables.iter().position(|v| v.name == name).unwrap();
    let state = |name: &str| index(&linear.states, name);
    // A line's length changes with its reel speed, which follows its command with the winch's lag.
    for line in ["center", "starboard", "port"] {
        let (length, reel) = (state(&format!("line_{line}")), state(&format!("reel_{line}")));
        let command = index(&linear.inputs, &format!("command_{line}"));
        assert_eq!(linear.a[(length, reel)], 1.0, "{line}");
        let lag = rig().winch.time_constant_s;
        assert!((linear.a[(reel, reel)] + 1.0 / lag).abs() < 1e-12, "{line}");
        assert!((linear.b[(reel, command)] - 1.0 / lag).abs() < 1e-12, "{line}");
        assert_eq!((linear.states[length].unit, linear.states[reel].unit), ("m", "m/s"), "{line}");
    }
    // The system among some states is A without the rows and columns of the others.
    for states in [&Linearization::FREE[..], &Linearization::LATERAL, &Linearization::LONGITUDINAL] {
        let part = linear.among(states);
        for (i, row) in states.iter().enumerate() {
            for (j, column) in states.iter().enumerate() {
                assert_eq!(part[(i, j)], linear.a[(*row, *column)]);
            }
        }
    }
    // All lines longer: higher by the cosine of the zenith angle. Turning the flow turns the heading from it back.
    let altitude = index(&linear.outputs, "altitude");
    let gain: f64 =
        ["center", "starboard", "port"].map(|l| linear.c[(altitude, state(&format!("line_{l}")))]).iter().sum();
    assert!((gain - STATE[0].cos()).abs() < 1e-12, "altitude gain {gain}");
    let heading = index(&linear.outputs, "heading_from_flow");
    assert!((linear.d[(heading, index(&linear.inputs, "flow_direction"))] + 1.0).abs() < 1e-12, "heading");
    assert!((linear.c[(heading, state("azimuth"))] - 1.0).abs() < 1e-12, "heading");
}

#[test]
fn response_to_a_small_kick_follows_the_linear_system() {
    let plant = Plant::new(&everything(), Fidelity::STALLED_WITH_ADDED_MASS).unwrap();
    let flow = Flow::straight(0.245);
    let request = TrimRequest { flow, pitch_rad: 0.2, height: TrimHeight::Altitude(0.61) };
    let start = trim(&plant, &request).unwrap().state;
    let linear = linearize(&plant, &start, [0.0; 3], &flow).unwrap();
    for k in 0..12 {
        let mut kicked = start;
        kicked[k] += 1e-6;
        let flown = oracle::fly(kicked, 1e-3, 1000, |_, x| evaluate(&plant, x, [0.0; 3], &flow).derivative);
        let mut departure = [0.0; 12];
        departure[k] = 1e-6;
        let expected = oracle::fly(departure, 1e-3, 1000, |_, x| (linear.a * SMatrix::from(*x)).into());
        let size = expected.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
        for row in 0..12 {
            let found = flown[row] - start[row];
            assert!((found - expected[row]).abs() < 1e-4 * size, "state {row} after a kick of {k}: {found}");
        }
    }
}

fn numbers(value: &Value) -> Vec<f64> {
    match value.as_array() {
        Some(entries) => entries.iter().flat_map(numbers).collect(),
        None => vec![value.as_f64().unwrap()],
    }
}

#[track_caller]
fn check_matrix(name: &str, found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len(), "{name}: size");
    let scale = expected.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    for (k, (f, e)) in found.iter().zip(expected).enumerate() {
        assert!((f - e).abs() < 1e-10 * scale, "{name}, entry {k}: {f}, stored {e}");
    }
}

/// Every stored eigenvalue has its mode and the other way around; conjugates count once.
#[track_caller]
fn check_eigenvalues(name: &str, found: &DMatrix<f64>, stored: &Value, tolerance: f64) {
    let stored: Vec<Complex<f64>> = numbers(stored).chunks(2).map(|pair| Complex::new(pair[0], pair[1])).collect();
    let expected: Vec<_> = stored.iter().filter(|value| value.im >= 0.0).collect();
    let found = modes(found).unwrap().modes;
    assert_eq!(found.len(), expected.len(), "{name}: number of modes");
    for value in expected {
        let nearest = found.iter().map(|mode| (mode.eigenvalue - value).norm()).fold(f64::INFINITY, f64::min);
        assert!(nearest < tolerance, "{name}: {value} is stored, the nearest mode is off by {nearest}");
    }
}

#[test]
fn trim_matrices_and_modes_are_those_of_the_independent_linearization() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/water-channel/eigenvalues.json");
    let golden: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let cases = golden["cases"].as_array().unwrap();
    assert!(cases.len() >= 5, "the golden file holds {} cases", cases.len());
    for case in cases {
        let name = case["name"].as_str().unwrap();
        let mut p = rig();
        p.body.center_of_mass_x = case["center_of_mass_x_pct_chord"].as_f64().unwrap() / 100.0;
        p.layout = match case["layout"].as_str().unwrap() {
            "two-forward-one-aft" => TetherLayout::TwoForwardOneAft,
            _ => TetherLayout::OneForwardTwoAft,
        };
        let fidelity = match case["fidelity"].as_str().unwrap() {
            "numerical" => Fidelity::NUMERICAL,
            _ => Fidelity::STALLED_WITH_ADDED_MASS,
        };
        let plant = Plant::new(&p, fidelity).unwrap();
        let flow = Flow::straight(case["flow_speed"].as_f64().unwrap());
        let pitch_rad = case["pitch_set_point_deg"].as_f64().unwrap().to_radians();
        let found = trim(&plant, &TrimRequest { flow, pitch_rad, height: TrimHeight::Altitude(0.61) }).unwrap();
        let stored = &case["trim"];
        for (value, key) in
            [(found.coordinates[0], "Phi"), (found.coordinates[3], "L_t"), (found.coordinates[4], "theta_prime")]
        {
            assert!((value - stored[key].as_f64().unwrap()).abs() < 1e-10, "{name}, {key}: {value}");
        }
        check_matrix(name, &found.state[6..9], &numbers(&stored["lines"]));
        check_matrix(name, &found.tensions.named().map(|line| line.1), &numbers(&stored["tensions"]));

        let linear = linearize(&plant, &found.state, [0.0; 3], &flow).unwrap();
        check_matrix(name, linear.a.transpose().as_slice(), &numbers(&case["A"]));
        check_matrix(name, linear.b.fixed_columns::<3>(0).transpose().as_slice(), &numbers(&case["B"]));
        // Three eigenvalues of A are zero, one for each line: they split by the square root of rounding at most.
        let all: [usize; 12] = core::array::from_fn(|k| k);
        for (states, key, tolerance) in [
            (&all[..], "open_loop", 1e-7),
            (&Linearization::FREE, "locked_lines", 1e-8),
            (&Linearization::LATERAL, "locked_lines_lateral", 1e-8),
            (&Linearization::LONGITUDINAL, "locked_lines_longitudinal", 1e-8),
        ] {
            check_eigenvalues(name, &linear.among(states), &case[key], tolerance);
        }
    }
}

/// A body with its center of buoyancy so far ahead of its joint that it leans downwind without any force of the flow.
fn tilted() -> Parameters {
    let mut p = without_surfaces(everything());
    p.body.center_of_buoyancy_x = 0.1;
    p.body.center_of_mass_x = p.body.joint_x;
    p
}

#[test]
fn modes_without_damping_lie_on_the_imaginary_axis() {
    let plant = Plant::new(&tilted(), Fidelity::NUMERICAL).unwrap();
    let flow = Flow::straight(0.2);
    let request = TrimRequest { flow, pitch_rad: 0.1, height: TrimHeight::TetherLength(0.6) };
    let state = trim(&plant, &request).unwrap().state;
    let linear = linearize(&plant, &state, [0.0; 3], &flow).unwrap();
    let found = modes(&linear.among(&Linearization::FREE)).unwrap().modes;
    let swinging = found.iter().filter(|mode| mode.natural_frequency_rad_s() > 1e-3).count();
    assert_eq!(swinging, 2, "two pendulum modes, and the body turned about the vertical: {found:?}");
    for mode in found {
        // The turn about the vertical is a double zero, which rounding splits by its square root.
        let tolerance = if mode.natural_frequency_rad_s() > 1e-3 { 1e-9 } else { 1e-6 };
        assert!(mode.eigenvalue.re.abs() < tolerance, "{mode:?}");
    }
}

#[test]
fn what_cannot_be_linearized_is_an_error() {
    let plant = Plant::new(&rig(), Fidelity::NUMERICAL).unwrap();
    let mut rest = STATE;
    rest[3..6].fill(0.0);
    rest[9..].fill(0.0);
    let error = linearize(&plant, &rest, [0.0; 3], &Flow::straight(0.0)).unwrap_err();
    assert!(matches!(error, Error::State { .. }) && error.to_string().contains("relative to the fluid"), "{error}");
    let error = linearize(&plant, &STATE, COMMAND, &Flow::straight(f64::NAN)).unwrap_err();
    assert!(matches!(error, Error::Argument { .. }), "{error}");
    let mut vertical = STATE;
    vertical[0] = 0.0;
    let error = linearize(&plant, &vertical, COMMAND, &FLOW).unwrap_err();
    assert!(matches!(error, Error::State { name: "zenith angle Phi", .. }), "{error}");
    let error = linearize(&plant, &STATE, [f64::NAN, 0.0, 0.0], &FLOW).unwrap_err();
    assert!(error.to_string().contains("command"), "{error}");
}
