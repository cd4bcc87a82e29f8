//! Dots out of sight: the region of interest, the hull, too few, and the spike that follows.

use water_channel::{Camera, Dot, Hold, PixelNoise, Pose, Region, Sensing, Tracker, View, Viewer};

use super::{MIDDLE, cameras, distance, perfect, viewer};

fn look(viewer: &Viewer, pose: &Pose) -> View {
    viewer.look(pose, &mut PixelNoise::new(1))
}

/// The camera below and the four dots under the hull alone, the region of interest narrowed to `half_height_px` about the middle.
fn from_below(half_height_px: f64) -> Sensing {
    let mut sensing = perfect();
    let mut below: Camera = sensing.cameras.pop().unwrap();
    below.region = Region {
        top_px: 0.5 * below.height_px - half_height_px,
        bottom_px: 0.5 * below.height_px + half_height_px,
        ..below.region
    };
    sensing.cameras = vec![below];
    sensing.dots = sensing.dots[4..8].to_vec();
    sensing
}

fn headed(heading_rad: f64) -> Pose {
    Pose { position_m: [-0.15, 0.0, -0.56], roll_rad: 0.0, pitch_rad: 0.2, heading_rad }
}

/// As in Figure 26 the heading turns until a pair of dots leaves the view, and comes back.
#[test]
fn heading_is_held_while_a_pair_of_dots_is_out_of_view_and_regained_after() {
    let sensing = from_below(28.0);
    let viewer = viewer(&sensing);
    let mut tracker = Tracker::new(&viewer);
    let swing = |k: usize| headed(0.8 * (std::f64::consts::PI * k as f64 / 400.0).sin());
    let (mut held, mut fewest, mut last, mut largest) = (0, 4, headed(0.0), 0.0f64);
    for k in 0..=400 {
        let (truth, reported) = (swing(k), tracker.observe(&swing(k)));
        let error = (reported.pose.heading_rad - truth.heading_rad).abs();
        largest = largest.max(error);
        match reported.hold {
            None => {
                assert_eq!(reported.dots_seen, 4, "sample {k}");
                assert!(distance(&reported.pose, &truth) < 1e-9, "sample {k}: {reported:?}");
                last = reported.pose;
            }
            Some(hold) => {
                assert_eq!(hold, Hold::TooFewDots);
                fewest = fewest.min(reported.dots_seen);
                assert_eq!(reported.pose, last, "held at sample {k}");
                held += 1;
            }
        }
    }
    assert_eq!(fewest, 2, "a pair is out of view at the widest heading");
    assert!((100..300).contains(&held), "{held} samples held");
    assert!(largest > 0.1, "the heading reported is off by {largest} rad before the dots come back");
    assert!(distance(&tracker.observe(&swing(0)).pose, &swing(0)) < 1e-9, "regained");
}

/// With more cameras the loss of a pair costs accuracy instead.
#[test]
fn loss_of_a_pair_makes_the_heading_uncertain() {
    let all = cameras();
    let mut fewer = all.clone();
    fewer.cameras[2].region.left_px = 300.0;
    fewer.cameras[2].region.right_px = 330.0;
    let deviation = |sensing: &Sensing| {
        let viewer = viewer(sensing);
        viewer.covariance(&look(&viewer, &headed(0.0)), &headed(0.0), 0.1).unwrap()[(5, 5)].sqrt()
    };
    let (seen, lost) = (deviation(&all), deviation(&fewer));
    assert!(lost > 1.1 * seen && lost < 100.0 * seen, "{seen} rad with all dots, {lost} rad with fewer");
}

#[test]
fn camera_that_sees_no_dot_is_no_error() {
    let mut sensing = perfect();
    sensing.cameras[2].pose.pitch_rad = -sensing.cameras[2].pose.pitch_rad;
    let viewer = viewer(&sensing);
    let view = look(&viewer, &MIDDLE);
    assert_eq!(view.seen_by(2), 0, "it looks at the floor");
    assert!(view.seen_by(0) > 0 && view.seen_by(1) > 0, "{view:?}");
    let reported = Tracker::new(&viewer).observe(&MIDDLE);
    assert_eq!((reported.cameras_seeing, reported.hold), (2, None));
    assert!(distance(&reported.pose, &MIDDLE) < 1e-9, "two cameras are enough");
}

#[test]
fn dots_that_face_away_are_hidden_by_the_hull() {
    let viewer = viewer(&perfect());
    // Abreast of the camera.
    let level = Pose { position_m: [-0.15, 0.0, -0.56], ..Pose::default() };
    let side = |pose: &Pose| {
        let view = look(&viewer, pose);
        view.sightings().iter().filter(|seen| seen.camera == 0).map(|seen| seen.dot).collect::<Vec<_>>()
    };
    // On starboard: dots 0 to 3. Under the hull and turned 25 degrees to starboard: 6 and 7. Aft: none, edge on.
    assert_eq!(side(&level), [0, 1, 2, 3, 6, 7]);
    // Nose to starboard, the camera sees no aft edge; nose to port, it does.
    let turned = |heading_rad| Pose { heading_rad, ..level };
    assert!(!side(&turned(0.3)).contains(&8), "{:?}", side(&turned(0.3)));
    assert!(side(&turned(-0.3)).contains(&8), "{:?}", side(&turned(-0.3)));
    // On its back the body shows its port side, where there are no dots, and the half of its underside towards port.
    let back = Pose { roll_rad: std::f64::consts::PI, ..level };
    assert_eq!(side(&back), [4, 5]);
}

#[test]
fn edges_of_the_region_of_interest_belong_to_it() {
    let region = Region { left_px: 10.0, right_px: 20.0, top_px: 30.0, bottom_px: 40.0 };
    for (pixel, inside) in [
        ([10.0, 30.0], true),
        ([20.0, 40.0], true),
        ([9.999, 35.0], false),
        ([15.0, 40.001], false),
        ([f64::NAN, 35.0], false),
    ] {
        assert_eq!(region.contains(pixel), inside, "{pixel:?}");
    }
}

#[test]
fn three_dots_or_fewer_leave_no_pose() {
    let viewer = viewer(&perfect());
    let all = look(&viewer, &MIDDLE);
    for n in 0..=4 {
        let some = View::new(all.sightings().iter().filter(|seen| seen.dot < n).copied().collect());
        assert_eq!(some.dots_seen(), n);
        let found = viewer.locate(&some, &MIDDLE);
        assert_eq!(found.err(), (n < 4).then_some(Hold::TooFewDots), "{n} dots");
    }
}

#[test]
fn dots_on_a_line_leave_the_pose_open() {
    let mut sensing = perfect();
    let on_a_line = |k: usize| Dot { position_m: [0.01 * k as f64, 0.045, -0.04], normal: [0.0, 1.0, 0.0] };
    sensing.dots = (0..5).map(on_a_line).collect();
    let viewer = viewer(&sensing);
    let view = look(&viewer, &MIDDLE);
    assert!(view.dots_seen() >= 4, "{view:?}");
    assert_eq!(viewer.locate(&view, &MIDDLE), Err(Hold::Singular), "the turn about the line is open");
    assert_eq!(viewer.covariance(&view, &MIDDLE, 0.1), None);
}

#[test]
fn pose_that_is_no_number_is_held() {
    let viewer = viewer(&perfect());
    let mut tracker = Tracker::new(&viewer);
    tracker.observe(&MIDDLE);
    for bad in [f64::NAN, f64::INFINITY, 1e300] {
        let reported = tracker.observe(&Pose { position_m: [bad; 3], ..MIDDLE });
        assert_eq!((reported.dots_seen, reported.hold), (0, Some(Hold::TooFewDots)), "{bad}");
        assert!(distance(&reported.pose, &MIDDLE) < 1e-9, "{reported:?}");
    }
    let nowhere = Pose { position_m: [f64::NAN; 3], ..MIDDLE };
    assert_eq!(viewer.locate(&look(&viewer, &MIDDLE), &nowhere), Err(Hold::NotConverged));
    let behind = Pose { position_m: [0.0, 5.0, 0.0], ..MIDDLE };
    assert_eq!(viewer.locate(&look(&viewer, &MIDDLE), &behind), Err(Hold::NotConverged), "dots behind the camera");
}

#[test]
fn sightings_of_unknown_dots_are_not_fitted() {
    let viewer = viewer(&perfect());
    let mut sightings = look(&viewer, &MIDDLE).sightings().to_vec();
    sightings[0].camera = 3;
    assert_eq!(viewer.locate(&View::new(sightings), &MIDDLE), Err(Hold::NotConverged));
}
