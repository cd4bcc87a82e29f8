//! At the data, next to them, and far away.

use surface::{Data, InverseDistance, Surface};

use crate::{check_close, check_exact, inverse_distance, squared_exponential};

fn data() -> Data {
    let data = Data::new(2, vec![0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0], vec![1.0, 3.0, 9.0, 7.0]);
    data.and_then(|data| data.with_weights(vec![2.0, 1.0, 1.0, 3.0])).expect("valid data")
}

/// (2·1 + 3 + 9 + 3·7)/7
const MEAN: f64 = 5.0;

#[test]
fn duplicates_average_by_weight() {
    for power in [0.5, 1.0, 2.0, 7.0, InverseDistance::LARGEST_POWER] {
        let surface = inverse_distance(&data(), power);
        check_exact(surface.predict(&[1.0, 0.0]), 6.0, &format!("(3 + 3 7)/4 with power {power}"));
        check_exact(surface.predict(&[0.0, 0.0]), 1.0, "a single datum");
    }
}

#[test]
fn inverse_distance_far_away_is_the_mean() {
    for power in [0.5, 1.0, 2.0, 3.0] {
        for far in [1e12, 1e100, 1e160, 1e290, 1e308, f64::MAX] {
            for direction in [[1.0, 0.3], [-1.0, 1.0], [0.0, -1.0]] {
                let x = direction.map(|unit| unit * far);
                check_close(inverse_distance(&data(), power).predict(&x), MEAN, 1e-10, &format!("{power} at {far:e}"));
            }
        }
    }
}

#[test]
fn inverse_distance_next_to_a_datum_is_the_datum() {
    for near in [1e-12, 1e-100, 1e-160, 1e-290, 5e-324] {
        for power in [1.0, 2.0, 50.0] {
            let estimate = inverse_distance(&data(), power).predict(&[near, 0.0]);
            check_close(estimate, 1.0, 1e-10, &format!("power {power} at {near:e}"));
        }
    }
}

#[test]
fn inverse_distance_tells_points_apart_whose_squared_distance_vanishes() {
    let data = Data::new(1, vec![0.0, 1e-200, 3e-200], vec![1.0, 2.0, 4.0]).expect("valid data");
    let surface = inverse_distance(&data, 2.0);
    for (x, value) in [(0.0, 1.0), (1e-200, 2.0), (3e-200, 4.0)] {
        check_exact(surface.predict(&[x]), value, "at a datum");
    }
    // Distances 2, 1, 1 and weights 1/4, 1, 1.
    check_close(surface.predict(&[2e-200]), (0.25 + 2.0 + 4.0) / 2.25, 1e-14, "between them");
}

#[test]
fn squared_exponential_far_away_is_the_nearest() {
    for scale in [1e-3, 1.0, 30.0, 1e50] {
        let surface = squared_exponential(&data(), scale);
        for far in [1e9, 1e100, 1e200, f64::MAX] {
            check_exact(surface.predict(&[far, 0.1 * far]), 6.0, &format!("{scale} at {far:e}: the two at (1, 0)"));
            check_exact(surface.predict(&[-far, -far]), 1.0, &format!("{scale} at {far:e}: the origin"));
            check_exact(surface.predict(&[0.1 * far, far]), 9.0, &format!("{scale} at {far:e}: the one at (0, 1)"));
            // As far from (1, 0) as from (0, 1): (3 + 21 + 9)/5.
            check_close(surface.predict(&[far, far]), 6.6, 1e-14, "between two directions");
        }
    }
}

#[test]
fn squared_exponential_goes_from_the_mean_to_the_nearest_neighbor_with_its_scale() {
    let x = [0.4, 0.3];
    check_close(squared_exponential(&data(), 1e-9).predict(&x), MEAN, 1e-14, "a small scale");
    check_close(squared_exponential(&data(), 1e-100).predict(&x), MEAN, 1e-14, "the smallest");
    check_exact(squared_exponential(&data(), 1e4).predict(&x), 1.0, "a large scale");
    check_exact(squared_exponential(&data(), 1e100).predict(&x), 1.0, "the largest");
}

#[test]
fn squared_exponential_is_continuous_where_its_sums_would_vanish() {
    // Between the data at distance 1 the exponent passes 600 at a scale of 24.49 and distance 1 from both.
    let data = Data::new(1, vec![-1.0, 1.0], vec![0.0, 10.0]).expect("valid data");
    for scale in [24.4, 24.49, 24.5, 24.6, 26.0] {
        let surface = squared_exponential(&data, scale);
        for x in [0.0, 1e-4, -3e-4, 1e-3] {
            // The weights differ by the factor exp(4 c² x).
            let expected = 10.0 / (1.0 + (-4.0 * scale * scale * x).exp());
            check_close(surface.predict(&[x]), expected, 1e-11, &format!("scale {scale} at {x}"));
        }
    }
}

#[test]
fn gradient_next_to_replicates_is_as_good_as_next_to_one_datum() {
    // Two values at the origin, and their mean: the slopes agree, although those of the two cancel to 1e-14 of theirs.
    let data = |points: &[f64], values: &[f64], weights: &[f64]| {
        let data = Data::new(1, points.to_vec(), values.to_vec());
        data.and_then(|data| data.with_weights(weights.to_vec())).expect("valid data")
    };
    let two = data(&[0.0, 0.0, 1.0], &[-50.0, 53.0, 3.0], &[1.0, 1.0, 1.0]);
    let one = data(&[0.0, 1.0], &[1.5, 3.0], &[2.0, 1.0]);
    let slope = |data: &Data| inverse_distance(data, 2.0).gradient(&[1e-7]).expect("off the data")[0];
    check_close(slope(&two) / slope(&one), 1.0, 1e-12, "slope at two data over that at their mean");
}

#[test]
fn values_and_weights_of_any_size_are_averaged() {
    let data = Data::new(1, vec![0.0, 1.0], vec![1e100, -1e100]);
    let data = data.and_then(|data| data.with_weights(vec![1e-100, 1e100])).expect("valid data");
    for surface in [&inverse_distance(&data, 2.0) as &dyn Surface, &squared_exponential(&data, 1.0)] {
        let estimate = surface.predict(&[0.5]);
        check_close(estimate / -1e100, 1.0, 1e-14, "the heavy one");
    }
    check_exact(inverse_distance(&data, 2.0).predict(&[0.0]), 1e100, "a datum stays one, however light");
}

#[test]
fn points_that_are_no_points_have_no_estimate() {
    let surfaces: [&dyn Surface; 2] = [&inverse_distance(&data(), 2.0), &squared_exponential(&data(), 1.0)];
    for surface in surfaces {
        for x in [&[0.0][..], &[0.0; 3], &[], &[f64::NAN, 0.0], &[0.0, f64::INFINITY], &[f64::NEG_INFINITY, f64::NAN]] {
            assert!(surface.predict(x).is_nan(), "{x:?}");
            assert_eq!(surface.gradient(x), None, "{x:?}");
        }
        assert_eq!(surface.variance(&[0.0, 0.0]), None, "no model of the errors");
    }
}

#[test]
fn gradient_of_inverse_distance_at_a_datum_is_zero_or_missing() {
    for (power, expected) in [(2.0, Some(vec![0.0, 0.0])), (1.5, Some(vec![0.0, 0.0])), (1.0, None), (0.5, None)] {
        assert_eq!(inverse_distance(&data(), power).gradient(&[0.0, 1.0]), expected, "power {power}");
    }
    // Next to it the slope falls as the distance: 2 d Σ (J_i − J) w_i/d_i² / w.
    let slope = inverse_distance(&data(), 2.0).gradient(&[0.0, 1e-8]).expect("off the data")[1];
    let expected = 2e-8 * ((3.0 - 1.0) + (9.0 - 1.0) + 3.0 * (7.0 - 1.0)) / 2.0;
    check_close(slope / expected, 1.0, 1e-6, "slope next to the origin");
    let tiny = inverse_distance(&data(), 2.0).gradient(&[1e-200, 0.0]).expect("off the data");
    assert!(tiny.iter().all(|slope| slope.abs() < 1e-100), "{tiny:?}");
}
