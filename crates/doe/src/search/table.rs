//! All product monomials on a lattice, so that v on the lattice and its moments are two sweeps over a table; axis by axis where
//! the table would be large.

use std::collections::HashMap;

use multiversion::multiversion;

use crate::lattice::Lattice;
use crate::nested::{MOST_STORED, Nested};
use crate::products::Products;

/// Points per block: their sums stay in registers while the monomials stream by.
const BLOCK: usize = 16;
/// A weight below this does not reach the last bit of a moment.
const NEGLIGIBLE: f64 = 1e-17;

/// The monomials on the allowed points of a lattice.
#[derive(Debug)]
pub(crate) struct Table {
    n_points: usize,
    monomials: Monomials,
}

#[derive(Debug)]
enum Monomials {
    Stored(Stored),
    /// Axis by axis each time; which points are allowed, if not all.
    Nested(Nested, Option<Vec<usize>>),
}

impl Table {
    pub(crate) fn of(products: &Products, lattice: &Lattice) -> Self {
        Self::with_stored(products, lattice, MOST_STORED)
    }

    /// A table that stores up to `most` numbers.
    fn with_stored(products: &Products, lattice: &Lattice, most: usize) -> Self {
        let allowed: Vec<usize> = (0..lattice.n_points()).filter(|&index| lattice.is_allowed(index)).collect();
        let n_points = allowed.len();
        let monomials = if n_points.saturating_mul(products.n_monomials()) <= most {
            Monomials::Stored(Stored::of(products, lattice, &allowed))
        } else {
            let some = (n_points < lattice.n_points()).then_some(allowed);
            Monomials::Nested(Nested::of(products, lattice.levels().to_vec()), some)
        };
        Self { n_points, monomials }
    }

    pub(crate) fn n_points(&self) -> usize {
        self.n_points
    }

    /// v at every point from the coefficients of its monomials; `scratch` is overwritten.
    pub(crate) fn values(&self, coefficients: &[f64], scratch: &mut Vec<f64>, values: &mut Vec<f64>) {
        match &self.monomials {
            Monomials::Stored(stored) => stored.values(coefficients, scratch, values),
            Monomials::Nested(nested, None) => nested.values(coefficients, values),
            Monomials::Nested(nested, Some(allowed)) => {
                nested.values(coefficients, scratch);
                values.clear();
                values.extend(allowed.iter().map(|&index| scratch[index]));
            }
        }
    }

    /// Σ w x^e for every monomial; `scratch` is overwritten.
    pub(crate) fn moments(&self, weights: &[f64], scratch: &mut Vec<f64>, moments: &mut [f64]) {
        match &self.monomials {
            Monomials::Stored(stored) => stored.moments(weights, scratch, moments),
            Monomials::Nested(nested, None) => nested.moments(weights, moments),
            Monomials::Nested(nested, Some(allowed)) => {
                scratch.clear();
                scratch.resize(nested.n_points(), 0.0);
                allowed.iter().zip(weights).for_each(|(&index, &weight)| scratch[index] = weight);
                nested.moments(scratch, moments);
            }
        }
    }
}

/// Values of the distinct monomials on the allowed points of a lattice. Monomials that agree on all of them, as x
/// and x³ on −1, 0, 1, share a column.
#[derive(Debug)]
struct Stored {
    n_points: usize,
    /// Column of each monomial.
    columns: Vec<u32>,
    n_columns: usize,
    /// Block by block, column by column, point by point; the last block is padded with zeros.
    blocked: Vec<f64>,
    /// Point by point.
    by_point: Vec<f64>,
}

impl Stored {
    /// Of the points of a lattice with these indices.
    fn of(products: &Products, lattice: &Lattice, allowed: &[usize]) -> Self {
        let n_monomials = products.n_monomials();
        let mut values = vec![0.0; allowed.len() * n_monomials];
        for (row, &index) in values.chunks_exact_mut(n_monomials).zip(allowed) {
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
        Self { n_points: allowed.len(), columns, n_columns, blocked, by_point }
    }

    fn values(&self, coefficients: &[f64], folded: &mut Vec<f64>, values: &mut Vec<f64>) {
        folded.clear();
        folded.resize(self.n_columns, 0.0);
        for (&column, c) in self.columns.iter().zip(coefficients) {
            folded[column as usize] += c;
        }
        values.clear();
        values.resize(self.blocked.len() / self.n_columns, 0.0);
        combine(&self.blocked, folded, values);
        values.truncate(self.n_points);
    }

    fn moments(&self, weights: &[f64], folded: &mut Vec<f64>, moments: &mut [f64]) {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::Shape;
    use crate::{Forbidden, Model, Space};

    /// Of a quadratic in twelve factors 967 million numbers would be stored, in three copies.
    #[test]
    fn many_factors_are_not_stored() {
        for (k, is_stored) in [(7, true), (12, false)] {
            let space = Space::cube(k).expect("a cube");
            let Shape::Box(shape) = space.shape() else { unreachable!("a cube is a box") };
            let products = Products::of(&Model::quadratic(k).expect("a model"));
            let table = Table::of(&products, &Lattice::with_levels(shape, 3));
            assert_eq!(matches!(table.monomials, Monomials::Stored(_)), is_stored, "{k} factors");
            assert_eq!(table.n_points(), 3_usize.pow(k as u32));
        }
    }

    #[test]
    fn what_is_stored_and_what_is_computed_line_by_line_are_the_same() {
        let corner = Forbidden::new(vec![Some([0.2, 1.0]), None, Some([-1.0, -0.3])]).expect("a box");
        let cube = || Space::cube(3).expect("a cube");
        let products = Products::of(&Model::quadratic(3).expect("a model"));
        for space in [cube(), cube().forbid(vec![corner]).expect("a part")] {
            let Shape::Box(shape) = space.shape() else { unreachable!("a cube is a box") };
            let lattice = Lattice::with_levels(shape, 5);
            let number = |i: usize| ((i * i * 7919 + i * 31) % 2003) as f64 / 1001.0 - 1.0;
            let coefficients: Vec<f64> = (0..products.n_monomials()).map(number).collect();
            let of = |most: usize| {
                let table = Table::with_stored(&products, &lattice, most);
                let (mut scratch, mut values) = (Vec::new(), Vec::new());
                table.values(&coefficients, &mut scratch, &mut values);
                assert_eq!(values.len(), table.n_points(), "a value for each point");
                let weights: Vec<f64> = (0..values.len()).map(|i| number(i).abs()).collect();
                let mut moments = vec![f64::NAN; products.n_monomials()];
                table.moments(&weights, &mut scratch, &mut moments);
                (values, moments)
            };
            let (stored, nested) = (of(usize::MAX), of(0));
            let pairs = [(&stored.0, &nested.0), (&stored.1, &nested.1)];
            for (one, other) in pairs.into_iter().flat_map(|(one, other)| one.iter().zip(other)) {
                assert!((one - other).abs() < 1e-11, "{one} is not {other} over the {}", space.over());
            }
            assert_eq!((stored.0.len(), stored.1.len()), (nested.0.len(), nested.1.len()), "as many");
        }
    }
}
