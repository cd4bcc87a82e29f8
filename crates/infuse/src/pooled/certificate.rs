//! How much better than the recommended design another may be.

use design_space::Cell;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use surface::process::Joint;

use crate::Error;
use crate::pooled::knowledge::Knowledge;
use crate::pooled::pool::Pool;
use crate::pooled::streams::{Purpose, stream};

/// The bound is this quantile of what the surface says may be gained, times this allowance.
const SURE: f64 = 0.99;
const ALLOWANCE: f64 = 1.5;
/// Cells on which the response is drawn.
const CELLS: usize = 256;
const DRAWS: usize = 640;
/// Draws that do not believe the simulation.
const DOUBTED: usize = 80;

/// "With this probability no design is better than the recommended one by more than `bound`."
///
/// It rests on the measurements, on the simulation as far as these agree with it, and on the response being a polynomial, a
/// corrected simulation or as smooth as the priors of the surface say. What no measurement and no simulation shows, as a well
/// between all of them, it allows for by widening what the surface says of itself.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Certificate {
    /// The probability.
    pub probability: f64,
    /// In the unit of the response, at least 0.
    pub bound: f64,
    /// The same as the surface has it, without that allowance.
    pub quantile: f64,
}

/// What may be gained over the recommended design, drawn from all that is possible.
#[derive(Debug, Clone)]
pub(crate) struct Draws {
    /// Ascending.
    gains: Vec<f64>,
}

impl Draws {
    pub(crate) fn of(
        knowledge: &mut Knowledge<'_, '_>,
        pool: &Pool,
        recommended: Cell,
        seed: u64,
        batch: usize,
    ) -> Result<Self, Error> {
        let mut order = pool.by_lower_bound(2.0);
        order.truncate(CELLS);
        let mut doubted = match &knowledge.sceptic {
            Some(sceptic) => pool.by_lower_bound_of(&sceptic.marginals(&pool.places), 2.0),
            None => Vec::new(),
        };
        doubted.truncate(CELLS / 2);
        order.truncate(CELLS - doubted.len());
        let mut cells: Vec<Cell> = order.iter().chain(&doubted).map(|&row| pool.cells[row]).collect();
        cells.sort_unstable();
        cells.dedup();
        cells.retain(|&cell| cell != recommended);
        cells.insert(0, recommended);
        let places = knowledge.places(&cells)?;
        let of_each = knowledge.joint_of_each(&places);
        let doubts = knowledge.sceptic.as_ref().map(|sceptic| sceptic.joint_of_each(&places)).unwrap_or_default();
        let n_doubted = if doubts.is_empty() { 0 } else { DOUBTED };
        let shares = |joints: Vec<Joint>, draws: usize| {
            let per_particle = if joints.is_empty() { 0 } else { draws.div_ceil(joints.len()) };
            joints.into_iter().map(move |joint| (joint, per_particle))
        };
        let tasks: Vec<_> = shares(of_each, DRAWS - n_doubted).chain(shares(doubts, n_doubted)).enumerate().collect();
        let mut gains: Vec<f64> = tasks
            .into_par_iter()
            .flat_map_iter(|(particle, (joint, per_particle))| {
                let mut rng = stream(seed, Purpose::Certificate, batch);
                rng.set_word_pos((particle as u128) << 40);
                joint.draws(per_particle, &mut rng).into_iter().map(|draw| gain(&draw))
            })
            .collect();
        gains.sort_by(f64::total_cmp);
        Ok(Self { gains })
    }

    pub(crate) fn certificate(&self, probability: f64) -> Certificate {
        let quantile = self.quantile(probability);
        Certificate { probability, bound: ALLOWANCE * self.quantile(SURE), quantile }
    }

    fn quantile(&self, level: f64) -> f64 {
        let count = self.gains.len();
        self.gains[((count as f64 * level).ceil() as usize).clamp(1, count) - 1]
    }
}

/// What the best of the cells is better by than the first.
fn gain(draw: &[f64]) -> f64 {
    draw[0] - draw.iter().copied().fold(f64::INFINITY, f64::min)
}
