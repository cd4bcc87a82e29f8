//! Check 24: a line that would have to push is reported, with its time and by how much.

use water_channel::{FlightError, FlightRequest, FlightSettings, SlackPolicy, TestProfile, Window, fly, fly_logged};

use crate::rigs::{assert_close, first_row, steps};

/// A hard jerk on winches without much lag: the center line is paid out faster than the body can follow.
const JERK_S: f64 = 2.0;

fn jerked() -> (FlightRequest, TestProfile) {
    let mut request = first_row();
    request.rig.plant.winch.speed_limit_m_s = 0.25;
    request.rig.plant.winch.time_constant_s = 0.05;
    let windows = vec![Window { from_s: JERK_S, to_s: JERK_S + 0.2, commands: [1.0, 0.0, 0.0] }];
    (request, TestProfile::new(4.0, steps(&[(0.0, 0.245, 0.0)]), windows).unwrap())
}

fn settings(slack: SlackPolicy) -> FlightSettings {
    let mut settings = FlightSettings::default();
    settings.slack = slack;
    settings
}

#[test]
fn line_that_is_jerked_is_slack_at_that_sample() {
    let (request, profile) = jerked();
    let flight = fly(&request, &profile, &settings(SlackPolicy::Warn)).unwrap();
    let event = flight.slack.unwrap();
    assert_eq!(event.line, "center", "the line that is paid out");
    assert_close(event.time_s, JERK_S, 0.025, "the sample of the jerk");
    assert!(event.tension_n < 0.0, "{event:?}");
    assert!(flight.extremes.smallest_tension_n <= event.tension_n, "{:?}", flight.extremes);
}

#[test]
fn event_is_the_first_sample_of_the_log_with_a_negative_tension() {
    let (request, profile) = jerked();
    let (outcome, log) = fly_logged(&request, &profile, &settings(SlackPolicy::Warn), 1).unwrap();
    let event = outcome.unwrap().slack.unwrap();
    let row = log.rows.iter().find(|row| row.tensions_n.iter().any(|tension| *tension < 0.0)).unwrap();
    assert_eq!(row.time_s.to_bits(), event.time_s.to_bits(), "time of the event");
    assert_eq!(row.tensions_n[0].to_bits(), event.tension_n.to_bits(), "tension of the event");
}

#[test]
fn event_is_the_first_even_where_a_later_one_is_deeper() {
    let (request, _) = jerked();
    let jerk = |from_s, fraction| Window { from_s, to_s: from_s + 0.2, commands: [fraction, 0.0, 0.0] };
    let windows = vec![jerk(JERK_S, 0.9), jerk(JERK_S + 20.0, 1.0)];
    let profile = TestProfile::new(30.0, steps(&[(0.0, 0.245, 0.0)]), windows).unwrap();
    let flight = fly(&request, &profile, &settings(SlackPolicy::Warn)).unwrap();
    let event = flight.slack.unwrap();
    assert_close(event.time_s, JERK_S, 1e-9, "the first jerk");
    assert!(flight.extremes.smallest_tension_n < event.tension_n, "{event:?} {:?}", flight.extremes);
    assert!(flight.extremes.smallest_tension_time_s > JERK_S + 19.0, "{:?}", flight.extremes);
}

#[test]
fn slack_line_fails_the_flight_where_that_is_asked_for() {
    let (request, profile) = jerked();
    let warned = fly(&request, &profile, &settings(SlackPolicy::Warn)).unwrap().slack.unwrap();
    let (outcome, log) = fly_logged(&request, &profile, &settings(SlackPolicy::Fail), 1).unwrap();
    let error = outcome.unwrap_err();
    let expected = FlightError::Slack { line: warned.line, time_s: warned.time_s, tension_n: warned.tension_n };
    assert_eq!(error, expected);
    let message = error.to_string();
    assert!(message.starts_with("line center went slack at t = 2 s: its tension would be -"), "{message}");
    assert!(message.ends_with(" N, allowed: zero or more"), "{message}");
    assert_close(log.rows.last().unwrap().time_s, warned.time_s, 0.0, "the log ends there");
}

/// At the sample of the jerk nothing has moved yet, so the tension is affine in the commanded speed, and the speed that
/// empties the line follows from two gentler jerks.
#[test]
fn line_is_slack_from_the_predicted_speed_on() {
    let (mut request, profile) = jerked();
    let mut at = |limit_m_s: f64| {
        request.rig.plant.winch.speed_limit_m_s = limit_m_s;
        let (outcome, log) = fly_logged(&request, &profile, &settings(SlackPolicy::Warn), 1).unwrap();
        let row = log.rows.iter().find(|row| (row.time_s - JERK_S).abs() < 1e-9).unwrap();
        (row.tensions_n[0], outcome.unwrap().slack)
    };
    let (gentle, hard) = (at(0.1).0, at(0.15).0);
    let emptying_m_s = 0.1 + 0.05 * gentle / (gentle - hard);
    let (left, none) = at(emptying_m_s * (1.0 - 1e-6));
    assert!((0.0..1e-6).contains(&left) && none.is_none(), "just above: {left} N, {none:?}");
    let (left, event) = at(emptying_m_s * (1.0 + 1e-6));
    assert!((-1e-6..0.0).contains(&left), "just below: {left} N");
    assert_close(event.unwrap().time_s, JERK_S, 1e-9, "the sample at which the line is empty");
}
