//! Eigenmodes of a linear system: frequency, damping, and which states take part.

use nalgebra::{Complex, DMatrix, DVector, Schur};

use crate::error::Error;

/// One mode; a conjugate pair counts once, with the positive imaginary part.
#[derive(Clone, Debug, PartialEq)]
pub struct Mode {
    /// The eigenvalue, in 1/s.
    pub eigenvalue: Complex<f64>,
    /// Share of each state in the mode, summing to 1; `None` where eigenvectors do not span the space, so that
    /// shares are not defined. Modes with the same eigenvalue share its states in no particular way: add theirs up.
    pub participation: Option<Vec<f64>>,
}

impl Mode {
    /// Natural frequency |lambda| in rad/s.
    #[must_use]
    pub fn natural_frequency_rad_s(&self) -> f64 {
        self.eigenvalue.norm()
    }

    /// Damping ratio −Re(lambda)/|lambda|; 1 for a decay without oscillation, negative when unstable, 0 at 0.
    #[must_use]
    pub fn damping_ratio(&self) -> f64 {
        let norm = self.eigenvalue.norm();
        if norm > 0.0 { -self.eigenvalue.re / norm } else { 0.0 }
    }

    /// Whether a disturbance grows.
    #[must_use]
    pub fn is_unstable(&self) -> bool {
        self.eigenvalue.re > 0.0
    }

    /// Sum of the shares of `states`, by index.
    #[must_use]
    pub fn share_of(&self, states: &[usize]) -> Option<f64> {
        self.participation.as_ref().map(|shares| states.iter().filter_map(|k| shares.get(*k)).sum())
    }
}

/// The modes of a matrix, slowest decay first.
#[derive(Clone, Debug, PartialEq)]
pub struct Modes {
    /// The modes, by decreasing real part.
    pub modes: Vec<Mode>,
}

impl Modes {
    /// Whether every disturbance decays.
    #[must_use]
    pub fn is_stable(&self) -> bool {
        self.modes.iter().all(|mode| mode.eigenvalue.re < 0.0)
    }
}

/// Sweeps of the QR algorithm before giving up.
const MAX_SWEEPS: usize = 10_000;
/// Largest part of the matrix's largest entry that an eigenvector may leave over.
const MAX_RESIDUAL: f64 = 1e-8;
/// Largest entry of the inverse of the unit eigenvectors up to which shares are reported.
const MAX_CONDITION: f64 = 1e7;

/// Eigenmodes of the square matrix `a` (units 1/s), with participation factors `|v_k w_k|` from right and left
/// eigenvectors, normalized to sum to 1.
///
/// # Errors
/// [`Error::Eigenvalues`] when `a` is empty, not square or not finite, or the iteration does not converge.
pub fn modes(a: &DMatrix<f64>) -> Result<Modes, Error> {
    let size = a.nrows();
    let failed = Error::Eigenvalues { size };
    if size == 0 || !a.is_square() || a.iter().any(|entry| !entry.is_finite()) {
        return Err(failed);
    }
    let schur = Schur::try_new(a.clone(), f64::EPSILON, MAX_SWEEPS).ok_or(failed)?;
    let eigenvalues = schur.complex_eigenvalues();
    let participation = participation(a, &eigenvalues);
    let mut modes: Vec<Mode> = eigenvalues
        .iter()
        .enumerate()
        .filter(|(_, eigenvalue)| eigenvalue.im >= 0.0)
        .map(|(k, eigenvalue)| Mode {
            eigenvalue: *eigenvalue,
            participation: participation.as_ref().map(|columns| columns[k].clone()),
        })
        .collect();
    modes.sort_by(|a, b| b.eigenvalue.re.total_cmp(&a.eigenvalue.re).then(a.eigenvalue.im.total_cmp(&b.eigenvalue.im)));
    Ok(Modes { modes })
}

/// Shares of the states per eigenvalue, or `None` when the eigenvectors are too close to dependent.
fn participation(a: &DMatrix<f64>, eigenvalues: &DVector<Complex<f64>>) -> Option<Vec<Vec<f64>>> {
    let size = a.nrows();
    let complex = a.map(|entry| Complex::new(entry, 0.0));
    let scale = if a.amax() > 0.0 { a.amax() } else { 1.0 };
    let mut right = DMatrix::<Complex<f64>>::zeros(size, size);
    for (k, eigenvalue) in eigenvalues.iter().enumerate() {
        // Inverse iteration a hair beside the eigenvalue; equal eigenvalues get orthogonal vectors.
        let shift = *eigenvalue + Complex::new(scale * 1e-13, scale * 1e-13);
        let lu = (&complex - DMatrix::identity(size, size) * shift).lu();
        let mut vector = DVector::from_fn(size, |i, _| Complex::new(1.0 + ((i * 7 + k * 13) % 11) as f64 / 11.0, 0.0));
        for _ in 0..3 {
            vector = lu.solve(&vector)?;
            for j in 0..k {
                if (eigenvalues[j] - *eigenvalue).norm() < 1e-9 * scale {
                    let other = right.column(j).into_owned();
                    let overlap = other.dotc(&vector);
                    vector -= other * overlap;
                }
            }
            let norm = vector.norm();
            if !(norm.is_finite() && norm > 0.0) {
                return None;
            }
            vector.unscale_mut(norm);
        }
        // A vector made orthogonal to another of the same eigenvalue need not be an eigenvector: a defective matrix.
        let residual = (&complex * &vector - &vector * *eigenvalue).norm();
        if residual.is_nan() || residual > MAX_RESIDUAL * scale {
            return None;
        }
        right.set_column(k, &vector);
    }
    let left = right.clone().try_inverse()?;
    if left.iter().any(|entry| !entry.norm().is_finite() || entry.norm() > MAX_CONDITION) {
        return None;
    }
    let shares = (0..size).map(|k| {
        let products: Vec<f64> = (0..size).map(|i| (right[(i, k)] * left[(k, i)]).norm()).collect();
        let total: f64 = products.iter().sum();
        products.iter().map(|product| product / total).collect()
    });
    Some(shares.collect())
}
