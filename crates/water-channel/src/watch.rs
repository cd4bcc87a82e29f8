//! What is noted of a flight at every sample: extremes, slack lines, and the moment it leaves the model.

use bat_dynamics::{FlightState, check_state};

use crate::error::FlightError;
use crate::flight::{Extremes, FlightSettings, SlackEvent, SlackPolicy};

/// Zenith angles outside (this, pi/2) leave the model: near zero azimuth and twist coincide, at a quarter turn the
/// body touches the floor.
const SMALLEST_ZENITH_RAD: f64 = 1e-3;
const LINES: [&str; 3] = ["center", "starboard", "port"];

/// The notes on one flight.
#[derive(Clone, Debug)]
pub(crate) struct Watcher {
    pub(crate) extremes: Extremes,
    pub(crate) slack: Option<SlackEvent>,
    pub(crate) failure: Option<FlightError>,
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
        }
    }
}

impl Watcher {
    /// Notes one sample; false when the state is not one of the model.
    #[inline]
    pub(crate) fn look(
        &mut self,
        time_s: f64,
        zenith: f64,
        heading: f64,
        sum_of_state: f64,
        tensions: [f64; 3],
        settings: &FlightSettings,
    ) -> bool {
        if self.failure.is_some() {
            return true;
        }
        if !(sum_of_state.is_finite() && zenith > SMALLEST_ZENITH_RAD && zenith < core::f64::consts::FRAC_PI_2) {
            return false;
        }
        let extremes = &mut self.extremes;
        extremes.peak_heading_rad = extremes.peak_heading_rad.max(heading.abs());
        extremes.smallest_zenith_rad = extremes.smallest_zenith_rad.min(zenith);
        extremes.largest_zenith_rad = extremes.largest_zenith_rad.max(zenith);
        for (line, tension) in LINES.into_iter().zip(tensions) {
            if tension < extremes.smallest_tension_n {
                extremes.smallest_tension_n = tension;
                extremes.smallest_tension_line = line;
                extremes.smallest_tension_time_s = time_s;
            }
            if tension < 0.0 && self.slack.is_none() {
                self.slack = Some(SlackEvent { line, time_s, tension_n: tension });
                if settings.slack == SlackPolicy::Fail {
                    self.failure = Some(FlightError::Slack { line, time_s, tension_n: tension });
                }
            }
        }
        true
    }

    /// Records what is wrong with a state that the model does not cover, if anything is.
    #[cold]
    pub(crate) fn check(&mut self, state: &FlightState, time_s: f64) {
        if self.failure.is_some() {
            return;
        }
        let zenith = state[0];
        let inside = zenith > SMALLEST_ZENITH_RAD && zenith < core::f64::consts::FRAC_PI_2;
        let error = match check_state(state, time_s) {
            Err(error) => error,
            Ok(()) if inside => return,
            Ok(()) => bat_dynamics::Error::State {
                name: "zenith angle Phi",
                value: zenith,
                unit: "rad",
                time_s,
                allowed: "within 0.001 and pi/2: azimuth and twist coincide at 0, the floor is at pi/2",
            },
        };
        self.failure = Some(FlightError::LeftTheModel(error));
    }
}
