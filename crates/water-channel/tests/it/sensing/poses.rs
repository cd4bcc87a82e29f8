//! Poses without noise: the truth comes back, from near and from far.

use proptest::prelude::*;
use water_channel::{PixelNoise, Pose};

use super::{MIDDLE, cameras, distance, perfect, viewer};

/// The range over which the rig flies, with room to spare.
fn poses() -> impl Strategy<Value = Pose> {
    let ranges = (-0.3..0.05f64, -0.12..0.12f64, -0.64..-0.5f64, -0.4..0.4f64, -0.1..0.55f64, -0.5..0.5f64);
    ranges.prop_map(|(x, y, z, roll_rad, pitch_rad, heading_rad)| Pose {
        position_m: [x, y, z],
        roll_rad,
        pitch_rad,
        heading_rad,
    })
}

fn beside(pose: &Pose, shift_m: [f64; 3], turn_rad: [f64; 3]) -> Pose {
    Pose {
        position_m: std::array::from_fn(|k| pose.position_m[k] + shift_m[k]),
        roll_rad: pose.roll_rad + turn_rad[0],
        pitch_rad: pose.pitch_rad + turn_rad[1],
        heading_rad: pose.heading_rad + turn_rad[2],
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// From a guess as far off as the body gets in tens of samples.
    #[test]
    fn pose_without_noise_is_the_truth(
        truth in poses(),
        shift in prop::array::uniform3(-0.02..0.02f64),
        turn in prop::array::uniform3(-0.1..0.1f64),
    ) {
        let viewer = viewer(&perfect());
        let view = viewer.look(&truth, &mut PixelNoise::new(1));
        let found = viewer.locate(&view, &beside(&truth, shift, turn)).unwrap();
        prop_assert!(distance(&found, &truth) < 1e-9, "{found:?} for {truth:?}");
    }

    /// From far off it is the truth as well, or held: never another pose that passes for it without fitting.
    #[test]
    fn pose_from_a_far_guess_is_the_truth(
        truth in poses(),
        shift in prop::array::uniform3(-0.15..0.15f64),
        turn in prop::array::uniform3(-0.6..0.6f64),
    ) {
        let viewer = viewer(&perfect());
        let view = viewer.look(&truth, &mut PixelNoise::new(1));
        let found = viewer.locate(&view, &beside(&truth, shift, turn)).unwrap();
        prop_assert!(distance(&found, &truth) < 1e-9, "{found:?} for {truth:?}");
    }

    /// Where the point of the pose lies makes no difference to the body.
    #[test]
    fn same_body_is_found_about_any_point(truth in poses()) {
        let sensing = perfect();
        let center_m = [-0.001, 0.0, -0.04];
        let about_center = water_channel::Viewer::new(&sensing, center_m).unwrap();
        let rows = truth.rows_gb();
        let shift = std::array::from_fn(|i| (0..3).map(|j| rows[i][j] * center_m[j]).sum());
        let center = beside(&truth, shift, [0.0; 3]);
        let (a, b) = (
            viewer(&sensing).look(&truth, &mut PixelNoise::new(1)),
            about_center.look(&center, &mut PixelNoise::new(1)),
        );
        for (a, b) in a.sightings().iter().zip(b.sightings()) {
            prop_assert!((a.pixel[0] - b.pixel[0]).abs() + (a.pixel[1] - b.pixel[1]).abs() < 1e-9);
        }
        prop_assert!(distance(&about_center.locate(&b, &center).unwrap(), &center) < 1e-9);
    }
}

/// Where the first steps go astray, damped ones find the way.
#[test]
fn pose_is_found_from_almost_upside_down() {
    let viewer = viewer(&perfect());
    let view = viewer.look(&MIDDLE, &mut PixelNoise::new(1));
    for angle_rad in [-3.0, -2.6, -2.0, 2.0, 2.4, 2.6, 3.0] {
        for axis in 0..3 {
            let mut turn = [0.0; 3];
            turn[axis] = angle_rad;
            let found = viewer.locate(&view, &beside(&MIDDLE, [0.0; 3], turn)).unwrap();
            assert!(distance(&found, &MIDDLE) < 1e-9, "axis {axis}, {angle_rad} rad: {found:?}");
        }
    }
}

/// Signs by hand: what each camera shows when the body moves upstream, to starboard, and up.
#[test]
fn pixels_move_as_the_cameras_stand() {
    let mut sensing = cameras();
    sensing.pixel_noise_px = 0.0;
    let viewer = viewer(&sensing);
    let level = Pose { roll_rad: 0.0, pitch_rad: 0.0, heading_rad: 0.0, ..MIDDLE };
    let pixel = |pose: &Pose, dot: usize, camera: usize| {
        let view = viewer.look(pose, &mut PixelNoise::new(1));
        view.sightings().iter().find(|s| s.dot == dot && s.camera == camera).unwrap().pixel
    };
    let [side, below] = [0, 2];
    let moved = |dot, camera, shift| {
        let (a, b) = (pixel(&level, dot, camera), pixel(&beside(&level, shift, [0.0; 3]), dot, camera));
        [b[0] - a[0], b[1] - a[1]]
    };
    // The camera at starboard looks to port: upstream is on its right. A dot on starboard is 0.87 m away.
    let upstream = moved(0, side, [0.01, 0.0, 0.0]);
    assert!((upstream[0] - 9.2).abs() < 0.2 && upstream[1].abs() < 1e-9, "{upstream:?}");
    let up = moved(0, side, [0.0, 0.0, -0.01]);
    assert!(up[0].abs() < 1e-9 && (up[1] + 9.2).abs() < 0.2, "{up:?}");
    // The camera below looks up, the top of its image towards port: upstream is on its left, starboard is below.
    let upstream = moved(4, below, [0.01, 0.0, 0.0]);
    assert!(upstream[0] < -9.0 && upstream[1].abs() < 1e-9, "{upstream:?}");
    let starboard = moved(4, below, [0.0, 0.01, 0.0]);
    assert!(starboard[0].abs() < 1e-9 && starboard[1].abs() > 9.0, "{starboard:?}");
}
