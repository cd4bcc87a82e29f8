//! The ground that a tether sweeps.

/// Area of land that a tether of length `length_m` at zenith angle `zenith_rad` sweeps through all azimuths,
/// `A = pi L_t² sin² Phi`, in m². Source: Section 3.1.
#[must_use]
pub fn footprint_m2(length_m: f64, zenith_rad: f64) -> f64 {
    let radius = length_m * zenith_rad.sin();
    core::f64::consts::PI * radius * radius
}
