//! Regret certificates: never wrong, attained, worthless with other norms, and kept while cells are dropped.

use infuse::{
    Error,
    convergence::{Norm, NormOrder, NormScaling, RegretCertificate, possible_optima},
};
use proptest::prelude::*;

fn least(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::INFINITY, f64::min)
}

/// True costs per cell, and errors of the model as fractions of eps.
fn truths() -> impl Strategy<Value = (Vec<f64>, Vec<f64>)> {
    prop::collection::vec((-3.0..3.0, prop_oneof![-1.0..=1.0, Just(1.0), Just(-1.0)]), 1..15)
        .prop_map(|cells| cells.into_iter().unzip())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    #[test]
    fn regret_of_every_cell_is_within_its_certificate(
        (truth, fractions) in truths(), eps in 0.0..2.0,
    ) {
        let model: Vec<f64> = truth.iter().zip(&fractions).map(|(truth, at)| truth + at * eps).collect();
        for (cell, true_cost) in truth.iter().enumerate() {
            let (regret, rounding) = (true_cost - least(&truth), 1e-14);
            let certificate = RegretCertificate::of_cell(cell, &model, eps).unwrap();
            prop_assert!(regret <= certificate.regret + rounding, "{} with {:?}", regret, certificate);
            let between = RegretCertificate::of_point(model[cell], &model, eps).unwrap();
            prop_assert!(certificate.regret <= between.regret, "knowing the cell never hurts");
            prop_assert!((between.regret - between.model_excess - 2.0 * eps).abs() <= rounding);
            prop_assert_eq!(certificate.model_excess.to_bits(), between.model_excess.to_bits());
        }
    }

    /// Between the cells too, wherever the point came from.
    #[test]
    fn regret_of_any_point_is_within_its_certificate(
        (truth, fractions) in truths(), eps in 0.0..2.0, true_cost in -4.0..4.0, at in -1.0..=1.0,
    ) {
        let model: Vec<f64> = truth.iter().zip(&fractions).map(|(truth, at)| truth + at * eps).collect();
        let certificate = RegretCertificate::of_point(true_cost + at * eps, &model, eps).unwrap();
        prop_assert!(true_cost - least(&truth) <= certificate.regret + 1e-14);
    }

    /// Batch after batch, each with its own model and eps, only what cannot be the optimum is
    /// dropped: the true optimum of the original region stays, and the last certificate holds against it.
    #[test]
    fn dropping_by_more_than_2_eps_never_loses_the_true_optimum(
        truth in prop::collection::vec(-3.0..3.0, 1..15),
        rounds in prop::collection::vec((0.0..1.0, prop::collection::vec(-1.0..=1.0, 15)), 1..6),
    ) {
        let mut cells: Vec<usize> = (0..truth.len()).collect();
        for (eps, fractions) in rounds {
            let model: Vec<f64> = cells.iter().map(|cell| truth[*cell] + eps * fractions[*cell]).collect();
            let keep = possible_optima(&model, eps + 1e-14).unwrap();
            for (index, cell) in cells.iter().enumerate() {
                let certificate = RegretCertificate::of_cell(index, &model, eps).unwrap();
                prop_assert!(truth[*cell] - least(&truth) <= certificate.regret + 1e-13, "cell {}", cell);
            }
            let mut kept = keep.iter();
            cells.retain(|_| *kept.next().unwrap());
            let kept: Vec<f64> = cells.iter().map(|cell| truth[*cell]).collect();
            prop_assert_eq!(least(&kept).to_bits(), least(&truth).to_bits());
        }
    }
}

#[test]
fn certificate_is_attained() {
    // The model is eps too low at the design and eps too high at the best.
    let (truth, eps) = ([1.0, 0.5], 0.25);
    let model = [truth[0] - eps, truth[1] + eps];
    for certificate in [RegretCertificate::of_cell(0, &model, eps), RegretCertificate::of_point(model[0], &model, eps)]
    {
        let certificate = certificate.unwrap();
        assert!((certificate.regret - 0.5).abs() < 1e-15, "the true regret, {certificate:?}");
    }
}

#[test]
fn a_cell_that_stands_out_is_certainly_the_best() {
    let model = [1.0, 3.0, 4.0];
    let at = |eps| RegretCertificate::of_cell(0, &model, eps).unwrap().regret;
    assert!(at(1.0) <= 0.0, "all others are at least 2 eps above");
    assert!((at(1.25) - 0.5).abs() < 1e-15, "against the runner-up: 1 - 3 + 2.5");
    let alone = RegretCertificate::of_cell(0, &[7.0], 100.0).unwrap();
    assert!(alone.regret <= 0.0, "there is nothing to regret");
    let between = RegretCertificate::of_point(1.0, &model, 1.0).unwrap();
    assert!((between.regret - 2.0).abs() < 1e-15, "a point has no cell of its own to leave out");
}

#[test]
fn cells_remain_possible_up_to_2_eps_above_the_least() {
    let model = [1.5, 1.0, 2.0, 2.001, 3.0];
    assert_eq!(possible_optima(&model, 0.5).unwrap(), [true, true, true, false, false]);
    assert_eq!(possible_optima(&model, 0.0).unwrap(), [false, true, false, false, false], "an exact model");
}

#[test]
fn stopping_rule_compares_the_regret() {
    let certificate = RegretCertificate::of_cell(1, &[1.0, 1.5], 0.25).unwrap();
    assert!(certificate.is_within(1.0), "0.5 + 0.5");
    assert!(!certificate.is_within(0.99), "0.5 + 0.5");
}

#[test]
fn a_norm_of_finite_order_certifies_nothing() {
    // The model is wrong in one cell of a hundred, where it sees a valley that is not there.
    let truth = vec![1.0; 100];
    let mut model = truth.clone();
    model[17] = -1.0;
    let mut truth = truth;
    truth[17] = 3.0;
    let error: Vec<f64> = model.iter().zip(&truth).map(|(model, truth)| model - truth).collect();
    let measures = vec![0.01; 100];
    let mean = Norm { order: NormOrder::finite(2.0).unwrap(), scaling: NormScaling::Mean };
    let (typical, largest) = (mean.over(&error, &measures).unwrap(), Norm::SUP.over(&error, &measures).unwrap());
    let regret = truth[17] - 1.0;
    let with = |eps| RegretCertificate::of_cell(17, &model, eps).unwrap().regret;
    assert!(with(typical) < regret, "eps = {typical} promises {} where the regret is {regret}", with(typical));
    assert!(with(largest) >= regret, "eps = {largest} does not");
}

#[test]
fn a_certificate_is_silent_about_cells_dropped_for_less() {
    // Within eps of the truth, but the best cell was dropped by a rule that trusts the model.
    let (truth, model, eps) = ([0.0, 0.5], [0.5, 0.25], 0.5);
    assert_eq!(possible_optima(&model, eps).unwrap(), [true, true], "0.25 is not more than 2 eps");
    let certificate = RegretCertificate::of_cell(0, &model[1..], eps).unwrap();
    assert!(certificate.regret < truth[1] - truth[0], "right over what is left, wrong over what was: {certificate:?}");
}

#[test]
fn rejects_models_that_certify_nothing() {
    assert_eq!(RegretCertificate::of_cell(0, &[], 1.0), Err(Error::EmptyRegion));
    assert_eq!(RegretCertificate::of_point(0.0, &[], 1.0), Err(Error::EmptyRegion));
    assert_eq!(possible_optima(&[], 1.0), Err(Error::EmptyRegion));
    let unknown = RegretCertificate::of_cell(2, &[1.0, 2.0], 1.0).unwrap_err();
    assert_eq!(unknown.to_string(), "cell 2 does not exist, expected less than 2");
    let nan = RegretCertificate::of_cell(0, &[1.0, f64::NAN], 1.0).unwrap_err();
    assert_eq!(nan.to_string(), "`model` has NaN at index 1, expected a finite number");
    assert!(matches!(possible_optima(&[f64::INFINITY], 1.0), Err(Error::Entry { name: "model", index: 0, .. })));
    let cost = RegretCertificate::of_point(f64::NAN, &[1.0], 1.0).unwrap_err();
    assert_eq!(cost.to_string(), "setting `model_cost` is NaN, expected a finite number");
    for eps in [-1.0, f64::NAN, f64::INFINITY] {
        let message = format!("setting `eps` is {eps:?}, expected a finite number, zero or positive");
        assert_eq!(RegretCertificate::of_cell(0, &[1.0], eps).unwrap_err().to_string(), message);
        assert_eq!(possible_optima(&[1.0], eps).unwrap_err().to_string(), message);
    }
}
