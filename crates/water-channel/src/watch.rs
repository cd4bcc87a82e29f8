//! What is noted of a flight at every sample: extremes, slack lines, and the moment it leaves the model.

use bat_dynamics::{FlightState, STATE_NAMES, check_state};
use serde::Serialize;

use crate::energy::{Meter, Reading};
use crate::error::FlightError;
use crate::settings::{FlightSettings, SlackPolicy};

/// Zenith angles outside (this, pi/2) leave the model: near zero azimuth and twist coincide, at a quarter turn the
/// body touches the floor.
const SMALLEST_ZENITH_RAD: f64 = 1e-3;
const LINES: [&str; 3] = ["center", "starboard", "port"];

/// How far a flight went, over its samples.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Extremes {
    /// Largest |psi − psi_flow|.
    pub peak_heading_rad: f64,
    /// Smallest zenith angle.
    pub smallest_zenith_rad: f64,
    /// Largest zenith angle.
    pub largest_zenith_rad: f64,
    /// Smallest tension of any line: the margin to slack.
    pub smallest_tension_n: f64,
    /// The line that had it.
    pub smallest_tension_line: &'static str,
    /// When it had it.
    pub smallest_tension_time_s: f64,
}

/// The first sample at which a line was slack.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SlackEvent {
    /// `center`, `starboard` or `port`.
    pub line: &'static str,
    /// When.
    pub time_s: f64,
    /// The tension that the model gives, negative.
    pub tension_n: f64,
}

/// The notes on one flight.
#[derive(Clone, Debug)]
pub(crate) struct Watcher {
    pub(crate) extremes: Extremes,
    pub(crate) slack: Option<SlackEvent>,
    pub(crate) failure: Option<FlightError>,
    /// Where the test has a turbine.
    pub(crate) meter: Option<Meter>,
}

impl Default for Watcher {
    fn default() -> Self {
        Self {
            extremes: Extremes {
                peak_heading_rad: 0.0,
                smallest_zenith_rad: f64::INFINITY,
                largest_zenith_rad: 0.0,
                smallest_tension_n: f64::INFINITY,
                smallest_tension_line: LINES[0],
                smallest_tension_time_s: 0.0,
            },
            slack: None,
            failure: None,
            meter: None,
        }
    }
}

/// What one lane shows at one sample.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seen {
    pub(crate) time_s: f64,
    pub(crate) zenith_rad: f64,
    pub(crate) heading_rad: f64,
    pub(crate) shortest_line_m: f64,
    /// Not finite when any entry of the state is not.
    pub(crate) sum_of_state: f64,
    pub(crate) tensions_n: [f64; 3],
}

impl Watcher {
    /// Nothing noted yet, with a meter where the test has a turbine.
    pub(crate) fn with(meter: Option<Meter>) -> Self {
        Self { meter, ..Self::default() }
    }

    /// Notes one sample; false when the state is not one of the model.
    #[inline(always)]
    pub(crate) fn look(&mut self, seen: &Seen, settings: &FlightSettings) -> bool {
        if self.failure.is_some() {
            return true;
        }
        if !(seen.sum_of_state.is_finite() && seen.shortest_line_m > 0.0 && is_inside(seen.zenith_rad)) {
            return false;
        }
        let extremes = &mut self.extremes;
        extremes.peak_heading_rad = extremes.peak_heading_rad.max(seen.heading_rad.abs());
        extremes.smallest_zenith_rad = extremes.smallest_zenith_rad.min(seen.zenith_rad);
        extremes.largest_zenith_rad = extremes.largest_zenith_rad.max(seen.zenith_rad);
        let [center, starboard, port] = seen.tensions_n;
        if center.min(starboard).min(port) < extremes.smallest_tension_n {
            self.note_tension(seen, settings);
        }
        true
    }

    /// Notes a tension that is smaller than all before: the smallest of the lines, and the first that is slack.
    #[cold]
    fn note_tension(&mut self, seen: &Seen, settings: &FlightSettings) {
        let time_s = seen.time_s;
        for (line, tension_n) in LINES.into_iter().zip(seen.tensions_n) {
            if tension_n < self.extremes.smallest_tension_n {
                self.extremes.smallest_tension_n = tension_n;
                self.extremes.smallest_tension_line = line;
                self.extremes.smallest_tension_time_s = time_s;
            }
            if tension_n < 0.0 && self.slack.is_none() {
                self.slack = Some(SlackEvent { line, time_s, tension_n });
                if settings.slack == SlackPolicy::Fail {
                    self.failure = Some(FlightError::Slack { line, time_s, tension_n });
                }
            }
        }
    }

    /// Adds to the energy, where the test has a turbine.
    #[cold]
    #[inline(never)]
    pub(crate) fn meter(&mut self, reading: &Reading) {
        if let Some(meter) = &mut self.meter {
            meter.add(reading);
        }
    }

    /// Records what is wrong with a state that the model does not cover, if anything is.
    #[cold]
    pub(crate) fn check(&mut self, state: &FlightState, time_s: f64) {
        if self.failure.is_some() {
            return;
        }
        let outside = |name, value, unit, expected| bat_dynamics::Error::State { name, value, unit, time_s, expected };
        let lines = STATE_NAMES[6..9].iter().zip(&state[6..9]);
        let error = match (check_state(state, time_s), lines.min_by(|a, b| a.1.total_cmp(b.1))) {
            (Err(error), _) => error,
            (Ok(()), Some((name, shortest))) if *shortest <= 0.0 => outside(name, *shortest, "m", "more than zero"),
            (Ok(()), _) if is_inside(state[0]) => return,
            (Ok(()), _) => outside(
                "zenith angle Phi",
                state[0],
                "rad",
                "within 0.001 and pi/2: azimuth and twist coincide at 0, the floor is at pi/2",
            ),
        };
        self.failure = Some(FlightError::LeftTheModel(error));
    }
}

#[inline(always)]
fn is_inside(zenith_rad: f64) -> bool {
    zenith_rad > SMALLEST_ZENITH_RAD && zenith_rad < core::f64::consts::FRAC_PI_2
}
