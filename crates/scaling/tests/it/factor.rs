//! Exact ratios.

use scaling::{Error, Factor};

use crate::ratio;

fn factor(text: &str) -> Factor {
    text.parse().unwrap()
}

#[test]
fn perfect_powers_are_reduced() {
    for (base, power, expected) in [
        ("100", "1/2", "10"),
        ("49/40000", "1/2", "7/200"),
        ("1000000", "1/3", "100"),
        ("12", "1/2", "2*3^(1/2)"),
        ("8/27", "2/3", "4/9"),
        ("10", "-1/2", "1/10^(1/2)"),
        ("1", "1/7", "1"),
        ("5", "0", "1"),
    ] {
        let power = factor(base).pow(&ratio(power));
        assert_eq!(power, factor(expected), "{base}");
    }
    assert_eq!(factor("100").pow(&ratio("1/2")).to_string(), "10");
    assert_eq!((&factor("2^(1/2)") * &factor("50^(1/2)")).to_string(), "10");
}

#[test]
fn large_primes_cancel_exactly() {
    // 65537 and 1000003 are primes beyond trial division.
    let p = factor("65537");
    let q = factor("1000003");
    let product = factor("65537196611");
    assert_eq!(&p * &q, product);
    let root = (&product * &p).pow(&ratio("1/2"));
    assert_eq!(root, &p * &q.pow(&ratio("1/2")));
    assert!((&root / &(&p * &q.pow(&ratio("1/2")))).is_one());
    assert_eq!(factor("65537^5").pow(&ratio("1/5")).to_string(), "65537");
    assert_eq!(factor("4295098369").pow(&ratio("1/2")).to_string(), "65537");
}

#[test]
fn texts_read_back() {
    for text in ["1", "1225", "49/40000", "10^(1/2)", "pi/180", "1/pi^(1/2)", "3*2^(1/3)/(7*5^(2/3))", "pi^2"] {
        assert_eq!(factor(&factor(text).to_string()), factor(text), "{text}");
    }
    assert_eq!(factor("1.225/1000").to_string(), "49/40000");
    assert_eq!(factor("pi/180").to_string(), "pi/180");
    assert_eq!(factor("pi^2").to_string(), "pi^2");
}

#[test]
fn values_are_the_nearest_doubles() {
    assert_eq!(factor("2^(1/2)").to_f64().to_bits(), std::f64::consts::SQRT_2.to_bits());
    assert_eq!(Factor::pi().to_f64().to_bits(), std::f64::consts::PI.to_bits());
    assert_eq!(factor("1/pi").to_f64().to_bits(), std::f64::consts::FRAC_1_PI.to_bits());
    assert_eq!(factor("2/pi^(1/2)").to_f64().to_bits(), std::f64::consts::FRAC_2_SQRT_PI.to_bits());
    assert_eq!(factor("1/3").to_f64().to_bits(), (1.0f64 / 3.0).to_bits());
    // Ends of the range, subnormals and the ties between them.
    assert_eq!(factor("1.7976931348623157e308").to_f64().to_bits(), f64::MAX.to_bits());
    assert_eq!(factor("1.7976931348623159e308").to_f64().to_bits(), f64::INFINITY.to_bits());
    assert_eq!(factor("4.9406564584124654e-324").to_f64().to_bits(), 1);
    assert_eq!(factor("2.4703282292062327e-324").to_f64().to_bits(), 0);
    assert_eq!(factor("2.4703282292062328e-324").to_f64().to_bits(), 1);
    assert_eq!(factor("2.2250738585072011e-308").to_f64().to_bits(), f64::MIN_POSITIVE.to_bits() - 1);
    assert_eq!(factor("2.2250738585072014e-308").to_f64().to_bits(), f64::MIN_POSITIVE.to_bits());
    // 2^53 + 1 is a tie, which goes to the even neighbor; a hair above it is not.
    assert_eq!(factor("9007199254740993").to_f64().to_bits(), 9_007_199_254_740_992.0_f64.to_bits());
    assert_eq!(factor("9007199254740993.0000000001").to_f64().to_bits(), 9_007_199_254_740_994.0_f64.to_bits());
}

#[test]
fn factors_beyond_every_double_stay_finite_work() {
    let huge = factor("10^1000").pow(&ratio("1000000000000"));
    assert_eq!(huge.to_f64().to_bits(), f64::INFINITY.to_bits());
    assert_eq!(huge.inverse().to_f64().to_bits(), 0);
    assert!(huge.rational().is_none());
    assert!((huge.log10() - 1e15).abs() < 1.0);
    assert!((&huge * &huge.inverse()).is_one());
    assert_eq!(huge.pow(&ratio("1/1000000000000")), factor("10^1000"));
}

#[test]
fn large_powers_are_still_rounded_once() {
    // (1 + 1/10^6)^(10^6), and roots of it, by mpmath with 60 digits.
    let base = factor("1000001/1000000");
    assert_eq!(base.pow(&ratio("1000000")).to_f64().to_bits(), 2.718_280_469_319_376_7_f64.to_bits());
    assert_eq!(base.pow(&ratio("1000000/3")).to_f64().to_bits(), 1.395_612_192_484_193_f64.to_bits());
    assert_eq!(base.pow(&ratio("-1000000")).to_f64().to_bits(), 0.367_879_625_111_086_24_f64.to_bits());
    // Huge powers that nearly cancel: (2/3)^(10^9) * 3^(10^9) / 2^(10^9) is 1.
    let cancelled = &factor("2/3").pow(&ratio("1000000000")) * &factor("3/2").pow(&ratio("999999999"));
    assert_eq!(cancelled.to_f64().to_bits(), (2.0f64 / 3.0).to_bits());
}

#[test]
fn only_positive_numbers_are_ratios() {
    for value in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(Factor::from_f64(value), Err(Error::NotPositive { .. })), "{value}");
    }
    assert_eq!(Factor::from_f64(0.1).unwrap().to_string(), "1/10");
    assert_eq!(
        "2*x".parse::<Factor>().unwrap_err().to_string(),
        "\"2*x\", character 3: unknown number `x`; did you mean `pi`?"
    );
    assert!("".parse::<Factor>().is_err());
    assert!("-3".parse::<Factor>().is_err());
}

/// More than 400 digits, or a power of ten beyond that, is no number: nobody means it, and it would fill the memory.
#[test]
fn decimals_end_at_400_digits() {
    let digits = |n: usize| "9".repeat(n);
    for text in ["1e400".to_owned(), "1e-400".to_owned(), digits(400)] {
        assert!(text.parse::<Factor>().is_ok(), "{text}");
    }
    for text in ["1e401".to_owned(), "1e-401".to_owned(), "1e999999999".to_owned(), digits(401), digits(402)] {
        assert!(text.parse::<Factor>().is_err(), "{text}");
    }
}

/// Logarithms of integers without small divisors, and of pi, whose decimals are longer than 64 bits.
#[test]
fn logarithms_of_long_numbers_are_those_of_mathematics() {
    // The Mersenne prime 2^127 - 1 is 2^127 to 38 digits.
    let prime = factor("170141183460469231731687303715884105727");
    let expected = 127.0 * std::f64::consts::LOG10_2;
    assert!((prime.log10() - expected).abs() < 1e-13, "{}", prime.log10());
    assert!((prime.inverse().log10() + expected).abs() < 1e-13, "{}", prime.inverse().log10());
    // Of a quotient of two numbers of 330 bits, whose logarithms are rounded first.
    assert!((Factor::pi().log10() - std::f64::consts::PI.log10()).abs() < 1e-13, "{}", Factor::pi().log10());
}

/// Exponents whose denominators are beyond any root are taken by logarithms.
#[test]
fn roots_of_any_degree_have_a_value() {
    for (base, degree) in [(3.0, "1000003"), (7.0, "65537"), (0.5, "123456789")] {
        let root = Factor::from_f64(base).unwrap().pow(&ratio(&format!("1000/{degree}")));
        let expected = (base.ln() * 1000.0 / degree.parse::<f64>().unwrap()).exp();
        assert!((root.to_f64() - expected).abs() < 1e-14, "{base}, {degree}: {}", root.to_f64());
    }
}

/// (1 + 1/10^6)^(10^6/k) is exp(10^6/k ln(1 + 1/10^6)): integers of 40 million bits, of which 320 are kept.
#[test]
fn roots_of_huge_powers_are_those_of_the_exponential() {
    for k in 1..10 {
        let power = factor("1000001/1000000").pow(&ratio(&format!("1000000/{k}")));
        let expected = (1e6 / f64::from(k) * 1e-6_f64.ln_1p()).exp();
        assert!((power.to_f64() / expected - 1.0).abs() < 1e-12, "{k}: {}", power.to_f64());
    }
}

/// Small divisors are split off, so that their powers are written as short as can be.
#[test]
fn roots_are_written_with_what_comes_out_of_them() {
    for (base, written) in [("12", "2*3^(1/2)"), ("75", "5*3^(1/2)"), ("98/3", "7*2^(1/2)/3^(1/2)")] {
        assert_eq!(factor(base).pow(&ratio("1/2")).to_string(), written, "{base}");
    }
}

/// Only parentheses inside each other are limited, not those beside each other.
#[test]
fn hundred_parentheses_side_by_side_are_no_nesting() {
    let text = vec!["(2)"; 100].join("*");
    assert_eq!(factor(&text), factor("2^100"));
}
