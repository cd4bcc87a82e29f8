//! Dimensionless products of variables.

use std::fmt;

use num_integer::Integer;
use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use crate::error::Error;
use crate::exponents::{Exponents, write_quotient};
use crate::number::{product_of_powers, shortest_decimal};
use crate::set_up::SetUp;
use crate::span::Span;
use crate::system::{System, Variable};

/// A dimensionless product of powers of variables.
#[derive(Debug, Clone, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(try_from = "Vec<(String, String)>", into = "Vec<(String, String)>")]
pub struct Group {
    /// Variables in the order of the system, with exponents other than zero.
    factors: Vec<(String, BigRational)>,
}

/// On which side of the line a group has the variable that does not repeat.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Orientation {
    /// `g*L_t/V^2`: above.
    #[default]
    Above,
    /// `V^2/(L_t*g)`: below.
    Below,
}

/// Independent groups of a system, from which all others are products of powers.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Groups {
    system: System,
    repeating: Vec<String>,
    groups: Vec<Group>,
}

impl Group {
    pub(crate) fn in_order(variables: &[Variable], mut exponents: Exponents) -> Self {
        let factors = variables.iter().filter_map(|v| exponents.remove(&v.name).map(|e| (v.name.clone(), e)));
        Self { factors: factors.collect() }
    }

    /// The exponent of a variable, zero if it does not occur.
    #[must_use]
    pub fn exponent(&self, variable: &str) -> BigRational {
        self.factors.iter().find(|(name, _)| name == variable).map_or_else(BigRational::zero, |(_, e)| e.clone())
    }

    /// Variables and exponents in the order of the system.
    pub fn factors(&self) -> impl Iterator<Item = (&str, &BigRational)> {
        self.factors.iter().map(|(name, exponent)| (name.as_str(), exponent))
    }

    /// The group to a rational power.
    #[must_use]
    pub fn pow(&self, power: &BigRational) -> Self {
        let factors = self.factors.iter().map(|(name, e)| (name.clone(), e * power));
        Self { factors: factors.filter(|(_, e)| !e.is_zero()).collect() }
    }

    /// One divided by the group.
    #[must_use]
    pub fn inverse(&self) -> Self {
        self.pow(&-BigRational::one())
    }

    /// The value at a set-up, rounded once: the shortest decimals of the values, taken exactly.
    ///
    /// # Errors
    /// [`Error::MissingValue`]; [`Error::BadValue`] if a value is not finite, is zero and stands in the denominator,
    /// or is negative under an even root; [`Error::GroupOutOfRange`].
    pub fn value(&self, set_up: &SetUp) -> Result<f64, Error> {
        let mut powers = Vec::with_capacity(self.factors.len());
        let (mut negative, mut zero) = (false, false);
        for (name, exponent) in &self.factors {
            let value = set_up.value(name).ok_or_else(|| Error::MissingValue {
                set_up: set_up.name().to_owned(),
                variable: name.clone(),
                group: self.to_string(),
            })?;
            let bad = |reason| self.bad_value(set_up, name, value, reason);
            let exact = shortest_decimal(value).ok_or_else(|| bad("needs a finite number"))?;
            if exact.is_zero() && exponent.is_negative() {
                return Err(bad("divides by it"));
            }
            if exact.is_negative() && exponent.denom().is_even() {
                return Err(bad("takes an even root of it"));
            }
            zero |= exact.is_zero();
            negative ^= exact.is_negative() && exponent.numer().is_odd();
            powers.push((exact.abs(), exponent));
        }
        if zero {
            return Ok(0.0);
        }
        let magnitude = product_of_powers(powers.iter().map(|(base, exponent)| (base, *exponent)));
        if !magnitude.is_normal() {
            return Err(Error::GroupOutOfRange { set_up: set_up.name().to_owned(), group: self.to_string() });
        }
        Ok(if negative { -magnitude } else { magnitude })
    }

    fn bad_value(&self, set_up: &SetUp, variable: &str, value: f64, reason: &'static str) -> Error {
        Error::BadValue {
            set_up: set_up.name().to_owned(),
            variable: variable.to_owned(),
            value,
            group: self.to_string(),
            reason,
        }
    }

    fn exponents(&self) -> Exponents {
        self.factors.iter().cloned().collect()
    }
}

impl Groups {
    pub(crate) fn new(system: System, repeating: Vec<String>, groups: Vec<Group>) -> Self {
        Self { system, repeating, groups }
    }

    /// The groups in the order of their variables that do not repeat.
    pub fn iter(&self) -> std::slice::Iter<'_, Group> {
        self.groups.iter()
    }

    /// How many groups there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.groups.len()
    }

    /// Whether there are no groups.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.groups.is_empty()
    }

    /// The system whose groups these are.
    #[must_use]
    pub fn system(&self) -> &System {
        &self.system
    }

    /// The repeating variables.
    #[must_use]
    pub fn repeating(&self) -> &[String] {
        &self.repeating
    }

    /// The same groups with the variables that do not repeat above or below the line.
    #[must_use]
    pub fn oriented(mut self, orientation: Orientation) -> Self {
        for group in &mut self.groups {
            let own = group.factors.iter().find(|(name, _)| !self.repeating.contains(name));
            let above = own.is_some_and(|(_, exponent)| exponent.is_positive());
            if above != (orientation == Orientation::Above) {
                *group = group.inverse();
            }
        }
        self
    }

    /// Whether other groups say the same: each is a product of powers of the other set's, in both directions.
    ///
    /// Groups that are written twice or depend on each other add nothing, so the counts may differ.
    #[must_use]
    pub fn span_same_space<'a>(&self, others: impl IntoIterator<Item = &'a Group>) -> bool {
        let mut span = Span::default();
        for group in &self.groups {
            let _ = span.insert(&group.to_string(), &group.exponents());
        }
        let mut theirs = Span::default();
        for group in others {
            if span.express(&group.exponents()).is_err() {
                return false;
            }
            // What depends on the former ones adds nothing to the rank.
            let _ = theirs.insert(&group.to_string(), &group.exponents());
        }
        theirs.rank() == span.rank()
    }
}

impl<'a> IntoIterator for &'a Groups {
    type Item = &'a Group;
    type IntoIter = std::slice::Iter<'a, Group>;
    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

impl fmt::Display for Group {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_quotient(f, self.factors())
    }
}

impl TryFrom<Vec<(String, String)>> for Group {
    type Error = num_rational::ParseRatioError;
    fn try_from(factors: Vec<(String, String)>) -> Result<Self, Self::Error> {
        let factors = factors.into_iter().map(|(name, exponent)| Ok((name, exponent.parse()?)));
        Ok(Self { factors: factors.collect::<Result<_, Self::Error>>()? })
    }
}

impl From<Group> for Vec<(String, String)> {
    fn from(group: Group) -> Self {
        group.factors.into_iter().map(|(name, exponent)| (name, exponent.to_string())).collect()
    }
}
