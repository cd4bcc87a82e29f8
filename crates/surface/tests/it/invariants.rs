//! What holds for every surface and any data.

use proptest::prelude::*;
use surface::{Data, Kind, Surface};

use crate::{any_data, check_close, kinds};

/// Rounding of some tens of data, and of the condition of a linear model on a few points.
const ROUNDING: f64 = 1e-9;

fn reordered(data: &Data, order: &[usize]) -> Data {
    let pick = |numbers: &[f64]| order.iter().map(|&i| numbers[i]).collect::<Vec<f64>>();
    let rows: Vec<&[f64]> = data.points().collect();
    let points = order.iter().flat_map(|&i| rows[i].iter().copied()).collect();
    let picked = Data::new(data.n_factors(), points, pick(data.values()));
    picked.and_then(|picked| picked.with_weights(pick(data.weights()))).expect("valid data")
}

fn fit(kind: &Kind, data: &Data) -> Box<dyn Surface> {
    kind.fit(data).expect("points in general position")
}

fn point() -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec(-1.2..1.2_f64, 3)
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, cases: 100, ..ProptestConfig::default() })]

    #[test]
    fn order_of_the_data_does_not_matter(data in any_data(3, 12, 20), x in point(), shift in 1..11_usize) {
        prop_assume!(data.n_used() >= 7);
        let n = data.n_points();
        let order: Vec<usize> = (0..n).rev().map(|i| (i + shift) % n).collect();
        for kind in kinds(3) {
            let (a, b) = (fit(&kind, &data), fit(&kind, &reordered(&data, &order)));
            check_close(a.predict(&x), b.predict(&x), ROUNDING, &format!("{kind:?}"));
        }
    }

    #[test]
    fn a_point_of_weight_zero_changes_nothing(data in any_data(3, 12, 20), x in point()) {
        prop_assume!(data.n_used() >= 7);
        let used: Vec<usize> = (0..data.n_points()).filter(|&i| data.weights()[i] > 0.0).collect();
        for kind in kinds(3) {
            let (a, b) = (fit(&kind, &data), fit(&kind, &reordered(&data, &used)));
            prop_assert_eq!(a.predict(&x).to_bits(), b.predict(&x).to_bits(), "{:?}", kind);
        }
    }

    #[test]
    fn a_weight_of_three_is_three_equal_points(data in any_data(3, 12, 20), x in point()) {
        prop_assume!(data.n_used() >= 7);
        let n = data.n_points();
        let weights = |first: f64| {
            let mut weights = data.weights().to_vec();
            weights[0] = first;
            weights
        };
        let weighted = data.clone().with_weights(weights(3.0)).expect("valid weights");
        let order: Vec<usize> = (0..n).chain([0, 0]).collect();
        let repeated = reordered(&data.clone().with_weights(weights(1.0)).expect("valid weights"), &order);
        for kind in kinds(3) {
            let (a, b) = (fit(&kind, &weighted), fit(&kind, &repeated));
            check_close(a.predict(&x), b.predict(&x), ROUNDING, &format!("{kind:?}"));
        }
    }

    #[test]
    fn scaling_all_weights_changes_no_estimate(data in any_data(3, 12, 20), x in point(), exponent in -60..60_i32) {
        prop_assume!(data.n_used() >= 7);
        let factor = 10.0_f64.powi(exponent);
        let weights = data.weights().iter().map(|weight| weight * factor).collect();
        let scaled = data.clone().with_weights(weights).expect("valid weights");
        for kind in kinds(3) {
            check_close(fit(&kind, &scaled).predict(&x), fit(&kind, &data).predict(&x), ROUNDING, &format!("{kind:?}"));
        }
    }

    #[test]
    fn leaving_one_out_is_fitting_again_without_it(data in any_data(3, 12, 20), left_out in 0..12_usize) {
        prop_assume!(data.n_used() >= 8);
        let others: Vec<usize> = (0..data.n_points()).filter(|&i| i != left_out).collect();
        let others = reordered(&data, &others);
        prop_assume!(others.n_used() >= 7);
        let x = data.points().nth(left_out).expect("there are twelve").to_vec();
        for kind in kinds(3) {
            let expected = data.values()[left_out] - fit(&kind, &others).predict(&x);
            let found = kind.leave_one_out(&data).expect("enough data").residuals()[left_out];
            check_close(found, expected, 1e-7, &format!("{kind:?}"));
        }
    }

    #[test]
    fn gradient_is_the_limit_of_differences(data in any_data(3, 12, 20), x in point()) {
        prop_assume!(data.n_used() >= 7);
        let nearest = data.points().map(|p| p.iter().zip(&x).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max));
        prop_assume!(nearest.fold(f64::INFINITY, f64::min) > 0.05);
        let step = 1e-5;
        for kind in kinds(3) {
            let surface = fit(&kind, &data);
            let gradient = surface.gradient(&x).expect("a gradient off the data");
            for (factor, &slope) in gradient.iter().enumerate() {
                let at = |shift: f64| {
                    let mut x = x.clone();
                    x[factor] += shift;
                    surface.predict(&x)
                };
                // Fourth order: third derivatives of an inverse distance reach 1e5 this close to a datum.
                let difference = (8.0 * (at(step) - at(-step)) - (at(2.0 * step) - at(-2.0 * step))) / (12.0 * step);
                check_close(slope, difference, 1e-6 * (1.0 + slope.abs()), &format!("{kind:?}"));
            }
        }
    }

    #[test]
    fn averages_stay_within_the_range_of_the_values(data in any_data(3, 2, 20), x in prop::collection::vec(-50.0..50.0_f64, 3)) {
        let used = data.values().iter().zip(data.weights()).filter(|&(_, &weight)| weight > 0.0);
        let (low, high) = used.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (&v, _)| (v.min(low), v.max(high)));
        for kind in &kinds(3)[..3] {
            for shrink in [1.0, 0.02] {
                let x: Vec<f64> = x.iter().map(|x| shrink * x).collect();
                let estimate = fit(kind, &data).predict(&x);
                prop_assert!((low..=high).contains(&estimate), "{:?}: {} not in {}..{}", kind, estimate, low, high);
            }
        }
    }

    #[test]
    fn inverse_distance_passes_through_the_data(data in any_data(3, 2, 20), power in 0.1..20.0_f64) {
        let used = |&(_, &weight): &(&f64, &f64)| weight > 0.0;
        for power in [2.0, power] {
            let surface = fit(&Kind::InverseDistance { power }, &data);
            for (x, (value, _)) in data.points().zip(data.values().iter().zip(data.weights())).filter(|(_, pair)| used(pair)) {
                prop_assert_eq!(surface.predict(x).to_bits(), value.to_bits());
            }
        }
    }
}
