//! The costs (20), (21) and (60) as integrals of what the log shows.

use bat_dynamics::Fidelity;
use proptest::prelude::*;
use water_channel::{CostWeights, Flight, FlightSettings, Integrals, N_TERMS, TERM_NAMES, fly_logged, open_loop_cost};

use crate::rigs::{assert_close, flown, request, short_test, weights};

const ZERO: CostWeights = CostWeights { terms: [0.0; N_TERMS], ballast: 0.0 };

fn flight() -> Flight {
    flown(&request(Fidelity::STALLED_WITH_ADDED_MASS, 48.0, 12.0), &short_test(8.0), 1)
}

fn positive() -> impl Strategy<Value = CostWeights> {
    (prop::array::uniform6(0.0..1e3_f64), 0.0..1e-3_f64).prop_map(|(terms, ballast)| CostWeights { terms, ballast })
}

/// A Gram matrix of six functions given by a few values each.
fn integrals() -> impl Strategy<Value = Integrals> {
    prop::collection::vec(prop::array::uniform6(0.0..2.0_f64), 1..6).prop_map(|values| {
        let mut gram = [[0.0; N_TERMS]; N_TERMS];
        for (i, row) in gram.iter_mut().enumerate() {
            for (j, entry) in row.iter_mut().enumerate() {
                *entry = values.iter().map(|f| f[i] * f[j]).sum();
            }
        }
        Integrals { gram, heading_squared: 1.0, lateral_squared: 1.0, duration_s: 300.0 }
    })
}

#[test]
fn ballast_is_how_far_aft_of_the_center_of_buoyancy_the_center_of_mass_lies() {
    let rig = request(Fidelity::NUMERICAL, 48.0, 12.0).rig;
    // The center of buoyancy is at 45.4 % of the chord.
    assert_close(rig.ballast_pct_chord(), 2.6, 1e-12, "ballast in per cent of chord");
}

/// Check of the quadrature: the trapezoidal rule over the samples of the log. The line speeds bend at every sample and
/// within (the winch lag is 2.7 samples), so the rule is good to about one part in a hundred of that term.
#[test]
fn each_integral_is_that_of_the_logged_quantity() {
    let request = request(Fidelity::STALLED_WITH_ADDED_MASS, 48.0, 12.0);
    let (outcome, log) = fly_logged(&request, &short_test(8.0), &FlightSettings::default(), 1).unwrap();
    let flight = outcome.unwrap();
    let rows = &log.rows;
    let trapezoid = |f: &dyn Fn(usize) -> f64| {
        let inner: f64 = (1..rows.len()).map(f).sum();
        0.025 * (inner + 0.5 * f(0))
    };
    let term = |k: usize, i: usize| {
        let row = &rows[k];
        match i {
            0 => row.heading_rad.powi(2),
            1 => row.pitch_error_rad.powi(2),
            2 => row.roll_error_rad.powi(2),
            3 => row.altitude_error_m.powi(2),
            4 => row.state[9..].iter().map(|speed| speed * speed).sum(),
            _ => row.state[0],
        }
    };
    for (i, row) in flight.integrals.gram.iter().enumerate() {
        for (j, found) in row.iter().enumerate() {
            let expected = trapezoid(&|k| term(k, i) * term(k, j));
            assert_close(*found, expected, 0.02 * expected, &format!("{} times {}", TERM_NAMES[i], TERM_NAMES[j]));
        }
    }
    let [heading, lateral] = open_loop_cost(&flight.integrals, 0.2, 0.0125);
    let expected = 0.2 * trapezoid(&|k| rows[k].heading_rad.powi(2));
    assert_close(heading, expected, 1e-3 * expected, "K1 term of (20)");
    let expected = 0.0125 * trapezoid(&|k| rows[k].lateral_m.powi(2));
    assert_close(lateral, expected, 1e-3 * expected, "K2 term of (20)");
}

#[test]
fn gram_matrix_is_symmetric_and_positive_semidefinite() {
    let gram = flight().integrals.gram;
    let matrix = nalgebra::Matrix6::from(gram);
    assert_eq!(matrix, matrix.transpose(), "symmetric bit for bit");
    // Scaled to a unit diagonal; what is negative is rounding.
    let scaled = nalgebra::Matrix6::from_fn(|i, j| gram[i][j] / (gram[i][i] * gram[j][j]).sqrt());
    let smallest = scaled.symmetric_eigenvalues().min();
    assert!(smallest > -1e-12, "smallest eigenvalue {smallest:e}");
}

#[test]
fn each_weight_alone_gives_its_own_square() {
    let integrals = flight().integrals;
    for (i, name) in TERM_NAMES[..N_TERMS].iter().enumerate() {
        let mut alone = ZERO;
        alone.terms[i] = 3.0;
        let cost = alone.cost(&integrals, 2.0);
        assert_close(cost.total, 9.0 * integrals.gram[i][i], 1e-15 * cost.total, name);
        assert_close(cost.terms[i], cost.total, 0.0, name);
    }
    let ballast = CostWeights { ballast: 0.5, ..ZERO }.cost(&integrals, -2.0);
    assert_close(ballast.total, 0.5 * 4.0 * 8.0, 1e-12, "k7 (x_cm - x_cb)^2 T");
    assert_close(ballast.terms[N_TERMS], ballast.total, 0.0, "ballast");
}

#[test]
fn published_weights_give_the_published_form() {
    // K1 = 0.2 per rad² and K2 = 0.0125 per m² of (20).
    let integrals = Integrals { heading_squared: 0.5, lateral_squared: 4.0, ..flight().integrals };
    let [heading, lateral] = open_loop_cost(&integrals, 0.2, 0.0125);
    assert_close(heading, 0.1, 1e-16, "K1 term");
    assert_close(lateral, 0.05, 1e-16, "K2 term");
    let of_the_file = [0.3981904, 9.672002, 1.964109, 1612.834, 949.8668, 0.9753303];
    for (found, expected) in weights().terms.iter().zip(of_the_file) {
        assert_close(*found, expected, 0.0, "weight of the fixture");
    }
}

proptest! {
    #[test]
    fn terms_sum_to_the_total(weights in positive(), integrals in integrals(), ballast in -5.0..5.0_f64) {
        let cost = weights.cost(&integrals, ballast);
        let sum: f64 = cost.terms.iter().sum();
        prop_assert!((sum - cost.total).abs() <= 1e-14 * cost.total);
        prop_assert!(cost.terms.iter().all(|term| *term >= 0.0));
    }

    #[test]
    fn cost_is_the_quadratic_form(weights in positive(), integrals in integrals()) {
        let k = nalgebra::Vector6::from(weights.terms);
        let form = k.dot(&(nalgebra::Matrix6::from(integrals.gram) * k));
        let cost = CostWeights { ballast: 0.0, ..weights }.cost(&integrals, 3.0);
        prop_assert!((cost.total - form).abs() <= 1e-13 * form);
    }

    /// (60) is (21) with k7 = 0, whatever the ballast.
    #[test]
    fn cost_without_k7_does_not_see_the_ballast(
        weights in positive(),
        integrals in integrals(),
        one in -5.0..5.0_f64,
        other in -5.0..5.0_f64,
    ) {
        let free = CostWeights { ballast: 0.0, ..weights };
        prop_assert_eq!(free.cost(&integrals, one), free.cost(&integrals, other));
        let difference = weights.cost(&integrals, one).total - free.cost(&integrals, one).total;
        let expected = weights.ballast * one * one * 300.0;
        prop_assert!((difference - expected).abs() <= 1e-13 * weights.cost(&integrals, one).total);
    }

    #[test]
    fn cost_scales_with_the_square_of_its_weights(
        weights in positive(),
        integrals in integrals(),
        factor in 0.01..100.0_f64,
    ) {
        let terms = weights.terms.map(|k| factor * k);
        let scaled = CostWeights { terms, ballast: factor * factor * weights.ballast };
        let (one, other) = (weights.cost(&integrals, 1.5).total, scaled.cost(&integrals, 1.5).total);
        prop_assert!((other - factor * factor * one).abs() <= 1e-13 * other);
    }

    #[test]
    fn cost_grows_with_every_weight(
        weights in positive(),
        integrals in integrals(),
        which in 0..N_TERMS,
        more in 0.0..10.0_f64,
    ) {
        let mut larger = weights;
        larger.terms[which] += more;
        let (before, after) = (weights.cost(&integrals, 0.0).total, larger.cost(&integrals, 0.0).total);
        prop_assert!(after >= before * (1.0 - 1e-14));
    }
}
