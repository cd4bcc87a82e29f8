//! The rig, the test and the weights of the fixtures, and short tests made of them.

use bat_dynamics::{Fidelity, Flow, FlowHistory, FlowKnot, TetherLayout, Transition};
use serde_json::Value;
use water_channel::{
    CostFile, CostWeights, Flight, FlightLog, FlightRequest, FlightSettings, ProfileFile, RigFile, TestProfile, Window,
    fly, fly_logged,
};

/// Path of a fixture.
pub(crate) fn fixture(name: &str) -> String {
    format!("{}/../../fixtures/{name}", env!("CARGO_MANIFEST_DIR"))
}

/// Text of a fixture.
pub(crate) fn text(name: &str) -> String {
    std::fs::read_to_string(fixture(name)).unwrap()
}

/// A golden file.
pub(crate) fn golden(name: &str) -> Value {
    serde_json::from_str(&text(name)).unwrap()
}

pub(crate) fn weights() -> CostWeights {
    CostFile::read(fixture("bat/cost-chapter4.toml")).unwrap().weights
}

/// The 300 s test of Section 3.2.
pub(crate) fn full_test() -> TestProfile {
    ProfileFile::read(fixture("bat/test-profile.toml")).unwrap().profile
}

/// The rig of the fixtures with a center of mass in per cent of chord and a pitch set point in degrees.
pub(crate) fn request(fidelity: Fidelity, x_cm_pct_chord: f64, pitch_deg: f64) -> FlightRequest {
    let mut rig = RigFile::read(fixture("bat/rig.toml")).unwrap().rig;
    rig.plant.body.center_of_mass_x = x_cm_pct_chord / 100.0;
    rig.set_points.pitch_rad = pitch_deg.to_radians();
    FlightRequest { rig, fidelity }
}

/// The first row of Table 3 in the numerical model.
pub(crate) fn first_row() -> FlightRequest {
    request(Fidelity::NUMERICAL, 46.1, 17.3)
}

/// The request of a golden case.
pub(crate) fn request_of(case: &Value) -> FlightRequest {
    let number = |name: &str| case[name].as_f64().unwrap();
    let fidelity = match case["fidelity"].as_str().unwrap() {
        "numerical" => Fidelity::NUMERICAL,
        "stalled" => Fidelity::STALLED,
        "stalled_added_mass" => Fidelity::STALLED_WITH_ADDED_MASS,
        other => panic!("unknown fidelity {other}"),
    };
    let mut request = request(fidelity, number("center_of_mass_x_pct_chord"), number("pitch_set_point_deg"));
    request.rig.plant.layout = match case["layout"].as_str().unwrap() {
        "one-forward-two-aft" => TetherLayout::OneForwardTwoAft,
        "two-forward-one-aft" => TetherLayout::TwoForwardOneAft,
        other => panic!("unknown layout {other}"),
    };
    request
}

/// The numbers of a golden array.
pub(crate) fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|entry| entry.as_f64().unwrap()).collect()
}

/// Steps of the flow: time in s, speed in m/s, direction in degrees.
pub(crate) fn steps(knots: &[(f64, f64, f64)]) -> FlowHistory {
    flow(knots, Transition::Step)
}

/// A flow with one kind of transition throughout.
pub(crate) fn flow(knots: &[(f64, f64, f64)], transition: Transition) -> FlowHistory {
    let knot = |&(from_s, speed_m_s, direction_deg): &(f64, f64, f64)| FlowKnot {
        from_s,
        flow: Flow { speed_m_s, direction_rad: direction_deg.to_radians() },
        transition,
    };
    FlowHistory::new(knots.iter().map(knot).collect()).unwrap()
}

/// The perturbation (22)–(26) from `from_s` on: the port line pulled for 1 s and held for 2 s.
pub(crate) fn kick(from_s: f64) -> Vec<Window> {
    vec![
        Window { from_s, to_s: from_s + 1.0, commands: [0.0, 0.0, -1.0] },
        Window { from_s: from_s + 1.0, to_s: from_s + 3.0, commands: [0.0; 3] },
    ]
}

/// A short test: 0.245 m/s along the channel, a kick at 1 s.
pub(crate) fn short_test(duration_s: f64) -> TestProfile {
    let windows = if duration_s > 2.0 { kick(1.0) } else { Vec::new() };
    TestProfile::new(duration_s, steps(&[(0.0, 0.245, 0.0)]), windows).unwrap()
}

/// A flight that is expected to end well.
#[track_caller]
pub(crate) fn flown(request: &FlightRequest, profile: &TestProfile, steps_per_sample: usize) -> Flight {
    match fly(request, profile, &FlightSettings::with_steps(steps_per_sample)) {
        Ok(flight) => flight,
        Err(error) => panic!("the flight failed: {error}"),
    }
}

/// The log of a flight that is expected to end well, every sample of it.
#[track_caller]
pub(crate) fn logged(request: &FlightRequest, profile: &TestProfile) -> FlightLog {
    let (outcome, log) = fly_logged(request, profile, &FlightSettings::default(), 1).unwrap();
    outcome.unwrap();
    log
}

/// J of a flight with the weights of the fixtures, without the ballast term.
pub(crate) fn cost(flight: &Flight) -> f64 {
    weights().cost(&flight.integrals, 0.0).total
}

#[track_caller]
pub(crate) fn assert_close(found: f64, expected: f64, tolerance: f64, what: &str) {
    assert!((found - expected).abs() <= tolerance, "{what}: {found}, expected {expected} within {tolerance:e}");
}
