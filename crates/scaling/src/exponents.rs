//! Products of symbols to rational powers: what dimensions and groups have in common.

use std::collections::BTreeMap;
use std::fmt;

use num_bigint::BigInt;
use num_integer::Integer;
use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use crate::parse::is_plain;

/// Symbol to exponent; a symbol with exponent zero is absent.
pub(crate) type Exponents = BTreeMap<String, BigRational>;

/// Multiplies `product` by `factor^power`.
pub(crate) fn multiply(product: &mut Exponents, factor: &Exponents, power: &BigRational) {
    for (symbol, exponent) in factor {
        multiply_symbol(product, symbol, &(exponent * power));
    }
}

/// Multiplies `product` by one symbol to a power.
pub(crate) fn multiply_symbol(product: &mut Exponents, symbol: &str, power: &BigRational) {
    let sum = product.get(symbol).map_or_else(|| power.clone(), |old| old + power);
    if sum.is_zero() {
        product.remove(symbol);
    } else {
        product.insert(symbol.to_owned(), sum);
    }
}

/// Raises to the lowest power that makes all exponents integers; they are coprime if one of them was 1.
pub(crate) fn clear_denominators(product: &mut Exponents) {
    let denominator = product.values().fold(BigInt::one(), |lcm, exponent| lcm.lcm(exponent.denom()));
    product.values_mut().for_each(|exponent| *exponent *= &denominator);
}

/// Writes `L_t^3*rho/M_a`: positive exponents above the line, negative ones below, 1 if there is nothing.
pub(crate) fn write_quotient<'a>(
    f: &mut fmt::Formatter<'_>,
    factors: impl Iterator<Item = (&'a str, &'a BigRational)>,
) -> fmt::Result {
    let (above, below): (Vec<_>, Vec<_>) = factors.partition(|(_, exponent)| exponent.is_positive());
    let write = |factors: &[(&str, &BigRational)]| {
        let powers: Vec<_> = factors.iter().map(|(symbol, exponent)| power(symbol, &exponent.abs())).collect();
        powers.join("*")
    };
    f.write_str(&if above.is_empty() { "1".to_owned() } else { write(&above) })?;
    match below.len() {
        0 => Ok(()),
        1 => write!(f, "/{}", write(&below)),
        _ => write!(f, "/({})", write(&below)),
    }
}

/// Writes `L_t^(1/2)*g^-1`, every factor above the line; 1 if there is nothing.
pub(crate) fn write_product<'a>(
    f: &mut fmt::Formatter<'_>,
    factors: impl Iterator<Item = (&'a str, &'a BigRational)>,
) -> fmt::Result {
    let powers: Vec<_> = factors.map(|(symbol, exponent)| power(symbol, exponent)).collect();
    f.write_str(&if powers.is_empty() { "1".to_owned() } else { powers.join("*") })
}

fn power(symbol: &str, exponent: &BigRational) -> String {
    if exponent.is_one() {
        return symbol.to_owned();
    }
    let exponent = if exponent.is_integer() { exponent.to_string() } else { format!("({exponent})") };
    if is_plain(symbol) { format!("{symbol}^{exponent}") } else { format!("({symbol})^{exponent}") }
}
