//! Whether the errors of the surfaces shrink, as the proposition assumes.

use serde::{Deserialize, Serialize};

use crate::Error;
use crate::checks::{check_error_bounds, check_not_negative};

/// Where E1 and E2 of (43) and (44) grew from one batch to the next.
///
/// The dissertation concludes from the shrinking region that they fall. That holds for the norm of one
/// function; every batch fits a new one, whose error over the smaller region may be larger. So it
/// is an assumption, checked here on the bounds or estimates that a campaign comes by. Its failure
/// takes nothing from [`Bound::finite`](crate::convergence::Bound::finite), which takes the errors as they come; it
/// says that they are not settling, so no limit is in sight.
///
/// Source: (43), (44).
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AssumptionReport {
    /// Growth of E1.
    pub simulation: Vec<Growth>,
    /// Growth of E2.
    pub experiment: Vec<Growth>,
}

/// One step in the wrong direction.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Growth {
    /// The batch whose error is larger, from 2.
    pub batch: usize,
    /// The error of the batch before.
    pub previous: f64,
    /// The least error of all batches before.
    pub least: f64,
    /// The error of this batch.
    pub error: f64,
}

impl Growth {
    /// How many times the error of the batch before this one is; infinite after a zero.
    #[must_use]
    pub fn ratio(&self) -> f64 {
        self.error / self.previous
    }
}

impl AssumptionReport {
    /// Compares the errors of all batches so far, E1,1.. and E2,1.., one sequence possibly longer.
    ///
    /// An error counts as grown if it exceeds both that of the batch before and, by more than the
    /// `tolerance`, the least so far: relative, such as 0.1 for a tenth. Slow growth, each step within
    /// the tolerance, is so found in the end.
    ///
    /// # Errors
    ///
    /// [`Error::Entry`] and [`Error::Setting`] for a negative number, a NaN or an infinity.
    pub fn new(simulation: &[f64], experiment: &[f64], tolerance: f64) -> Result<Self, Error> {
        check_error_bounds("simulation", simulation)?;
        check_error_bounds("experiment", experiment)?;
        check_not_negative("tolerance", tolerance)?;
        Ok(Self { simulation: growths(simulation, tolerance), experiment: growths(experiment, tolerance) })
    }

    /// Whether nothing grew.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.simulation.is_empty() && self.experiment.is_empty()
    }
}

fn growths(errors: &[f64], tolerance: f64) -> Vec<Growth> {
    let mut least = f64::INFINITY;
    let mut found = Vec::new();
    for (index, pair) in errors.windows(2).enumerate() {
        let (previous, error) = (pair[0], pair[1]);
        least = least.min(previous);
        if error > previous && error > least + tolerance * least {
            found.push(Growth { batch: index + 2, previous, least, error });
        }
    }
    found
}
