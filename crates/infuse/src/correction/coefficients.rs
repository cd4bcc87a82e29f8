//! A combination of surfaces.

use serde::{Deserialize, Serialize};

use crate::Error;
use crate::checks::{check_count, check_finite};

/// Σ_j experiment_j Ĵexp,j + Σ_j simulation_j Ĵsim,j, with batches j from 1 at index j − 1.
///
/// The surfaces may be given in any form in which sums of surfaces are sums of numbers: values at
/// points, or coefficients in one basis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Coefficients {
    /// Factor of the experiment surface of each batch.
    pub experiment: Vec<f64>,
    /// Factor of the simulation surface of each batch.
    pub simulation: Vec<f64>,
}

impl Coefficients {
    /// The combination, entry by entry. Rows are batches; all rows have the same length.
    ///
    /// # Errors
    ///
    /// [`Error::WrongCount`] for another number of rows or unequal rows, [`Error::Entry`] for a NaN or
    /// an infinity in a row or in the result.
    pub fn combine<E: AsRef<[f64]>, S: AsRef<[f64]>>(
        &self,
        experiment: &[E],
        simulation: &[S],
    ) -> Result<Vec<f64>, Error> {
        check_count("experiment", self.experiment.len(), experiment.len(), "coefficient")?;
        check_count("simulation", self.simulation.len(), simulation.len(), "coefficient")?;
        let rows = || experiment.iter().map(AsRef::as_ref).chain(simulation.iter().map(AsRef::as_ref));
        let factors = self.experiment.iter().chain(&self.simulation);
        let mut sum = vec![0.0; rows().next().map_or(0, <[f64]>::len)];
        for (factor, row) in factors.zip(rows()) {
            check_count("surface", sum.len(), row.len(), "entry of the first surface")?;
            check_finite("surface", row)?;
            for (total, value) in sum.iter_mut().zip(row) {
                *total += factor * value;
            }
        }
        check_finite("combined surface", &sum)?;
        Ok(sum)
    }
}
