//! What a bound on the model says about a design.

use serde::{Deserialize, Serialize};

use crate::Error;
use crate::checks::{check_cells, check_finite, check_not_negative};

/// How much worse than the best retained design a design can be, in the unit of the response.
///
/// If |Ĵ_model − J_true| ≤ eps at the design p and everywhere in the retained region M, then
///
/// ```text
/// J_true(p) − min_M J_true ≤ Ĵ_model(p) − min_M Ĵ_model + 2 eps
/// ```
///
/// for any p, however it was found: add J_true(p) ≤ Ĵ_model(p) + eps and −J_true ≤ −Ĵ_model + eps at
/// the best design. Source: beyond the text.
///
/// eps must hold in the sup norm, such as [`Bound::finite`](crate::convergence::Bound::finite) of sup norms; a norm
/// of finite order says nothing about a single design.
///
/// The certificate speaks of M. About designs dropped earlier it says nothing, unless each was dropped
/// while its model response exceeded the least by more than 2 eps, with the eps valid then: such a design
/// was truly worse than one that was kept. [`possible_optima`] drops no others, and the certificate
/// then holds against the original box. A z-test gives no such guarantee.
///
/// ```
/// use infuse::convergence::RegretCertificate;
///
/// let model = [4.20, 4.01, 4.35];
/// let certificate = RegretCertificate::of_cell(1, &model, 0.3)?;
/// assert!((certificate.regret - 0.41).abs() < 1e-12); // 4.01 − 4.20 + 2 · 0.3
/// assert!(certificate.is_within(0.5), "good enough to stop");
/// # Ok::<(), infuse::Error>(())
/// ```
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RegretCertificate {
    /// Ĵ_model(p) − min_M Ĵ_model; negative for a point between cells below all of them.
    pub model_excess: f64,
    /// The bound on J_true(p) − min_M J_true.
    pub regret: f64,
}

impl RegretCertificate {
    /// For a design between the cells, from its model response and those of all retained cells.
    ///
    /// # Errors
    ///
    /// [`Error::EmptyRegion`]; [`Error::Entry`] and [`Error::Setting`] for a response that is not finite or
    /// an `eps` that is negative, NaN or infinite.
    pub fn of_point(model_cost: f64, model: &[f64], eps: f64) -> Result<Self, Error> {
        check(model, eps)?;
        if !model_cost.is_finite() {
            return Err(Error::Setting { name: "model_cost", value: model_cost, expected: "a finite number" });
        }
        let model_excess = model_cost - least(model);
        Ok(Self { model_excess, regret: model_excess + 2.0 * eps })
    }

    /// For one of the retained cells.
    ///
    /// Against itself a design has no regret, so the minimum runs over the others: a cell that
    /// undercuts all others by more than 2 eps is certainly the best, with a regret of 0.
    ///
    /// # Errors
    ///
    /// [`Error::UnknownCell`], and those of [`of_point`](Self::of_point).
    pub fn of_cell(cell_idx: usize, model: &[f64], eps: f64) -> Result<Self, Error> {
        let Some(&model_cost) = model.get(cell_idx) else {
            check_cells(model.len())?;
            return Err(Error::UnknownCell { cell_idx, n_cells: model.len() });
        };
        let certificate = Self::of_point(model_cost, model, eps)?;
        let least_other = least(&model[..cell_idx]).min(least(&model[cell_idx + 1..]));
        Ok(Self::among(model_cost, least_other, certificate.model_excess, eps))
    }

    /// For a retained cell, from the least model response of the others, infinite without any.
    #[cfg(feature = "global")]
    pub(crate) fn of_cell_among(model_cost: f64, least_other: f64, eps: f64) -> Result<Self, Error> {
        check_not_negative("eps", eps)?;
        Ok(Self::among(model_cost, least_other, model_cost - least_other.min(model_cost), eps))
    }

    fn among(model_cost: f64, least_other: f64, model_excess: f64, eps: f64) -> Self {
        Self { model_excess, regret: (model_cost - least_other + 2.0 * eps).max(0.0) }
    }

    /// The stopping rule: whether the design is certainly this close to the best, in the unit of the
    /// response.
    ///
    /// A tolerance below twice the limit of the bound may never be reached:
    /// [`Bound::limit`](crate::convergence::Bound::limit) tells beforehand.
    #[must_use]
    pub fn is_within(&self, tolerance: f64) -> bool {
        self.regret <= tolerance
    }
}

/// Which cells may still be the true optimum if |Ĵ_model − J_true| ≤ `eps` at every cell: those whose
/// model response exceeds the least by 2 `eps` at most.
///
/// # Errors
///
/// [`Error::EmptyRegion`]; [`Error::Entry`] for a response that is not finite; [`Error::Setting`] for an
/// `eps` that is negative, NaN or infinite.
pub fn possible_optima(model: &[f64], eps: f64) -> Result<Vec<bool>, Error> {
    check(model, eps)?;
    let least = least(model);
    Ok(model.iter().map(|cost| cost - least <= 2.0 * eps).collect())
}

fn check(model: &[f64], eps: f64) -> Result<(), Error> {
    check_cells(model.len())?;
    check_finite("model", model)?;
    check_not_negative("eps", eps)
}

fn least(costs: &[f64]) -> f64 {
    costs.iter().copied().fold(f64::INFINITY, f64::min)
}
