//! Where experiments fail: Laplace's approximation, once more by hand.

use statrs::distribution::{Continuous, ContinuousCDF, Normal};
use surface::process::{Feasibility, Places};

use crate::check_close;

/// Of the latent process: quadratic trend of variance 1/4, Matérn-5/2 of variance 4 and length 0.6.
fn kernel(a: [f64; 2], b: [f64; 2]) -> f64 {
    let third = |x: f64| x * x - 1.0 / 3.0;
    let trend =
        a[0] * b[0] + a[1] * b[1] + third(a[0]) * third(b[0]) + a[0] * a[1] * b[0] * b[1] + third(a[1]) * third(b[1]);
    let r = 5.0_f64.sqrt() * (a[0] - b[0]).hypot(a[1] - b[1]) / 0.6;
    0.25 * trend + 4.0 * (1.0 + r + r * r / 3.0) * (-r).exp()
}

/// Two experiments, of which the first failed: the mode by small steps along the gradient, the rest by a 2 by 2 inverse.
#[test]
fn probabilities_after_a_failure_and_a_success_are_those_of_laplace() {
    let tested = [[0.3, -0.4], [-0.2, 0.5]];
    let labels = [-1.0, 1.0];
    let normal = Normal::standard();
    let k: Vec<[f64; 2]> = tested.iter().map(|&a| [kernel(a, tested[0]), kernel(a, tested[1])]).collect();
    let slope = |f: f64, label: f64| label * normal.pdf(f + 1.0) / normal.cdf(label * (f + 1.0));
    let mut mode = [0.0; 2];
    for _ in 0..2000 {
        let slopes = [slope(mode[0], labels[0]), slope(mode[1], labels[1])];
        for i in 0..2 {
            mode[i] += 0.05 * (k[i][0] * slopes[0] + k[i][1] * slopes[1] - mode[i]);
        }
    }
    let slopes = [slope(mode[0], labels[0]), slope(mode[1], labels[1])];
    // The curvature of the logarithm by a difference of its slope.
    let h = 1e-5;
    let curvature = |i: usize| (slope(mode[i] - h, labels[i]) - slope(mode[i] + h, labels[i])) / (2.0 * h);
    let (a, b, off) = (k[0][0] + 1.0 / curvature(0), k[1][1] + 1.0 / curvature(1), k[0][1]);
    let determinant = a * b - off * off;

    let places = [[0.3, -0.4], [-0.2, 0.5], [0.0, 0.0], [0.9, 0.9]];
    let feasibility = Feasibility::of(Places::new(2, &tested.concat()).expect("valid places"), &[false, true])
        .expect("one outcome per place")
        .expect("one failed");
    let found = feasibility.probabilities(&Places::new(2, &places.concat()).expect("valid places"));
    for (place, found) in places.into_iter().zip(found) {
        let [u, v] = [kernel(place, tested[0]), kernel(place, tested[1])];
        let mean = u * slopes[0] + v * slopes[1] + 1.0;
        let variance = kernel(place, place) - (b * u * u - 2.0 * off * u * v + a * v * v) / determinant;
        check_close(found, normal.cdf(mean / (1.0 + variance).sqrt()), 1e-7, &format!("{place:?}"));
    }
}

#[test]
fn where_nothing_failed_nothing_is_known_of_failures() {
    let places = Places::new(1, &[0.0, 0.5]).expect("valid places");
    assert!(Feasibility::of(places.clone(), &[true, true]).expect("one outcome per place").is_none(), "none failed");
    assert!(Feasibility::of(places, &[true]).is_err(), "an outcome is missing");
}
