//! Equation (4) solved for what is unknown: the accelerations of the free coordinates and the forces of the lines.

use crate::coordinates::{Coordinates, check_coordinates};
use crate::disturbance::Disturbance;
use crate::error::Error;
use crate::flow::Flow;
use crate::kinematics::{Driven, Pose, Rates};
use crate::plant::Plant;
use crate::real::Real;
use crate::rows::Instant;
use crate::tensions::{Tensions, tensions};
use crate::vector::{Vector, Wrench, project};

/// Unknown accelerations and what follows from them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Motion<T> {
    /// Accelerations of Phi, Theta, Psi.
    pub(crate) free: [T; 3],
    /// Generalized forces f that the lines supply on L_t, theta', phi'.
    pub(crate) supplied: [T; 3],
}

/// The free rows of (4) for their accelerations, then the driven rows for the forces of the lines.
#[inline(always)]
pub(crate) fn solve_motion<T: Real, const LOPSIDED: bool, const MOVING: bool>(
    plant: &Plant<T>,
    pose: &Pose<T>,
    rates: &Rates<T>,
    driven: &Driven<T>,
    flow_speed: T,
    disturbance: &Disturbance<T>,
) -> Motion<T> {
    let at = Instant::<T, LOPSIDED, MOVING>::new(plant, pose, rates, driven, flow_speed, disturbance);
    let a0_b = at.joint_acceleration();
    let alpha0_b = at.angular_acceleration();
    let f_n_b = at.wrench_f_n(a0_b, alpha0_b);
    let f_n_t = Wrench { force: project(&pose.axes, f_n_b.force), moment: project(&pose.axes, f_n_b.moment) };

    let units = at.unit_motions();
    let x = solve(at.free_matrix(&units), at.free_rows(&f_n_t));
    Motion { free: at.free_accelerations(x), supplied: at.line_forces(f_n_t.force[2], f_n_b.moment, &units, x) }
}

/// Solves the symmetric positive definite system `m x = b` by an unrolled L D Lᵀ.
#[inline(always)]
fn solve<T: Real>(m: [[T; 3]; 3], b: Vector<T>) -> Vector<T> {
    let per_d0 = T::constant(1.0) / m[0][0];
    let (l10, l20) = (m[1][0] * per_d0, m[2][0] * per_d0);
    let per_d1 = T::constant(1.0) / (m[1][1] - l10 * m[1][0]);
    let m21 = m[2][1] - l20 * m[1][0];
    let l21 = m21 * per_d1;
    let per_d2 = T::constant(1.0) / (m[2][2] - l20 * m[2][0] - l21 * m21);
    let y1 = b[1] - l10 * b[0];
    let y2 = b[2] - l20 * b[0] - l21 * y1;
    let x2 = y2 * per_d2;
    let x1 = y1 * per_d1 - l21 * x2;
    [b[0] * per_d0 - l10 * x1 - l20 * x2, x1, x2]
}

/// What the equation of motion says at one configuration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accelerations {
    /// Accelerations of Phi, Theta, Psi in rad/s².
    pub free_rad_s2: [f64; 3],
    /// Generalized forces that the lines supply on L_t (N), theta' and phi' (N·m).
    pub supplied: [f64; 3],
    /// Tensions of the lines. They mean something where lines can give the induced angles, within a quarter turn
    /// (a [`FlightState`](crate::FlightState), which holds the lines themselves, is always there); the rest holds at any angle.
    pub tensions: Tensions,
}

/// Accelerations of the free coordinates when the driven ones follow their winches, and the line tensions.
///
/// `q` are the coordinates, `q_rate` their rates, `driven` the accelerations of `[L_t, theta', phi']` in m/s²
/// and rad/s². The rows of Phi, Theta and Psi give the accelerations, the other three the forces.
///
/// Source: (4).
///
/// # Errors
/// [`Error::State`] for a non-finite entry, a length of zero or less, or a zenith angle at which the azimuth
/// and the twist coincide; [`Error::Argument`] for a flow or driven accelerations that are not finite.
pub fn accelerations(
    plant: &Plant,
    q: &Coordinates,
    q_rate: &Coordinates,
    driven: [f64; 3],
    flow: &Flow,
) -> Result<Accelerations, Error> {
    flow.validate()?;
    check_coordinates(q, q_rate)?;
    if let Some(&value) = driven.iter().find(|acceleration| !acceleration.is_finite()) {
        return Err(Error::Argument { name: "acceleration of a driven coordinate", value, expected: "finite" });
    }
    let pose = Pose::of_coordinates(q, flow);
    let rates = Rates::of_array(q_rate);
    let driven = Driven { length: driven[0], pitch: driven[1], roll: driven[2] };
    let motion = if plant.lopsided {
        solve_motion::<_, true, false>(plant, &pose, &rates, &driven, flow.speed_m_s, &Disturbance::none())
    } else {
        solve_motion::<_, false, false>(plant, &pose, &rates, &driven, flow.speed_m_s, &Disturbance::none())
    };
    Ok(Accelerations {
        free_rad_s2: motion.free,
        supplied: motion.supplied,
        tensions: tensions(plant, &pose, motion.supplied),
    })
}
