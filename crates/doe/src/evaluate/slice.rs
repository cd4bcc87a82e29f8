//! The prediction variance on a plane through the cube, for pictures.

use design_space::coded_level;
use serde::Serialize;

use crate::{Error, PredictionVariance};

/// Prediction variance on a lattice of the plane of two factors, the others held.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct VarianceSlice {
    /// The two factors that vary.
    pub factors: [usize; 2],
    /// The coded point that the plane passes through; its coordinates of the two factors do not matter.
    pub through: Vec<f64>,
    /// Coded levels of both axes, from −1 to 1.
    pub levels: Vec<f64>,
    /// For unit variance of a run, row by row: one row per level of the second factor, the first fastest.
    pub variances: Vec<f64>,
}

impl VarianceSlice {
    /// The largest number of levels.
    pub const MOST_LEVELS: usize = 2001;

    /// The slice of `n_levels` × `n_levels` points. Forbidden boxes are not left out:
    /// [`Space::contains`](crate::Space::contains) says what belongs to a space.
    ///
    /// # Errors
    ///
    /// [`PointLength`](design_space::Error::PointLength); [`Error::NoSuchFactor`]; [`Error::Count`] for fewer than two levels or more than
    /// [`MOST_LEVELS`](Self::MOST_LEVELS), or the same factor twice.
    pub fn of(
        variance: &PredictionVariance,
        factors: [usize; 2],
        through: &[f64],
        n_levels: usize,
    ) -> Result<Self, Error> {
        let n_factors = variance.n_factors();
        if through.len() != n_factors {
            return Err(Error::DesignSpace(design_space::Error::PointLength {
                expected: n_factors,
                found: through.len(),
            }));
        }
        if let Some(&index) = factors.iter().find(|&&index| index >= n_factors) {
            return Err(Error::NoSuchFactor { index, n_factors });
        }
        if factors[0] == factors[1] {
            return Err(Error::Count { name: "distinct factors of a slice", found: 1, least: 2, most: 2 });
        }
        if !(2..=Self::MOST_LEVELS).contains(&n_levels) {
            return Err(Error::Count { name: "levels of a slice", found: n_levels, least: 2, most: Self::MOST_LEVELS });
        }
        let levels: Vec<f64> = (0..n_levels as u64).map(|level| coded_level(level, n_levels as u64)).collect();
        let mut point = through.to_vec();
        let mut variances = Vec::with_capacity(n_levels * n_levels);
        for &second in &levels {
            for &first in &levels {
                point[factors[0]] = first;
                point[factors[1]] = second;
                variances.push(variance.at(&point)?);
            }
        }
        Ok(Self { factors, through: through.to_vec(), levels, variances })
    }
}
