//! The fraction-of-design-space curve.

use serde::Serialize;

use super::sample::Sampling;

/// How much of a space is predicted with at most which variance: Zahran, Anderson-Cook and Myers' curve.
///
/// The curve begins at the smallest value of the sample and ends at the largest over all of the space, that of G; in
/// between it is the sample's.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FractionOfSpace {
    /// How the space was sampled.
    pub sampling: Sampling,
    /// Rising fractions from 0 to 1, equally spaced.
    pub fractions: Vec<f64>,
    /// The prediction variance, for unit variance of a run, that this fraction of the sample does not exceed.
    pub variances: Vec<f64>,
}

impl FractionOfSpace {
    /// Number of points of the curve.
    pub const N_POINTS: usize = 201;

    /// The curve through the values at the points of a sample, in any order, at least one, and the largest of all.
    pub(super) fn of(mut values: Vec<f64>, sampling: Sampling, maximum: f64) -> Self {
        values.sort_by(f64::total_cmp);
        let fractions: Vec<f64> = (0..Self::N_POINTS).map(|i| i as f64 / (Self::N_POINTS - 1) as f64).collect();
        let mut variances: Vec<f64> =
            fractions.iter().map(|fraction| quantile(&values, *fraction).min(maximum)).collect();
        variances[Self::N_POINTS - 1] = maximum;
        Self { sampling, fractions, variances }
    }

    /// The variance at any fraction, between the points of the curve on a straight line; none outside 0 to 1.
    #[must_use]
    pub fn variance_at(&self, fraction: f64) -> Option<f64> {
        (0.0..=1.0).contains(&fraction).then(|| quantile(&self.variances, fraction))
    }
}

/// Linear between order statistics, the smallest at 0 and the largest at 1.
fn quantile(sorted: &[f64], fraction: f64) -> f64 {
    let at = fraction * (sorted.len() - 1) as f64;
    let below = (at as usize).min(sorted.len() - 1);
    let above = (below + 1).min(sorted.len() - 1);
    sorted[below] + (at - below as f64) * (sorted[above] - sorted[below])
}
