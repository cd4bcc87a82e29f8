//! What is left of the gridded space: one bit a cell, where it is not all or nothing.

use std::cmp::Ordering;
use std::collections::BTreeSet;
use std::ops::Range;
use std::sync::Arc;

use design_space::Cell;
use rayon::prelude::*;
use surface::{GridPoints, LANES, Lanes, MOST_FACTORS, PointSource, Surface};

use crate::Error;
use crate::convergence::Norm;

/// Words of 64 cells that are held together, and that one thread takes at a time.
const CHUNK: usize = 64;
/// The cells of a chunk.
const CHUNK_CELLS: u64 = 64 * CHUNK as u64;
/// With no more cells than this left among a block of lanes, they are evaluated one by one.
const FEW: u32 = 3;
/// A bit for each lane of a block.
const EVERY_LANE: u64 = (1 << LANES) - 1;

const _: () = assert!(LANES < 64 && 64 % LANES == 0, "a word of cells is some whole blocks of lanes");

/// 64 cells a word, the first cell in the lowest bit.
type Words = [u64; CHUNK];

static ALL: Words = [u64::MAX; CHUNK];
static NONE: Words = [0; CHUNK];

/// Some neighboring cells: two sets whose cells are the same here hold them once.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Chunk {
    All,
    Nothing,
    /// Some of them, not all.
    Part(Arc<Words>),
}

impl Chunk {
    fn of(words: Words) -> Self {
        match words {
            words if words == ALL => Self::All,
            words if words == NONE => Self::Nothing,
            words => Self::Part(Arc::new(words)),
        }
    }

    fn words(&self) -> &Words {
        match self {
            Self::All => &ALL,
            Self::Nothing => &NONE,
            Self::Part(words) => words,
        }
    }
}

/// The design space M_i: the cells of a grid that have not been dropped.
///
/// Cells count as in [`Grid`](design_space::Grid), the last parameter fastest. A cell takes at most one bit, whatever the
/// number of parameters; neighbors that are all retained, or all dropped, take next to nothing, and copies share the rest.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RetainedSet {
    chunks: Vec<Chunk>,
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
        let n_chunks = usize::try_from(n_cells / CHUNK_CELLS).unwrap_or(usize::MAX);
        let mut chunks = vec![Chunk::All; n_chunks];
        let n_rest = n_cells % CHUNK_CELLS;
        if n_rest > 0 {
            let mut last = NONE;
            let (n_words, n_bits) = ((n_rest / 64) as usize, n_rest % 64);
            last[..n_words].fill(u64::MAX);
            if n_bits > 0 {
                last[n_words] = (1 << n_bits) - 1;
            }
            chunks.push(Chunk::of(last));
        }
        Self { chunks, n_cells, n_retained: n_cells }
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
        let chunk = usize::try_from(cell / CHUNK_CELLS).ok().and_then(|at| self.chunks.get(at));
        chunk.is_some_and(|chunk| chunk.words()[word_of(cell)] >> (cell % 64) & 1 == 1)
    }

    /// The retained cells, rising.
    pub fn cells(&self) -> impl Iterator<Item = Cell> + '_ {
        self.words().flat_map(|(at, word)| bits(word).map(move |bit| Cell::new(64 * at + u64::from(bit))))
    }

    /// 64 cells a word, the first cell in the lowest bit, each with its number; of those without a cell not all.
    pub(crate) fn words(&self) -> impl Iterator<Item = (u64, u64)> + '_ {
        let some = self.chunks.iter().zip(0_u64..).filter(|(chunk, _)| **chunk != Chunk::Nothing);
        some.flat_map(|(chunk, at)| (at * CHUNK as u64..).zip(chunk.words().iter().copied()))
    }

    /// The first and the last retained cell among these.
    pub(crate) fn ends(&self, cells: Range<u64>) -> Option<(u64, u64)> {
        let word = |at: u64| {
            let word = self.chunks[(at / CHUNK as u64) as usize].words()[(at % CHUNK as u64) as usize];
            let from = if at == cells.start / 64 { u64::MAX << (cells.start % 64) } else { u64::MAX };
            let to = if at == (cells.end - 1) / 64 { u64::MAX >> (63 - (cells.end - 1) % 64) } else { u64::MAX };
            (at, word & from & to)
        };
        let mut some = (cells.start / 64..cells.end.div_ceil(64)).map(word).filter(|&(_, word)| word != 0);
        let first = some.next()?;
        let last = some.next_back().unwrap_or(first);
        Some((64 * first.0 + u64::from(first.1.trailing_zeros()), 64 * last.0 + 63 - u64::from(last.1.leading_zeros())))
    }

    /// The words of every chunk that has a cell, and the number of its first word: in the order of the cells.
    pub(crate) fn par_words(&self) -> impl ParallelIterator<Item = (u64, &[u64])> + '_ {
        let some = self.chunks.par_iter().enumerate().filter(|(_, chunk)| **chunk != Chunk::Nothing);
        some.map(|(at, chunk)| ((at * CHUNK) as u64, chunk.words().as_slice()))
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
        let of_chunk = |(at, words): (u64, &[u64])| {
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
        self.par_words().filter_map(of_chunk).reduce_with(least)
    }

    /// The largest magnitude of the estimates over the retained cells.
    pub(crate) fn largest_magnitude(&self, points: &GridPoints, surface: &dyn Surface) -> f64 {
        let of_chunk = |(at, words): (u64, &[u64])| {
            let mut largest = 0.0_f64;
            each_estimate(words, at, points, surface, |_, value| largest = largest.max(value.abs()));
            largest
        };
        self.par_words().map(of_chunk).reduce(|| 0.0, f64::max)
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
        let of_chunk = |(at, words): (u64, &[u64])| {
            let mut sum = 0.0;
            each_estimate(words, at, points, surface, |_, value| sum += norm.share(value, largest));
            sum
        };
        // One sum per chunk, added up in order: the same bits on any number of threads.
        let sums: Vec<f64> = self.par_words().map(of_chunk).collect();
        norm.of_shares(largest, sums.iter().sum(), self.n_retained, measure)
    }

    /// The first retained cell at which a surface is not a finite number.
    fn first_not_finite(&self, points: &GridPoints, surface: &dyn Surface) -> Option<(u64, f64)> {
        let of_chunk = |(at, words): (u64, &[u64])| {
            let mut found = None;
            each_estimate(words, at, points, surface, |cell, value| {
                if found.is_none() && !value.is_finite() {
                    found = Some((cell, value));
                }
            });
            found
        };
        self.par_words().find_map_first(of_chunk)
    }

    /// The same without these cells.
    pub(crate) fn without(&self, cells: &BTreeSet<Cell>) -> Self {
        let mut others = self.clone();
        for cell in cells.iter().filter(|&&cell| self.contains(cell)) {
            let chunk = &mut others.chunks[(cell.index() / CHUNK_CELLS) as usize];
            let mut words = *chunk.words();
            words[word_of(cell.index())] &= !(1 << (cell.index() % 64));
            *chunk = Chunk::of(words);
            others.n_retained -= 1;
        }
        others
    }

    /// Drops every retained cell whose estimate is not to be kept.
    pub(crate) fn retain(&mut self, points: &GridPoints, surface: &dyn Surface, keep: impl Fn(f64) -> bool + Sync) {
        let of_chunk = |(at, chunk): (usize, &mut Chunk)| {
            if *chunk == Chunk::Nothing {
                return 0;
            }
            let (mut after, at) = (*chunk.words(), (at * CHUNK) as u64);
            each_estimate(chunk.words(), at, points, surface, |cell, value| {
                if !keep(value) {
                    after[word_of(cell)] &= !(1 << (cell % 64));
                }
            });
            if after != *chunk.words() {
                *chunk = Chunk::of(after);
            }
            after.iter().map(|word| u64::from(word.count_ones())).sum::<u64>()
        };
        self.n_retained = self.chunks.par_iter_mut().enumerate().map(of_chunk).sum();
    }
}

/// The word of a cell within its chunk.
fn word_of(cell: u64) -> usize {
    (cell % CHUNK_CELLS / 64) as usize
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
            let lanes = word >> shift & EVERY_LANE;
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
            if lanes == EVERY_LANE {
                for (cell, &estimate) in (first..).zip(&estimates) {
                    each(cell, estimate);
                }
                continue;
            }
            for bit in bits(lanes) {
                each(first + u64::from(bit), estimates[bit as usize]);
            }
        }
    }
}
