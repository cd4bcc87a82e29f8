//! The term that experiments add to the cost of the model.

use serde::{Deserialize, Serialize};

use crate::Error;
use crate::problem::check_length;

/// How an iteration changes the correction.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CorrectionForm {
    /// J_cor += Σ_j R_j (∂J_exp/∂p_j − ∂J_mod/∂p_j)(p*) (p_j − p*_j): the form that works.
    #[default]
    Repaired,
    /// J_cor += Σ_j R_j ∂J_exp/∂p_j (p*) (p*_j − p_j): (27) to the letter.
    ///
    /// Do not use it on a rig. It lowers the cost of the model in the direction in which the
    /// experiment got worse, so every iteration walks away from the optimum of the experiment. It is
    /// offered so that one can watch it fail.
    AsPrinted,
}

impl CorrectionForm {
    /// What an iteration adds to the slope of one parameter; nothing without the gradients it needs.
    pub(crate) fn slope_change(
        self,
        trust: f64,
        experiment_gradient: Option<f64>,
        model_gradient: Option<f64>,
    ) -> Option<f64> {
        match self {
            Self::Repaired => Some(trust * (experiment_gradient? - model_gradient?)),
            Self::AsPrinted => Some(-trust * experiment_gradient?),
        }
    }
}

/// A correction linear in the parameters: J_cor(p) = offset + Σ_j slope_j p_j, natural coordinates.
///
/// Every sum of terms like those of (27) has this shape, whatever the number of iterations.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Correction {
    slope: Vec<f64>,
    offset: f64,
}

impl Correction {
    pub(crate) fn zero(n_parameters: usize) -> Self {
        Self { slope: vec![0.0; n_parameters], offset: 0.0 }
    }

    /// Cost per unit of each parameter.
    #[must_use]
    pub fn slope(&self) -> &[f64] {
        &self.slope
    }

    /// Cost at the origin of the natural coordinates.
    #[must_use]
    pub fn offset(&self) -> f64 {
        self.offset
    }

    /// J_cor at a natural point.
    ///
    /// # Errors
    ///
    /// [`Error::WrongLength`].
    pub fn cost(&self, point: &[f64]) -> Result<f64, Error> {
        check_length("point", self.slope.len(), point.len())?;
        Ok(self.value_at(point))
    }

    pub(crate) fn value_at(&self, point: &[f64]) -> f64 {
        let terms = self.slope.iter().zip(point);
        self.offset + terms.map(|(slope, value)| slope * value).sum::<f64>()
    }

    /// Adds `change` (p_j − p*_j) for one parameter j; refuses a change that overflows.
    pub(crate) fn add(&mut self, parameter_idx: usize, change: f64, optimum: f64) -> bool {
        let slope = self.slope[parameter_idx] + change;
        let offset = self.offset - change * optimum;
        let is_usable = slope.is_finite() && offset.is_finite();
        if is_usable {
            self.slope[parameter_idx] = slope;
            self.offset = offset;
        }
        is_usable
    }
}
