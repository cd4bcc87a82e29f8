//! Drag of the straight tether.

use crate::kinematics::{Pose, Rates};
use crate::plant::Plant;
use crate::real::Real;
use crate::vector::Vector;

/// Three-point Gauss–Legendre on (0, 1): abscissas and weights.
const GAUSS: [(f64, f64); 3] = [
    (0.112_701_665_379_258_3, 0.277_777_777_777_777_8),
    (0.5, 0.444_444_444_444_444_4),
    (0.887_298_334_620_741_7, 0.277_777_777_777_777_8),
];

/// Drag of the straight tether: generalized forces on the zenith angle and, divided by sin Phi, on the azimuth.
///
/// `flow` is the flow's velocity along T. Only its part across the tether acts, so the length is not driven.
#[inline(always)]
pub(crate) fn tether_drag<T: Real>(plant: &Plant<T>, pose: &Pose<T>, rates: &Rates<T>, flow: Vector<T>) -> [T; 2] {
    let swing = [-rates.zenith, -(rates.azimuth * pose.sin_zenith)];
    let mut sum = [T::constant(0.0); 2];
    for (share, weight) in GAUSS {
        let s = T::constant(share) * pose.length;
        let across = [flow[0] - s * swing[0], flow[1] - s * swing[1]];
        let speed = (across[0] * across[0] + across[1] * across[1]).sqrt();
        let factor = T::constant(weight * share) * speed;
        sum = [sum[0] + factor * across[0], sum[1] + factor * across[1]];
    }
    // ∫ ½ rho n d C |w| w s ds; the virtual displacements of s·e along x_T and y_T are −s.
    let scale = -(plant.tether_drag * pose.length * pose.length);
    [scale * sum[0], scale * sum[1]]
}
