//! Which experiments teach most about the lowest response: a joint knowledge gradient, one pick after the other.

use design_space::Cell;
use rayon::prelude::*;
use statrs::distribution::{ContinuousCDF, Normal};
use surface::process::Joint;

use crate::pooled::knowledge::Knowledge;
use crate::pooled::pool::{FEASIBLE, Pool};

/// Common random numbers: how the surface may turn out after the batch.
const OUTCOMES: u32 = 48;

/// Below this probability of a response a cell is not worth learning about.
const HOPELESS: f64 = 0.25;

/// Cells for the next batch, and how sure it will make us.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Picks {
    pub(crate) cells: Vec<Cell>,
    /// Root of the mean variance that the pool has afterwards, as a share of that before.
    pub(crate) remaining: f64,
}

/// One pick in so many, and at least one of a batch of so many, is for the one who does not believe the simulation. With one in eight
/// wells that the simulation lacks are found later, with one in four more of the best is missed elsewhere.
const DOUBTED: usize = 6;
const FEWEST: usize = 4;

/// Picks `count` cells of the pool, repeats allowed: each makes the expected minimum of the mean after the batch as low as a
/// single pick can, those before it and the pending experiments counted in. A cell where experiments may fail counts as much
/// less as they are likely to (Frazier et al. 2009; Wu and Frazier 2016 for batches). The last pick in six goes to
/// where the sceptic sees least of what may still be best, so that a simulation that misleads is found out sooner.
pub(crate) fn pick(knowledge: &Knowledge<'_, '_>, pool: &Pool, pending: &[Cell], count: usize, scramble: u32) -> Picks {
    let noise = knowledge.process.noise().powi(2);
    let mut believed = Gradient::of(&knowledge.joint_of_each(&pool.places), pool, noise);
    let mut doubted = knowledge.sceptic.as_ref().map(|sceptic| {
        let noise = sceptic.noise().powi(2);
        Gradient { least_feasible: FEASIBLE, ..Gradient::of(&sceptic.joint_of_each(&pool.places), pool, noise) }
    });
    let pending: Vec<usize> =
        pending.iter().filter_map(|cell| pool.cells.iter().position(|candidate| candidate == cell)).collect();
    let before = spread(&believed.joint);
    let n_doubted = if count < FEWEST { 0 } else { (count / DOUBTED).max(1) };
    let mut cells = Vec::with_capacity(count);
    for step in 0..pending.len() + count {
        let normals = outcomes(step as u32, scramble);
        let row = match (pending.get(step), &doubted) {
            (Some(&row), _) => row,
            (None, Some(doubted)) if cells.len() >= count - n_doubted => doubted.clearest(),
            (None, _) => believed.most_telling(&normals),
        };
        if step >= pending.len() {
            cells.push(pool.cells[row]);
        }
        believed.measure(row, &normals);
        if let Some(doubted) = &mut doubted {
            doubted.measure(row, &normals);
        }
    }
    let remaining = if before > 0.0 { spread(&believed.joint) / before } else { 0.0 };
    Picks { cells, remaining }
}

/// What one surface says of the pool, and how it may turn out after the picks so far.
struct Gradient<'a> {
    pool: &'a Pool,
    joint: Joint,
    noise: f64,
    futures: Vec<Vec<f64>>,
    /// Cells that are less likely to give a response are not picked.
    least_feasible: f64,
}

impl<'a> Gradient<'a> {
    fn of(of_each: &[Joint], pool: &'a Pool, noise: f64) -> Self {
        let joint = Joint::of_mixture(of_each);
        // A cell that will hardly ever be recommended is not the lowest.
        let mut now = joint.means().to_vec();
        if pool.feasible.iter().any(|&feasible| feasible >= HOPELESS) {
            let hopeless = now.iter_mut().zip(&pool.feasible).filter(|(_, feasible)| **feasible < HOPELESS);
            hopeless.for_each(|(mean, _)| *mean = f64::INFINITY);
        }
        Self { pool, joint, noise, futures: vec![now; OUTCOMES as usize], least_feasible: 0.0 }
    }

    /// An experiment at this row, as it may turn out.
    fn measure(&mut self, row: usize, normals: &[f64]) {
        let effect = self.joint.effect(row, self.noise);
        for (future, z) in self.futures.iter_mut().zip(normals) {
            future.iter_mut().zip(&effect).for_each(|(value, effect)| *value += z * effect);
        }
        self.joint.measure(&effect);
    }

    fn weight(&self, row: usize) -> f64 {
        let feasible = self.pool.feasible[row];
        if feasible < self.least_feasible { 0.0 } else { feasible }
    }

    /// The row after which least is uncertain where the best may still be: what an experiment takes from the variances of all rows,
    /// each counted as it is likely to be better than the best (targeted integrated error, Picheny et al. 2010).
    fn clearest(&self) -> usize {
        let n = self.pool.cells.len();
        let means = self.joint.means();
        let best = means.iter().copied().fold(f64::INFINITY, f64::min);
        let normal = Normal::standard();
        let better = |row: usize| {
            let sd = self.joint.variance(row).max(0.0).sqrt();
            if sd > 0.0 { normal.cdf((best - means[row]) / sd) } else { 0.0 }
        };
        let shares: Vec<f64> = (0..n).map(better).collect();
        let learnt = |row: usize| {
            let effect = self.joint.effect(row, self.noise);
            self.weight(row) * effect.iter().zip(&shares).map(|(effect, share)| effect * effect * share).sum::<f64>()
        };
        let learnt: Vec<f64> = (0..n).into_par_iter().map(learnt).collect();
        (0..n).max_by(|&a, &b| learnt[a].total_cmp(&learnt[b]).then(b.cmp(&a))).unwrap_or(0)
    }

    /// The row that lowers the expected minimum most; of equals the one that is least certain, so that nothing to gain still
    /// teaches.
    fn most_telling(&self, normals: &[f64]) -> usize {
        let n = self.pool.cells.len();
        let least = |future: &Vec<f64>| future.iter().copied().fold(f64::INFINITY, f64::min);
        let now: f64 = self.futures.iter().map(least).sum();
        let gain = |row: usize| {
            let effect = self.joint.effect(row, self.noise);
            let then: f64 = self.futures.iter().zip(normals).map(|(future, z)| lowest(future, &effect, *z)).sum();
            self.weight(row) * (now - then).max(0.0)
        };
        let gains: Vec<f64> = (0..n).into_par_iter().map(gain).collect();
        let uncertain = |row: usize| self.weight(row) * self.joint.variance(row);
        let order = |&a: &usize, &b: &usize| {
            gains[a].total_cmp(&gains[b]).then(uncertain(a).total_cmp(&uncertain(b))).then(b.cmp(&a))
        };
        (0..n).max_by(order).unwrap_or(0)
    }
}

/// Root of the mean variance.
fn spread(joint: &Joint) -> f64 {
    let n = joint.n_places();
    ((0..n).map(|row| joint.variance(row).max(0.0)).sum::<f64>() / n as f64).sqrt()
}

/// min_j (m_j + z b_j)
fn lowest(means: &[f64], effect: &[f64], z: f64) -> f64 {
    let mut lanes = [f64::INFINITY; 16];
    let (blocks, rest) = means.as_chunks::<16>();
    let (effects, rest_of_effects) = effect.as_chunks::<16>();
    for (block, effects) in blocks.iter().zip(effects) {
        for lane in 0..16 {
            let value = block[lane] + z * effects[lane];
            lanes[lane] = if value < lanes[lane] { value } else { lanes[lane] };
        }
    }
    let rest = rest.iter().zip(rest_of_effects).map(|(mean, effect)| mean + z * effect);
    lanes.into_iter().chain(rest).fold(f64::INFINITY, f64::min)
}

/// Standard normals, evenly spread: a scrambled Sobol sequence, one dimension for each pick.
fn outcomes(dimension: u32, scramble: u32) -> Vec<f64> {
    let normal = Normal::standard();
    // Beyond the dimensions that the sequence has, they are used again with another scramble.
    let (round, dimension) = (dimension / sobol_burley::NUM_DIMENSIONS, dimension % sobol_burley::NUM_DIMENSIONS);
    let sample = |index| f64::from(sobol_burley::sample(index, dimension, scramble.wrapping_add(round)));
    (0..OUTCOMES).map(|index| normal.inverse_cdf(sample(index).clamp(1e-7, 1.0 - 1e-7))).collect()
}
