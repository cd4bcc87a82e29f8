//! Where experiments fail.

use faer::linalg::triangular_solve::{solve_lower_triangular_in_place, solve_upper_triangular_in_place};
use faer::{Mat, Par, Side};
use statrs::distribution::{Continuous, ContinuousCDF, Normal};

use crate::Error;
use crate::process::covariance::{Covariance, Hyperparameters, Residual, SimulationUse, Structure};
use crate::process::places::Places;

/// The probability that an experiment gives a response: a probit of a Gaussian process, by Laplace's approximation
/// (Rasmussen and Williams 2006, Algorithms 3.1 and 3.2).
#[derive(Debug, Clone)]
pub struct Feasibility {
    places: Places,
    hyper: Hyperparameters,
    /// ∇ log p(labels | f) at the mode.
    gradient: Mat<f64>,
    /// √W on the diagonal.
    roots: Vec<f64>,
    /// Lower factor of I + √W K √W.
    factor: Mat<f64>,
    /// Prior mean of the process: most experiments give a response.
    offset: f64,
}

/// Over which outcomes go together, in coded units.
const LENGTH: f64 = 0.6;
const STRUCTURE: Structure = Structure { simulation: SimulationUse::Ignored, residual: Residual::Smooth };
/// Standard deviations of the latent process by which a design is feasible before anything failed.
const OFFSET: f64 = 1.0;

impl Feasibility {
    /// From places where experiments were made, each with whether it gave a response. Nothing if none failed: then every design
    /// may do.
    ///
    /// # Errors
    ///
    /// [`Error::Length`] unless there is one outcome per place.
    pub fn of(places: Places, succeeded: &[bool]) -> Result<Option<Self>, Error> {
        if succeeded.len() != places.n_places() {
            return Err(Error::Length { name: "outcomes", expected: places.n_places(), found: succeeded.len() });
        }
        if succeeded.iter().all(|&succeeded| succeeded) {
            return Ok(None);
        }
        let hyper = Hyperparameters {
            trend: 0.25,
            simulation: 0.0,
            residual: 4.0,
            lengths: vec![LENGTH; places.n_factors()],
            noise: 0.0,
            assembly: 0.0,
        };
        let covariance = Covariance::of(STRUCTURE, &hyper).without_constant().between(&places, &places);
        let labels: Vec<f64> = succeeded.iter().map(|succeeded| if *succeeded { 1.0 } else { -1.0 }).collect();
        let n = labels.len();
        let normal = Normal::standard();
        let mut latent = Mat::<f64>::zeros(n, 1);
        let (mut gradient, mut roots, mut factor) = (Mat::zeros(n, 1), vec![0.0; n], Mat::identity(n, n));
        // Newton's steps for a concave objective; it settles in a handful.
        for _ in 0..30 {
            for i in 0..n {
                let at = labels[i] * (latent[(i, 0)] + OFFSET);
                // The inverse Mills ratio, by its asymptote where the tail underflows.
                let ratio = if at > -30.0 { normal.pdf(at) / normal.cdf(at) } else { -at };
                gradient[(i, 0)] = labels[i] * ratio;
                roots[i] = (ratio * (ratio + at)).max(1e-12).sqrt();
            }
            let mut matrix = Mat::from_fn(n, n, |i, j| roots[i] * covariance[(i, j)] * roots[j]);
            (0..n).for_each(|i| matrix[(i, i)] += 1.0);
            let Ok(llt) = matrix.llt(Side::Lower) else {
                break;
            };
            factor = llt.L().to_owned();
            let b = Mat::from_fn(n, 1, |i, _| roots[i] * roots[i] * latent[(i, 0)] + gradient[(i, 0)]);
            let product = &covariance * &b;
            let mut solved = Mat::from_fn(n, 1, |i, _| roots[i] * product[(i, 0)]);
            solve_lower_triangular_in_place(factor.as_ref(), solved.as_mut(), Par::Seq);
            solve_upper_triangular_in_place(factor.transpose(), solved.as_mut(), Par::Seq);
            let a = Mat::from_fn(n, 1, |i, _| b[(i, 0)] - roots[i] * solved[(i, 0)]);
            let next = &covariance * &a;
            let change = (&next - &latent).norm_max();
            latent = next;
            if change < 1e-9 {
                break;
            }
        }
        Ok(Some(Self { places, hyper, gradient, roots, factor, offset: OFFSET }))
    }

    /// Probability of a response at each place.
    #[must_use]
    pub fn probabilities(&self, places: &Places) -> Vec<f64> {
        let covariance = Covariance::of(STRUCTURE, &self.hyper).without_constant();
        let cross = covariance.between(places, &self.places);
        let means = &cross * &self.gradient;
        let mut whitened = Mat::from_fn(self.roots.len(), places.n_places(), |i, j| self.roots[i] * cross[(j, i)]);
        solve_lower_triangular_in_place(self.factor.as_ref(), whitened.as_mut(), Par::Seq);
        let prior = covariance.variances(places);
        let normal = Normal::standard();
        (0..places.n_places())
            .map(|place| {
                let variance = (prior[place] - whitened.col(place).squared_norm_l2()).max(0.0);
                normal.cdf((means[(place, 0)] + self.offset) / (1.0 + variance).sqrt())
            })
            .collect()
    }
}
