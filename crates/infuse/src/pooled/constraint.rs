//! What a design has to keep to: responses within bounds, and settings that do not go together.

use design_space::Region;
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, Normal};

use crate::Error;

/// A response that has to stay within bounds: a second thing that each experiment measures.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Constraint {
    /// Its name.
    pub name: String,
    /// What is allowed at least, in its unit.
    #[serde(default)]
    pub lower: Option<f64>,
    /// What is allowed at most, in its unit.
    #[serde(default)]
    pub upper: Option<f64>,
    /// A design is recommended if it keeps to the bounds with this probability. Default 0.9.
    #[serde(default = "default_probability")]
    pub probability: f64,
    /// Standard deviation of one reading of it, where that is known; otherwise it is learnt.
    #[serde(default)]
    pub noise: Option<f64>,
}

fn default_probability() -> f64 {
    0.9
}

impl Constraint {
    /// A constraint of this name without bounds, the rest as documented per field: set at least one of them.
    pub fn new(name: impl Into<String>) -> Self {
        Self { name: name.into(), lower: None, upper: None, probability: default_probability(), noise: None }
    }

    /// A response of at most this.
    pub fn at_most(name: impl Into<String>, upper: f64) -> Self {
        Self { upper: Some(upper), ..Self::new(name) }
    }

    /// A response of at least this.
    pub fn at_least(name: impl Into<String>, lower: f64) -> Self {
        Self { lower: Some(lower), ..Self::new(name) }
    }

    /// Whether a value keeps to it.
    #[must_use]
    pub fn allows(&self, value: f64) -> bool {
        self.lower.is_none_or(|lower| value >= lower) && self.upper.is_none_or(|upper| value <= upper)
    }

    /// Whether it is usable.
    ///
    /// # Errors
    ///
    /// [`Error::Constraint`]: a bound, a probability or a noise that cannot be.
    pub fn validate(&self) -> Result<(), Error> {
        let fault =
            |field, value, expected| Err(Error::Constraint { constraint: self.name.clone(), field, value, expected });
        for (field, bound) in [("lower", self.lower), ("upper", self.upper)] {
            if let Some(value) = bound.filter(|bound| bound.is_nan() || bound.abs() > surface::Data::LARGEST) {
                return fault(field, value, "a number of at most 1e100 in magnitude");
            }
        }
        match (self.lower, self.upper) {
            (None, None) => return fault("upper", f64::NAN, "at least one of the two bounds"),
            (Some(lower), Some(upper)) if lower >= upper => {
                return fault("upper", upper, "a bound above the lower one");
            }
            _ => {}
        }
        if !(0.5..=0.999).contains(&self.probability) {
            return fault("probability", self.probability, "0.5 to 0.999");
        }
        match self.noise.filter(|noise| !(0.0..=1e100).contains(noise)) {
            Some(noise) => fault("noise", noise, "a number from 0 to 1e100"),
            None => Ok(()),
        }
    }

    /// Probability that a normal quantity keeps to it.
    pub(crate) fn probability_of(&self, mean: f64, deviation: f64) -> f64 {
        if deviation <= 0.0 {
            return if self.allows(mean) { 1.0 } else { 0.0 };
        }
        let normal = Normal::standard();
        let below = |bound: f64| normal.cdf((bound - mean) / deviation);
        let up_to = self.upper.map_or(1.0, below);
        (up_to - self.lower.map_or(0.0, below)).clamp(0.0, 1.0)
    }
}

/// Settings that go together: Σ cⱼ xⱼ ≤ `upper`, xⱼ natural. Designs that break it are neither asked for nor recommended.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LinearConstraint {
    /// cⱼ, one per parameter, in 1 over its unit times the unit of `upper`.
    pub coefficients: Vec<f64>,
    /// What the sum may be at most.
    pub upper: f64,
}

impl LinearConstraint {
    /// Σ cⱼ xⱼ ≤ `upper`.
    #[must_use]
    pub fn at_most(coefficients: Vec<f64>, upper: f64) -> Self {
        Self { coefficients, upper }
    }

    /// Σ cⱼ xⱼ ≥ `lower`.
    #[must_use]
    pub fn at_least(coefficients: &[f64], lower: f64) -> Self {
        Self { coefficients: coefficients.iter().map(|coefficient| -coefficient).collect(), upper: -lower }
    }

    /// By how much the sum is above what is allowed, at a natural point; negative if it is below.
    #[must_use]
    pub fn excess(&self, point: &[f64]) -> f64 {
        self.coefficients.iter().zip(point).map(|(coefficient, x)| coefficient * x).sum::<f64>() - self.upper
    }

    /// Whether a natural point keeps to it, but for rounding.
    #[must_use]
    pub fn allows(&self, point: &[f64]) -> bool {
        let size: f64 = self.coefficients.iter().zip(point).map(|(coefficient, x)| (coefficient * x).abs()).sum();
        self.excess(point) <= 1e-9 * (size + self.upper.abs())
    }

    pub(crate) fn validate(&self, number: usize, region: &Region) -> Result<(), Error> {
        let constraint = || format!("linear constraint {number}");
        let fault =
            |field, value, expected| Err(Error::Constraint { constraint: constraint(), field, value, expected });
        if self.coefficients.len() != region.n_parameters() {
            return fault("coefficients", self.coefficients.len() as f64, "one per parameter");
        }
        let is_usable = |value: f64| value.abs() <= surface::Data::LARGEST;
        if let Some(&value) = self.coefficients.iter().find(|value| !is_usable(**value)) {
            return fault("coefficients", value, "numbers of at most 1e100 in magnitude");
        }
        if self.coefficients.iter().all(|coefficient| *coefficient == 0.0) {
            return fault("coefficients", 0.0, "at least one that is not zero");
        }
        if !is_usable(self.upper) {
            return fault("upper", self.upper, "a number of at most 1e100 in magnitude");
        }
        let mut concerned =
            region.parameters().iter().zip(&self.coefficients).filter(|(_, coefficient)| **coefficient != 0.0);
        concerned.try_for_each(|(parameter, _)| Ok(parameter.check_number()?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn between() -> Constraint {
        let mut both = Constraint::at_most("travel", 1.5);
        both.lower = Some(0.5);
        both
    }

    #[test]
    fn bounds_themselves_are_kept_to() {
        for (value, expected) in [(0.4, false), (0.5, true), (1.0, true), (1.5, true), (1.6, false)] {
            assert_eq!(between().allows(value), expected, "{value}");
        }
        assert!(Constraint::at_least("travel", 0.5).allows(9.0) && !Constraint::at_least("travel", 0.5).allows(0.0));
    }

    /// Mean 1 and deviation 1/2: one deviation to either side, by a table of the normal distribution.
    #[test]
    fn probability_is_that_of_a_normal_quantity_between_the_bounds() {
        let close = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-9, "{found}, not {expected}");
        close(between().probability_of(1.0, 0.5), 0.682_689_492_137);
        close(Constraint::at_most("travel", 1.5).probability_of(1.0, 0.5), 0.841_344_746_069);
        close(Constraint::at_least("travel", 1.5).probability_of(1.0, 0.5), 0.158_655_253_931);
        close(between().probability_of(1.4, 0.0), 1.0);
        close(between().probability_of(1.6, 0.0), 0.0);
    }

    #[test]
    fn constraints_that_cannot_be_are_refused_and_others_are_not() {
        let with = |change: fn(&mut Constraint)| {
            let mut constraint = between();
            change(&mut constraint);
            constraint.validate().is_ok()
        };
        assert!(with(|_| ()) && with(|one| one.probability = 0.5) && with(|one| one.noise = Some(0.0)));
        assert!(with(|one| one.upper = None) && with(|one| one.lower = None));
        assert!(!with(|one| one.probability = 0.4) && !with(|one| one.probability = 1.0));
        assert!(!with(|one| one.lower = Some(1.5)) && !with(|one| one.upper = Some(f64::NAN)));
        assert!(!with(|one| (one.lower, one.upper) = (None, None)) && !with(|one| one.noise = Some(-1.0)));
    }

    #[test]
    fn excess_is_how_far_a_sum_is_above_what_it_may_be() {
        let sum = LinearConstraint::at_most(vec![2.0, -1.0], 3.0);
        assert!((sum.excess(&[2.0, 0.5]) - 0.5).abs() < 1e-15 && !sum.allows(&[2.0, 0.5]));
        assert!((sum.excess(&[1.0, 0.5]) + 1.5).abs() < 1e-15 && sum.allows(&[1.0, 0.5]));
        assert!(!LinearConstraint::at_least(&[1.0], 2.0).allows(&[1.9]));
    }
}
