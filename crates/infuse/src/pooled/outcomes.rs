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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outcomes_are_spread_like_standard_normals_and_differ_from_pick_to_pick() {
        for scramble in [0, 7, u32::MAX] {
            let of_each: Vec<Vec<f64>> =
                [0, 1, sobol_burley::NUM_DIMENSIONS].map(|pick| outcomes(pick, scramble)).to_vec();
            for normals in &of_each {
                let n = f64::from(OUTCOMES);
                assert_eq!(normals.len(), OUTCOMES as usize);
                let mean = normals.iter().sum::<f64>() / n;
                let variance = normals.iter().map(|z| (z - mean).powi(2)).sum::<f64>() / n;
                // A sixth of the standard error that random numbers would have.
                assert!(mean.abs() < 0.15 / 6.0 * 2.0 && (variance - 1.0).abs() < 0.2, "{mean} {variance}");
            }
            assert!(of_each[0] != of_each[1] && of_each[0] != of_each[2] && of_each[1] != of_each[2]);
        }
    }
}
