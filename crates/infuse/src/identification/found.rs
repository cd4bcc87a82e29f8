//! What a fit found.

use serde::{Deserialize, Serialize};
use statrs::distribution::{ChiSquared, ContinuousCDF, Normal, StudentsT};

use super::settings::Noise;
use super::undetermined::Direction;
use crate::Error;

/// The end of its range that an unknown has run against.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RangeEnd {
    /// The lower one.
    Lower,
    /// The upper one.
    Upper,
}

/// Why a search ended.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FitStop {
    /// A step made no difference, or there is no slope left.
    Converged,
    /// The limit on the steps was reached.
    StepLimit,
    /// No step however short led to a lower sum of squares.
    NoBetterStep,
}

/// One unknown after a fit.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Estimate {
    /// Its name.
    pub name: String,
    /// Its unit, which all numbers here share.
    pub unit: String,
    /// Where it was believed to be.
    pub start: f64,
    /// Its bounds.
    pub range: [f64; 2],
    /// The estimate.
    pub value: f64,
    /// Its standard error; none at a bound, and none where it is not determined.
    pub standard_error: Option<f64>,
    /// The bound it has run against.
    pub bound: Option<RangeEnd>,
    /// Degrees of freedom of the noise; none where the noise is known.
    pub(super) degrees_of_freedom: Option<usize>,
}

impl Estimate {
    /// Whether what was measured determines it: it has a standard error, or is at a bound.
    #[must_use]
    pub fn is_determined(&self) -> bool {
        self.standard_error.is_some() || self.bound.is_some()
    }

    /// The two-sided interval that contains the truth with this probability, by Student's t where the noise was estimated and by the
    /// normal distribution where it is known; none without a standard error. It is not cut at the bounds.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] for a probability that is not between 0 and 1.
    pub fn interval(&self, probability: f64) -> Result<Option<[f64; 2]>, Error> {
        if !(probability > 0.0 && probability < 1.0) {
            return Err(Error::Setting { name: "probability", value: probability, expected: "between 0 and 1" });
        }
        let tail = 0.5 * (1.0 + probability);
        let quantile = match self.degrees_of_freedom {
            None => Normal::new(0.0, 1.0).map(|normal| normal.inverse_cdf(tail)).ok(),
            Some(freedom) => StudentsT::new(0.0, 1.0, freedom as f64).map(|t| t.inverse_cdf(tail)).ok(),
        };
        let half = self.standard_error.zip(quantile).map(|(error, quantile)| error * quantile);
        Ok(half.map(|half| [self.value - half, self.value + half]))
    }
}

/// What a fit found.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Identification {
    /// The unknowns, in their order.
    pub estimates: Vec<Estimate>,
    /// What was measured does not determine, one change of the unknowns after the other; along them the start was kept.
    pub undetermined: Vec<Direction>,
    /// Singular values of the Jacobian of the weighted residuals at the estimate, in shares of the ranges, largest first.
    pub singular_values: Vec<f64>,
    /// Sum of the squares of the weighted residuals at the estimate.
    pub sum_of_squares: f64,
    /// The same at the start.
    pub sum_of_squares_at_start: f64,
    /// Readings less unknowns that were fitted.
    pub degrees_of_freedom: usize,
    /// What is known of the noise.
    pub noise: Noise,
    /// σ: 1 where the noise is known, else the root of the sum of squares over the degrees of freedom.
    pub sigma: f64,
    /// Experiments that were fitted.
    pub n_experiments: usize,
    /// Experiments that had failed and were left out.
    pub n_failed_experiments: usize,
    /// Simulations of one design each.
    pub n_simulations: usize,
    /// Vectors of unknowns that the search had to turn back from, because the model failed.
    pub n_failed_simulations: usize,
    /// Steps of all searches.
    pub n_steps: usize,
    /// Why the last search ended.
    pub stop: FitStop,
    /// Correlations by unknown and unknown; none where one has no standard error.
    pub(super) correlations: Vec<Vec<Option<f64>>>,
}

impl Identification {
    /// The estimates alone.
    #[must_use]
    pub fn values(&self) -> Vec<f64> {
        self.estimates.iter().map(|estimate| estimate.value).collect()
    }

    /// Correlation of two estimates, −1 to 1, by their numbers from 0; none where one has no standard error.
    #[must_use]
    pub fn correlation(&self, i: usize, j: usize) -> Option<f64> {
        self.correlations.get(i)?.get(j).copied()?
    }

    /// How many times as large as the noise the residuals are: the root of the sum of squares over the degrees of freedom. None without
    /// degrees of freedom, and where the noise is estimated, because then it is what the residuals say.
    #[must_use]
    pub fn misfit(&self) -> Option<f64> {
        let is_told = self.noise == Noise::Known && self.degrees_of_freedom > 0;
        is_told.then(|| (self.sum_of_squares / self.degrees_of_freedom as f64).sqrt())
    }

    /// Probability of a sum of squares at least as large if the model were right: small where it is wrong, or the noise larger
    /// than told. None where there is no [`misfit`](Self::misfit).
    #[must_use]
    pub fn p_of_misfit(&self) -> Option<f64> {
        self.misfit()?;
        let distribution = ChiSquared::new(self.degrees_of_freedom as f64).ok()?;
        Some(distribution.sf(self.sum_of_squares))
    }

    /// What a person should know before using the estimates, one sentence each.
    #[must_use]
    pub fn warnings(&self) -> Vec<String> {
        let mut warnings: Vec<String> = self.undetermined.iter().map(|direction| direction.words.clone()).collect();
        for estimate in &self.estimates {
            let which = match estimate.bound {
                Some(RangeEnd::Lower) => "lower",
                Some(RangeEnd::Upper) => "upper",
                None => continue,
            };
            let Estimate { name, value, unit, .. } = estimate;
            let told = format!("`{name}` has run to its {which} bound of {value} {unit}");
            warnings.push(told.trim_end().to_owned());
        }
        const UNLIKELY: f64 = 0.01;
        if let Some((misfit, _)) = self.misfit().zip(self.p_of_misfit()).filter(|(_, p)| *p < UNLIKELY) {
            warnings.push(format!(
                "the residuals are {misfit:.1} times as large as the noise: the model is wrong, or the noise larger, and no \
                 standard error knows it"
            ));
        }
        if self.stop == FitStop::StepLimit {
            warnings.push(format!("the search was stopped after {} steps", self.n_steps));
        }
        if self.n_failed_experiments > 0 {
            warnings.push(format!("{} experiments had failed and were left out", self.n_failed_experiments));
        }
        warnings
    }
}
