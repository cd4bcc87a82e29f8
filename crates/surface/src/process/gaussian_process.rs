//! A Gaussian process with given hyperparameters.

use std::sync::Arc;

use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::{solve_lower_triangular_in_place, solve_upper_triangular_in_place};
use faer::{Accum, Mat, Par, Side};
use serde::{Deserialize, Serialize};
use statrs::distribution::{Continuous, ContinuousCDF, Normal};

use crate::Error;
use crate::process::covariance::{Hyperparameters, Parts, SimulationUse, Structure, prior_variances};
use crate::process::joint::Joint;
use crate::process::places::Places;
use crate::process::sites::Sites;

/// The response as a Gaussian process, given measurements and hyperparameters.
///
/// ```text
/// y(x) = c + q(x)'b + ρ s(x) + f(x) + g(x) + a + ε
/// ```
///
/// with q the linear and quadratic regressors, s the simulation, f of a Matérn covariance with a length per axis, g of one along some
/// axes alone where that is asked for, a the error of an assembly where these are told apart, and ε of the variance σ²/w. All of them
/// have normal priors, so that everything follows from one matrix (Rasmussen and Williams 2006, Section 2.7; Kennedy and O'Hagan 2000
/// for ρ).
#[derive(Debug, Clone)]
pub struct GaussianProcess {
    sites: Arc<Sites>,
    structure: Structure,
    hyper: Hyperparameters,
    /// Lower Cholesky factor of the covariance of the sites, noise included.
    factor: Mat<f64>,
    /// K⁻¹ r, with r the means less what the prior expects.
    solved: Mat<f64>,
    /// L⁻¹ r.
    whitened: Mat<f64>,
}

/// Smallest variance of the noise, in units of the squared scale: below it the factorization would lose digits.
pub(crate) const LEAST_NOISE: f64 = 1e-9;

/// Places that are computed at once: their covariances with some hundred sites stay in the second cache.
const AT_ONCE: usize = 256;

/// What the hyperparameters of a process leave alone.
#[derive(Debug)]
pub(crate) struct Problem<'a> {
    sites: &'a Sites,
    parts: Parts<'a>,
}

impl<'a> Problem<'a> {
    pub(crate) fn of(sites: &'a Sites) -> Self {
        let parts = Parts::between(sites.places(), sites.places(), sites.units());
        Self { sites, parts }
    }

    /// Lower factor of the covariance of the sites; none where the matrix is not positive definite.
    fn factor(&self, structure: Structure, hyper: &Hyperparameters) -> Option<Mat<f64>> {
        let mut matrix = self.parts.lower_half(structure, hyper);
        for (site, weight) in self.sites.weights().iter().enumerate() {
            matrix[(site, site)] += hyper.noise.max(LEAST_NOISE) / weight;
        }
        if let Some(assemblies) = self.sites.assemblies() {
            for (column, of_column) in assemblies.iter().enumerate() {
                for row in (column..assemblies.len()).filter(|&row| assemblies[row] == *of_column) {
                    matrix[(row, column)] += hyper.assembly;
                }
            }
        }
        matrix.llt(Side::Lower).ok().map(|llt| llt.L().to_owned())
    }

    /// Means of the sites less what the prior expects of them.
    fn residuals(&self, structure: Structure) -> Mat<f64> {
        let (means, units) = (self.sites.means(), self.sites.units());
        let factor = structure.prior_factor();
        let simulated = self.sites.places().simulated();
        Mat::from_fn(means.len(), 1, |site, _| {
            means[site] - simulated.map_or(0.0, |all| factor * units.simulated(all[site]))
        })
    }

    /// The logarithm of the likelihood, but for a constant that all structures share; −∞ where there is none.
    pub(crate) fn log_likelihood(&self, structure: Structure, hyper: &Hyperparameters) -> f64 {
        let Some(factor) = self.factor(structure, hyper) else {
            return f64::NEG_INFINITY;
        };
        let mut whitened = self.residuals(structure);
        solve_lower_triangular_in_place(factor.as_ref(), whitened.as_mut(), Par::Seq);
        let value = log_density(self.sites, &factor, &whitened, hyper);
        if value.is_nan() { f64::NEG_INFINITY } else { value }
    }
}

/// Estimates of the response at places, without noise.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "UncheckedEstimates")]
pub struct Marginals {
    /// Means, in the unit of the response.
    pub means: Vec<f64>,
    /// Variances, in its square.
    pub variances: Vec<f64>,
}

/// Means with their variances as they stand in a file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct UncheckedEstimates {
    means: Vec<f64>,
    variances: Vec<f64>,
}

impl UncheckedEstimates {
    fn checked(self) -> Result<(Vec<f64>, Vec<f64>), Error> {
        let (expected, found) = (self.means.len(), self.variances.len());
        if found != expected {
            return Err(Error::Length { name: "variances", expected, found });
        }
        match self.variances.iter().find(|variance| variance.is_nan() || **variance < 0.0) {
            Some(&value) => Err(Error::Parameter { name: "variance", value, expected: "0 or more" }),
            None => Ok((self.means, self.variances)),
        }
    }
}

impl TryFrom<UncheckedEstimates> for Marginals {
    type Error = Error;

    fn try_from(read: UncheckedEstimates) -> Result<Self, Error> {
        read.checked().map(|(means, variances)| Self { means, variances })
    }
}

impl TryFrom<UncheckedEstimates> for Contrast {
    type Error = Error;

    fn try_from(read: UncheckedEstimates) -> Result<Self, Error> {
        read.checked().map(|(means, variances)| Self { means, variances })
    }
}

impl Marginals {
    /// Both ends of the interval that holds the response at a place with this probability, as of a normal distribution. With the
    /// standard deviation of a reading as `noise` it is the prediction interval of one; with 0 that of the response itself.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] for a probability that is not between 0 and 1, or a noise that is negative or not finite,
    /// [`Error::NoSuchPoints`] for a place that is not there.
    pub fn interval(&self, place: usize, probability: f64, noise: f64) -> Result<[f64; 2], Error> {
        if !(probability > 0.0 && probability < 1.0) {
            return Err(Error::Parameter { name: "probability", value: probability, expected: "between 0 and 1" });
        }
        if !(noise >= 0.0 && noise.is_finite()) {
            return Err(Error::Parameter { name: "noise", value: noise, expected: "a finite number from 0 on" });
        }
        let (Some(mean), Some(variance)) = (self.means.get(place), self.variances.get(place)) else {
            let (first, n_points) = (place as u64, self.means.len() as u64);
            return Err(Error::NoSuchPoints { first, n_wanted: 1, n_points });
        };
        let half = Normal::standard().inverse_cdf(0.5 + probability / 2.0) * (variance + noise * noise).sqrt();
        Ok([mean - half, mean + half])
    }
}

/// Differences of the response at places to that at the first of them, without noise.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "UncheckedEstimates")]
pub struct Contrast {
    /// Means, in the unit of the response; 0 at the first place.
    pub means: Vec<f64>,
    /// Variances, in its square; 0 at the first place.
    pub variances: Vec<f64>,
}

impl Contrast {
    /// Probability that the response at a place is below that at the first.
    ///
    /// # Panics
    ///
    /// If there is no such place.
    #[must_use]
    pub fn probability_below(&self, place: usize) -> f64 {
        match (self.means[place], self.variances[place]) {
            (mean, variance) if variance > 0.0 => Normal::standard().cdf(-mean / variance.sqrt()),
            (mean, _) => f64::from(u8::from(mean < 0.0)),
        }
    }
}

impl GaussianProcess {
    /// The process that follows from these measurements.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] for a variance that is negative or a length that is not positive, [`Error::Length`], [`Error::IllConditioned`]
    /// if rounding has eaten the covariance of the sites.
    pub fn new(sites: Arc<Sites>, structure: Structure, hyper: Hyperparameters) -> Result<Self, Error> {
        hyper.check(sites.places().n_factors())?;
        let problem = Problem::of(&sites);
        let factor = problem.factor(structure, &hyper);
        let factor = factor.ok_or(Error::IllConditioned { ratio: 0.0, least: LEAST_NOISE })?;
        let mut whitened = problem.residuals(structure);
        solve_lower_triangular_in_place(factor.as_ref(), whitened.as_mut(), Par::Seq);
        let mut solved = whitened.clone();
        solve_upper_triangular_in_place(factor.transpose(), solved.as_mut(), Par::Seq);
        Ok(Self { sites, structure, hyper, factor, solved, whitened })
    }

    /// The measurements.
    #[must_use]
    pub fn sites(&self) -> &Sites {
        &self.sites
    }

    /// Which parts it has.
    #[must_use]
    pub fn structure(&self) -> Structure {
        self.structure
    }

    /// Its variances and lengths, the variances in units of the squared [`scale`](Self::scale).
    #[must_use]
    pub fn hyperparameters(&self) -> &Hyperparameters {
        &self.hyper
    }

    /// The unit of the hyperparameters: the standard deviation of the values.
    #[must_use]
    pub fn scale(&self) -> f64 {
        self.sites.units().scale
    }

    /// Standard deviation of a measurement of weight 1, in the unit of the response.
    #[must_use]
    pub fn noise(&self) -> f64 {
        self.hyper.noise.max(LEAST_NOISE).sqrt() * self.scale()
    }

    /// Standard deviation of the error that the measurements of an assembly share, in the unit of the response.
    #[must_use]
    pub fn assembly_deviation(&self) -> f64 {
        self.hyper.assembly.sqrt() * self.scale()
    }

    /// Whether these are places of this process.
    pub(crate) fn check(&self, places: &Places) -> Result<(), Error> {
        places.check_factors(self.sites.places().n_factors())?;
        if self.structure.simulation != SimulationUse::Ignored && places.simulated().is_none() {
            return Err(Error::Length { name: "simulated responses", expected: places.n_places(), found: 0 });
        }
        Ok(())
    }

    fn parts<'a>(&self, rows: &'a Places, columns: &Places) -> Parts<'a> {
        let units = self.sites.units();
        Parts::between(rows, columns, units)
    }

    /// What the prior expects at each place, scaled.
    fn prior_means(&self, places: &Places) -> impl Fn(usize) -> f64 {
        let (factor, units) = (self.structure.prior_factor(), self.sites.units());
        let expected: Vec<f64> = match places.simulated() {
            Some(all) => all.iter().map(|&s| factor * units.simulated(s)).collect(),
            None => vec![0.0; places.n_places()],
        };
        move |place| expected[place]
    }

    /// Covariances of each place with the sites, a row per place, and the means that follow from them, scaled.
    fn scaled_means(&self, places: &Places) -> (Mat<f64>, Vec<f64>) {
        let cross = self.parts(places, self.sites.places()).covariance(self.structure, &self.hyper);
        let mut means = Mat::zeros(places.n_places(), 1);
        matmul(means.as_mut(), Accum::Replace, &cross, &self.solved, 1.0, Par::Seq);
        let expected = self.prior_means(places);
        let means = (0..places.n_places()).map(|place| expected(place) + means[(place, 0)]).collect();
        (cross, means)
    }

    /// Means, scaled, and L⁻¹ k of each place in a column.
    fn conditioned(&self, places: &Places) -> (Vec<f64>, Mat<f64>) {
        let (cross, means) = self.scaled_means(places);
        let mut whitened = cross.transpose().to_owned();
        solve_lower_triangular_in_place(self.factor.as_ref(), whitened.as_mut(), Par::Seq);
        (means, whitened)
    }

    /// K⁻¹ r of the sites, scaled.
    pub(crate) fn solved(&self) -> &Mat<f64> {
        &self.solved
    }

    /// Covariances of the sites (rows) with places (columns), scaled.
    pub(crate) fn covariance_with_sites(&self, places: &Places) -> Mat<f64> {
        self.parts(self.sites.places(), places).covariance(self.structure, &self.hyper)
    }

    /// K⁻¹ times a matrix with a row per site.
    pub(crate) fn solve(&self, right: &Mat<f64>) -> Mat<f64> {
        let mut solved = right.clone();
        solve_lower_triangular_in_place(self.factor.as_ref(), solved.as_mut(), Par::Seq);
        solve_upper_triangular_in_place(self.factor.transpose(), solved.as_mut(), Par::Seq);
        solved
    }

    /// Mean at each place, in the unit of the response.
    ///
    /// # Errors
    ///
    /// [`Error::FactorMismatch`] unless the places have as many factors as the sites, [`Error::Length`] if the process uses a simulation
    /// and they do not have what it says.
    pub fn means(&self, places: &Places) -> Result<Vec<f64>, Error> {
        self.check(places)?;
        let units = self.sites.units();
        let scaled = places.blocks(AT_ONCE).flat_map(|block| self.scaled_means(&block).1);
        Ok(scaled.map(|mean| units.center + units.scale * mean).collect())
    }

    /// Mean and variance at each place.
    ///
    /// # Errors
    ///
    /// Those of [`means`](Self::means).
    pub fn marginals(&self, places: &Places) -> Result<Marginals, Error> {
        self.check(places)?;
        let n = places.n_places();
        let mut all = Marginals { means: Vec::with_capacity(n), variances: Vec::with_capacity(n) };
        for block in places.blocks(AT_ONCE) {
            let of_block = self.marginals_of_block(&block);
            all.means.extend(of_block.means);
            all.variances.extend(of_block.variances);
        }
        Ok(all)
    }

    fn marginals_of_block(&self, places: &Places) -> Marginals {
        let (mut cross, means) = self.scaled_means(places);
        // A row per place, as it stands: the steps of the solution then go over places side by side.
        solve_lower_triangular_in_place(self.factor.as_ref(), cross.transpose_mut(), Par::Seq);
        let mut explained = vec![0.0; places.n_places()];
        for column in cross.col_iter() {
            explained.iter_mut().zip(column.iter()).for_each(|(sum, value)| *sum += value * value);
        }
        let units = self.sites.units();
        let prior = prior_variances(places, self.structure, &self.hyper, units);
        let variances = prior.iter().zip(&explained).map(|(prior, explained)| (prior - explained).max(0.0));
        Marginals {
            means: means.iter().map(|mean| units.center + units.scale * mean).collect(),
            variances: variances.map(|variance| variance * units.scale * units.scale).collect(),
        }
    }

    /// Means, and covariances of all pairs of places, in the unit of the response and its square.
    ///
    /// # Errors
    ///
    /// Those of [`means`](Self::means).
    pub fn joint(&self, places: &Places) -> Result<Joint, Error> {
        self.check(places)?;
        let (means, whitened) = self.conditioned(places);
        let mut covariance = self.parts(places, places).covariance(self.structure, &self.hyper);
        matmul(covariance.as_mut(), Accum::Add, whitened.transpose(), &whitened, -1.0, Par::Seq);
        let units = self.sites.units();
        let means = means.iter().map(|mean| units.center + units.scale * mean).collect();
        Ok(Joint::new(means, &covariance, units.scale * units.scale))
    }

    /// How it sees the differences of places to the first of them.
    ///
    /// # Errors
    ///
    /// [`Error::Count`] without a place; those of [`means`](Self::means).
    pub fn contrast(&self, places: &Places) -> Result<Contrast, Error> {
        self.check(places)?;
        if places.n_places() == 0 {
            return Err(Error::Count { name: "places", found: 0, least: 1, most: usize::MAX });
        }
        let (means, whitened) = self.conditioned(places);
        let units = self.sites.units();
        let first = places.select(&[0]);
        let with_first = self.parts(places, &first).covariance(self.structure, &self.hyper);
        let prior = prior_variances(places, self.structure, &self.hyper, units);
        let variance = |place: usize| {
            let column = whitened.col(place);
            let own = prior[place] - column.squared_norm_l2();
            let of_first = prior[0] - whitened.col(0).squared_norm_l2();
            let both = with_first[(place, 0)] - (column.transpose() * whitened.col(0));
            (own + of_first - 2.0 * both).max(0.0) * units.scale * units.scale
        };
        let variances = (0..places.n_places()).map(|place| if place == 0 { 0.0 } else { variance(place) }).collect();
        Ok(Contrast { means: means.iter().map(|mean| units.scale * (mean - means[0])).collect(), variances })
    }

    /// Mean and variance of ρ after the measurements; none where the simulation is not used with a factor.
    #[must_use]
    pub fn simulation_factor(&self) -> Option<[f64; 2]> {
        let all = self.sites.places().simulated()?;
        if self.structure.simulation != super::SimulationUse::Scaled {
            return None;
        }
        let (units, variance) = (self.sites.units(), self.hyper.simulation);
        let mut scaled = Mat::from_fn(all.len(), 1, |site, _| units.simulated(all[site]));
        let mean: f64 = (0..all.len()).map(|site| scaled[(site, 0)] * self.solved[(site, 0)]).sum();
        solve_lower_triangular_in_place(self.factor.as_ref(), scaled.as_mut(), Par::Seq);
        Some([1.0 + variance * mean, (variance - variance * variance * scaled.squared_norm_l2()).max(0.0)])
    }

    /// Mean of ρ² after the measurements; 0 without a simulation.
    #[must_use]
    pub fn squared_simulation_factor(&self) -> f64 {
        match (self.structure.simulation, self.simulation_factor()) {
            (super::SimulationUse::Ignored, _) => 0.0,
            (_, Some([mean, variance])) => mean * mean + variance,
            (_, None) => 1.0,
        }
    }

    /// Mean of the values at each place less the mean that the others predict, divided by its standard deviation, noise of the
    /// place included: the sites in order (Rasmussen and Williams 2006, (5.12)).
    #[must_use]
    pub fn standardized_leave_one_out(&self) -> Vec<f64> {
        self.left_out().into_iter().map(|[distance, _]| distance).collect()
    }

    /// The logarithm of the density of the mean at each place as the others foretell it, scaled.
    pub(crate) fn log_left_out(&self) -> Vec<f64> {
        let normal = Normal::standard();
        self.left_out().into_iter().map(|[distance, variance]| normal.ln_pdf(distance) - 0.5 * variance.ln()).collect()
    }

    /// Of each site its distance from what the others foretell, in standard deviations, and the variance of that, scaled.
    fn left_out(&self) -> Vec<[f64; 2]> {
        let n = self.factor.nrows();
        let mut inverse = Mat::<f64>::identity(n, n);
        solve_lower_triangular_in_place(self.factor.as_ref(), inverse.as_mut(), Par::Seq);
        let precision = |site: usize| inverse.col(site).squared_norm_l2();
        (0..n).map(|site| [self.solved[(site, 0)] / precision(site).sqrt(), 1.0 / precision(site)]).collect()
    }

    /// The logarithm of the density of the measurements, scaled: what structures and hyperparameters are compared by.
    #[must_use]
    pub fn log_likelihood(&self) -> f64 {
        log_density(&self.sites, &self.factor, &self.whitened, &self.hyper)
    }
}

/// The logarithm of the density of the measurements from the lower factor L of their covariance and L⁻¹ r, but for a constant.
fn log_density(sites: &Sites, factor: &Mat<f64>, whitened: &Mat<f64>, hyper: &Hyperparameters) -> f64 {
    let logs: f64 = (0..factor.nrows()).map(|site| factor[(site, site)].ln()).sum();
    let noise = hyper.noise.max(LEAST_NOISE);
    let repeats = sites.n_repeats() as f64 * noise.ln() + sites.scatter() / noise;
    -0.5 * whitened.squared_norm_l2() - logs - 0.5 * repeats
}
