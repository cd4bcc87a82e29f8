//! Conversion factors and ratios without rounding.

use std::collections::BTreeMap;
use std::fmt;
use std::ops::{Div, Mul};
use std::str::FromStr;
use std::sync::LazyLock;

use num_bigint::{BigInt, BigUint};
use num_integer::Integer;
use num_rational::BigRational;
use num_traits::{One, Pow, Signed, ToPrimitive, Zero};

use crate::error::Error;
use crate::number::{is_short_decimal, log2, nearest, perfect_power, product_of_powers, shortest_decimal};
use crate::parse::{Atom, parse};

/// A positive number, held exactly as a product of integers to rational powers and a power of pi.
///
/// Products, quotients and powers are exact, equality is exact, and perfect powers come out as such: `100^(1/2)` is 10.
///
/// # Rounding
/// Everything is exact except the f64 that goes in and the f64 that comes out.
/// A number of at most 15 significant digits is taken as the decimal that someone wrote, a longer one as the f64 that something computed; it is multiplied exactly and rounded once.
/// (A long decimal whose product has at most 15 digits counts as written, too.)
/// Irrational factors are evaluated from their exact radicand, so they are rounded once as well; pi enters with 100 decimals.
///
/// There and back, bit for bit: whenever the converted number has at most 15 significant digits.
/// Otherwise the number returns within one unit in the last place, or two in the rare case that the rounded product, or the way back, happens to be a decimal of 15 digits.
/// One unit cannot be promised by any rule: two neighbors may share one converted number, each up to one unit from where it points, and if a 15-digit decimal is among them it has the right to return.
/// Among 600,000 random conversions of various kinds, 80 came back by two units and none by more.
///
/// Values of groups and irrational factors whose exact radicand would have more than 2^13 bits keep 320 of them, which is still one rounding for every practical purpose.
///
/// ```
/// use scaling::Factor;
///
/// let speed = "100".parse::<Factor>()?.pow(&"1/2".parse()?);
/// assert_eq!(speed.to_string(), "10");
/// let degree: Factor = "pi/180".parse()?;
/// assert_eq!(degree.inverse().apply(degree.apply(17.3)), 17.3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Default, serde::Serialize, serde::Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Factor {
    /// Pairwise coprime integers above 1, none a perfect power, with exponents other than zero.
    bases: BTreeMap<BigUint, BigRational>,
    pi: BigRational,
}

/// Divisors up to here are split off; what remains is held coprime by common divisors.
const TRIAL_LIMIT: u32 = 1 << 12;

/// Integers above this many bits are written as a power, not digit by digit.
const WRITTEN_BITS: u64 = 1024;

/// 100 decimals: far below the rounding of an f64 even after a root or a power.
#[expect(clippy::expect_used, reason = "a constant of this file")]
static PI: LazyLock<BigRational> = LazyLock::new(|| {
    crate::number::decimal(
        "3.1415926535897932384626433832795028841971693993751058209749445923078164062862089986280348253421170679",
    )
    .expect("a decimal")
});

impl Factor {
    /// The factor that changes nothing.
    #[must_use]
    pub fn one() -> Self {
        Self::default()
    }

    /// The circle constant.
    #[must_use]
    pub fn pi() -> Self {
        Self { bases: BTreeMap::new(), pi: BigRational::one() }
    }

    /// A rational number.
    ///
    /// # Errors
    /// [`Error::NotPositive`] for zero and negative numbers.
    pub fn from_rational(value: &BigRational) -> Result<Self, Error> {
        if !value.is_positive() {
            return Err(Error::NotPositive { value: value.to_string() });
        }
        let mut factor = Self::one();
        factor.multiply(value.numer().magnitude().clone(), BigRational::one());
        factor.multiply(value.denom().magnitude().clone(), -BigRational::one());
        Ok(factor)
    }

    /// The number that the shortest decimal of an f64 names: 0.1 is one tenth.
    ///
    /// # Errors
    /// [`Error::NotPositive`] unless the number is finite and positive.
    pub fn from_f64(value: f64) -> Result<Self, Error> {
        let exact = shortest_decimal(value).ok_or_else(|| Error::NotPositive { value: value.to_string() })?;
        Self::from_rational(&exact)
    }

    /// Whether this is exactly 1.
    #[must_use]
    pub fn is_one(&self) -> bool {
        self.bases.is_empty() && self.pi.is_zero()
    }

    /// One divided by this.
    #[must_use]
    pub fn inverse(&self) -> Self {
        self.pow(&-BigRational::one())
    }

    /// This to a rational power.
    #[must_use]
    pub fn pow(&self, power: &BigRational) -> Self {
        let mut factor = Self { bases: BTreeMap::new(), pi: &self.pi * power };
        if !power.is_zero() {
            factor.bases = self.bases.iter().map(|(base, exponent)| (base.clone(), exponent * power)).collect();
        }
        factor
    }

    /// The exact value, if it is rational and its digits are of any use (below 2^262144).
    #[must_use]
    pub fn rational(&self) -> Option<BigRational> {
        let integral = self.pi.is_zero() && self.bases.values().all(BigRational::is_integer);
        let bits: f64 =
            self.bases.iter().map(|(base, e)| base.bits() as f64 * e.abs().to_f64().unwrap_or(f64::INFINITY)).sum();
        if !integral || bits > 262_144.0 {
            return None;
        }
        self.bases.iter().try_fold(BigRational::one(), |product, (base, exponent)| {
            Some(product * Pow::pow(integer(base), exponent.to_i32()?))
        })
    }

    /// The nearest f64, infinite or zero beyond its range.
    #[must_use]
    pub fn to_f64(&self) -> f64 {
        self.times(BigRational::one())
    }

    /// The base-10 logarithm, for a factor beyond the range of f64.
    #[must_use]
    pub fn log10(&self) -> f64 {
        let log2: f64 = self.factors().iter().map(|(base, e)| log2(base) * e.to_f64().unwrap_or(f64::NAN)).sum();
        log2 * std::f64::consts::LOG10_2
    }

    /// Multiplies a number exactly and rounds once, to the nearest f64.
    ///
    /// A number of at most 15 significant digits is the decimal that someone wrote: 0.1 is one tenth.
    /// A longer one came out of a computation and is the f64 itself, unless the product of its shortest decimal has
    /// at most 15 digits.
    ///
    /// If the product has at most 15 digits, the inverse factor therefore returns the number bit for bit.
    /// Otherwise it returns it within one unit in the last place, or two where the rounded product or the way back
    /// happens to be such a short decimal; no rule can promise one unit always, as is said of [`Factor`].
    /// Zero, infinities and NaN come back as they are.
    #[must_use]
    pub fn apply(&self, value: f64) -> f64 {
        let (Some(decimal), Some(binary)) = (shortest_decimal(value.abs()), BigRational::from_float(value.abs()))
        else {
            return value;
        };
        if decimal.is_zero() || self.is_one() {
            return value;
        }
        let magnitude = match self.rational() {
            Some(rational) => {
                let product = &rational * &decimal;
                let written = is_short_decimal(&decimal) || is_short_decimal(&product);
                nearest(&if written { product } else { rational * binary })
            }
            None => self.times(if is_short_decimal(&decimal) { decimal } else { binary }),
        };
        magnitude.copysign(value)
    }

    fn times(&self, magnitude: BigRational) -> f64 {
        if let Some(rational) = self.rational() {
            return nearest(&(rational * magnitude));
        }
        let mut factors = self.factors();
        factors.push((magnitude, BigRational::one()));
        product_of_powers(factors.iter().map(|(base, exponent)| (base, exponent)))
    }

    fn factors(&self) -> Vec<(BigRational, BigRational)> {
        let integers = self.bases.iter().map(|(base, exponent)| (integer(base), exponent.clone()));
        integers.chain((!self.pi.is_zero()).then(|| (PI.clone(), self.pi.clone()))).collect()
    }

    /// The product, in which exponents are added.
    fn joined(&self, other: &Self) -> Self {
        let mut product = self.clone();
        product.pi += &other.pi;
        for (base, exponent) in &other.bases {
            product.multiply(base.clone(), exponent.clone());
        }
        product
    }

    /// Multiplies by `base^exponent`, keeping the bases coprime.
    fn multiply(&mut self, mut base: BigUint, exponent: BigRational) {
        let mut prime = 2u32;
        while prime < TRIAL_LIMIT && base >= BigUint::from(prime) * prime {
            let mut count = 0u32;
            while (&base % prime).is_zero() {
                base /= prime;
                count += 1;
            }
            if count > 0 {
                self.add(BigUint::from(prime), &exponent * integer(&count.into()));
            }
            prime += if prime == 2 { 1 } else { 2 };
        }
        let mut work = vec![(base, exponent)];
        while let Some((base, exponent)) = work.pop() {
            let (base, degree) = perfect_power(&base);
            let exponent = exponent * integer(&degree.into());
            if base.is_one() || exponent.is_zero() {
                continue;
            }
            let shared = self.bases.keys().find(|known| **known != base && !known.gcd(&base).is_one()).cloned();
            let Some(known) = shared else {
                self.add(base, exponent);
                continue;
            };
            let known_exponent = self.bases.remove(&known).unwrap_or_default();
            let divisor = known.gcd(&base);
            work.push((&base / &divisor, exponent.clone()));
            work.push((&known / &divisor, known_exponent.clone()));
            work.push((divisor, exponent + known_exponent));
        }
    }

    fn add(&mut self, base: BigUint, exponent: BigRational) {
        let sum = self.bases.remove(&base).unwrap_or_default() + exponent;
        if !sum.is_zero() {
            self.bases.insert(base, sum);
        }
    }
}

fn integer(n: &BigUint) -> BigRational {
    BigRational::from_integer(BigInt::from(n.clone()))
}

impl PartialEq for Factor {
    fn eq(&self, other: &Self) -> bool {
        (self / other).is_one()
    }
}

impl Eq for Factor {}

impl Mul for &Factor {
    type Output = Factor;
    fn mul(self, other: Self) -> Factor {
        self.joined(other)
    }
}

impl Div for &Factor {
    type Output = Factor;
    fn div(self, other: Self) -> Factor {
        self.joined(&other.inverse())
    }
}

impl fmt::Display for Factor {
    /// Writes `1225`, `49/40000`, `10^(1/2)`, `pi/180`, so that it reads back exactly (exponents up to 1000, numbers up
    /// to 400 digits).
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut fractional: BTreeMap<BigRational, BigUint> = BTreeMap::new();
        let mut powers: Vec<(String, BigRational)> = Vec::new();
        let (mut above, mut below) = (BigUint::one(), BigUint::one());
        for (base, exponent) in &self.bases {
            let small = exponent.is_integer()
                && base.bits() as f64 * exponent.abs().to_f64().unwrap_or(f64::INFINITY) < WRITTEN_BITS as f64;
            match exponent.to_i32() {
                Some(power) if small => {
                    let side = if power > 0 { &mut above } else { &mut below };
                    *side *= Pow::pow(base, power.unsigned_abs());
                }
                _ => *fractional.entry(exponent.clone()).or_insert_with(BigUint::one) *= base,
            }
        }
        powers.extend(fractional.into_iter().map(|(exponent, base)| (base.to_string(), exponent)));
        if !self.pi.is_zero() {
            powers.push(("pi".to_owned(), self.pi.clone()));
        }
        let power = |(base, exponent): &(String, BigRational)| match exponent.abs() {
            e if e.is_one() => base.clone(),
            e if e.is_integer() => format!("{base}^{e}"),
            e => format!("{base}^({e})"),
        };
        let side = |integer: &BigUint, positive: bool| {
            let mut words = vec![integer.to_string()];
            words.extend(powers.iter().filter(|(_, e)| e.is_positive() == positive).map(power));
            if integer.is_one() && words.len() > 1 {
                words.remove(0);
            }
            words
        };
        f.write_str(&side(&above, true).join("*"))?;
        match side(&below, false).as_slice() {
            [one] if one == "1" => Ok(()),
            [single] => write!(f, "/{single}"),
            several => write!(f, "/({})", several.join("*")),
        }
    }
}

impl FromStr for Factor {
    type Err = Error;

    /// Reads arithmetic such as `100`, `1.225/1000`, `2^(1/2)`, `pi/180`.
    fn from_str(text: &str) -> Result<Self, Error> {
        parse(text, &|_| None)?.into_iter().try_fold(Self::one(), |product, term| {
            let base = match term.atom {
                Atom::Number(number) => Self::from_rational(&number)?,
                Atom::Symbol { symbol, .. } if symbol == "pi" || symbol == "π" => Self::pi(),
                Atom::Symbol { symbol, position } => {
                    return Err(Error::UnknownSymbol {
                        what: "number",
                        symbol,
                        position,
                        text: text.into(),
                        near: vec!["pi".into()],
                    });
                }
            };
            Ok(&product * &base.pow(&term.exponent))
        })
    }
}

impl TryFrom<String> for Factor {
    type Error = Error;
    fn try_from(text: String) -> Result<Self, Error> {
        text.parse()
    }
}

impl From<Factor> for String {
    fn from(factor: Factor) -> Self {
        factor.to_string()
    }
}
