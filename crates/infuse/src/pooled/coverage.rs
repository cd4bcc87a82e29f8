//! How much of the box the runs have seen: what lies far from all of them is unknown to them, however many there are.

use design_space::Cell;
use rand::RngExt;
use rayon::prelude::*;

use crate::Error;
use crate::pooled::designs::Designs;
use crate::pooled::evenly::spread;
use crate::pooled::pool::Pool;
use crate::pooled::streams::{Purpose, stream};

/// Sequences of evenly spread runs that the runs are compared with.
const SEQUENCES: usize = 4;
/// Designs by which the box is judged, at most.
const DESIGNS: usize = 1000;

/// Designs that stand for the box, each with its distance to the nearest run.
#[derive(Debug, Clone)]
pub(crate) struct Coverage {
    designs: Vec<Vec<f64>>,
    distances: Vec<f64>,
}

impl Coverage {
    /// Of runs at these coded settings.
    pub(crate) fn of(designs: &Designs, pool: &Pool, runs: &[&[f64]]) -> Result<Self, Error> {
        let cells = if pool.random.is_empty() { &pool.cells } else { &pool.random };
        let mut cells = cells.clone();
        cells.sort_unstable();
        cells.dedup();
        let step = cells.len().div_ceil(DESIGNS).max(1);
        let coded =
            cells.into_iter().step_by(step).map(|cell| designs.coded_of(cell)).collect::<Result<Vec<_>, _>>()?;
        let mut coverage = Self { distances: vec![f64::INFINITY; coded.len()], designs: coded };
        runs.iter().for_each(|run| coverage.add(run));
        Ok(coverage)
    }

    /// One more run.
    pub(crate) fn add(&mut self, run: &[f64]) {
        for (distance, design) in self.distances.iter_mut().zip(&self.designs) {
            *distance = distance.min(apart(run, design));
        }
    }

    /// By how much a run there would bring the designs nearer to a run, summed over them.
    pub(crate) fn gain(&self, run: &[f64]) -> f64 {
        self.distances
            .iter()
            .zip(&self.designs)
            .map(|(distance, design)| (distance - apart(run, design)).max(0.0))
            .sum()
    }

    /// The mean distance of a design from the nearest run.
    fn distance(&self) -> f64 {
        self.distances.iter().sum::<f64>() / self.distances.len() as f64
    }

    /// As many evenly spread runs (a scrambled Sobol sequence) leave the designs as far from the nearest one; `most` if more do.
    pub(crate) fn even_runs(&self, designs: &Designs, most: usize, seed: u64) -> Result<usize, Error> {
        let of_one = |sequence: usize| {
            let mut rng = stream(seed, Purpose::Coverage, sequence);
            let mut even = Self { designs: self.designs.clone(), distances: vec![f64::INFINITY; self.designs.len()] };
            let cells: Vec<Cell> = spread(designs, most, rng.random());
            let far = |cell: Cell| {
                even.add(&designs.coded_of(cell)?);
                Ok(even.distance())
            };
            cells.into_iter().map(far).collect::<Result<Vec<f64>, Error>>()
        };
        let of_each = (0..SEQUENCES).into_par_iter().map(of_one).collect::<Result<Vec<_>, _>>()?;
        let mean = |n: usize| of_each.iter().map(|distances| distances[n - 1]).sum::<f64>() / SEQUENCES as f64;
        let here = self.distance();
        Ok((1..most).find(|&n| mean(n) <= here).unwrap_or(most))
    }
}

/// The share of all designs of which so many runs at random places would have met one with this probability, and no smaller one:
/// 1 − (1 − p)^(1/n), whatever the response looks like.
pub(crate) fn unseen(n_runs: usize, probability: f64) -> f64 {
    1.0 - (1.0 - probability).powf(1.0 / n_runs.max(1) as f64)
}

/// The distance of two places, coded.
pub(crate) fn apart(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pooled::scene::Scene;

    /// Levels of two numbers that are their own pool, and runs at some of them.
    fn coverage(scene: &mut Scene, runs: &[Vec<f64>]) -> Coverage {
        for at in 0..4 {
            scene.read(&[at, at], at as f64);
        }
        let designs = scene.designs.clone();
        let pool = Pool::gather(&mut scene.knowledge(None), 1, 0).unwrap();
        Coverage::of(&designs, &pool, &runs.iter().map(Vec::as_slice).collect::<Vec<_>>()).unwrap()
    }

    /// On a line of nine designs at steps of a quarter: by hand.
    #[test]
    fn a_run_gains_what_it_brings_the_designs_nearer() {
        let mut scene = Scene::new(&[9]);
        for at in 0..4 {
            scene.read(&[at], at as f64);
        }
        let designs = scene.designs.clone();
        let pool = Pool::gather(&mut scene.knowledge(None), 1, 0).unwrap();
        let mut of = Coverage::of(&designs, &pool, &[&[-1.0]]).unwrap();
        assert!((of.distance() - 1.0).abs() < 1e-12, "0 to 2");
        // From 2, 1.75, 1.5, 1.25 to 0, 0.25, 0.5, 0.75; the middle is as far from either.
        assert!((of.gain(&[1.0]) - (2.0 + 1.5 + 1.0 + 0.5)).abs() < 1e-12);
        // The middle gains more: nothing up to a quarter of the way, 0.5 there, and 1 for each design from it on.
        let middle = of.gain(&[0.0]);
        assert!((middle - (0.5 + 5.0)).abs() < 1e-12, "{middle}");
        let before = of.distance();
        of.add(&[0.0]);
        assert!((9.0 * (before - of.distance()) - middle).abs() < 1e-12, "as was said");
    }

    /// Of the best of n designs drawn at random, out of all, 90 in 100 are among so many of the best.
    #[test]
    fn so_many_may_be_better_than_the_best_of_random_runs() {
        use rand::SeedableRng as _;
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(5);
        for n in [1, 3, 12, 60] {
            let share = unseen(n, 0.9);
            // Designs in their order, from the best on, as a number from 0 to 1.
            let mut best = || (0..n).map(|_| rng.random::<f64>()).fold(1.0, f64::min);
            let within = (0..20_000).filter(|_| best() <= share).count() as f64 / 20_000.0;
            assert!((within - 0.9).abs() < 0.01, "{n} runs: {within}");
        }
    }

    /// Of runs of the same sequence as many; of as many at one place hardly more than one; never fewer for one more.
    #[test]
    fn even_runs_count_and_crowded_ones_do_not() {
        let mut scene = Scene::new(&[20, 20]);
        let designs = scene.designs.clone();
        let coded = |cells: &[Cell]| cells.iter().map(|&cell| designs.coded_of(cell).unwrap()).collect::<Vec<_>>();
        let even = coded(&spread(&designs, 24, 99));
        let of_even = coverage(&mut scene, &even).even_runs(&designs, 24, 1).unwrap();
        assert!((18..=24).contains(&of_even), "{of_even}");
        let crowded: Vec<Vec<f64>> = (0..24).map(|k| vec![0.5 + 0.01 * f64::from(k % 5), 0.5]).collect();
        let of_crowded = coverage(&mut Scene::new(&[20, 20]), &crowded).even_runs(&designs, 24, 1).unwrap();
        assert!(of_crowded <= 2, "{of_crowded}");
        let mut last = 0;
        for n in 1..=24 {
            let now = coverage(&mut Scene::new(&[20, 20]), &even[..n]).even_runs(&designs, n, 1).unwrap();
            assert!(now >= last && now <= n, "{now} after {last}");
            last = now;
        }
    }
}
