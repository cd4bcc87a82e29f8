//! What is known after some experiments: one surface through all of them, and where experiments fail.

use std::collections::BTreeSet;

use design_space::Cell;
use surface::process::{
    AveragedProcess, Contrast, Feasibility, Joint, Marginals, Places, Residual, SamplerSettings, SimulationUse,
    Structure,
};

use crate::Error;
use crate::pooled::block::Block;
use crate::pooled::constraint::Constraint;
use crate::pooled::designs::Designs;
use crate::pooled::displacement::Displacement;
use crate::pooled::drift::Drift;
use crate::pooled::held::{Chances, Expected, Held};
use crate::pooled::measurements::{Measurements, Reading};
use crate::pooled::registration::{Emulation, Registration, Runs, registered};
use crate::pooled::settings::Settings;
use crate::pooled::simulated::{Column, Simulated, Source};
use crate::pooled::streams::{Purpose, stream};

/// What others say of a reading.
#[derive(Debug, Clone, Copy)]
pub(crate) struct View {
    pub(crate) mean: f64,
    /// Standard deviation of a reading there.
    pub(crate) deviation: f64,
    /// Standard deviation of the noise alone.
    pub(crate) noise: f64,
}

impl View {
    /// How far a reading is from that, in standard deviations.
    pub(crate) fn of(&self, reading: &Reading) -> f64 {
        (reading.response - self.mean) / self.deviation
    }
}

/// Particles of the sceptic.
const SCEPTICAL: usize = 6;

/// The same sampler without the simulation, and with a residual that can be anything.
fn sceptical(sampler: &SamplerSettings) -> SamplerSettings {
    let structures = [Residual::Smooth, Residual::Rough];
    let structures = structures.map(|residual| Structure { simulation: SimulationUse::Ignored, residual }).to_vec();
    SamplerSettings { structures, particles: SCEPTICAL, ..sampler.clone() }
}

/// The surface, and what it takes to evaluate it elsewhere.
pub(crate) struct Knowledge<'a, 's> {
    pub(crate) designs: &'a Designs,
    pub(crate) process: AveragedProcess,
    /// The same measurements by one who believes neither the simulation nor that a polynomial is all there is; none where there is
    /// nothing to doubt, because one structure without a simulation is all that was asked for.
    pub(crate) sceptic: Option<AveragedProcess>,
    pub(crate) simulated: &'a mut Simulated,
    pub(crate) feasibility: Option<Feasibility>,
    /// Cells with a response, ascending.
    pub(crate) measured: Vec<Cell>,
    /// Cells where every experiment failed, ascending: neither asked for again nor recommended.
    pub(crate) failed: Vec<Cell>,
    /// The responses that have to stay within bounds.
    pub(crate) held: Vec<Held>,
    /// How far the simulation is displaced, as far as the readings tell.
    pub(crate) registration: Option<Registration>,
    source: Source<'s>,
}

impl<'a, 's> Knowledge<'a, 's> {
    pub(crate) fn of(
        measurements: &Measurements,
        designs: &'a Designs,
        settings: &Settings,
        simulated: &'a mut Simulated,
        mut source: Source<'s>,
    ) -> Result<Self, Error> {
        let Measurements { readings, constrained, failed, refused, .. } = measurements;
        let cells: Vec<Cell> = readings.iter().map(|reading| reading.cell).collect();
        let mut registration = None;
        if settings.displaced {
            // The same ones are tried in every batch, so that only new readings take new simulations.
            let mut rng = stream(settings.seed, Purpose::Displacement, 0);
            let found = match &mut source {
                Source::Nothing => None,
                Source::Cheap { simulate, screened, .. } => {
                    let mut runs = Runs { simulated: &mut *simulated, simulate: &mut **simulate, screened };
                    registered(readings, designs, &mut rng, &mut runs)?
                }
                Source::Emulated { emulator, .. } => {
                    let mut emulation = Emulation::of(emulator, simulated);
                    registered(readings, designs, &mut rng, &mut emulation)?
                }
            };
            let (displacement, found) = found.unzip();
            let displacement = displacement.filter(|_| found.as_ref().is_some_and(Registration::is_sure));
            source.displace(displacement.unwrap_or_default(), designs, &cells, simulated, constrained.len())?;
            registration = found;
        }
        let places = source.places(designs, &cells, simulated)?;
        let all: Vec<&Reading> = readings.iter().collect();
        let sites = Reading::sites(&all, designs, settings.plants.as_ref(), &places)?;
        let sampler = settings.sampler();
        let is_to_doubt = sites.places().simulated().is_some() || settings.structures.len() > 1;
        let sceptic = if is_to_doubt { Some(AveragedProcess::new(sites.clone(), &sceptical(&sampler))?) } else { None };
        let process = AveragedProcess::new(sites, &sampler)?;
        let measured: BTreeSet<Cell> = cells.into_iter().filter(|cell| !refused.contains(cell)).collect();
        let failed: Vec<Cell> = failed.difference(&measured).copied().collect();
        let measured: Vec<Cell> = measured.into_iter().collect();
        let tested: Vec<Cell> = measured.iter().chain(&failed).copied().collect();
        let succeeded: Vec<bool> = (0..tested.len()).map(|index| index < measured.len()).collect();
        let feasibility = Feasibility::of(designs.places(&tested)?, &succeeded)?;
        for readings in constrained {
            // Runs the simulation there, where that is cheap.
            source.places(designs, &readings.iter().map(|reading| reading.cell).collect::<Vec<_>>(), simulated)?;
        }
        let of_each = constrained.iter().enumerate();
        let held = of_each.map(|(index, readings)| Held::of(index, readings, designs, settings, simulated, &source));
        let held = held.collect::<Result<_, _>>()?;
        Ok(Self { designs, process, sceptic, simulated, feasibility, measured, failed, held, registration, source })
    }

    /// The settings of a reading, seen from a surface that was learnt without the readings that are `left_out`, of which
    /// it must be one.
    pub(crate) fn seen_from(
        &mut self,
        readings: &[Reading],
        left_out: impl Fn(&Reading) -> bool,
        one: &Reading,
        settings: &Settings,
    ) -> Result<View, Error> {
        let others: Vec<&Reading> = readings.iter().filter(|reading| !left_out(reading)).collect();
        let cells: Vec<Cell> = others.iter().map(|other| other.cell).chain([one.cell]).collect();
        let places = self.places(&cells)?;
        let of_others = places.select(&(0..others.len()).collect::<Vec<_>>());
        let sites = Reading::sites(&others, self.designs, settings.plants.as_ref(), &of_others)?;
        let process = AveragedProcess::new(sites, &settings.sampler())?;
        let here = places.select(&[others.len()]);
        let mut place = Places::new(self.designs.n_factors(), &one.coded)?;
        if let Some(simulated) = here.simulated() {
            place = place.with_simulated(simulated.to_vec())?.with_deviations(here.deviations().to_vec())?;
            if !here.unknown().is_empty() {
                place = place.with_unknown(here.unknown().to_vec())?;
            }
        }
        let (marginals, noise) = (process.marginals(&place)?, process.noise());
        let variance = marginals.variances[0] + noise.powi(2) + process.assembly_deviation().powi(2);
        Ok(View { mean: marginals.means[0], deviation: variance.sqrt(), noise })
    }

    /// How far the simulation is displaced, if it is.
    pub(crate) fn displacement(&self) -> Option<&Displacement> {
        self.source.displacement()
    }

    /// The design whose simulation tells of this one.
    pub(crate) fn simulated_at(&self, cell: Cell) -> Cell {
        self.displacement().map_or(cell, |displacement| displacement.of(self.designs, cell))
    }

    /// The designs for which the simulation says least.
    pub(crate) fn lowest_simulated(&self, count: usize) -> Vec<Cell> {
        let mut lowest = self.source.lowest(self.simulated, count);
        if let Some(displacement) = self.displacement() {
            lowest.iter_mut().for_each(|cell| *cell = displacement.back(self.designs, *cell));
        }
        lowest
    }

    /// Whether there is a simulation.
    pub(crate) fn is_simulated(&self) -> bool {
        !matches!(self.source, Source::Nothing)
    }

    /// Whether it is run wherever it is needed.
    pub(crate) fn is_simulated_everywhere(&self) -> bool {
        matches!(self.source, Source::Cheap { .. })
    }

    /// The probability that the response is better learnt without the simulation; one where there is none, or one that says the same of
    /// all that was measured.
    pub(crate) fn ignored(&self) -> f64 {
        let simulated = self.process.sites().places().simulated();
        if simulated.is_some_and(|simulated| simulated.windows(2).all(|two| two[0].to_bits() == two[1].to_bits())) {
            return 1.0;
        }
        let uses = self.process.particles().iter().map(|particle| particle.structure().simulation);
        let n_ignoring = uses.filter(|simulation| *simulation == SimulationUse::Ignored).count();
        n_ignoring as f64 / self.process.particles().len() as f64
    }

    /// Variance of one reading of an assembly that nothing else is known of.
    pub(crate) fn reading_variance(&self) -> f64 {
        self.process.noise().powi(2) + self.process.assembly_deviation().powi(2)
    }

    /// What the readings of each constrained response say of a drift.
    pub(crate) fn constrained_drifts(
        &self,
        constrained: &[Vec<Reading>],
        blocks: &[Vec<Block>],
        settings: &Settings,
    ) -> Result<Vec<Option<Drift>>, Error> {
        let of_each = self.held.iter().zip(constrained.iter().zip(blocks)).map(|(held, (readings, blocks))| {
            let cells: Vec<Cell> = readings.iter().map(|reading| reading.cell).collect();
            let places = held.places(self.designs, &cells, self.simulated, &self.source)?;
            held.drift(readings, blocks, &places, settings)
        });
        of_each.collect()
    }

    /// The same knowledge from other readings.
    pub(crate) fn through(self, measurements: &Measurements, settings: &Settings) -> Result<Self, Error> {
        Self::of(measurements, self.designs, settings, self.simulated, self.source)
    }

    /// Cells as places of the surface.
    pub(crate) fn places(&mut self, cells: &[Cell]) -> Result<Places, Error> {
        self.source.places(self.designs, cells, self.simulated)
    }

    /// Which of the cells to simulate next, those first of which the emulator knows least; none where there is no emulator.
    pub(crate) fn least_simulated(&self, cells: &[Cell], count: usize) -> Result<Vec<Cell>, Error> {
        match &self.source {
            Source::Emulated { emulator, .. } => emulator.most_uncertain(self.designs, cells, count),
            _ => Ok(Vec::new()),
        }
    }

    /// Mean and variance of the response, that of an uncertain simulation included.
    pub(crate) fn marginals(&self, places: &Places) -> Result<Marginals, Error> {
        let mut marginals = self.process.marginals(places)?;
        if let Some(simulated) = self.source.variances(places, Column::Cost)? {
            let factor = self.process.squared_simulation_factor();
            marginals.variances.iter_mut().zip(simulated).for_each(|(variance, own)| *variance += factor * own);
        }
        Ok(marginals)
    }

    /// What each particle says of places together, an uncertain simulation included.
    pub(crate) fn joint_of_each(&self, places: &Places) -> Result<Vec<Joint>, Error> {
        let mut of_each = self.process.joint_of_each(places)?;
        if let Some(simulated) = self.source.joint(places, Column::Cost)? {
            for (joint, particle) in of_each.iter_mut().zip(self.process.particles()) {
                joint.add_covariance(&simulated, particle.squared_simulation_factor());
            }
        }
        Ok(of_each)
    }

    /// How each particle sees the differences of places to the first of them.
    pub(crate) fn contrasts(&self, places: &Places) -> Result<Vec<Contrast>, Error> {
        let mut of_each = self.process.contrasts(places)?;
        if let Some(simulated) = self.source.variances_from_first(places)? {
            for (contrast, particle) in of_each.iter_mut().zip(self.process.particles()) {
                let factor = particle.squared_simulation_factor();
                contrast.variances.iter_mut().zip(&simulated).for_each(|(variance, own)| *variance += factor * own);
            }
        }
        Ok(of_each)
    }

    /// Probability that an experiment gives a response; 0 where it was seen to fail.
    fn responding(&self, cells: &[Cell], places: &Places) -> Result<Vec<f64>, Error> {
        let mut probabilities = match &self.feasibility {
            Some(feasibility) => feasibility.probabilities(places)?,
            None => vec![1.0; cells.len()],
        };
        for (probability, cell) in probabilities.iter_mut().zip(cells) {
            if self.failed.binary_search(cell).is_ok() {
                *probability = 0.0;
            } else if self.measured.binary_search(cell).is_ok() {
                *probability = 1.0;
            }
        }
        Ok(probabilities)
    }

    /// How likely the designs are to be of use; `places` are theirs.
    pub(crate) fn chances(&self, cells: &[Cell], places: &Places) -> Result<Chances, Error> {
        let mut within: Vec<(&Constraint, Vec<f64>)> = Vec::with_capacity(self.held.len());
        for held in &self.held {
            let places = held.places(self.designs, cells, self.simulated, &self.source)?;
            within.push((&held.constraint, held.within(&places, &self.source)?));
        }
        Ok(Chances::of(self.responding(cells, places)?, &within))
    }

    /// What is expected of each constrained response at the cells; nothing before its first reading.
    pub(crate) fn expected_of_each(&self, cells: &[Cell]) -> Result<Vec<Option<Expected>>, Error> {
        let expected = |held: &Held| {
            let places = held.places(self.designs, cells, self.simulated, &self.source)?;
            held.expected(&places, &self.source)
        };
        self.held.iter().map(expected).collect()
    }

    /// Of each constrained response what its particles say of the cells together; nothing before its first reading.
    pub(crate) fn constrained_joints(&self, cells: &[Cell]) -> Result<Vec<Option<Vec<Joint>>>, Error> {
        let joints = |held: &Held| {
            let places = held.places(self.designs, cells, self.simulated, &self.source)?;
            held.joint_of_each(&places, &self.source)
        };
        self.held.iter().map(joints).collect()
    }
}
