//! The laws: two forms of each, (47), closed forms, and what they refuse.

use infuse::{
    Error,
    correction::{Coefficients, Field, Gain, Law, ModelStage, Rule},
};
use proptest::prelude::*;

use super::{LAWS, STAGES, any_gain, any_stage, by_recursion, rule};

/// n rows of experiments and n + 1 rows of simulations over some cells.
fn surfaces() -> impl Strategy<Value = (Vec<Vec<f64>>, Vec<Vec<f64>>)> {
    (0_usize..12, 1_usize..6).prop_flat_map(|(n, n_cells)| {
        let row = prop::collection::vec(-10.0..10.0, n_cells);
        (prop::collection::vec(row.clone(), n), prop::collection::vec(row, n + 1))
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn recursion_and_factors_give_the_same_model(
        (experiment, simulation) in surfaces(),
        law in prop::sample::select(&LAWS[..]),
        gain in any_gain(),
        stage in any_stage(),
    ) {
        let rule = Rule::new(law, gain);
        let model = rule.model(stage, experiment.len());
        let combined = model.combine(&experiment, &simulation[..model.simulation.len()]).unwrap();
        let scale: f64 = model.experiment.iter().chain(&model.simulation).map(|factor| 10.0 * factor.abs()).sum();
        for (a, b) in combined.iter().zip(by_recursion(rule, stage, &experiment, &simulation)) {
            prop_assert!((a - b).abs() <= 1e-13 * scale, "{} by factors, {} by recursion", a, b);
        }
    }

    /// The n-th term of the proof, with its sum written as printed.
    #[test]
    fn printed_47_is_the_recursion((experiment, simulation) in surfaces(), k in 0.01..1.99) {
        let n = experiment.len();
        prop_assume!(n > 0);
        let rule = rule(Law::ProofRecursion, k);
        let model = by_recursion(rule, ModelStage::Corrected, &experiment, &simulation);
        for (cell, value) in model.iter().enumerate() {
            let exp = |j: usize| experiment[j - 1][cell];
            let sim = |j: usize| simulation[j - 1][cell];
            let decay = |r: usize| (1.0 - k).powi(i32::try_from(r).unwrap());
            let mut sum = decay(n - 1) * (exp(1) - sim(1));
            for r in 0..n - 1 {
                sum += decay(r) * (exp(n - r) - sim(n - r - 1));
            }
            let printed = sim(n) + k * sum;
            prop_assert!((value - printed).abs() <= 1e-12, "{} by recursion, {} by (47)", value, printed);
        }
    }

    /// What is added to both surfaces is in the model, and what only the truth has arrives by its weight.
    #[test]
    fn factors_of_a_model_sum_to_one(
        law in prop::sample::select(&LAWS[..]), gain in any_gain(), stage in any_stage(), n in 0_usize..12,
    ) {
        let model = Rule::new(law, gain).model(stage, n);
        let sum: f64 = model.experiment.iter().chain(&model.simulation).sum();
        let scale: f64 = model.experiment.iter().chain(&model.simulation).map(|factor| factor.abs()).sum();
        prop_assert!((sum - 1.0).abs() <= 1e-13 * scale, "{}", sum);
    }

    #[test]
    fn dropped_cells_leave_the_others_as_they_were(
        (experiment, simulation) in surfaces(), law in prop::sample::select(&LAWS[..]), gain in any_gain(),
        at in any::<prop::sample::Index>(), which in any::<prop::sample::Index>(),
    ) {
        let n = experiment.len();
        prop_assume!(n > 0);
        let (n_cells, drop_at) = (simulation[0].len(), at.index(n));
        let cell = which.index(n_cells);
        let rule = Rule::new(law, gain);
        let mut field = Field::new(rule, n_cells).unwrap();
        for j in 0..n {
            if j == drop_at {
                let keep: Vec<bool> = (0..n_cells).map(|other| other == cell).collect();
                field.retain(&keep).unwrap();
            }
            let kept = |row: &[f64]| if j < drop_at { row.to_vec() } else { vec![row[cell]] };
            field.update(&kept(&experiment[j]), &kept(&simulation[j])).unwrap();
        }
        let full = by_recursion(rule, ModelStage::Corrected, &experiment, &simulation);
        prop_assert_eq!(field.model().unwrap()[0].to_bits(), full[cell].to_bits());
        prop_assert_eq!(field.n_batches(), n);
    }
}

/// One cell, exact surfaces that differ by `gap`: the error after each round.
fn errors(rule: Rule, gap: f64, n: usize) -> Vec<f64> {
    let mut field = Field::new(rule, 1).unwrap();
    (0..n)
        .map(|_| {
            field.update(&[gap], &[0.0]).unwrap();
            field.model().unwrap()[0] - gap
        })
        .collect()
}

#[test]
fn a_constant_gap_decays_geometrically() {
    for law in &LAWS[..2] {
        for k in [0.1, 0.5, 1.0, 1.5] {
            for (index, error) in errors(rule(*law, k), 2.0, 20).into_iter().enumerate() {
                let expected = -2.0 * (1.0 - k).powi(i32::try_from(index).unwrap() + 1);
                assert!((error - expected).abs() < 1e-14, "{law:?}, k = {k}: {error}, closed form {expected}");
            }
        }
    }
}

#[test]
fn harmonic_gain_is_right_after_one_round_and_averages_the_experiments() {
    for law in &LAWS[..2] {
        let mut field = Field::new(Rule::new(*law, Gain::harmonic()), 1).unwrap();
        for (index, experiment) in [4.0, 1.0, 7.0, 2.0].into_iter().enumerate() {
            field.update(&[experiment], &[10.0]).unwrap();
            let mean = [4.0, 2.5, 4.0, 3.5][index];
            assert!((field.model().unwrap()[0] - mean).abs() < 1e-14, "{law:?}: {:?}", field.model());
        }
    }
}

#[test]
fn printed_36_corrects_a_gap_twice_as_much_every_time() {
    let k = 0.4;
    for (index, error) in errors(rule(Law::AsPrinted36, k), 2.0, 40).into_iter().enumerate() {
        let expected = 2.0 * (k * 2.0_f64.powi(i32::try_from(index).unwrap()) - 1.0);
        assert!((error - expected).abs() <= 1e-14 * expected.abs().max(1.0), "{error}, closed form {expected}");
    }
    assert!(errors(rule(Law::AsPrinted36, k), 2.0, 30)[29] > 1e8, "k = 0.4 and a gap of 2, batch 30");
}

#[test]
fn laws_differ_in_the_simulation_they_compare_with() {
    // Jsim = 0, 1 and Jexp = 0, 0: the proof's law has not seen the 1 yet.
    let models = LAWS.map(|law| {
        let rows = (vec![vec![0.0], vec![0.0]], vec![vec![0.0], vec![1.0], vec![0.0]]);
        by_recursion(rule(law, 0.25), ModelStage::Corrected, &rows.0, &rows.1)[0]
    });
    assert!((models[0] - 1.0).abs() < 1e-15, "1 + 0.25 (0 - 0): {models:?}");
    assert!((models[1] - 0.75).abs() < 1e-15, "1 + 0.25 (0 - 1): {models:?}");
    assert!((models[2] - 0.75).abs() < 1e-15, "the sums are still empty: {models:?}");
}

#[test]
fn nothing_is_corrected_before_the_first_round() {
    for law in LAWS {
        let rule = rule(law, 0.5);
        assert_eq!(rule.correction(0), Coefficients { experiment: vec![], simulation: vec![] }, "{law:?}");
        for stage in STAGES {
            let model = rule.model(stage, 0);
            assert_eq!(model, Coefficients { experiment: vec![], simulation: vec![1.0] }, "{law:?}");
        }
        let field = Field::new(rule, 2).unwrap();
        assert_eq!((field.n_batches(), field.model()), (0, None), "{law:?}");
        assert_eq!(field.onset_model(&[3.0, 4.0]).unwrap(), [3.0, 4.0], "{law:?}");
    }
}

#[test]
fn onset_lacks_what_the_experiments_of_its_batch_say() {
    let rule = rule(Law::ProofRecursion, 0.5);
    let mut field = Field::new(rule, 1).unwrap();
    field.update(&[3.0], &[1.0]).unwrap();
    let onset = field.onset_model(&[1.5]).unwrap();
    assert!((onset[0] - 2.5).abs() < 1e-15, "1.5 + 0.5 (3 - 1)");
    field.update(&[100.0], &[1.5]).unwrap();
    assert!((onset[0] - 2.5).abs() < 1e-15, "whatever is measured afterwards");
}

#[test]
fn rejects_gains_that_cannot_settle() {
    for k in [0.0, -0.1, 2.0, f64::NAN, f64::INFINITY] {
        let error = Gain::constant(k).unwrap_err();
        assert_eq!(error.to_string(), format!("setting `gain` is {k:?}, expected 0 < k < 2"));
    }
    assert_eq!(Gain::constant(0.3).unwrap().as_constant(), Some(0.3));
    assert_eq!(Gain::harmonic().as_constant(), None);
}

#[test]
fn rejects_surfaces_that_do_not_fit_and_stays_as_it_was() {
    let rule = rule(Law::AsPrinted36, 0.5);
    assert_eq!(Field::new(rule, 0), Err(Error::EmptyRegion));
    let mut field = Field::new(rule, 2).unwrap();
    field.update(&[1.0, 2.0], &[0.0, 0.0]).unwrap();
    let before = field.clone();
    let short = field.update(&[1.0], &[0.0, 0.0]).unwrap_err();
    assert_eq!(short.to_string(), "`experiment` has 1 entries, expected 2: one per cell");
    let nan = field.update(&[1.0, 1.0], &[0.0, f64::NAN]).unwrap_err();
    assert_eq!(nan.to_string(), "`simulation` has NaN at index 1, expected a finite number");
    assert!(field.update(&[f64::MAX, 0.0], &[f64::MIN, 0.0]).is_err(), "their difference overflows");
    assert_eq!(field.retain(&[false, false]), Err(Error::EmptyRegion));
    assert!(matches!(field.retain(&[true]), Err(Error::WrongCount { name: "keep", found: 1, expected: 2, .. })));
    assert!(matches!(field.onset_model(&[1.0]), Err(Error::WrongCount { name: "simulation", .. })));
    assert!(matches!(field.onset_model(&[1.0, f64::INFINITY]), Err(Error::Entry { index: 1, .. })));
    assert_eq!(field, before, "unchanged by all of that");
}

#[test]
fn printed_36_is_stopped_when_it_leaves_the_doubles() {
    let mut field = Field::new(rule(Law::AsPrinted36, 0.5), 1).unwrap();
    let fault = (0..2000).find_map(|_| field.update(&[1.0], &[0.0]).err()).unwrap();
    assert!(matches!(fault, Error::Entry { name: "sum of corrections", index: 0, .. }), "{fault}");
    assert_eq!(field.n_batches(), 1024, "2^1024 is the first power of two beyond the doubles");
}

#[test]
fn rejects_combinations_of_the_wrong_shape() {
    let model = rule(Law::ProofRecursion, 0.5).model(ModelStage::Corrected, 1);
    assert_eq!(model.combine(&[[3.0]], &[[1.0]]).unwrap(), [2.0], "half of each");
    let nothing: [[f64; 1]; 0] = [];
    let missing = model.combine(&nothing, &[[1.0]]).unwrap_err();
    assert_eq!(missing.to_string(), "`experiment` has 0 entries, expected 1: one per coefficient");
    assert!(matches!(model.combine(&[[3.0]], &nothing), Err(Error::WrongCount { name: "simulation", .. })));
    let ragged = model.combine(&[vec![3.0]], &[vec![1.0, 2.0]]).unwrap_err();
    assert_eq!(ragged.to_string(), "`surface` has 2 entries, expected 1: one per entry of the first surface");
    assert!(matches!(model.combine(&[[f64::NAN]], &[[1.0]]), Err(Error::Entry { name: "surface", .. })));
    let large = Coefficients { experiment: vec![2.0], simulation: vec![] };
    assert!(matches!(large.combine(&[[f64::MAX]], &nothing), Err(Error::Entry { name: "combined surface", .. })));
}
