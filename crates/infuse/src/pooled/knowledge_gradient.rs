//! Which experiments teach most about the lowest response: a joint knowledge gradient, one pick after the other.

use design_space::Cell;
use rayon::prelude::*;
use statrs::distribution::{ContinuousCDF, Normal};
use surface::process::Joint;

use crate::pooled::knowledge::Knowledge;
use crate::pooled::pool::Pool;

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

/// Picks `count` cells of the pool, repeats allowed: each makes the expected minimum of the mean after the batch as low as a
/// single pick can, those before it and the pending experiments counted in. A cell where experiments may fail counts as much
/// less as they are likely to (Frazier et al. 2009; Wu and Frazier 2016 for batches).
pub(crate) fn pick(knowledge: &Knowledge<'_, '_>, pool: &Pool, pending: &[Cell], count: usize, scramble: u32) -> Picks {
    let mut joint = Joint::of_mixture(&knowledge.joint_of_each(&pool.places));
    let n = joint.n_places();
    let noise = knowledge.process.noise().powi(2);
    // A cell that will hardly ever be recommended is not the lowest.
    let mut futures: Vec<Vec<f64>> = vec![joint.means().to_vec(); OUTCOMES as usize];
    if (0..n).any(|row| pool.feasible[row] >= HOPELESS) {
        for row in (0..n).filter(|&row| pool.feasible[row] < HOPELESS) {
            futures.iter_mut().for_each(|future| future[row] = f64::INFINITY);
        }
    }
    let pending: Vec<usize> =
        pending.iter().filter_map(|cell| pool.cells.iter().position(|candidate| candidate == cell)).collect();
    let before = spread(&joint);
    let mut cells = Vec::with_capacity(count);
    for step in 0..pending.len() + count {
        let normals = outcomes(step as u32, scramble);
        let row = match pending.get(step) {
            Some(&row) => row,
            None => most_telling(pool, &futures, &joint, noise, &normals),
        };
        if step >= pending.len() {
            cells.push(pool.cells[row]);
        }
        let effect = joint.effect(row, noise);
        for (future, z) in futures.iter_mut().zip(&normals) {
            future.iter_mut().zip(&effect).for_each(|(value, effect)| *value += z * effect);
        }
        joint.measure(&effect);
    }
    let remaining = if before > 0.0 { spread(&joint) / before } else { 0.0 };
    Picks { cells, remaining }
}

/// The row that lowers the expected minimum most; of equals the one that is least certain, so that nothing to gain still teaches.
fn most_telling(pool: &Pool, futures: &[Vec<f64>], joint: &Joint, noise: f64, normals: &[f64]) -> usize {
    let n = pool.cells.len();
    let least = |future: &Vec<f64>| future.iter().copied().fold(f64::INFINITY, f64::min);
    let now: f64 = futures.iter().map(least).sum();
    let gain = |row: usize| {
        let effect = joint.effect(row, noise);
        let then: f64 = futures.iter().zip(normals).map(|(future, z)| lowest(future, &effect, *z)).sum();
        pool.feasible[row] * (now - then).max(0.0)
    };
    let gains: Vec<f64> = (0..n).into_par_iter().map(gain).collect();
    let uncertain = |row: usize| pool.feasible[row] * joint.variance(row);
    let order = |&a: &usize, &b: &usize| {
        gains[a].total_cmp(&gains[b]).then(uncertain(a).total_cmp(&uncertain(b))).then(b.cmp(&a))
    };
    (0..n).max_by(order).unwrap_or(0)
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
