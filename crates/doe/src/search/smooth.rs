//! Criteria as smooth functions of the coordinates of the free runs.
//!
//! With M = R'R, D = M⁻¹, every criterion φ(M) has ∂φ/∂rᵢ = −2 S rᵢ with S = −∂φ/∂M:
//!
//! | | φ | S |
//! |---|---|---|
//! | D | −log det(M) / p | D / p |
//! | A | log tr D | D² / tr D |
//! | I | log tr(B D) | D B D / tr(B D) |
//! | E | log(tr D^q) / q | D^(q+1) / tr D^q |
//! | T | −log tr M + c δ² | 1 / tr M + 2 c δ D / p, δ = what log det(M) / p is below the least |
//! | G | log(Σ v^q) / q over a lattice | D W D, W = Σ w r r', w = v^(q−1) / Σ v^q |
//!
//! G and E tend to the logarithm of their criterion as q grows.

use multiversion::multiversion;

use super::bounded::Objective;
use super::frame::{Frame, Matrices};
use crate::Criterion;
use crate::matrix::{multiply, product};

/// S = D X D for G and I.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx+avx2"))]
fn sandwich(inverse: &[f64], middle: &[f64], p: usize, scratch: &mut [f64], out: &mut [f64]) {
    product(inverse, middle, p, scratch);
    product(scratch, inverse, p, out);
}

#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx+avx2"))]
fn square(a: &[f64], p: usize, out: &mut [f64]) {
    product(a, a, p, out);
}

#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx+avx2"))]
fn apply(a: &[f64], p: usize, x: &[f64], out: &mut [f64]) {
    multiply(a, p, x, out);
}

/// Weight of the square of what the determinant lacks, for T.
const PENALTY: f64 = 100.0;
/// The penalty begins so much above the least, so that its balance with the trace is not below it.
pub(crate) const MARGIN: f64 = 0.02;

/// A smoothed criterion as a function of the coordinates of the free runs, run by run.
#[derive(Debug)]
pub(crate) struct Smooth<'a> {
    frame: &'a Frame,
    /// Exponent of G and E: 2 to this.
    log_q: u32,
    rows: Vec<f64>,
    matrices: Matrices,
    steepness: Vec<f64>,
    middle: Vec<f64>,
    scratch: Vec<f64>,
    coefficients: Vec<f64>,
    folded: Vec<f64>,
    values: Vec<f64>,
    weights: Vec<f64>,
    product: Vec<f64>,
}

impl<'a> Smooth<'a> {
    pub(crate) fn new(frame: &'a Frame, log_q: u32) -> Self {
        let (p, n) = (frame.n_terms(), frame.multiplicities.len());
        Self {
            frame,
            log_q,
            rows: vec![0.0; n * p],
            matrices: Matrices::new(p),
            steepness: vec![0.0; p * p],
            middle: vec![0.0; p * p],
            scratch: vec![0.0; p * p],
            coefficients: vec![0.0; frame.products.n_monomials()],
            folded: Vec::new(),
            values: Vec::new(),
            weights: Vec::new(),
            product: vec![0.0; p],
        }
    }

    pub(crate) fn set_log_q(&mut self, log_q: u32) {
        self.log_q = log_q;
    }

    /// φ, and S into `steepness`.
    fn value_and_steepness(&mut self, log_determinant: f64) -> f64 {
        let p = self.frame.n_terms();
        let trace = |matrix: &[f64]| matrix.iter().step_by(p + 1).sum::<f64>();
        let inverse = &self.matrices.inverse;
        match self.frame.criterion {
            Criterion::D => {
                self.steepness.iter_mut().zip(inverse).for_each(|(s, d)| *s = d / p as f64);
                -log_determinant / p as f64
            }
            Criterion::A => {
                let value = trace(inverse);
                square(inverse, p, &mut self.steepness);
                self.steepness.iter_mut().for_each(|s| *s /= value);
                value.ln()
            }
            Criterion::I => {
                let value: f64 = self.frame.moments.iter().zip(inverse).map(|(b, d)| b * d).sum();
                sandwich(inverse, &self.frame.moments, p, &mut self.scratch, &mut self.steepness);
                self.steepness.iter_mut().for_each(|s| *s /= value);
                value.ln()
            }
            Criterion::T => {
                let value = trace(&self.matrices.information);
                self.steepness.fill(0.0);
                self.steepness.iter_mut().step_by(p + 1).for_each(|s| *s = 1.0 / value);
                let below = (self.frame.least_log_determinant + MARGIN - log_determinant / p as f64).max(0.0);
                let slope = 2.0 * PENALTY * below / p as f64;
                self.steepness.iter_mut().zip(inverse).for_each(|(s, d)| *s += slope * d);
                PENALTY * below * below - value.ln()
            }
            Criterion::E => {
                // D^q by squaring, scaled to stay finite.
                let scale = trace(inverse);
                self.middle.iter_mut().zip(inverse).for_each(|(m, d)| *m = d / scale);
                let mut log_scale = 0.0;
                for _ in 0..self.log_q {
                    square(&self.middle, p, &mut self.scratch);
                    let size = trace(&self.scratch);
                    log_scale = 2.0 * log_scale + size.ln();
                    self.middle.iter_mut().zip(&self.scratch).for_each(|(m, s)| *m = s / size);
                }
                let q = f64::from(1 << self.log_q);
                let size = trace(&self.middle);
                product(&self.middle, inverse, p, &mut self.steepness);
                self.steepness.iter_mut().for_each(|s| *s /= size);
                scale.ln() + (log_scale + size.ln()) / q
            }
            Criterion::G => self.worst_prediction(),
        }
    }

    fn worst_prediction(&mut self) -> f64 {
        let (p, frame) = (self.frame.n_terms(), self.frame);
        let Some(table) = &frame.table else {
            return f64::INFINITY;
        };
        frame.products.collect(&self.matrices.inverse, &mut self.coefficients);
        table.values(&self.coefficients, &mut self.folded, &mut self.values);
        let highest = self.values.iter().copied().fold(0.0, f64::max);
        if highest <= 0.0 || !highest.is_finite() {
            return f64::INFINITY;
        }
        let sum = powers(&self.values, highest, self.log_q, &mut self.weights);
        let scale = 1.0 / (sum * highest);
        self.weights.iter_mut().for_each(|w| *w *= scale);
        table.moments(&self.weights, &mut self.folded, &mut self.coefficients);
        frame.products.spread(&self.coefficients, &mut self.middle);
        sandwich(&self.matrices.inverse, &self.middle, p, &mut self.scratch, &mut self.steepness);
        highest.ln() + sum.ln() / f64::from(1 << self.log_q)
    }
}

/// (v / highest)^(q − 1) into `weights`, and the sum of (v / highest)^q.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx+avx2"))]
fn powers(values: &[f64], highest: f64, log_q: u32, weights: &mut Vec<f64>) -> f64 {
    let scale = 1.0 / highest;
    weights.clear();
    weights.extend(values.iter().map(|v| v * scale));
    for _ in 0..log_q {
        for w in weights.iter_mut() {
            *w *= *w;
        }
    }
    let sum = weights.iter().sum();
    for (w, v) in weights.iter_mut().zip(values) {
        *w *= highest / v;
    }
    sum
}

impl Objective for Smooth<'_> {
    fn evaluate(&mut self, x: &[f64], gradient: &mut [f64]) -> f64 {
        let Some(log_determinant) = self.frame.invert(x, &mut self.rows, &mut self.matrices) else {
            return f64::INFINITY;
        };
        let value = self.value_and_steepness(log_determinant);
        if !value.is_finite() {
            return f64::INFINITY;
        }
        let (p, k) = (self.frame.n_terms(), self.frame.n_factors());
        gradient.fill(0.0);
        let runs = self.rows.chunks_exact(p).zip(x.chunks_exact(k)).zip(&self.frame.multiplicities);
        for (((row, point), multiplicity), slopes) in runs.zip(gradient.chunks_exact_mut(k)) {
            apply(&self.steepness, p, row, &mut self.product);
            self.frame.regressors.add_slopes(point, &self.product, -2.0 * multiplicity, slopes);
        }
        value
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::lattice::Lattice;
    use crate::products::Products;
    use crate::search::runs::Regressors;
    use crate::search::table::Table;
    use crate::shape::Shape;
    use crate::{Model, Space, moment_matrix};

    fn frame(criterion: Criterion) -> Frame {
        let model = Model::quadratic(2).expect("a model");
        let space = Space::cube(2).expect("a cube");
        let products = Arc::new(Products::of(&model));
        let Shape::Box(shape) = space.shape() else { unreachable!("a cube is a box") };
        let table = Table::of(&products, &Lattice::with_levels(shape, 5));
        Frame {
            criterion,
            regressors: Regressors::of(&model),
            products,
            fixed: vec![0.0; 36],
            multiplicities: vec![1.0, 1.0, 2.0, 1.0, 1.0, 1.0, 1.0],
            moments: moment_matrix(&model, &space).expect("moments"),
            least_log_determinant: 1.0,
            table: Some(table),
        }
    }

    #[test]
    fn slopes_agree_with_central_differences() {
        let x = [-0.9, -0.8, 0.1, -0.95, 0.85, -0.7, -0.9, 0.1, 0.05, 0.15, 0.9, 0.2, -0.3, 0.97];
        for criterion in Criterion::ALL {
            let frame = frame(criterion);
            let mut smooth = Smooth::new(&frame, 5);
            let mut gradient = vec![0.0; x.len()];
            let mut unused = gradient.clone();
            smooth.evaluate(&x, &mut gradient);
            for i in 0..x.len() {
                let step = 1e-6;
                let mut at = |offset: f64| {
                    let mut moved = x;
                    moved[i] += offset;
                    smooth.evaluate(&moved, &mut unused)
                };
                let difference = (at(step) - at(-step)) / (2.0 * step);
                assert!(
                    (difference - gradient[i]).abs() < 1e-7,
                    "{criterion} {i}: {difference} is not {}",
                    gradient[i]
                );
            }
        }
    }
}
