//! Normal distributions of the response at several places together.

use faer::{Mat, Side};
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};

/// Means and covariances of the response at places, without noise.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    means: Vec<f64>,
    /// Row by row; symmetric.
    covariance: Vec<f64>,
}

impl Joint {
    pub(crate) fn new(means: Vec<f64>, covariance: &Mat<f64>, scale: f64) -> Self {
        let columns = covariance.col_iter().flat_map(|column| column.iter().map(|value| value * scale));
        Self { means, covariance: columns.collect() }
    }

    /// Number of places.
    #[must_use]
    pub fn n_places(&self) -> usize {
        self.means.len()
    }

    /// Mean at each place, in the unit of the response.
    #[must_use]
    pub fn means(&self) -> &[f64] {
        &self.means
    }

    /// Covariances of one place with all, in the squared unit of the response.
    ///
    /// # Panics
    ///
    /// For a place that is not there.
    #[must_use]
    pub fn covariances(&self, place: usize) -> &[f64] {
        &self.covariance[place * self.n_places()..][..self.n_places()]
    }

    /// Variance at a place.
    ///
    /// # Panics
    ///
    /// For a place that is not there.
    #[must_use]
    pub fn variance(&self, place: usize) -> f64 {
        self.covariances(place)[place]
    }

    /// Mean and covariance of a mixture of equal shares; the parts differ in what they say of the same places.
    ///
    /// # Panics
    ///
    /// If the parts are not all of as many places as the first.
    #[must_use]
    pub fn of_mixture(parts: &[Self]) -> Self {
        let (n, count) = (parts.first().map_or(0, Self::n_places), parts.len() as f64);
        let mean = |place: usize| parts.iter().map(|part| part.means[place] / count).sum::<f64>();
        let means: Vec<f64> = (0..n).map(mean).collect();
        let mut covariance = vec![0.0; n * n];
        for part in parts {
            let about: Vec<f64> = part.means.iter().zip(&means).map(|(own, mean)| own - mean).collect();
            for ((row, own), factor) in covariance.chunks_exact_mut(n.max(1)).zip(part.rows()).zip(&about) {
                for ((value, own), other) in row.iter_mut().zip(own).zip(&about) {
                    *value += (own + factor * other) / count;
                }
            }
        }
        Self { means, covariance }
    }

    /// Adds `factor` times the covariance of another quantity at the same places, independent of this one.
    ///
    /// # Panics
    ///
    /// If it has another number of places.
    pub fn add_covariance(&mut self, other: &Self, factor: f64) {
        assert_eq!(self.n_places(), other.n_places(), "both are of the same places");
        self.covariance.iter_mut().zip(&other.covariance).for_each(|(value, other)| *value += factor * other);
    }

    /// How the means move for a measurement at a place, of this variance of noise, that comes out one standard deviation above
    /// what is expected.
    ///
    /// # Panics
    ///
    /// For a place that is not there.
    #[must_use]
    pub fn effect(&self, place: usize, noise: f64) -> Vec<f64> {
        let deviation = (self.variance(place).max(0.0) + noise).sqrt();
        let scale = if deviation > 0.0 { 1.0 / deviation } else { 0.0 };
        self.covariances(place).iter().map(|value| value * scale).collect()
    }

    /// The covariance after a measurement of this [effect](Self::effect), by an update of rank one. The means stay.
    ///
    /// # Panics
    ///
    /// If the effect is of another number of places.
    pub fn measure(&mut self, effect: &[f64]) {
        let n = self.n_places();
        assert_eq!(n, effect.len(), "one effect per place");
        for (row, factor) in self.covariance.chunks_exact_mut(n.max(1)).zip(effect) {
            row.iter_mut().zip(effect).for_each(|(value, other)| *value -= factor * other);
        }
    }

    /// Draws from the distribution, one value per place each. Where rounding has left the covariance slightly indefinite, as
    /// little as needed is added to its diagonal.
    pub fn draws(&self, count: usize, rng: &mut impl Rng) -> Vec<Vec<f64>> {
        let n = self.n_places();
        let factor = self.lower_factor();
        let normals = Mat::<f64>::from_fn(n, count, |_, _| StandardNormal.sample(rng));
        let drawn: Mat<f64> = &factor * &normals;
        drawn.col_iter().map(|column| column.iter().zip(&self.means).map(|(z, mean)| mean + z).collect()).collect()
    }

    fn lower_factor(&self) -> Mat<f64> {
        let n = self.n_places();
        let mut matrix = Mat::from_fn(n, n, |row, column| self.covariances(row)[column]);
        let largest = (0..n).map(|place| self.variance(place)).fold(0.0, f64::max);
        let mut jitter = 1e-9 * largest + f64::MIN_POSITIVE;
        loop {
            (0..n).for_each(|place| matrix[(place, place)] += jitter);
            match matrix.llt(Side::Lower) {
                Ok(llt) => return llt.L().to_owned(),
                Err(_) if jitter < largest => jitter *= 10.0,
                Err(_) => return Mat::zeros(n, n),
            }
        }
    }

    fn rows(&self) -> impl Iterator<Item = &[f64]> {
        self.covariance.chunks_exact(self.n_places().max(1))
    }
}
