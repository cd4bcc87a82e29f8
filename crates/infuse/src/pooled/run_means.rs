//! Where every design was run and a quadratic has as many terms as there are designs, the means of their runs say all there is.

use std::collections::BTreeMap;

use design_space::Cell;
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF as _, Normal, StudentsT};

use crate::pooled::measurements::Reading;
use crate::pure_error::PureError;

/// The runs of each design beside those of the recommended one.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct RunMeans {
    /// Of each other design, by how much its mean is below that of the recommended one, and √(1/n + 1/n').
    others: Vec<(f64, f64)>,
    /// Standard deviation of one run.
    deviation: f64,
    /// Degrees of freedom that it has; none where it is given.
    freedom: Option<f64>,
}

impl RunMeans {
    /// None where nothing tells the noise: it is not given, and no design was run twice.
    pub(crate) fn of(readings: &[Reading], recommended: Cell, noise: Option<f64>) -> Option<Self> {
        let mut runs: BTreeMap<Cell, Vec<f64>> = BTreeMap::new();
        readings.iter().for_each(|reading| runs.entry(reading.cell).or_default().push(reading.response));
        let mean = |runs: &[f64]| runs.iter().sum::<f64>() / runs.len() as f64;
        let (deviation, freedom) = match noise {
            Some(given) => (given, None),
            None => {
                let settings = readings.iter().map(|reading| (reading.coded.clone(), reading.response));
                let repeats = PureError::of_readings(settings)?;
                (repeats.standard_deviation(), Some(repeats.degrees_of_freedom as f64))
            }
        };
        let own = runs.get(&recommended)?;
        let other =
            |runs: &Vec<f64>| (mean(own) - mean(runs), (1.0 / own.len() as f64 + 1.0 / runs.len() as f64).sqrt());
        let others = runs.iter().filter(|(cell, _)| **cell != recommended).map(|(_, runs)| other(runs)).collect();
        Some(Self { others, deviation, freedom })
    }

    /// With this probability at least, none of the others is better by more (Student's t of each difference, of all at once by
    /// Bonferroni).
    pub(crate) fn bound(&self, probability: f64) -> f64 {
        let level = self.level(probability);
        let quantile = match self.freedom.and_then(|freedom| StudentsT::new(0.0, 1.0, freedom).ok()) {
            Some(student) => student.inverse_cdf(level),
            None => Normal::standard().inverse_cdf(level),
        };
        let of_each = self.others.iter().map(|(below, error)| below + quantile * self.deviation * error);
        of_each.fold(0.0, f64::max)
    }

    /// How that falls, of the design for which it is the largest once the noise is known.
    pub(crate) fn of_means(&self, probability: f64) -> OfMeans {
        let quantile = Normal::standard().inverse_cdf(self.level(probability));
        let of_each = self.others.iter().map(|(below, error)| (-below, quantile * self.deviation * error));
        let largest = of_each.max_by(|a, b| (a.1 - a.0).total_cmp(&(b.1 - b.0)));
        largest.map_or(OfMeans { behind: 0.0, error: 0.0 }, |(behind, error)| OfMeans { behind, error })
    }

    fn level(&self, probability: f64) -> f64 {
        1.0 - (1.0 - probability) / self.others.len().max(1) as f64
    }
}

/// How a bound of means of runs falls: it is the error, which is divided by the root of how many times as many runs there are, less what
/// the mean of the design is behind.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct OfMeans {
    /// By how much the mean of the other design is worse than that of the recommended one.
    pub behind: f64,
    /// By how much that may be wrong, were the noise known.
    pub error: f64,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pooled::scene::Scene;

    fn readings(levels: &[(u64, f64)]) -> Vec<Reading> {
        let mut scene = Scene::new(&[3]);
        levels.iter().for_each(|&(level, response)| scene.read(&[level], response));
        scene.readings
    }

    /// scipy: with a, b, c = [8.1, 8.4, 8.3], [8.2, 8.8], [9.9] the pooled deviation is 0.2651 with 3 degrees of freedom and
    /// stats.t.ppf(0.95, 3) is 2.3534; of a known deviation stats.norm.ppf(0.95) is 1.6449.
    #[test]
    fn bound_is_that_of_student_by_hand() {
        let some = readings(&[(0, 8.1), (1, 8.2), (0, 8.4), (2, 9.9), (0, 8.3), (1, 8.8)]);
        let deviation = ((0.026_666_666_666_667_f64 * 1.75 + 0.18) / 3.0).sqrt();
        let means = RunMeans::of(&some, Cell::new(0), None).unwrap();
        assert!((means.deviation - deviation).abs() < 1e-9 && means.freedom == Some(3.0), "{means:?}");
        // b is 0.2333 above a, c 1.6333: b may be better by more.
        let expected = -0.233_333_333_333_333 + 2.353_363_434_801_823 * deviation * (1.0_f64 / 3.0 + 0.5).sqrt();
        assert!((means.bound(0.9) - expected).abs() < 1e-6, "{} for {expected}", means.bound(0.9));
        // scipy.stats.norm.ppf(0.95): of a known deviation b's error is so large.
        let OfMeans { behind, error } = means.of_means(0.9);
        let expected = 1.644_853_626_951_472 * deviation * (1.0_f64 / 3.0 + 0.5).sqrt();
        assert!((behind - 0.233_333_333_333_333).abs() < 1e-9 && (error - expected).abs() < 1e-6, "{behind} {error}");
        let known = RunMeans::of(&some, Cell::new(1), Some(0.1)).unwrap();
        let expected = 0.233_333_333_333_333 + 1.644_853_626_951_472 * 0.1 * (1.0_f64 / 3.0 + 0.5).sqrt();
        assert!((known.bound(0.9) - expected).abs() < 1e-6, "{}", known.bound(0.9));
        let exact = RunMeans::of(&some, Cell::new(0), Some(0.0)).unwrap();
        assert!(exact.bound(0.9).abs() < 1e-15, "the lowest, and no noise");
        assert_eq!(RunMeans::of(&readings(&[(0, 1.0), (1, 2.0)]), Cell::new(0), None), None, "nothing tells the noise");
    }

    /// Of three designs of which the best is recommended by its runs, nine times in ten at least, whatever the noise.
    #[test]
    fn bound_holds_as_often_as_it_says() {
        use rand::SeedableRng as _;
        use rand_distr::{Distribution as _, StandardNormal};
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(3);
        for truth in [[0.0, 0.0, 0.0], [0.0, 0.4, 0.5], [0.0, 1.0, 1.3]] {
            let mut n_broken = 0;
            for _ in 0..2000 {
                let runs = |(level, &mean): (u64, &f64)| {
                    let noise: Vec<f64> = StandardNormal.sample_iter(&mut rng).take(2).collect();
                    noise.into_iter().map(move |noise: f64| (level, mean + noise)).collect::<Vec<_>>()
                };
                let some = readings(&(0..).zip(&truth).flat_map(runs).collect::<Vec<_>>());
                let mean = |level: usize| (some[2 * level].response + some[2 * level + 1].response) / 2.0;
                let best = (0..3).min_by(|&a, &b| mean(a).total_cmp(&mean(b))).unwrap();
                let bound = RunMeans::of(&some, Cell::new(best as u64), None).unwrap().bound(0.9);
                n_broken += usize::from(truth[best] - truth[0] > bound);
            }
            assert!(n_broken <= 200, "{truth:?}: {n_broken} of 2000");
        }
    }
}
