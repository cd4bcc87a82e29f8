//! Numbers between text, exact rationals and f64.

use num_bigint::{BigInt, BigUint, Sign};
use num_integer::Integer;
use num_rational::BigRational;
use num_traits::{One, Pow, Signed, ToPrimitive, Zero};

/// Longest mantissa and largest power of ten of a decimal text.
const DECIMAL_LIMIT: usize = 400;

/// The exact value of a decimal such as `-1.225e-3`; none if it is no number or beyond any use.
pub(crate) fn decimal(text: &str) -> Option<BigRational> {
    let (mantissa, power) = match text.split_once(['e', 'E']) {
        Some((mantissa, power)) => (mantissa, power.parse::<i64>().ok()?),
        None => (text, 0),
    };
    let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    let digits = format!("{whole}{fraction}");
    let unsigned = digits.strip_prefix(['+', '-']).unwrap_or(&digits);
    let proper = !unsigned.is_empty() && unsigned.bytes().all(|b| b.is_ascii_digit());
    if !proper || digits.len() > DECIMAL_LIMIT || power.unsigned_abs() > DECIMAL_LIMIT as u64 {
        return None;
    }
    let power = power - i64::try_from(fraction.len()).ok()?;
    let ten = BigInt::from(10u8).pow(u32::try_from(power.unsigned_abs()).ok()?);
    let integer: BigInt = digits.parse().ok()?;
    Some(if power < 0 { BigRational::new(integer, ten) } else { BigRational::from_integer(integer * ten) })
}

/// The shortest decimal that names this f64, as an exact number; none for infinities and NaN.
pub(crate) fn shortest_decimal(value: f64) -> Option<BigRational> {
    if value.is_finite() { decimal(&format!("{value:e}")) } else { None }
}

/// Whether an exact number is a decimal of at most 15 significant digits, which every f64 keeps.
pub(crate) fn is_short_decimal(value: &BigRational) -> bool {
    let five = BigUint::from(5u8);
    let mut rest = value.denom().magnitude().clone();
    let twos = rest.trailing_zeros().unwrap_or(0);
    rest >>= twos;
    let mut fives = 0u64;
    while (&rest % &five).is_zero() {
        rest /= &five;
        fives += 1;
    }
    if !rest.is_one() {
        return false;
    }
    let ten = BigUint::from(10u8);
    let mut digits = (value * BigRational::from_integer(Pow::pow(BigInt::from(10u8), twos.max(fives)))).to_integer();
    let limit = BigInt::from(10u64.pow(15));
    while digits.magnitude() >= limit.magnitude() && (digits.magnitude() % &ten).is_zero() {
        digits /= 10;
    }
    digits.magnitude() < limit.magnitude()
}

/// The f64 nearest to `radicand^(1/degree) * 2^scale` (ties to even), for a positive radicand and degree.
///
/// Rounded once: the root is cut after 64 bits, and whether anything was cut decides the ties.
/// Beyond the range of f64 it is infinite or zero.
fn nearest_root(radicand: &BigRational, degree: u32, scale: i64) -> f64 {
    let p = radicand.numer().magnitude();
    let q = radicand.denom().magnitude();
    let degree_bits = i64::from(degree);
    let bits = |n: &BigUint| i64::try_from(n.bits()).unwrap_or(i64::MAX / 4);
    // p/q lies between 2^(excess - 1) and 2^(excess + 1).
    let excess = bits(p) - bits(q);
    let exponent = excess.div_euclid(degree_bits);
    if exponent.saturating_add(scale) > 1100 {
        return f64::INFINITY;
    }
    if exponent.saturating_add(scale) < -1200 {
        return 0.0;
    }
    let shift = 66 - exponent;
    let powers = shift * degree_bits;
    let (numerator, denominator) =
        if powers >= 0 { (p << powers.unsigned_abs(), q.clone()) } else { (p.clone(), q << powers.unsigned_abs()) };
    let (quotient, remainder) = numerator.div_rem(&denominator);
    let root = quotient.nth_root(degree);
    let exact = remainder.is_zero() && Pow::pow(&root, degree) == quotient;
    let sticky = (root << 1u32) | BigUint::from(u8::from(!exact));
    round_binary(&sticky, shift + 1 - scale)
}

/// The f64 nearest to `mantissa * 2^-scale`, ties to even.
fn round_binary(mantissa: &BigUint, scale: i64) -> f64 {
    let bits = i64::try_from(mantissa.bits()).unwrap_or(i64::MAX / 4);
    // Keep 53 bits, and nothing below the smallest subnormal, 2^-1074.
    let dropped = (bits - 53).max(scale - 1074).max(0);
    let mut kept = mantissa >> dropped.unsigned_abs();
    let rest = mantissa - (&kept << dropped.unsigned_abs());
    let twice = rest << 1u32;
    let half = BigUint::one() << dropped.unsigned_abs();
    if twice > half || (twice == half && kept.is_odd()) {
        kept += 1u32;
    }
    let exponent = dropped - scale;
    let significand = kept.to_u64().map_or(f64::INFINITY, |n| n as f64);
    if exponent > 1000 {
        return f64::INFINITY;
    }
    // In two steps, both exact: the first stays normal, the second meets a representable number.
    let first = exponent.clamp(-1000, 1000);
    significand * power_of_two(first) * power_of_two(exponent - first)
}

fn power_of_two(exponent: i64) -> f64 {
    f64::from_bits(u64::try_from(exponent + 1023).unwrap_or(0) << 52)
}

/// The f64 nearest to a rational, ties to even.
pub(crate) fn nearest(value: &BigRational) -> f64 {
    if value.is_zero() {
        return 0.0;
    }
    let magnitude = nearest_root(&value.abs(), 1, 0);
    if value.numer().sign() == Sign::Minus { -magnitude } else { magnitude }
}

/// The base-2 logarithm of a positive rational, good to about 1e-15 of its size, whatever that is.
pub(crate) fn log2(value: &BigRational) -> f64 {
    let part = |n: &BigInt| {
        let n = n.magnitude();
        let dropped = n.bits().saturating_sub(64);
        (n >> dropped).to_f64().map_or(f64::INFINITY, f64::log2) + dropped as f64
    };
    part(value.numer()) - part(value.denom())
}

/// `n = root^degree` with the largest degree; 1 stays 1.
pub(crate) fn perfect_power(n: &BigUint) -> (BigUint, u32) {
    if n.is_one() {
        return (n.clone(), 1);
    }
    let most = u32::try_from(n.bits()).unwrap_or(u32::MAX);
    for degree in (2..=most).rev() {
        let root = n.nth_root(degree);
        if !root.is_one() && Pow::pow(&root, degree) == *n {
            return (root, degree);
        }
    }
    (n.clone(), 1)
}

/// Bits of intermediate integers up to which products are exact.
const EXACT_BITS: f64 = 8192.0;

/// Largest common denominator of exponents for which roots are taken.
const DEGREE_LIMIT: u32 = 1 << 16;

/// The product of positive bases to rational powers, rounded once.
///
/// Beyond integers of 2^13 bits the radicand keeps 320 of them, with a relative error of 2^-320 times the exponents.
/// Only for exponents above 2^63 or with a common denominator above 2^16 are logarithms taken instead (error 1e-15
/// of the sum of their magnitudes).
pub(crate) fn product_of_powers<'a>(factors: impl Iterator<Item = (&'a BigRational, &'a BigRational)> + Clone) -> f64 {
    root_of_product(factors.clone()).unwrap_or_else(|| {
        factors.map(|(base, exponent)| log2(base) * exponent.to_f64().unwrap_or(f64::NAN)).sum::<f64>().exp2()
    })
}

fn root_of_product<'a>(factors: impl Iterator<Item = (&'a BigRational, &'a BigRational)> + Clone) -> Option<f64> {
    let degree = factors.clone().fold(BigInt::one(), |degree, (_, exponent)| degree.lcm(exponent.denom()));
    let degree = degree.to_u32().filter(|degree| *degree <= DEGREE_LIMIT)?;
    let powers = factors.map(|(base, exponent)| {
        let power = exponent * BigRational::from_integer(degree.into());
        Some((base, power.to_integer().to_i64()?))
    });
    let powers: Vec<(&BigRational, i64)> = powers.collect::<Option<_>>()?;
    let bits = |(base, power): &(&BigRational, i64)| {
        (base.numer().bits() + base.denom().bits()) as f64 * power.unsigned_abs() as f64
    };
    if powers.iter().map(bits).sum::<f64>() <= EXACT_BITS {
        let exact = |product: BigRational, (base, power): &(&BigRational, i64)| {
            Some(product * Pow::pow(*base, i32::try_from(*power).ok()?))
        };
        let radicand = powers.iter().try_fold(BigRational::one(), exact)?;
        return Some(nearest_root(&radicand, degree, 0));
    }
    let product = powers.iter().fold(Truncated::one(), |product, (base, power)| {
        product.times(&Truncated::new(base, *power < 0).pow(power.unsigned_abs()))
    });
    // 2^exponent in the radicand is 2^scale after the root, and a rest below the degree.
    let (scale, rest) = product.exponent.div_mod_floor(&i128::from(degree));
    let radicand = BigInt::from(product.mantissa) << u32::try_from(rest).ok()?;
    let scale = scale.clamp(-1_000_000, 1_000_000) as i64;
    Some(nearest_root(&BigRational::from_integer(radicand), degree, scale))
}

/// `mantissa * 2^exponent`, the mantissa cut to 320 bits.
#[derive(Debug, Clone)]
struct Truncated {
    mantissa: BigUint,
    exponent: i128,
}

impl Truncated {
    const BITS: u64 = 320;

    fn one() -> Self {
        Self { mantissa: BigUint::one(), exponent: 0 }
    }

    /// A positive rational, or one divided by it.
    fn new(value: &BigRational, inverted: bool) -> Self {
        let (p, q) = (value.numer().magnitude(), value.denom().magnitude());
        let (p, q) = if inverted { (q, p) } else { (p, q) };
        let shift = Self::BITS + q.bits();
        Self::cut((p << shift) / q, -i128::from(shift))
    }

    fn cut(mantissa: BigUint, exponent: i128) -> Self {
        let excess = mantissa.bits().saturating_sub(Self::BITS);
        Self { mantissa: mantissa >> excess, exponent: exponent + i128::from(excess) }
    }

    fn times(&self, other: &Self) -> Self {
        Self::cut(&self.mantissa * &other.mantissa, self.exponent + other.exponent)
    }

    fn pow(mut self, mut power: u64) -> Self {
        let mut product = Self::one();
        while power > 0 {
            if power & 1 == 1 {
                product = product.times(&self);
            }
            power >>= 1;
            if power > 0 {
                self = self.times(&self);
            }
        }
        product
    }
}

/// Five significant digits.
pub(crate) fn significant(value: f64) -> String {
    let magnitude = value.abs();
    if magnitude != 0.0 && !(1e-4..1e6).contains(&magnitude) {
        return format!("{value:.4e}");
    }
    // The place of the first digit once it is rounded to five, as the formatter has it: 0.1 and 0.099999999 have the same.
    let rounded = format!("{magnitude:.4e}");
    let first = rounded.split_once('e').and_then(|(_, place)| place.parse::<i32>().ok()).unwrap_or(0);
    format!("{value:.*}", usize::try_from(4 - first).unwrap_or(0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Also at a power of ten, and where rounding makes one.
    #[test]
    fn five_digits_are_shown_wherever_the_point_is() {
        let shown = [
            (0.1, "0.10000"),
            (0.01, "0.010000"),
            (-0.001225, "-0.0012250"),
            (0.099_999_99, "0.10000"),
            (9.999_996, "10.000"),
            (1.0, "1.0000"),
            (1000.0, "1000.0"),
            (31_406.25, "31406"),
            (999_999.0, "999999"),
            (0.0, "0.0000"),
            (1e-5, "1.0000e-5"),
            (-1.5e6, "-1.5000e6"),
            (f64::NAN, "NaN"),
            (f64::INFINITY, "inf"),
        ];
        for (value, text) in shown {
            assert_eq!(significant(value), text, "{value:?}");
        }
    }

    #[test]
    fn numbers_below_zero_round_as_those_above() {
        let tenth = BigRational::new(1.into(), 10.into());
        assert_eq!(nearest(&tenth).to_bits(), 0.1_f64.to_bits());
        assert_eq!(nearest(&-tenth).to_bits(), (-0.1_f64).to_bits());
    }
}
