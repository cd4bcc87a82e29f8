//! A surface fitted to observations: it rests on the trials that they rest on.

use std::sync::Arc;

use surface::{Kind, Regression};

use crate::Error;
use crate::traced::observations::Observations;
use crate::traced::traced_surface::{Form, TracedSurface};

impl TracedSurface {
    /// The surface of this kind fitted to these observations.
    ///
    /// # Errors
    ///
    /// [`Error::Surface`].
    pub fn fit(kind: &Kind, observations: &Observations) -> Result<Self, Error> {
        let data = observations.data()?;
        let form = match kind {
            Kind::Regression { model, confounded } => {
                Form::Regression(Arc::new(Regression::fit_with(model, &data, *confounded)?))
            }
            Kind::InverseDistance { .. } | Kind::SquaredExponential { .. } => {
                Form::Smoother(Arc::from(kind.fit(&data)?))
            }
        };
        Ok(Self { form, trials: observations.trials().clone() })
    }
}
