//! Random numbers for each purpose, all from the seed of the campaign.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// What random numbers are drawn for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Purpose {
    FirstBatch = 1,
    Pool = 3,
    KnowledgeGradient = 4,
    Certificate = 5,
    Simulations = 6,
    Recommendation = 7,
    Constraints = 8,
    Designs = 9,
    Plants = 10,
    Coverage = 11,
    Finds = 12,
    Displacement = 13,
}

/// An independent stream of the generator for a purpose in a batch.
pub(crate) fn stream(seed: u64, purpose: Purpose, batch: usize) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(((batch as u64) << 8) | purpose as u64);
    rng
}

#[cfg(test)]
mod tests {
    use super::*;

    use rand::RngExt as _;

    #[test]
    fn every_purpose_has_numbers_of_its_own_in_every_batch() {
        let purposes = [
            Purpose::FirstBatch,
            Purpose::Pool,
            Purpose::KnowledgeGradient,
            Purpose::Certificate,
            Purpose::Simulations,
            Purpose::Recommendation,
            Purpose::Constraints,
            Purpose::Designs,
            Purpose::Plants,
            Purpose::Coverage,
            Purpose::Finds,
            Purpose::Displacement,
        ];
        let all = purposes.into_iter().flat_map(|purpose| (0..4).map(move |batch| (purpose, batch)));
        let first =
            all.flat_map(|(purpose, batch)| (1..3).map(move |seed| stream(seed, purpose, batch).random::<u64>()));
        let distinct: std::collections::BTreeSet<u64> = first.collect();
        assert_eq!(distinct.len(), 12 * 4 * 2);
    }
}
