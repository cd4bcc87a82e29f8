//! The design with the lowest mean, of those that may be recommended.

use std::collections::BTreeMap;

use design_space::Cell;

use crate::Error;
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

/// How a cell stands: whether it does not suffice, how unlikely it then is to, whether its mean is not to be believed, and that; the lower
/// the better.
#[derive(Debug, Clone, Copy)]
struct Rank(bool, f64, bool, f64);

impl Rank {
    const LAST: Self = Self(true, f64::INFINITY, true, f64::INFINITY);

    fn of(chances: &Chances, row: usize, mean: f64, is_incredible: bool) -> Self {
        let (fails, unlikely, mean) = chances.rank(row, mean);
        Self(fails, unlikely, is_incredible, mean)
    }

    fn total_cmp(&self, other: &Self) -> std::cmp::Ordering {
        let suffices = self.0.cmp(&other.0).then(self.1.total_cmp(&other.1));
        suffices.then(self.2.cmp(&other.2)).then(self.3.total_cmp(&other.3))
    }
}

/// With fewer readings what they differ by says nothing.
const ENOUGH: usize = 3;

/// Below this no mean is believed where nothing was run: it would be farther below the lowest reading than that is below the highest.
fn least_credible(readings: &[Reading]) -> f64 {
    let range = Reading::range(readings);
    let least = readings.iter().map(|reading| reading.response).fold(f64::INFINITY, f64::min);
    if readings.len() < ENOUGH || range <= 0.0 { f64::NEG_INFINITY } else { least - range }
}

/// The cell of the lowest mean, of those where it is to be believed. By descent along the axes from the lowest of the pool, with steps that
/// halve; while there are too few readings to promise anything, and no simulation, of the measured ones.
pub(crate) fn lowest_mean(
    knowledge: &mut Knowledge<'_, '_>,
    pool: &Pool,
    readings: &[Reading],
    seed: u64,
    batch: usize,
) -> Result<Cell, Error> {
    let designs = knowledge.designs;
    let (least, run) = (least_credible(readings), knowledge.measured.clone());
    let is_incredible = |cell: Cell, mean: f64| mean < least && run.binary_search(&cell).is_err();
    let is_early = readings.len() < designs.n_to_promise() && !knowledge.is_simulated();
    let measured = || knowledge.measured.iter().copied().filter(|&cell| is_early && designs.allows(cell));
    let few: Vec<Cell> = measured().collect();
    if designs.n_cells() <= FULL || !few.is_empty() {
        let cells: Vec<Cell> = if few.is_empty() { designs.cells().collect() } else { few };
        let places = knowledge.places(&cells)?;
        let means = knowledge.process.means(&places);
        let chances = knowledge.chances(&cells, &places)?;
        let rank = |row: usize| Rank::of(&chances, row, means[row], is_incredible(cells[row], means[row]));
        let best = (0..cells.len()).min_by(|&a, &b| rank(a).total_cmp(&rank(b)).then(a.cmp(&b)));
        return Ok(cells[best.unwrap_or(0)]);
    }
    let rank = |row: usize| {
        let mean = pool.marginals.means[row];
        Rank::of(&pool.chances, row, mean, is_incredible(pool.cells[row], mean))
    };
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
            let ranks = knowledge.process.means(&places).into_iter().enumerate();
            let ranks = ranks.map(|(row, mean)| Rank::of(&chances, row, mean, is_incredible(new[row], mean)));
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

#[cfg(test)]
mod tests {
    use super::*;

    fn readings(responses: &[f64]) -> Vec<Reading> {
        let one = |(number, &response): (usize, &f64)| {
            let (coded, cell) = (vec![0.1 * number as f64], Cell::new(number as u64));
            Reading { coded, cell, response, number, assembly: None }
        };
        responses.iter().enumerate().map(one).collect()
    }

    #[test]
    fn what_is_far_below_all_that_was_measured_is_not_believed() {
        assert_eq!(least_credible(&readings(&[3.0, 7.0, 4.5])), -1.0);
        for too_few in [&[3.0, 7.0][..], &[5.0, 5.0, 5.0]] {
            assert_eq!(least_credible(&readings(too_few)), f64::NEG_INFINITY, "{too_few:?} tell no range");
        }
        // A design that keeps to its bounds comes first, whatever is said of it; then one that is to be believed.
        let ranks = [
            Rank(false, 0.0, false, 2.0),
            Rank(false, 0.0, false, 3.0),
            Rank(false, 0.0, true, -5.0),
            Rank(true, 0.2, false, -1.0),
        ];
        assert!(ranks.windows(2).all(|two| two[0].total_cmp(&two[1]).is_lt()));
    }
}
