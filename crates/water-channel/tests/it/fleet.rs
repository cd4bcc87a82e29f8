//! Flights side by side: each has the bits that it has alone.

use bat_dynamics::{Fidelity, LANES};
use proptest::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};
use water_channel::{
    Flight, FlightError, FlightRequest, FlightSettings, SlackPolicy, TestProfile, Window, fly, fly_all, fly_all_logged,
    fly_logged,
};

use crate::rigs::{first_row, kick, request, short_test, steps};

/// Everything of a flight as text: `f64` is printed with all its digits, and with its sign.
fn words(outcome: &Result<Flight, FlightError>) -> String {
    format!("{outcome:?}")
}

#[track_caller]
fn assert_same(fleet: &[Result<Flight, FlightError>], alone: &[Result<Flight, FlightError>]) {
    assert_eq!(fleet.len(), alone.len(), "one result per request");
    for (k, (beside, alone)) in fleet.iter().zip(alone).enumerate() {
        assert_eq!(words(beside), words(alone), "flight {k}");
    }
}

fn each_alone(
    requests: &[FlightRequest],
    profile: &TestProfile,
    settings: &FlightSettings,
) -> Vec<Result<Flight, FlightError>> {
    requests.iter().map(|request| fly(request, profile, settings)).collect()
}

#[test]
fn symmetric_and_lopsided_flights_side_by_side_have_their_own_bits() {
    let profile = short_test(6.0);
    let mut requests = vec![first_row(); 7];
    for (k, request) in requests.iter_mut().enumerate() {
        request.rig.set_points.pitch_rad += 0.01 * k as f64;
        if k % 3 == 1 {
            request.rig.plant.asymmetry.line_port_m = 1e-3 * k as f64;
            request.rig.plant.asymmetry.center_of_mass_y_m = 1e-3;
        }
    }
    let settings = FlightSettings::default();
    let alone = each_alone(&requests, &profile, &settings);
    assert!(alone.iter().all(Result::is_ok), "{alone:?}");
    assert_same(&fly_all(&requests, &profile, &settings, |_| {}), &alone);
    let rolled = alone[1].as_ref().unwrap().trim.coordinates;
    assert!(rolled[1].abs() > 1e-4 && rolled[5].abs() > 1e-3, "the lopsided trim is rolled and turned: {rolled:?}");
}

/// Flights that fail at once and later, and such as have to fly alone, are among them.
#[test]
fn logs_side_by_side_are_those_that_flights_have_alone() {
    let (profile, settings) = (short_test(6.0), FlightSettings::default());
    let mut requests = vec![first_row(); 4 * LANES + 1];
    for (k, request) in requests.iter_mut().enumerate() {
        request.rig.set_points.pitch_rad += 0.002 * k as f64;
    }
    requests[LANES].rig.plant.asymmetry.center_of_mass_y_m = 1e-3;
    requests[2 * LANES].rig.set_points.pitch_rad = 3.0;
    requests[3 * LANES] = request(Fidelity::STALLED_WITH_ADDED_MASS, 20.0, 15.0);
    let alone: Vec<_> = requests
        .iter()
        .map(|request| fly_logged(request, &profile, &settings, 3).and_then(|(flight, log)| Ok((flight?, log))))
        .collect();
    let failed = alone.iter().filter(|one| one.is_err()).count();
    assert!((1..=2).contains(&failed), "{failed} fail");
    for (k, (beside, alone)) in fly_all_logged(&requests, &profile, &settings, 3).iter().zip(&alone).enumerate() {
        assert_eq!(format!("{beside:?}"), format!("{alone:?}"), "flight {k}");
    }
    let refused = fly_all_logged(&requests[..2], &profile, &settings, 0);
    assert!(refused.iter().all(|one| matches!(one, Err(FlightError::Start(_)))), "every 0th sample: {refused:?}");
}

fn with_threads<T: Send>(n_threads: usize, f: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap().install(f)
}

fn requests() -> impl Strategy<Value = Vec<FlightRequest>> {
    let fidelities = [Fidelity::NUMERICAL, Fidelity::STALLED, Fidelity::ADDED_MASS, Fidelity::STALLED_WITH_ADDED_MASS];
    let one = (45.0..52.0_f64, -2.0..24.0_f64, 0..4_usize, 0.6..1.6_f64, 0.5..2.0_f64, 0..2_usize);
    let one = one.prop_map(move |(x_cm, pitch, fidelity, fin, gain, layout)| {
        let mut request = request(fidelities[fidelity], x_cm, pitch);
        request.rig.plant.vertical_stabilizer.area_factor = fin;
        request.rig.plant.winch.speed_limit_m_s *= gain;
        if layout == 1 {
            request.rig.plant.layout = bat_dynamics::TetherLayout::TwoForwardOneAft;
        }
        request
    });
    prop::collection::vec(one, 1..=2 * LANES + 1)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn flight_has_the_same_bits_alone_and_in_any_company(requests in requests(), turn in 0..9_usize) {
        let (profile, settings) = (short_test(6.0), FlightSettings::with_steps(1));
        let alone = each_alone(&requests, &profile, &settings);
        assert_same(&fly_all(&requests, &profile, &settings, |_| {}), &alone);
        // Other neighbors, other lanes.
        let turn = turn % requests.len();
        let mut turned = requests.clone();
        turned.rotate_left(turn);
        let mut expected = alone.clone();
        expected.rotate_left(turn);
        assert_same(&fly_all(&turned, &profile, &settings, |_| {}), &expected);
    }
}

#[test]
fn number_of_threads_changes_nothing() {
    let requests: Vec<_> =
        (0..19).map(|k| request(Fidelity::STALLED_WITH_ADDED_MASS, 46.0 + 0.3 * k as f64, 19.0 - k as f64)).collect();
    let (profile, settings) = (short_test(6.0), FlightSettings::default());
    let one = with_threads(1, || fly_all(&requests, &profile, &settings, |_| {}));
    let two = with_threads(2, || fly_all(&requests, &profile, &settings, |_| {}));
    assert_same(&two, &one);
    assert_same(&one, &each_alone(&requests, &profile, &settings));
}

#[test]
fn every_flight_is_counted_once_as_it_lands() {
    for n in [0, 1, LANES - 1, LANES, LANES + 1, 3 * LANES + 2] {
        let landed = AtomicUsize::new(0);
        let requests = vec![first_row(); n];
        let count = |flights| {
            landed.fetch_add(flights, Ordering::Relaxed);
        };
        let flights = fly_all(&requests, &short_test(0.5), &FlightSettings::with_steps(1), count);
        assert_eq!(flights.len(), n, "one result per request");
        assert_eq!(landed.into_inner(), n, "flights counted");
    }
}

/// Four requests that fail each in its own way, among four that do not.
#[test]
fn neighbor_that_fails_leaves_the_others_alone() {
    let mut slack = first_row();
    slack.rig.plant.body.center_of_mass_height_m = 0.02; // its windows below empty the center line
    let mut diverging = first_row();
    let pitch = diverging.rig.pitch;
    diverging.rig.pitch = tether_control::FilteredPd::new(-20.0 * pitch.proportional(), 0.0, 0.1).unwrap();
    diverging.rig.plant.winch.speed_limit_m_s = 0.5;
    let mut no_trim = first_row();
    no_trim.rig.plant.body.volume_m3 = 1e-5;
    let mut wrong = first_row();
    wrong.rig.plant.body.mass_kg = -0.18;
    let mut other_clock = first_row();
    other_clock.rig.sample_time_s = 0.05;
    let good = |pitch_deg| request(Fidelity::STALLED, 48.0, pitch_deg);
    let requests =
        [good(5.0), diverging, good(10.0), no_trim, wrong, good(15.0), other_clock, slack, good(20.0), good(12.0)];
    let windows = [kick(1.0), vec![Window { from_s: 5.0, to_s: 8.0, commands: [-1.0, 1.0, 1.0] }]].concat();
    let profile = TestProfile::new(10.0, steps(&[(0.0, 0.245, 0.0)]), windows).unwrap();
    for policy in [SlackPolicy::Fail, SlackPolicy::Warn] {
        let mut settings = FlightSettings::with_steps(1);
        settings.slack = policy;
        let alone = each_alone(&requests, &profile, &settings);
        let failed: Vec<usize> = (0..requests.len()).filter(|k| alone[*k].is_err()).collect();
        assert!(failed.contains(&1) && failed.contains(&3) && failed.contains(&4), "these fail: {failed:?}");
        for k in [0, 2, 5, 6, 8, 9] {
            assert!(alone[k].is_ok(), "flight {k} is a good one: {:?}", alone[k]);
        }
        assert_same(&fly_all(&requests, &profile, &settings, |_| {}), &alone);
        for k in 0..requests.len() {
            let mut turned = requests.to_vec();
            turned.rotate_left(k);
            let mut expected = alone.clone();
            expected.rotate_left(k);
            assert_same(&fly_all(&turned, &profile, &settings, |_| {}), &expected);
        }
    }
}

#[test]
fn wrong_settings_fail_every_flight_with_the_reason() {
    let settings = FlightSettings::with_steps(0);
    for outcome in fly_all(&[first_row(), first_row()], &short_test(1.0), &settings, |_| {}) {
        let message = outcome.unwrap_err().to_string();
        assert_eq!(message, "cannot start: steps per sample = 0: it must be a whole number from 1 to 1000");
    }
}
