//! Kernels for small symmetric matrices as row-major slices: up to a few dozen rows they beat a general library,
//! whose calls cost more than the arithmetic.

/// Dot product with eight partial sums in a fixed order, so that it vectorizes and gives the same bits everywhere.
#[inline(always)]
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len().min(b.len());
    let (a, b) = (&a[..n], &b[..n]);
    let mut sums = [0.0; 8];
    let (a_blocks, b_blocks) = (a.chunks_exact(8), b.chunks_exact(8));
    let tail: f64 = a_blocks.remainder().iter().zip(b_blocks.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in a_blocks.zip(b_blocks) {
        for lane in 0..8 {
            sums[lane] += x[lane] * y[lane];
        }
    }
    ((sums[0] + sums[4]) + (sums[1] + sums[5])) + ((sums[2] + sums[6]) + (sums[3] + sums[7])) + tail
}

/// y += a x.
#[inline(always)]
pub(crate) fn axpy(a: f64, x: &[f64], y: &mut [f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += a * x;
    }
}

/// Lower Cholesky factor of a p × p matrix in place (the upper triangle is left alone) and log |A|; none unless
/// every pivot is above `floor` times its diagonal element.
#[inline(always)]
pub(crate) fn cholesky(a: &mut [f64], p: usize, floor: f64) -> Option<f64> {
    cholesky_rows(a, p, 0..p, floor)
}

/// Some rows of the factor, those above them known, and their part of log |A|.
#[inline(always)]
pub(crate) fn cholesky_rows(a: &mut [f64], p: usize, rows: std::ops::Range<usize>, floor: f64) -> Option<f64> {
    let mut log_determinant = 0.0;
    for j in rows {
        let (above, from) = a.split_at_mut(j * p);
        let row = &mut from[..p];
        let diagonal = row[j];
        for k in 0..j {
            let other = &above[k * p..k * p + p];
            let sum = dot(&row[..k], &other[..k]);
            row[k] = (row[k] - sum) / other[k];
        }
        let pivot = diagonal - dot(&row[..j], &row[..j]);
        // NaN is not above anything.
        if pivot.is_nan() || pivot <= floor * diagonal || pivot <= 0.0 {
            return None;
        }
        log_determinant += pivot.ln();
        row[j] = pivot.sqrt();
    }
    Some(log_determinant)
}

/// Inverse from a lower Cholesky factor L, full and symmetric: A⁻¹ = L⁻ᵀ L⁻¹. `scratch` holds p × p values.
#[inline(always)]
pub(crate) fn inverse_of_factor(factor: &[f64], p: usize, inverse: &mut [f64], scratch: &mut [f64]) {
    // Row j of L⁻¹ from the rows above it.
    for j in 0..p {
        let (above, from) = scratch.split_at_mut(j * p);
        let row = &mut from[..p];
        row.fill(0.0);
        for k in 0..j {
            axpy(-factor[j * p + k], &above[k * p..k * p + k + 1], &mut row[..k + 1]);
        }
        let scale = 1.0 / factor[j * p + j];
        for value in &mut row[..j] {
            *value *= scale;
        }
        row[j] = scale;
    }
    inverse[..p * p].fill(0.0);
    for k in 0..p {
        let row = &scratch[k * p..k * p + k + 1];
        for i in 0..=k {
            axpy(row[i], row, &mut inverse[i * p..i * p + k + 1]);
        }
    }
}

/// out = A x for a p × p matrix.
#[inline(always)]
pub(crate) fn multiply(a: &[f64], p: usize, x: &[f64], out: &mut [f64]) {
    for (value, row) in out.iter_mut().zip(a.chunks_exact(p)) {
        *value = dot(row, x);
    }
}

/// out = A B for p × p matrices.
#[inline(always)]
pub(crate) fn product(a: &[f64], b: &[f64], p: usize, out: &mut [f64]) {
    out[..p * p].fill(0.0);
    for i in 0..p {
        let row = &mut out[i * p..i * p + p];
        for k in 0..p {
            axpy(a[i * p + k], &b[k * p..k * p + p], row);
        }
    }
}

/// A += w x xᵀ, all of the matrix.
#[inline(always)]
pub(crate) fn add_outer(a: &mut [f64], p: usize, weight: f64, x: &[f64]) {
    for (row, &value) in a.chunks_exact_mut(p).zip(x) {
        axpy(weight * value, x, row);
    }
}

/// Eigenvalues of a symmetric matrix, rising.
pub(crate) fn eigenvalues(a: &[f64], p: usize) -> Option<Vec<f64>> {
    let matrix = faer::Mat::from_fn(p, p, |i, j| a[i * p + j]);
    matrix.self_adjoint_eigenvalues(faer::Side::Lower).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factor_and_inverse_undo_each_other() {
        // The Hilbert matrix of order 5 has a known inverse with whole-number entries.
        let p = 5;
        let hilbert: Vec<f64> = (0..p * p).map(|at| 1.0 / (at / p + at % p + 1) as f64).collect();
        let mut factor = hilbert.clone();
        let log_determinant = cholesky(&mut factor, p, 0.0).expect("positive definite");
        assert!((log_determinant - 3.749_295_132_5e-12_f64.ln()).abs() < 1e-6, "det of the Hilbert matrix");
        let (mut inverse, mut scratch) = (vec![0.0; p * p], vec![0.0; p * p]);
        inverse_of_factor(&factor, p, &mut inverse, &mut scratch);
        for (at, expected) in [(0, 25.0), (1, -300.0), (5, -300.0), (12, 79_380.0), (24, 44_100.0)] {
            assert!((inverse[at] / expected - 1.0).abs() < 1e-9, "{} is not {expected}", inverse[at]);
        }
    }

    #[test]
    fn a_singular_matrix_has_no_factor() {
        assert_eq!(cholesky(&mut [1.0, 2.0, 2.0, 4.0], 2, 1e-12), None);
        assert_eq!(cholesky(&mut [1.0, f64::NAN, f64::NAN, 4.0], 2, 0.0), None);
    }

    #[test]
    fn dot_products_count_every_element_once() {
        for n in 0..40 {
            let a: Vec<f64> = (0..n).map(f64::from).collect();
            let expected = (0..n).map(|i| f64::from(i * i)).sum::<f64>();
            assert!((dot(&a, &a) - expected).abs() < 1e-9, "{n}");
        }
    }
}
