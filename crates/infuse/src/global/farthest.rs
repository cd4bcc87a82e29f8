//! The retained cells that lie farthest along the axes and the diagonals of the coded box.

use std::collections::BTreeSet;
use std::ops::Range;

use design_space::{Cell, Combinations};
use rayon::prelude::*;

use crate::global::cells::Cells;
use crate::global::retained::RetainedSet;

/// Diagonals are looked at one by one up to this number of parameters.
pub(crate) const MOST_SIGNS: usize = 8;
/// Lines of cells that one thread takes at a time.
const LINES: u64 = 1 << 14;

/// The farthest retained cell along both directions of every axis and, while these are not too many, of every diagonal;
/// of equals the first.
pub(crate) fn farthest(retained: &RetainedSet, cells: &Cells) -> BTreeSet<Cell> {
    let axes = cells.points().levels();
    let n_lines = cells.n_cells() / cells.line();
    let of_part = |part: u64| {
        let lines = part * LINES..((part + 1) * LINES).min(n_lines);
        of_lines(lines, retained, cells, axes)
    };
    let found = (0..n_lines.div_ceil(LINES)).into_par_iter().map(of_part);
    let found = found.reduce(|| Farthest::none(axes.len()), Farthest::or_farther);
    found.cells.into_iter().filter(|&cell| cell != NOWHERE).map(Cell::new).collect()
}

const NOWHERE: u64 = u64::MAX;

/// How far the farthest cell lies in every direction, and which it is: the axes first, down before up, then the diagonals,
/// whose j-th sign is minus where bit j of their number is 0.
#[derive(Debug, Clone, PartialEq)]
struct Farthest {
    distances: Vec<f64>,
    cells: Vec<u64>,
}

impl Farthest {
    fn none(k: usize) -> Self {
        let n = 2 * k + if k <= MOST_SIGNS { 1 << k } else { 0 };
        Self { distances: vec![f64::NEG_INFINITY; n], cells: vec![NOWHERE; n] }
    }

    /// Cells come in rising order.
    fn look(&mut self, direction: usize, distance: f64, cell: u64) {
        if distance > self.distances[direction] {
            self.distances[direction] = distance;
            self.cells[direction] = cell;
        }
    }

    fn or_farther(mut self, other: Self) -> Self {
        for (direction, (&distance, &cell)) in other.distances.iter().zip(&other.cells).enumerate() {
            let (mine, first) = (self.distances[direction], self.cells[direction]);
            if distance > mine || (distance >= mine && cell < first) {
                (self.distances[direction], self.cells[direction]) = (distance, cell);
            }
        }
        self
    }
}

/// Along a line, whose cells differ in the last parameter alone, only the first and the last retained cell can be farthest.
fn of_lines(lines: Range<u64>, retained: &RetainedSet, cells: &Cells, axes: &[Vec<f64>]) -> Farthest {
    let k = axes.len();
    let mut found = Farthest::none(k);
    let mut sums = Sums::new(axes);
    let (next, last) = (Combinations::saturating(&cells.grid().combinations().counts()[..k - 1]), &axes[k - 1]);
    let mut digits = next.digits(lines.start);
    for line in lines {
        let begin = line * cells.line();
        if let Some((first, end)) = retained.ends(begin..begin + cells.line()) {
            let (low, high) = (last[(first - begin) as usize], last[(end - begin) as usize]);
            for (j, (&digit, axis)) in digits.iter().zip(axes).enumerate() {
                found.look(2 * j, -axis[digit as usize], first);
                found.look(2 * j + 1, axis[digit as usize], first);
            }
            found.look(2 * k - 2, -low, first);
            found.look(2 * k - 1, high, end);
            let n_diagonals = found.cells.len() - 2 * k;
            if n_diagonals > 0 {
                let before = sums.of(&digits);
                let (down, up) = (2 * k, 2 * k + n_diagonals / 2);
                for (number, &sum) in before.iter().enumerate() {
                    found.look(down + number, sum - low, first);
                    found.look(up + number, sum + high, end);
                }
            }
        }
        next.advance(&mut digits);
    }
    found
}

/// ± x₁ ± x₂ … over all signs, for the first one, two, … parameters: only what has changed since the last line is added up.
struct Sums<'a> {
    axes: &'a [Vec<f64>],
    digits: Vec<Option<u64>>,
    of_first: Vec<Vec<f64>>,
}

impl<'a> Sums<'a> {
    fn new(axes: &'a [Vec<f64>]) -> Self {
        let n = if axes.len() <= MOST_SIGNS { axes.len() } else { 0 };
        let of_first = (0..n).map(|j| vec![0.0; 1 << j]).collect();
        Self { axes, digits: vec![None; axes.len() - 1], of_first }
    }

    fn of(&mut self, digits: &[u64]) -> &[f64] {
        let same = self.digits.iter().zip(digits).take_while(|(old, new)| **old == Some(**new)).count();
        for (j, &digit) in digits.iter().enumerate().skip(same) {
            let x = self.axes[j][digit as usize];
            let (before, after) = self.of_first.split_at_mut(j + 1);
            let (minus, plus) = after[0].split_at_mut(1 << j);
            for ((minus, plus), sum) in minus.iter_mut().zip(plus).zip(&before[j]) {
                (*minus, *plus) = (sum - x, sum + x);
            }
            self.digits[j] = Some(digit);
        }
        self.of_first.last().map_or(&[], Vec::as_slice)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    /// Some of the cells at random, and all distances one by one; lines longer and shorter than a word, and more than a
    /// thread takes at a time.
    #[test]
    fn no_retained_cell_is_farther_along_any_axis_or_diagonal_than_the_farthest() {
        let share = [0.5, 0.5, 0.5, 0.1, 0.02, 0.5, 0.001];
        let levels: [&[u32]; 7] = [&[7, 5, 6], &[9, 11], &[70], &[3, 4, 2, 5], &[3, 200], &[2; 9], &[40, 30, 20, 2]];
        for (seed, (levels, share)) in levels.iter().zip(share).enumerate() {
            let cells = Cells::with_levels(levels);
            let mut generator = Pcg64::seed_from_u64(seed as u64);
            let away = (0..cells.n_cells()).filter(|_| generator.random::<f64>() > share).map(Cell::new).collect();
            let retained = RetainedSet::full(cells.n_cells()).without(&away);
            let chosen = farthest(&retained, &cells);
            assert!(chosen.iter().all(|&cell| retained.contains(cell)), "{levels:?}: one that is not left");
            let k = levels.len();
            let axis = |number: usize| {
                (0..k).map(|j| if j == number / 2 { 2.0 * (number % 2) as f64 - 1.0 } else { 0.0 }).collect()
            };
            let diagonal = |number: usize| (0..k).map(|j| 2.0 * (number >> j & 1) as f64 - 1.0).collect();
            let n_diagonals = if k <= MOST_SIGNS { 1 << k } else { 0 };
            let directions: Vec<Vec<f64>> = (0..2 * k).map(axis).chain((0..n_diagonals).map(diagonal)).collect();
            assert!(chosen.len() <= directions.len(), "{levels:?}: one cell a direction");
            let points = |cells_: &mut dyn Iterator<Item = Cell>| -> Vec<Vec<f64>> {
                cells_.map(|cell| cells.coded(cell).unwrap()).collect()
            };
            let (all, chosen) = (points(&mut retained.cells()), points(&mut chosen.iter().copied()));
            for direction in directions {
                let most = |points: &[Vec<f64>]| {
                    let distance = |point: &Vec<f64>| -> f64 { direction.iter().zip(point).map(|(a, b)| a * b).sum() };
                    points.iter().map(distance).fold(f64::NEG_INFINITY, f64::max)
                };
                let [of_all, of_chosen] = [most(&all), most(&chosen)];
                assert!(of_chosen >= of_all - 1e-12, "{levels:?} along {direction:?}: {of_chosen} below {of_all}");
            }
        }
    }

    #[test]
    fn of_two_parts_the_farther_is_taken_and_of_equals_the_first_cell() {
        let found =
            |distances: [f64; 4], cells: [u64; 4]| Farthest { distances: distances.into(), cells: cells.into() };
        let none = f64::NEG_INFINITY;
        let a = found([1.0, 2.0, 1.0, none], [7, 7, 3, NOWHERE]);
        let b = found([2.0, 1.0, 1.0, 1.0], [9, 3, 7, 9]);
        let expected = found([2.0, 2.0, 1.0, 1.0], [9, 7, 3, 9]);
        assert_eq!(a.clone().or_farther(b.clone()), expected);
        assert_eq!(b.or_farther(a), expected);
    }
}
