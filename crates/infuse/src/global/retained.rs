//! What is left of the gridded space: one bit a cell.

use std::cmp::Ordering;
use std::collections::BTreeSet;

use design_space::Cell;
use rayon::prelude::*;
use surface::{GridPoints, LANES, Lanes, MOST_FACTORS, PointSource, Surface};

use crate::Error;
use crate::convergence::Norm;

/// Words of 64 cells that one thread takes at a time.
const CHUNK: usize = 64;
/// With no more cells than this left among a block of lanes, they are evaluated one by one.
const FEW: u32 = 3;

const _: () = assert!(LANES < 64 && 64 % LANES == 0, "a word of cells is some whole blocks of lanes");

/// The design space M_i: the cells of a grid that have not been dropped.
///
/// Cells count as in [`Grid`](design_space::Grid), the last parameter fastest. A cell takes one bit, whatever the
/// number of parameters.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RetainedSet {
    words: Vec<u64>,
    n_cells: u64,
    n_retained: u64,
}

/// The smallest estimate, and where.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Least {
    pub(crate) cell: Cell,
    pub(crate) value: f64,
}

impl RetainedSet {
    /// All cells.
    pub(crate) fn full(n_cells: u64) -> Self {
        let n_words = n_cells.div_ceil(64);
        let mut words = vec![u64::MAX; usize::try_from(n_words).unwrap_or(usize::MAX)];
        if let Some(last) = words.last_mut()
            && !n_cells.is_multiple_of(64)
        {
            *last = (1 << (n_cells % 64)) - 1;
        }
        Self { words, n_cells, n_retained: n_cells }
    }

    /// Number of cells of the original grid.
    #[must_use]
    pub fn n_cells(&self) -> u64 {
        self.n_cells
    }

    /// Number of cells retained.
    #[must_use]
    pub fn n_retained(&self) -> u64 {
        self.n_retained
    }

    /// The part of the original grid that is retained, 0 to 1: the last column of Tables 5 and 6.
    #[must_use]
    pub fn share(&self) -> f64 {
        self.n_retained as f64 / self.n_cells as f64
    }

    /// Whether this cell is retained; false for a cell outside the grid.
    #[must_use]
    pub fn contains(&self, cell: Cell) -> bool {
        let cell = cell.index();
        let word = usize::try_from(cell / 64).ok().and_then(|at| self.words.get(at));
        word.is_some_and(|word| word >> (cell % 64) & 1 == 1)
    }

    /// The retained cells, rising.
    pub fn cells(&self) -> impl Iterator<Item = Cell> + '_ {
        let of_word = |(&word, at)| bits(word).map(move |bit| Cell::new(64 * at + u64::from(bit)));
        self.words.iter().zip(0_u64..).flat_map(of_word)
    }

    /// 64 cells a word, the first cell in the lowest bit.
    pub(crate) fn words(&self) -> &[u64] {
        &self.words
    }

    /// The retained cell of the smallest estimate, of equals the first; none if no estimate is a number.
    pub(crate) fn minimum(&self, points: &GridPoints, surface: &dyn Surface) -> Option<Least> {
        self.minimum_but(None, points, surface)
    }

    /// The same, one cell left out.
    pub(crate) fn minimum_but(
        &self,
        except: Option<Cell>,
        points: &GridPoints,
        surface: &dyn Surface,
    ) -> Option<Least> {
        let of_chunk = |(words, at): (&[u64], u64)| {
            let mut best: Option<Least> = None;
            each_estimate(words, at, points, surface, |cell, value| {
                let cell = Cell::new(cell);
                if except == Some(cell) {
                    return;
                }
                if best.map_or(!value.is_nan(), |best| value < best.value) {
                    best = Some(Least { cell, value });
                }
            });
            best
        };
        let least = |a: Least, b: Least| match (b.value, b.cell).partial_cmp(&(a.value, a.cell)) {
            Some(Ordering::Less) => b,
            _ => a,
        };
        self.words.par_chunks(CHUNK).zip(chunk_starts(&self.words)).filter_map(of_chunk).reduce_with(least)
    }

    /// The largest magnitude of the estimates over the retained cells.
    pub(crate) fn largest_magnitude(&self, points: &GridPoints, surface: &dyn Surface) -> f64 {
        let of_chunk = |(words, at): (&[u64], u64)| {
            let mut largest = 0.0_f64;
            each_estimate(words, at, points, surface, |_, value| largest = largest.max(value.abs()));
            largest
        };
        self.words.par_chunks(CHUNK).zip(chunk_starts(&self.words)).map(of_chunk).reduce(|| 0.0, f64::max)
    }

    /// A norm of a surface over the retained cells, each of this measure; nothing is stored per cell.
    pub(crate) fn norm(
        &self,
        points: &GridPoints,
        surface: &dyn Surface,
        norm: Norm,
        measure: f64,
    ) -> Result<f64, Error> {
        if let Some((cell, value)) = self.first_not_finite(points, surface) {
            let index = usize::try_from(cell).unwrap_or(usize::MAX);
            return Err(Error::Entry {
                name: "surface",
                index,
                value,
                expected: "a finite number at each retained cell",
            });
        }
        let largest = self.largest_magnitude(points, surface);
        let of_chunk = |(words, at): (&[u64], u64)| {
            let mut sum = 0.0;
            each_estimate(words, at, points, surface, |_, value| sum += norm.share(value, largest));
            sum
        };
        // One sum per chunk, added up in order: the same bits on any number of threads.
        let sums: Vec<f64> = self.words.par_chunks(CHUNK).zip(chunk_starts(&self.words)).map(of_chunk).collect();
        norm.of_shares(largest, sums.iter().sum(), self.n_retained, measure)
    }

    /// The first retained cell at which a surface is not a finite number.
    fn first_not_finite(&self, points: &GridPoints, surface: &dyn Surface) -> Option<(u64, f64)> {
        let of_chunk = |(words, at): (&[u64], u64)| {
            let mut found = None;
            each_estimate(words, at, points, surface, |cell, value| {
                if found.is_none() && !value.is_finite() {
                    found = Some((cell, value));
                }
            });
            found
        };
        self.words.par_chunks(CHUNK).zip(chunk_starts(&self.words)).find_map_first(of_chunk)
    }

    /// The same without these cells.
    pub(crate) fn without(&self, cells: &BTreeSet<Cell>) -> Self {
        let mut others = self.clone();
        for cell in cells.iter().filter(|&&cell| self.contains(cell)) {
            others.words[(cell.index() / 64) as usize] &= !(1 << (cell.index() % 64));
            others.n_retained -= 1;
        }
        others
    }

    /// Drops every retained cell whose estimate is not to be kept.
    pub(crate) fn retain(&mut self, points: &GridPoints, surface: &dyn Surface, keep: impl Fn(f64) -> bool + Sync) {
        let starts = chunk_starts(&self.words);
        let of_chunk = |(words, at): (&mut [u64], u64)| {
            let before = words.to_vec();
            each_estimate(&before, at, points, surface, |cell, value| {
                if !keep(value) {
                    let inside = cell - 64 * at;
                    words[(inside / 64) as usize] &= !(1 << (inside % 64));
                }
            });
            words.iter().map(|word| u64::from(word.count_ones())).sum::<u64>()
        };
        self.n_retained = self.words.par_chunks_mut(CHUNK).zip(starts).map(of_chunk).sum();
    }
}

/// Index of the first word of every chunk.
fn chunk_starts(words: &[u64]) -> impl IndexedParallelIterator<Item = u64> + use<> {
    (0..words.len().div_ceil(CHUNK)).into_par_iter().map(|chunk| (chunk * CHUNK) as u64)
}

/// Positions of the ones, rising.
fn bits(mut word: u64) -> impl Iterator<Item = u32> {
    std::iter::from_fn(move || {
        (word != 0).then(|| {
            let bit = word.trailing_zeros();
            word &= word - 1;
            bit
        })
    })
}

/// Calls `each` with every retained cell of these words, rising, and the estimate there. `at` is the index of the first word.
fn each_estimate(words: &[u64], at: u64, points: &GridPoints, surface: &dyn Surface, mut each: impl FnMut(u64, f64)) {
    let (mut block, mut estimates): ([Lanes; MOST_FACTORS], Lanes) = ([[0.0; LANES]; MOST_FACTORS], [0.0; LANES]);
    let (block, mut point) = (&mut block[..points.n_factors()], [0.0; MOST_FACTORS]);
    for (&word, at) in words.iter().zip(at..) {
        if word == 0 {
            continue;
        }
        for shift in (0..64).step_by(LANES) {
            let lanes = word >> shift & ((1 << LANES) - 1);
            if lanes == 0 {
                continue;
            }
            let first = 64 * at + shift as u64;
            if lanes.count_ones() <= FEW {
                for bit in bits(lanes) {
                    let cell = first + u64::from(bit);
                    points.fill(cell, 1, block);
                    point.iter_mut().zip(&*block).for_each(|(x, coordinate)| *x = coordinate[0]);
                    each(cell, surface.predict(&point[..block.len()]));
                }
                continue;
            }
            let n_filled = (points.n_points() - first).min(LANES as u64) as usize;
            points.fill(first, n_filled, block);
            surface.predict_lanes(block, &mut estimates);
            for bit in bits(lanes) {
                each(first + u64::from(bit), estimates[bit as usize]);
            }
        }
    }
}
