//! One flight: from trim, or beside it, through the test profile, with what it cost and what it came close to.

use bat_dynamics::{Fidelity, FlightState, Flow, Plant, Trim, TrimHeight, TrimRequest, check_state, trim};
use tether_control::{Controller, SetPoints};

use crate::cost::Integrals;
use crate::error::{Error, FlightError};
use crate::footprint::footprint_m2;
use crate::integrate::{Ending, Sample, Setup, integrate};
use crate::log::{FlightLog, LogRow};
use crate::profile::TestProfile;
use crate::rig::Rig;
use crate::settings::FlightSettings;
use crate::watch::{Extremes, SlackEvent};

/// A rig with the physics that it flies in.
#[derive(Clone, Debug, PartialEq)]
pub struct FlightRequest {
    /// The rig.
    pub rig: Rig,
    /// The physics.
    pub fidelity: Fidelity,
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
    /// Whether the loop for symmetric plants can fly it.
    pub(crate) fn is_plain(&self) -> bool {
        !self.plant.is_lopsided()
    }

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

    pub(crate) fn finish(self, ending: Ending) -> Result<Flight, FlightError> {
        match ending.failure {
            Some(failure) => Err(failure),
            None => Ok(Flight {
                integrals: ending.integrals,
                extremes: ending.extremes,
                slack: ending.slack,
                trim: self.trim,
                final_state: ending.final_state,
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
    let [ending] = one(&ready, profile, settings, |_| {});
    ready.finish(ending)
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
    let [ending] = one(&ready, profile, settings, |seen| {
        if sample % every == 0 {
            rows.push(LogRow::of(seen, &request.rig));
        }
        sample += 1;
    });
    Ok((ready.finish(ending), FlightLog { rows }))
}

fn one(
    ready: &Ready,
    profile: &TestProfile,
    settings: &FlightSettings,
    watch: impl FnMut(&Sample<'_, f64, 1>),
) -> [Ending; 1] {
    let setup = Setup {
        plant: ready.plant,
        controllers: [&ready.controller],
        sample_time_s: ready.controller.parameters().sample_time_s,
        profile,
        settings,
        used: 1,
    };
    if ready.is_plain() {
        integrate::<f64, 1, true>(&setup, [&ready.start], watch)
    } else {
        integrate::<f64, 1, false>(&setup, [&ready.start], watch)
    }
}
