//! What can be promised of the optimum: certificates, and the cells that may still be better.

use serde::{Deserialize, Serialize};
use surface::LeaveOneOut;

use crate::Error;
use crate::checks::check_not_negative;
use crate::convergence::{Bound, RegretCertificate};
use crate::correction::ModelStage;
use crate::global::campaign::Loop;
use crate::global::report::Report;
use crate::global::retained::RetainedSet;
use crate::global::surfaces::BatchSurfaces;
use crate::traced::TracedSurface;

/// What [`Loop::observed_certificate`] rests on.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct ObservedErrors {
    /// Largest error of an Ĵsim of the campaign at a simulation that was left out of the fit.
    pub simulation: f64,
    /// Largest error of an Ĵexp of the campaign at an experiment that was left out of the fit, its noise included.
    pub experiment: f64,
    /// The bound on |Ĵnum − J_true| that follows from the errors of every batch and the gap.
    pub eps: f64,
    /// What eps promises of p̂*.
    pub certificate: RegretCertificate,
}

impl Loop {
    /// What `eps` promises of the optimum p̂* of the last closed batch, with the corrected model Ĵnum of that
    /// batch, over what it left: eps must bound |Ĵnum − J_true| there, in the sup norm. None before the
    /// first batch is closed.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] for an `eps` that is negative, NaN or infinite.
    pub fn certificate(&self, eps: f64) -> Result<Option<RegretCertificate>, Error> {
        let Some((report, surfaces)) = self.history.last().zip(self.surfaces.last()) else {
            return Ok(None);
        };
        let (model, cell) = (surfaces.numerical.surface(), report.screening.optimum_cell);
        let least_other = self.retained.minimum_but(Some(cell), self.cells.points(), model);
        let least_other = least_other.map_or(f64::INFINITY, |least| least.value);
        RegretCertificate::of_cell_among(model.predict(&self.cells.coded(cell)?), least_other, eps).map(Some)
    }

    /// The cells left that may still be the best of them, if `eps` bounds |Ĵnum − J_true| as for the
    /// [`certificate`](Self::certificate): how many, and which. None before the first batch is closed.
    ///
    /// # Errors
    ///
    /// As [`certificate`](Self::certificate).
    pub fn possible_optima(&self, eps: f64) -> Result<Option<RetainedSet>, Error> {
        check_not_negative("eps", eps)?;
        let (points, mut possible) = (self.cells.points(), self.retained.clone());
        let Some(model) = self.surfaces.last().map(|surfaces| surfaces.numerical.surface()) else {
            return Ok(None);
        };
        if let Some(least) = possible.minimum(points, model) {
            possible.retain(points, model, |value| value.is_nan() || value - least.value <= 2.0 * eps);
        }
        Ok(Some(possible))
    }

    /// The [certificate](Self::certificate) with errors of the surfaces as they were observed at runs left out of the
    /// fit, one by one: a promise only as far as the surfaces err no more between the runs than at them. None if some surface cannot be
    /// fitted without one of its runs, or if the correction law has no bound with such errors.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] if the errors are too large for a double.
    pub fn observed_certificate(&self) -> Result<Option<ObservedErrors>, Error> {
        let errors: Option<Vec<(f64, f64)>> =
            self.history.iter().zip(&self.surfaces).map(|(report, surfaces)| left_out(report, surfaces)).collect();
        let Some((e1, e2)) = errors.map(|errors| errors.into_iter().unzip::<f64, f64, Vec<f64>, Vec<f64>>()) else {
            return Ok(None);
        };
        let Some(gap) = self.history.first().and_then(|report| report.changes.gap) else {
            return Ok(None);
        };
        let bound = Bound::new(self.settings.correction, ModelStage::Corrected);
        let eps = bound.finite(gap + e1[0] + e2[0], &e1, &e2)?;
        let largest = |errors: &[f64]| errors.iter().copied().fold(0.0, f64::max);
        let certificate = self.certificate(eps)?;
        Ok(certificate.map(|certificate| ObservedErrors {
            simulation: largest(&e1),
            experiment: largest(&e2),
            eps,
            certificate,
        }))
    }
}

/// The largest errors of Ĵsim and Ĵexp of a batch at runs left out.
fn left_out(report: &Report, surfaces: &BatchSurfaces) -> Option<(f64, f64)> {
    if report.not_corrected.is_some() {
        return None;
    }
    let largest = |errors: LeaveOneOut| errors.residuals().iter().fold(0.0, |largest: f64, e| largest.max(e.abs()));
    let of = |surface: &TracedSurface| surface.regression()?.leave_one_out().ok().map(largest);
    Some((of(&surfaces.simulation)?, of(surfaces.experiment.as_ref()?)?))
}
