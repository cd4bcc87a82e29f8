//! A response with a ripple along what is built, of which the simulation knows nothing.

use anyhow::Result;
use design_space::{Parameter, Region};

/// Settings of each parameter, a whole number of units.
const LEVELS: u32 = 13;

/// Two that are built, and one that is typed.
pub(super) fn region() -> Result<Region> {
    let parameters = ["first part", "second part", "set point"]
        .map(|name| Parameter::continuous(name, "mm", 0.0, f64::from(LEVELS - 1))?.with_levels(LEVELS));
    Ok(Region::new(parameters.into_iter().collect::<Result<_, _>>()?)?)
}

/// A bowl whose best set point follows the first part, and the ripple: three waves along the first part, two along the second.
pub(super) fn truth(point: &[f64]) -> f64 {
    let [a, b, k] = [point[0] - 5.0, point[1] - 8.0, point[2] - 6.0];
    let bowl = (a * a + b * b + (k - 0.5 * a) * (k - 0.5 * a)) / 100.0;
    bowl + 0.25 * (1.3 * point[0] + point[1]).sin()
}

/// The bowl elsewhere, without the ripple.
pub(super) fn simulation(point: &[f64]) -> f64 {
    let [a, b, k] = [point[0] - 7.0, point[1] - 7.0, point[2] - 6.0];
    (a * a + b * b + k * k) / 100.0
}
