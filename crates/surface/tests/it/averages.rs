//! Comparing surfaces by what leaving one out says.

use doe::Model;
use surface::{Confounded, Data, Kind, compare};

use crate::check_close;

/// A bowl with a little scatter that is not a polynomial.
fn bowl() -> Data {
    let points: Vec<f64> = (0..25).flat_map(|i| [f64::from(i / 5) / 2.0 - 1.0, f64::from(i % 5) / 2.0 - 1.0]).collect();
    let scatter = |i: usize| 0.02 * ((i * 7 % 5) as f64 - 2.0);
    let values =
        points.chunks_exact(2).enumerate().map(|(i, x)| x[0] * x[0] + 2.0 * x[1] * x[1] + scatter(i)).collect();
    Data::new(2, points, values).expect("valid data")
}

fn regression(model: Result<Model, doe::DesignSpaceError>) -> Kind {
    Kind::Regression { model: model.expect("a valid model"), confounded: Confounded::Refuse }
}

#[test]
fn a_bowl_is_predicted_best_by_a_quadratic_model() {
    let kinds = [
        Kind::InverseDistance { power: 2.0 },
        // 45 terms for 25 data: no surface at all.
        regression(Model::new(2, (0..45).map(|i| doe::Term::new([i / 8, i % 8])).collect())),
        Kind::SquaredExponential { scale: None },
        regression(Model::linear(2)),
        regression(Model::quadratic(2)),
    ];
    let comparisons = compare(&bowl(), &kinds);
    assert_eq!(comparisons[0].kind, kinds[4]);
    assert_eq!(comparisons[4].kind, kinds[1]);
    assert!(comparisons[4].outcome.is_err(), "too few data");
    let rms: Vec<f64> = comparisons[..4].iter().filter_map(|c| c.outcome.as_ref().ok()).map(|o| o.rms()).collect();
    assert!(rms.windows(2).all(|pair| pair[0] <= pair[1]) && rms.len() == 4, "{rms:?}");
}

#[test]
fn press_and_rms_weigh_the_residuals() {
    // Inverse distance between two points: each is predicted by the other.
    let data = Data::new(1, vec![0.0, 1.0, 7.0], vec![1.0, 3.0, 100.0]);
    let data = data.and_then(|data| data.with_weights(vec![1.0, 3.0, 0.0])).expect("valid data");
    let left_out = Kind::InverseDistance { power: 2.0 }.leave_one_out(&data).expect("two points");
    assert_eq!(left_out.residuals()[..2], [-2.0, 2.0]);
    assert!(left_out.residuals()[2] > 97.0, "the point without weight is predicted by the others");
    check_close(left_out.press(), 16.0, 1e-15, "press");
    check_close(left_out.rms(), 2.0, 1e-15, "rms");
}
