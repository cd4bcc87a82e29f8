//! Whole flights against an independent plant (Newton and Euler) and integrator (DOP853 at 1e-12).

use serde_json::Value;
use water_channel::{Flight, N_TERMS, fly_logged, open_loop_cost};

use crate::rigs::{assert_close, first_row, flown, full_test, golden, numbers, request_of, weights};

/// Both roots are found to the last bit.
const TRIM: f64 = 1e-10;
/// Two steps per sample: the truncation is 3e-7 of the cost.
const COST_TWO_STEPS: f64 = 1e-6;
/// Two steps per sample: small entries of the Gram matrix are left over from the perturbation and lose more.
const GRAM_TWO_STEPS: f64 = 2e-5;
/// The same method with the same steps leaves only rounding: 1e-11 by the golden file's own statement.
const SAME_METHOD: f64 = 1e-11;
/// Samples of the states after two steps per sample: the truncation.
const STATE_TWO_STEPS: f64 = 2e-6;

fn cases() -> Vec<Value> {
    golden("water-channel/closed_loop.json")["cases"].as_array().unwrap().clone()
}

fn ballast_pct(case: &Value) -> f64 {
    case["center_of_mass_x_pct_chord"].as_f64().unwrap() - 45.4
}

#[track_caller]
fn check(case: &Value, found: f64, key: &str, relative: f64) {
    let expected = case[key].as_f64().unwrap();
    assert_close(found, expected, relative * expected.abs(), &format!("{key} of {}", case["name"]));
}

fn fly_case(case: &Value, steps_per_sample: usize) -> Flight {
    flown(&request_of(case), &full_test(), steps_per_sample)
}

#[test]
fn flights_match_an_independent_integration_at_tight_tolerance() {
    let cases = cases();
    assert_eq!(cases.len(), 6, "cases in the golden file");
    for case in &cases {
        let request = request_of(case);
        let (outcome, log) = fly_logged(&request, &full_test(), &water_channel::FlightSettings::default(), 1).unwrap();
        let flight = outcome.unwrap();

        let [zenith, azimuth, twist, length, pitch, roll] = flight.trim.coordinates;
        for (found, key) in [(zenith, "Phi"), (length, "L_t"), (pitch, "theta_prime")] {
            check(&case["trim"], found, key, TRIM);
        }
        for (what, angle) in [("azimuth", azimuth), ("twist", twist), ("induced roll", roll)] {
            assert!(angle.abs() <= 0.0, "{what} at trim: {angle}");
        }
        let tensions = flight.trim.tensions.named().map(|line| line.1);
        for (found, expected) in tensions.iter().zip(numbers(&case["trim"]["tensions"])) {
            assert_close(*found, expected, TRIM, "tension at trim");
        }

        let breakdown = weights().cost(&flight.integrals, ballast_pct(case));
        check(case, breakdown.total, "cost", COST_TWO_STEPS);
        check(case, breakdown.terms[N_TERMS], "cost_k7", 1e-12);
        let [heading, lateral] = open_loop_cost(&flight.integrals, 1.0, 1.0);
        check(case, heading, "integral_psi_error_squared", GRAM_TWO_STEPS);
        check(case, lateral, "integral_y_squared", GRAM_TWO_STEPS);
        for (row, expected) in flight.integrals.gram.iter().zip(case["gram"].as_array().unwrap()) {
            for (found, expected) in row.iter().zip(numbers(expected)) {
                assert_close(*found, expected, GRAM_TWO_STEPS * expected, "entry of the Gram matrix");
            }
        }

        check(&case["peak_abs_psi"], flight.extremes.peak_heading_rad, "value", STATE_TWO_STEPS);
        let least = &case["min_tension_after_samples"];
        check(least, flight.extremes.smallest_tension_n, "value", 1e-5);
        check(least, flight.extremes.smallest_tension_time_s, "time", 1e-12);
        let lines = ["center", "starboard", "port"];
        let line = lines[least["line"].as_u64().unwrap() as usize - 1];
        assert_eq!(flight.extremes.smallest_tension_line, line, "line with the smallest tension");

        for (key, sample) in [("state_at_20_s", 800), ("state_at_50_s", 2000), ("state_at_150_s", 6000)] {
            let row = &log.rows[sample];
            for (found, expected) in row.state.iter().zip(numbers(&case[key])) {
                assert_close(*found, expected, STATE_TWO_STEPS, key);
            }
        }
        for (found, expected) in flight.final_state.iter().zip(numbers(&case["final_state"])) {
            assert_close(*found, expected, STATE_TWO_STEPS, "final state");
        }
    }
}

#[test]
fn flights_match_the_same_method_of_the_independent_program_to_rounding() {
    for case in &cases() {
        for entry in case["rk4"].as_array().unwrap() {
            let flight = fly_case(case, entry["steps_per_sample"].as_u64().unwrap() as usize);
            check(entry, weights().cost(&flight.integrals, ballast_pct(case)).total, "cost", SAME_METHOD);
            check(entry, flight.integrals.heading_squared, "integral_psi_error_squared", SAME_METHOD);
            for (found, expected) in flight.final_state.iter().zip(numbers(&entry["final_state"])) {
                assert_close(*found, expected, SAME_METHOD, "final state");
            }
        }
    }
}

/// Check 27: the error of the cost falls with the fourth power of the step, and two steps are enough for 1e-6.
#[test]
fn error_of_the_cost_falls_with_the_fourth_power_of_the_step() {
    for case in &cases() {
        let truth = case["cost"].as_f64().unwrap();
        let error = |steps| {
            let total = weights().cost(&fly_case(case, steps).integrals, ballast_pct(case)).total;
            (total - truth).abs() / truth
        };
        let errors = [error(1), error(2), error(4)];
        assert!(errors[0] < 2e-5 && errors[1] < 1e-6 && errors[2] < 6e-8, "{}: {errors:?}", case["name"]);
        for pair in errors.windows(2) {
            // The stored truth has nine digits to spare at four steps; a kink of the stalled lift costs a little order.
            let slope = (pair[0] / pair[1]).log2();
            assert!((3.7..=4.7).contains(&slope), "{}: slope {slope}, errors {errors:?}", case["name"]);
        }
    }
}

#[test]
fn two_and_four_steps_per_sample_agree_on_the_cost_to_1e_6() {
    let [two, four] =
        [2, 4].map(|steps| weights().cost(&flown(&first_row(), &full_test(), steps).integrals, 0.7).total);
    assert_close(two, four, 1e-6 * four, "cost");
}
