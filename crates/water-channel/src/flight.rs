//! One flight: from trim, or beside it, through the test profile, with what it cost and what it came close to.

use bat_dynamics::{Fidelity, FlightState, Flow, Plant, Trim, TrimHeight, TrimRequest, check_state, trim};
use serde::{Deserialize, Serialize};
use tether_control::{Controller, SetPoints};

use crate::cost::Integrals;
use crate::error::{Error, FlightError};
use crate::integrate::{Landing, Setup, integrate};
use crate::log::{FlightLog, LogRow};
use crate::profile::TestProfile;
use crate::rig::Rig;

/// What a negative tension means.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SlackPolicy {
    /// The flight fails: the model does not hold with a slack line.
    #[default]
    Fail,
    /// The flight goes on and the first slack line is reported.
    Warn,
}

/// How a flight is computed.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FlightSettings {
    /// RK4 steps per sample: 2 keep the cost to about 1e-6, 1 to about 2e-5.
    pub steps_per_sample: usize,
    /// What a slack line means.
    pub slack: SlackPolicy,
}

impl Default for FlightSettings {
    fn default() -> Self {
        Self { steps_per_sample: 2, slack: SlackPolicy::Fail }
    }
}

impl FlightSettings {
    /// The default with `steps_per_sample` RK4 steps per sample.
    #[must_use]
    pub fn with_steps(steps_per_sample: usize) -> Self {
        Self { steps_per_sample, ..Self::default() }
    }

    /// # Errors
    /// [`Error::Argument`] for no step or more than 1000 steps per sample.
    pub fn validate(&self) -> Result<(), Error> {
        if (1..=1000).contains(&self.steps_per_sample) {
            return Ok(());
        }
        Err(Error::Argument {
            name: "steps per sample",
            value: self.steps_per_sample as f64,
            allowed: "a whole number from 1 to 1000",
        })
    }
}

/// A rig with the physics that it flies in.
#[derive(Clone, Debug, PartialEq)]
pub struct FlightRequest {
    /// The rig.
    pub rig: Rig,
    /// The physics.
    pub fidelity: Fidelity,
}

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

/// A completed flight.
#[derive(Clone, Debug, PartialEq)]
pub struct Flight {
    /// Integrals from which every cost follows.
    pub integrals: Integrals,
    /// How far it went.
    pub extremes: Extremes,
    /// The first slack line, where that is only a warning.
    pub slack: Option<SlackEvent>,
    /// The equilibrium at the first flow, from which it started unless the test starts it elsewhere.
    pub trim: Trim,
    /// Where it ended.
    pub final_state: FlightState,
}

impl Flight {
    /// The ground footprint `pi L_t² sin² Phi` at trim, in m². Source: Section 3.1.
    #[must_use]
    pub fn trim_footprint_m2(&self) -> f64 {
        footprint_m2(self.trim.coordinates[3], self.trim.coordinates[0])
    }
}

/// Area of land that a tether of length `length_m` at zenith angle `zenith_rad` sweeps through all azimuths,
/// `A = pi L_t² sin² Phi`, in m². Source: Section 3.1.
#[must_use]
pub fn footprint_m2(length_m: f64, zenith_rad: f64) -> f64 {
    let radius = length_m * zenith_rad.sin();
    core::f64::consts::PI * radius * radius
}

/// The equilibrium that the controller's set points ask for.
pub(crate) fn trim_at(plant: &Plant, set_points: &SetPoints, flow: Flow) -> Result<Trim, Error> {
    let height = TrimHeight::Altitude(set_points.altitude_m);
    Ok(trim(plant, &TrimRequest { flow, pitch_rad: set_points.pitch_rad, height })?)
}

/// A rig made ready: checked plant and controller, the trim at the first flow, and the state at the start.
pub(crate) struct Ready {
    pub(crate) plant: Plant,
    pub(crate) controller: Controller,
    pub(crate) trim: Trim,
    pub(crate) start: FlightState,
}

impl Ready {
    pub(crate) fn new(request: &FlightRequest, profile: &TestProfile) -> Result<Self, Error> {
        let plant = request.rig.plant(request.fidelity)?;
        let controller = request.rig.controller()?;
        let trim = trim_at(&plant, &request.rig.set_points, profile.flow().at(0.0))?;
        let departure = profile.start();
        let mut start = trim.state;
        start[0] += departure.zenith_rad;
        start[1] += departure.azimuth_rad;
        start[2] += departure.twist_rad;
        check_state(&start, 0.0)?;
        Ok(Self { plant, controller, trim, start })
    }

    pub(crate) fn finish(self, landing: Landing) -> Result<Flight, FlightError> {
        match landing.failure {
            Some(failure) => Err(failure),
            None => Ok(Flight {
                integrals: landing.integrals,
                extremes: landing.extremes,
                slack: landing.slack,
                trim: self.trim,
                final_state: landing.final_state,
            }),
        }
    }
}

/// Flies `request` through `profile`, from trim at the profile's first flow or the departure from it that the profile sets.
///
/// # Errors
/// [`FlightError`]: the flight cannot start, leaves the model, or a line goes slack where that is an error.
pub fn fly(request: &FlightRequest, profile: &TestProfile, settings: &FlightSettings) -> Result<Flight, FlightError> {
    settings.validate()?;
    let ready = Ready::new(request, profile)?;
    let [landing] = one(&ready, profile, settings, |_| {});
    ready.finish(landing)
}

/// Flies like [`fly`] and keeps every `every`-th sample; the log ends where a failed flight ends.
///
/// # Errors
/// [`FlightError::Start`] when there is no flight at all. A flight that fails later has a log and an outcome.
pub fn fly_logged(
    request: &FlightRequest,
    profile: &TestProfile,
    settings: &FlightSettings,
    every: usize,
) -> Result<(Result<Flight, FlightError>, FlightLog), FlightError> {
    settings.validate()?;
    if every == 0 {
        return Err(Error::Argument { name: "samples per log row", value: 0.0, allowed: "at least 1" }.into());
    }
    let ready = Ready::new(request, profile)?;
    let mut rows = Vec::new();
    let mut sample = 0;
    let [landing] = one(&ready, profile, settings, |seen| {
        if sample % every == 0 {
            rows.push(LogRow::of(seen, &request.rig));
        }
        sample += 1;
    });
    Ok((ready.finish(landing), FlightLog { rows }))
}

fn one(
    ready: &Ready,
    profile: &TestProfile,
    settings: &FlightSettings,
    watch: impl FnMut(&crate::integrate::Sample<'_, f64, 1>),
) -> [Landing; 1] {
    let setup = Setup {
        plant: ready.plant,
        controllers: [&ready.controller],
        sample_time_s: ready.controller.parameters().sample_time_s,
        profile,
        settings,
        used: 1,
    };
    integrate::<f64, 1>(&setup, [&ready.start], watch)
}
