//! Forces of the fluid: the component build-up (56), (57), stall (58), (59), the hull's moments, tether drag.

use crate::kinematics::{Pose, Rates};
use crate::plant::Plant;
use crate::real::Real;
use crate::vector::{Vector, add, cross_point, point_cross};

/// Stands for sqrt(u² + w²) = 0 in a flow exactly from the side, where lift and side force have no direction and
/// vanish; not so small that a quotient by it overflows.
const SMALLEST_IN_PLANE_M_S: f64 = 1e-100;

/// A force and its moment about the bridle joint, along B.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wrench<T> {
    pub(crate) force: Vector<T>,
    pub(crate) moment: Vector<T>,
}

impl<T: Real> Wrench<T> {
    #[inline(always)]
    fn at(x: T, z: T, force: Vector<T>) -> Self {
        Self { force, moment: point_cross(x, z, force) }
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        Self { force: add(self.force, other.force), moment: add(self.moment, other.moment) }
    }
}

/// The flow at one point of the body, along B.
struct LocalFlow<T> {
    u: T,
    v: T,
    w: T,
    /// sqrt(u² + w²).
    in_plane: T,
    /// V.
    speed: T,
}

impl<T: Real> LocalFlow<T> {
    #[inline(always)]
    fn at(relative: Vector<T>, omega: Vector<T>, x: T, z: T) -> Self {
        let [u, v, w] = add(relative, cross_point(omega, x, z));
        let in_plane_squared = u * u + w * w;
        Self { u, v, w, in_plane: in_plane_squared.sqrt(), speed: (in_plane_squared + v * v).sqrt() }
    }

    /// alpha = atan2(w, u).
    #[inline(always)]
    fn attack(&self) -> T {
        self.w.atan2(self.u)
    }

    /// beta = asin(v / V), written so that it is defined at V = 0.
    #[inline(always)]
    fn side_slip(&self) -> T {
        self.v.atan2(self.in_plane)
    }

    /// `q V² (C_D e_D + C_L e_L + C_S e_S)` with q = ½ rho A and the directions
    /// `e_D = −[u, v, w]/V`, `e_L = [w, 0, −u]/sqrt(u² + w²)`, `e_S = [−uv, u² + w², −vw]/(V sqrt(u² + w²))`.
    #[inline(always)]
    fn force(&self, q: T, drag: T, lift: T, side: T) -> Vector<T> {
        let q_speed = q * self.speed;
        let per_plane = q_speed / self.in_plane.max(T::constant(SMALLEST_IN_PLANE_M_S));
        let lift = lift * self.speed * per_plane;
        let side_v = side * self.v * per_plane;
        let back = -(q_speed * drag) - side_v;
        [back * self.u + lift * self.w, q_speed * (side * self.in_plane - drag * self.v), back * self.w - lift * self.u]
    }
}

/// The angle of attack that a linear lift curve must be given to follow (58), (59), with 2 α_stall carrying
/// the sign of α so that the curve is continuous and odd at both stall angles.
#[inline(always)]
fn effective_attack<T: Real>(attack: T, stall: T) -> T {
    let beyond = (T::constant(2.0) * stall).copysign(attack) - attack;
    stall.select_below(attack.abs(), beyond, attack)
}

/// Aerodynamic wrench about the joint: (56), (57), each component in its own local flow.
///
/// `relative` is the joint's velocity relative to the flow and `omega` the angular velocity, along B.
#[inline(always)]
pub(crate) fn aerodynamics<T: Real>(plant: &Plant<T>, relative: Vector<T>, omega: Vector<T>) -> Wrench<T> {
    let zero = T::constant(0.0);

    let flow = LocalFlow::at(relative, omega, plant.hull_x, plant.hull_z);
    let (attack, slip) = (flow.attack(), flow.side_slip());
    let lift = plant.hull_cl0 + plant.hull_cla * effective_attack(attack, plant.hull_stall);
    let side = plant.hull_csb * slip;
    let drag = plant.hull_cd0 + plant.hull_k * (lift * lift + side * side);
    let mut hull = Wrench::at(plant.hull_x, plant.hull_z, flow.force(plant.hull_q, drag, lift, side));
    let pressure = plant.hull_q_chord * flow.speed * flow.speed;
    hull.moment = add(
        hull.moment,
        [
            pressure * plant.hull_clb * slip,
            pressure * (plant.hull_cm0 + plant.hull_cma * attack),
            pressure * plant.hull_cnb * slip,
        ],
    );

    let flow = LocalFlow::at(relative, omega, plant.fin_h_x, plant.fin_h_z);
    let attack = flow.attack() + plant.fin_h_incidence;
    let lift = plant.fin_h_cl0 + plant.fin_h_cla * effective_attack(attack, plant.fin_h_stall);
    let drag = plant.fin_h_cd0 + plant.fin_h_k * lift * lift;
    let horizontal = Wrench::at(plant.fin_h_x, plant.fin_h_z, flow.force(plant.fin_h_q, drag, lift, zero));

    let flow = LocalFlow::at(relative, omega, plant.fin_v_x, plant.fin_v_z);
    let side = plant.fin_v_csb * flow.side_slip();
    let drag = plant.fin_v_cd0 + plant.fin_v_k * side * side;
    let vertical = Wrench::at(plant.fin_v_x, plant.fin_v_z, flow.force(plant.fin_v_q, drag, zero, side));

    hull.plus(horizontal).plus(vertical)
}

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

/// Lift coefficients of hull and horizontal stabilizer at an angle of attack in rad: (58) and (59).
///
/// For angles up to the stall angle this is the linear law, beyond it the law that falls; with a plant of
/// attached lift it is linear throughout. Differs from the source: for negative angles the printed form jumps
/// by 4 C_Lα α_stall at −α_stall; here 2 α_stall carries the sign of α.
#[must_use]
pub fn lift_coefficients(plant: &Plant, attack_rad: f64) -> [f64; 2] {
    [
        plant.hull_cl0 + plant.hull_cla * effective_attack(attack_rad, plant.hull_stall),
        plant.fin_h_cl0 + plant.fin_h_cla * effective_attack(attack_rad, plant.fin_h_stall),
    ]
}

/// Aerodynamic force in N and moment about the bridle joint in N·m, along B, for a body that moves relative
/// to the flow with `relative_m_s` at the joint and turns with `omega_rad_s`, both along B.
///
/// Source: (56), (57), with each component in its own local flow. Defined, and zero, at rest in still fluid.
#[must_use]
pub fn aerodynamic_wrench(plant: &Plant, relative_m_s: [f64; 3], omega_rad_s: [f64; 3]) -> ([f64; 3], [f64; 3]) {
    let wrench = aerodynamics(plant, relative_m_s, omega_rad_s);
    (wrench.force, wrench.moment)
}
