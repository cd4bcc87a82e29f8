//! What the water does beside its mean flow: gusts, and a force that the wake exerts on the hull.

use crate::real::Real;

/// Water that moves beside its mean flow, at one instant, uniform over the body and the tether.
///
/// Both vectors lie along the axes of G turned to the flow: against the flow, to the right of someone who looks upstream, down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disturbance<T = f64> {
    /// Added to the velocity of the flow, in m/s: a gust along the flow has a negative first entry.
    pub velocity_m_s: [T; 3],
    /// A force at the center of buoyancy over `½ rho A_ref` of the hull: a coefficient times a squared speed, in m²/s².
    pub wake_m2_s2: [T; 3],
}

impl<T: Real> Disturbance<T> {
    /// No disturbance.
    #[must_use]
    #[inline(always)]
    pub fn none() -> Self {
        Self { velocity_m_s: [T::constant(0.0); 3], wake_m2_s2: [T::constant(0.0); 3] }
    }
}
