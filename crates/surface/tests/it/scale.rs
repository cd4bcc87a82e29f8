//! The scale of the squared exponential that the data choose.

use proptest::prelude::*;
use surface::{Data, SquaredExponential, Surface};

use crate::{any_data, check_close};

fn wave(n: usize) -> Data {
    let points: Vec<f64> = (0..n).map(|i| 2.0 * i as f64 / (n - 1) as f64 - 1.0).collect();
    // Scatter, without which the two nearest neighbors would always be the best estimate.
    let scatter = |i: usize| 0.3 * ((i * 13 % 7) as f64 - 3.0);
    let values = points.iter().enumerate().map(|(i, x)| (3.0 * x).sin() + 0.5 * scatter(i)).collect();
    Data::new(1, points, values).expect("valid data")
}

#[test]
fn chosen_scale_has_the_least_leave_one_out_error() {
    let data = wave(15);
    let surface = SquaredExponential::fit_scale(data.clone()).expect("fifteen places");
    let choice = *surface.choice().expect("it was chosen");
    assert!(!choice.at_bound && choice.lower < choice.scale && choice.scale < choice.upper, "{choice:?}");
    check_close(surface.scale(), choice.scale, 0.0, "the scale used");
    // No replicates: leaving out a place is leaving out a point.
    let rms =
        |scale: f64| SquaredExponential::fit(data.clone(), scale).and_then(|s| s.leave_one_out()).map(|l| l.rms());
    let least = rms(choice.scale).expect("fifteen points");
    check_close(least, choice.rms, 1e-12, "the error it reports");
    for step in 0..2000 {
        let scale = choice.lower * (choice.upper / choice.lower).powf(f64::from(step) / 1999.0);
        assert!(rms(scale).expect("fifteen points") >= least * (1.0 - 1e-9), "{scale} is better than {}", choice.scale);
    }
}

#[test]
fn replicates_do_not_drive_the_scale() {
    let once = wave(15);
    let twice = once.followed_by(&once).expect("one factor each");
    let scale = |data: Data| SquaredExponential::fit_scale(data).expect("fifteen places").scale();
    check_close(scale(twice) / scale(once), 1.0, 1e-6, "the scale of replicated data over that of the data");
}

#[test]
fn an_error_without_a_minimum_inside_is_said_to_be_at_the_bound() {
    // Alternating values: every neighbor is wrong, and the mean is the best there is.
    let points = (0..10).map(f64::from).collect();
    let values = (0..10).map(|i| f64::from(i % 2)).collect();
    let surface = SquaredExponential::fit_scale(Data::new(1, points, values).expect("valid data")).expect("ten places");
    let choice = surface.choice().expect("it was chosen");
    assert!(choice.at_bound && choice.scale <= choice.lower, "{choice:?}");
    check_close(surface.predict(&[4.3]), 0.5, 0.02, "nearly the mean");
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, cases: 30, ..ProptestConfig::default() })]

    #[test]
    fn scale_is_in_the_inverse_unit_of_the_coordinates(data in any_data(2, 8, 14), exponent in -20..20_i32) {
        prop_assume!(data.n_used() >= 5);
        let factor = 2.0_f64.powi(exponent);
        let points = data.coordinates().iter().map(|x| x * factor).collect();
        let stretched = Data::new(2, points, data.values().to_vec()).and_then(|d| d.with_weights(data.weights().to_vec()));
        let choice = |data: Data| *SquaredExponential::fit_scale(data).expect("places").choice().expect("chosen");
        let (plain, stretched) = (choice(data), choice(stretched.expect("valid data")));
        check_close(stretched.rms / plain.rms, 1.0, 1e-9, "error");
        check_close(stretched.lower * factor / plain.lower, 1.0, 1e-12, "lower end");
        check_close(stretched.upper * factor / plain.upper, 1.0, 1e-12, "upper end");
    }
}
