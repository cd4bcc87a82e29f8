//! Experiments without a water channel: a flight of the stand-in, read with noise of bounded size.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use crate::error::Error;

/// Multiplicative noise, uniform within a bound: a measured cost is `J (1 + e)`, |e| at most `relative_bound`.
///
/// The noise of an experiment depends on the seed and on the experiment's number and on nothing else, so that
/// experiments can be made in any order, repeated, or made side by side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundedNoise {
    relative_bound: f64,
    seed: u64,
}

impl BoundedNoise {
    /// Noise of at most `relative_bound` (0.02 for ±2 %), for the campaign `seed`.
    ///
    /// # Errors
    /// [`Error::Argument`] for a bound that is not within 0 and 1.
    pub fn new(relative_bound: f64, seed: u64) -> Result<Self, Error> {
        if (0.0..1.0).contains(&relative_bound) {
            return Ok(Self { relative_bound, seed });
        }
        Err(Error::Argument {
            name: "relative bound of the noise",
            value: relative_bound,
            expected: "0 or more and less than 1",
        })
    }

    /// The relative error of experiment `number`, within the bound.
    #[must_use]
    pub fn relative_error(&self, number: u64) -> f64 {
        // A generator for each experiment; neighbors in seed or number share no draw, and the first is thrown away.
        let mut generator = Pcg64::seed_from_u64(self.seed.wrapping_mul(0x9E37_79B9_7F4A_7C15).wrapping_add(number));
        let _: u64 = generator.random();
        let share: f64 = generator.random();
        self.relative_bound * (2.0 * share - 1.0)
    }

    /// What a rig with this noise reads in experiment `number` where the true cost is `cost`.
    #[must_use]
    pub fn measured(&self, cost: f64, number: u64) -> f64 {
        cost * (1.0 + self.relative_error(number))
    }
}
