//! What kind of quantity a number measures.

use std::collections::BTreeMap;
use std::fmt;
use std::ops::{Div, Mul};
use std::str::FromStr;

use num_rational::BigRational;
use num_traits::{One, Zero};

use crate::error::Error;
use crate::exponents::{Exponents, multiply, multiply_symbol, write_quotient};
use crate::parse::{Atom, parse};

/// A product of base dimensions to rational powers, such as `M*L/T^2`; exact, and of any size.
///
/// A base dimension is any symbol. Those of the SI are `M`, `L`, `T`, `I`, `Theta`, `N` and `J`.
///
/// ```
/// use scaling::Dimension;
///
/// let force: Dimension = "M*L/T^2".parse()?;
/// let pressure = &force / &"L^2".parse()?;
/// assert_eq!(pressure.to_string(), "M/(L*T^2)");
/// # Ok::<(), scaling::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Default, serde::Serialize, serde::Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Dimension {
    exponents: Exponents,
}

/// The order in which people name the bases of the SI.
const SI_ORDER: [&str; 7] = ["M", "L", "T", "I", "Theta", "N", "J"];

impl Dimension {
    /// The dimension of numbers.
    #[must_use]
    pub fn one() -> Self {
        Self::default()
    }

    /// A base dimension.
    ///
    /// # Errors
    /// [`Error::BadName`] unless the symbol is a letter or one of `_ % ‰ ° $ € £ ' "`, followed by letters, digits and `_`; `%` and
    /// `‰` stand alone.
    pub fn base(symbol: &str) -> Result<Self, Error> {
        if !crate::parse::is_plain(symbol) {
            return Err(Error::BadName {
                name: symbol.into(),
                expected: "a base dimension is a letter or one of _ % ‰ ° $ € £ ' \" followed by letters, digits and `_`, where % and ‰ \
                           stand alone",
            });
        }
        Ok(Self { exponents: BTreeMap::from([(symbol.to_owned(), BigRational::one())]) })
    }

    /// The exponent of a base dimension, zero if it does not occur.
    #[must_use]
    pub fn exponent(&self, base: &str) -> BigRational {
        self.exponents.get(base).cloned().unwrap_or_else(BigRational::zero)
    }

    /// The base dimensions that occur.
    pub fn bases(&self) -> impl Iterator<Item = &str> {
        self.exponents.keys().map(String::as_str)
    }

    /// Whether this is the dimension of numbers.
    #[must_use]
    pub fn is_one(&self) -> bool {
        self.exponents.is_empty()
    }

    /// The dimension to a rational power.
    #[must_use]
    pub fn pow(&self, power: &BigRational) -> Self {
        let mut exponents = Exponents::new();
        multiply(&mut exponents, &self.exponents, power);
        Self { exponents }
    }

    pub(crate) fn exponents(&self) -> &Exponents {
        &self.exponents
    }

    pub(crate) fn from_exponents(exponents: Exponents) -> Self {
        Self { exponents }
    }

    pub(crate) fn multiply(&mut self, factor: &Self, power: &BigRational) {
        multiply(&mut self.exponents, &factor.exponents, power);
    }
}

impl Mul for &Dimension {
    type Output = Dimension;
    fn mul(self, other: Self) -> Dimension {
        let mut product = self.clone();
        product.multiply(other, &BigRational::one());
        product
    }
}

impl Div for &Dimension {
    type Output = Dimension;
    fn div(self, other: Self) -> Dimension {
        let mut quotient = self.clone();
        quotient.multiply(other, &-BigRational::one());
        quotient
    }
}

impl fmt::Display for Dimension {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let rank = |symbol: &str| SI_ORDER.iter().position(|known| *known == symbol).unwrap_or(SI_ORDER.len());
        let mut factors: Vec<_> = self.exponents.iter().map(|(symbol, exponent)| (symbol.as_str(), exponent)).collect();
        factors.sort_by_key(|(symbol, _)| rank(symbol));
        write_quotient(f, factors.into_iter())
    }
}

impl FromStr for Dimension {
    type Err = Error;

    /// Reads what [`Display`](fmt::Display) writes, and every other product of powers; each symbol is a base dimension.
    fn from_str(text: &str) -> Result<Self, Error> {
        let mut exponents = Exponents::new();
        for term in parse(text, &|_| None)? {
            match term.atom {
                Atom::Symbol { symbol, .. } => multiply_symbol(&mut exponents, &symbol, &term.exponent),
                Atom::Number(number) if number.is_one() => {}
                Atom::Number(number) => {
                    return Err(Error::NumberInText { number: number.to_string(), text: text.into() });
                }
            }
        }
        Ok(Self { exponents })
    }
}

impl TryFrom<String> for Dimension {
    type Error = Error;
    fn try_from(text: String) -> Result<Self, Error> {
        text.parse()
    }
}

impl From<Dimension> for String {
    fn from(dimension: Dimension) -> Self {
        dimension.to_string()
    }
}
