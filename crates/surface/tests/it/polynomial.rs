//! Polynomials on their own: values and slopes against closed forms, sums against sums of values.

use doe::{Model, Term};
use proptest::prelude::*;
use surface::{Data, Kind, LANES, Polynomial, Regression, Surface};

fn cubic() -> Polynomial {
    // 2 − x y + 3 x² y, and a factor in no term.
    let terms = [[0, 0, 0], [1, 1, 0], [2, 1, 0]].map(Term::new).to_vec();
    Polynomial::new(&Model::new(3, terms).expect("a valid model"), &[2.0, -1.0, 3.0]).expect("three coefficients")
}

#[test]
fn has_the_values_and_slopes_of_its_closed_form() {
    let (x, y) = (0.5, -2.0);
    let point = [x, y, 7.0];
    assert!((cubic().predict(&point) - (2.0 - x * y + 3.0 * x * x * y)).abs() < 1e-15);
    assert_eq!(cubic().gradient(&point), Some(vec![-y + 6.0 * x * y, -x + 3.0 * x * x, 0.0]));
    assert!(cubic().variance(&point).is_none());
    assert_eq!(cubic().n_factors(), 3, "those of its model");
}

#[test]
fn is_no_number_where_a_coordinate_is_none_even_if_no_term_has_it() {
    let zero = Polynomial::zero(3).expect("three factors");
    for polynomial in [cubic(), zero.clone()] {
        assert!(polynomial.predict(&[0.0, 0.0, f64::NAN]).is_nan());
        assert!(polynomial.predict(&[0.0, f64::INFINITY, 0.0]).is_nan());
        assert!(polynomial.predict(&[0.0; 2]).is_nan());
        assert!(polynomial.gradient(&[0.0, 0.0, f64::INFINITY]).is_none());
    }
    assert!(zero.predict(&[1.0, 2.0, 3.0]).abs() <= 0.0);
    assert_eq!(zero.parts().count(), 0);
}

#[test]
fn refuses_what_does_not_fit() {
    let message = |refused: Result<Polynomial, surface::Error>| refused.expect_err("refused").to_string();
    let line = Model::linear(1).expect("a valid model");
    assert_eq!(message(Polynomial::new(&line, &[1.0])), "number of coefficients: 1, expected 2");
    assert_eq!(message(Polynomial::zero(0)), "number of factors: 0, expected 1 to 12");
    let other = Polynomial::new(&line, &[1.0, 2.0]).expect("two coefficients");
    assert_eq!(message(cubic().plus(1.0, &other)), "number of factors of the second polynomial: 1, expected 3");
}

#[test]
fn a_kind_checks_its_numbers_without_data() {
    let message = |kind: Kind| kind.check().expect_err("refused").to_string();
    assert_eq!(
        message(Kind::InverseDistance { power: 100.5 }),
        "`power` is 100.5, expected a number above 0, at most 100"
    );
    assert!(message(Kind::SquaredExponential { scale: Some(0.0) }).starts_with("`scale` is 0.0"));
    assert_eq!(Kind::InverseDistance { power: 100.0 }.check(), Ok(()));
    assert_eq!(Kind::SquaredExponential { scale: None }.check(), Ok(()));
}

proptest! {
    #[test]
    fn a_sum_of_regressions_is_the_regression_of_the_sum(
        values in prop::collection::vec(-10.0..10.0_f64, 9),
        others in prop::collection::vec(-10.0..10.0_f64, 9),
        times in -3.0..3.0_f64,
        point in prop::array::uniform2(-1.5..1.5_f64),
    ) {
        let points: Vec<f64> =
            (0..9_i32).flat_map(|i| [f64::from(i % 3) - 1.0, f64::from(i / 3) - 1.0]).collect();
        let fit = |model: &Model, values: Vec<f64>| {
            let data = Data::new(2, points.clone(), values).expect("valid data");
            Regression::fit(model, &data).expect("nine points")
        };
        let (quadratic, plane) = (Model::quadratic(2).expect("a model"), Model::linear(2).expect("a model"));
        let (first, second) = (fit(&quadratic, values.clone()), fit(&quadratic, others.clone()));
        let sum = first.polynomial().plus(times, second.polynomial()).expect("two factors each");
        let pooled = fit(&quadratic, values.iter().zip(&others).map(|(a, b)| a + times * b).collect());
        prop_assert!((sum.predict(&point) - pooled.predict(&point)).abs() < 1e-11);
        for (a, b) in sum.gradient(&point).expect("a slope").iter().zip(pooled.gradient(&point).expect("a slope")) {
            prop_assert!((a - b).abs() < 1e-11);
        }
        // Terms that only one of them has are kept.
        let short = fit(&plane, others);
        let mixed = short.polynomial().plus(times, first.polynomial()).expect("two factors each");
        let expected = short.predict(&point) + times * first.predict(&point);
        prop_assert!((mixed.predict(&point) - expected).abs() < 1e-11);
        prop_assert_eq!(mixed.parts().count(), 6);
        // Lanes have the bits of single points.
        let mut estimates = [0.0; LANES];
        mixed.predict_lanes(&[[point[0]; LANES], [point[1]; LANES]], &mut estimates);
        prop_assert!(estimates.iter().all(|estimate| estimate.to_bits() == mixed.predict(&point).to_bits()));
    }
}
