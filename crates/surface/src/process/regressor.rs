//! How well a regressor explains responses.

use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Mat, Par, Side};

use crate::{Data, Error};

/// Prior variances in units of that of the regressor's factor: of the constant,
const CONSTANT: f64 = 10.0;
/// of a slope along an axis,
const SLOPE: f64 = 0.1;
/// and the standard deviations of the residual
const RESIDUALS: [f64; 3] = [0.1, 0.3, 1.0];
/// and of the noise, of which each pair is as likely.
const NOISES: [f64; 3] = [0.05, 0.15, 0.4];

/// How plausible responses are if they are a regressor times an unknown factor, a plane, a smooth residual and noise.
///
/// y = c + bᵀx + ρ s + r(x) + ε with normal priors of c, b and ρ, a Matérn-5/2 residual r of the length 1 in coded coordinates (half of the
/// box) and noise ε, all in proportion to an unknown scale, which is integrated out with the prior 1/σ² of its square, as are nine pairs of
/// sizes of residual and noise, from a tenth to all of what the regressor explains and from a twentieth to two fifths. So values of one regressor
/// at other places can be compared: the marginal likelihood of the same responses with each of them (Rasmussen and Williams 2006, section 5.4).
/// The responses are factored once, a regressor is a change of rank one.
#[derive(Debug, Clone)]
pub struct RegressorEvidence {
    alternatives: Vec<Alternative>,
    n_points: usize,
}

/// The responses by one pair of sizes.
#[derive(Debug, Clone)]
struct Alternative {
    /// Lower Cholesky factor of the covariance without the regressor.
    factor: Mat<f64>,
    log_determinant: f64,
    /// Solved with the factor.
    responses: Vec<f64>,
}

impl RegressorEvidence {
    /// Of these responses; weights are left out of account.
    ///
    /// # Errors
    ///
    /// [`Error::Count`] for fewer than two points.
    pub fn of(data: &Data) -> Result<Self, Error> {
        let n_points = data.n_points();
        if n_points < 2 {
            return Err(Error::Count { name: "points", found: n_points, least: 2, most: usize::MAX });
        }
        let points: Vec<&[f64]> = data.points().collect();
        let mean = data.values().iter().sum::<f64>() / n_points as f64;
        let pairs = RESIDUALS.into_iter().flat_map(|residual| NOISES.map(|noise| [residual, noise]));
        let alternatives = pairs.filter_map(|[residual, noise]| {
            let matrix = Mat::from_fn(n_points, n_points, |i, j| {
                let (x, y) = (points[i], points[j]);
                let dot: f64 = x.iter().zip(y).map(|(a, b)| a * b).sum();
                let square: f64 = x.iter().zip(y).map(|(a, b)| (a - b).powi(2)).sum();
                let noise = if i == j { noise * noise } else { 0.0 };
                CONSTANT + SLOPE * dot + residual * residual * smooth_correlation(square) + noise
            });
            let factor = matrix.llt(Side::Lower).ok()?.L().to_owned();
            let log_determinant = (0..n_points).map(|i| 2.0 * factor[(i, i)].ln()).sum();
            let responses = solved(&factor, data.values().iter().map(|value| value - mean));
            Some(Alternative { factor, log_determinant, responses })
        });
        Ok(Self { alternatives: alternatives.collect(), n_points })
    }

    /// Logarithm of the marginal likelihood with this regressor, up to a constant of the responses. It is to be of order one: the prior
    /// deviation of its factor is what the sizes of all else are given in.
    ///
    /// # Errors
    ///
    /// [`Error::Length`] unless there is one value per response.
    pub fn log_likelihood(&self, regressor: &[f64]) -> Result<f64, Error> {
        if regressor.len() != self.n_points {
            return Err(Error::Length { name: "values", expected: self.n_points, found: regressor.len() });
        }
        let of_each: Vec<f64> = self.alternatives.iter().map(|one| one.log_likelihood(regressor)).collect();
        let highest = of_each.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        Ok(highest + of_each.iter().map(|one| (one - highest).exp()).sum::<f64>().ln())
    }
}

impl Alternative {
    /// With the regressor the determinant grows, and the square of the responses falls, by what a change of rank one makes of them.
    fn log_likelihood(&self, regressor: &[f64]) -> f64 {
        let regressor = solved(&self.factor, regressor.iter().copied());
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let grown = 1.0 + dot(&regressor, &regressor);
        let square = dot(&self.responses, &self.responses);
        let left = square - dot(&regressor, &self.responses).powi(2) / grown;
        // Responses that are all the same leave nothing to explain.
        let left = left.max(f64::EPSILON * square).max(f64::MIN_POSITIVE);
        -0.5 * (self.log_determinant + grown.ln() + self.responses.len() as f64 * left.ln())
    }
}

/// Matérn-5/2 of the length 1.
fn smooth_correlation(square: f64) -> f64 {
    let r = (5.0 * square).sqrt();
    (1.0 + r + r * r / 3.0) * (-r).exp()
}

fn solved(factor: &Mat<f64>, values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut column = Mat::<f64>::zeros(factor.nrows(), 1);
    column.col_mut(0).iter_mut().zip(values).for_each(|(entry, value)| *entry = value);
    solve_lower_triangular_in_place(factor.as_ref(), column.as_mut(), Par::Seq);
    column.col(0).iter().copied().collect()
}
