//! The case study as a problem: named design variables in, costs out, flights remembered.

use std::path::Path;

use anyhow::{Context as _, Result, bail};
use bat_dynamics::Fidelity;
#[cfg(feature = "global")]
use bat_dynamics::{FluidInertia, Lift};
#[cfg(feature = "global")]
use design_space::Region;
use water_channel::{
    CostBreakdown, CostFile, CostWeights, Flight, FlightLog, FlightRequest, FlightSettings, ProfileFile, Record, Rig,
    RigFile, TestProfile, fly, fly_all, fly_logged,
};

#[cfg(feature = "global")]
use crate::costs::key::Key;
use crate::costs::{Cost, Store};

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

    #[cfg(feature = "global")]
    fn name(self) -> &'static str {
        match self {
            Self::CenterOfMass => "center_of_mass",
            Self::PitchSetPoint => "pitch_set_point",
            Self::HorizontalArea => "horizontal_area",
            Self::VerticalArea => "vertical_area",
        }
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

/// The closed loop as a function of the design variables.
#[derive(Debug)]
pub(crate) struct Bat {
    rig: Rig,
    profile: TestProfile,
    weights: CostWeights,
    /// For searches and landscapes.
    settings: FlightSettings,
    /// For the designs that are reported.
    report_settings: FlightSettings,
    variables: Vec<Variable>,
    /// Of flights with the settings for searches.
    costs: Store,
    /// Rig, test and weights as their files have them.
    #[cfg_attr(not(feature = "global"), expect(dead_code, reason = "only costs on disk need a name"))]
    texts: [String; 3],
    pub(crate) records: Vec<Record>,
}

impl Bat {
    pub(crate) fn read(
        directory: &Path,
        [rig, profile, cost]: [&str; 3],
        variables: Vec<Variable>,
        [steps_per_sample, report_steps_per_sample]: [usize; 2],
    ) -> Result<Self> {
        let read = |name: &str| {
            let path = directory.join(name);
            std::fs::read_to_string(&path).with_context(|| path.display().to_string())
        };
        let texts = [read(rig)?, read(profile)?, read(cost)?];
        let rig = RigFile::parse(&texts[0]).with_context(|| rig.to_owned())?;
        let profile = ProfileFile::parse(&texts[1]).with_context(|| profile.to_owned())?;
        let cost = CostFile::parse(&texts[2]).with_context(|| cost.to_owned())?;
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
            costs: Store::default(),
            texts,
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
        if let Some(cost) = self.costs.get(point, fidelity) {
            return cost;
        }
        let cost = self.value(point, fly(&self.request(point, fidelity), &self.profile, &self.settings));
        self.costs.add(fidelity, [(point, &cost)]);
        cost
    }

    /// The costs at many points, flown in lanes and threads unless they are remembered; `done` is called with how many
    /// points each batch adds.
    pub(crate) fn costs(&self, points: &[Vec<f64>], fidelity: Fidelity, done: impl Fn(usize) + Sync) -> Vec<Cost> {
        let mut costs: Vec<Option<Cost>> = points.iter().map(|point| self.costs.get(point, fidelity)).collect();
        let missing: Vec<usize> = (0..points.len()).filter(|k| costs[*k].is_none()).collect();
        done(points.len() - missing.len());
        let unknown: Vec<Vec<f64>> = missing.iter().map(|k| points[*k].clone()).collect();
        let flown = self.flown_costs(&unknown, fidelity, done);
        self.costs.add(fidelity, unknown.iter().map(Vec::as_slice).zip(&flown));
        for (k, cost) in missing.into_iter().zip(flown) {
            costs[k] = Some(cost);
        }
        costs.into_iter().flatten().collect()
    }

    /// The same, all flown and none remembered.
    pub(crate) fn flown_costs(
        &self,
        points: &[Vec<f64>],
        fidelity: Fidelity,
        done: impl Fn(usize) + Sync,
    ) -> Vec<Cost> {
        let requests: Vec<FlightRequest> = points.iter().map(|point| self.request(point, fidelity)).collect();
        let flown = fly_all(&requests, &self.profile, &self.settings, done);
        points.iter().zip(flown).map(|(point, flight)| self.value(point, flight)).collect()
    }

    /// A flight of a reported design with its log, every `every`-th sample.
    pub(crate) fn logged(&self, point: &[f64], fidelity: Fidelity, every: usize) -> Result<(Flight, FlightLog)> {
        let (flight, log) = fly_logged(&self.request(point, fidelity), &self.profile, &self.report_settings, every)?;
        Ok((flight?, log))
    }

    /// How many different points are known in a fidelity.
    pub(crate) fn n_known(&self, fidelity: Fidelity) -> usize {
        self.costs.len(fidelity)
    }
}

/// On disk.
#[cfg(feature = "global")]
impl Bat {
    /// Keeps what is flown in these fidelities in a folder, and goes on with what is there: one file for each combination
    /// of rig, test, weights, step size, design variables and fidelity, named after all of it.
    pub(crate) fn keep_in(&self, directory: &Path, region: &Region, fidelities: &[Fidelity]) -> Result<()> {
        std::fs::create_dir_all(directory).with_context(|| directory.display().to_string())?;
        for fidelity in fidelities {
            let path = directory.join(format!("{}.tsv", self.key(region, *fidelity)));
            self.costs.keep_in(&path, *fidelity).with_context(|| path.display().to_string())?;
        }
        Ok(())
    }

    /// How many of these points no flight is known of.
    pub(crate) fn n_missing(&self, points: &[Vec<f64>], fidelity: Fidelity) -> usize {
        points.iter().filter(|point| self.costs.get(point, fidelity).is_none()).count()
    }

    /// A name for everything that a cost depends on. The plant, the controller and the integration of this program are
    /// in it by what they make of some designs, flown anew.
    fn key(&self, region: &Region, fidelity: Fidelity) -> String {
        let mut key = Key::default();
        for text in &self.texts {
            key = key.with(text);
        }
        key = key.with(self.settings.steps_per_sample.to_le_bytes());
        for variable in &self.variables {
            key = key.with(variable.name());
        }
        key = key.with(match fidelity.lift {
            Lift::Attached => "attached",
            Lift::Stalled => "stalled",
        });
        key = key.with(match fidelity.fluid_inertia {
            FluidInertia::Neglected => "neglected",
            FluidInertia::Included => "included",
        });
        for cost in self.flown_costs(&probes(region), fidelity, |_| {}) {
            key = match cost {
                Ok(cost) => key.with(cost.to_le_bytes()),
                Err(reason) => key.with(reason),
            };
        }
        key.name()
    }
}

/// Designs whose costs stand for the program, all over a region.
#[cfg(feature = "global")]
fn probes(region: &Region) -> Vec<Vec<f64>> {
    const N_PROBES: usize = 24;
    let share = |probe: usize, factor: usize| (0.5 + probe as f64 * f64::from([2, 3, 5, 7][factor % 4]).sqrt()).fract();
    let point = |probe: usize| {
        let parameters = region.parameters().iter().enumerate();
        parameters.map(|(factor, p)| p.lower() + share(probe, factor) * (p.upper() - p.lower())).collect()
    };
    (0..N_PROBES).map(point).collect()
}
