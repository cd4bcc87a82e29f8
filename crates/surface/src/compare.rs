//! Which surface suits some data best.

use doe::Model;
use serde::{Deserialize, Serialize};

use crate::{Confounded, Data, Error, InverseDistance, LeaveOneOut, Regression, SquaredExponential, Surface};

/// A kind of surface with everything but its data.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Kind {
    /// Weighted least squares, (30) and (31).
    Regression {
        /// The terms.
        model: Model,
        /// What to do about terms that the data cannot tell apart.
        #[serde(default)]
        confounded: Confounded,
    },
    /// Inverse distance, (32) and (33).
    InverseDistance {
        /// The power q.
        power: f64,
    },
    /// Squared exponential, (34).
    SquaredExponential {
        /// The scale c; chosen by the data if there is none.
        #[serde(default)]
        scale: Option<f64>,
    },
}

impl Kind {
    /// Whether its power or scale is one that a fit accepts, before there are data.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`].
    pub fn check(&self) -> Result<(), Error> {
        match self {
            Self::Regression { .. } | Self::SquaredExponential { scale: None } => Ok(()),
            Self::InverseDistance { power } => InverseDistance::check_power(*power),
            Self::SquaredExponential { scale: Some(scale) } => SquaredExponential::check_scale(*scale),
        }
    }

    /// The surface of this kind for these data.
    ///
    /// # Errors
    ///
    /// Those of [`Regression::fit_with`], [`InverseDistance::fit`], [`SquaredExponential::fit`] or
    /// [`SquaredExponential::fit_scale`].
    pub fn fit(&self, data: &Data) -> Result<Box<dyn Surface>, Error> {
        Ok(match self {
            Self::Regression { model, confounded } => Box::new(Regression::fit_with(model, data, *confounded)?),
            Self::InverseDistance { power } => Box::new(InverseDistance::fit(data.clone(), *power)?),
            Self::SquaredExponential { scale } => Box::new(squared_exponential(data, *scale)?),
        })
    }

    /// How well it predicts each point from the others.
    ///
    /// # Errors
    ///
    /// As [`fit`](Self::fit), and those of the surface's own `leave_one_out`.
    pub fn leave_one_out(&self, data: &Data) -> Result<LeaveOneOut, Error> {
        match self {
            Self::Regression { model, confounded } => Regression::fit_with(model, data, *confounded)?.leave_one_out(),
            Self::InverseDistance { power } => InverseDistance::fit(data.clone(), *power)?.leave_one_out(),
            Self::SquaredExponential { scale } => squared_exponential(data, *scale)?.leave_one_out(),
        }
    }
}

fn squared_exponential(data: &Data, scale: Option<f64>) -> Result<SquaredExponential, Error> {
    match scale {
        Some(scale) => SquaredExponential::fit(data.clone(), scale),
        None => SquaredExponential::fit_scale(data.clone()),
    }
}

/// What leaving one out says about one kind of surface.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// The kind.
    pub kind: Kind,
    /// Its leave-one-out residuals, or why it has none.
    pub outcome: Result<LeaveOneOut, Error>,
}

/// Kinds of surfaces in the order of their leave-one-out error, the smallest first, those without one last.
///
/// The scale of a squared exponential that is chosen by the data is chosen once, by all of them, which favors it a
/// little. Replicates favor the surfaces that pass close to each datum.
#[must_use]
pub fn compare(data: &Data, kinds: &[Kind]) -> Vec<Comparison> {
    let one = |kind: &Kind| Comparison { kind: kind.clone(), outcome: kind.leave_one_out(data) };
    let mut comparisons: Vec<Comparison> = kinds.iter().map(one).collect();
    let error = |comparison: &Comparison| comparison.outcome.as_ref().map_or(f64::INFINITY, LeaveOneOut::rms);
    comparisons.sort_by(|a, b| error(a).total_cmp(&error(b)));
    comparisons
}
