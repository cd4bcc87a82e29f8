//! What the crate promises, one module per behavior.

mod averages;
mod batch;
mod data;
mod errors;
mod golden;
mod invariants;
mod lack_of_fit;
mod limits;
mod nist;
mod over_grid;
mod polynomial;
mod process;
mod process_additive;
mod process_assemblies;
mod process_covariance;
mod process_deviations;
mod process_feasibility;
mod process_gradient;
mod process_regressor;
mod regression;
mod scale;
mod serde;

use proptest::prelude::*;
use surface::{Confounded, Data, InverseDistance, Kind, SquaredExponential};

#[track_caller]
fn check_close(found: f64, expected: f64, tolerance: f64, what: &str) {
    assert!((found - expected).abs() <= tolerance, "{what}: {found:?}, expected {expected:?} within {tolerance:e}");
}

/// The same number to the last bit.
#[track_caller]
fn check_exact(found: f64, expected: f64, what: &str) {
    assert_eq!(found.to_bits(), expected.to_bits(), "{what}: {found:?}, expected {expected:?}");
}

/// Two lists, to within a fraction of the largest number of the second.
#[track_caller]
fn check_list(found: &[f64], expected: &[f64], fraction: f64, what: &str) {
    assert_eq!(found.len(), expected.len(), "{what}: lengths");
    let largest = expected.iter().fold(0.0, |largest: f64, x| largest.max(x.abs()));
    for (position, (&a, &b)) in found.iter().zip(expected).enumerate() {
        check_close(a, b, fraction * largest, &format!("{what}, number {position}"));
    }
}

/// Points in general position in the box, with values, some weights zero, the first never.
fn any_data(n_factors: usize, least: usize, most: usize) -> impl Strategy<Value = Data> {
    let coordinates = prop::collection::vec(-1.0..1.0_f64, n_factors);
    let weight = prop_oneof![4 => 0.1..3.0_f64, 1 => Just(0.0)];
    let point = (coordinates, -5.0..5.0_f64, weight);
    prop::collection::vec(point, least..=most).prop_map(move |rows| {
        let points = rows.iter().flat_map(|(point, _, _)| point.iter().copied()).collect();
        let values = rows.iter().map(|&(_, value, _)| value).collect();
        let weights = rows.iter().enumerate().map(|(i, &(_, _, weight))| if i == 0 { 1.0 } else { weight }).collect();
        Data::new(n_factors, points, values).and_then(|data| data.with_weights(weights)).expect("valid data")
    })
}

/// The two averages and, for data that determine it, a linear model.
fn kinds(n_factors: usize) -> Vec<Kind> {
    vec![
        Kind::InverseDistance { power: 2.0 },
        Kind::InverseDistance { power: 3.0 },
        Kind::SquaredExponential { scale: Some(1.3) },
        Kind::Regression {
            model: doe::Model::linear(n_factors).expect("a valid model"),
            confounded: Confounded::Refuse,
        },
    ]
}

fn inverse_distance(data: &Data, power: f64) -> InverseDistance {
    InverseDistance::fit(data.clone(), power).expect("a valid power")
}

fn squared_exponential(data: &Data, scale: f64) -> SquaredExponential {
    SquaredExponential::fit(data.clone(), scale).expect("a valid scale")
}
