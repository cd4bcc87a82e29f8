//! The responses that have to stay within bounds, each with a surface of its own.

use design_space::Cell;
use rayon::prelude::*;
use surface::process::{AveragedProcess, Joint, Marginals, Places};

use crate::Error;
use crate::pooled::block::Block;
use crate::pooled::constraint::Constraint;
use crate::pooled::designs::Designs;
use crate::pooled::drift::Drift;
use crate::pooled::measurements::Reading;
use crate::pooled::settings::Settings;
use crate::pooled::simulated::{Column, Simulated, Source};

/// Where nobody knows a response, it keeps to its bounds with this probability.
pub(crate) const UNKNOWN: f64 = 0.5;

/// A constrained response, and what is known of it.
#[derive(Debug)]
pub(crate) struct Held {
    pub(crate) constraint: Constraint,
    column: Column,
    /// None before readings tell of other designs.
    process: Option<AveragedProcess>,
}

/// What is expected of a constrained response at places.
#[derive(Debug, Clone)]
pub(crate) struct Expected {
    pub(crate) means: Vec<f64>,
    pub(crate) deviations: Vec<f64>,
    /// Probability to keep to the bounds.
    pub(crate) within: Vec<f64>,
}

impl Held {
    /// From its readings; the simulation was run at their cells, if it is cheap.
    pub(crate) fn of(
        index: usize,
        readings: &[Reading],
        designs: &Designs,
        settings: &Settings,
        simulated: &Simulated,
        source: &Source<'_>,
    ) -> Result<Self, Error> {
        let (column, constraint) = (Column::Constrained(index), settings.constraints[index].clone());
        // One reading, or a few that are alike, tell of no other design.
        let is_alike = readings.windows(2).all(|pair| pair[0].response.to_bits() == pair[1].response.to_bits());
        if readings.len() < if is_alike { designs.n_to_tell() } else { 2 } {
            return Ok(Self { constraint, column, process: None });
        }
        let cells: Vec<Cell> = readings.iter().map(|reading| reading.cell).collect();
        let places = source.known_places(designs, &cells, simulated, column)?;
        let all: Vec<&Reading> = readings.iter().collect();
        let sites = Reading::sites(&all, designs, settings.plants.as_ref(), &places)?;
        let process = AveragedProcess::new(sites, &settings.sampler_of(&constraint))?;
        Ok(Self { constraint, column, process: Some(process) })
    }

    pub(crate) fn places(
        &self,
        designs: &Designs,
        cells: &[Cell],
        simulated: &Simulated,
        source: &Source<'_>,
    ) -> Result<Places, Error> {
        source.known_places(designs, cells, simulated, self.column)
    }

    /// What its readings say of a drift, of what the simulation says of their cells.
    pub(crate) fn drift(
        &self,
        readings: &[Reading],
        blocks: &[Block],
        places: &Places,
        settings: &Settings,
    ) -> Result<Option<Drift>, Error> {
        let sampler = settings.sampler_of(&self.constraint);
        let of = |process: &AveragedProcess| Drift::of(readings, blocks, places, process.particles(), &sampler);
        self.process.as_ref().map_or(Ok(None), of)
    }

    /// Standard deviation of the error that its readings of a block share.
    pub(crate) fn shared(&self) -> Option<f64> {
        self.process.as_ref().map(AveragedProcess::assembly_deviation)
    }

    /// Standard deviation of one reading.
    pub(crate) fn noise(&self) -> Option<f64> {
        self.process.as_ref().map(AveragedProcess::noise)
    }

    /// What is expected at places of this response, each particle asked.
    pub(crate) fn expected(&self, places: &Places, source: &Source<'_>) -> Result<Option<Expected>, Error> {
        let Some(process) = self.process.as_ref() else { return Ok(None) };
        let simulated = source.variances(places, self.column)?;
        let own = |place: usize| simulated.as_ref().map_or(0.0, |variances| variances[place]);
        let of_each = process.particles().par_iter().map(|particle| {
            let mut marginals = particle.marginals(places)?;
            let factor = particle.squared_simulation_factor();
            for (place, variance) in marginals.variances.iter_mut().enumerate() {
                *variance = (*variance + factor * own(place)).max(0.0);
            }
            Ok(marginals)
        });
        let of_each = of_each.collect::<Result<Vec<Marginals>, Error>>()?;
        let (n, count) = (places.n_places(), of_each.len() as f64);
        let (mut means, mut deviations, mut within) =
            (Vec::with_capacity(n), Vec::with_capacity(n), Vec::with_capacity(n));
        for place in 0..n {
            let at = || of_each.iter().map(|each| (each.means[place], each.variances[place]));
            let mean = at().map(|(mean, _)| mean / count).sum::<f64>();
            let variance = at().map(|(own, variance)| (variance + (own - mean).powi(2)) / count).sum::<f64>();
            let probability = |(mean, variance): (f64, f64)| self.constraint.probability_of(mean, variance.sqrt());
            within.push(at().map(|one| probability(one) / count).sum());
            means.push(mean);
            deviations.push(variance.sqrt());
        }
        Ok(Some(Expected { means, deviations, within }))
    }

    /// Probability to keep to the bounds, at each place.
    pub(crate) fn within(&self, places: &Places, source: &Source<'_>) -> Result<Vec<f64>, Error> {
        let expected = self.expected(places, source)?;
        Ok(expected.map_or_else(|| vec![UNKNOWN; places.n_places()], |expected| expected.within))
    }

    /// What each particle says of places together; nothing before readings tell of them.
    pub(crate) fn joint_of_each(&self, places: &Places, source: &Source<'_>) -> Result<Option<Vec<Joint>>, Error> {
        let Some(process) = self.process.as_ref() else { return Ok(None) };
        let mut of_each = process.joint_of_each(places)?;
        if let Some(simulated) = source.joint(places, self.column)? {
            for (joint, particle) in of_each.iter_mut().zip(process.particles()) {
                joint.add_covariance(&simulated, particle.squared_simulation_factor());
            }
        }
        Ok(Some(of_each))
    }
}

/// How likely designs are to be of use.
#[derive(Debug, Clone, Default)]
pub(crate) struct Chances {
    /// Probability that an experiment gives a response.
    pub(crate) responding: Vec<f64>,
    /// Probability that the design keeps to every constraint.
    pub(crate) within: Vec<f64>,
    /// Whether each probability is as high as it is asked for: the design may be recommended.
    pub(crate) suffices: Vec<bool>,
    /// Whether it may turn out so.
    pub(crate) possible: Vec<bool>,
}

/// A design may be recommended if an experiment there gives a response with this probability.
pub const FEASIBLE: f64 = 0.75;
/// A design of which an experiment gives a response with less than this probability is no longer thought of.
pub(crate) const MAY_RESPOND: f64 = 0.1;
/// A design that keeps to its bounds with less than this probability is no longer thought of.
const POSSIBLE: f64 = 0.05;

impl Chances {
    /// From the probability of a response, and of keeping to each constraint.
    pub(crate) fn of(responding: Vec<f64>, held: &[(&Constraint, Vec<f64>)]) -> Self {
        let mut chances = Self {
            within: vec![1.0; responding.len()],
            suffices: responding.iter().map(|&probability| probability >= FEASIBLE).collect(),
            possible: responding.iter().map(|&probability| probability >= MAY_RESPOND).collect(),
            responding,
        };
        for (constraint, within) in held {
            for (row, &within) in within.iter().enumerate() {
                chances.within[row] *= within;
                chances.suffices[row] &= within >= constraint.probability;
                chances.possible[row] &= within >= POSSIBLE;
            }
        }
        chances
    }

    /// How a row stands among those to recommend: those that suffice by their mean, and before all others; those by how likely
    /// they are to be of use, and where nothing tells that by their mean, too.
    pub(crate) fn rank(&self, row: usize, mean: f64) -> (bool, f64, f64) {
        let unlikely = if self.suffices[row] { 0.0 } else { -self.responding[row] * self.within[row] };
        (!self.suffices[row], unlikely, mean)
    }

    pub(crate) fn select(&self, rows: &[usize]) -> Self {
        let numbers = |values: &[f64]| rows.iter().map(|&row| values[row]).collect();
        let flags = |values: &[bool]| rows.iter().map(|&row| values[row]).collect();
        Self {
            responding: numbers(&self.responding),
            within: numbers(&self.within),
            suffices: flags(&self.suffices),
            possible: flags(&self.possible),
        }
    }

    pub(crate) fn followed_by(mut self, other: Self) -> Self {
        self.responding.extend(other.responding);
        self.within.extend(other.within);
        self.suffices.extend(other.suffices);
        self.possible.extend(other.possible);
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pooled::scene::Scene;

    /// What the particles say of each place is one mixture, however it is put together.
    #[test]
    fn what_is_expected_is_the_mixture_of_all_particles() {
        let mut scene = Scene::new(&[21]);
        for (x, travel) in [(0, 1.0), (6, 1.9), (11, 1.2), (20, 3.0)] {
            scene.read(&[x], travel);
        }
        scene.settings.constraints = vec![Constraint::at_most("travel", 2.0)];
        let (designs, simulated, source) = (&scene.designs, Simulated::default(), Source::Nothing);
        let held = Held::of(0, &scene.readings, designs, &scene.settings, &simulated, &source).unwrap();
        let cells: Vec<Cell> = (0..21).map(|x| scene.cell(&[x])).collect();
        let places = held.places(designs, &cells, &simulated, &source).unwrap();
        let expected = held.expected(&places, &source).unwrap().unwrap();
        let together = Joint::of_mixture(&held.joint_of_each(&places, &source).unwrap().unwrap());
        for place in 0..cells.len() {
            let (mean, deviation) = (together.means()[place], together.variance(place).max(0.0).sqrt());
            assert!((expected.means[place] - mean).abs() < 1e-9, "{mean} at {place}");
            assert!((expected.deviations[place] - deviation).abs() < 1e-7, "{deviation} at {place}");
        }
        assert!(expected.deviations.iter().any(|deviation| *deviation > 0.05), "{:?}", expected.deviations);
    }
}
