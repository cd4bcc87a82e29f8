//! Dropping what is worse than the optimum beyond doubt: Section 5.5.

use design_space::Cell;
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, Normal};
use surface::GridPoints;

use crate::Error;
use crate::global::retained::RetainedSet;
use crate::global::settings::{Settings, SpreadFallback};
use crate::traced::{Observations, TracedSurface};

/// S below this part of the responses it is made of is rounding.
const ROUNDING: f64 = 1e-12;

/// S of (40), the quality of fit: how far a combined surface is from validation experiments.
///
/// ```text
/// S = √( Σ (Ĵ(p_val) − J(p_val))² / (n − 1) )
/// ```
///
/// With n the number of validation experiments that gave a response; none for fewer than two.
///
/// Source: (40).
///
/// The surface must never have seen these experiments, neither as its own data nor through the correction of
/// the simulations it was fitted to, or S would be too small and the test would drop too much: the
/// provenance of both is compared, and an overlap is refused.
///
/// # Errors
///
/// [`Error::ValidationLeak`].
pub fn quality_of_fit(combined: &TracedSurface, validation: &Observations) -> Result<Option<f64>, Error> {
    let seen: Vec<_> = validation.trials().intersection(combined.trials()).copied().collect();
    if !seen.is_empty() {
        return Err(Error::ValidationLeak { trials: seen });
    }
    let n_points = validation.n_points();
    if n_points < 2 {
        return Ok(None);
    }
    let pairs = validation.points().zip(validation.values());
    let squares = pairs.map(|(point, cost)| (combined.surface().predict(point) - cost).powi(2));
    Ok(Some((squares.sum::<f64>() / (n_points - 1) as f64).sqrt()))
}

/// z of (39): how many standard deviations a cell is worse than the optimum.
///
/// ```text
/// z(p) = (Ĵ(p) − Ĵ(p*)) / (S √2)
/// ```
///
/// Source: (39).
pub(crate) fn z(value: f64, optimum_value: f64, spread: f64) -> f64 {
    (value - optimum_value) / (spread * std::f64::consts::SQRT_2)
}

/// z_0: the quantile of the standard normal distribution at this level, 1.2816 at 0.9. One-sided, because
/// (38) is: only what is worse is dropped.
pub(crate) fn threshold(confidence: f64) -> f64 {
    Normal::standard().inverse_cdf(confidence)
}

/// Why validation experiments give no spread.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SpreadFault {
    /// Fewer than two of them gave a response.
    TooFew,
    /// They were predicted to rounding, 10⁻¹² of the largest response among them.
    Zero,
    /// S is not finite.
    NotFinite,
}

/// The S that a z-test used.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Spread {
    /// (40), from this many validation experiments.
    Estimated {
        /// S, in the unit of the response.
        s: f64,
        /// Number of validation experiments that gave a response.
        n_validation: usize,
    },
    /// The one of the settings.
    Given {
        /// S, in the unit of the response.
        s: f64,
        /// Why (40) gave none.
        because: SpreadFault,
    },
    /// None: nothing was dropped.
    Undefined {
        /// Why (40) gave none.
        because: SpreadFault,
    },
}

impl Spread {
    /// (40), or what the settings say where it gives nothing.
    pub(crate) fn of(
        combined: &TracedSurface,
        validation: &Observations,
        fallback: SpreadFallback,
    ) -> Result<Self, Error> {
        let largest = validation.values().iter().fold(0.0_f64, |largest, cost| largest.max(cost.abs()));
        let because = match quality_of_fit(combined, validation)? {
            None => SpreadFault::TooFew,
            Some(s) if !s.is_finite() => SpreadFault::NotFinite,
            Some(s) if s <= ROUNDING * largest => SpreadFault::Zero,
            Some(s) => return Ok(Self::Estimated { s, n_validation: validation.n_points() }),
        };
        Ok(match fallback {
            SpreadFallback::Given(s) => Self::Given { s, because },
            SpreadFallback::KeepAll | SpreadFallback::Stop => Self::Undefined { because },
        })
    }

    /// S, if there is one.
    #[must_use]
    pub fn s(&self) -> Option<f64> {
        match *self {
            Self::Estimated { s, .. } | Self::Given { s, .. } => Some(s),
            Self::Undefined { .. } => None,
        }
    }
}

/// The optimum of a batch and the test of every other cell against it.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Screening {
    /// The cell of p̂*, where the combined surface is smallest among the retained cells.
    pub optimum_cell: Cell,
    /// p̂*, natural.
    pub optimum: Vec<f64>,
    /// Ĵ(p̂*).
    pub optimum_value: f64,
    /// The cell where Ĵsim is smallest among the retained cells: in batch 1 the pure numerical optimum,
    /// row 0 of Tables 5 and 6.
    pub simulation_optimum_cell: Cell,
    /// The same, natural.
    pub simulation_optimum: Vec<f64>,
    /// The S of the test.
    pub spread: Spread,
    /// Whether there was a test: not before [`Settings::first_screening`].
    #[serde(default = "yes", skip_serializing_if = "is_yes")]
    pub tested: bool,
    /// z_0.
    pub threshold: f64,
    /// Cells at the onset of the batch, M_i.
    pub n_before: u64,
    /// Cells left after it, M_i+1.
    pub n_after: u64,
}

fn yes() -> bool {
    true
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde hands out references")]
fn is_yes(flag: &bool) -> bool {
    *flag
}

impl Screening {
    /// The S that cells were tested with.
    pub(crate) fn tested_spread(&self) -> Option<f64> {
        self.spread.s().filter(|_| self.tested)
    }

    /// Whether a cell with this combined value is retained: (37), that it is as good as the optimum, is not rejected in
    /// favor of (38), that it is worse.
    ///
    /// Source: (37), (38).
    pub(crate) fn keeps(&self, value: f64) -> bool {
        self.tested_spread().is_none_or(|s| {
            let z = z(value, self.optimum_value, s);
            z.is_nan() || z < self.threshold
        })
    }

    /// M_i+1: the cells of M_i that the test keeps.
    pub(crate) fn reduced(&self, before: &RetainedSet, points: &GridPoints, combined: &TracedSurface) -> RetainedSet {
        let mut after = before.clone();
        if self.tested_spread().is_some() {
            after.retain(points, combined.surface(), |value| self.keeps(value));
        }
        after
    }

    pub(crate) fn ends_campaign(&self, settings: &Settings) -> bool {
        settings.fallback == SpreadFallback::Stop && self.spread.s().is_none()
    }
}

/// Why and when a cell was dropped.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dropped {
    /// The batch that dropped it, from 1.
    pub iteration: usize,
    /// Ĵ of that batch at the cell.
    pub value: f64,
    /// Ĵ(p̂*) of that batch.
    pub optimum_value: f64,
    /// S of that batch.
    pub spread: f64,
    /// z of (39), at least z0.
    pub z: f64,
    /// z_0.
    pub z0: f64,
}
