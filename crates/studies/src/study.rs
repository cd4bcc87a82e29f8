//! What the loop sees of the case study: named design variables in, costs out, flights remembered.

use std::collections::HashMap;
use std::path::Path;
use std::sync::Mutex;

use anyhow::{Context as _, Result, bail};
use bat_dynamics::Fidelity;
use serde::Deserialize;
use water_channel::{
    CostBreakdown, CostFile, CostWeights, Flight, FlightLog, FlightRequest, FlightSettings, ProfileFile, Record, Rig,
    RigFile, TestProfile, fly, fly_all, fly_logged,
};

/// The numerical model that the loop optimizes.
pub(crate) const MODEL: Fidelity = Fidelity::NUMERICAL;
/// What stands in for the water channel.
pub(crate) const STAND_IN: Fidelity = Fidelity::STALLED_WITH_ADDED_MASS;

/// A design variable of the case study, by the name that a study file uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Variable {
    /// Longitudinal position of the center of mass, in per cent of chord.
    CenterOfMass,
    /// Pitch set point, in degrees.
    PitchSetPoint,
    /// `A^H`, the factor on the area of the horizontal stabilizer.
    HorizontalArea,
    /// `A^V`, the factor on the area of the vertical stabilizer.
    VerticalArea,
}

impl Variable {
    pub(crate) fn named(name: &str, unit: &str) -> Result<Self> {
        let (variable, expected) = match name {
            "center_of_mass" => (Self::CenterOfMass, "% chord"),
            "pitch_set_point" => (Self::PitchSetPoint, "deg"),
            "horizontal_area" => (Self::HorizontalArea, "1"),
            "vertical_area" => (Self::VerticalArea, "1"),
            other => bail!(
                "parameter.name = `{other}`: it must be center_of_mass, pitch_set_point, horizontal_area or vertical_area"
            ),
        };
        if unit != expected {
            bail!("parameter `{name}` has the unit `{unit}`: it must be `{expected}`");
        }
        Ok(variable)
    }

    fn set(self, rig: &mut Rig, value: f64) {
        match self {
            Self::CenterOfMass => rig.plant.body.center_of_mass_x = value / 100.0,
            Self::PitchSetPoint => rig.set_points.pitch_rad = value.to_radians(),
            Self::HorizontalArea => rig.plant.horizontal_stabilizer.area_factor = value,
            Self::VerticalArea => rig.plant.vertical_stabilizer.area_factor = value,
        }
    }
}

/// The step sizes of a study file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct NumericsEntry {
    steps_per_sample: usize,
    report_steps_per_sample: usize,
}

impl NumericsEntry {
    /// RK4 steps per sample: in searches and landscapes, and for reported designs.
    pub(crate) fn steps(&self) -> [usize; 2] {
        [self.steps_per_sample, self.report_steps_per_sample]
    }
}

/// A flight's cost, or the reason why there is none.
pub(crate) type Cost = std::result::Result<f64, String>;

/// A point of the design space, bit for bit, in a fidelity.
type Key = (Fidelity, Vec<u64>);

fn key(point: &[f64], fidelity: Fidelity) -> Key {
    (fidelity, point.iter().map(|x| x.to_bits()).collect())
}

/// The closed loop as a function of the design variables.
#[derive(Debug)]
pub(crate) struct Study {
    rig: Rig,
    profile: TestProfile,
    weights: CostWeights,
    /// For searches and landscapes.
    settings: FlightSettings,
    /// For the designs that are reported.
    report_settings: FlightSettings,
    variables: Vec<Variable>,
    /// Flights carry no noise, so each point is flown once per fidelity.
    memory: Mutex<HashMap<Key, Cost>>,
    pub(crate) records: Vec<Record>,
}

impl Study {
    pub(crate) fn read(
        directory: &Path,
        [rig, profile, cost]: [&str; 3],
        variables: Vec<Variable>,
        [steps_per_sample, report_steps_per_sample]: [usize; 2],
    ) -> Result<Self> {
        let rig = RigFile::read(directory.join(rig))?;
        let profile = ProfileFile::read(directory.join(profile))?;
        let cost = CostFile::read(directory.join(cost))?;
        let settings = FlightSettings::with_steps(steps_per_sample);
        settings.validate().context("numerics.steps_per_sample")?;
        let report_settings = FlightSettings::with_steps(report_steps_per_sample);
        report_settings.validate().context("numerics.report_steps_per_sample")?;
        Ok(Self {
            rig: rig.rig,
            profile: profile.profile,
            weights: cost.weights,
            settings,
            report_settings,
            variables,
            memory: Mutex::default(),
            records: [rig.records, profile.records, cost.records].concat(),
        })
    }

    pub(crate) fn profile(&self) -> &TestProfile {
        &self.profile
    }

    /// The rig at a point of the design space.
    fn rig(&self, point: &[f64]) -> Rig {
        let mut rig = self.rig.clone();
        for (variable, value) in self.variables.iter().zip(point) {
            variable.set(&mut rig, *value);
        }
        rig
    }

    /// The same, to be flown in a fidelity.
    pub(crate) fn request(&self, point: &[f64], fidelity: Fidelity) -> FlightRequest {
        FlightRequest { rig: self.rig(point), fidelity }
    }

    /// The cost (21) of a flight at `point`, term by term.
    pub(crate) fn breakdown(&self, point: &[f64], flight: &Flight) -> CostBreakdown {
        let body = self.rig(point).plant.body;
        self.weights.cost(&flight.integrals, 100.0 * (body.center_of_mass_x - body.center_of_buoyancy_x))
    }

    fn value(&self, point: &[f64], flown: std::result::Result<Flight, water_channel::FlightError>) -> Cost {
        flown.map(|flight| self.breakdown(point, &flight).total).map_err(|error| error.to_string())
    }

    /// The cost at `point`, flown unless it is remembered.
    pub(crate) fn cost(&self, point: &[f64], fidelity: Fidelity) -> Cost {
        let key = key(point, fidelity);
        if let Some(cost) = self.remembered(&key) {
            return cost;
        }
        let cost = self.value(point, fly(&self.request(point, fidelity), &self.profile, &self.settings));
        self.remember(key, cost.clone());
        cost
    }

    /// The costs at many points, flown in lanes and threads; `landed` hears how many flights each batch added.
    pub(crate) fn costs(&self, points: &[Vec<f64>], fidelity: Fidelity, landed: impl Fn(usize) + Sync) -> Vec<Cost> {
        let known: Vec<Option<Cost>> = points.iter().map(|point| self.remembered(&key(point, fidelity))).collect();
        let missing: Vec<usize> = (0..points.len()).filter(|k| known[*k].is_none()).collect();
        landed(points.len() - missing.len());
        let unknown: Vec<Vec<f64>> = missing.iter().map(|k| points[*k].clone()).collect();
        let mut costs = known;
        for (k, cost) in missing.into_iter().zip(self.flown_costs(&unknown, fidelity, landed)) {
            self.remember(key(&points[k], fidelity), cost.clone());
            costs[k] = Some(cost);
        }
        costs.into_iter().flatten().collect()
    }

    /// The same, all flown and none remembered.
    pub(crate) fn flown_costs(
        &self,
        points: &[Vec<f64>],
        fidelity: Fidelity,
        landed: impl Fn(usize) + Sync,
    ) -> Vec<Cost> {
        let requests: Vec<FlightRequest> = points.iter().map(|point| self.request(point, fidelity)).collect();
        let flown = fly_all(&requests, &self.profile, &self.settings, landed);
        points.iter().zip(flown).map(|(point, flight)| self.value(point, flight)).collect()
    }

    /// Everything in this study that decides what a design costs in a fidelity, as text: rig, test, weights, step size
    /// and what the design variables are.
    pub(crate) fn contents(&self, fidelity: Fidelity) -> String {
        format!("{:?}", (&self.rig, &self.profile, &self.weights, &self.settings, &self.variables, fidelity))
    }

    /// A flight of a reported design with its log, every `every`-th sample.
    pub(crate) fn logged(&self, point: &[f64], fidelity: Fidelity, every: usize) -> Result<(Flight, FlightLog)> {
        let (flight, log) = fly_logged(&self.request(point, fidelity), &self.profile, &self.report_settings, every)?;
        Ok((flight?, log))
    }

    /// How many different points have been flown in a fidelity.
    pub(crate) fn flown(&self, fidelity: Fidelity) -> usize {
        self.lock().keys().filter(|(flown, _)| *flown == fidelity).count()
    }

    fn remembered(&self, key: &Key) -> Option<Cost> {
        self.lock().get(key).cloned()
    }

    fn remember(&self, key: Key, cost: Cost) {
        self.lock().insert(key, cost);
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, HashMap<Key, Cost>> {
        // A panic elsewhere cannot leave the map half written.
        self.memory.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }
}
