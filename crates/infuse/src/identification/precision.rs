//! What the Jacobian at an estimate says of its precision.

use nalgebra::{DMatrix, DVector};

/// Singular values below this share of the largest are zero.
const RANK: f64 = 1e-6;
/// Part of a unit direction that is rounding.
const ROUNDING: f64 = 1e-4;

/// The directions of a Jacobian in shares of the ranges, best determined first.
#[derive(Debug, Clone)]
pub(super) struct Directions {
    /// One for each unknown.
    pub(super) singular_values: Vec<f64>,
    /// Rows of length 1.
    rows: DMatrix<f64>,
}

impl Directions {
    pub(super) fn of(jacobian: &DMatrix<f64>) -> Self {
        let (m, n) = jacobian.shape();
        // With as many rows as columns or more there is a direction for each column.
        let svd = jacobian.clone().resize_vertically(m.max(n), 0.0).svd(false, true);
        let rows = svd.v_t.unwrap_or_else(|| DMatrix::identity(n, n));
        Self { singular_values: svd.singular_values.iter().copied().collect(), rows }
    }

    /// Whether a direction is not seen at all.
    pub(super) fn is_null(&self, k: usize) -> bool {
        let largest = self.singular_values.first().copied().unwrap_or(0.0);
        self.singular_values[k] <= RANK * largest
    }

    pub(super) fn rank(&self) -> usize {
        (0..self.singular_values.len()).filter(|k| !self.is_null(*k)).count()
    }

    /// Standard error along a direction as a share of the range; infinite where it is not seen.
    pub(super) fn error(&self, k: usize, sigma: f64) -> f64 {
        if self.is_null(k) { f64::INFINITY } else { sigma / self.singular_values[k] }
    }

    /// The directions whose standard error is larger than `largest`.
    pub(super) fn undetermined(&self, sigma: f64, largest: f64) -> Vec<usize> {
        (0..self.singular_values.len()).filter(|k| self.error(*k, sigma) > largest).collect()
    }

    pub(super) fn rows(&self, chosen: &[usize]) -> DMatrix<f64> {
        self.rows.select_rows(chosen)
    }

    /// Covariance of the unknowns i and j in shares of the ranges; infinite or without meaning where a direction that is
    /// not seen has a part in both.
    pub(super) fn covariance(&self, i: usize, j: usize, sigma: f64) -> f64 {
        let parts = (0..self.singular_values.len()).map(|k| {
            let (a, b) = (self.rows[(k, i)], self.rows[(k, j)]);
            if !self.is_null(k) {
                a * b * self.error(k, sigma).powi(2)
            } else if a.abs().min(b.abs()) <= ROUNDING {
                0.0
            } else {
                f64::INFINITY * a * b
            }
        });
        parts.sum()
    }

    /// Part of a vector that lies across the chosen directions.
    pub(super) fn across(&self, vector: &[f64], chosen: &[usize]) -> Vec<f64> {
        let vector = DVector::from_column_slice(vector);
        let rows = self.rows(chosen);
        let along = rows.transpose() * (&rows * &vector);
        (vector - along).iter().copied().collect()
    }
}
