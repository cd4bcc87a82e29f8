//! How surfaces may turn out after a batch: common random numbers.

use statrs::distribution::{ContinuousCDF, Normal};

/// So many outcomes are looked at.
pub(crate) const OUTCOMES: u32 = 48;

/// Standard normals, evenly spread: a scrambled Sobol sequence, one dimension for each pick.
pub(crate) fn outcomes(dimension: u32, scramble: u32) -> Vec<f64> {
    let normal = Normal::standard();
    // Beyond the dimensions that the sequence has, they are used again with another scramble.
    let (round, dimension) = (dimension / sobol_burley::NUM_DIMENSIONS, dimension % sobol_burley::NUM_DIMENSIONS);
    let sample = |index| f64::from(sobol_burley::sample(index, dimension, scramble.wrapping_add(round)));
    (0..OUTCOMES).map(|index| normal.inverse_cdf(sample(index).clamp(1e-7, 1.0 - 1e-7))).collect()
}
