//! How mean and variance of a process change with the place.

use faer::Mat;

use crate::Error;
use crate::process::averaged::AveragedProcess;
use crate::process::covariance::{Matern, SimulationUse};
use crate::process::gaussian_process::GaussianProcess;
use crate::process::places::Places;

/// Derivatives of mean and variance at a place, along each axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Gradient {
    /// ∂mean/∂x_j, in the unit of the response per coded unit.
    pub mean: Vec<f64>,
    /// ∂variance/∂x_j, without noise, in its square per coded unit.
    pub variance: Vec<f64>,
}

impl GaussianProcess {
    /// Gradient at one place. Where there is a simulation, `simulated` is its own gradient there, in the unit of the response per
    /// coded unit.
    ///
    /// At a site of a process without noise the variance has a kink; its derivative is then 0.
    ///
    /// # Errors
    ///
    /// [`Error::Length`] unless there is one place of as many factors as the sites have, and one slope of the simulation per
    /// axis and what it says at the place where the process uses one; [`Error::Parameter`] where that simulation may be off ([`Places::with_deviations`],
    /// [`Places::with_unknown`]).
    pub fn gradient(&self, place: &Places, simulated: Option<&[f64]>) -> Result<Gradient, Error> {
        let k = self.sites().places().n_factors();
        let length = |name, expected, found| Err(Error::Length { name, expected, found });
        if place.n_places() != 1 {
            return length("places", 1, place.n_places());
        }
        if place.n_factors() != k {
            return length("coordinates", k, place.n_factors());
        }
        self.check(place)?;
        let uses_it = self.structure().simulation != SimulationUse::Ignored;
        let n_ways = place.deviations().len() + usize::from(!place.unknown().is_empty());
        if uses_it && n_ways > 0 {
            let expected = "0: how they change with the place is not known";
            return Err(Error::Parameter { name: "deviations of the simulation", value: n_ways as f64, expected });
        }
        let slopes = match simulated.filter(|_| uses_it) {
            Some(slopes) if slopes.len() != k => return length("slopes of the simulation", k, slopes.len()),
            Some(slopes) => slopes.to_vec(),
            None if uses_it => return length("slopes of the simulation", k, 0),
            None => vec![0.0; k],
        };
        let scale = self.scale();
        let slopes: Vec<f64> = slopes.into_iter().map(|slope| slope / scale).collect();
        let (x, solved) = (place.point(0), self.solved());
        let cross = self.solve(&self.covariance_with_sites(place));
        let (mut mean, mut variance) = (Vec::with_capacity(k), Vec::with_capacity(k));
        for (axis, &slope) in slopes.iter().enumerate() {
            let along = self.covariance_slopes(place, axis, slope);
            let dot =
                |with: &Mat<f64>| along.iter().enumerate().map(|(site, slope)| slope * with[(site, 0)]).sum::<f64>();
            mean.push(scale * (self.structure().prior_factor() * slope + dot(solved)));
            let prior = self.prior_variance_slope(place, &x, axis, slope);
            variance.push(scale * scale * (prior - 2.0 * dot(&cross)));
        }
        Ok(Gradient { mean, variance })
    }

    /// ∂/∂x_j of the covariance of a place with each site.
    fn covariance_slopes(&self, place: &Places, axis: usize, slope: f64) -> Vec<f64> {
        let (hyper, sites) = (self.hyperparameters(), self.sites().places());
        let (x, terms) = (place.point(0), hyper.matern_terms(self.structure()));
        let one = |site: usize| {
            let at = sites.point(site);
            let mut along = hyper.trend * trend_slope(&x, &at, axis);
            if let (SimulationUse::Scaled, Some(all)) = (self.structure().simulation, sites.simulated()) {
                along += hyper.simulation * slope * self.sites().units().simulated(all[site]);
            }
            along + terms.iter().map(|term| term.slope(&x, &at, axis)).sum::<f64>()
        };
        (0..sites.n_places()).map(one).collect()
    }

    /// ∂/∂x_j of the variance before anything was measured.
    fn prior_variance_slope(&self, place: &Places, x: &[f64], axis: usize, slope: f64) -> f64 {
        let hyper = self.hyperparameters();
        let of_simulation = match (self.structure().simulation, place.simulated()) {
            (SimulationUse::Scaled, Some(all)) => hyper.simulation * slope * self.sites().units().simulated(all[0]),
            _ => 0.0,
        };
        2.0 * (hyper.trend * trend_slope(x, x, axis) + of_simulation)
    }
}

/// ∂q(x)/∂x_j · q(y), with q = x_i, x_i² − 1/3, x_i x_l.
fn trend_slope(x: &[f64], y: &[f64], axis: usize) -> f64 {
    let products: f64 = (0..x.len()).filter(|&other| other != axis).map(|other| x[other] * y[other]).sum();
    y[axis] * (1.0 + products) + 2.0 * x[axis] * (y[axis] * y[axis] - 1.0 / 3.0)
}

impl Matern {
    /// ∂/∂x_j of the covariance of x and y: with r = √5 d −(5/3)(1 + r) exp(−r) (x_j − y_j)/ℓ_j², with r = √3 d
    /// −3 exp(−r) (x_j − y_j)/ℓ_j², times the variance.
    fn slope(&self, x: &[f64], y: &[f64], axis: usize) -> f64 {
        let square: f64 = x.iter().zip(y).zip(&self.rates).map(|((x, y), rate)| rate * (x - y).powi(2)).sum();
        let along = self.variance * self.rates[axis] * (x[axis] - y[axis]);
        if self.is_rough {
            -3.0 * (-(3.0 * square).sqrt()).exp() * along
        } else {
            let r = (5.0 * square).sqrt();
            -5.0 / 3.0 * (1.0 + r) * (-r).exp() * along
        }
    }
}

impl AveragedProcess {
    /// Gradient at one place, how far the particles differ counted in; see [`GaussianProcess::gradient`].
    ///
    /// # Errors
    ///
    /// Those of [`GaussianProcess::gradient`].
    pub fn gradient(&self, place: &Places, simulated: Option<&[f64]>) -> Result<Gradient, Error> {
        let particles = self.particles();
        let n = particles.len() as f64;
        let of_each: Vec<Gradient> =
            particles.iter().map(|particle| particle.gradient(place, simulated)).collect::<Result<_, _>>()?;
        let means = particles.iter().map(|particle| Ok(particle.means(place)?[0]));
        let means = means.collect::<Result<Vec<f64>, Error>>()?;
        let center = means.iter().map(|mean| mean / n).sum::<f64>();
        let k = self.sites().places().n_factors();
        let mean: Vec<f64> = (0..k).map(|axis| of_each.iter().map(|each| each.mean[axis] / n).sum()).collect();
        let along = |axis: usize| {
            let one = |(each, own): (&Gradient, &f64)| {
                each.variance[axis] + 2.0 * (own - center) * (each.mean[axis] - mean[axis])
            };
            of_each.iter().zip(&means).map(|pair| one(pair) / n).sum::<f64>()
        };
        let variance = (0..k).map(along).collect();
        Ok(Gradient { mean, variance })
    }
}
