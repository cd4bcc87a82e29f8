//! How far a quantity may be off, from places that were drawn from several densities: importance sampling.

use faer::linalg::solvers::DenseSolveCore as _;
use faer::{Mat, Side};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, StandardNormal};

/// Draws near a most probable place are spread by so many times the variances there, so that they reach its flanks.
const WIDER: f64 = 2.0;

/// A normal density.
#[derive(Debug, Clone)]
pub(crate) struct Normal {
    center: Vec<f64>,
    /// The lower Cholesky factor of its covariance.
    lower: Mat<f64>,
    /// Times this the factor is that of draws.
    scale: f64,
}

impl Normal {
    /// About zero, with these standard deviations.
    pub(crate) fn about_none(deviations: &[f64]) -> Self {
        Self { center: vec![0.0; deviations.len()], lower: diagonal(deviations), scale: 1.0 }
    }

    /// About a most probable place where the logarithm of the probability bends so much, and that is known to `within` alone.
    pub(crate) fn near(center: Vec<f64>, precision: &Mat<f64>, within: &[f64]) -> Self {
        let n = center.len();
        let with = |covariance: &dyn Fn(usize, usize) -> f64| {
            Mat::from_fn(n, n, |row, column| {
                covariance(row, column) + if row == column { within[row].powi(2) } else { 0.0 }
            })
        };
        let of_all = precision.llt(Side::Lower).ok().map(|factor| factor.inverse());
        let of_all = of_all.map(|inverse| with(&|row, column| inverse[(row, column)]));
        let lower = of_all.and_then(|covariance| covariance.llt(Side::Lower).ok().map(|factor| factor.L().to_owned()));
        // Where it bends up along some way between the axes, each is told alone.
        let alone = || {
            let of_each = (0..n).map(|row| (1.0 / precision[(row, row)] + within[row].powi(2)).sqrt());
            diagonal(&of_each.collect::<Vec<_>>())
        };
        Self { center, lower: lower.unwrap_or_else(alone), scale: WIDER.sqrt() }
    }

    pub(crate) fn center(&self) -> &[f64] {
        &self.center
    }

    /// Of one coordinate; not that of draws.
    pub(crate) fn variance(&self, row: usize) -> f64 {
        (0..=row).map(|column| self.lower[(row, column)].powi(2)).sum()
    }

    pub(crate) fn draw(&self, rng: &mut ChaCha8Rng) -> Vec<f64> {
        let normals: Vec<f64> = self.center.iter().map(|_| StandardNormal.sample(rng)).collect();
        let off = |row: usize| (0..=row).map(|column| self.lower[(row, column)] * normals[column]).sum::<f64>();
        self.center.iter().enumerate().map(|(row, center)| center + self.scale * off(row)).collect()
    }

    /// The logarithm of the density of draws.
    fn log_density(&self, place: &[f64]) -> f64 {
        let n = self.center.len();
        let mut normals: Vec<f64> = Vec::with_capacity(n);
        for (row, (place, center)) in place.iter().zip(&self.center).enumerate() {
            let entries = normals.iter().enumerate();
            let others: f64 = entries.map(|(column, normal)| self.lower[(row, column)] * normal).sum();
            normals.push(((place - center) / self.scale - others) / self.lower[(row, row)]);
        }
        let volume: f64 = (0..n).map(|row| (self.scale * self.lower[(row, row)]).ln()).sum();
        let square: f64 = normals.iter().map(|normal| normal * normal).sum();
        -0.5 * square - volume - 0.5 * n as f64 * (2.0 * std::f64::consts::PI).ln()
    }
}

fn diagonal(entries: &[f64]) -> Mat<f64> {
    Mat::from_fn(entries.len(), entries.len(), |row, column| if row == column { entries[row] } else { 0.0 })
}

/// Along each axis the mean of the square of the distance to a place, under probabilities whose logarithms are known, up to a
/// constant, of places that were drawn: so many of each of the densities (the balance heuristic of Veach and Guibas 1995).
pub(crate) fn mean_squares_about(
    center: &[f64],
    drawn: &[Vec<f64>],
    log_probabilities: &[f64],
    densities: &[(&Normal, usize)],
) -> Vec<f64> {
    let log_weight = |(place, log_probability): (&Vec<f64>, &f64)| {
        let of_each = densities.iter().map(|(density, count)| (*count as f64).ln() + density.log_density(place));
        let of_each: Vec<f64> = of_each.collect();
        let highest = of_each.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        log_probability - highest - of_each.iter().map(|one| (one - highest).exp()).sum::<f64>().ln()
    };
    let log_weights: Vec<f64> = drawn.iter().zip(log_probabilities).map(log_weight).collect();
    let highest = log_weights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let weights: Vec<f64> = log_weights.into_iter().map(|weight| (weight - highest).exp()).collect();
    let total: f64 = weights.iter().sum();
    let along = |(axis, center): (usize, &f64)| {
        let squares = drawn.iter().zip(&weights).map(|(place, weight)| weight * (place[axis] - center).powi(2));
        squares.sum::<f64>() / total
    };
    center.iter().enumerate().map(along).collect()
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng as _;

    use super::*;

    /// Against the closed form, of a covariance with correlation: log N(x; c, Σ) with Σ = [[4, 1], [1, 2]] · 2 + diag(0.5, 0.25)².
    #[test]
    fn log_densities_are_those_of_normal_laws() {
        let precision =
            Mat::from_fn(2, 2, |row, column| [[2.0 / 7.0, -1.0 / 7.0], [-1.0 / 7.0, 4.0 / 7.0]][row][column]);
        let near = Normal::near(vec![1.0, -2.0], &precision, &[0.5, 0.25]);
        let [[a, b], [_, d]]: [[f64; 2]; 2] = [[4.25, 1.0], [1.0, 2.0625]].map(|row| row.map(|entry| 2.0 * entry));
        for place in [[1.0, -2.0], [0.3, 1.2], [-4.0, -1.0]] {
            let (x, y) = (place[0] - 1.0, place[1] + 2.0);
            let determinant: f64 = a * d - b * b;
            let square = (d * x * x - 2.0 * b * x * y + a * y * y) / determinant;
            let expected = -0.5 * square - 0.5 * determinant.ln() - (2.0 * std::f64::consts::PI).ln();
            assert!((near.log_density(&place) - expected).abs() < 1e-12, "{place:?}");
        }
        assert!((near.variance(0) - 4.25).abs() < 1e-12 && (near.variance(1) - 2.0625).abs() < 1e-12);
    }

    /// Of a probability that is no normal one: along a line it is spread widely, across it narrowly. Draws of a wide law and of one that is
    /// close to the middle come to its moments about another place.
    #[test]
    fn a_mean_square_is_that_of_the_density_that_was_weighted() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        // x uniform from -1 to 2, y = x with the standard deviation 0.1.
        let log_probability = |place: &Vec<f64>| {
            let off = (place[1] - place[0]) / 0.1;
            if (-1.0..2.0).contains(&place[0]) { -0.5 * off * off } else { f64::NEG_INFINITY }
        };
        let wide = Normal::about_none(&[1.5, 1.5]);
        let precision = Mat::from_fn(2, 2, |row, column| if row == column { 101.0 } else { -100.0 });
        let near = Normal::near(vec![0.25, 0.25], &precision, &[0.0, 0.0]);
        let n = 40_000;
        let drawn: Vec<Vec<f64>> = (0..2 * n).map(|i| if i < n { &wide } else { &near }.draw(&mut rng)).collect();
        let log_probabilities: Vec<f64> = drawn.iter().map(log_probability).collect();
        let found = mean_squares_about(&[0.25, 0.25], &drawn, &log_probabilities, &[(&wide, n), (&near, n)]);
        // (x - 1/4)² over the interval: ((7/4)³ + (5/4)³) / 9.
        let expected = (1.75_f64.powi(3) + 1.25_f64.powi(3)) / 9.0;
        assert!((found[0] / expected - 1.0).abs() < 0.03, "{found:?}, {expected}");
        assert!((found[1] / (expected + 0.01) - 1.0).abs() < 0.03, "{found:?}, {expected}");
    }

    /// Where it bends up between the axes each is told alone.
    #[test]
    fn a_saddle_is_told_axis_by_axis() {
        let saddle = Mat::from_fn(2, 2, |row, column| if row == column { 4.0 } else { 5.0 });
        let near = Normal::near(vec![0.0, 0.0], &saddle, &[0.0, 0.0]);
        assert!([0, 1].iter().all(|&row| (near.variance(row) - 0.25).abs() < 1e-12));
    }
}
