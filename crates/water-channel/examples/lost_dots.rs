//! A pair of dots leaves the view of the camera below: the heading that is reported stands still, and jumps when they are back.
//!
//! An argument names a CSV file for the samples; Figure 26 of the dissertation shows such spikes.
#![expect(clippy::print_stdout, reason = "an example talks")]

use std::error::Error;
use std::f64::consts::PI;
use std::path::Path;

use water_channel::{Pose, SensingFile, Tracker, Viewer};

fn main() -> Result<(), Box<dyn Error>> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/bat/sensing.toml");
    let mut sensing = SensingFile::read(file)?.sensing;
    // The camera below alone, with the four dots under the hull and a narrow region of interest.
    sensing.cameras.retain(|camera| camera.name == "below");
    sensing.dots = sensing.dots[4..8].to_vec();
    sensing.cameras[0].region.top_px = 212.0;
    sensing.cameras[0].region.bottom_px = 268.0;
    let viewer = Viewer::new(&sensing, [0.0; 3])?;
    let mut tracker = Tracker::new(&viewer);

    let mut csv = String::from("time [s],heading [rad],estimated_heading [rad],dots_seen [1],hold [1]\n");
    let (mut held, mut largest, mut largest_seen) = (0, 0.0_f64, 0.0_f64);
    for sample in 0..=1200 {
        // Thirty seconds of a heading that swings ever wider, to 40 degrees.
        let time_s = 0.025 * f64::from(sample);
        let heading_rad = 40.0_f64.to_radians() * time_s / 30.0 * (2.0 * PI * time_s / 6.0).sin();
        let truth = Pose { position_m: [-0.15, 0.0, -0.56], roll_rad: 0.0, pitch_rad: 0.2, heading_rad };
        let reported = tracker.observe(&truth);
        let error_rad = (reported.pose.heading_rad - heading_rad).abs();
        match reported.hold {
            None => largest_seen = largest_seen.max(error_rad),
            Some(_) => (held, largest) = (held + 1, largest.max(error_rad)),
        }
        let code = reported.hold.map_or(0, water_channel::Hold::code);
        let (estimated, dots) = (reported.pose.heading_rad, reported.dots_seen);
        csv += &format!("{time_s},{heading_rad},{estimated},{dots},{code}\n");
    }
    println!("{held} of 1201 samples are held for want of dots");
    println!(
        "largest error of the heading: {:.1} deg while dots are seen, most of it the delay",
        largest_seen.to_degrees()
    );
    println!("                              {:.1} deg while it is held", largest.to_degrees());
    if let Some(path) = std::env::args().nth(1) {
        std::fs::write(&path, csv)?;
        println!("samples written to {path}");
    }
    Ok(())
}
