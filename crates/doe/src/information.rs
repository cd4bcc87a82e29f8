//! The information matrix of a design.

use crate::matrix::{self, add_outer, cholesky, inverse_of_factor};
use crate::support::confounded_terms_of_design;
use crate::{Design, Error, Model};

/// R'R of a design with its inverse and determinant: what n uncorrelated runs of unit variance say about the terms.
///
/// R holds one regressor per run; matrices are p × p, row by row.
///
/// Source: (28)
#[derive(Debug, Clone, PartialEq)]
pub struct Information {
    n_terms: usize,
    n_runs: usize,
    matrix: Vec<f64>,
    inverse: Vec<f64>,
    log_determinant: f64,
}

/// A pivot below this fraction of its diagonal element makes the matrix singular: about half the digits of a double.
pub(crate) const PIVOT_FLOOR: f64 = 1e-13;

impl Information {
    /// The information that a design has about a model.
    ///
    /// ```
    /// use doe::{Design, Information, Model};
    /// let design = Design::new(1, vec![-1.0, 0.0, 1.0])?;
    /// let information = Information::of(&Model::quadratic(1)?, &design)?;
    /// assert!((information.determinant() - 4.0).abs() < 1e-12);
    /// assert!((information.variance(&[1.0, 0.0, 0.0])? - 1.0).abs() < 1e-12, "the response at the center");
    /// # Ok::<(), doe::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::FactorMismatch`], [`Error::TooFewRuns`], [`Error::Confounded`] with the terms that the runs cannot
    /// tell apart, [`Error::Singular`] if they can, but not in double precision.
    pub fn of(model: &Model, design: &Design) -> Result<Self, Error> {
        let (expected, found) = (model.n_factors(), design.n_factors());
        if expected != found {
            return Err(Error::FactorMismatch { what: "the design", expected, found });
        }
        let (n_runs, n_terms) = (design.n_runs(), model.n_terms());
        if n_runs < n_terms {
            return Err(Error::TooFewRuns { n_runs, n_terms });
        }
        let mut information = vec![0.0; n_terms * n_terms];
        let mut regressor = vec![0.0; n_terms];
        for run in design.runs() {
            model.fill_regressor(run, &mut regressor);
            add_outer(&mut information, n_terms, 1.0, &regressor);
        }
        Self::of_matrix(information, n_terms, n_runs).ok_or_else(|| match confounded_terms_of_design(model, design) {
            Ok(confounded) if !confounded.is_empty() => Error::Confounded { what: "design", confounded },
            _ => Error::Singular,
        })
    }

    /// None if the matrix is singular in double precision.
    pub(crate) fn of_matrix(matrix: Vec<f64>, n_terms: usize, n_runs: usize) -> Option<Self> {
        let mut factor = matrix.clone();
        let log_determinant = cholesky(&mut factor, n_terms, PIVOT_FLOOR)?;
        let (mut inverse, mut scratch) = (vec![0.0; matrix.len()], vec![0.0; matrix.len()]);
        inverse_of_factor(&factor, n_terms, &mut inverse, &mut scratch);
        // The rows of the inverse are complete up to the diagonal and beyond it; make it symmetric to the last bit.
        for i in 0..n_terms {
            for j in 0..i {
                inverse[j * n_terms + i] = inverse[i * n_terms + j];
            }
        }
        Some(Self { n_terms, n_runs, matrix, inverse, log_determinant })
    }

    /// Number of terms, p.
    #[must_use]
    pub fn n_terms(&self) -> usize {
        self.n_terms
    }

    /// Number of runs, N.
    #[must_use]
    pub fn n_runs(&self) -> usize {
        self.n_runs
    }

    /// R'R, p × p, row by row.
    #[must_use]
    pub fn matrix(&self) -> &[f64] {
        &self.matrix
    }

    /// (R'R)⁻¹, p × p, row by row: covariance of the coefficients for unit variance of a run.
    #[must_use]
    pub fn inverse(&self) -> &[f64] {
        &self.inverse
    }

    /// log |R'R|.
    #[must_use]
    pub fn log_determinant(&self) -> f64 {
        self.log_determinant
    }

    /// |R'R|.
    #[must_use]
    pub fn determinant(&self) -> f64 {
        self.log_determinant.exp()
    }

    /// Prediction variance r' (R'R)⁻¹ r for a regressor r, for unit variance of a run.
    ///
    /// # Errors
    ///
    /// [`PointLength`](design_space::Error::PointLength) for a regressor of another length than p.
    pub fn variance(&self, regressor: &[f64]) -> Result<f64, Error> {
        if regressor.len() != self.n_terms {
            return Err(Error::DesignSpace(design_space::Error::PointLength {
                expected: self.n_terms,
                found: regressor.len(),
            }));
        }
        let mut product = vec![0.0; self.n_terms];
        matrix::multiply(&self.inverse, self.n_terms, regressor, &mut product);
        Ok(matrix::dot(&product, regressor))
    }

    /// Leverage of each run: the prediction variance at the run itself; they sum to p.
    ///
    /// # Errors
    ///
    /// [`Error::FactorMismatch`], [`PointLength`](design_space::Error::PointLength) if the model has another number of terms.
    pub fn leverages(&self, model: &Model, design: &Design) -> Result<Vec<f64>, Error> {
        design.runs().map(|run| self.variance(&model.regressor(run)?)).collect()
    }

    /// Eigenvalues of R'R, rising.
    ///
    /// # Errors
    ///
    /// [`Error::Singular`] if the iteration fails.
    pub fn eigenvalues(&self) -> Result<Vec<f64>, Error> {
        matrix::eigenvalues(&self.matrix, self.n_terms).ok_or(Error::Singular)
    }
}
