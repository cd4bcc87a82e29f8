//! Against programs that share nothing with the code: projection by numpy and OpenCV, poses and covariances by scipy.

use serde_json::Value;
use water_channel::{PixelNoise, Pose, Sighting, View};

use super::{distance, perfect, viewer};
use crate::rigs::{assert_close, golden, numbers};

/// Rounding of some hundreds of pixels.
const PIXELS: f64 = 1e-9;
/// Within this the sum of squares is flat to rounding.
const POSES: f64 = 1e-8;

fn pose(value: &Value) -> Pose {
    let [x, y, z, roll_rad, pitch_rad, heading_rad] = numbers(value).try_into().unwrap();
    Pose { position_m: [x, y, z], roll_rad, pitch_rad, heading_rad }
}

fn sightings(case: &Value, pixel: &str) -> Vec<Sighting> {
    let one = |seen: &Value| Sighting {
        dot: seen["dot"].as_u64().unwrap() as usize,
        camera: seen["camera"].as_u64().unwrap() as usize,
        pixel: numbers(&seen[pixel]).try_into().unwrap(),
    };
    case["sightings"].as_array().unwrap().iter().map(one).collect()
}

fn cases() -> Vec<Value> {
    golden("water-channel/sensing.json")["cases"].as_array().unwrap().clone()
}

#[test]
fn pixels_and_the_dots_seen_match_independent_programs() {
    let viewer = viewer(&perfect());
    for case in cases() {
        let view = viewer.look(&pose(&case["pose"]), &mut PixelNoise::new(1));
        let expected = sightings(&case, "pixel");
        let ids = |seen: &[Sighting]| seen.iter().map(|s| (s.dot, s.camera)).collect::<Vec<_>>();
        assert_eq!(ids(view.sightings()), ids(&expected), "dots seen, by dot and camera");
        for (found, expected) in view.sightings().iter().zip(&expected) {
            for k in 0..2 {
                assert_close(found.pixel[k], expected.pixel[k], PIXELS, "pixel");
            }
        }
    }
}

#[test]
fn pose_of_noisy_pixels_matches_scipy() {
    let viewer = viewer(&perfect());
    for case in cases() {
        let view = View::new(sightings(&case, "noisy"));
        // A search ends where the noise hides the rest; the next one begins there, and goes on to where the sum of squares is flat.
        let found = viewer.locate(&view, &pose(&case["pose"])).unwrap();
        let found = viewer.locate(&view, &found).unwrap();
        let gap = distance(&found, &pose(&case["fitted"]));
        assert!(gap < POSES, "{found:?} is {gap:e} from {}", case["fitted"]);
    }
}

#[test]
fn covariance_matches_that_of_a_complex_step_jacobian() {
    let viewer = viewer(&perfect());
    for case in cases() {
        let view = View::new(sightings(&case, "noisy"));
        let found = viewer.covariance(&view, &pose(&case["fitted"]), 0.3).unwrap();
        let expected: Vec<Vec<f64>> = case["covariance"].as_array().unwrap().iter().map(numbers).collect();
        for i in 0..6 {
            for j in 0..6 {
                let scale = (expected[i][i] * expected[j][j]).sqrt();
                assert_close(found[(i, j)], expected[i][j], 1e-8 * scale, "covariance");
            }
        }
    }
}
