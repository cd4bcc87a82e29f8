//! How well a regressor explains responses.

use faer::linalg::solvers::DenseSolveCore as _;
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
    /// Correlations of the unknown parts of regressors.
    correlations: Mat<f64>,
    /// Less their mean.
    responses: Vec<f64>,
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
    /// The inverse of the covariance.
    inverse: Mat<f64>,
    /// The responses times that.
    weighted: Vec<f64>,
}

/// Where 1 is to tell nothing, no part that is not known need be larger.
const MOST_UNKNOWN: f64 = 1e3;

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
        let centered: Vec<f64> = data.values().iter().map(|value| value - mean).collect();
        let square = |x: &[f64], y: &[f64]| -> f64 { x.iter().zip(y).map(|(a, b)| (a - b).powi(2)).sum() };
        let correlations = Mat::from_fn(n_points, n_points, |i, j| smooth_correlation(square(points[i], points[j])));
        let pairs = RESIDUALS.into_iter().flat_map(|residual| NOISES.map(|noise| [residual, noise]));
        let alternatives = pairs.filter_map(|[residual, noise]| {
            let matrix = Mat::from_fn(n_points, n_points, |i, j| {
                let (x, y) = (points[i], points[j]);
                let dot: f64 = x.iter().zip(y).map(|(a, b)| a * b).sum();
                let noise = if i == j { noise * noise } else { 0.0 };
                CONSTANT + SLOPE * dot + residual * residual * correlations[(i, j)] + noise
            });
            let llt = matrix.llt(Side::Lower).ok()?;
            let (factor, inverse) = (llt.L().to_owned(), llt.inverse());
            let log_determinant = (0..n_points).map(|i| 2.0 * factor[(i, i)].ln()).sum();
            let responses = solved(&factor, centered.iter().copied());
            let weighted = (0..n_points).map(|i| (0..n_points).map(|j| inverse[(i, j)] * centered[j]).sum());
            let weighted = weighted.collect();
            Some(Alternative { factor, log_determinant, responses, inverse, weighted })
        });
        let alternatives = alternatives.collect();
        Ok(Self { alternatives, correlations, responses: centered, n_points })
    }

    /// Logarithm of the marginal likelihood with this regressor, up to a constant of the responses. It is to be of order one: the prior
    /// deviation of its factor is what the sizes of all else are given in.
    ///
    /// # Errors
    ///
    /// [`Error::Length`] unless there is one value per response.
    pub fn log_likelihood(&self, regressor: &[f64]) -> Result<f64, Error> {
        self.check_length(regressor)?;
        Ok(of_all(self.alternatives.iter().map(|one| one.log_likelihood(regressor, None))))
    }

    /// The same where the regressor is not known everywhere: at each point it lacks a part of this standard deviation, which is as smooth as the
    /// residual, and times the factor 1. Where that is 1, the regressor tells nothing.
    ///
    /// # Errors
    ///
    /// [`Error::Length`] unless there is one value, and one deviation, per response; [`Error::Value`] for a deviation that is negative, no
    /// number, or above 1000: from some 1e6 on rounding would decide.
    pub fn log_likelihood_in_part(&self, regressor: &[f64], unknown: &[f64]) -> Result<f64, Error> {
        self.check_unknown(unknown)?;
        let points: Vec<usize> = (0..self.n_points).filter(|&point| unknown[point] > 0.0).collect();
        if points.is_empty() || regressor.len() != self.n_points {
            return self.log_likelihood(regressor);
        }
        // A diagonal that is a little more than it is, as the matrix is close to singular where points are close together.
        let covariance = |i: usize, j: usize| {
            let nugget = if i == j { 1.0 + 1e-10 } else { 1.0 };
            nugget * unknown[points[i]] * unknown[points[j]] * self.correlations[(points[i], points[j])]
        };
        let Ok(factor) = Mat::from_fn(points.len(), points.len(), covariance).llt(Side::Lower) else {
            return Ok(f64::NEG_INFINITY);
        };
        let parts = UnknownParts { points, factor: factor.L().to_owned() };
        Ok(of_all(self.alternatives.iter().map(|one| one.log_likelihood(regressor, Some(&parts)))))
    }

    /// The same without each of the responses in turn: what stands and falls with one of them is seen by that. The mean that all are less
    /// by stays that of all.
    ///
    /// # Errors
    ///
    /// As [`log_likelihood_in_part`](Self::log_likelihood_in_part).
    pub fn log_likelihoods_without_each(&self, regressor: &[f64], unknown: &[f64]) -> Result<Vec<f64>, Error> {
        self.check_unknown(unknown)?;
        self.check_length(regressor)?;
        let of_each = self.alternatives.iter().filter_map(|one| self.without_each(one, regressor, unknown));
        let of_each: Vec<Vec<f64>> = of_each.collect();
        Ok((0..self.n_points).map(|left_out| of_all(of_each.iter().map(|one| one[left_out]))).collect())
    }

    /// By one pair of sizes. Without response i the determinant is that of all times the entry P_ii of the inverse, and the square of the
    /// responses less by (P y)_i²/P_ii (Rasmussen and Williams 2006, section 5.4.2).
    fn without_each(&self, one: &Alternative, regressor: &[f64], unknown: &[f64]) -> Option<Vec<f64>> {
        let n = self.n_points;
        let base = &one.factor * one.factor.transpose();
        let matrix = Mat::from_fn(n, n, |i, j| {
            base[(i, j)] + regressor[i] * regressor[j] + unknown[i] * unknown[j] * self.correlations[(i, j)]
        });
        let llt = matrix.llt(Side::Lower).ok()?;
        let (factor, inverse) = (llt.L(), llt.inverse());
        let log_determinant: f64 = (0..n).map(|i| 2.0 * factor[(i, i)].ln()).sum();
        let weighted = |i: usize| -> f64 { (0..n).map(|j| inverse[(i, j)] * self.responses[j]).sum() };
        let weighted: Vec<f64> = (0..n).map(weighted).collect();
        let square: f64 = weighted.iter().zip(&self.responses).map(|(weighted, response)| weighted * response).sum();
        let without = |i: usize| {
            let left = square - weighted[i].powi(2) / inverse[(i, i)];
            of_scale(log_determinant + inverse[(i, i)].ln(), [left, square], n - 1)
        };
        Some((0..n).map(without).collect())
    }

    fn check_length(&self, regressor: &[f64]) -> Result<(), Error> {
        if regressor.len() != self.n_points {
            return Err(Error::Length { name: "values", expected: self.n_points, found: regressor.len() });
        }
        Ok(())
    }

    fn check_unknown(&self, unknown: &[f64]) -> Result<(), Error> {
        let most = MOST_UNKNOWN;
        if let Some(point) = unknown.iter().position(|deviation| !(0.0..=most).contains(deviation)) {
            return Err(Error::Value { point, value: unknown[point], most });
        }
        if unknown.len() != self.n_points {
            return Err(Error::Length { name: "deviations", expected: self.n_points, found: unknown.len() });
        }
        Ok(())
    }
}

/// The logarithm of the marginal likelihood of so many responses, of whose `square` so much is left: the scale is integrated out.
fn of_scale(log_determinant: f64, [left, square]: [f64; 2], n: usize) -> f64 {
    // Responses that are all the same leave nothing to explain.
    let left = left.max(f64::EPSILON * square).max(f64::MIN_POSITIVE);
    -0.5 * (log_determinant + n as f64 * left.ln())
}

/// The logarithm of the sum of what these are the logarithms of.
fn of_all(logarithms: impl Iterator<Item = f64>) -> f64 {
    let of_each: Vec<f64> = logarithms.collect();
    let highest = of_each.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    highest + of_each.iter().map(|one| (one - highest).exp()).sum::<f64>().ln()
}

/// The points where a regressor is not known, and the lower Cholesky factor C of the covariance of what it lacks there.
struct UnknownParts {
    points: Vec<usize>,
    factor: Mat<f64>,
}

impl UnknownParts {
    /// Cᵀ times the entries of a vector at the points.
    fn times(&self, of_all: impl Fn(usize) -> f64) -> Vec<f64> {
        let n = self.points.len();
        (0..n).map(|i| (i..n).map(|j| self.factor[(j, i)] * of_all(self.points[j])).sum()).collect()
    }
}

impl Alternative {
    /// With the regressor the determinant grows, and the square of the responses falls, by what a change of rank one makes of them; before that,
    /// by what a change of the rank of the unknown parts does.
    fn log_likelihood(&self, regressor: &[f64], parts: Option<&UnknownParts>) -> f64 {
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let solved_regressor = solved(&self.factor, regressor.iter().copied());
        let mut grown = 1.0 + dot(&solved_regressor, &solved_regressor);
        let mut square = dot(&self.responses, &self.responses);
        let mut common = dot(&solved_regressor, &self.responses);
        let mut log_determinant = self.log_determinant;
        if let Some(parts) = parts {
            let Some([lost, of_both, of_regressor, of_responses]) = self.changes(regressor, parts) else {
                return f64::NEG_INFINITY;
            };
            log_determinant += lost;
            common -= of_both;
            grown -= of_regressor;
            square = (square - of_responses).max(0.0);
        }
        let left = square - common.powi(2) / grown;
        of_scale(log_determinant + grown.ln(), [left, square], self.responses.len())
    }

    /// By how much unknown parts, A + UVUᵀ, change the logarithm of the determinant and, of regressor s and responses y, sᵀA⁻¹y, sᵀA⁻¹s and yᵀA⁻¹y
    /// (Woodbury, with V = CCᵀ and I + Cᵀ(A⁻¹)C factored).
    fn changes(&self, regressor: &[f64], parts: &UnknownParts) -> Option<[f64; 4]> {
        let (points, n) = (&parts.points, parts.points.len());
        let inner = Mat::from_fn(n, n, |i, j| self.inverse[(points[i], points[j])]);
        let mut inner = parts.factor.transpose() * inner * &parts.factor;
        (0..n).for_each(|i| inner[(i, i)] += 1.0);
        let factor = inner.llt(Side::Lower).ok()?.L().to_owned();
        let log_determinant = (0..n).map(|i| 2.0 * factor[(i, i)].ln()).sum();
        let weighted = |point: usize| -> f64 {
            let column = self.inverse.col(point);
            regressor.iter().enumerate().map(|(other, value)| column[other] * value).sum()
        };
        let of_regressor = solved(&factor, parts.times(weighted).into_iter());
        let of_responses = solved(&factor, parts.times(|point| self.weighted[point]).into_iter());
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        Some([
            log_determinant,
            dot(&of_regressor, &of_responses),
            dot(&of_regressor, &of_regressor),
            dot(&of_responses, &of_responses),
        ])
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
