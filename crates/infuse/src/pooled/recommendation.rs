//! The feasible design with the lowest mean.

use std::collections::BTreeMap;

use design_space::Cell;

use crate::Error;
use crate::pooled::knowledge::Knowledge;
use crate::pooled::pool::{FEASIBLE, Pool};

/// Grids of up to this many cells are searched in full.
const FULL: u64 = 5_000;
const STARTS: usize = 5;

/// The cell of the lowest mean, and that mean. By descent along the axes from the lowest of the pool, with steps that halve.
pub(crate) fn lowest_mean(knowledge: &mut Knowledge<'_, '_>, pool: &Pool) -> Result<Cell, Error> {
    let designs = knowledge.designs;
    if designs.n_cells() <= FULL {
        let cells: Vec<Cell> = designs.grid().cells().collect();
        let places = knowledge.places(&cells)?;
        let means = knowledge.process.means(&places);
        let feasible = knowledge.feasible(&cells, &places);
        let value = |row: usize| if feasible[row] >= FEASIBLE { means[row] } else { f64::INFINITY };
        let best = (0..cells.len()).min_by(|&a, &b| value(a).total_cmp(&value(b)).then(a.cmp(&b)));
        return Ok(cells[best.unwrap_or(0)]);
    }
    let value = |row: usize| if pool.may_be_best(row) { pool.marginals.means[row] } else { f64::INFINITY };
    let mut known: BTreeMap<Cell, f64> = pool.cells.iter().copied().zip((0..pool.cells.len()).map(value)).collect();
    let mut fronts: Vec<Cell> = pool.first(&pool.by_lower_bound(0.0), STARTS).cells;
    let longest = designs.combinations().counts().iter().max().copied().unwrap_or(2);
    let mut share = 0.125;
    loop {
        loop {
            fronts.sort_unstable();
            fronts.dedup();
            let stars: Vec<Vec<Cell>> = fronts.iter().map(|&front| designs.star(front, share)).collect();
            let mut new: Vec<Cell> = stars.iter().flatten().copied().filter(|cell| !known.contains_key(cell)).collect();
            new.sort_unstable();
            new.dedup();
            let places = knowledge.places(&new)?;
            let feasible = knowledge.feasible(&new, &places);
            let means = knowledge.process.means(&places).into_iter().zip(feasible);
            let values = means.map(|(mean, feasible)| if feasible >= FEASIBLE { mean } else { f64::INFINITY });
            known.extend(new.iter().copied().zip(values));
            let mut moved = false;
            for (front, star) in fronts.iter_mut().zip(&stars) {
                let value = |cell: &Cell| known.get(cell).copied().unwrap_or(f64::INFINITY);
                let best = star.iter().copied().min_by(|a, b| value(a).total_cmp(&value(b)).then(a.cmp(b)));
                if let Some(best) = best.filter(|best| value(best) < value(front)) {
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
