//! The suspension of the tutorial: the same program that the shell calls.

pub(super) use quarter_car::Car;
use quarter_car::{Design, Drive, Vehicle, road};

use crate::costs::Cost;

/// Name, unit and bounds of each parameter: those of the example.
pub(super) const RANGES: [(&str, &str, f64, f64); 4] = [
    ("spring", "N/m", 8e3, 30e3),
    ("damper", "N s/m", 300.0, 2500.0),
    ("skyhook", "N s/m", 0.0, 4000.0),
    ("tire gain", "N/m", 0.0, 60e3),
];

pub(super) fn cost(car: Car, point: &[f64]) -> Cost {
    let design =
        Design { spring_n_m: point[0], damper_n_s_m: point[1], skyhook_n_s_m: point[2], tire_gain_n_m: point[3] };
    let ride = Vehicle { car, design }.drive(&road(), &Drive::STANDARD, |_| {});
    ride.map(|ride| ride.cost_m_s2()).map_err(|error| error.to_string())
}
