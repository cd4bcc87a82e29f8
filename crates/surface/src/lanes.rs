//! Points side by side, and how many coordinates they have.

use crate::Error;

/// Number of points that are evaluated side by side.
pub const LANES: usize = 32;

/// One number for each of [`LANES`] points.
pub type Lanes = [f64; LANES];

/// The largest number of factors of a surface, the same as of a model.
pub const MOST_FACTORS: usize = design_space::Model::MOST_FACTORS;

pub(crate) fn check_factors(n_factors: usize) -> Result<(), Error> {
    if (1..=MOST_FACTORS).contains(&n_factors) {
        Ok(())
    } else {
        Err(Error::Count { name: "factors", found: n_factors, least: 1, most: MOST_FACTORS })
    }
}

/// Whether a point has this many coordinates, all finite.
pub(crate) fn is_usable(point: &[f64], n_factors: usize) -> bool {
    point.len() == n_factors && point.iter().all(|x| x.is_finite())
}

/// A point as a block of one lane; none if it has another number of coordinates.
#[inline(always)]
pub(crate) fn one_lane(point: &[f64], n_factors: usize) -> Option<[[f64; 1]; MOST_FACTORS]> {
    (point.len() == n_factors).then(|| {
        let mut block = [[0.0]; MOST_FACTORS];
        block.iter_mut().zip(point).for_each(|(lane, &x)| *lane = [x]);
        block
    })
}
