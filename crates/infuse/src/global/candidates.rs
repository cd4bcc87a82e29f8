//! The cells from which a batch is designed: all that are left, or a stated part of them.

use std::collections::BTreeSet;

use design_space::Cell;
use doe::Space;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use crate::Error;
use crate::global::cells::Cells;
use crate::global::farthest::{MOST_SIGNS, farthest};
use crate::global::retained::RetainedSet;

/// Retained cells as a list, rising.
#[derive(Debug, Clone)]
pub(crate) struct Candidates {
    pub(crate) cells: Vec<Cell>,
    pub(crate) space: Space,
}

impl Candidates {
    /// Every retained cell if there are at most `limit`; otherwise about `limit` of them, spread over the grid at random, and
    /// with them the cells without which no design is good: the farthest along each axis and each
    /// diagonal, and the corners, edges and faces of the box around all of them, where retained.
    pub(crate) fn of(retained: &RetainedSet, cells: &Cells, limit: u64, seed: u64) -> Result<Self, Error> {
        let chosen: Vec<Cell> = if retained.n_retained() <= limit {
            retained.cells().collect()
        } else {
            let mut chosen = sample(retained, limit, seed);
            chosen.extend(extremes(retained, cells));
            chosen.into_iter().collect()
        };
        Self::of_cells(chosen, cells)
    }

    /// These cells, at least one.
    pub(crate) fn of_cells(chosen: Vec<Cell>, cells: &Cells) -> Result<Self, Error> {
        let space = Space::list(cells.n_factors(), cells.all_coded(&chosen)?)?;
        Ok(Self { cells: chosen, space })
    }
}

/// One retained cell from each of `n` equal stretches of the retained cells, at a random place in it.
fn sample(retained: &RetainedSet, n: u64, seed: u64) -> BTreeSet<Cell> {
    let mut generator = Pcg64::seed_from_u64(seed);
    let stretch = retained.n_retained() as f64 / n as f64;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "ranks are below the number of cells")]
    let mut ranks = (0..n).map(|j| ((j as f64 + generator.random::<f64>()) * stretch) as u64).peekable();
    let (mut chosen, mut passed) = (BTreeSet::new(), 0);
    for (at, word) in retained.words() {
        let here = u64::from(word.count_ones());
        while let Some(rank) = ranks.next_if(|&rank| rank < passed + here) {
            let nth = (0..rank - passed).fold(word, |word, _| word & (word - 1));
            chosen.insert(Cell::new(64 * at + u64::from(nth.trailing_zeros())));
        }
        passed += here;
    }
    chosen
}

/// The retained cells that lie farthest in some direction, and those on the lattice of the box around all.
fn extremes(retained: &RetainedSet, cells: &Cells) -> BTreeSet<Cell> {
    let k = cells.n_factors();
    let combinations = cells.grid().combinations();
    let mut chosen = farthest(retained, cells);
    let digits: Vec<Vec<u64>> = chosen.iter().map(|cell| combinations.digits(cell.index())).collect();
    let marks: Vec<[u64; 3]> = (0..k)
        .map(|j| {
            let along = digits.iter().map(|digits| digits[j]);
            let (low, high) = (along.clone().min().unwrap_or(0), along.max().unwrap_or(0));
            [low, low.midpoint(high), high]
        })
        .collect();
    if k <= MOST_SIGNS {
        let lattice = (0..3_usize.pow(k as u32)).map(|number| {
            let pick = |j: usize| marks[j][number / 3_usize.pow(j as u32) % 3];
            Cell::new(combinations.index(&(0..k).map(pick).collect::<Vec<_>>()))
        });
        chosen.extend(lattice.filter(|&cell| retained.contains(cell)));
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_edges_faces_and_the_middle_of_a_full_grid_are_among_the_extremes() {
        let cells = Cells::with_levels(&[5, 7, 9]);
        let chosen = extremes(&RetainedSet::full(cells.n_cells()), &cells);
        let points: Vec<Vec<f64>> = chosen.iter().map(|&cell| cells.coded(cell).unwrap()).collect();
        for number in 0..27 {
            let wanted = [1, 3, 9].map(|step| f64::from(number / step % 3) - 1.0);
            assert!(points.iter().any(|point| point == &wanted), "{wanted:?} is missing");
        }
    }
}
