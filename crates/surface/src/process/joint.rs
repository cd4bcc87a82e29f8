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

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use super::*;

    fn joint(means: [f64; 2], covariance: [f64; 4]) -> Joint {
        Joint { means: means.to_vec(), covariance: covariance.to_vec() }
    }

    fn check(found: &[f64], expected: &[f64], tolerance: f64) {
        assert_eq!(found.len(), expected.len(), "numbers");
        for (a, b) in found.iter().zip(expected) {
            assert!((a - b).abs() <= tolerance, "{found:?}, expected {expected:?}");
        }
    }

    #[test]
    fn mixture_has_the_variance_within_its_parts_and_between_them() {
        let parts = [joint([1.0, 5.0], [2.0, 0.5, 0.5, 1.0]), joint([3.0, -1.0], [1.0, -0.2, -0.2, 4.0])];
        let mixture = Joint::of_mixture(&parts);
        check(mixture.means(), &[2.0, 2.0], 1e-15);
        // The mean of the two, and what means that are (1, −3) and (−1, 3) away from theirs add.
        check(&mixture.covariance, &[1.5 + 1.0, 0.15 - 3.0, 0.15 - 3.0, 2.5 + 9.0], 1e-14);
    }

    #[test]
    fn draws_have_the_means_and_the_covariance() {
        let joint = joint([1.0, -2.0], [4.0, 1.5, 1.5, 1.0]);
        let count = 40_000;
        let draws = joint.draws(count, &mut ChaCha8Rng::seed_from_u64(1));
        assert_eq!((draws.len(), draws[0].len()), (count, 2), "one value per place, for each draw");
        let mean = |of: &dyn Fn(&[f64]) -> f64| draws.iter().map(|draw| of(draw)).sum::<f64>() / count as f64;
        check(&[mean(&|draw| draw[0]), mean(&|draw| draw[1])], &[1.0, -2.0], 0.04);
        let about = |a: usize, b: usize| mean(&|draw| (draw[a] - joint.means[a]) * (draw[b] - joint.means[b]));
        check(&[about(0, 0), about(0, 1), about(1, 1)], &[4.0, 1.5, 1.0], 0.12);
    }

    #[test]
    fn what_rounding_has_made_indefinite_is_drawn_with_little_more_on_the_diagonal() {
        let rng = &mut ChaCha8Rng::seed_from_u64(2);
        let off = 1.0 + 1e-6;
        for draw in joint([0.0, 0.0], [1.0, off, off, 1.0]).draws(200, rng) {
            assert!((draw[0] - draw[1]).abs() < 0.05, "{draw:?}: as good as the same number");
        }
        for draw in joint([3.0, 4.0], [0.0; 4]).draws(5, rng) {
            check(&draw, &[3.0, 4.0], 1e-100);
        }
    }
}
