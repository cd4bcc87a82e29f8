//! Inverse distances with the power 2: squares of distances add along the axes.

use multiversion::multiversion;

use crate::GridPoints;
use crate::over_grid::runs::{Alone, AxisTables, OverGrid, RUN_OF_AVERAGE, Run, Runs, WIDTH};
use crate::quotients::{Groups, Quotients};
use crate::weighted_average::{GROUP, Packed};

/// Squared differences along each axis.
pub(crate) struct Squares<'a> {
    packed: &'a Packed,
    groups: &'a Groups,
    runs: Runs<'a>,
    tables: AxisTables,
    alone: Alone<'a>,
}

impl<'a> Squares<'a> {
    /// None where the grid is too large for tables, or so wide that products of distances might overflow.
    pub(crate) fn new(packed: &'a Packed, groups: &'a Groups, grid: &'a GridPoints, alone: Alone<'a>) -> Option<Self> {
        let mut levels = grid.levels().iter().flatten();
        let is_plain = groups.is_plain() && levels.all(|x| Groups::is_plain_coordinate(*x));
        let points: Vec<&[f64]> = groups.points().collect();
        let runs = Runs::of(grid, RUN_OF_AVERAGE);
        (is_plain && runs.are_small(points.len())).then(|| {
            let tables =
                AxisTables::new(&runs, &points, |x, coordinate| (x - coordinate) * (x - coordinate), |a, b| a + b);
            Self { packed, groups, runs, tables, alone }
        })
    }
}

impl OverGrid for Squares<'_> {
    fn fill(&self, first: u64, estimates: &mut [f64]) {
        fill(self, first, estimates);
    }
}

#[multiversion(targets("x86_64+avx512f+avx512vl+fma", "x86_64+avx+avx2+fma"))]
fn fill(squares: &Squares<'_>, first: u64, estimates: &mut [f64]) {
    let run = SquaresRun { squares, of_run: vec![0.0; squares.tables.n_data()] };
    squares.runs.fill(run, first, estimates, &squares.alone);
}

struct SquaresRun<'a> {
    squares: &'a Squares<'a>,
    /// Σ (x − p)² over all axes but those of a run, for each datum.
    of_run: Vec<f64>,
}

impl Run for SquaresRun<'_> {
    #[inline(always)]
    fn start(&mut self, levels: &[u64]) {
        self.of_run.fill(0.0);
        for (axis, &level) in levels.iter().enumerate() {
            self.of_run
                .iter_mut()
                .zip(self.squares.tables.leading(axis, level))
                .for_each(|(sum, square)| *sum += square);
        }
    }

    #[inline(always)]
    fn block(&self, at: usize) -> [f64; WIDTH] {
        let Squares { packed, groups, tables, .. } = self.squares;
        let mut quotients = Quotients::<WIDTH>::new();
        let numbers = groups.of_eight().iter().zip(self.of_run.as_chunks::<GROUP>().0);
        for (along_run, (group, of_run)) in tables.of_run(at).iter().zip(numbers) {
            quotients.add(|place, lane| of_run[place] + along_run[place * WIDTH + lane], group);
        }
        quotients.averages().map(|average| packed.within(average))
    }
}
