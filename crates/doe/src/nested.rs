//! v on a whole grid at a few operations a point, and the moments of weights on it.
//!
//! With one coordinate fixed a polynomial in K coordinates becomes one in K − 1 with fewer monomials: 70, 35, 15, 5 for
//! the quadratic model in four factors. Fixing them axis by axis leaves one polynomial a line, so a point costs what
//! its place on the line costs, four products and sums, and the line is computed side by side. The moments are the transpose:
//! sums along each line first, and from there axis by axis back to the monomials.

use std::collections::HashMap;

use multiversion::multiversion;

use crate::power::power;
use crate::products::Products;

/// Points times monomials beyond which a grid is computed axis by axis wherever something else is quicker below: stored they
/// would take 256 MB a copy, and point by point the time of a whole search.
pub(crate) const MOST_STORED: usize = 1 << 25;

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
            let powers = levels.iter().flat_map(|&x| (0..n_powers as u32).map(move |e| power(x, e))).collect();
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

    /// Σ w x^e over all points for every monomial.
    pub(crate) fn moments(&self, weights: &[f64], moments: &mut [f64]) {
        let mut scratch: Vec<Vec<f64>> = self.steps.iter().map(|step| vec![0.0; step.n_left]).collect();
        let mut line = vec![0.0; self.n_powers];
        self.gather(0, weights, &mut scratch, &mut line, moments);
    }

    fn gather(&self, axis: usize, weights: &[f64], scratch: &mut [Vec<f64>], line: &mut [f64], moments: &mut [f64]) {
        let (Some(step), Some((left, deeper))) = (self.steps.get(axis), scratch.split_first_mut()) else {
            line.fill(0.0);
            for (weight, x) in weights.iter().zip(&self.levels[axis]) {
                let mut power = *weight;
                for sum in line.iter_mut() {
                    *sum += power;
                    power *= x;
                }
            }
            for (moment, &exponent) in moments.iter_mut().zip(&self.last) {
                *moment = line[exponent];
            }
            return;
        };
        moments.fill(0.0);
        let part = weights.len() / self.levels[axis].len();
        for (powers, weights) in step.powers.chunks_exact(self.n_powers).zip(weights.chunks_exact(part)) {
            self.gather(axis + 1, weights, deeper, line, left);
            for (moment, &(target, power)) in moments.iter_mut().zip(&step.targets) {
                *moment += left[target] * powers[power];
            }
        }
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
    fn values_and_moments_agree_with_the_polynomial_point_by_point() {
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
            assert_eq!(values.len(), levels.iter().map(Vec::len).product::<usize>());
            // The last coordinate varies fastest.
            let point = |index: usize| {
                let mut rest = index;
                let mut point: Vec<f64> = levels
                    .iter()
                    .rev()
                    .map(|levels| {
                        let digit = rest % levels.len();
                        rest /= levels.len();
                        levels[digit]
                    })
                    .collect();
                point.reverse();
                point
            };
            for (index, value) in values.iter().enumerate() {
                let expected = variance.value(&point(index));
                assert!((value - expected).abs() < 1e-10 * expected.abs().max(1.0), "{index}: {value} {expected}");
            }
            let products = Products::of(&model);
            let weights: Vec<f64> = (0..values.len()).map(|i| number(7 * i + 1)).collect();
            let (mut moments, mut monomials) =
                (vec![f64::NAN; products.n_monomials()], vec![0.0; products.n_monomials()]);
            nested.moments(&weights, &mut moments);
            let mut expected = vec![0.0; products.n_monomials()];
            for (index, weight) in weights.iter().enumerate() {
                products.fill(&point(index), &mut monomials);
                expected.iter_mut().zip(&monomials).for_each(|(sum, value)| *sum += weight * value);
            }
            for (moment, expected) in moments.iter().zip(expected) {
                assert!((moment - expected).abs() < 1e-10 * expected.abs().max(1.0), "{moment} is not {expected}");
            }
        }
    }
}
