//! Vortices that leave the hull in turn, and the force that each leaves on it.

use crate::error::Error;

/// A force across the flow at the Strouhal frequency `St V / D` of the instantaneous speed V.
///
/// The force is `½ rho A_ref V² C sin(phase)`, A_ref the reference area of the hull, at the center of buoyancy; the phase grows by
/// `2 pi St/D ∫V dt` from a start that the seed draws. V is the speed of the water along the mean flow, gusts included; the motion
/// of the body does not enter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shedding {
    /// St, zero or more. About 0.2 for cylinders, 0.13 to 0.2 for spheres and discs.
    pub strouhal: f64,
    /// D, the width that sheds, in m; more than zero.
    pub width_m: f64,
    /// C, the amplitude of the force coefficient, zero or more.
    pub lift_coefficient: f64,
    /// The plane in which the force swings, in rad: 0 to the side, a quarter turn up and down.
    pub plane_rad: f64,
}

impl Shedding {
    /// # Errors
    /// [`Error::Argument`] for a number that is not finite or out of range.
    pub fn validate(&self) -> Result<(), Error> {
        let not_negative = |value: f64| value.is_finite() && value >= 0.0;
        let bad = |name, value, expected| Err(Error::Argument { name, value, expected });
        if !not_negative(self.strouhal) {
            return bad("Strouhal number of the shedding", self.strouhal, "finite and zero or more");
        }
        if !(self.width_m.is_finite() && self.width_m > 0.0) {
            return bad("width that sheds in m", self.width_m, "finite and more than zero");
        }
        if !not_negative(self.lift_coefficient) {
            return bad("lift coefficient of the shedding", self.lift_coefficient, "finite and zero or more");
        }
        if !self.plane_rad.is_finite() {
            return bad("plane of the shedding in rad", self.plane_rad, "finite");
        }
        Ok(())
    }

    /// Whether there is no force at all.
    #[must_use]
    pub fn is_still(&self) -> bool {
        self.lift_coefficient <= 0.0
    }
}
