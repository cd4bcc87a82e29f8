//! The suspension of the tutorial, whose command drives the same car.

use std::sync::OnceLock;

pub(super) use quarter_car::Car;
use quarter_car::{Design, Drive, Error, Track, Vehicle, road};

use crate::costs::Cost;

/// Name, unit and bounds of each parameter: those of the example.
pub(super) const RANGES: [(&str, &str, f64, f64); 4] = [
    ("spring", "N/m", Design::LOWEST.spring_n_m, Design::HIGHEST.spring_n_m),
    ("damper", "N s/m", Design::LOWEST.damper_n_s_m, Design::HIGHEST.damper_n_s_m),
    ("skyhook", "N s/m", Design::LOWEST.skyhook_n_s_m, Design::HIGHEST.skyhook_n_s_m),
    ("tire gain", "N/m", Design::LOWEST.tire_gain_n_m, Design::HIGHEST.tire_gain_n_m),
];

/// All drive over the same.
fn track() -> &'static Result<Track, Error> {
    static TRACK: OnceLock<Result<Track, Error>> = OnceLock::new();
    TRACK.get_or_init(|| Track::new(&road(), &Drive::STANDARD))
}

pub(super) fn cost(car: Car, point: &[f64]) -> Cost {
    let design =
        Design { spring_n_m: point[0], damper_n_s_m: point[1], skyhook_n_s_m: point[2], tire_gain_n_m: point[3] };
    let track = track().as_ref().map_err(ToString::to_string)?;
    let ride = Vehicle { car, design }.drive_over(track, |_| {});
    ride.map(|ride| ride.cost_m_s2()).map_err(|error| error.to_string())
}
