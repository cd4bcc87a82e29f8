//! The monomials that products of two terms consist of.
//!
//! v(x) = r(x)' D r(x) is a polynomial; with its coefficients collected per monomial it costs a third of the
//! quadratic form, and along one axis it is a polynomial of one variable.

use crate::Model;

/// Exponents of every distinct product of two terms of a model.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Products {
    pub(crate) n_factors: usize,
    pub(crate) n_terms: usize,
    /// n_monomials × n_factors.
    exponents: Vec<u8>,
    /// Axis and exponent of every power above the zeroth, monomial after monomial.
    factors: Vec<(u8, u8)>,
    /// Where those of each monomial end.
    ends: Vec<usize>,
    /// Monomial of each pair (i, j ≥ i), row by row of the upper triangle.
    pairs: Vec<u32>,
    /// Largest exponent in any product.
    pub(crate) largest: usize,
}

impl Products {
    pub(crate) fn of(model: &Model) -> Self {
        let mut found = std::collections::HashMap::new();
        let mut exponents = Vec::new();
        let mut pairs = Vec::new();
        for (i, a) in model.terms().iter().enumerate() {
            for b in &model.terms()[i..] {
                let sum: Vec<u8> = a.exponents().iter().zip(b.exponents()).map(|(x, y)| x + y).collect();
                let next = found.len() as u32;
                let index = *found.entry(sum.clone()).or_insert(next);
                if index == next {
                    exponents.extend(sum);
                }
                pairs.push(index);
            }
        }
        let largest = exponents.iter().copied().max().map_or(0, usize::from);
        let (mut factors, mut ends) = (Vec::new(), Vec::new());
        for exponents in exponents.chunks_exact(model.n_factors()) {
            factors.extend((0..).zip(exponents).filter(|(_, exponent)| **exponent > 0).map(|(axis, &e)| (axis, e)));
            ends.push(factors.len());
        }
        Self { n_factors: model.n_factors(), n_terms: model.n_terms(), exponents, factors, ends, pairs, largest }
    }

    /// Whether v is convex along an axis, with its maxima at the ends: where every term is linear in that factor, v is the
    /// square of a norm of a linear function of it.
    pub(crate) fn is_convex_along(&self, axis: usize) -> bool {
        self.monomials().all(|exponents| exponents[axis] <= 2)
    }

    pub(crate) fn n_monomials(&self) -> usize {
        self.exponents.len() / self.n_factors
    }

    pub(crate) fn monomials(&self) -> std::slice::ChunksExact<'_, u8> {
        self.exponents.chunks_exact(self.n_factors)
    }

    /// Axis and exponent of every power above the zeroth, monomial after monomial, and where those of each end.
    pub(crate) fn sparse(&self) -> (&[(u8, u8)], &[usize]) {
        (&self.factors, &self.ends)
    }

    /// For every monomial axis and exponent of its powers above the zeroth.
    pub(crate) fn powers(&self) -> impl Iterator<Item = &[(u8, u8)]> {
        let mut begin = 0;
        self.ends.iter().map(move |&end| {
            let powers = &self.factors[begin..end];
            begin = end;
            powers
        })
    }

    /// Coefficients of x ↦ r(x)' D r(x) for a symmetric p × p matrix D.
    pub(crate) fn collect(&self, matrix: &[f64], coefficients: &mut [f64]) {
        coefficients.fill(0.0);
        let mut pair = 0;
        for (i, row) in matrix.chunks_exact(self.n_terms).enumerate() {
            coefficients[self.pairs[pair] as usize] += row[i];
            for (offset, value) in row[i + 1..].iter().enumerate() {
                coefficients[self.pairs[pair + 1 + offset] as usize] += 2.0 * value;
            }
            pair += self.n_terms - i;
        }
    }

    /// The symmetric matrix Σ w r r', full, from the moments Σ w x^e of every monomial.
    pub(crate) fn spread(&self, moments: &[f64], matrix: &mut [f64]) {
        let p = self.n_terms;
        let mut pair = 0;
        for i in 0..p {
            for j in i..p {
                let value = moments[self.pairs[pair] as usize];
                matrix[i * p + j] = value;
                matrix[j * p + i] = value;
                pair += 1;
            }
        }
    }

    /// Every monomial at a point.
    pub(crate) fn fill(&self, point: &[f64], values: &mut [f64]) {
        for (value, exponents) in values.iter_mut().zip(self.monomials()) {
            let mut product = 1.0;
            for (&exponent, &x) in exponents.iter().zip(point) {
                for _ in 0..exponent {
                    product *= x;
                }
            }
            *value = product;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Convex along a factor that enters by its first power alone.
    #[test]
    fn variance_is_convex_along_factors_without_squares() {
        let terms = [[0, 0], [1, 0], [0, 1], [1, 1], [0, 2]].map(design_space::Term::new).to_vec();
        let products = Products::of(&Model::new(2, terms).unwrap());
        assert!(products.is_convex_along(0) && !products.is_convex_along(1), "only the second has a square");
    }
}
