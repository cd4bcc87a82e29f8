//! The case study as a problem: named design variables in, costs out, flights remembered.

use std::path::Path;

use anyhow::{Context as _, Result, ensure};
use bat_dynamics::{Fidelity, LANES};
#[cfg(feature = "global")]
use bat_dynamics::{FluidInertia, Lift};
#[cfg(feature = "global")]
use design_space::Region;
use rayon::prelude::*;
use water_channel::{
    CostBreakdown, CostFile, CostWeights, Flight, FlightError, FlightRequest, FlightSettings, ProfileFile, Record, Rig,
    RigFile, TestProfile, fly, fly_all, fly_all_logged, fly_logged,
};

#[cfg(feature = "ensemble")]
use water_channel::fly_seeded;

#[cfg(feature = "global")]
use crate::blind;
#[cfg(feature = "global")]
use crate::costs::key::Key;
use crate::costs::{Cost, Failure, Flown, Store};
#[cfg(feature = "global")]
use crate::kept;
use crate::logged::{LOG_EVERY, Logged};
use crate::study_file::{FilesEntry, NumericsEntry};
use crate::variable::Variable;

/// The numerical model that the loop optimizes.
pub(crate) const MODEL: Fidelity = Fidelity::NUMERICAL;
/// What stands in for the water channel.
pub(crate) const STAND_IN: Fidelity = Fidelity::STALLED_WITH_ADDED_MASS;

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
        files: &FilesEntry,
        variables: Vec<Variable>,
        numerics: &NumericsEntry,
    ) -> Result<Self> {
        let texts = files.read(directory)?;
        let [rig, profile, cost] = &texts;
        let rig = RigFile::parse(&rig.text).with_context(|| rig.name.clone())?;
        let profile = ProfileFile::parse(&profile.text).with_context(|| profile.name.clone())?;
        let cost_name = cost.name.clone();
        let cost = CostFile::parse(&cost.text).with_context(|| cost_name.clone())?;
        ensure!(
            cost.net_energy_per_w == 0.0,
            "{cost_name}: `k8_net_energy` is {}: it must be 0, the studies weigh no energy",
            cost.net_energy_per_w
        );
        let [steps_per_sample, report_steps_per_sample] = numerics.steps();
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
            texts: texts.map(|file| file.text),
            records: [rig.records, profile.records, cost.records].concat(),
        })
    }

    pub(crate) fn profile(&self) -> &TestProfile {
        &self.profile
    }

    /// The design variables, one for each coordinate of a point.
    pub(crate) fn variables(&self) -> &[Variable] {
        &self.variables
    }

    /// In per cent of chord.
    pub(crate) fn center_of_buoyancy(&self) -> f64 {
        100.0 * self.rig.plant.body.center_of_buoyancy_x
    }

    /// The rig at a point of the design space, to be flown in a fidelity.
    pub(crate) fn request(&self, point: &[f64], fidelity: Fidelity) -> FlightRequest {
        let mut rig = self.rig.clone();
        for (variable, value) in self.variables.iter().zip(point) {
            variable.set(&mut rig, *value);
        }
        FlightRequest { rig, fidelity }
    }

    /// The cost (21) of a flight of a rig, term by term.
    pub(crate) fn breakdown(&self, rig: &Rig, flight: &Flight) -> CostBreakdown {
        self.weights.cost(&flight.integrals, rig.ballast_pct_chord())
    }

    fn value(&self, rig: &Rig, flown: std::result::Result<Flight, FlightError>) -> Flown {
        flown.map(|flight| self.breakdown(rig, &flight).total).map_err(Failure::from)
    }

    /// The cost at `point`, flown unless it is remembered.
    pub(crate) fn cost(&self, point: &[f64], fidelity: Fidelity) -> Cost {
        if let Some(cost) = self.costs.get(point, fidelity) {
            return in_words(cost);
        }
        let request = self.request(point, fidelity);
        let cost = self.value(&request.rig, fly(&request, &self.profile, &self.settings));
        self.costs.add(fidelity, [(point, &cost)]);
        in_words(cost)
    }

    /// The costs at many points, flown in lanes and threads unless they are remembered; `done` is called with how many
    /// points each batch adds.
    pub(crate) fn costs(&self, points: &[Vec<f64>], fidelity: Fidelity, done: impl Fn(usize) + Sync) -> Vec<Cost> {
        let mut costs: Vec<Option<Flown>> = points.iter().map(|point| self.costs.get(point, fidelity)).collect();
        let missing: Vec<usize> = (0..points.len()).filter(|k| costs[*k].is_none()).collect();
        done(points.len() - missing.len());
        let unknown: Vec<Vec<f64>> = missing.iter().map(|k| points[*k].clone()).collect();
        let flown = self.flown_costs(&unknown, fidelity, done);
        self.costs.add(fidelity, unknown.iter().map(Vec::as_slice).zip(&flown));
        for (k, cost) in missing.into_iter().zip(flown) {
            costs[k] = Some(cost);
        }
        costs.into_iter().flatten().map(in_words).collect()
    }

    /// The same, all flown and none remembered.
    pub(crate) fn flown_costs(
        &self,
        points: &[Vec<f64>],
        fidelity: Fidelity,
        done: impl Fn(usize) + Sync,
    ) -> Vec<Flown> {
        let requests: Vec<FlightRequest> = points.iter().map(|point| self.request(point, fidelity)).collect();
        let flown = fly_all(&requests, &self.profile, &self.settings, done);
        requests.iter().zip(flown).map(|(request, flight)| self.value(&request.rig, flight)).collect()
    }

    /// The costs at points in several fidelities, flown together unless they are remembered.
    pub(crate) fn costs_in_each(&self, asked: &[(Vec<Vec<f64>>, Fidelity)]) -> Vec<Vec<Cost>> {
        let all = || asked.iter().flat_map(|(points, fidelity)| points.iter().map(|point| (point, *fidelity)));
        let mut unknown: Vec<(&Vec<f64>, Fidelity)> = Vec::new();
        for (point, fidelity) in all() {
            if self.costs.get(point, fidelity).is_none() && !unknown.contains(&(point, fidelity)) {
                unknown.push((point, fidelity));
            }
        }
        let requests: Vec<FlightRequest> =
            unknown.iter().map(|(point, fidelity)| self.request(point, *fidelity)).collect();
        let flown = fly_all(&requests, &self.profile, &self.settings, |_| {});
        for (((point, fidelity), request), flight) in unknown.into_iter().zip(&requests).zip(flown) {
            self.costs.add(fidelity, [(point.as_slice(), &self.value(&request.rig, flight))]);
        }
        // All are remembered now.
        asked.iter().map(|(points, fidelity)| self.costs(points, *fidelity, |_| {})).collect()
    }

    /// The costs, term by term, of these flights, all flown and none remembered.
    #[cfg(feature = "identification")]
    pub(crate) fn breakdowns(&self, requests: &[FlightRequest]) -> Vec<std::result::Result<CostBreakdown, String>> {
        let flown = fly_all(requests, &self.profile, &self.settings, |_| {});
        let both = requests.iter().zip(flown);
        both.map(|(request, flight)| match flight {
            Ok(flight) => Ok(self.breakdown(&request.rig, &flight)),
            Err(error) => Err(error.to_string()),
        })
        .collect()
    }

    /// What rig and weights are before a design is written into them.
    #[cfg(feature = "identification")]
    pub(crate) fn rig_and_weights(&self) -> (&Rig, &CostWeights) {
        (&self.rig, &self.weights)
    }

    /// A flight of a reported design.
    pub(crate) fn logged(&self, point: &[f64], fidelity: Fidelity) -> Result<Logged> {
        let request = self.request(point, fidelity);
        let (flight, log) = fly_logged(&request, &self.profile, &self.report_settings, LOG_EVERY)?;
        let flight = flight?;
        Ok(Logged { cost: self.breakdown(&request.rig, &flight), flight, log })
    }

    /// What `read` makes of flights of reported designs, which are flown side by side.
    pub(crate) fn read_logged<T: Send>(
        &self,
        points: &[Vec<f64>],
        fidelity: Fidelity,
        read: impl Fn(&[f64], Logged) -> T + Sync,
    ) -> Vec<Result<T>> {
        // A few at a time: logs are large.
        let fly = |some: &[Vec<f64>]| {
            let requests: Vec<FlightRequest> = some.iter().map(|point| self.request(point, fidelity)).collect();
            let flown = fly_all_logged(&requests, &self.profile, &self.report_settings, LOG_EVERY);
            let each = some.iter().zip(&requests).zip(flown).map(|((point, request), flown)| {
                let (flight, log) = flown?;
                Ok(read(point, Logged { cost: self.breakdown(&request.rig, &flight), flight, log }))
            });
            each.collect::<Vec<_>>()
        };
        points.par_chunks(LANES).flat_map_iter(fly).collect()
    }

    /// How many different points are known in a fidelity.
    pub(crate) fn n_known(&self, fidelity: Fidelity) -> usize {
        self.costs.len(fidelity)
    }
}

/// As the loops take it.
fn in_words(flown: Flown) -> Cost {
    flown.map_err(String::from)
}

/// On other plants.
#[cfg(feature = "ensemble")]
impl Bat {
    /// The same variables on another rig with other weights, in another test: nothing is remembered of any other. Reported
    /// designs have the steps of all others.
    pub(crate) fn on(&self, rig: Rig, weights: CostWeights, profile: TestProfile) -> Self {
        Self {
            rig,
            profile,
            weights,
            settings: self.settings,
            report_settings: self.settings,
            variables: self.variables.clone(),
            costs: Store::default(),
            texts: self.texts.clone(),
            records: Vec::new(),
        }
    }

    /// The costs at many points, each flown in the water of a seed of its own.
    pub(crate) fn seeded_costs(&self, points: &[Vec<f64>], seeds: &[u64], fidelity: Fidelity) -> Vec<Cost> {
        let requests: Vec<FlightRequest> = points.iter().map(|point| self.request(point, fidelity)).collect();
        let flown = fly_seeded(&requests, seeds, &self.profile, &self.settings, |_| {});
        requests.iter().zip(flown).map(|(request, flight)| in_words(self.value(&request.rig, flight))).collect()
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

    /// Knows from now on what is kept in a folder in these fidelities, if it is what this program flies: of every so many
    /// points one is flown anew, and has to cost the same bit for bit, or to fail for a reason of the same kind.
    pub(crate) fn take_over(&self, directory: &Path, region: &Region, fidelities: &[Fidelity]) -> Result<()> {
        for fidelity in fidelities {
            let path = directory.join(format!("{}.tsv", self.key(region, *fidelity)));
            let known = crate::costs::read(&path).with_context(|| path.display().to_string())?;
            let (points, costs): (Vec<Vec<f64>>, Vec<Flown>) = known.iter().step_by(kept::SAMPLE).cloned().unzip();
            for ((point, cost), anew) in points.iter().zip(costs).zip(self.flown_costs(&points, *fidelity, |_| {})) {
                kept::ensure_same(&format!("the cost of {point:?}"), &cost, &anew)?;
            }
            self.costs.add(*fidelity, known.iter().map(|(point, cost)| (point.as_slice(), cost)));
        }
        Ok(())
    }

    /// How many of these points no flight is known of.
    pub(crate) fn n_missing(&self, points: &[Vec<f64>], fidelity: Fidelity) -> usize {
        points.iter().filter(|point| self.costs.get(point, fidelity).is_none()).count()
    }

    /// A name for everything that a cost depends on. The plant, the controller and the integration of this program are
    /// in it by what they make of some designs, flown anew.
    pub(crate) fn key(&self, region: &Region, fidelity: Fidelity) -> String {
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
        for cost in self.flown_costs(&blind::points(region, N_PROBES), fidelity, |_| {}) {
            key = match cost {
                Ok(cost) => key.with(cost.to_le_bytes()),
                Err(failure) => key.with(failure.name()),
            };
        }
        key.name()
    }
}

/// Designs whose costs stand for the program, all over a region.
#[cfg(feature = "global")]
const N_PROBES: usize = 24;
