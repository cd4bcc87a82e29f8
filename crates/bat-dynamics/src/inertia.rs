//! Equation (4) in its own terms: mass matrix D, Christoffel matrix C, gravity g, generalized forces tau, energy.

use nalgebra::{Matrix6, Vector6};
use num_dual::Dual64;

use crate::aerodynamics::aerodynamics;
use crate::coordinates::Coordinates;
use crate::flow::Flow;
use crate::kinematics::{Pose, Rates, height};
use crate::plant::Plant;
use crate::real::Real;
use crate::tether_drag::tether_drag;
use crate::vector::{Vector, add, combine, cross, cross_place, cross_point, dot, point_cross, sub};

/// How the joint moves and the body turns per unit rate of each coordinate, along B.
fn jacobian<T: Real>(pose: &Pose<T>) -> [(Vector<T>, Vector<T>); 6] {
    let zero = T::constant(0.0);
    let (s, c, length) = (pose.sin_zenith, pose.cos_zenith, pose.length);
    let none = [zero; 3];
    let to_body = |v| combine(&pose.axes, v);
    [
        (to_body([-length, zero, zero]), pose.axes[1]),
        (to_body([zero, -(length * s), zero]), to_body([-s, zero, c])),
        (none, pose.axes[2]),
        (to_body([zero, zero, T::constant(-1.0)]), none),
        (none, pose.pitch_axis()),
        (none, [T::constant(1.0), zero, zero]),
    ]
}

fn mass_matrix_of<T: Real>(plant: &Plant<T>, q: &Coordinates<T>) -> [[T; 6]; 6] {
    if plant.lopsided { mass_matrix_with::<_, true>(plant, q) } else { mass_matrix_with::<_, false>(plant, q) }
}

fn mass_matrix_with<T: Real, const LOPSIDED: bool>(plant: &Plant<T>, q: &Coordinates<T>) -> [[T; 6]; 6] {
    let still = Flow { speed_m_s: T::constant(0.0), direction_rad: T::constant(0.0) };
    let pose = Pose::of_coordinates(q, &still);
    let columns = jacobian(&pose).map(|(v, omega)| {
        let at_cm = add(v, cross_place::<_, LOPSIDED>(omega, plant.cm()));
        let at_cb = add(v, cross_point(omega, plant.cb_x, plant.cb_z));
        (at_cm, at_cb, omega)
    });
    let mut d: [[T; 6]; 6] = core::array::from_fn(|i| {
        core::array::from_fn(|j| {
            let ((a_cm, a_cb, a), (b_cm, b_cb, b)) = (columns[i], columns[j]);
            plant.mass * dot(a_cm, b_cm)
                + dot(a_cb, plant.added_mass_times(b_cb))
                + dot(a, plant.inertia_times::<LOPSIDED>(b))
        })
    });
    // ½ lambda L (L'² + L² (Phi'² + sin² Phi Theta'²)/3)
    let line = plant.tether_density * q[3];
    let swing = line * q[3] * q[3] * T::constant(1.0 / 3.0);
    d[0][0] = d[0][0] + swing;
    d[1][1] = d[1][1] + swing * pose.sin_zenith * pose.sin_zenith;
    d[3][3] = d[3][3] + line;
    d
}

/// The mass matrix D(Q) of (4): rows and columns in the order of [`Coordinates`].
///
/// Kinetic energy of the hull, of the straight tether and, where the plant has it, of the added mass in fluid
/// at rest is `½ Q̇ᵀ D Q̇`. Symmetric; positive definite away from Phi = 0.
#[must_use]
pub fn mass_matrix(plant: &Plant, q: &Coordinates) -> Matrix6<f64> {
    let d = mass_matrix_of(plant, q);
    Matrix6::from_fn(|i, j| 0.5 * (d[i][j] + d[j][i]))
}

/// The matrix C(Q, Q̇) of (4) from the Christoffel symbols of D.
///
/// ```text
/// C_ij = Σ_k ½ (∂D_ij/∂q_k + ∂D_ik/∂q_j − ∂D_jk/∂q_i) q̇_k
/// ```
///
/// so that Ḋ − 2 C is skew. The derivatives of D are exact (dual numbers).
#[must_use]
pub fn christoffel_matrix(plant: &Plant, q: &Coordinates, q_rate: &Coordinates) -> Matrix6<f64> {
    let plant = plant.cast::<Dual64>();
    let slopes: [[[f64; 6]; 6]; 6] = core::array::from_fn(|k| {
        let seeded: Coordinates<Dual64> = core::array::from_fn(|i| Dual64::new(q[i], if i == k { 1.0 } else { 0.0 }));
        mass_matrix_of(&plant, &seeded).map(|row| row.map(|entry| entry.eps))
    });
    Matrix6::from_fn(|i, j| {
        (0..6).map(|k| 0.5 * (slopes[k][i][j] + slopes[j][i][k] - slopes[i][j][k]) * q_rate[k]).sum()
    })
}

fn potential_of<T: Real>(plant: &Plant<T>, q: &Coordinates<T>) -> T {
    let still = Flow { speed_m_s: T::constant(0.0), direction_rad: T::constant(0.0) };
    let pose = Pose::of_coordinates(q, &still);
    let (s, c) = (pose.sin_zenith, pose.cos_zenith);
    let down: Vector<T> = core::array::from_fn(|k| c * pose.axes[2][k] - s * pose.axes[0][k]);
    let joint = q[3] * c;
    let at = |point| joint + height(down, point);
    let zero = T::constant(0.0);
    plant.gravity
        * (plant.mass * at(plant.cm()) - plant.displaced_mass * at([plant.cb_x, zero, plant.cb_z])
            + T::constant(0.5) * plant.tether_net_density * q[3] * q[3] * c)
}

/// Potential energy in J: weight and buoyancy of the body, weight less buoyancy of the tether.
#[must_use]
pub fn potential_energy(plant: &Plant, q: &Coordinates) -> f64 {
    potential_of(plant, q)
}

/// Kinetic energy `½ Q̇ᵀ D Q̇` in J.
#[must_use]
pub fn kinetic_energy(plant: &Plant, q: &Coordinates, q_rate: &Coordinates) -> f64 {
    let rate = Vector6::from(*q_rate);
    0.5 * rate.dot(&(mass_matrix(plant, q) * rate))
}

/// The vector g(Q) of (4), the gradient of the potential energy (exact, by dual numbers).
#[must_use]
pub fn gravity_vector(plant: &Plant, q: &Coordinates) -> Vector6<f64> {
    let plant = plant.cast::<Dual64>();
    Vector6::from_fn(|k, _| {
        let seeded: Coordinates<Dual64> = core::array::from_fn(|i| Dual64::new(q[i], if i == k { 1.0 } else { 0.0 }));
        potential_of(&plant, &seeded).eps
    })
}

/// The generalized forces tau(Q, Q̇, V_flow, psi_flow) of (4): aerodynamics, tether drag and, where the plant
/// has added mass, the part of its inertia that is not quadratic in Q̇ (the flow's share, with the Munk moment).
///
/// Units: N·m for the angles, N for L_t. The forces of the lines are not in it.
#[must_use]
pub fn generalized_forces(plant: &Plant, q: &Coordinates, q_rate: &Coordinates, flow: &Flow) -> Vector6<f64> {
    let pose = Pose::of_coordinates(q, flow);
    let rates = Rates::of_array(q_rate);
    let (omega, _) = pose.angular_velocity(&rates);
    let joint = pose.joint_velocity(&rates);
    let flow_t = pose.flow_velocity(flow.speed_m_s);
    let moving = combine(&pose.axes, joint);
    let relative = combine(&pose.axes, sub(joint, flow_t));

    let air = if plant.lopsided {
        aerodynamics::<_, true>(plant, relative, omega)
    } else {
        aerodynamics::<_, false>(plant, relative, omega)
    };
    let (still_force, still_moment) = carried_wrench(plant, moving, omega);
    let (flow_force, flow_moment) = carried_wrench(plant, relative, omega);
    let force = add(air.force, sub(still_force, flow_force));
    let moment = add(air.moment, sub(still_moment, flow_moment));
    let [zenith, azimuth] = tether_drag(plant, &pose, &rates, flow_t);
    let line = [zenith, azimuth * pose.sin_zenith, 0.0, 0.0, 0.0, 0.0];
    let columns = jacobian(&pose);
    Vector6::from_fn(|k, _| dot(columns[k].0, force) + dot(columns[k].1, moment) + line[k])
}

/// The velocity-dependent wrench about the joint that the added mass takes when the joint moves with `velocity`.
fn carried_wrench(plant: &Plant, velocity: Vector<f64>, omega: Vector<f64>) -> (Vector<f64>, Vector<f64>) {
    let through = add(velocity, cross_point(omega, plant.cb_x, plant.cb_z));
    let carried = plant.added_mass_times(through);
    let force = sub(cross(omega, carried), plant.added_mass_times(cross(omega, through)));
    (force, add(point_cross(plant.cb_x, plant.cb_z, force), cross(through, carried)))
}
