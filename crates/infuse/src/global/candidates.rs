//! The cells from which a batch is designed: all that are left, or a stated part of them.

use std::collections::BTreeSet;

use design_space::Cell;
use doe::Space;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use rayon::prelude::*;

use crate::Error;
use crate::global::cells::Cells;
use crate::global::retained::RetainedSet;

/// Sign vectors are looked at one by one up to this number of parameters.
const MOST_SIGNS: usize = 8;
/// Words of 64 cells that one thread takes at a time.
const CHUNK: usize = 4096;

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
            chosen.extend(extremes(retained, cells)?);
            chosen.into_iter().collect()
        };
        Self::of_cells(chosen, cells)
    }

    /// These cells, at least one.
    pub(crate) fn of_cells(chosen: Vec<Cell>, cells: &Cells) -> Result<Self, Error> {
        let mut coordinates = Vec::with_capacity(chosen.len() * cells.n_factors());
        for &cell in &chosen {
            coordinates.extend(cells.coded(cell)?);
        }
        let space = Space::list(cells.n_factors(), coordinates)?;
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
    for (&word, at) in retained.words().iter().zip(0_u64..) {
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
fn extremes(retained: &RetainedSet, cells: &Cells) -> Result<BTreeSet<Cell>, Error> {
    let k = cells.n_factors();
    let directions = directions(k);
    let farthest = retained
        .words()
        .par_chunks(CHUNK)
        .enumerate()
        .map(|(chunk, words)| farthest(words, (chunk * CHUNK) as u64, cells, &directions))
        .reduce(|| vec![None; directions.len()], farther);
    let combinations = cells.grid().combinations();
    let mut chosen: BTreeSet<Cell> = farthest.into_iter().flatten().map(|(_, cell)| cell).collect();
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
    Ok(chosen)
}

/// Both directions of every axis, and of every diagonal while these are not too many.
fn directions(k: usize) -> Vec<Vec<f64>> {
    let axes = (0..2 * k).map(|number| {
        let mut axis = vec![0.0; k];
        axis[number / 2] = if number % 2 == 0 { -1.0 } else { 1.0 };
        axis
    });
    let n_diagonals = if k <= MOST_SIGNS { 1_usize << k } else { 0 };
    let sign = |number: usize, j: usize| if number >> j & 1 == 0 { -1.0 } else { 1.0 };
    axes.chain((0..n_diagonals).map(|number| (0..k).map(|j| sign(number, j)).collect())).collect()
}

/// A cell and how far it lies in some direction.
type Farthest = Option<(f64, Cell)>;

fn farther(a: Vec<Farthest>, b: Vec<Farthest>) -> Vec<Farthest> {
    let pick = |(a, b): (Farthest, Farthest)| match (a, b) {
        (Some(a), Some(b)) => Some(if b.0 > a.0 || (b.0 >= a.0 && b.1 < a.1) { b } else { a }),
        (a, b) => a.or(b),
    };
    a.into_iter().zip(b).map(pick).collect()
}

/// Along a line of the last parameter only the ends of a run of retained cells can be farthest.
fn farthest(words: &[u64], at: u64, cells: &Cells, directions: &[Vec<f64>]) -> Vec<Farthest> {
    let mut best: Vec<Farthest> = vec![None; directions.len()];
    let mut look = |index: u64| {
        let cell = Cell::new(index);
        let Ok(point) = cells.coded(cell) else {
            return;
        };
        for (best, direction) in best.iter_mut().zip(directions) {
            let distance: f64 = direction.iter().zip(&point).map(|(a, b)| a * b).sum();
            if best.is_none_or(|(farthest, _)| distance > farthest) {
                *best = Some((distance, cell));
            }
        }
    };
    for (&word, at) in words.iter().zip(at..) {
        let mut rest = word;
        while rest != 0 {
            let begin = rest.trailing_zeros();
            let run = (rest >> begin).trailing_ones();
            let first = 64 * at + u64::from(begin);
            let in_line = (cells.line() - first % cells.line()).min(u64::from(run));
            look(first);
            if in_line > 1 {
                look(first + in_line - 1);
            }
            let end = begin + in_line as u32;
            rest = if end == 64 { 0 } else { rest & (u64::MAX << end) };
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use design_space::{Parameter, Region};

    fn cells(levels: &[u32]) -> Cells {
        let parameter = |(index, &count): (usize, &u32)| {
            Parameter::continuous(format!("p{index}"), "m", -1.0, 1.0).unwrap().with_levels(count).unwrap()
        };
        Cells::of(&Region::new(levels.iter().enumerate().map(parameter).collect()).unwrap()).unwrap()
    }

    /// Half of the cells at random, and all distances one by one.
    #[test]
    fn no_retained_cell_is_farther_than_the_extremes_along_any_axis_or_diagonal() {
        for (levels, seed) in [(&[7, 5, 6][..], 1), (&[9, 11], 2), (&[70], 3), (&[3, 4, 2, 5], 4)] {
            let cells = cells(levels);
            let mut generator = Pcg64::seed_from_u64(seed);
            let away = (0..cells.n_cells()).filter(|_| generator.random::<bool>()).map(Cell::new).collect();
            let retained = RetainedSet::full(cells.n_cells()).without(&away);
            let chosen = extremes(&retained, &cells).unwrap();
            assert!(chosen.iter().all(|&cell| retained.contains(cell)), "{levels:?}: one that is not left");
            for direction in directions(levels.len()) {
                let distance =
                    |cell: Cell| -> f64 { cells.coded(cell).unwrap().iter().zip(&direction).map(|(a, b)| a * b).sum() };
                let most = |all: &mut dyn Iterator<Item = Cell>| all.map(distance).fold(f64::NEG_INFINITY, f64::max);
                let [of_all, of_chosen] = [most(&mut retained.cells()), most(&mut chosen.iter().copied())];
                assert!(of_chosen >= of_all - 1e-12, "{levels:?} along {direction:?}: {of_chosen} below {of_all}");
            }
        }
    }

    #[test]
    fn corners_edges_faces_and_the_middle_of_a_full_grid_are_among_the_extremes() {
        let cells = cells(&[5, 7, 9]);
        let chosen = extremes(&RetainedSet::full(cells.n_cells()), &cells).unwrap();
        let points: Vec<Vec<f64>> = chosen.iter().map(|&cell| cells.coded(cell).unwrap()).collect();
        for number in 0..27 {
            let wanted = [1, 3, 9].map(|step| f64::from(number / step % 3) - 1.0);
            assert!(points.iter().any(|point| point == &wanted), "{wanted:?} is missing");
        }
    }

    #[test]
    fn of_two_parts_the_farther_is_taken_and_of_equals_the_first_cell() {
        let at = |distance: f64, cell: u64| Some((distance, Cell::new(cell)));
        let a = vec![at(1.0, 7), at(2.0, 7), at(1.0, 3), at(1.0, 7), None, at(1.0, 7), None];
        let b = vec![at(2.0, 9), at(1.0, 3), at(1.0, 7), at(1.0, 3), at(1.0, 9), None, None];
        let expected = vec![at(2.0, 9), at(2.0, 7), at(1.0, 3), at(1.0, 3), at(1.0, 9), at(1.0, 7), None];
        assert_eq!(farther(a, b), expected);
    }
}
