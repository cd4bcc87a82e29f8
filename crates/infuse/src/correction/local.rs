//! The correction (27) around an optimum: a plane that turns the slopes of the model into those of the experiments.

use serde::{Deserialize, Serialize};

use crate::Error;
use crate::checks::check_length;

/// How an iteration changes the correction. In files `repaired`, `as_printed`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Form {
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

impl Form {
    /// What an iteration adds to the slope of one parameter; nothing without the gradients it needs.
    fn slope_change(self, trust: f64, experiment: Option<f64>, model: Option<f64>) -> Option<f64> {
        match self {
            Self::Repaired => Some(trust * (experiment? - model?)),
            Self::AsPrinted => Some(-trust * experiment?),
        }
    }
}

/// What an iteration knows of the slopes at its optimum p*, per unit of each parameter.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Slopes<'a> {
    /// p*, natural coordinates.
    pub(crate) optimum: &'a [f64],
    /// ∂J_exp/∂p_j, by the experiments.
    pub(crate) experiment: &'a [Option<f64>],
    /// ∂J_mod/∂p_j of the corrected model.
    pub(crate) model: &'a [Option<f64>],
}

/// A correction linear in the parameters: J_cor(p) = offset + Σ_j slope_j p_j, natural coordinates.
///
/// Every sum of terms like those of (27) has this shape, whatever the number of iterations.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename = "Correction")]
pub struct Local {
    slope: Vec<f64>,
    offset: f64,
}

impl Local {
    pub(crate) fn zero(n_parameters: usize) -> Self {
        Self { slope: vec![0.0; n_parameters], offset: 0.0 }
    }

    /// The correction after one more iteration, with trust factors R, and whether that of each parameter changed:
    ///
    /// ```text
    /// J_cor(p) + Σ_j R_j (∂J_exp/∂p_j − ∂J_mod/∂p_j)(p*) (p_j − p*_j)
    /// ```
    ///
    /// Where a slope is unknown, and where the change overflows, it stays as it was.
    ///
    /// Source: (27), repaired or as printed.
    pub(crate) fn updated(&self, form: Form, trust: &[f64], at: Slopes) -> (Self, Vec<bool>) {
        let mut correction = self.clone();
        let is_corrected = (0..at.optimum.len())
            .map(|j| {
                let change = form.slope_change(trust[j], at.experiment[j], at.model[j]);
                change.is_some_and(|change| correction.add(j, change, at.optimum[j]))
            })
            .collect();
        (correction, is_corrected)
    }

    /// Adds `change` (p_j − p*_j) for one parameter j; refuses a change that overflows.
    fn add(&mut self, j: usize, change: f64, optimum: f64) -> bool {
        let slope = self.slope[j] + change;
        let offset = self.offset - change * optimum;
        let is_usable = slope.is_finite() && offset.is_finite();
        if is_usable {
            self.slope[j] = slope;
            self.offset = offset;
        }
        is_usable
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
}
