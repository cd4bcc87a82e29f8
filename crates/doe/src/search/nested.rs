//! v on a whole grid at a few operations a point.
//!
//! With one coordinate fixed a polynomial in K coordinates becomes one in K − 1 with fewer monomials: 70, 35, 15, 5 for
//! the quadratic model in four factors. Fixing them axis by axis leaves one polynomial a line, so a point costs what
//! its place on the line costs, four products and sums, and the line is computed side by side.

use std::collections::HashMap;

use multiversion::multiversion;

use crate::products::Products;

/// A grid prepared for evaluating the polynomials of a model.
#[derive(Debug)]
pub(crate) struct Nested {
    pub(crate) levels: Vec<Vec<f64>>,
    /// For every axis but the last, what fixing its coordinate makes of each monomial.
    steps: Vec<Step>,
    /// Exponents of the monomials left on a line.
    last: Vec<usize>,
    /// One more than the largest exponent.
    n_powers: usize,
}

#[derive(Debug)]
struct Step {
    n_left: usize,
    /// Monomial that is left, and the power that multiplies it.
    targets: Vec<(usize, usize)>,
    /// Powers of every level, level by level.
    powers: Vec<f64>,
}

impl Nested {
    pub(crate) fn of(products: &Products, levels: Vec<Vec<f64>>) -> Self {
        let n_powers = products.largest + 1;
        let mut monomials: Vec<Vec<u8>> = products.monomials().map(<[u8]>::to_vec).collect();
        let steps = levels[..levels.len() - 1].iter().map(|levels| {
            let mut left: Vec<Vec<u8>> = Vec::new();
            let mut found = HashMap::new();
            let target = |exponents: &Vec<u8>| {
                let rest = exponents[1..].to_vec();
                let index = *found.entry(rest.clone()).or_insert(left.len());
                if index == left.len() {
                    left.push(rest);
                }
                (index, usize::from(exponents[0]))
            };
            let targets = monomials.iter().map(target).collect();
            monomials = left;
            let powers = levels.iter().flat_map(|&x| (0..n_powers).map(move |e| x.powi(e as i32))).collect();
            Step { n_left: monomials.len(), targets, powers }
        });
        let steps = steps.collect();
        let last = monomials.iter().map(|exponents| usize::from(exponents[0])).collect();
        Self { levels, steps, last, n_powers }
    }

    pub(crate) fn n_points(&self) -> usize {
        self.levels.iter().map(Vec::len).product()
    }

    /// The polynomial with these coefficients at every point, the last axis fastest.
    pub(crate) fn values(&self, coefficients: &[f64], values: &mut Vec<f64>) {
        values.resize(self.n_points(), 0.0);
        let mut scratch: Vec<Vec<f64>> = self.steps.iter().map(|step| vec![0.0; step.n_left]).collect();
        let mut line = vec![0.0; self.n_powers];
        self.fill(0, coefficients, &mut scratch, &mut line, values);
    }

    /// As [`values`](Self::values), at most `most` at a time where a line is no longer: `visit` gets the index of the first
    /// point and the values from there on.
    pub(crate) fn parts(&self, coefficients: &[f64], most: usize, mut visit: impl FnMut(usize, &[f64])) {
        let mut scratch: Vec<Vec<f64>> = self.steps.iter().map(|step| vec![0.0; step.n_left]).collect();
        self.visit_parts((0, 0), most, coefficients, &mut scratch, &mut visit);
    }

    fn visit_parts(
        &self,
        (axis, first): (usize, usize),
        most: usize,
        coefficients: &[f64],
        scratch: &mut [Vec<f64>],
        visit: &mut impl FnMut(usize, &[f64]),
    ) {
        let n_points: usize = self.levels[axis..].iter().map(Vec::len).product();
        let (Some(step), true) = (self.steps.get(axis), n_points > most) else {
            let (mut line, mut values) = (vec![0.0; self.n_powers], vec![0.0; n_points]);
            self.fill(axis, coefficients, scratch, &mut line, &mut values);
            return visit(first, &values);
        };
        let Some((left, deeper)) = scratch.split_first_mut() else { return };
        let part = n_points / self.levels[axis].len();
        for (index, powers) in step.powers.chunks_exact(self.n_powers).enumerate() {
            left.fill(0.0);
            for (&(target, power), c) in step.targets.iter().zip(coefficients) {
                left[target] += c * powers[power];
            }
            self.visit_parts((axis + 1, first + index * part), most, left, deeper, visit);
        }
    }

    fn fill(&self, axis: usize, coefficients: &[f64], scratch: &mut [Vec<f64>], line: &mut [f64], values: &mut [f64]) {
        let (Some(step), Some((left, deeper))) = (self.steps.get(axis), scratch.split_first_mut()) else {
            line.fill(0.0);
            for (&exponent, c) in self.last.iter().zip(coefficients) {
                line[exponent] += c;
            }
            along(line, &self.levels[axis], values);
            return;
        };
        let part = values.len() / self.levels[axis].len();
        for (powers, values) in step.powers.chunks_exact(self.n_powers).zip(values.chunks_exact_mut(part)) {
            left.fill(0.0);
            for (&(target, power), c) in step.targets.iter().zip(coefficients) {
                left[target] += c * powers[power];
            }
            self.fill(axis + 1, left, deeper, line, values);
        }
    }
}

/// A polynomial of one variable at many places.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx+avx2"))]
fn along(coefficients: &[f64], places: &[f64], values: &mut [f64]) {
    values.fill(0.0);
    for c in coefficients.iter().rev() {
        for (value, x) in values.iter_mut().zip(places) {
            *value = *value * x + c;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Design, Model, PredictionVariance, Term};
    use std::sync::Arc;

    #[test]
    fn agrees_with_the_polynomial_point_by_point() {
        let cubic = Model::new(1, (0..4).map(|e| Term::new(vec![e])).collect()).expect("a model");
        let models = [cubic, Model::quadratic(2).expect("a model"), Model::quadratic(3).expect("a model")];
        for (model, seed) in models.into_iter().zip(1..) {
            let k = model.n_factors();
            let number = |i: usize| ((i * i * 7919 + i * 31 + seed * 104_729) % 2003) as f64 / 1001.0 - 1.0;
            let runs: Vec<f64> = (0..k * 14).map(number).collect();
            let design = Design::new(k, runs).expect("a design");
            let variance = PredictionVariance::of(&model, &design).expect("not singular");
            let levels: Vec<Vec<f64>> = (0..k).map(|j| (0..j + 3).map(|i| number(i + 3 * j)).collect()).collect();
            let nested = Nested::of(&Arc::new(Products::of(&model)), levels.clone());
            let mut values = Vec::new();
            nested.values(variance.coefficients(), &mut values);
            let lattice = crate::lattice::Lattice::new(levels);
            assert_eq!(values.len(), lattice.n_points());
            for (index, value) in values.iter().enumerate() {
                let expected = variance.value(&lattice.point(index));
                assert!((value - expected).abs() < 1e-10 * expected.abs().max(1.0), "{index}: {value} {expected}");
            }
        }
    }
}
