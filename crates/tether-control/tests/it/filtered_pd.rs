//! One loop in the time domain: the closed-form step, and what must hold for any error.

use proptest::prelude::*;
use tether_control::{FilteredPd, PdState};

/// Rounding of a few hundred steps on values of order one.
const ROUNDING: f64 = 1e-12;

fn outputs(pd: &FilteredPd, sample_time_s: f64, errors: &[f64]) -> Vec<f64> {
    let sampled = pd.sampled(sample_time_s).expect("a positive sample time");
    let mut state = PdState::default();
    errors.iter().map(|&error| sampled.output(&mut state, error)).collect()
}

#[track_caller]
fn check_step(proportional: f64, derivative: f64, time_constant_s: f64, sample_time_s: f64) {
    let pd = FilteredPd::new(proportional, derivative, time_constant_s).expect("valid gains");
    let scale = proportional.abs() + (derivative / time_constant_s).abs();
    for (sample, output) in outputs(&pd, sample_time_s, &[1.0; 400]).iter().enumerate() {
        let time_s = sample as f64 * sample_time_s;
        let decay = (-time_s / time_constant_s).exp();
        let exact = proportional * (1.0 - decay) + derivative / time_constant_s * decay;
        assert!((output - exact).abs() <= ROUNDING * scale, "at {time_s} s: {output}, not {exact}");
        assert!(
            (pd.step_response(time_s) - exact).abs() <= ROUNDING * scale,
            "the closed form of the crate, at {time_s} s"
        );
    }
    assert_eq!(pd.step_response(-sample_time_s).to_bits(), 0.0_f64.to_bits(), "before the step");
}

#[test]
fn step_response_is_exact_at_the_samples() {
    for sample_time_s in [0.001, 0.025, 0.1, 1.0, 50.0] {
        check_step(0.2047, 0.005839, 0.6807, sample_time_s);
        check_step(0.03847, 0.01612, 0.1025, sample_time_s);
        check_step(0.07119, 0.03208, 0.1294, sample_time_s);
        check_step(0.1, 0.0, 1.0, sample_time_s);
        check_step(-2.0, 3.0, 0.02, sample_time_s);
    }
}

#[test]
fn step_starts_at_the_derivative_gain_and_ends_at_the_proportional_one() {
    let pd = FilteredPd::new(2.0, 3.0, 0.5).expect("valid gains");
    let response = outputs(&pd, 0.025, &[1.0; 2000]);
    assert!((response[0] - 6.0).abs() <= 1e-15, "k_d / tau");
    assert!((response[1999] - 2.0).abs() <= ROUNDING, "k_p after 100 time constants");
}

#[test]
fn ramp_is_exact_for_the_held_staircase() {
    // An independent sum: the answer to a staircase is the sum of the answers to its steps.
    let pd = FilteredPd::new(0.04, 0.016, 0.1).expect("valid gains");
    let (sample_time_s, slope) = (0.025, 0.3);
    let ramp: Vec<f64> = (0..200).map(|k| slope * f64::from(k) * sample_time_s).collect();
    for (sample, output) in outputs(&pd, sample_time_s, &ramp).iter().enumerate() {
        let sum: f64 = (1..=sample)
            .map(|step| slope * sample_time_s * pd.step_response((sample - step) as f64 * sample_time_s))
            .sum();
        assert!((output - sum).abs() <= ROUNDING, "sample {sample}");
    }
}

#[test]
fn filter_that_has_settled_stays_where_it_is() {
    let sampled = FilteredPd::new(0.07, 0.032, 0.13).and_then(|pd| pd.sampled(0.025)).expect("valid gains");
    let mut state = PdState { filtered_error: 0.1 };
    for _ in 0..10_000 {
        sampled.output(&mut state, 0.1);
    }
    assert_eq!(state.filtered_error.to_bits(), 0.1_f64.to_bits());
}

#[test]
fn sample_time_far_below_the_time_constant_keeps_its_digits() {
    // 1 − exp(−x) computed as such would lose nine of sixteen digits here.
    let (time_constant_s, sample_time_s) = (1.0, 1e-9);
    let sampled =
        FilteredPd::new(1.0, 0.0, time_constant_s).and_then(|pd| pd.sampled(sample_time_s)).expect("valid gains");
    let mut state = PdState::default();
    sampled.output(&mut state, 1.0);
    let exact = sample_time_s - 0.5 * sample_time_s * sample_time_s;
    assert!((state.filtered_error / exact - 1.0).abs() < 1e-15, "s_1");
}

proptest! {
    #[test]
    fn default_state_is_a_reset(
        errors in prop::collection::vec(-1.0..1.0_f64, 1..50),
        before in prop::collection::vec(-1.0..1.0_f64, 0..50),
    ) {
        let sampled = FilteredPd::new(0.04, 0.016, 0.1).and_then(|pd| pd.sampled(0.025)).unwrap();
        let mut state = PdState::default();
        for error in before {
            sampled.output(&mut state, error);
        }
        state = PdState::default();
        let mut fresh = PdState::default();
        for error in errors {
            let again = sampled.output(&mut state, error);
            prop_assert_eq!(again.to_bits(), sampled.output(&mut fresh, error).to_bits());
        }
    }

    #[test]
    fn outputs_superpose(
        pairs in prop::collection::vec((-1.0..1.0_f64, -1.0..1.0_f64), 1..100),
        (a, b) in (-3.0..3.0_f64, -3.0..3.0_f64),
        (proportional, derivative, time_constant_s) in (-1.0..1.0_f64, -1.0..1.0_f64, 0.05..2.0_f64),
        sample_time_s in 0.001..1.0_f64,
    ) {
        let pd = FilteredPd::new(proportional, derivative, time_constant_s).unwrap();
        let first: Vec<f64> = pairs.iter().map(|pair| pair.0).collect();
        let second: Vec<f64> = pairs.iter().map(|pair| pair.1).collect();
        let both: Vec<f64> = pairs.iter().map(|pair| a * pair.0 + b * pair.1).collect();
        let first = outputs(&pd, sample_time_s, &first);
        let second = outputs(&pd, sample_time_s, &second);
        let both = outputs(&pd, sample_time_s, &both);
        for k in 0..both.len() {
            let sum = a * first[k] + b * second[k];
            // Gains up to 1/0.05, six units of error, a hundred steps.
            prop_assert!((both[k] - sum).abs() <= 1e-11, "sample {}: {} and {}", k, both[k], sum);
        }
    }

    #[test]
    fn two_samples_of_a_held_error_are_one_of_twice_the_time(
        errors in prop::collection::vec(-1.0..1.0_f64, 1..50),
        time_constant_s in 0.02..2.0_f64,
        sample_time_s in 0.001..0.5_f64,
    ) {
        let pd = FilteredPd::new(0.04, 0.016, time_constant_s).unwrap();
        let held: Vec<f64> = errors.iter().flat_map(|&error| [error, error]).collect();
        let fine = outputs(&pd, sample_time_s, &held);
        let coarse = outputs(&pd, 2.0 * sample_time_s, &errors);
        for (k, output) in coarse.iter().enumerate() {
            prop_assert!((output - fine[2 * k]).abs() <= ROUNDING, "sample {}", k);
        }
    }

    #[test]
    fn filtered_error_stays_within_the_errors_seen(
        errors in prop::collection::vec(-1.0..1.0_f64, 1..200),
        time_constant_s in 0.001..5.0_f64,
    ) {
        let sampled = FilteredPd::new(1.0, 0.0, time_constant_s).and_then(|pd| pd.sampled(0.025)).unwrap();
        let mut state = PdState::default();
        for error in errors {
            sampled.output(&mut state, error);
            prop_assert!(state.filtered_error.abs() <= 1.0, "{}", state.filtered_error);
        }
    }
}

#[test]
fn a_loop_says_what_it_was_made_with() {
    let pd = FilteredPd::new(0.25, -0.75, 1.5).expect("valid gains");
    let said = [pd.proportional(), pd.derivative(), pd.time_constant_s()].map(f64::to_bits);
    assert_eq!(said, [0.25_f64, -0.75, 1.5].map(f64::to_bits));
}
