//! Norms over cells: closed forms, the axioms, extremes of range, and what they refuse.

use infuse::{
    Error,
    convergence::{Norm, NormOrder, NormScaling, coded_cell_measure},
};
use proptest::prelude::*;

fn norm(q: f64, scaling: NormScaling) -> Norm {
    let order = if q.is_infinite() { NormOrder::INFINITY } else { NormOrder::finite(q).unwrap() };
    Norm { order, scaling }
}

const SCALINGS: [NormScaling; 2] = [NormScaling::Integral, NormScaling::Mean];
const ORDERS: [f64; 6] = [1.0, 1.5, 2.0, 3.0, 40.0, f64::INFINITY];

#[test]
fn norms_of_x_over_the_coded_box_are_its_moments() {
    // (∫ |x|^q dx)^(1/q) over −1..1 is (2/(q + 1))^(1/q), the mean (1/(q + 1))^(1/q).
    let n = 20_000;
    let values: Vec<f64> = (0..n).map(|cell| (2.0 * f64::from(cell) + 1.0) / f64::from(n) - 1.0).collect();
    let measures = vec![coded_cell_measure(1, values.len()).unwrap(); values.len()];
    for q in [1.0, 2.0, 3.5, 8.0] {
        for (scaling, size) in [(NormScaling::Integral, 2.0), (NormScaling::Mean, 1.0)] {
            let (found, expected) =
                (norm(q, scaling).over(&values, &measures).unwrap(), (size / (q + 1.0)).powf(1.0 / q));
            assert!((found - expected).abs() < 1e-7, "midpoint rule, q = {q}: {found}, {expected}");
        }
    }
    let sup = Norm::SUP.over(&values, &measures).unwrap();
    assert!((sup - (1.0 - 1.0 / f64::from(n))).abs() < 1e-12, "the outermost cell: {sup}");
}

#[test]
fn measures_weigh_the_cells() {
    let (values, measures) = ([3.0, -1.0], [1.0, 3.0]);
    let of = |q, scaling| norm(q, scaling).over(&values, &measures).unwrap();
    for (q, integral) in [(1.0, 6.0), (2.0, 12.0_f64.sqrt()), (3.0, 30.0_f64.cbrt())] {
        assert!((of(q, NormScaling::Integral) - integral).abs() < 1e-14, "q = {q}");
        assert!((of(q, NormScaling::Mean) - integral / 4.0_f64.powf(1.0 / q)).abs() < 1e-14, "q = {q}");
    }
    assert!((of(f64::INFINITY, NormScaling::Mean) - 3.0).abs() < 1e-15, "however small its cell");
}

#[test]
fn cells_of_the_coded_box_add_up_to_its_measure() {
    assert!((coded_cell_measure(2, 576).unwrap() * 576.0 - 4.0).abs() < 1e-14, "2²");
    assert!((coded_cell_measure(4, 331_776).unwrap() * 331_776.0 - 16.0).abs() < 1e-12, "2⁴");
    assert_eq!(coded_cell_measure(2, 0), Err(Error::EmptyRegion));
    for n in [0, 1001] {
        let message = format!("setting `n_parameters` is {n}, expected 1 to 1000");
        assert_eq!(coded_cell_measure(n, 5).unwrap_err().to_string(), message);
    }
}

#[test]
fn extreme_magnitudes_neither_overflow_nor_vanish() {
    for size in [1e-320, 1e-200, 1e200, 1.7e308] {
        for q in ORDERS {
            let mean = norm(q, NormScaling::Mean).over(&[size, -size], &[1e-300, 1e-300]).unwrap();
            assert!((mean / size - 1.0).abs() < 1e-3, "q = {q}, size {size:e}: {mean:e}");
        }
    }
    let tiny_cells = norm(40.0, NormScaling::Integral).over(&[2.0], &[1e-300]).unwrap();
    assert!((tiny_cells / (2.0 * 10.0_f64.powf(-7.5)) - 1.0).abs() < 1e-12, "{tiny_cells:e}");
    let large = norm(1.0, NormScaling::Integral).over(&[1e200], &[1e200]).unwrap_err();
    assert_eq!(large.to_string(), "setting `norm` is inf, expected a norm below the largest double");
    assert_eq!(norm(2.0, NormScaling::Mean).over(&[0.0, -0.0], &[1.0, 1.0]), Ok(0.0));
}

#[test]
fn a_mean_may_grow_when_the_region_shrinks() {
    let mean = norm(2.0, NormScaling::Mean);
    let (all, kept) = (mean.over(&[0.0, 4.0], &[1.0; 2]).unwrap(), mean.over(&[4.0], &[1.0]).unwrap());
    assert!(kept > all, "{kept} over the cell that is left, {all} before");
}

#[test]
fn rejects_what_has_no_norm() {
    for q in [0.99, 0.0, -2.0, f64::NAN, f64::INFINITY] {
        let error = NormOrder::finite(q).unwrap_err().to_string();
        assert_eq!(error, format!("setting `order` is {q:?}, expected a finite q of at least 1, or infinity by name"));
    }
    for q in ORDERS {
        for scaling in SCALINGS {
            let norm = norm(q, scaling);
            assert_eq!(norm.over(&[], &[]), Err(Error::EmptyRegion));
            let short = norm.over(&[1.0, 2.0], &[1.0]).unwrap_err().to_string();
            assert_eq!(short, "`measures` has 1 entries, expected 2: one per cell");
            let nan = norm.over(&[1.0, f64::NAN], &[1.0, 1.0]).unwrap_err().to_string();
            assert_eq!(nan, "`values` has NaN at index 1, expected a finite number");
            for measure in [0.0, -1.0, f64::NAN, f64::INFINITY] {
                let error = norm.over(&[1.0, 2.0], &[measure, 1.0]).unwrap_err().to_string();
                assert_eq!(error, format!("`measures` has {measure:?} at index 0, expected a finite positive number"));
            }
        }
    }
}

/// Cells with two values and a measure each.
fn cells() -> impl proptest::strategy::Strategy<Value = Vec<(f64, f64, f64)>> {
    prop::collection::vec((-5.0..5.0, -5.0..5.0, 0.01..3.0), 1..12)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(3000))]

    #[test]
    fn norms_are_norms(
        cells in cells(), q in prop_oneof![1.0..50.0, Just(1.0), Just(2.0), Just(f64::INFINITY)],
        scaling in prop::sample::select(&SCALINGS[..]), factor in -10.0_f64..10.0,
    ) {
        let norm = norm(q, scaling);
        let measures: Vec<f64> = cells.iter().map(|cell| cell.2).collect();
        let of = |value: &dyn Fn(&(f64, f64, f64)) -> f64| {
            norm.over(&cells.iter().map(value).collect::<Vec<f64>>(), &measures).unwrap()
        };
        let (a, b) = (of(&|cell| cell.0), of(&|cell| cell.1));
        prop_assert!(of(&|cell| cell.0 + cell.1) <= (a + b) * (1.0 + 1e-13), "triangle");
        prop_assert!((of(&|cell| factor * cell.0) - factor.abs() * a).abs() <= 1e-12 * a.max(1.0) * 10.0, "scaling");
        prop_assert!(a >= 0.0, "sign");
        prop_assert!(a > 0.0 || cells.iter().all(|cell| cell.0.abs() <= 0.0), "only zero has none");
    }

    #[test]
    fn means_grow_with_the_order_up_to_the_largest_value(cells in cells(), q in 1.0..30.0, more in 0.0..30.0) {
        let (values, measures): (Vec<f64>, Vec<f64>) = cells.iter().map(|cell| (cell.0, cell.2)).unzip();
        let of = |q| norm(q, NormScaling::Mean).over(&values, &measures).unwrap();
        let (low, high, sup) = (of(q), of(q + more), of(f64::INFINITY));
        prop_assert!(low <= high * (1.0 + 1e-12), "{} at {}, {} at {}", low, q, high, q + more);
        prop_assert!(high <= sup, "{} at {}, largest {}", high, q + more, sup);
        prop_assert!((of(1e5) / sup - 1.0).abs() < 1e-4 || sup < 1e-9, "a large order is nearly the largest");
    }

    #[test]
    fn integrals_and_largest_values_do_not_grow_when_the_region_shrinks(
        cells in cells(), q in 1.0..30.0, keep in prop::collection::vec(any::<bool>(), 12),
    ) {
        let kept: Vec<_> = cells.iter().zip(&keep).filter(|(_, keep)| **keep).map(|(cell, _)| *cell).collect();
        prop_assume!(!kept.is_empty());
        let of = |norm: Norm, cells: &[(f64, f64, f64)]| {
            let (values, measures): (Vec<f64>, Vec<f64>) = cells.iter().map(|cell| (cell.0, cell.2)).unzip();
            norm.over(&values, &measures).unwrap()
        };
        for norm in [norm(q, NormScaling::Integral), Norm::SUP] {
            prop_assert!(of(norm, &kept) <= of(norm, &cells) * (1.0 + 1e-12), "{:?}", norm);
        }
    }

    #[test]
    fn a_cell_split_in_two_changes_nothing(cells in cells(), q in 1.0..30.0, scaling in prop::sample::select(&SCALINGS[..])) {
        let (values, measures): (Vec<f64>, Vec<f64>) = cells.iter().map(|cell| (cell.0, cell.2)).unzip();
        let halves: Vec<f64> = measures.iter().flat_map(|measure| [0.25 * measure, 0.75 * measure]).collect();
        let twice: Vec<f64> = values.iter().flat_map(|value| [*value; 2]).collect();
        let norm = norm(q, scaling);
        let (whole, split) = (norm.over(&values, &measures).unwrap(), norm.over(&twice, &halves).unwrap());
        prop_assert!((whole - split).abs() <= 1e-12 * whole, "{} whole, {} split", whole, split);
    }
}
