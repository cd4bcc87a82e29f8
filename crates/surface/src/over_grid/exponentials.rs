//! Squared exponentials: those of the axes multiply.

use multiversion::multiversion;

use crate::GridPoints;
use crate::exponential::exp_of_negative;
use crate::over_grid::runs::{Alone, AxisTables, OverGrid, RUN_OF_AVERAGE, Run, Runs, WIDTH};
use crate::weighted_average::{GROUP, LEAST_TOTAL, Packed, Row};

/// exp(−c² (x − p)²) along each axis.
pub(crate) struct Exponentials<'a> {
    packed: &'a Packed,
    runs: Runs<'a>,
    tables: AxisTables,
    /// One for each datum, and zero for those that fill up the last group.
    weights: Vec<f64>,
    weighted_values: Vec<f64>,
    alone: Alone<'a>,
}

impl<'a> Exponentials<'a> {
    /// None where the grid is too large for tables.
    pub(crate) fn new(packed: &'a Packed, scale: f64, grid: &'a GridPoints, alone: Alone<'a>) -> Option<Self> {
        let rows: Vec<_> = packed.rows().collect();
        let padded = rows.len().next_multiple_of(GROUP);
        let runs = Runs::of(grid, RUN_OF_AVERAGE);
        if !runs.are_small(padded) {
            return None;
        }
        let points: Vec<&[f64]> =
            (0..padded).filter_map(|place| rows.get(place).or(rows.last())).map(|row| row.point).collect();
        let rate = scale * scale;
        let entry = |x: f64, coordinate: f64| {
            let exponent = -(rate * ((x - coordinate) * (x - coordinate)));
            // The exponential is not meant for what is not a number.
            if exponent <= 0.0 { exp_of_negative(exponent) } else { f64::NAN }
        };
        let tables = AxisTables::new(&runs, &points, entry, |a, b| a * b);
        let number = |of: fn(&Row<'_>) -> f64| (0..padded).map(|place| rows.get(place).map_or(0.0, of)).collect();
        Some(Self {
            packed,
            runs,
            tables,
            weights: number(|row| row.weight),
            weighted_values: number(|row| row.weighted_value),
            alone,
        })
    }
}

impl OverGrid for Exponentials<'_> {
    fn fill(&self, first: u64, estimates: &mut [f64]) {
        fill(self, first, estimates);
    }
}

#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx+avx2"))]
fn fill(exponentials: &Exponentials<'_>, first: u64, estimates: &mut [f64]) {
    let n_data = exponentials.tables.n_data();
    let run = ExponentialsRun { exponentials, weights: vec![0.0; n_data], weighted_values: vec![0.0; n_data] };
    exponentials.runs.fill(run, first, estimates, &exponentials.alone);
}

struct ExponentialsRun<'a> {
    exponentials: &'a Exponentials<'a>,
    /// w Π exp(−c² (x − p)²) over all axes but those of a run, for each datum.
    weights: Vec<f64>,
    /// The same times J.
    weighted_values: Vec<f64>,
}

impl Run for ExponentialsRun<'_> {
    #[inline(always)]
    fn start(&mut self, levels: &[u64]) {
        let Exponentials { tables, weights, weighted_values, .. } = self.exponentials;
        self.weights.fill(1.0);
        for (axis, &level) in levels.iter().enumerate() {
            self.weights.iter_mut().zip(tables.leading(axis, level)).for_each(|(product, factor)| *product *= factor);
        }
        for (into, (product, value)) in self.weighted_values.iter_mut().zip(self.weights.iter().zip(weighted_values)) {
            *into = product * value;
        }
        self.weights.iter_mut().zip(weights).for_each(|(product, weight)| *product *= weight);
    }

    #[inline(always)]
    fn block(&self, at: usize) -> [f64; WIDTH] {
        let [averages] = self.averages([at]);
        averages
    }

    /// What stands before the exponentials is then read once for all of them.
    #[inline(always)]
    fn three_blocks(&self, at: usize) -> [[f64; WIDTH]; 3] {
        self.averages([at, at + WIDTH, at + 2 * WIDTH])
    }
}

impl ExponentialsRun<'_> {
    #[inline(always)]
    fn averages<const N: usize>(&self, at: [usize; N]) -> [[f64; WIDTH]; N] {
        let Exponentials { packed, tables, .. } = self.exponentials;
        let of_blocks = at.map(|at| tables.of_run(at));
        let (mut totals, mut sums) = ([[0.0; WIDTH]; N], [[0.0; WIDTH]; N]);
        let numbers = self.weights.as_chunks::<GROUP>().0.iter().zip(self.weighted_values.as_chunks::<GROUP>().0);
        for (group, (weights, values)) in numbers.enumerate() {
            for block in 0..N {
                let of_fours = of_blocks[block][group].as_chunks::<{ 4 * WIDTH }>().0;
                let numbers = weights.as_chunks::<4>().0.iter().zip(values.as_chunks::<4>().0);
                for (factors, (weights, values)) in of_fours.iter().zip(numbers) {
                    for lane in 0..WIDTH {
                        let [a, b, c, d] = std::array::from_fn(|place| factors[place * WIDTH + lane]);
                        totals[block][lane] += (weights[0] * a + weights[1] * b) + (weights[2] * c + weights[3] * d);
                        sums[block][lane] += (values[0] * a + values[1] * b) + (values[2] * c + values[3] * d);
                    }
                }
            }
        }
        for block in 0..N {
            for lane in 0..WIDTH {
                let (total, sum) = (totals[block][lane], sums[block][lane]);
                let average = packed.within(sum / total);
                sums[block][lane] = if total >= LEAST_TOTAL { average } else { f64::NAN };
            }
        }
        sums
    }
}
