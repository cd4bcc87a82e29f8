//! Cameras: projection, poses and their errors, dots out of sight, delay, the closed loop, and what is refused.

use water_channel::{FlightRequest, Pose, Sensing, SensingFile, Viewer};

use crate::rigs::fixture;

mod closed_loop;
mod errors;
mod golden;
mod loss;
mod poses;
mod refused;

/// The cameras and dots of the fixtures.
fn cameras() -> Sensing {
    SensingFile::read(fixture("bat/sensing.toml")).unwrap().sensing
}

/// The same without noise and without delay.
fn perfect() -> Sensing {
    Sensing { pixel_noise_px: 0.0, delay_samples: 0, ..cameras() }
}

/// For poses of the bridle joint, from which dots are given.
fn viewer(sensing: &Sensing) -> Viewer {
    Viewer::new(sensing, [0.0; 3]).unwrap()
}

/// About the middle of the flights of the 300 s test.
const MIDDLE: Pose = Pose { position_m: [-0.08, -0.01, -0.56], roll_rad: -0.05, pitch_rad: 0.3, heading_rad: 0.04 };

/// A request with cameras.
fn with(mut request: FlightRequest, sensing: Sensing) -> FlightRequest {
    request.rig.sensing = Some(sensing);
    request
}

/// Largest difference of the six numbers of two poses.
fn distance(a: &Pose, b: &Pose) -> f64 {
    a.numbers().iter().zip(b.numbers()).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
}
