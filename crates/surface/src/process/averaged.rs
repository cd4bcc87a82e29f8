//! Gaussian processes averaged over structures and hyperparameters.

use std::sync::Arc;

use rayon::prelude::*;

use crate::Error;
use crate::process::covariance::{SimulationUse, Structure};
use crate::process::gaussian_process::{Contrast, GaussianProcess, Marginals};
use crate::process::joint::Joint;
use crate::process::places::Places;
use crate::process::sampler::{Sample, SamplerSettings, sample};
use crate::process::sites::Sites;

/// The response given measurements, averaged over the structures and hyperparameters that they leave possible.
#[derive(Debug, Clone)]
pub struct AveragedProcess {
    sites: Arc<Sites>,
    /// All of the same weight.
    particles: Vec<GaussianProcess>,
    log_evidence: f64,
}

impl AveragedProcess {
    /// The average that follows from these measurements.
    ///
    /// # Errors
    ///
    /// [`Error::Count`] for no structure, or structures with a simulation where there is none, and for fewer than two particles;
    /// [`Error::Parameter`] for a noise that is negative or not finite; [`Error::IllConditioned`].
    pub fn new(sites: Sites, settings: &SamplerSettings) -> Result<Self, Error> {
        if let Some(value) = settings.noise.filter(|noise| !(*noise >= 0.0 && noise.is_finite())) {
            return Err(Error::Parameter { name: "noise", value, expected: "a finite number from 0 on" });
        }
        if settings.particles < 2 {
            return Err(Error::Count { name: "particles", found: settings.particles, least: 2, most: usize::MAX });
        }
        let has_simulation = sites.places().simulated().is_some();
        let possible = |structure: &Structure| has_simulation || structure.simulation == SimulationUse::Ignored;
        let structures: Vec<Structure> = settings.structures.iter().copied().filter(possible).collect();
        if structures.is_empty() {
            return Err(Error::Count { name: "structures", found: 0, least: 1, most: usize::MAX });
        }
        let settings = SamplerSettings { structures, ..settings.clone() };
        let sites = Arc::new(sites);
        let Sample { particles, log_evidence } = sample(&sites, &settings);
        let particles: Result<Vec<_>, Error> = particles
            .into_par_iter()
            .map(|(structure, hyper)| GaussianProcess::new(Arc::clone(&sites), structure, hyper))
            .collect();
        Ok(Self { sites, particles: particles?, log_evidence })
    }

    /// The measurements.
    #[must_use]
    pub fn sites(&self) -> &Sites {
        &self.sites
    }

    /// The processes that are averaged, with equal weights.
    #[must_use]
    pub fn particles(&self) -> &[GaussianProcess] {
        &self.particles
    }

    /// The logarithm of the density of the measurements, averaged over all that was possible before them, but for a constant that depends on
    /// the sites alone: of two settings of the sampler, with the same sites, it tells which the measurements speak for, and how loudly. It is
    /// an estimate, by some tenths off with a hundred particles and by some units with a few.
    #[must_use]
    pub fn log_evidence(&self) -> f64 {
        self.log_evidence
    }

    /// Mean of the response at each place.
    ///
    /// # Errors
    ///
    /// Those of [`GaussianProcess::means`].
    pub fn means(&self, places: &Places) -> Result<Vec<f64>, Error> {
        let of_each = self.particles.par_iter().map(|particle| particle.means(places));
        let of_each = of_each.collect::<Result<Vec<Vec<f64>>, Error>>()?;
        let n = of_each.len() as f64;
        Ok((0..places.n_places()).map(|place| of_each.iter().map(|means| means[place] / n).sum()).collect())
    }

    /// Mean and variance of the response at each place, without noise; the variance counts how far the particles differ.
    ///
    /// # Errors
    ///
    /// Those of [`GaussianProcess::means`].
    pub fn marginals(&self, places: &Places) -> Result<Marginals, Error> {
        let of_each = self.particles.par_iter().map(|particle| particle.marginals(places));
        let of_each = of_each.collect::<Result<Vec<Marginals>, Error>>()?;
        let n = of_each.len() as f64;
        let mean = |place: usize| of_each.iter().map(|each| each.means[place] / n).sum::<f64>();
        let means: Vec<f64> = (0..places.n_places()).map(mean).collect();
        let variance = |place: usize| {
            let about = |each: &Marginals| each.variances[place] + (each.means[place] - means[place]).powi(2);
            of_each.iter().map(|each| about(each) / n).sum::<f64>()
        };
        let variances = (0..places.n_places()).map(variance).collect();
        Ok(Marginals { means, variances })
    }

    /// Means and covariances of each particle.
    ///
    /// # Errors
    ///
    /// Those of [`GaussianProcess::means`].
    pub fn joint_of_each(&self, places: &Places) -> Result<Vec<Joint>, Error> {
        self.particles.par_iter().map(|particle| particle.joint(places)).collect()
    }

    /// Means, and covariances of all pairs of places, without noise; they count how far the particles differ.
    ///
    /// # Errors
    ///
    /// Those of [`GaussianProcess::means`].
    pub fn joint(&self, places: &Places) -> Result<Joint, Error> {
        Ok(Joint::of_mixture(&self.joint_of_each(places)?))
    }

    /// How each particle sees the differences of places to the first of them.
    ///
    /// # Errors
    ///
    /// Those of [`GaussianProcess::contrast`].
    pub fn contrasts(&self, places: &Places) -> Result<Vec<Contrast>, Error> {
        self.particles.par_iter().map(|particle| particle.contrast(places)).collect()
    }

    /// For each site the mean of its values less what the other sites predict, in standard deviations of that difference: the
    /// mean over the particles. In the order of [`Sites::places`].
    #[must_use]
    pub fn standardized_leave_one_out(&self) -> Vec<f64> {
        let of_each: Vec<Vec<f64>> =
            self.particles.par_iter().map(GaussianProcess::standardized_leave_one_out).collect();
        let n = of_each.len() as f64;
        (0..self.sites.places().n_places()).map(|site| of_each.iter().map(|each| each[site] / n).sum()).collect()
    }

    /// Mean of ρ² over the particles, 0 for those that ignore the simulation.
    #[must_use]
    pub fn squared_simulation_factor(&self) -> f64 {
        let n = self.particles.len() as f64;
        self.particles.iter().map(|particle| particle.squared_simulation_factor() / n).sum()
    }

    /// Root of the mean variance of the error that the measurements of an assembly share; 0 where assemblies are not told apart.
    #[must_use]
    pub fn assembly_deviation(&self) -> f64 {
        let n = self.particles.len() as f64;
        self.particles.iter().map(|particle| particle.assembly_deviation().powi(2) / n).sum::<f64>().sqrt()
    }

    /// Root of the mean variance of a measurement of weight 1.
    #[must_use]
    pub fn noise(&self) -> f64 {
        let n = self.particles.len() as f64;
        self.particles.iter().map(|particle| particle.noise().powi(2) / n).sum::<f64>().sqrt()
    }
}
