//! Forces of the fluid on the body: the sum (56), (57) of hull and stabilizers, each in its own local flow.

use crate::plant::Plant;
use crate::real::Real;
use crate::stall::effective_attack;
use crate::vector::{Vector, Wrench, add, cross, cross_point};

/// Stands for sqrt(u² + w²) = 0 in a flow exactly from the side, where lift and side force have no direction and
/// vanish; not so small that a quotient by it overflows.
const SMALLEST_IN_PLANE_M_S: f64 = 1e-100;

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
        Self::of(add(relative, cross_point(omega, x, z)))
    }

    /// Of the velocity of the point relative to the flow.
    #[inline(always)]
    fn of([u, v, w]: Vector<T>) -> Self {
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

/// The horizontal stabilizer as one surface in the plane of symmetry.
#[inline(always)]
fn horizontal_stabilizer<T: Real>(plant: &Plant<T>, relative: Vector<T>, omega: Vector<T>) -> Wrench<T> {
    let flow = LocalFlow::at(relative, omega, plant.fin_h_x, plant.fin_h_z);
    let attack = flow.attack() + plant.fin_h_incidence;
    let lift = plant.fin_h_cl0 + plant.fin_h_cla * effective_attack(attack, plant.fin_h_stall);
    let drag = plant.fin_h_cd0 + plant.fin_h_k * lift * lift;
    Wrench::at(plant.fin_h_x, plant.fin_h_z, flow.force(plant.fin_h_q, drag, lift, T::constant(0.0)))
}

/// Half of the horizontal stabilizer, `side` 1 to starboard and −1 to port: half of the area, with its own place, flow,
/// incidence and lift slope.
#[inline(always)]
fn half_stabilizer<T: Real>(plant: &Plant<T>, relative: Vector<T>, omega: Vector<T>, side: f64) -> Wrench<T> {
    let side = T::constant(side);
    let center = [plant.fin_h_x, side * plant.fin_h_y, plant.fin_h_z];
    let flow = LocalFlow::of(add(relative, cross(omega, center)));
    let attack = flow.attack() + (plant.fin_h_incidence + side * plant.fin_h_half_incidence);
    let slope = plant.fin_h_cla + side * plant.fin_h_half_cla;
    let lift = plant.fin_h_cl0 + slope * effective_attack(attack, plant.fin_h_stall);
    let drag = plant.fin_h_cd0 + plant.fin_h_k * lift * lift;
    let force = flow.force(T::constant(0.5) * plant.fin_h_q, drag, lift, T::constant(0.0));
    Wrench { force, moment: cross(center, force) }
}

/// The sum of [`aerodynamic_wrench`]: hull, horizontal and vertical stabilizer, each in its own local flow.
///
/// `relative` is the joint's velocity relative to the flow and `omega` the angular velocity, along B. The horizontal
/// stabilizer is one surface, and two halves where `LOPSIDED`.
#[inline(always)]
pub(crate) fn aerodynamics<T: Real, const LOPSIDED: bool>(
    plant: &Plant<T>,
    relative: Vector<T>,
    omega: Vector<T>,
) -> Wrench<T> {
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

    let horizontal = if LOPSIDED {
        half_stabilizer(plant, relative, omega, 1.0).plus(half_stabilizer(plant, relative, omega, -1.0))
    } else {
        horizontal_stabilizer(plant, relative, omega)
    };

    let flow = LocalFlow::at(relative, omega, plant.fin_v_x, plant.fin_v_z);
    let side = plant.fin_v_csb * flow.side_slip();
    let drag = plant.fin_v_cd0 + plant.fin_v_k * side * side;
    let vertical = Wrench::at(plant.fin_v_x, plant.fin_v_z, flow.force(plant.fin_v_q, drag, zero, side));

    hull.plus(horizontal).plus(vertical)
}

/// Aerodynamic force in N and moment about the bridle joint in N·m, along B, for a body that moves relative
/// to the flow with `relative_m_s` at the joint and turns with `omega_rad_s`, both along B.
///
/// Hull and stabilizers act in the flow that their own aerodynamic center meets. Defined, and zero, at rest in still fluid.
///
/// Source: (56), (57).
#[must_use]
pub fn aerodynamic_wrench(plant: &Plant, relative_m_s: [f64; 3], omega_rad_s: [f64; 3]) -> ([f64; 3], [f64; 3]) {
    let wrench = if plant.lopsided {
        aerodynamics::<_, true>(plant, relative_m_s, omega_rad_s)
    } else {
        aerodynamics::<_, false>(plant, relative_m_s, omega_rad_s)
    };
    (wrench.force, wrench.moment)
}
