//! Points that stand for a whole space.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use serde::Serialize;

use crate::lattice::Lattice;
use crate::measure::Measure;
use crate::power::power;
use crate::shape::{Axis, BoxShape, Shape};
use crate::{Error, Space};

/// How the points that stand for a space were chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Sampling {
    /// Every point of a list, or of a grid with no more points than asked for.
    All {
        /// How many.
        n_points: usize,
    },
    /// A lattice of irrational steps (Roberts' R sequence), shifted at random, less what is forbidden.
    QuasiRandom {
        /// How many.
        n_points: usize,
        /// The shift follows from it.
        seed: u64,
    },
    /// Drawn independently and uniformly from what the forbidden boxes leave: where they leave very little.
    Random {
        /// How many.
        n_points: usize,
        /// The draws follow from it.
        seed: u64,
    },
}

impl Sampling {
    /// Number of points.
    #[must_use]
    pub fn n_points(self) -> usize {
        match self {
            Self::All { n_points } | Self::QuasiRandom { n_points, .. } | Self::Random { n_points, .. } => n_points,
        }
    }
}

impl std::fmt::Display for Sampling {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::All { n_points } => write!(formatter, "all {n_points} points"),
            Self::QuasiRandom { n_points, seed } => write!(formatter, "{n_points} quasi-random points, seed {seed}"),
            Self::Random { n_points, seed } => write!(formatter, "{n_points} random points, seed {seed}"),
        }
    }
}

/// Points that cover a space evenly, coded, row by row, and how they were chosen.
///
/// A list is taken whole, a grid if it has at most `n_points` points; other boxes are sampled quasi-randomly,
/// less the points that are forbidden. An axis with levels takes each of them equally often.
///
/// # Errors
///
/// [`Error::Count`] for no points or more than ten million.
pub(super) fn sample(space: &Space, n_points: usize, seed: u64) -> Result<(Vec<f64>, Sampling), Error> {
    if !(1..=MOST_SAMPLES).contains(&n_points) {
        return Err(Error::Count { name: "sample points", found: n_points, least: 1, most: MOST_SAMPLES });
    }
    let shape = match space.shape() {
        Shape::List(list) => return Ok((list.coordinates.clone(), Sampling::All { n_points: list.n_points() })),
        Shape::Box(shape) => shape,
    };
    // Every combination is visited to leave out the forbidden ones, so the whole grid has to be small.
    if shape.is_discrete() && shape.n_combinations() <= n_points as f64 {
        let points = grid(shape);
        let n_points = points.len() / shape.axes.len();
        return Ok((points, Sampling::All { n_points }));
    }
    let mut generator = Pcg64::seed_from_u64(seed);
    let points = quasi_random(shape, n_points, &mut generator);
    if points.len() == n_points * shape.axes.len() {
        return Ok((points, Sampling::QuasiRandom { n_points, seed }));
    }
    let measure = Measure::of(shape);
    let points = (0..n_points).flat_map(|_| measure.sample(&mut generator)).collect();
    Ok((points, Sampling::Random { n_points, seed }))
}

/// The largest number of points that [`sample`] chooses.
pub(super) const MOST_SAMPLES: usize = 10_000_000;

/// Every allowed combination of levels, the last axis fastest.
fn grid(shape: &BoxShape) -> Vec<f64> {
    let lattice = Lattice::whole(shape);
    let points = (0..lattice.n_points()).map(|index| lattice.point(index));
    points.filter(|point| !shape.forbids(point)).flatten().collect()
}

/// Points of the sequence looked at for each allowed one that is wanted, at most.
const MOST_LOOKED_AT: usize = 50;

/// Allowed points among (n + 1) / g^j + shift, n = 0, 1, …, with g the root above 1 of g^(K+1) = g + 1: as many as
/// wanted, fewer only where forbidden boxes leave very little.
fn quasi_random(shape: &BoxShape, n_points: usize, generator: &mut impl RngExt) -> Vec<f64> {
    let k = shape.axes.len();
    let mut root = 2.0_f64;
    for _ in 0..60 {
        root = (1.0 + root).powf(1.0 / (k as f64 + 1.0));
    }
    let steps: Vec<f64> = (1..=k as u32).map(|j| 1.0 / power(root, j)).collect();
    let shifts: Vec<f64> = (0..k).map(|_| generator.random::<f64>()).collect();
    let coordinate = |n: usize, j: usize| {
        let fraction = ((n as f64 + 1.0) * steps[j] + shifts[j]).fract();
        match &shape.axes[j] {
            Axis::Continuous => 2.0 * fraction - 1.0,
            Axis::Levels(levels) => levels[((fraction * levels.len() as f64) as usize).min(levels.len() - 1)],
        }
    };
    let all = (0..n_points.saturating_mul(MOST_LOOKED_AT)).map(|n| (0..k).map(|j| coordinate(n, j)).collect());
    all.filter(|point: &Vec<f64>| !shape.forbids(point)).take(n_points).flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A thousand points of a box: all in it, and evenly over the halves of each axis.
    #[test]
    fn points_are_in_the_box_and_all_over_it() {
        for seed in 0..20 {
            let (points, sampling) = sample(&Space::cube(3).unwrap(), 1000, seed).unwrap();
            assert_eq!(sampling, Sampling::QuasiRandom { n_points: 1000, seed });
            assert!(points.iter().all(|x| x.abs() <= 1.0), "seed {seed}: one is outside");
            for axis in 0..3 {
                let below = points.iter().skip(axis).step_by(3).filter(|x| **x < 0.0).count();
                assert!((490..=510).contains(&below), "seed {seed}, axis {axis}: {below} of 1000 below the middle");
            }
        }
    }
}
