//! What holds for every fit.

use std::cell::RefCell;

use design_space::{Parameter, Region};
use infuse::identification::{Answer, Measurements, Noise, Settings, Unknowns, identify};
use proptest::prelude::*;

use super::each;

fn bent(theta: &[f64], x: f64) -> f64 {
    theta[0] * (theta[1] * x).sin() + theta[2] * x * x
}

/// Unknowns in units of `units`, with bounds at ±1 of them about `centers`.
fn scaled(centers: [f64; 3], units: [f64; 3], start: [f64; 3]) -> Unknowns {
    let parameter = |j: usize| {
        let [lower, upper] = [centers[j] - 1.0, centers[j] + 1.0].map(|bound| bound * units[j]);
        Parameter::continuous(format!("t{j}"), "u", lower, upper).unwrap()
    };
    let start = (0..3).map(|j| (centers[j] + start[j]) * units[j]).collect();
    Unknowns::new(Region::new((0..3).map(parameter).collect()).unwrap(), start).unwrap()
}

fn measured(readings: &[(f64, f64)], deviation: f64) -> Measurements {
    super::readings(readings, deviation)
}

fn readings() -> impl Strategy<Value = Vec<(f64, f64)>> {
    prop::collection::vec((-2.0..2.0_f64, -3.0..3.0_f64), 4..9)
}

fn centers() -> impl Strategy<Value = [f64; 3]> {
    [0.5..2.0_f64, 0.5..2.0_f64, -1.0..1.0_f64]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    /// Whatever the data, the model is asked within the bounds alone, and what is found fits no worse than the start.
    #[test]
    fn bounds_are_never_left(readings in readings(), centers in centers(), start in [-0.9..0.9, -0.9..0.9, -0.9..0.9_f64]) {
        let unknowns = scaled(centers, [1.0; 3], start);
        let asked = RefCell::new(Vec::new());
        let mut model = each(|t: &[f64], x: &[f64]| -> Answer {
            asked.borrow_mut().push(t.to_vec());
            Ok(vec![bent(t, x[0])])
        });
        let found = identify(&unknowns, &measured(&readings, 0.3), &Settings::default(), &mut model).unwrap();
        for theta in asked.borrow().iter().chain([&found.values()]) {
            prop_assert!(unknowns.region().contains(theta).unwrap(), "{theta:?}");
        }
        prop_assert!(found.sum_of_squares <= found.sum_of_squares_at_start * (1.0 + 1e-9) + 1e-12 || !found.undetermined.is_empty());
    }

    /// Not a bit depends on the order of the measurements.
    #[test]
    fn the_order_of_measurements_is_irrelevant(readings in readings(), centers in centers()) {
        let unknowns = scaled(centers, [1.0; 3], [0.1, -0.2, 0.3]);
        let mut backwards = readings.clone();
        backwards.reverse();
        let run = |readings: &[(f64, f64)]| {
            let mut model = each(|t: &[f64], x: &[f64]| Ok(vec![bent(t, x[0])]));
            format!("{:?}", identify(&unknowns, &measured(readings, 0.3), &Settings::default(), &mut model).unwrap())
        };
        prop_assert_eq!(run(&readings), run(&backwards));
    }

    /// Other units of unknowns and responses change the numbers and nothing else.
    #[test]
    fn units_are_irrelevant(readings in readings(), exponents in [-6..7_i32, -6..7, -6..7], k in -6..7_i32) {
        let units = exponents.map(|exponent| 2.0_f64.powi(exponent));
        let unit = 2.0_f64.powi(k);
        let run = |units: [f64; 3], unit: f64| {
            let unknowns = scaled([1.0, 1.0, 0.0], units, [0.1, -0.2, 0.3]);
            let readings: Vec<(f64, f64)> = readings.iter().map(|(x, y)| (*x, unit * y)).collect();
            let mut model = each(move |t: &[f64], x: &[f64]| {
                Ok(vec![unit * bent(&[t[0] / units[0], t[1] / units[1], t[2] / units[2]], x[0])])
            });
            identify(&unknowns, &measured(&readings, 0.3 * unit), &Settings::default(), &mut model).unwrap()
        };
        let (plain, other) = (run([1.0; 3], 1.0), run(units, unit));
        for ((a, b), unit) in plain.estimates.iter().zip(&other.estimates).zip(units) {
            // Powers of two leave no rounding.
            prop_assert_eq!(a.value.to_bits(), (b.value / unit).to_bits());
            prop_assert_eq!(a.standard_error, b.standard_error.map(|error| error / unit));
        }
        prop_assert_eq!(plain.singular_values, other.singular_values);
    }

    /// With the noise estimated, a common factor of all deviations is irrelevant to the fit and to what it determines; where
    /// an unknown that is not determined ends hangs on the way there.
    #[test]
    fn a_factor_of_the_noise_is_found(readings in readings(), factor in 0.01..100.0_f64) {
        let unknowns = scaled([1.0, 1.0, 0.0], [1.0; 3], [0.1, -0.2, 0.3]);
        let mut settings = Settings::default();
        settings.noise = Noise::Estimated;
        let run = |deviation| {
            let mut model = each(|t: &[f64], x: &[f64]| Ok(vec![bent(t, x[0])]));
            identify(&unknowns, &measured(&readings, deviation), &settings, &mut model).unwrap()
        };
        let (a, b) = (run(1.0), run(factor));
        prop_assert_eq!(a.undetermined.len(), b.undetermined.len());
        let (fit, other) = (a.sum_of_squares, b.sum_of_squares * factor * factor);
        prop_assert!((fit - other).abs() <= 1e-6 * fit.max(1e-6), "{fit} {other}");
        for (a, b) in a.estimates.iter().zip(&b.estimates).filter(|(a, b)| a.standard_error.or(b.standard_error).is_some()) {
            prop_assert!((a.value - b.value).abs() < 1e-4, "{a:?} {b:?}");
        }
    }
}

/// A model that fails for large unknowns: the first step would go there, and the search ends all the same where the residuals
/// are zero.
#[test]
fn steps_into_failures_are_shortened() {
    // From 5 a full step goes to 5 − (e⁻⁵ − e⁻¹)/(−e⁻⁵), about −49, which the bound cuts to −20: there e²⁰ is refused.
    let unknowns = super::unknowns(&[(-20.0, 20.0, 5.0)]);
    let n_failed = RefCell::new(0);
    let mut model = each(|t: &[f64], _: &[f64]| -> Answer {
        if t[0] < 0.0 {
            *n_failed.borrow_mut() += 1;
            return Err("no trim".to_owned());
        }
        Ok(vec![(-t[0]).exp()])
    });
    let readings = measured(&[(0.0, (-1.0_f64).exp())], 1e-3);
    let found = identify(&unknowns, &readings, &Settings::default(), &mut model).unwrap();
    assert!(*n_failed.borrow() > 0, "the search never met the failures");
    assert_eq!(found.n_failed_simulations, *n_failed.borrow(), "and all are counted");
    assert!((found.estimates[0].value - 1.0).abs() < 1e-6, "{found:?}");
}
