//! One dimensionless product of variables.

use std::fmt;

use num_integer::Integer;
use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use crate::error::Error;
use crate::exponents::{Exponents, write_quotient};
use crate::number::{product_of_powers, shortest_decimal};
use crate::set_up::SetUp;
use crate::system::{Variable, check_name};

/// A dimensionless product of powers of variables.
#[derive(Debug, Clone, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(try_from = "Vec<(String, String)>", into = "Vec<(String, String)>")]
pub struct Group {
    /// Variables in the order of the system, with exponents other than zero.
    factors: Vec<(String, BigRational)>,
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

    pub(crate) fn exponents(&self) -> Exponents {
        self.factors.iter().cloned().collect()
    }
}

impl fmt::Display for Group {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_quotient(f, self.factors())
    }
}

impl TryFrom<Vec<(String, String)>> for Group {
    type Error = Error;
    fn try_from(texts: Vec<(String, String)>) -> Result<Self, Error> {
        let mut factors: Vec<(String, BigRational)> = Vec::with_capacity(texts.len());
        for (name, exponent) in texts {
            check_name(&name)?;
            if factors.iter().any(|(other, _)| *other == name) {
                return Err(Error::Duplicate { what: "factor of the group", name });
            }
            match exponent.parse::<BigRational>() {
                Ok(power) if !power.is_zero() => factors.push((name, power)),
                _ => return Err(Error::BadExponent { name, exponent }),
            }
        }
        Ok(Self { factors })
    }
}

impl From<Group> for Vec<(String, String)> {
    fn from(group: Group) -> Self {
        group.factors.into_iter().map(|(name, exponent)| (name, exponent.to_string())).collect()
    }
}
