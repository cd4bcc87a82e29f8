//! All product monomials on a lattice, so that v on the lattice and its moments are two sweeps over a table.

use std::collections::HashMap;

use multiversion::multiversion;

use crate::lattice::Lattice;
use crate::products::Products;

/// Points per block: their sums stay in registers while the monomials stream by.
const BLOCK: usize = 16;
/// A weight below this does not reach the last bit of a moment.
const NEGLIGIBLE: f64 = 1e-17;

/// Values of the distinct monomials on the allowed points of a lattice. Monomials that agree on all of them, as x
/// and x³ on −1, 0, 1, share a column.
#[derive(Debug)]
pub(crate) struct Table {
    /// Lattice index of each row.
    allowed: Vec<usize>,
    /// Column of each monomial.
    columns: Vec<u32>,
    n_columns: usize,
    /// Block by block, column by column, point by point; the last block is padded with zeros.
    blocked: Vec<f64>,
    /// Point by point.
    by_point: Vec<f64>,
}

impl Table {
    pub(crate) fn of(products: &Products, lattice: &Lattice) -> Self {
        let allowed: Vec<usize> = (0..lattice.n_points()).filter(|&index| lattice.is_allowed(index)).collect();
        let n_monomials = products.n_monomials();
        let mut values = vec![0.0; allowed.len() * n_monomials];
        for (row, &index) in values.chunks_exact_mut(n_monomials).zip(&allowed) {
            products.fill(&lattice.point(index), row);
        }
        let mut distinct: HashMap<Vec<u64>, u32> = HashMap::new();
        let mut sources = Vec::new();
        let columns: Vec<u32> = (0..n_monomials)
            .map(|monomial| {
                // Adding zero makes the two zeros one.
                let bits = |row: usize| (values[row * n_monomials + monomial] + 0.0).to_bits();
                let next = distinct.len() as u32;
                let column = *distinct.entry((0..allowed.len()).map(bits).collect()).or_insert(next);
                if column == next {
                    sources.push(monomial);
                }
                column
            })
            .collect();
        drop(distinct);
        let n_columns = sources.len();
        let by_point: Vec<f64> = (0..allowed.len())
            .flat_map(|row| sources.iter().map(move |&source| (row, source)))
            .map(|(row, source)| values[row * n_monomials + source])
            .collect();
        drop(values);
        let n_blocks = allowed.len().div_ceil(BLOCK);
        let mut blocked = vec![0.0; n_blocks * n_columns * BLOCK];
        for row in 0..allowed.len() {
            for column in 0..n_columns {
                let (block, lane) = (row / BLOCK, row % BLOCK);
                blocked[(block * n_columns + column) * BLOCK + lane] = by_point[row * n_columns + column];
            }
        }
        Self { allowed, columns, n_columns, blocked, by_point }
    }

    pub(crate) fn n_points(&self) -> usize {
        self.allowed.len()
    }

    /// v at every point from the coefficients of its monomials; `folded` is scratch.
    pub(crate) fn values(&self, coefficients: &[f64], folded: &mut Vec<f64>, values: &mut Vec<f64>) {
        folded.clear();
        folded.resize(self.n_columns, 0.0);
        for (&column, c) in self.columns.iter().zip(coefficients) {
            folded[column as usize] += c;
        }
        values.clear();
        values.resize(self.blocked.len() / self.n_columns, 0.0);
        combine(&self.blocked, folded, values);
        values.truncate(self.allowed.len());
    }

    /// Σ w x^e for every monomial; `folded` is scratch.
    pub(crate) fn moments(&self, weights: &[f64], folded: &mut Vec<f64>, moments: &mut [f64]) {
        folded.clear();
        folded.resize(self.n_columns, 0.0);
        accumulate(&self.by_point, weights, folded);
        for (moment, &column) in moments.iter_mut().zip(&self.columns) {
            *moment = folded[column as usize];
        }
    }
}

#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx+avx2"))]
fn combine(blocked: &[f64], coefficients: &[f64], values: &mut [f64]) {
    let blocks = blocked.chunks_exact(coefficients.len() * BLOCK);
    for (block, values) in blocks.zip(values.chunks_exact_mut(BLOCK)) {
        let mut sums = [0.0; BLOCK];
        for (column, &c) in block.chunks_exact(BLOCK).zip(coefficients) {
            for lane in 0..BLOCK {
                sums[lane] += c * column[lane];
            }
        }
        values.copy_from_slice(&sums);
    }
}

#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx+avx2"))]
fn accumulate(by_point: &[f64], weights: &[f64], sums: &mut [f64]) {
    for (row, &weight) in by_point.chunks_exact(sums.len()).zip(weights) {
        if weight > NEGLIGIBLE {
            for (sum, value) in sums.iter_mut().zip(row) {
                *sum += weight * value;
            }
        }
    }
}
