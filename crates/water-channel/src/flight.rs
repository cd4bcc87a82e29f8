//! One flight: from trim, or beside it, through the test profile, with what it cost and what it came close to.

use std::sync::Arc;

use bat_dynamics::{Fidelity, FlightState, Flow, Plant, Trim, TrimHeight, TrimRequest, check_state, trim};
use tether_control::{Controller, SetPoints};

use crate::cost::Integrals;
use crate::course::{Course, checked_count};
use crate::energy::{Energy, Meter};
use crate::error::{Error, FlightError};
use crate::footprint::footprint_m2;
use crate::integrate::{Ending, Sample, Setup, integrate, pose_of};
use crate::log::{FlightLog, LogRow};
use crate::profile::TestProfile;
use crate::rig::Rig;
use crate::sensing::Viewer;
use crate::settings::FlightSettings;
use crate::watch::{Extremes, SlackEvent};
use crate::water::WaterTable;

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
    /// What the turbine of the test gave and the winches took, if the test has one.
    pub energy: Option<Energy>,
    /// The share of its images of which no pose could be had, so that the controller was given the last one again; none without
    /// cameras.
    pub held_share: Option<f64>,
    /// The cameras that saw no dot in any image, by their place in [`Sensing::cameras`](crate::Sensing::cameras): the others
    /// may be enough for a pose, and whoever set such a camera up wants to know.
    pub blind_cameras: Vec<usize>,
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

/// What the loop that flies a rig has to know.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// A symmetric plant in water with its mean flow alone.
    Plain,
    /// A symmetric plant in water that moves beside its mean flow, or with a turbine.
    Moving,
    /// A plant whose sides differ, in water of either kind.
    Lopsided,
}

/// The tables of the water of a test; the last one is kept, for flights that share it.
#[derive(Clone)]
pub(crate) struct Tables<'a> {
    profile: &'a TestProfile,
    /// What tables at one sample time share, if they have a seed.
    course: Option<(u64, Option<Arc<Course>>)>,
    last: Option<(u64, Option<u64>, Arc<WaterTable>)>,
}

impl<'a> Tables<'a> {
    pub(crate) fn of(profile: &'a TestProfile) -> Self {
        Self { profile, course: None, last: None }
    }

    /// With what the tables of all flights share that have the sample time of `first`; an error is said where it flies.
    pub(crate) fn seeded(profile: &'a TestProfile, first: &FlightRequest) -> Self {
        let mut tables = Self::of(profile);
        let _: Result<_, Error> = tables.course_at(first.rig.sample_time_s);
        tables
    }

    /// With the table that `first` needs, which flights without seeds of their own will share; an error is said where it flies.
    pub(crate) fn shared_with(profile: &'a TestProfile, first: &FlightRequest) -> Self {
        let mut tables = Self::of(profile);
        let _: Result<_, Error> = tables.get(first.rig.sample_time_s, None);
        tables
    }

    pub(crate) fn profile(&self) -> &'a TestProfile {
        self.profile
    }

    fn get(&mut self, sample_time_s: f64, seed: Option<u64>) -> Result<Option<Arc<WaterTable>>, Error> {
        let key = (sample_time_s.to_bits(), seed);
        if let Some((time, seed, table)) = &self.last
            && (*time, *seed) == key
        {
            return Ok(Some(Arc::clone(table)));
        }
        let course = self.course_at(sample_time_s)?;
        let table = self.profile.water_on(course.as_deref(), sample_time_s, seed)?;
        self.last = table.as_ref().map(|table| (key.0, key.1, Arc::clone(table)));
        Ok(table)
    }

    fn course_at(&mut self, sample_time_s: f64) -> Result<Option<Arc<Course>>, Error> {
        let key = sample_time_s.to_bits();
        match &self.course {
            Some((time, course)) if *time == key => Ok(course.clone()),
            _ => {
                let course = self.profile.course(sample_time_s)?.map(Arc::new);
                self.course = Some((key, course.clone()));
                Ok(course)
            }
        }
    }
}

/// A rig made ready: checked plant and controller, the trim at the first flow, and the state at the start.
pub(crate) struct Ready {
    pub(crate) plant: Plant,
    pub(crate) controller: Controller,
    pub(crate) viewer: Option<Viewer>,
    pub(crate) trim: Trim,
    pub(crate) start: FlightState,
    /// Water that moves beside its mean flow.
    pub(crate) water: Option<Arc<WaterTable>>,
    /// The turbine of the test in the water of the rig.
    pub(crate) meter: Option<Meter>,
}

impl Ready {
    /// The code that flies it.
    pub(crate) fn kind(&self) -> Kind {
        match (self.plant.is_lopsided(), self.water.is_some() || self.meter.is_some()) {
            (true, _) => Kind::Lopsided,
            (false, true) => Kind::Moving,
            (false, false) => Kind::Plain,
        }
    }

    /// `seed`, where it is given, takes the place of the seed of the profile's water.
    pub(crate) fn new(request: &FlightRequest, tables: &mut Tables<'_>, seed: Option<u64>) -> Result<Self, Error> {
        let profile = tables.profile;
        let plant = request.rig.plant(request.fidelity)?;
        let controller = request.rig.controller()?;
        checked_count(profile.duration_s(), controller.parameters().sample_time_s)?;
        let viewer = request.rig.viewer()?;
        let water = tables.get(controller.parameters().sample_time_s, seed)?;
        let trim = trim_at(&plant, &request.rig.set_points, profile.flow().at(0.0))?;
        let departure = profile.start();
        let mut start = trim.state;
        start[0] += departure.zenith_rad;
        start[1] += departure.azimuth_rad;
        start[2] += departure.twist_rad;
        check_state(&start, 0.0)?;
        if let Some(viewer) = &viewer {
            viewer.check_start(&pose_of(&plant, &start, profile.flow().at(0.0)))?;
        }
        let density_kg_m3 = request.rig.plant.fluid.density_kg_m3;
        let meter =
            profile.turbine().map(|turbine| Meter { turbine: *turbine, density_kg_m3, energy: Energy::default() });
        Ok(Self { plant, controller, viewer, trim, start, water, meter })
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
                energy: ending.energy,
                held_share: ending.sight.as_ref().map(|sight| sight.held_share),
                blind_cameras: ending.sight.map_or_else(Vec::new, |sight| sight.blind_cameras),
            }),
        }
    }
}

/// A log of this test that is not too long: one of 1e7 rows takes gigabytes.
pub(crate) fn check_log(rig: &Rig, profile: &TestProfile, every: usize) -> Result<(), Error> {
    let value = (checked_count(profile.duration_s(), rig.sample_time_s)? / every as f64).ceil();
    if value <= 1e7 {
        return Ok(());
    }
    let expected = "at most 1e7: more samples per row, or a shorter test";
    Err(Error::Argument { name: "number of log rows", value, expected })
}

/// Flies `request` through `profile`, from trim at the profile's first flow or the departure from it that the profile sets.
///
/// # Errors
/// [`FlightError`]: the flight cannot start, by cameras that see too little for a pose or by more than 1e8 samples either, leaves the model,
/// or a line goes slack where that is an error.
pub fn fly(request: &FlightRequest, profile: &TestProfile, settings: &FlightSettings) -> Result<Flight, FlightError> {
    settings.validate()?;
    let ready = Ready::new(request, &mut Tables::of(profile), None)?;
    let [ending] = one(&ready, profile, settings, |_| {});
    ready.finish(ending)
}

/// Flies like [`fly`] and keeps every `every`-th sample; the log ends where a failed flight ends.
///
/// # Errors
/// [`FlightError::Start`] when there is no flight at all, or a log of more than 1e7 rows. A flight that fails later has a log and an
/// outcome.
pub fn fly_logged(
    request: &FlightRequest,
    profile: &TestProfile,
    settings: &FlightSettings,
    every: usize,
) -> Result<(Result<Flight, FlightError>, FlightLog), FlightError> {
    settings.validate()?;
    if every == 0 {
        return Err(Error::Argument { name: "samples per log row", value: 0.0, expected: "at least 1" }.into());
    }
    let ready = Ready::new(request, &mut Tables::of(profile), None)?;
    check_log(&request.rig, profile, every)?;
    let mut rows = Vec::new();
    let mut sample = 0;
    let [ending] = one(&ready, profile, settings, |seen| {
        if sample % every == 0 {
            rows.push(LogRow::of(seen, 0, &request.rig));
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
        viewers: [ready.viewer.as_ref()],
        sample_time_s: ready.controller.parameters().sample_time_s,
        profile,
        settings,
        water: ready.water.as_deref().map(|water| [water]),
        meters: [ready.meter],
        used: 1,
    };
    match ready.kind() {
        Kind::Plain => integrate::<f64, 1, false, false>(&setup, [&ready.start], watch),
        Kind::Moving => integrate::<f64, 1, false, true>(&setup, [&ready.start], watch),
        Kind::Lopsided => integrate::<f64, 1, true, true>(&setup, [&ready.start], watch),
    }
}
