//! Flights without the controller, from another start: the modes of the body by itself, and the flight as the judge.

use bat_dynamics::{Fidelity, Flow, TetherLayout};
use nalgebra::Complex;
use water_channel::{
    Control, Departure, FlightError, FlightSettings, OpenLoop, ProfileFile, TestProfile, Window, fly, fly_all,
    fly_logged, open_loop_modes,
};

use crate::rigs::{assert_close, first_row, flown, golden, kick, logged, numbers, request, request_of, steps};

/// What the golden file promises of its eigenvalues.
const EIGENVALUES: f64 = 1e-7;

fn open(duration_s: f64, windows: Vec<Window>) -> TestProfile {
    TestProfile::new(duration_s, steps(&[(0.0, 0.245, 0.0)]), windows).unwrap().with_control(Control::OpenLoop)
}

fn twisted(profile: TestProfile, twist_rad: f64) -> TestProfile {
    profile.with_start(Departure { twist_rad, ..Departure::default() }).unwrap()
}

#[test]
fn eigenvalues_match_an_independent_linearization_with_locked_lines() {
    for case in golden("water-channel/eigenvalues.json")["cases"].as_array().unwrap() {
        let flow = Flow::straight(case["flow_speed"].as_f64().unwrap());
        let found = open_loop_modes(&request_of(case), &[flow]).unwrap().remove(0);
        let mut eigenvalues: Vec<Complex<f64>> = Vec::new();
        for mode in &found.modes.modes {
            eigenvalues.push(mode.eigenvalue);
            if mode.eigenvalue.im > 0.0 {
                eigenvalues.push(mode.eigenvalue.conj());
            }
        }
        let expected: Vec<Vec<f64>> = case["locked_lines"].as_array().unwrap().iter().map(numbers).collect();
        assert_eq!(eigenvalues.len(), expected.len(), "{}", case["name"]);
        for pair in expected {
            let expected = Complex::new(pair[0], pair[1]);
            let nearest = eigenvalues.iter().map(|one| (one - expected).norm()).fold(f64::INFINITY, f64::min);
            assert!(nearest <= EIGENVALUES, "{}: {expected} is off by {nearest:e}", case["name"]);
        }
        assert!(found.is_stable(), "{}: every golden case is stable with locked lines", case["name"]);
    }
}

/// A center of mass ahead of the joint turns the body away from the flow: what the modes call unstable grows in flight, at the
/// rate that they say.
#[test]
fn unstable_body_departs_at_the_rate_of_its_fastest_growth() {
    let request = request(Fidelity::STALLED_WITH_ADDED_MASS, 41.0, 2.0);
    let found = open_loop_modes(&request, &[Flow::straight(0.245)]).unwrap().remove(0);
    let growth = found.growth_rate_per_s();
    assert!(!found.is_stable() && growth > 0.1, "growth in 1/s: {growth}");
    assert!(found.modes.modes.iter().any(|mode| mode.eigenvalue.re < -1.0), "other modes die out");
    let log = logged(&request, &twisted(open(30.0, vec![]), 1e-7));
    let twist = |time_s: f64| log.rows[(time_s / 0.025).round() as usize].state[2].abs();
    let rate = (twist(25.0) / twist(20.0)).ln() / 5.0;
    assert_close(rate, growth, 0.002 * growth, "growth of the twist in 1/s");
}

/// At the later speed a small twist must die out as the modes there say, about the equilibrium that they name.
#[test]
fn flight_after_a_change_of_speed_follows_the_modes_there() {
    let request = request(Fidelity::STALLED_WITH_ADDED_MASS, 46.1, 12.0);
    let flows = [Flow::straight(0.205), Flow::straight(0.285)];
    let found: OpenLoop = open_loop_modes(&request, &flows).unwrap().remove(1);
    let slowest = found.modes.modes[0].eigenvalue;
    assert!(slowest.im > 0.0, "the slowest mode swings: {slowest}");
    let profile = TestProfile::new(90.0, steps(&[(0.0, 0.205, 0.0), (1.0, 0.285, 0.0)]), vec![]).unwrap();
    let profile = twisted(profile.with_control(Control::OpenLoop), 1e-3);
    let log = logged(&request, &profile);
    // Where only the slowest mode is left: heading² + (heading rate / frequency)² decays twice as fast as the mode.
    let heading = |time_s: f64| log.rows[(time_s / 0.025).round() as usize].heading_rad;
    let period_s = core::f64::consts::TAU / slowest.im;
    let size = |from_s: f64| {
        let samples = (period_s / 0.025).round() as usize;
        (0..samples).map(|k| heading(from_s + 0.025 * k as f64).powi(2)).sum::<f64>().sqrt()
    };
    let (from_s, to_s) = (20.0, 20.0 + 3.0 * (period_s / 0.025).round() * 0.025);
    let rate = (size(to_s) / size(from_s)).ln() / (to_s - from_s);
    assert_close(rate, slowest.re, 0.005 * slowest.re.abs(), "decay in 1/s");
    assert_close(log.rows[3599].state[0], found.trim.coordinates[0], 1e-5, "zenith angle where it comes to rest");
}

#[test]
fn nobody_moves_the_winches_outside_the_windows() {
    let log = logged(&first_row(), &open(6.0, kick(1.0)));
    let limit = first_row().rig.plant.winch.speed_limit_m_s;
    for (k, row) in log.rows.iter().enumerate() {
        let port = if (40..=80).contains(&k) { -limit } else { 0.0 };
        assert_eq!(row.commands_m_s.map(f64::to_bits), [0.0, 0.0, port].map(f64::to_bits), "sample {k}");
    }
}

/// 40 samples at the limit are exactly one second: out and back leaves the lines as long as they were.
#[test]
fn lines_reeled_in_and_out_for_equal_times_return() {
    let windows = (0..3)
        .flat_map(|line| {
            let from_s = 1.0 + 4.0 * f64::from(line);
            [(from_s, -1.0), (from_s + 3.0, 1.0)].map(|(from_s, speed)| {
                let mut commands = [0.0; 3];
                commands[line as usize] = speed;
                Window { from_s, to_s: from_s + 0.975, commands }
            })
        })
        .collect();
    let request = first_row();
    let log = logged(&request, &open(30.0, windows));
    let (first, last) = (log.rows[0].state, log.rows[log.rows.len() - 1].state);
    let shortest: [f64; 3] =
        core::array::from_fn(|line| log.rows.iter().map(|row| row.state[6 + line]).fold(f64::INFINITY, f64::min));
    for line in 0..3 {
        assert_close(last[6 + line], first[6 + line], 1e-9, "length of a line at the end");
        let pulled = first[6 + line] - shortest[line];
        // What the winch's lag keeps back at the end of the pull it makes up for after it.
        assert_close(pulled, request.rig.plant.winch.speed_limit_m_s, 1e-6, "line reeled in, in m");
    }
}

#[test]
fn start_is_the_trim_plus_the_departure_at_rest() {
    let departure = Departure { zenith_rad: 0.02, azimuth_rad: -0.1, twist_rad: 0.17 };
    let profile = open(2.0, vec![]).with_start(departure).unwrap();
    let request = first_row();
    let (flight, log) = fly_logged(&request, &profile, &FlightSettings::default(), 1).unwrap();
    let trim = flight.unwrap().trim.state;
    let start = log.rows[0].state;
    for (k, added) in [0.02, -0.1, 0.17].into_iter().chain([0.0; 9]).enumerate() {
        assert_close(start[k] - trim[k], added, 1e-15, "departure of a state");
    }
    // With the line near the vertical azimuth and twist both turn the body.
    assert!((log.rows[0].heading_rad - 0.07).abs() < 0.01, "heading {}", log.rows[0].heading_rad);
}

/// Mirrored twist, mirrored flight; and no twist, no lateral motion at all.
#[test]
fn twist_to_either_side_is_the_same_flight_mirrored() {
    let request = request(Fidelity::STALLED_WITH_ADDED_MASS, 46.1, 12.0);
    let [left, right] = [-0.17, 0.17].map(|twist| logged(&request, &twisted(open(20.0, vec![]), twist)));
    for (a, b) in left.rows.iter().zip(&right.rows) {
        assert_close(a.lateral_m, -b.lateral_m, 1e-12, "lateral position");
        assert_close(a.heading_rad, -b.heading_rad, 1e-12, "heading");
        assert_close(a.altitude_m, b.altitude_m, 1e-12, "altitude");
    }
    assert!(right.rows.iter().any(|row| row.lateral_m.abs() > 0.01), "the twist swings the body sideways");
    let straight = logged(&request, &open(20.0, vec![]));
    assert!(straight.rows.iter().all(|row| row.lateral_m.abs() < 1e-14), "no twist, no lateral motion");
}

/// Lanes start where single flights start.
#[test]
fn many_flights_are_the_single_ones_bit_for_bit() {
    let profile = twisted(open(10.0, kick(1.0)), 0.1);
    let requests: Vec<_> = [5.0, 8.0, 11.0, 14.0, 17.0].map(|pitch| request(Fidelity::NUMERICAL, 46.1, pitch)).into();
    let settings = FlightSettings::default();
    for (many, request) in fly_all(&requests, &profile, &settings, |_| {}).into_iter().zip(&requests) {
        let (many, one) = (many.unwrap(), flown(request, &profile, settings.steps_per_sample));
        assert_eq!(many.final_state.map(f64::to_bits), one.final_state.map(f64::to_bits), "final state");
    }
}

/// Figure 14's layouts: the same line moves the nose the other way.
#[test]
fn center_line_pitches_the_other_way_with_two_lines_forward() {
    let pull = Window { from_s: 1.0, to_s: 1.975, commands: [-1.0, 0.0, 0.0] };
    let pitch_change = |layout| {
        let mut request = first_row();
        request.rig.plant.layout = layout;
        let log = logged(&request, &open(3.0, vec![pull]));
        log.rows[119].pitch_rad - log.rows[0].pitch_rad
    };
    let (one, two) = (pitch_change(TetherLayout::OneForwardTwoAft), pitch_change(TetherLayout::TwoForwardOneAft));
    assert!(one < -0.05 && two > 0.05, "pitch after the center line is reeled in: {one} and {two} rad");
}

#[test]
fn profile_file_says_where_it_starts_and_who_commands() {
    let text = r#"
        title = "Released with a twist"
        control = "open-loop"
        duration = { value = 20.0, unit = "s", provenance = "estimated", source = "two periods" }
        [start]
        twist = { value = 10.0, unit = "deg", provenance = "estimated", source = "by hand" }
        [[flow]]
        from = { value = 0.0, unit = "s", provenance = "given", source = "start" }
        speed = { value = 30.0, unit = "cm/s", provenance = "given", source = "Table 2" }
        direction = { value = 0.0, unit = "deg", provenance = "given", source = "along the channel" }
    "#;
    let profile = ProfileFile::parse(text).unwrap().profile;
    assert_eq!(profile.control(), Control::OpenLoop);
    assert_eq!(profile.start(), Departure { twist_rad: 10.0_f64.to_radians(), ..Departure::default() });
    let refuses = |from: &str, to: &str, words: &[&str]| {
        let error = ProfileFile::parse(&text.replacen(from, to, 1)).unwrap_err().to_string();
        for word in words {
            assert!(error.contains(word), "`{word}` is not in: {error}");
        }
    };
    refuses("open-loop", "open", &["control", "open", "closed-loop or open-loop"]);
    refuses("twist =", "yaw =", &["start.yaw", "azimuth, twist, zenith"]);
    refuses("value = 10.0", "value = 180.0", &["start.twist", "180", "half turn"]);
    refuses("value = 10.0", "value = nan", &["start.twist", "half turn"]);
}

#[test]
fn start_that_cannot_be_flown_is_refused_by_name() {
    let start = |zenith_rad| open(2.0, vec![]).with_start(Departure { zenith_rad, ..Departure::default() });
    for angle in [f64::NAN, f64::INFINITY, 3.2] {
        let error = start(angle).unwrap_err().to_string();
        assert!(error.contains("zenith") && error.contains("half turn"), "{error}");
    }
    let through_the_vertical = fly(&first_row(), &start(-1.0).unwrap(), &FlightSettings::default()).unwrap_err();
    assert!(matches!(through_the_vertical, FlightError::LeftTheModel(_)), "{through_the_vertical:?}");
    let words = through_the_vertical.to_string();
    assert!(words.contains("zenith angle Phi") && words.contains("0 s"), "{words}");
    let no_flow = open_loop_modes(&first_row(), &[]).unwrap_err().to_string();
    assert!(no_flow.contains("number of flows"), "{no_flow}");
}
