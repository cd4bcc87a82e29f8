//! The check of the assumption that errors do not grow.

use infuse::{
    Error,
    convergence::{AssumptionReport, Growth},
};
use proptest::prelude::*;

#[test]
fn falling_and_constant_errors_pass() {
    let report = AssumptionReport::new(&[3.0, 3.0, 2.0], &[1.0, 0.5, 0.5, 0.0], 0.0).unwrap();
    assert!(report.holds(), "{report:?}");
    assert!(AssumptionReport::new(&[], &[1.0], 0.0).unwrap().holds(), "nothing to compare");
}

#[test]
fn growth_is_reported_with_its_batch_and_size() {
    let report = AssumptionReport::new(&[2.0, 1.0, 3.0, 2.0], &[1.0, 1.5], 0.0).unwrap();
    assert!(!report.holds(), "{report:?}");
    assert_eq!(report.simulation, [Growth { batch: 3, previous: 1.0, least: 1.0, error: 3.0 }], "not the fall after");
    assert_eq!(report.experiment, [Growth { batch: 2, previous: 1.0, least: 1.0, error: 1.5 }]);
    assert!((report.simulation[0].ratio() - 3.0).abs() < 1e-15, "three times");
}

#[test]
fn growth_within_the_tolerance_passes_but_not_in_many_steps() {
    let slow: Vec<f64> = (0..5).map(|j| 1.0 + 0.04 * f64::from(j)).collect();
    let report = AssumptionReport::new(&slow, &[1.0, 1.1], 0.1).unwrap();
    let batches: Vec<usize> = report.simulation.iter().map(|growth| growth.batch).collect();
    assert_eq!(batches, [4, 5], "1.12 and 1.16 are more than a tenth above 1");
    assert!(report.experiment.is_empty(), "a tenth is allowed");
}

#[test]
fn growth_from_nothing_is_growth() {
    let report = AssumptionReport::new(&[0.0, 1e-9], &[], 0.5).unwrap();
    assert!(report.simulation[0].ratio().is_infinite(), "{report:?}");
}

#[test]
fn rejects_errors_and_tolerances_below_zero() {
    let entry = AssumptionReport::new(&[1.0, -1.0], &[], 0.0).unwrap_err();
    assert_eq!(entry.to_string(), "`simulation` has -1.0 at index 1, expected a finite number, zero or positive");
    assert!(matches!(
        AssumptionReport::new(&[], &[f64::NAN], 0.0),
        Err(Error::Entry { name: "experiment", index: 0, .. })
    ));
    let tolerance = AssumptionReport::new(&[], &[], -0.1).unwrap_err();
    assert_eq!(tolerance.to_string(), "setting `tolerance` is -0.1, expected a finite number, zero or positive");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn without_tolerance_it_holds_exactly_for_sequences_that_never_rise(
        errors in prop::collection::vec((0_u8..5).prop_map(f64::from), 0..8),
    ) {
        let report = AssumptionReport::new(&errors, &[], 0.0).unwrap();
        prop_assert_eq!(report.holds(), errors.is_sorted_by(|a, b| a >= b));
        for growth in report.simulation {
            prop_assert_eq!(growth.error.to_bits(), errors[growth.batch - 1].to_bits());
            prop_assert_eq!(growth.previous.to_bits(), errors[growth.batch - 2].to_bits());
        }
    }
}
