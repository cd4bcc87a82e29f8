//! A surface that knows which experiments are in it.

use std::collections::BTreeSet;
use std::sync::Arc;

use surface::{Regression, Surface};

use crate::checks::check_length;
use crate::traced::sum::Sum;
use crate::{Error, TrialId};

/// A response surface with the trials whose outcomes have entered it, directly or through a correction.
///
/// Coordinates are coded to the original box.
#[derive(Debug, Clone)]
pub struct TracedSurface {
    pub(super) form: Form,
    pub(super) trials: BTreeSet<TrialId>,
}

/// What kind of surface it is.
#[derive(Debug, Clone)]
pub(super) enum Form {
    Regression(Arc<Regression>),
    Smoother(Arc<dyn Surface>),
    Sum(Arc<Sum>),
}

impl TracedSurface {
    /// Σ f Ĵ over these surfaces; a factor of exactly 0 leaves its surface out, and the trials of it too.
    ///
    /// Regressions are added coefficient by coefficient, so a sum of many costs no more to evaluate than one.
    ///
    /// # Errors
    ///
    /// [`Error::WrongLength`] for a surface with another number of factors, [`Error::Surface`] for a number of factors
    /// that no surface has.
    pub fn combination<'a>(
        n_factors: usize,
        parts: impl IntoIterator<Item = (f64, &'a TracedSurface)>,
    ) -> Result<Self, Error> {
        let mut sum = Sum::zero(n_factors)?;
        let mut trials = BTreeSet::new();
        for (factor, part) in parts {
            check_length("surface", n_factors, part.surface().n_factors())?;
            if factor == 0.0 {
                continue;
            }
            trials.extend(&part.trials);
            match &part.form {
                Form::Regression(regression) => {
                    sum.add_polynomial(factor, regression.polynomial())?;
                }
                Form::Smoother(surface) => sum.add_surface(factor, Arc::clone(surface)),
                Form::Sum(part) => sum.add_sum(factor, part)?,
            }
        }
        Ok(Self { form: Form::Sum(Arc::new(sum)), trials })
    }

    /// The surface itself.
    #[must_use]
    pub fn surface(&self) -> &dyn Surface {
        match &self.form {
            Form::Regression(regression) => regression.as_ref(),
            Form::Smoother(surface) => surface.as_ref(),
            Form::Sum(sum) => sum.as_ref(),
        }
    }

    /// The regression, with its coefficients and diagnostics, if it is one.
    #[must_use]
    pub fn regression(&self) -> Option<&Regression> {
        match &self.form {
            Form::Regression(regression) => Some(regression),
            Form::Smoother(_) | Form::Sum(_) => None,
        }
    }

    /// The trials that have entered it.
    #[must_use]
    pub fn trials(&self) -> &BTreeSet<TrialId> {
        &self.trials
    }
}
