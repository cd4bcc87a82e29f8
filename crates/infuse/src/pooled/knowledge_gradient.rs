//! Which experiments teach most about the lowest response: a joint knowledge gradient, one pick after the other.

use design_space::Cell;
use rayon::prelude::*;
use statrs::distribution::{ContinuousCDF, Normal};
use surface::process::Joint;

use crate::Error;
use crate::pooled::admission::{Admission, Step};
use crate::pooled::economy::Economy;
use crate::pooled::held::FEASIBLE;
use crate::pooled::knowledge::Knowledge;
use crate::pooled::outcomes::{OUTCOMES, outcomes};
use crate::pooled::pool::Pool;

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
/// One in so many while there are fewer readings than for two batches: nothing has been seen yet of where the simulation misleads.
const DOUBTED_AT_FIRST: usize = 2;
const FEWEST: usize = 4;

/// Picks `count` cells of the pool, repeats allowed: each makes the expected minimum of the mean after the batch as low as a
/// single pick can, those before it and the pending experiments counted in. A cell where experiments may fail counts as much
/// less as they are likely to (Frazier et al. 2009; Wu and Frazier 2016 for batches). The last pick in six, and
/// the last half of the batch after the first, goes to where the sceptic sees least of what may still be best, so that a simulation
/// that misleads is found out sooner.
///
/// Where responses have to stay within bounds, a design is worth its mean as far as it is likely to keep to them, and the highest
/// mean of all otherwise; so a run is worth what it teaches of either (Ungredda and Branke 2024).
///
/// # Errors
///
/// [`Error::Surface`] if a constrained response cannot be evaluated.
pub(crate) fn pick(
    knowledge: &Knowledge<'_, '_>,
    pool: &Pool,
    pending: &[Cell],
    count: usize,
    scramble: u32,
    mut economy: Economy<'_>,
) -> Result<Picks, Error> {
    let noise = knowledge.reading_variance();
    let mut believed = Gradient::of(&knowledge.joint_of_each(&pool.places), pool, noise);
    believed.admissions = admissions(knowledge, pool, scramble)?;
    let mut doubted = knowledge.sceptic.as_ref().map(|sceptic| {
        let noise = sceptic.noise().powi(2) + sceptic.assembly_deviation().powi(2);
        Gradient { least_feasible: FEASIBLE, ..Gradient::of(&sceptic.joint_of_each(&pool.places), pool, noise) }
    });
    let pending: Vec<usize> =
        pending.iter().filter_map(|cell| pool.cells.iter().position(|candidate| candidate == cell)).collect();
    let before = spread(&believed.joint);
    let sites = knowledge.process.sites();
    let is_early = sites.places().n_places() + sites.n_repeats() < 2 * count;
    let share = if is_early { DOUBTED_AT_FIRST } else { DOUBTED };
    let n_doubted = if count < FEWEST { 0 } else { (count / share).max(1) };
    let mut cells = Vec::with_capacity(count);
    for step in 0..pending.len() + count {
        let normals = outcomes(step as u32, scramble);
        let row = match (pending.get(step), &doubted) {
            (Some(&row), _) => row,
            (None, Some(doubted)) if cells.len() >= count - n_doubted => doubted.clearest(&economy),
            (None, _) => believed.most_telling(&normals, step as u32, &economy),
        };
        if step >= pending.len() {
            cells.push(pool.cells[row]);
            economy.take(pool.cells[row]);
        }
        believed.measure(row, &normals, step as u32);
        if let Some(doubted) = &mut doubted {
            doubted.measure(row, &normals, step as u32);
        }
    }
    let remaining = if before > 0.0 { spread(&believed.joint) / before } else { 0.0 };
    Ok(Picks { cells, remaining })
}

/// What is known of each constrained response that was measured.
fn admissions(knowledge: &Knowledge<'_, '_>, pool: &Pool, scramble: u32) -> Result<Vec<Admission>, Error> {
    let joints = knowledge.constrained_joints(&pool.cells)?;
    let known = knowledge.held.iter().zip(joints).zip(0..);
    let known = known.filter_map(|((held, joint), number)| {
        Some(Admission::of(&held.constraint, Joint::of_mixture(&joint?), held.noise()?, number, scramble))
    });
    Ok(known.collect())
}

/// What one surface says of the pool, and how it may turn out after the picks so far.
struct Gradient<'a> {
    pool: &'a Pool,
    joint: Joint,
    noise: f64,
    futures: Vec<Vec<f64>>,
    /// Cells that are less likely to give a response are not picked.
    least_feasible: f64,
    /// The responses that have to stay within bounds.
    admissions: Vec<Admission>,
}

impl<'a> Gradient<'a> {
    fn of(of_each: &[Joint], pool: &'a Pool, noise: f64) -> Self {
        let joint = Joint::of_mixture(of_each);
        // A cell that will hardly ever be recommended is not the lowest.
        let mut now = joint.means().to_vec();
        let responding = &pool.chances.responding;
        if responding.iter().any(|&feasible| feasible >= HOPELESS) {
            let hopeless = now.iter_mut().zip(responding).filter(|(_, feasible)| **feasible < HOPELESS);
            hopeless.for_each(|(mean, _)| *mean = f64::INFINITY);
        }
        let futures = vec![now; OUTCOMES as usize];
        Self { pool, joint, noise, futures, least_feasible: 0.0, admissions: Vec::new() }
    }

    /// An experiment at this row, as it may turn out.
    fn measure(&mut self, row: usize, normals: &[f64], number: u32) {
        let effect = self.joint.effect(row, self.noise);
        for (future, z) in self.futures.iter_mut().zip(normals) {
            future.iter_mut().zip(&effect).for_each(|(value, effect)| *value += z * effect);
        }
        self.joint.measure(&effect);
        for admission in &mut self.admissions {
            let step = admission.step(row, number);
            admission.measure(&step);
        }
    }

    /// How much what is learnt at a row counts: as it is likely to give a response, and per cost.
    fn weight(&self, row: usize, economy: &Economy<'_>) -> f64 {
        let feasible = self.pool.chances.responding[row];
        if feasible < self.least_feasible { 0.0 } else { feasible * economy.weight(self.pool.cells[row]) }
    }

    /// The row after which least is uncertain where the best may still be: what an experiment takes from the variances of all rows,
    /// each counted as it is likely to be better than the best (targeted integrated error, Picheny et al. 2010).
    fn clearest(&self, economy: &Economy<'_>) -> usize {
        let n = self.pool.cells.len();
        let means = self.joint.means();
        let best = means.iter().copied().fold(f64::INFINITY, f64::min);
        let normal = Normal::standard();
        let better = |row: usize| {
            let sd = self.joint.variance(row).max(0.0).sqrt();
            let share = if sd > 0.0 { normal.cdf((best - means[row]) / sd) } else { 0.0 };
            share * self.pool.chances.within[row]
        };
        let shares: Vec<f64> = (0..n).map(better).collect();
        let learnt = |row: usize| {
            let effect = self.joint.effect(row, self.noise);
            self.weight(row, economy)
                * effect.iter().zip(&shares).map(|(effect, share)| effect * effect * share).sum::<f64>()
        };
        let learnt: Vec<f64> = (0..n).into_par_iter().map(learnt).collect();
        let allowed = |row: usize| economy.allows(self.pool.cells[row]);
        let order =
            |&a: &usize, &b: &usize| allowed(a).cmp(&allowed(b)).then(learnt[a].total_cmp(&learnt[b])).then(b.cmp(&a));
        (0..n).max_by(order).unwrap_or(0)
    }

    /// The row that lowers the expected minimum most; of equals the one that is least certain, so that nothing to gain still
    /// teaches.
    fn most_telling(&self, normals: &[f64], number: u32, economy: &Economy<'_>) -> usize {
        let n = self.pool.cells.len();
        let (still, stay): (Vec<f64>, Vec<Step>) =
            (vec![0.0; n], self.admissions.iter().map(Admission::stay).collect());
        let bounded = Bounded { reserve: self.reserve(), promising: self.promising(&stay) };
        let now = self.lowest_of_each(&still, normals, &stay, &bounded);
        let gain = |row: usize| {
            let effect = self.joint.effect(row, self.noise);
            let steps: Vec<Step> = self.admissions.iter().map(|admission| admission.step(row, number)).collect();
            let then = self.lowest_of_each(&effect, normals, &steps, &bounded);
            self.weight(row, economy) * (now - then).max(0.0)
        };
        let gains: Vec<f64> = (0..n).into_par_iter().map(gain).collect();
        let uncertain = |row: usize| self.weight(row, economy) * self.joint.variance(row);
        let allowed = |row: usize| economy.allows(self.pool.cells[row]);
        let order = |&a: &usize, &b: &usize| {
            let gain = || gains[a].total_cmp(&gains[b]);
            allowed(a).cmp(&allowed(b)).then_with(gain).then(uncertain(a).total_cmp(&uncertain(b))).then(b.cmp(&a))
        };
        (0..n).max_by(order).unwrap_or(0)
    }
}

impl Gradient<'_> {
    /// The highest mean: worth as much as a design that breaks a bound.
    fn reserve(&self) -> f64 {
        self.joint.means().iter().copied().fold(f64::NEG_INFINITY, f64::max)
    }

    /// What a design of this mean is worth where it has to keep to bounds.
    fn worth(&self, row: usize, mean: f64, steps: &[Step], outcome: usize, reserve: f64) -> f64 {
        let of_each = self.admissions.iter().zip(steps);
        let chance: f64 = of_each.map(|(admission, step)| admission.chance(row, step, outcome)).product();
        reserve + chance * (mean - reserve)
    }

    /// All rows, those first that are worth most in the first outcome as things stand; none where there is no bound.
    fn promising(&self, stay: &[Step]) -> Vec<usize> {
        if self.admissions.is_empty() {
            return Vec::new();
        }
        let reserve = self.reserve();
        let means = self.futures[0].iter().enumerate();
        let worths: Vec<f64> = means.map(|(row, mean)| self.worth(row, mean.min(reserve), stay, 0, reserve)).collect();
        let mut rows: Vec<usize> = (0..worths.len()).collect();
        rows.sort_by(|&a, &b| worths[a].total_cmp(&worths[b]));
        rows
    }

    /// What the best design is worth after a run of this effect, summed over the outcomes.
    fn lowest_of_each(&self, effect: &[f64], normals: &[f64], steps: &[Step], bounded: &Bounded) -> f64 {
        if self.admissions.is_empty() {
            return self.futures.iter().zip(normals).map(|(future, z)| lowest(future, effect, *z)).sum();
        }
        let of_outcome = |(outcome, (future, z)): (usize, (&Vec<f64>, &f64))| {
            let mut best = bounded.reserve;
            for &row in &bounded.promising {
                let mean = future[row] + z * effect[row];
                // Even a design that is sure to keep to its bounds is worth no less than its mean.
                if mean < best {
                    best = best.min(self.worth(row, mean, steps, outcome, bounded.reserve));
                }
            }
            best
        };
        self.futures.iter().zip(normals).enumerate().map(of_outcome).sum()
    }
}

/// What helps to find the best design that keeps to its bounds.
struct Bounded {
    reserve: f64,
    /// The rows in the order in which they are looked at: after a good one most need not be weighed.
    promising: Vec<usize>,
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
