//! The rig of the fixtures over the box of Table 4 and one experiment step beyond it.

use bat_dynamics::Fidelity;
use water_channel::{FlightSettings, fly_all};

use crate::rigs::{full_test, request};

/// x_cm in per cent of chord, 45.65 to 51.25 and a step of 1 beyond; pitch in degrees, 0 to 22 and a step of 1 beyond.
const CENTERS: [f64; 5] = [44.65, 46.55, 48.45, 50.35, 52.25];
const PITCHES: [f64; 5] = [-1.0, 5.0, 11.0, 17.0, 23.0];

#[test]
fn every_design_of_the_box_flies_with_taut_lines_and_inside_the_model() {
    for fidelity in [Fidelity::NUMERICAL, Fidelity::STALLED_WITH_ADDED_MASS] {
        let points: Vec<(f64, f64)> = CENTERS.iter().flat_map(|x| PITCHES.map(|pitch| (*x, pitch))).collect();
        let requests: Vec<_> = points.iter().map(|(x, pitch)| request(fidelity, *x, *pitch)).collect();
        let flights = fly_all(&requests, &full_test(), &FlightSettings::with_steps(1), |_| {});
        for (point, flight) in points.iter().zip(flights) {
            let flight = flight.unwrap_or_else(|error| panic!("{fidelity:?} {point:?}: {error}"));
            let extremes = flight.extremes;
            assert!(extremes.smallest_tension_n > 0.1, "{fidelity:?} {point:?}: {extremes:?}");
            assert!(extremes.smallest_zenith_rad > 0.02, "{fidelity:?} {point:?}: {extremes:?}");
            assert!(extremes.peak_heading_rad < 0.6, "{fidelity:?} {point:?}: {extremes:?}");
            assert!(flight.slack.is_none(), "{fidelity:?} {point:?}");
        }
    }
}
