//! The regressors that a study file can name.

use anyhow::Result;
use doe::Model;
use serde::Deserialize;

/// A regressor for any number of parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Regressor {
    /// (61).
    AdditiveQuadratic,
    /// (61) with all products of two parameters.
    Quadratic,
}

impl Regressor {
    pub(crate) fn model(self, n_parameters: usize) -> Result<Model> {
        Ok(match self {
            Self::AdditiveQuadratic => Model::additive_quadratic(n_parameters)?,
            Self::Quadratic => Model::quadratic(n_parameters)?,
        })
    }

    pub(crate) fn words(self) -> &'static str {
        match self {
            Self::AdditiveQuadratic => "additive quadratic (61)",
            Self::Quadratic => "full quadratic",
        }
    }
}
