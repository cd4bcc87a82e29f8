//! Errors of poses under noise and quantization: those that the normal equations promise.

use nalgebra::{Matrix6, Vector6};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use water_channel::{PixelNoise, Pose, Sensing};

use super::{MIDDLE, perfect, viewer};

const DRAWS: usize = 6000;
/// A right program exceeds five standard errors in one of 21 entries once in some ten thousand seeds; the seed is fixed.
const STANDARD_ERRORS: f64 = 5.0;

fn error_of(found: &Pose, truth: &Pose) -> Vector6<f64> {
    Vector6::from(found.numbers()) - Vector6::from(truth.numbers())
}

#[test]
fn errors_under_noise_have_the_covariance_of_the_normal_equations() {
    let sensing = Sensing { pixel_noise_px: 0.1, ..perfect() };
    let (viewer, mut noise) = (viewer(&sensing), PixelNoise::new(7));
    let mut sum = Vector6::zeros();
    let mut products = Matrix6::zeros();
    for _ in 0..DRAWS {
        let view = viewer.look(&MIDDLE, &mut noise);
        let error = error_of(&viewer.locate(&view, &MIDDLE).unwrap(), &MIDDLE);
        sum += error;
        products += error * error.transpose();
    }
    let n = DRAWS as f64;
    let (mean, found) = (sum / n, products / n);
    let view = viewer.look(&MIDDLE, &mut noise);
    let promised = viewer.covariance(&view, &MIDDLE, sensing.pixel_deviation_px()).unwrap();
    for i in 0..6 {
        let limit = STANDARD_ERRORS * (promised[(i, i)] / n).sqrt();
        assert!(mean[i].abs() < limit, "mean error {i}: {:e}, at most {limit:e}", mean[i]);
        for j in 0..=i {
            // Of a product of two normal numbers.
            let variance = (promised[(i, i)] * promised[(j, j)] + promised[(i, j)].powi(2)) / n;
            let (gap, limit) = (found[(i, j)] - promised[(i, j)], STANDARD_ERRORS * variance.sqrt());
            assert!(gap.abs() < limit, "covariance ({i}, {j}): off by {gap:e}, at most {limit:e}");
        }
    }
}

/// A search ends before it has come to rest, and what it leaves is nothing beside the noise: sought from another noisy pose and a
/// sample's way off, as in a flight, every number of a pose is within half a thousandth of its standard deviation of where searches
/// come to rest that begin where the last one ended.
#[test]
fn what_a_search_leaves_is_far_below_the_noise() {
    for noise_px in [0.03, 0.1, 0.3, 1.0] {
        let viewer = viewer(&Sensing { pixel_noise_px: noise_px, ..perfect() });
        let (mut noise, mut generator) = (PixelNoise::new(11), Pcg64::seed_from_u64(5));
        for _ in 0..2000 {
            let truth = scattered(&mut generator);
            let mut off = |size: f64| size * (2.0 * generator.random::<f64>() - 1.0);
            let before = Pose {
                position_m: std::array::from_fn(|k| truth.position_m[k] + off(5e-4)),
                roll_rad: truth.roll_rad + off(5e-3),
                pitch_rad: truth.pitch_rad + off(5e-3),
                heading_rad: truth.heading_rad + off(5e-3),
            };
            let guess = viewer.locate(&viewer.look(&before, &mut noise), &before).unwrap();
            let view = viewer.look(&truth, &mut noise);
            let found = viewer.locate(&view, &guess).unwrap();
            let at_rest = (0..3).fold(found, |pose, _| viewer.locate(&view, &pose).unwrap());
            let promised = viewer.covariance(&view, &at_rest, noise_px).unwrap();
            let left = error_of(&found, &at_rest);
            for i in 0..6 {
                let (left, limit) = (left[i].abs(), 5e-4 * promised[(i, i)].sqrt());
                assert!(left < limit, "{noise_px} px, number {i}: {left:e}, at most {limit:e}");
            }
        }
    }
}

/// Poses all over a few pixels, so that dots fall anywhere between the steps.
fn scattered(generator: &mut Pcg64) -> Pose {
    let mut off = |size: f64| size * (2.0 * generator.random::<f64>() - 1.0);
    Pose {
        position_m: std::array::from_fn(|k| MIDDLE.position_m[k] + off(0.01)),
        roll_rad: MIDDLE.roll_rad + off(0.05),
        pitch_rad: MIDDLE.pitch_rad + off(0.05),
        heading_rad: MIDDLE.heading_rad + off(0.05),
    }
}

#[test]
fn quantization_errs_like_uniform_noise_of_a_twelfth_of_the_step_squared() {
    for step_px in [1.0, 0.25] {
        let sensing = Sensing { quantization_px: step_px, ..perfect() };
        let (exact, told) = (viewer(&perfect()), viewer(&sensing));
        let mut generator = Pcg64::seed_from_u64(3);
        let (mut n, mut sum, mut squares, mut fourth, mut largest) = (0.0, 0.0, 0.0, 0.0, 0.0f64);
        let mut whitened = 0.0;
        for _ in 0..2000 {
            let truth = scattered(&mut generator);
            let (clean, rounded) =
                (exact.look(&truth, &mut PixelNoise::new(1)), told.look(&truth, &mut PixelNoise::new(1)));
            for (a, b) in clean.sightings().iter().zip(rounded.sightings()) {
                for k in 0..2 {
                    let error = b.pixel[k] - a.pixel[k];
                    n += 1.0;
                    sum += error;
                    squares += error * error;
                    fourth += error.powi(4);
                    largest = largest.max(error.abs());
                }
            }
            let found = told.locate(&rounded, &truth).unwrap();
            let promised = told.covariance(&rounded, &truth, sensing.pixel_deviation_px()).unwrap();
            let error = error_of(&found, &truth);
            whitened += (error.transpose() * promised.try_inverse().unwrap() * error)[0] / 6.0;
        }
        let variance = step_px * step_px / 12.0;
        assert!(largest <= 0.5 * step_px + 1e-9, "no error beyond half a step: {largest}");
        assert!((sum / n).abs() < STANDARD_ERRORS * (variance / n).sqrt(), "mean {}", sum / n);
        // Fourth moment of a uniform number: variance² 9/5.
        let limit = STANDARD_ERRORS * variance * (0.8 / n).sqrt();
        assert!((squares / n - variance).abs() < limit, "variance {}", squares / n);
        assert!((fourth / n / (1.8 * variance * variance) - 1.0).abs() < 0.02, "uniform, not normal");
        // The mean over 2000 poses of a sum of six squares over six: 1, give or take sqrt(2/6/2000).
        let gap = whitened / 2000.0 - 1.0;
        assert!(gap.abs() < STANDARD_ERRORS * (2.0 / 6.0 / 2000.0f64).sqrt(), "poses: {gap}");
    }
}

#[test]
fn noise_follows_its_seed_and_its_size() {
    let noisy = |seed: u64| {
        let sensing = Sensing { pixel_noise_px: 0.1, ..perfect() };
        viewer(&sensing).look(&MIDDLE, &mut PixelNoise::new(seed))
    };
    assert_eq!(noisy(5), noisy(5), "the same seed");
    assert_ne!(noisy(5), noisy(6), "another seed");
    let clean = viewer(&perfect()).look(&MIDDLE, &mut PixelNoise::new(5));
    let double = Sensing { pixel_noise_px: 0.2, ..perfect() };
    let double = viewer(&double).look(&MIDDLE, &mut PixelNoise::new(5));
    for ((a, b), clean) in noisy(5).sightings().iter().zip(double.sightings()).zip(clean.sightings()) {
        let (once, twice) = (a.pixel[0] - clean.pixel[0], b.pixel[0] - clean.pixel[0]);
        assert!((2.0 * once - twice).abs() < 1e-9, "twice the noise: {once} and {twice}");
    }
}
