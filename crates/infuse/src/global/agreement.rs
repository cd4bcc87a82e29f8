//! Whether what a file says is what follows from its outcomes.

use std::fmt::Debug;

use crate::Error;
use crate::global::batch::{Batch, DroppedTerm};
use crate::global::changes::SurfaceChanges;
use crate::global::report::Report;
use crate::global::screening::Screening;
use crate::global::spread::Spread;
use crate::global::trial::Trial;

/// Numbers computed from the outcomes agree to this, relative: factorizations round differently on machines with
/// other instruction sets. Responses, and differences of them in which digits cancel, are compared relative to the
/// largest response.
const TOLERANCE: f64 = 1e-9;
/// Efficiencies agree to this, relative: they come from information matrices, which square the condition of what is
/// left of the grid.
const EFFICIENCY_TOLERANCE: f64 = 1e-6;

/// Whether a number that was written down is the one found again, perhaps on another machine: to 1e-9 of `scale` or of
/// the number itself, whichever is larger.
///
/// `scale` is the largest magnitude of what it was computed from. NaN and infinities agree with nothing but themselves.
#[must_use]
pub fn agrees(saved: f64, found: f64, scale: f64) -> bool {
    is_close(saved, found, TOLERANCE * scale.max(found.abs()))
}

fn is_close(saved: f64, found: f64, margin: f64) -> bool {
    (margin.is_finite() && (saved - found).abs() <= margin) || saved.to_bits() == found.to_bits()
}

/// The two sides of a comparison: a batch as saved and as found.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Agreement {
    pub(crate) turn: usize,
    /// The largest magnitude of all responses measured and simulated so far.
    pub(crate) largest_cost: f64,
}

impl Agreement {
    pub(crate) fn of_trials(self, saved: &Trial, found: &Trial) -> Result<(), Error> {
        self.exact("trials.trial.id", &saved.id, &found.id)?;
        self.exact("trials.trial.batch", &saved.batch, &found.batch)?;
        self.exact("trials.trial.used_for", &saved.used_for, &found.used_for)?;
        self.exact("trials.trial.cell", &saved.cell.index(), &found.cell.index())?;
        self.exact("trials.trial.point", &saved.point, &found.point)
    }

    pub(crate) fn of_batches(self, saved: &Batch, found: &Batch) -> Result<(), Error> {
        self.exact("batch.n_candidates", &saved.n_candidates, &found.n_candidates)?;
        self.exact("batch.constant_instead", &saved.constant_instead, &found.constant_instead)?;
        let names = |batch: &Batch| -> Vec<(usize, String, Vec<String>)> {
            let equals = |term: &DroppedTerm| term.equals.iter().map(|(name, _)| name.clone()).collect();
            batch.dropped_terms.iter().map(|term| (term.term, term.name.clone(), equals(term))).collect()
        };
        self.exact("batch.dropped_terms", &names(saved), &names(found))?;
        let coefficients = |batch: &Batch| -> Vec<f64> {
            batch.dropped_terms.iter().flat_map(|term| &term.equals).map(|(_, coefficient)| *coefficient).collect()
        };
        for (saved, found) in coefficients(saved).into_iter().zip(coefficients(found)) {
            self.close("batch.dropped_terms.equals", saved, found, TOLERANCE * found.abs().max(1.0))?;
        }
        for (field, saved, found) in [
            ("batch.experiment_efficiency", saved.experiment_efficiency, found.experiment_efficiency),
            ("batch.simulation_efficiency", saved.simulation_efficiency, found.simulation_efficiency),
        ] {
            self.close(field, saved, found, EFFICIENCY_TOLERANCE * found.abs())?;
        }
        Ok(())
    }

    /// Of what is not an outcome and not in the batch.
    pub(crate) fn of_reports(self, saved: &Report, found: &Report) -> Result<(), Error> {
        self.exact("number", &saved.number, &found.number)?;
        self.exact("n_earlier", &saved.n_earlier, &found.n_earlier)?;
        self.of_screenings(&saved.screening, &found.screening)?;
        // The reason may hold numbers, so only whether there is one must agree.
        if saved.not_corrected.is_some() != found.not_corrected.is_some() {
            return self.exact("not_corrected", &saved.not_corrected, &found.not_corrected);
        }
        self.of_changes(&saved.changes, &found.changes)
    }

    fn of_screenings(self, saved: &Screening, found: &Screening) -> Result<(), Error> {
        self.exact("screening.optimum_cell", &saved.optimum_cell.index(), &found.optimum_cell.index())?;
        self.exact("screening.optimum", &saved.optimum, &found.optimum)?;
        self.cost("screening.optimum_value", saved.optimum_value, found.optimum_value)?;
        let (cell, other) = (saved.simulation_optimum_cell.index(), found.simulation_optimum_cell.index());
        self.exact("screening.simulation_optimum_cell", &cell, &other)?;
        self.exact("screening.simulation_optimum", &saved.simulation_optimum, &found.simulation_optimum)?;
        let field = "screening.spread";
        match (saved.spread, found.spread) {
            (Spread::Estimated { s, n_validation }, Spread::Estimated { s: other, n_validation: n }) => {
                self.cost("screening.spread.s", s, other)?;
                self.exact("screening.spread.n_validation", &n_validation, &n)?;
            }
            (saved, found) => self.exact(field, &saved, &found)?,
        }
        self.exact("screening.tested", &saved.tested, &found.tested)?;
        self.close("screening.threshold", saved.threshold, found.threshold, TOLERANCE * found.threshold)?;
        self.exact("screening.n_before", &saved.n_before, &found.n_before)?;
        self.exact("screening.n_after", &saved.n_after, &found.n_after)
    }

    fn of_changes(self, saved: &SurfaceChanges, found: &SurfaceChanges) -> Result<(), Error> {
        self.cost("changes.model", saved.model, found.model)?;
        for (field, saved, found) in [
            ("changes.gap", saved.gap, found.gap),
            ("changes.innovation", saved.innovation, found.innovation),
            ("changes.simulation", saved.simulation, found.simulation),
            ("changes.experiment", saved.experiment, found.experiment),
        ] {
            match (saved, found) {
                (Some(saved), Some(found)) => self.cost(field, saved, found)?,
                (saved, found) => self.exact(field, &saved, &found)?,
            }
        }
        Ok(())
    }

    pub(crate) fn exact<T: PartialEq + Debug>(self, field: &'static str, saved: &T, found: &T) -> Result<(), Error> {
        if saved == found { Ok(()) } else { Err(self.differs(field, saved, found)) }
    }

    fn cost(self, field: &'static str, saved: f64, found: f64) -> Result<(), Error> {
        if agrees(saved, found, self.largest_cost) { Ok(()) } else { Err(self.differs(field, &saved, &found)) }
    }

    fn close(self, field: &'static str, saved: f64, found: f64, margin: f64) -> Result<(), Error> {
        if is_close(saved, found, margin) { Ok(()) } else { Err(self.differs(field, &saved, &found)) }
    }

    fn differs(self, field: &'static str, saved: &impl Debug, found: &impl Debug) -> Error {
        let (saved, found) = (format!("{saved:?}"), format!("{found:?}"));
        Error::StateDiffers { field, turn: self.turn, saved, found }
    }
}
