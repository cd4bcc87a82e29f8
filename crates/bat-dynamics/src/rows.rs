//! The rows of equation (4), term by term.
//!
//! They are formed as one wrench about the bridle joint J (Newton–Euler) and projected on the motions that the
//! coordinates allow; the tests hold this against the Lagrangian form, D and C of [`inertia`](crate::inertia), to
//! rounding.
//! A subscript names the frame along which a vector has its components: t the tether frame T, b the body frame B.
//! s and c are sin Phi and cos Phi.
//! An index 0 marks an acceleration that is left when those of the free coordinates are zero.

use crate::aerodynamics::aerodynamics;
use crate::disturbance::Disturbance;
use crate::kinematics::{Driven, Pose, Rates};
use crate::plant::Plant;
use crate::real::Real;
use crate::tether_drag::tether_drag;
use crate::vector::{
    Vector, Wrench, add, combine, cross, cross_place, cross_point, dot, place_cross, point_cross, scale, sub,
};

/// Everything that is known before (4) is solved; what sets starboard apart from port counts only where `LOPSIDED`, a
/// disturbance of the water only where `MOVING`.
pub(crate) struct Instant<'a, T, const LOPSIDED: bool, const MOVING: bool> {
    plant: &'a Plant<T>,
    pose: &'a Pose<T>,
    rates: &'a Rates<T>,
    driven: &'a Driven<T>,
    disturbance: &'a Disturbance<T>,
    v: Velocities<T>,
    rod: Rod<T>,
}

/// How joint, body and flow move at the given rates.
struct Velocities<T> {
    /// `Thetȧ s`.
    azimuth_s: T,
    /// `Thetȧ c`.
    azimuth_c: T,
    /// omega, of B against G.
    omega_b: Vector<T>,
    /// omega_tb, of B against T.
    omega_tb_b: Vector<T>,
    /// v_flow.
    flow_t: Vector<T>,
    /// `[u, v, w] = R_tbᵀ (v_J − v_flow)`, the joint's velocity through the water.
    uvw_b: Vector<T>,
}

impl<T: Real> Velocities<T> {
    #[inline(always)]
    fn of(pose: &Pose<T>, rates: &Rates<T>, flow_t: Vector<T>) -> Self {
        let (omega_b, omega_tb_b) = pose.angular_velocity(rates);
        Self {
            azimuth_s: rates.azimuth * pose.sin_zenith,
            azimuth_c: rates.azimuth * pose.cos_zenith,
            omega_b,
            omega_tb_b,
            flow_t,
            uvw_b: combine(&pose.axes, sub(pose.joint_velocity(rates), flow_t)),
        }
    }
}

/// The straight tether as a rod of mass lambda per length.
struct Rod<T> {
    /// `lambda L_t²`.
    first_moment: T,
    /// `lambda L_t³ / 3`, its moment of inertia about O.
    inertia: T,
    /// `w = (lambda − n rho pi d_t²/4) g L_t`, weight less buoyancy.
    weight: T,
}

impl<T: Real> Rod<T> {
    #[inline(always)]
    fn of(plant: &Plant<T>, pose: &Pose<T>) -> Self {
        let first_moment = plant.tether_density * pose.length * pose.length;
        Self {
            first_moment,
            inertia: first_moment * pose.length * T::constant(1.0 / 3.0),
            weight: plant.tether_net_density * plant.gravity * pose.length,
        }
    }
}

/// A motion of the body, along B, and the wrench about the joint that it takes as an acceleration.
pub(crate) struct UnitMotion<T> {
    /// Of the joint.
    v: Vector<T>,
    /// Of the body about it.
    omega: Vector<T>,
    /// `M (v, omega)`.
    takes: Wrench<T>,
}

impl<'a, T: Real, const LOPSIDED: bool, const MOVING: bool> Instant<'a, T, LOPSIDED, MOVING> {
    #[inline(always)]
    pub(crate) fn new(
        plant: &'a Plant<T>,
        pose: &'a Pose<T>,
        rates: &'a Rates<T>,
        driven: &'a Driven<T>,
        flow_speed: T,
        disturbance: &'a Disturbance<T>,
    ) -> Self {
        let flow_t = if MOVING {
            let [ahead, right, down] = disturbance.velocity_m_s;
            pose.along_tether([ahead - flow_speed, right, down])
        } else {
            pose.flow_velocity(flow_speed)
        };
        let (v, rod) = (Velocities::of(pose, rates, flow_t), Rod::of(plant, pose));
        Self { plant, pose, rates, driven, disturbance, v, rod }
    }

    /// Acceleration a_0 of the joint along B:
    ///
    /// ```text
    /// R_tbᵀ [L_t s c Thetȧ² − 2 L̇_t Phi̇, −2 L̇_t Thetȧ s − 2 L_t Thetȧ c Phi̇, L_t (Phi̇² + Thetȧ² s²) − L̈_t]
    /// ```
    #[inline(always)]
    pub(crate) fn joint_acceleration(&self) -> Vector<T> {
        let Self { pose, rates, driven, v, .. } = self;
        let two = T::constant(2.0);
        combine(
            &pose.axes,
            [
                pose.length * v.azimuth_s * v.azimuth_c - two * rates.length * rates.zenith,
                -(two * rates.length * v.azimuth_s) - two * pose.length * v.azimuth_c * rates.zenith,
                pose.length * self.swing_squared() - driven.length,
            ],
        )
    }

    /// `Phi̇² + Thetȧ² s²`: the squared rate at which the direction of the tether turns.
    #[inline(always)]
    fn swing_squared(&self) -> T {
        self.rates.zenith * self.rates.zenith + self.v.azimuth_s * self.v.azimuth_s
    }

    /// Angular acceleration alpha_0 of the body along B:
    ///
    /// ```text
    /// R_tbᵀ [−Thetȧ c Phi̇, 0, −Thetȧ s Phi̇] − omega_tb × (omega − omega_tb) − omega_tb × Psi̇ z_T + alpha_bridle
    /// ```
    #[inline(always)]
    pub(crate) fn angular_acceleration(&self) -> Vector<T> {
        let Self { pose, rates, v, .. } = self;
        let frame_turns = cross(v.omega_tb_b, sub(v.omega_b, v.omega_tb_b));
        let twist_turns = cross(v.omega_tb_b, scale(rates.twist, pose.axes[2]));
        let frame_t = [-(v.azimuth_c * rates.zenith), T::constant(0.0), -(v.azimuth_s * rates.zenith)];
        let frame_b = combine(&pose.axes, frame_t);
        add(sub(sub(frame_b, frame_turns), twist_turns), self.bridle_acceleration())
    }

    /// Share of theta' and phi' in alpha_0, along B:
    ///
    /// ```text
    /// alpha_bridle = phi'¨ [1, 0, 0] + theta'¨ [0, cos phi', −sin phi'] − theta'˙ phi'˙ [0, sin phi', cos phi']
    /// ```
    #[inline(always)]
    fn bridle_acceleration(&self) -> Vector<T> {
        let Self { pose, rates, driven, .. } = self;
        let pitch_roll = rates.pitch * rates.roll;
        [
            driven.roll,
            driven.pitch * pose.cos_roll - pitch_roll * pose.sin_roll,
            -(driven.pitch * pose.sin_roll) - pitch_roll * pose.cos_roll,
        ]
    }

    /// The wrench about the joint that fluid and gravity supply less what the motion at a_0 and alpha_0 takes, along B:
    ///
    /// ```text
    /// F = F_aero − force of M (a_0, alpha_0) − (F_cm + F_cb)
    /// N = N_aero − moment of M (a_0, alpha_0) − (r_cm × F_cm + r_cb × F_cb + omega × (I + I_a) omega + v_r × M_a v_r)
    /// ```
    ///
    /// with the aerodynamic wrench of (56), (57) and v_r, the velocity of the center of buoyancy through the water.
    /// The last term is the Munk moment.
    #[inline(always)]
    pub(crate) fn wrench_f_n(&self, a0_b: Vector<T>, alpha0_b: Vector<T>) -> Wrench<T> {
        let Self { plant, v, .. } = self;
        let gravity_b = self.gravity();
        let taken = inertial_wrench::<_, LOPSIDED>(plant, a0_b, alpha0_b);
        let force_cm = self.force_at_center_of_mass(gravity_b);
        let v_r_b = add(v.uvw_b, cross_point(v.omega_b, plant.cb_x, plant.cb_z));
        let momentum_b = plant.added_mass_times(v_r_b);
        let force_cb = self.force_at_center_of_buoyancy(momentum_b, gravity_b);
        let spin = cross(v.omega_b, plant.inertia_times::<LOPSIDED>(v.omega_b));
        let munk = cross(v_r_b, momentum_b);
        let arm_cm = place_cross::<_, LOPSIDED>(plant.cm(), force_cm);
        let arms = add(arm_cm, point_cross(plant.cb_x, plant.cb_z, force_cb));
        let aero = aerodynamics::<_, LOPSIDED>(plant, v.uvw_b, v.omega_b);
        Wrench {
            force: sub(aero.force, add(taken.force, add(force_cm, force_cb))),
            moment: sub(aero.moment, add(taken.moment, add(add(arms, spin), munk))),
        }
    }

    /// `g (−s x_T + c z_T)`: gravity, which points down, along B.
    #[inline(always)]
    fn gravity(&self) -> Vector<T> {
        let Pose { axes, sin_zenith, cos_zenith, .. } = *self.pose;
        scale(self.plant.gravity, add(scale(-sin_zenith, axes[0]), scale(cos_zenith, axes[2])))
    }

    /// `F_cm = m (omega × (omega × r_cm) − g)` along B.
    #[inline(always)]
    fn force_at_center_of_mass(&self, gravity_b: Vector<T>) -> Vector<T> {
        let Self { plant, v, .. } = self;
        let centripetal = cross(v.omega_b, cross_place::<_, LOPSIDED>(v.omega_b, plant.cm()));
        scale(plant.mass, sub(centripetal, gravity_b))
    }

    /// `F_cb = omega × M_a v_r − M_a (omega × [u, v, w]) + rho Vol g` along B: buoyancy, and what is left of
    /// `d/dt (M_a v_r)` at a_0 and alpha_0, because `[u, v, w]` and `M_a v_r` turn with B; less the force of the wake.
    #[inline(always)]
    fn force_at_center_of_buoyancy(&self, momentum_b: Vector<T>, gravity_b: Vector<T>) -> Vector<T> {
        let Self { plant, v, .. } = self;
        let turning = sub(cross(v.omega_b, momentum_b), plant.added_mass_times(cross(v.omega_b, v.uvw_b)));
        let carried = add(turning, scale(plant.displaced_mass, gravity_b));
        if MOVING { sub(carried, self.wake()) } else { carried }
    }

    /// The force of the disturbance on the hull, along B.
    #[inline(always)]
    fn wake(&self) -> Vector<T> {
        let force_t = self.pose.along_tether(self.disturbance.wake_m2_s2);
        scale(self.plant.hull_q, combine(&self.pose.axes, force_t))
    }

    /// The motions of unit `Phi¨`, `Theta¨ s` and `Psi¨ + Theta¨ c`: the joint moves along −L_t x_T, −L_t y_T and not at
    /// all, the body turns about y_T, −x_T and z_T.
    #[inline(always)]
    pub(crate) fn unit_motions(&self) -> [UnitMotion<T>; 3] {
        let ([x_t, y_t, z_t], length) = (self.pose.axes, self.pose.length);
        let unit = |v, omega| UnitMotion { v, omega, takes: inertial_wrench::<_, LOPSIDED>(self.plant, v, omega) };
        [
            unit(scale(-length, x_t), y_t),
            unit(scale(-length, y_t), scale(T::constant(-1.0), x_t)),
            unit([T::constant(0.0); 3], z_t),
        ]
    }

    /// The symmetric matrix of the three free rows: `v_i · force_j + omega_i · moment_j`, and the inertia of the rod.
    #[inline(always)]
    pub(crate) fn free_matrix(&self, units: &[UnitMotion<T>; 3]) -> [[T; 3]; 3] {
        let row = |i: usize, j: usize| dot(units[i].omega, units[j].takes.moment);
        let entry = |i: usize, j: usize| dot(units[i].v, units[j].takes.force) + row(i, j);
        let m00 = entry(0, 0) + self.rod.inertia;
        let m11 = entry(1, 1) + self.rod.inertia;
        let (m10, m20, m21, m22) = (entry(0, 1), entry(2, 0), entry(2, 1), row(2, 2));
        [[m00, m10, m20], [m10, m11, m21], [m20, m21, m22]]
    }

    /// Right-hand sides of the rows of Phi, of Theta (less c times that of Psi, over s) and of Psi:
    ///
    /// ```text
    /// N_y − L_t F_x + Q_Phi − lambda L_t² L̇_t Phi̇ + (lambda L_t³/3) Thetȧ² s c + ½ w L_t s
    /// −N_x − L_t F_y + Q_Theta/s − lambda L_t² L̇_t Thetȧ s − 2 (lambda L_t³/3) Thetȧ c Phi̇
    /// N_z
    /// ```
    ///
    /// with F and N along T, and Q, the drag of the tether.
    #[inline(always)]
    pub(crate) fn free_rows(&self, f_n_t: &Wrench<T>) -> Vector<T> {
        let Self { plant, pose, rates, v, rod, .. } = self;
        let ([f_x, f_y, _], [n_x, n_y, n_z]) = (f_n_t.force, f_n_t.moment);
        let [drag_zenith, drag_azimuth] = tether_drag(plant, pose, rates, v.flow_t);
        [
            n_y - pose.length * f_x + drag_zenith - rod.first_moment * rates.length * rates.zenith
                + rod.inertia * v.azimuth_s * v.azimuth_c
                + T::constant(0.5) * rod.weight * pose.length * pose.sin_zenith,
            -n_x - pose.length * f_y + drag_azimuth
                - rod.first_moment * rates.length * v.azimuth_s
                - T::constant(2.0) * rod.inertia * v.azimuth_c * rates.zenith,
            n_z,
        ]
    }

    /// Accelerations of Phi, Theta, Psi from the solution `x = [Phi¨, Theta¨ s, Psi¨ + Theta¨ c]`.
    #[inline(always)]
    pub(crate) fn free_accelerations(&self, x: Vector<T>) -> [T; 3] {
        let azimuth = x[1] / self.pose.sin_zenith;
        [x[0], azimuth, x[2] - azimuth * self.pose.cos_zenith]
    }

    /// The driven rows, `f = D Q¨ + C Q̇ + g − tau` on L_t, theta' and phi':
    ///
    /// ```text
    /// F_z − Σ x_j z_T · force_j + lambda L_t (L̈_t − ½ L_t (Phi̇² + Thetȧ² s²)) + ½ lambda L̇_t² + w c
    /// −[0, cos phi', −sin phi'] · (N − Σ x_j moment_j)
    /// −[1, 0, 0] · (N − Σ x_j moment_j)
    /// ```
    ///
    /// `f_z_t` is F_z along T, `n_b` is N along B.
    #[inline(always)]
    pub(crate) fn line_forces(&self, f_z_t: T, n_b: Vector<T>, units: &[UnitMotion<T>; 3], x: Vector<T>) -> [T; 3] {
        let Self { plant, pose, rates, driven, rod, .. } = self;
        let (mut f_z_t, mut n_b) = (f_z_t, n_b);
        for (x_j, unit) in x.into_iter().zip(units) {
            f_z_t = f_z_t - x_j * dot(pose.axes[2], unit.takes.force);
            n_b = sub(n_b, scale(x_j, unit.takes.moment));
        }
        let (half, lambda) = (T::constant(0.5), plant.tether_density);
        [
            f_z_t
                + lambda * pose.length * (driven.length - half * pose.length * self.swing_squared())
                + half * lambda * rates.length * rates.length
                + rod.weight * pose.cos_zenith,
            -dot(pose.pitch_axis(), n_b),
            -n_b[0],
        ]
    }
}

/// `M (a, alpha)`: the wrench about the joint that an acceleration `a` of the joint and an angular acceleration `alpha`
/// take, all along B: the inertia of the body and its added mass, which are constant there.
#[inline(always)]
fn inertial_wrench<T: Real, const LOPSIDED: bool>(plant: &Plant<T>, a: Vector<T>, alpha: Vector<T>) -> Wrench<T> {
    let in_plane = Wrench {
        force: [
            plant.total_x * a[0] + plant.first_xz * alpha[1],
            plant.total_y * a[1] + plant.first_yx * alpha[2] - plant.first_yz * alpha[0],
            plant.total_z * a[2] - plant.first_zx * alpha[1],
        ],
        moment: [
            plant.joint_x * alpha[0] - plant.joint_xz * alpha[2] - plant.first_yz * a[1],
            plant.joint_y * alpha[1] + plant.first_xz * a[0] - plant.first_zx * a[2],
            plant.joint_z * alpha[2] - plant.joint_xz * alpha[0] + plant.first_yx * a[1],
        ],
    };
    if LOPSIDED { in_plane.plus(lateral_wrench(plant, a, alpha)) } else { in_plane }
}

/// The part of [`inertial_wrench`] that comes of a center of mass beside the plane of symmetry and of the products of inertia
/// out of it.
#[inline(always)]
fn lateral_wrench<T: Real>(plant: &Plant<T>, a: Vector<T>, alpha: Vector<T>) -> Wrench<T> {
    let (first, squared) = (plant.first_y, plant.joint_y_squared);
    Wrench {
        force: [-(first * alpha[2]), T::constant(0.0), first * alpha[0]],
        moment: [
            squared * alpha[0] - plant.joint_xy * alpha[1] + first * a[2],
            -(plant.joint_xy * alpha[0] + plant.joint_yz * alpha[2]),
            squared * alpha[2] - plant.joint_yz * alpha[1] - first * a[0],
        ],
    }
}
