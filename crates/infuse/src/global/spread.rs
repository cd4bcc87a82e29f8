//! S of (40): how far the combined surface lies from validation experiments.

use serde::{Deserialize, Serialize};

use crate::Error;
use crate::global::settings::SpreadFallback;
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

/// Why validation experiments give no spread.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SpreadFault {
    /// Fewer than two of them gave a response; in a [careful](crate::global::Settings::careful) campaign those at cells that
    /// taught the surface something do not count.
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
        /// Number of validation experiments that gave a response, and count.
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
