//! Numbers there and back.

use proptest::prelude::*;
use scaling::{BigRational, Factor};

/// Significant digits of the shortest decimal of a number.
fn digits(value: f64) -> usize {
    let text = format!("{value:e}");
    text.split('e').next().unwrap().chars().filter(char::is_ascii_digit).count()
}

fn units_between(a: f64, b: f64) -> u64 {
    assert_eq!(a.is_sign_negative(), b.is_sign_negative());
    a.to_bits().abs_diff(b.to_bits())
}

fn factor(numerator: u64, denominator: u64) -> Factor {
    Factor::from_rational(&BigRational::new(numerator.into(), denominator.into())).unwrap()
}

#[test]
fn decimals_are_multiplied_as_decimals() {
    let apply = |text: &str, value: f64| text.parse::<Factor>().unwrap().apply(value);
    // In doubles 0.1*3 is 0.30000000000000004, and 1.1*1.1 is 1.2100000000000002.
    assert_eq!(apply("3", 0.1).to_bits(), 0.3f64.to_bits());
    assert_eq!(apply("1.1", 1.1).to_bits(), 1.21f64.to_bits());
    assert_eq!(apply("1225", 0.18).to_bits(), 220.5f64.to_bits());
    assert_eq!(apply("1/100", 5.625).to_bits(), 0.05625f64.to_bits());
    assert_eq!(apply("1/100", -0.0).to_bits(), (-0.0f64).to_bits());
    assert!(apply("3", f64::NAN).is_nan());
    assert_eq!(apply("3", f64::NEG_INFINITY).to_bits(), f64::NEG_INFINITY.to_bits());
    assert_eq!(apply("10", 1e308).to_bits(), f64::INFINITY.to_bits());
    assert_eq!(apply("1/4", 5e-324).to_bits(), 0);
}

#[test]
fn computed_numbers_are_taken_as_they_are() {
    // 0.1 + 0.2 is a double, not the decimal 0.30000000000000004: a third of it is the nearest double to the third.
    let sum = 0.1 + 0.2;
    assert_eq!(factor(1, 4).apply(sum).to_bits(), (sum / 4.0).to_bits());
    assert_eq!(factor(1, 3).apply(sum).to_bits(), (sum / 3.0).to_bits());
}

#[test]
fn irrational_factors_round_once_too() {
    let root: Factor = "2^(1/2)".parse().unwrap();
    // 3*sqrt(2) = 4.24264068711928514640..., by hand to 20 digits.
    assert_eq!(root.apply(3.0).to_bits(), 4.242_640_687_119_285_f64.to_bits());
    let degree: Factor = "pi/180".parse().unwrap();
    // 17.3 deg = 0.30194196059501901680... rad.
    assert_eq!(degree.apply(17.3).to_bits(), 0.301_941_960_595_019_04_f64.to_bits());
    assert_eq!(degree.inverse().apply(degree.apply(17.3)).to_bits(), 17.3f64.to_bits());
}

#[test]
fn one_unit_cannot_be_promised_to_every_number() {
    // Two neighbors of x share one converted number, so no rounding can return both.
    let ten = factor(10, 1);
    let start = 0.120_000_000_000_000_02_f64;
    let converted = |i: u64| ten.apply(f64::from_bits(start.to_bits() + i)).to_bits();
    assert!((0..16).any(|i| converted(i) == converted(i + 1)));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(3000))]

    /// The converted number is exact in 15 digits: bit for bit.
    #[test]
    fn short_products_return_bit_for_bit(
        mantissa in 1u64..1_000_000_000, power in -30i32..30, n in 1u64..1000, twos in 0u32..4, fives in 0u32..4, sign: bool,
    ) {
        let value: f64 = format!("{}{mantissa}e{power}", if sign { "-" } else { "" }).parse().unwrap();
        let factor = factor(n, 2u64.pow(twos) * 5u64.pow(fives));
        // mantissa * n has at most 15 digits, and dividing by 2^a 5^b adds at most max(a, b).
        let there = factor.apply(value);
        let exact_digits = (u128::from(mantissa) * u128::from(n) * 10u128.pow(twos.max(fives))
            / (2u128.pow(twos) * 5u128.pow(fives))).to_string().trim_end_matches('0').len();
        prop_assume!(exact_digits <= 15);
        prop_assert_eq!(factor.inverse().apply(there).to_bits(), value.to_bits());
    }

    /// Not only for short numbers: a long decimal whose product is short returns as well.
    #[test]
    fn long_decimals_with_short_products_return_bit_for_bit(
        product in 100_000_000_000_000u64..1_000_000_000_000_000, n in prop::sample::select(vec![2u64, 4, 5, 8, 16, 20, 25, 125]),
    ) {
        let text = format!("{}e-4", u128::from(product) * 10_000 / u128::from(n));
        let value: f64 = text.parse().unwrap();
        // Only where the shortest decimal is the quotient itself, and not a shorter neighbor.
        let shortest = format!("{value:e}").replace('.', "");
        prop_assume!(text.starts_with(shortest.split('e').next().unwrap()) && (value * n as f64 - product as f64).abs() < 1.0);
        prop_assume!(text.split('e').next().unwrap().trim_end_matches('0') == shortest.split('e').next().unwrap());
        let factor = factor(n, 1);
        let there = factor.apply(value);
        prop_assert_eq!(there.to_bits(), (product as f64).to_bits());
        prop_assert_eq!(factor.inverse().apply(there).to_bits(), value.to_bits());
    }

    #[test]
    fn all_numbers_return_within_two_units_and_mostly_one(bits: u64, n in 1u64..1_000_000, d in 1u64..1_000_000) {
        let value = f64::from_bits(bits);
        prop_assume!(value.is_finite() && (1e-280..1e280).contains(&value.abs()));
        let factor = factor(n, d);
        let there = factor.apply(value);
        let back = factor.inverse().apply(there);
        let units = units_between(back, value);
        prop_assert!(units <= 2);
        if digits(there) > 15 && digits(back) > 15 {
            prop_assert!(units <= 1);
        }
    }

    #[test]
    fn short_decimals_return_within_one_unit(mantissa in 1u64..1_000_000_000_000, n in 1u64..1_000_000, d in 1u64..1_000_000) {
        let value: f64 = format!("{mantissa}e-9").parse().unwrap();
        let factor = factor(n, d);
        let there = factor.apply(value);
        if digits(there) > 15 {
            prop_assert!(units_between(factor.inverse().apply(there), value) <= 1);
        }
    }

    /// The product rounded once, against i128 arithmetic and the platform's correctly rounded decimal reader.
    #[test]
    fn products_are_the_nearest_doubles(mantissa in 1u64..1_000_000_000_000_000, power in -40i32..40, n in 1u64..1_000_000_000) {
        let value: f64 = format!("{mantissa}e{power}").parse().unwrap();
        let expected: f64 = format!("{}e{power}", u128::from(mantissa) * u128::from(n)).parse().unwrap();
        prop_assert_eq!(factor(n, 1).apply(value).to_bits(), expected.to_bits());
    }

    #[test]
    fn square_roots_are_the_platforms(n in 1u64..(1 << 53)) {
        let root = factor(n, 1).pow(&"1/2".parse().unwrap());
        prop_assert_eq!(root.to_f64().to_bits(), (n as f64).sqrt().to_bits());
    }
}
