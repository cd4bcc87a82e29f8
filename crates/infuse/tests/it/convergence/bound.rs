//! Bounds: closed forms, limits, how many batches, and what they refuse.

use infuse::{
    Error,
    convergence::{Amplification, Bound, ErrorLevels},
    correction::{Gain, Law, ModelStage, Rule},
};
use proptest::prelude::*;

use super::{LAWS, STAGES, any_gain, any_stage, converging_law, rule};

const PROOF: Law = Law::ProofRecursion;
const CURRENT: Law = Law::CurrentSimulation;

#[track_caller]
fn check_near(found: f64, expected: f64) {
    assert!((found - expected).abs() <= 1e-12 * (1.0 + expected.abs()), "{found}, expected {expected}");
}

fn corrected(law: Law, k: f64) -> Bound {
    Bound::new(rule(law, k), ModelStage::Corrected)
}

#[test]
fn limit_of_the_proofs_law_is_that_of_the_proposition() {
    for k in [0.01, 0.4, 1.0] {
        for stage in STAGES {
            let limit = Bound::new(rule(PROOF, k), stage).limit().unwrap();
            assert_eq!(limit, Amplification { gap: 0.0, simulation: 2.0, experiment: 1.0 }, "2 E1 + E2, k = {k}");
        }
    }
}

#[test]
fn comparing_with_the_current_simulation_takes_2_k_e1_from_the_limit_but_not_at_the_onset() {
    for k in [0.1, 0.5, 1.0] {
        let limit = corrected(CURRENT, k).limit().unwrap();
        check_near(limit.simulation, 2.0 - 2.0 * k);
        check_near(limit.experiment, 1.0);
        let onset = Bound::new(rule(CURRENT, k), ModelStage::Onset).limit().unwrap();
        check_near(onset.simulation, 2.0);
    }
}

#[test]
fn limits_beyond_a_gain_of_one_grow_as_it_nears_two() {
    for (k, proof, current, experiment) in [(1.5, 4.0, 2.0, 3.0), (1.9, 20.0, 18.0, 19.0)] {
        let (limit, tighter) = (corrected(PROOF, k).limit().unwrap(), corrected(CURRENT, k).limit().unwrap());
        check_near(limit.simulation, proof);
        check_near(tighter.simulation, current);
        check_near(limit.experiment, experiment);
        check_near(tighter.experiment, experiment);
    }
}

#[test]
fn one_round_gives_the_same_bound_under_both_laws() {
    let levels = ErrorLevels::new(3.0, 0.5, 0.25).unwrap();
    for k in [0.3, 1.0, 1.7] {
        for law in [PROOF, CURRENT] {
            let expected = (1.0_f64 - k).abs() * (3.0 + 0.5) + k * 0.25;
            check_near(corrected(law, k).after(1).error(&levels), expected);
        }
    }
}

#[test]
fn harmonic_gain_forgets_the_gap_at_once() {
    let levels = ErrorLevels::new(1e6, 0.5, 0.25).unwrap();
    let bound = |law, n| {
        let rule = Rule::new(law, Gain::harmonic());
        Bound::new(rule, ModelStage::Corrected).after(n).error(&levels)
    };
    for n in 2..50 {
        check_near(bound(PROOF, n), 2.0 * 0.5 + 0.25);
        check_near(bound(CURRENT, n), 2.0 * (1.0 - 1.0 / n as f64) * 0.5 + 0.25);
    }
    check_near(bound(PROOF, 1), 0.25);
    check_near(bound(CURRENT, 1), 0.25);
}

#[test]
fn printed_36_has_a_bound_that_doubles_and_no_limit() {
    let bound = corrected(Law::AsPrinted36, 0.5);
    assert_eq!(bound.limit(), None);
    assert_eq!(bound.batches_to(&ErrorLevels::new(1.0, 0.0, 0.0).unwrap(), 0.1), Ok(None));
    check_near(bound.after(11).gap, 0.5 * 1024.0 - 1.0);
    check_near(bound.after(11).experiment, 0.5 * 1024.0);
}

#[test]
fn batches_to_a_hundredth_of_the_start_are_those_of_the_logarithm() {
    // ln 0.01 / ln (1 − k), rounded up.
    for (k, expected) in [(0.1, 44), (0.3, 13), (0.5, 7), (0.8, 3), (1.0, 1)] {
        for law in [PROOF, CURRENT] {
            let levels = ErrorLevels::new(1.0, 0.0, 0.0).unwrap();
            assert_eq!(corrected(law, k).batches_to(&levels, 0.01), Ok(Some(expected)), "{law:?}, k = {k}");
        }
    }
}

#[test]
fn a_gain_too_small_for_doubles_never_arrives() {
    let levels = ErrorLevels::new(1.0, 0.0, 0.0).unwrap();
    assert_eq!(corrected(PROOF, 1e-17).batches_to(&levels, 0.5), Ok(None));
    let slow = corrected(PROOF, 1e-9).batches_to(&levels, 0.5).unwrap().unwrap();
    assert!((slow as f64 * 1e-9 - 2.0_f64.ln()).abs() < 1e-6, "ln 2 / k: {slow}");
}

#[test]
fn a_bound_that_dips_below_its_limit_and_comes_back_is_not_taken_for_good() {
    // After one round 0.7 above the limit, after two 0.81.
    let bound = corrected(PROOF, 0.1);
    let levels = ErrorLevels::new(2.0, 1.0, 0.0).unwrap();
    let excess = |n| bound.after(n).error(&levels) - 2.0;
    check_near(excess(1), 0.7);
    check_near(excess(2), 0.81);
    assert_eq!(bound.batches_to(&levels, 0.75), Ok(Some(3)), "0.729, and not the 0.7 of one round");
}

fn gain_up_to_one() -> impl Strategy<Value = Gain> {
    prop_oneof![4 => (0.01..=1.0).prop_map(|k| Gain::constant(k).unwrap()), 1 => Just(Gain::harmonic())]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    #[test]
    fn batches_to_is_the_first_number_from_which_on_the_bound_is_near(
        law in converging_law(), gain in any_gain(), stage in any_stage(),
        levels in [0.0..10.0, 0.0..2.0, 0.0..2.0], tolerance in 1e-6..1.0,
    ) {
        let bound = Bound::new(Rule::new(law, gain), stage);
        let levels = ErrorLevels::new(levels[0], levels[1], levels[2]).unwrap();
        let n = bound.batches_to(&levels, tolerance).unwrap().unwrap();
        let limit = bound.limit().unwrap().error(&levels);
        let rounding = 1e-13 * (limit + 12.0);
        for later in n..n + 50 {
            let excess = bound.after(later).error(&levels) - limit;
            prop_assert!(excess <= tolerance + rounding, "n = {}, later {}: {}", n, later, excess);
        }
        if n > 0 {
            let excess = bound.after(n - 1).error(&levels) - limit;
            prop_assert!(excess > tolerance - rounding, "one less than {} would do: {}", n, excess);
        }
    }

    /// The closed forms for constant errors against the sums for any.
    #[test]
    fn closed_forms_equal_the_sums(
        law in prop::sample::select(&LAWS[..]), gain in any_gain(), stage in any_stage(), n in 0_usize..40,
        levels in [0.0..10.0, 0.0..2.0, 0.0..2.0],
    ) {
        let bound = Bound::new(Rule::new(law, gain), stage);
        let n_sim = if stage == ModelStage::Onset { n + 1 } else { n.max(1) };
        let summed = bound.finite(levels[0], &vec![levels[1]; n_sim], &vec![levels[2]; n]).unwrap();
        let closed = bound.after(n).error(&ErrorLevels::new(levels[0], levels[1], levels[2]).unwrap());
        prop_assert!((summed - closed).abs() <= 1e-12 * summed.max(1.0), "{} summed, {} closed", summed, closed);
    }

    #[test]
    fn after_very_many_rounds_only_the_limit_is_left(law in converging_law(), gain in any_gain(), stage in any_stage()) {
        let bound = Bound::new(Rule::new(law, gain), stage);
        let (far, limit) = (bound.after(1_000_000_000), bound.limit().unwrap());
        prop_assert!(far.gap.abs() < 1e-9);
        prop_assert!((far.simulation - limit.simulation).abs() < 1e-8, "{:?}, {:?}", far, limit);
        prop_assert!((far.experiment - limit.experiment).abs() < 1e-8, "{:?}, {:?}", far, limit);
    }

    #[test]
    fn current_simulation_is_never_bounded_worse_than_the_proofs_law_up_to_a_gain_of_one(
        gain in gain_up_to_one(), n in 0_usize..30, levels in [0.0..10.0, 0.0..2.0, 0.0..2.0],
    ) {
        let levels = ErrorLevels::new(levels[0], levels[1], levels[2]).unwrap();
        let of = |law| Bound::new(Rule::new(law, gain), ModelStage::Corrected).after(n).error(&levels);
        prop_assert!(of(CURRENT) <= of(PROOF) * (1.0 + 1e-12), "{}, {}", of(CURRENT), of(PROOF));
    }
}

#[test]
fn current_simulation_can_be_bounded_worse_early_with_a_gain_near_two() {
    // Sums of magnitudes after two rounds: 1 + k (2 − k) and k² − 1.
    let k = 1.9;
    check_near(corrected(PROOF, k).after(2).simulation, 1.19);
    check_near(corrected(CURRENT, k).after(2).simulation, 2.61);
}

#[test]
fn rejects_errors_that_are_no_bounds() {
    for bad in [-1.0, f64::NAN, f64::INFINITY] {
        let message = |name: &str| format!("setting `{name}` is {bad:?}, expected a finite number, zero or positive");
        assert_eq!(ErrorLevels::new(bad, 0.0, 0.0).unwrap_err().to_string(), message("gap"));
        assert_eq!(ErrorLevels::new(0.0, bad, 0.0).unwrap_err().to_string(), message("simulation"));
        assert_eq!(ErrorLevels::new(0.0, 0.0, bad).unwrap_err().to_string(), message("experiment"));
        let bound = corrected(PROOF, 0.5);
        assert_eq!(bound.finite(bad, &[1.0], &[1.0]).unwrap_err().to_string(), message("gap"));
        assert!(matches!(bound.finite(1.0, &[bad], &[1.0]), Err(Error::Entry { name: "simulation", index: 0, .. })));
        assert!(matches!(bound.finite(1.0, &[1.0], &[bad]), Err(Error::Entry { name: "experiment", index: 0, .. })));
    }
}

#[test]
fn rejects_one_simulation_error_too_many_or_too_few() {
    let message = "`simulation` has 2 entries, expected 3: one per simulation surface of the model";
    let onset = Bound::new(rule(PROOF, 0.5), ModelStage::Onset);
    assert_eq!(onset.finite(1.0, &[1.0; 2], &[1.0; 2]).unwrap_err().to_string(), message);
    assert!(corrected(PROOF, 0.5).finite(1.0, &[1.0; 3], &[1.0; 2]).is_err(), "the third is not in this model");
    assert!(corrected(PROOF, 0.5).finite(1.0, &[1.0], &[]).is_ok(), "with no round the model is Jsim,1");
}

#[test]
fn rejects_tolerances_that_mean_nothing() {
    let levels = ErrorLevels::new(1.0, 0.0, 0.0).unwrap();
    for tolerance in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = corrected(PROOF, 0.5).batches_to(&levels, tolerance).unwrap_err();
        assert_eq!(
            error.to_string(),
            format!("setting `tolerance` is {tolerance:?}, expected a finite positive number")
        );
    }
}
