//! A grid as runs over its last axes, and tables for them.

use design_space::Combinations;

use crate::GridPoints;
use crate::lanes::MOST_FACTORS;
use crate::weighted_average::GROUP;

/// Estimates at the points of one grid, from tables of its axes: [`Surface::over_grid`](crate::Surface::over_grid).
pub trait OverGrid: Sync {
    /// Estimates at as many points as there is room for, from index `first` on.
    ///
    /// The callers keep them within the grid. An estimate depends on its point alone, not on the range asked for.
    fn fill(&self, first: u64, estimates: &mut [f64]);
}

/// The estimate at a point where the tables do not do.
pub(crate) type Alone<'a> = Box<dyn Fn(&[f64]) -> f64 + Sync + 'a>;

/// Points of a run that are evaluated side by side.
pub(crate) const WIDTH: usize = 8;

/// Points of a run of an average, so that its tables stay in the nearest cache.
pub(crate) const RUN_OF_AVERAGE: usize = 128;

/// Tables of more numbers than this are not made: 64 MB.
const MOST_NUMBERS: usize = 1 << 23;

/// A grid as runs over its last axes: within a run only they change.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Runs<'a> {
    grid: &'a GridPoints,
    /// Axes in front of those of a run.
    n_leading: usize,
    length: usize,
}

impl<'a> Runs<'a> {
    /// As many of the last axes as have no more than `most` points together, one at least.
    pub(crate) fn of(grid: &'a GridPoints, most: usize) -> Self {
        let levels = grid.levels();
        let (mut n_leading, mut length) = (levels.len(), 1);
        for axis in levels.iter().rev() {
            if n_leading < levels.len() && length * axis.len() > most {
                break;
            }
            n_leading -= 1;
            length *= axis.len();
        }
        Self { grid, n_leading, length }
    }

    /// Whether tables of so many numbers for each point of a run and each level of another axis are worth their memory.
    pub(crate) fn are_small(&self, n_each: usize) -> bool {
        let leading: usize = self.leading_levels().iter().map(Vec::len).sum();
        let n_rows = leading.saturating_add(self.length.next_multiple_of(WIDTH));
        n_rows.checked_mul(n_each).is_some_and(|n| n <= MOST_NUMBERS)
    }

    /// The levels of each axis in front of those of a run.
    pub(crate) fn leading_levels(&self) -> &'a [Vec<f64>] {
        &self.grid.levels()[..self.n_leading]
    }

    /// The coordinates along a run, point by point.
    pub(crate) fn points(&self) -> Vec<Vec<f64>> {
        let axes = &self.grid.levels()[self.n_leading..];
        let counts: Vec<u64> = axes.iter().map(|axis| axis.len() as u64).collect();
        let point = |digits: Vec<u64>| axes.iter().zip(digits).map(|(axis, digit)| axis[digit as usize]).collect();
        Combinations::saturating(counts).all().map(point).collect()
    }

    /// Goes through part of the grid run by run; `alone` is asked where the tables do not do.
    #[inline(always)]
    pub(crate) fn fill(&self, mut run: impl Run, first: u64, estimates: &mut [f64], alone: &Alone<'_>) {
        let combinations = self.grid.combinations();
        let mut digits = [0; MOST_FACTORS];
        let digits = &mut digits[..self.grid.levels().len()];
        combinations.fill_digits(first, digits);
        let (mut left, mut index) = (estimates, first);
        let mut from = (first % self.length as u64) as usize;
        while !left.is_empty() {
            let (now, later) = left.split_at_mut(left.len().min(self.length - from));
            run.start(&digits[..self.n_leading]);
            fill_run(&run, from, now);
            if now.iter().any(|estimate| estimate.is_nan()) {
                self.repair(index, now, alone);
            }
            // From the last point of the run to the next.
            for (digit, axis) in digits.iter_mut().zip(self.grid.levels()).skip(self.n_leading) {
                *digit = axis.len() as u64 - 1;
            }
            combinations.advance(digits);
            (left, from) = (later, 0);
            index += now.len() as u64;
        }
    }

    /// Asks for each of these estimates that is not a number; `first` is the index of the first.
    #[cold]
    fn repair(&self, first: u64, estimates: &mut [f64], alone: &Alone<'_>) {
        for (estimate, index) in estimates.iter_mut().zip(first..) {
            if let (true, Some(point)) = (estimate.is_nan(), self.grid.point(index)) {
                *estimate = alone(&point);
            }
        }
    }
}

/// What is computed along one run of a grid.
pub(crate) trait Run {
    /// The next run, by the levels of all axes but its own.
    fn start(&mut self, levels: &[u64]);

    /// Estimates at [`WIDTH`] points of the run from `at` on, a multiple of it; what stands behind its last point does not
    /// matter. Not a number where the tables do not do.
    fn block(&self, at: usize) -> [f64; WIDTH];

    /// The same at three times as many points.
    #[inline(always)]
    fn three_blocks(&self, at: usize) -> [[f64; WIDTH]; 3] {
        [self.block(at), self.block(at + WIDTH), self.block(at + 2 * WIDTH)]
    }
}

/// Estimates at the points of a run from `from` on, in whole blocks, so that none depends on where a range begins.
#[inline(always)]
fn fill_run(run: &impl Run, from: usize, estimates: &mut [f64]) {
    let mut at = from / WIDTH * WIDTH;
    let mut left = estimates;
    if from > at {
        let n = left.len().min(at + WIDTH - from);
        let (now, later) = left.split_at_mut(n);
        now.copy_from_slice(&run.block(at)[from - at..][..n]);
        (left, at) = (later, at + WIDTH);
    }
    let (blocks, rest) = left.as_chunks_mut::<WIDTH>();
    let (threes, others) = blocks.as_chunks_mut::<3>();
    for three in threes {
        *three = run.three_blocks(at);
        at += 3 * WIDTH;
    }
    for block in others {
        *block = run.block(at);
        at += WIDTH;
    }
    if !rest.is_empty() {
        rest.copy_from_slice(&run.block(at)[..rest.len()]);
    }
}

/// For each datum a number at each point of a run, and one at each level of each axis in front; data in groups of eight.
#[derive(Debug)]
pub(crate) struct AxisTables {
    /// For each axis in front, level by level, one number per datum.
    leading: Vec<Vec<f64>>,
    /// Along a run, [`WIDTH`] points at a time: datum by datum, one number per point. The last block is filled up.
    of_run: Vec<f64>,
    n_data: usize,
}

impl AxisTables {
    /// With `entry` of a level and a coordinate of a datum, and `both` of the numbers of two axes; `data` are given by their
    /// points, as many as a multiple of eight.
    pub(crate) fn new(
        runs: &Runs<'_>,
        data: &[&[f64]],
        entry: impl Fn(f64, f64) -> f64,
        both: impl Fn(f64, f64) -> f64,
    ) -> Self {
        let of_axis = |(axis, levels): (usize, &Vec<f64>)| {
            let pairs = levels.iter().flat_map(|&x| data.iter().map(move |datum| (x, datum[axis])));
            pairs.map(|(x, coordinate)| entry(x, coordinate)).collect()
        };
        let at = |point: &[f64], datum: &[f64]| {
            let axes = point.iter().zip(&datum[runs.n_leading..]);
            axes.map(|(&x, &coordinate)| entry(x, coordinate)).reduce(&both).unwrap_or(f64::NAN)
        };
        let mut of_run = Vec::new();
        for block in runs.points().chunks(WIDTH) {
            let padded = || block.iter().chain(std::iter::repeat_n(&block[0], WIDTH - block.len()));
            of_run.extend(data.iter().flat_map(|datum| padded().map(|point| at(point, datum))));
        }
        let leading = runs.leading_levels().iter().enumerate().map(of_axis).collect();
        Self { leading, of_run, n_data: data.len() }
    }

    pub(crate) fn n_data(&self) -> usize {
        self.n_data
    }

    /// The numbers of one level of one of the axes in front, one per datum.
    #[inline(always)]
    pub(crate) fn leading(&self, axis: usize, level: u64) -> &[f64] {
        &self.leading[axis][level as usize * self.n_data..][..self.n_data]
    }

    /// For each group of eight data their numbers at [`WIDTH`] points of a run from `at` on, a multiple of it.
    #[inline(always)]
    pub(crate) fn of_run(&self, at: usize) -> &[[f64; GROUP * WIDTH]] {
        self.of_run[at * self.n_data..][..WIDTH * self.n_data].as_chunks().0
    }
}
