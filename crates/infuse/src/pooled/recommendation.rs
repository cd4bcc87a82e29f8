//! The design with the lowest mean, of those that may be recommended.

use std::collections::{BTreeMap, BTreeSet};

use design_space::Cell;

use crate::Error;
use crate::pooled::bands::NINE_IN_TEN;
use crate::pooled::held::Chances;
use crate::pooled::knowledge::Knowledge;
use crate::pooled::measurements::Reading;
use crate::pooled::pool::Pool;
use crate::pooled::streams::{Purpose, stream};

/// Grids of up to this many cells are searched in full.
const FULL: u64 = 5_000;
const STARTS: usize = 5;
/// Cells looked at around each start, where there is more to keep to than the bounds.
const AROUND: usize = 40;

/// How a cell stands: whether it does not suffice, how unlikely it then is to, and its mean; the lower the better.
#[derive(Debug, Clone, Copy)]
struct Rank(bool, f64, f64);

impl Rank {
    const LAST: Self = Self(true, f64::INFINITY, f64::INFINITY);

    fn of(chances: &Chances, row: usize, mean: f64) -> Self {
        let (fails, unlikely, mean) = chances.rank(row, mean);
        Self(fails, unlikely, mean)
    }

    fn total_cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.cmp(&other.0).then(self.1.total_cmp(&other.1)).then(self.2.total_cmp(&other.2))
    }
}

/// The cell of the lowest mean. By descent along the axes from the lowest of the pool, with steps that halve; while there are too few
/// readings to promise anything, and no simulation, of the measured ones.
pub(crate) fn lowest_mean(
    knowledge: &mut Knowledge<'_, '_>,
    pool: &Pool,
    n_readings: usize,
    seed: u64,
    batch: usize,
) -> Result<Cell, Error> {
    let designs = knowledge.designs;
    let is_early = n_readings < designs.n_to_promise() && !knowledge.is_simulated();
    let measured = || knowledge.measured.iter().copied().filter(|&cell| is_early && designs.allows(cell));
    let few: Vec<Cell> = measured().collect();
    if designs.n_cells() <= FULL || !few.is_empty() {
        let cells: Vec<Cell> = if few.is_empty() { designs.cells().collect() } else { few };
        let places = knowledge.places(&cells)?;
        let means = knowledge.process.means(&places)?;
        let chances = knowledge.chances(&cells, &places)?;
        let rank = |row: usize| Rank::of(&chances, row, means[row]);
        let best = (0..cells.len()).min_by(|&a, &b| rank(a).total_cmp(&rank(b)).then(a.cmp(&b)));
        return Ok(cells[best.unwrap_or(0)]);
    }
    let rank = |row: usize| Rank::of(&pool.chances, row, pool.marginals.means[row]);
    let mut known: BTreeMap<Cell, Rank> = pool.cells.iter().copied().zip((0..pool.cells.len()).map(rank)).collect();
    let mut fronts: Vec<Cell> = pool.first(&pool.by_lower_bound(0.0), STARTS).cells;
    let longest = designs.combinations().counts().iter().max().copied().unwrap_or(2);
    let mut share = 0.125;
    let is_confined = designs.is_confined() || !knowledge.held.is_empty();
    let mut rng = stream(seed, Purpose::Recommendation, batch);
    loop {
        loop {
            fronts.sort_unstable();
            fronts.dedup();
            let mut stars: Vec<Vec<Cell>> = fronts.iter().map(|&front| designs.star(front, share)).collect();
            if is_confined {
                // Along a bound that lies across the axes no single step leads on.
                for (star, &front) in stars.iter_mut().zip(&fronts) {
                    star.extend((0..AROUND).map(|_| designs.near(front, share, &mut rng)));
                }
            }
            let mut new: Vec<Cell> = stars.iter().flatten().copied().filter(|cell| !known.contains_key(cell)).collect();
            new.sort_unstable();
            new.dedup();
            let places = knowledge.places(&new)?;
            let chances = knowledge.chances(&new, &places)?;
            let ranks = knowledge.process.means(&places)?.into_iter().enumerate();
            let ranks = ranks.map(|(row, mean)| Rank::of(&chances, row, mean));
            known.extend(new.iter().copied().zip(ranks));
            let mut moved = false;
            for (front, star) in fronts.iter_mut().zip(&stars) {
                let rank = |cell: &Cell| known.get(cell).copied().unwrap_or(Rank::LAST);
                let best = star.iter().copied().min_by(|a, b| rank(a).total_cmp(&rank(b)).then(a.cmp(b)));
                if let Some(best) = best.filter(|best| rank(best).total_cmp(&rank(front)).is_lt()) {
                    (*front, moved) = (best, true);
                }
            }
            if !moved {
                break;
            }
        }
        if share * (longest - 1) as f64 <= 1.0 {
            break;
        }
        share /= 2.0;
    }
    let best = known.iter().min_by(|a, b| a.1.total_cmp(b.1).then(a.0.cmp(b.0)));
    Ok(best.map_or(Cell::new(0), |(&cell, _)| cell))
}

/// The cell of the lowest mean, unless that is less than a response can be, so that the surface is wrong there: then one of those that
/// were run and may be recommended. Of these the one of the lowest readings, of all that may be as low as the least by their bands,
/// or else the one whose band begins lowest.
pub(crate) fn possible(
    knowledge: &mut Knowledge<'_, '_>,
    lowest: Cell,
    least: f64,
    readings: &[Reading],
    eligible: &BTreeSet<Cell>,
) -> Result<Cell, Error> {
    let cells: Vec<Cell> = std::iter::once(lowest).chain(eligible.iter().copied()).collect();
    let places = knowledge.places(&cells)?;
    let marginals = knowledge.marginals(&places)?;
    if marginals.means[0] >= least {
        return Ok(lowest);
    }
    let low_end = |row: usize| marginals.means[row] - NINE_IN_TEN * marginals.variances[row].sqrt();
    let chances = knowledge.chances(&cells, &places)?;
    let read = |cell: Cell| {
        let here = readings.iter().filter(|reading| reading.cell == cell).map(|reading| reading.response);
        let n = here.clone().count().max(1) as f64;
        here.sum::<f64>() / n
    };
    let rank = |row: usize| (Rank::of(&chances, row, low_end(row).max(least)), read(cells[row]));
    let order = |a: &(Rank, f64), b: &(Rank, f64)| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1));
    let best = (1..cells.len()).min_by(|&a, &b| order(&rank(a), &rank(b)).then(cells[a].cmp(&cells[b])));
    Ok(best.map_or(lowest, |row| cells[row]))
}
