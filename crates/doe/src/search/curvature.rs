//! Second derivatives of the heights of the maxima, for steps that converge quickly.
//!
//! With u = D r(z) and cₐ = (∂M/∂xₐ) u for every coordinate a of the free runs,
//!
//! ```text
//! ∂²v/∂xₐ∂x_b = 2 cₐ' D c_b − u' (∂²M/∂xₐ∂x_b) u
//! ∂²v/∂z∂xₐ   = −2 (∂r/∂z)' D cₐ
//! ∂²v/∂z²     = 2 (∂r/∂z)' D (∂r/∂z) + 2 Σ u_t ∂²r_t/∂z²
//! ```
//!
//! and where the maximum itself moves with the design, in the coordinates of z that no bound holds, its height has the
//! curvature v_xx − v_xz v_zz⁻¹ v_zx: the flatter v is there, the larger.

use multiversion::multiversion;

use super::runs::Regressors;
use crate::matrix::{axpy, cholesky, dot, multiply};

/// What the second derivatives are made from.
#[derive(Debug)]
pub(crate) struct Local<'a> {
    pub(crate) regressors: &'a Regressors,
    pub(crate) multiplicities: &'a [f64],
    /// Coordinates of the free runs.
    pub(crate) x: &'a [f64],
    /// Their regressors.
    pub(crate) rows: &'a [f64],
    /// M⁻¹.
    pub(crate) inverse: &'a [f64],
    /// Indices into x that count.
    pub(crate) free: &'a [usize],
}

/// A curvature of v at its maximum at least this fraction of v: less would be rounding.
const FLATTEST: f64 = 1e-3;

impl Local<'_> {
    /// H += weight · (second derivatives of the height of the maximum at z), n_free × n_free; z moves along the axes of
    /// `is_continuous`.
    pub(crate) fn add(&self, z: &[f64], is_continuous: impl Fn(usize) -> bool, weight: f64, hessian: &mut [f64]) {
        let moving: Vec<usize> = (0..z.len()).filter(|&j| is_continuous(j) && z[j].abs() < 1.0 - 1e-9).collect();
        self.add_moving(z, &moving, weight, FLATTEST, hessian);
    }

    /// As [`add`](Self::add) with the coordinates in which the maximum moves.
    fn add_moving(&self, z: &[f64], moving: &[usize], weight: f64, flattest: f64, hessian: &mut [f64]) {
        let (p, k, n) = (self.regressors.n_terms, self.regressors.n_factors, self.free.len());
        let mut at_z = vec![0.0; p];
        let mut u = vec![0.0; p];
        self.regressors.fill(z, &mut at_z);
        multiply(self.inverse, p, &at_z, &mut u);
        let height = dot(&at_z, &u);

        // ∂r/∂x of one coordinate of one run: slopes of each term, by unit vectors in place of u.
        let slope_of = |point: &[f64], factor: usize, out: &mut [f64]| {
            for (term, value) in out.iter_mut().enumerate() {
                *value = self.regressors.slope_of_term(term, point, factor);
            }
        };
        let (mut c, mut dc) = (vec![0.0; n * p], vec![0.0; n * p]);
        let mut slope = vec![0.0; p];
        let mut along = vec![0.0; n];
        for (row, &coordinate) in self.free.iter().enumerate() {
            let (run, factor) = (coordinate / k, coordinate % k);
            let regressor = &self.rows[run * p..run * p + p];
            slope_of(&self.x[run * k..run * k + k], factor, &mut slope);
            along[row] = dot(&slope, &u);
            let (reach, multiplicity) = (dot(regressor, &u), self.multiplicities[run]);
            let c = &mut c[row * p..row * p + p];
            axpy(multiplicity * reach, &slope, c);
            axpy(multiplicity * along[row], regressor, c);
            multiply(self.inverse, p, c, &mut dc[row * p..row * p + p]);
        }
        add_products(&dc, &c, p, 2.0 * weight, hessian);

        // −u' M'' u acts within a run only.
        for (a, &first) in self.free.iter().enumerate() {
            for (b, _) in self.free.iter().enumerate().filter(|&(_, &second)| second / k == first / k) {
                hessian[a * n + b] -= 2.0 * weight * self.multiplicities[first / k] * along[a] * along[b];
            }
        }
        let mut curvature = vec![0.0; k * k];
        let mut last = usize::MAX;
        for (a, &first) in self.free.iter().enumerate() {
            let run = first / k;
            if run != last {
                let reach = dot(&self.rows[run * p..run * p + p], &u);
                curvature.fill(0.0);
                let scale = -2.0 * weight * self.multiplicities[run] * reach;
                self.regressors.add_curvature(&self.x[run * k..run * k + k], &u, scale, &mut curvature);
                last = run;
            }
            for (b, &second) in self.free.iter().enumerate().filter(|&(_, &second)| second / k == run) {
                hessian[a * n + b] += curvature[first % k * k + second % k];
            }
        }

        // The maximum moves in its free coordinates.
        let q = moving.len();
        if q == 0 {
            return;
        }
        let mut slopes = vec![0.0; q * p];
        let mut d_slopes = vec![0.0; q * p];
        for (j, &factor) in moving.iter().enumerate() {
            slope_of(z, factor, &mut slopes[j * p..j * p + p]);
            multiply(self.inverse, p, &slopes[j * p..j * p + p], &mut d_slopes[j * p..j * p + p]);
        }
        curvature.fill(0.0);
        self.regressors.add_curvature(z, &u, 2.0, &mut curvature);
        let mut downward = vec![0.0; q * q];
        for (i, &first) in moving.iter().enumerate() {
            for (j, &second) in moving.iter().enumerate() {
                let product = 2.0 * dot(&slopes[i * p..i * p + p], &d_slopes[j * p..j * p + p]);
                downward[i * q + j] = -(product + curvature[first * k + second]);
            }
            downward[i * q + i] += flattest * height;
        }
        if cholesky(&mut downward, q, 1e-12).is_none() {
            return;
        }
        // Forward substitution: rows y with H += yᵀ y.
        let mut cross = vec![0.0; q * n];
        for j in 0..q {
            for a in 0..n {
                cross[j * n + a] = -2.0 * dot(&d_slopes[j * p..j * p + p], &c[a * p..a * p + p]);
            }
            let (above, from) = cross.split_at_mut(j * n);
            let row = &mut from[..n];
            for (i, earlier) in above.chunks_exact(n).enumerate() {
                axpy(-downward[j * q + i], earlier, row);
            }
            let scale = 1.0 / downward[j * q + j];
            row.iter_mut().for_each(|value| *value *= scale);
        }
        for row in cross.chunks_exact(n) {
            crate::matrix::add_outer(hessian, n, weight, row);
        }
    }
}

/// H += scale · A Bᵀ for rows of length p; A Bᵀ is symmetric.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx+avx2"))]
fn add_products(a: &[f64], b: &[f64], p: usize, scale: f64, hessian: &mut [f64]) {
    let n = a.len() / p;
    for i in 0..n {
        let row = &a[i * p..i * p + p];
        for j in 0..=i {
            let value = scale * dot(row, &b[j * p..j * p + p]);
            hessian[i * n + j] += value;
            if j < i {
                hessian[j * n + i] += value;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::polynomial;
    use crate::products::Products;
    use crate::search::frame::{Frame, Matrices};
    use crate::{Criterion, Model, PredictionVariance};
    use std::sync::Arc;

    /// What designs of eight runs in two factors are looked at by.
    fn frame_of(multiplicities: [f64; 8]) -> Frame {
        let model = Model::quadratic(2).expect("a model");
        Frame {
            criterion: Criterion::G,
            regressors: Regressors::of(&model),
            products: Arc::new(Products::of(&model)),
            fixed: vec![0.0; 36],
            multiplicities: multiplicities.to_vec(),
            moments: Vec::new(),
            least_log_determinant: f64::NEG_INFINITY,
            table: None,
        }
    }

    /// A few second derivatives of the highest v against central differences.
    fn assert_agrees_with_differences(hessian: &[f64], x: &[f64; 16], highest: impl Fn(&[f64]) -> f64) {
        let (step, value) = (1e-3, highest(x));
        for (a, b) in [(0, 0), (0, 1), (3, 3), (4, 9), (5, 5), (8, 12), (13, 15), (12, 12), (14, 15)] {
            let at = |da: f64, db: f64| {
                let mut moved = *x;
                moved[a] += da;
                moved[b] += db;
                highest(&moved)
            };
            let difference = if a == b {
                (at(step, 0.0) - 2.0 * value + at(-step, 0.0)) / (step * step)
            } else {
                (at(step, step) - at(step, -step) - at(-step, step) + at(-step, -step)) / (4.0 * step * step)
            };
            let exact = hessian[a * x.len() + b];
            assert!((difference - exact).abs() < 1e-3 * (1.0 + exact.abs()), "{a} {b}: {difference} is not {exact}");
        }
    }

    /// Highest v along the line through (·, z₂), and the matrices of a design.
    fn height(frame: &Frame, x: &[f64], second: f64) -> (f64, Vec<f64>, Vec<f64>, Vec<f64>) {
        let p = frame.n_terms();
        let mut rows = vec![0.0; p * frame.multiplicities.len()];
        let mut matrices = Matrices::new(p);
        frame.invert(x, &mut rows, &mut matrices).expect("not singular");
        let variance = PredictionVariance::with_products(frame.products.clone(), &matrices.inverse);
        let mut line = vec![0.0; 5];
        variance.along(&[0.0, second], 0, &mut line);
        let (at, value) = polynomial::maximum(&line, [-0.6, 0.6]);
        (value, vec![at, second], rows, matrices.inverse)
    }

    #[test]
    fn curvature_of_a_moving_maximum_agrees_with_differences() {
        let frame = frame_of([1.0, 1.0, 2.0, 1.0, 1.0, 1.0, 1.0, 1.0]);
        let x = [-0.9, -0.8, 0.95, -0.95, -1.0, 0.9, 0.9, 0.9, -0.95, 0.1, 0.9, 0.2, -0.1, -0.97, 0.05, 0.98];
        let (_, z, rows, inverse) = height(&frame, &x, 0.0);
        assert!(z[0].abs() < 0.5, "a maximum inside: {z:?}");
        let free: Vec<usize> = (0..x.len()).collect();
        let local = Local {
            regressors: &frame.regressors,
            multiplicities: &frame.multiplicities,
            x: &x,
            rows: &rows,
            inverse: &inverse,
            free: &free,
        };
        // The second coordinate is held, as by a bound: a value beyond 1 could not be used here, so only the first moves.
        let mut hessian = vec![0.0; free.len() * free.len()];
        local.add_moving(&z, &[0], 1.0, 0.0, &mut hessian);
        assert_agrees_with_differences(&hessian, &x, |x| height(&frame, x, 0.0).0);
    }

    /// Runs made twice predict with half the variance, whose curvature is half as large, too.
    #[test]
    fn curvature_of_a_doubled_design_is_half() {
        let x = [-0.9, -0.8, 0.95, -0.95, -1.0, 0.9, 0.9, 0.9, -0.95, 0.1, 0.9, 0.2, -0.1, -0.97, 0.05, 0.98];
        let hessian = |times: f64| {
            let frame = frame_of([times; 8]);
            let (_, z, rows, inverse) = height(&frame, &x, 0.0);
            let free: Vec<usize> = (0..x.len()).collect();
            let (regressors, multiplicities) = (&frame.regressors, &frame.multiplicities[..]);
            let local = Local { regressors, multiplicities, x: &x, rows: &rows, inverse: &inverse, free: &free };
            let mut hessian = vec![0.0; free.len() * free.len()];
            // In the second coordinate it is hardly curved: the least curvature counts.
            local.add(&[z[0], 0.3], |_| true, 1.0, &mut hessian);
            hessian
        };
        let (once, hundred) = (hessian(1.0), hessian(100.0));
        let size = once.iter().map(|h| h.abs()).fold(0.0, f64::max);
        for (one, other) in once.iter().zip(&hundred) {
            assert!((one - 100.0 * other).abs() < 1e-9 * size, "{one} and {other}");
        }
    }

    /// Eight runs around the center: near it a maximum moves in both coordinates.
    #[test]
    fn curvature_of_a_maximum_that_moves_in_two_coordinates_agrees_with_differences() {
        let x = [-1.0, -1.0, 1.0, -0.9, -0.8, 1.0, 1.0, 1.0, 0.2, -1.0, -0.1, 1.0, -1.0, 0.3, 1.0, 0.1];
        let frame = frame_of([1.0; 8]);
        let shape = crate::shape::BoxShape { axes: vec![crate::shape::Axis::Continuous; 2], forbidden: Vec::new() };
        let peak = |x: &[f64]| {
            let (_, _, rows, inverse) = height(&frame, x, 0.0);
            let variance = PredictionVariance::with_products(frame.products.clone(), &inverse);
            let (z, value) = crate::ascent::climb(&variance, &shape, &[0.0, 0.0]);
            (value, z, rows, inverse)
        };
        let (_, z, rows, inverse) = peak(&x);
        assert!(z.iter().all(|z| z.abs() < 0.3), "a maximum inside: {z:?}");
        let free: Vec<usize> = (0..x.len()).collect();
        let (regressors, multiplicities) = (&frame.regressors, &frame.multiplicities[..]);
        let local = Local { regressors, multiplicities, x: &x, rows: &rows, inverse: &inverse, free: &free };
        let mut hessian = vec![0.0; free.len() * free.len()];
        local.add_moving(&z, &[0, 1], 1.0, 0.0, &mut hessian);
        assert_agrees_with_differences(&hessian, &x, |x| peak(x).0);
    }
}
