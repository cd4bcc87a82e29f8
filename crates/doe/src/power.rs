//! Whole powers, which are the same bits on every machine: those of `f64::powi` are not promised.

/// x to a whole power by squaring: the exponent's digits in base two, the lowest first. No more than twice as many roundings as the
/// exponent has digits, and none where all of them are exact.
#[inline]
pub(crate) fn power(x: f64, exponent: u32) -> f64 {
    let (mut product, mut square, mut left) = (1.0, x, exponent);
    loop {
        if left & 1 == 1 {
            product *= square;
        }
        left >>= 1;
        if left == 0 {
            return product;
        }
        square *= square;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Where nothing is rounded it is the power, and elsewhere within the roundings of the products in turn.
    #[test]
    fn powers_are_products() {
        for (x, exponent, exact) in
            [(3.0_f64, 5, 243.0_f64), (-2.0, 7, -128.0), (0.5, 8, 0.003_906_25), (0.0, 0, 1.0), (0.0, 3, 0.0)]
        {
            assert_eq!(power(x, exponent).to_bits(), exact.to_bits(), "{x} to the power {exponent}");
        }
        for x in [0.1, -0.7, 1.0 / 3.0, 0.999] {
            for exponent in 0..=17 {
                let in_turn = (0..exponent).fold(1.0, |product: f64, _| product * x);
                let error = (power(x, exponent) / in_turn - 1.0).abs();
                assert!(error <= f64::from(exponent) * f64::EPSILON, "{x} to the power {exponent}: off by {error}");
            }
        }
    }
}
