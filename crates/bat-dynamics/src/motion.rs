//! Accelerations of the free coordinates and tensions of the lines: equation (4) solved for what is unknown.
//!
//! The rows of (4) are formed as one wrench about the bridle joint (Newton–Euler) and projected; the tests hold
//! this against the Lagrangian form, D and C of [`inertia`](crate::inertia), to rounding.

use crate::error::Error;
use crate::flow::Flow;
use crate::fluid::{self, Wrench};
use crate::kinematics::{Bridle, Coordinates, Driven, FlightState, Pose, Rates, Sight};
use crate::plant::Plant;
use crate::real::Real;
use crate::vector::{Vector, add, combine, cross, cross_point, dot, point_cross, project, scale, sub};

/// Unknown accelerations and what follows from them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Motion<T> {
    /// Accelerations of Phi, Theta, Psi.
    pub(crate) free: [T; 3],
    /// Generalized forces that the lines supply on L_t, theta', phi'.
    pub(crate) supplied: [T; 3],
}

/// The wrench about the joint that a linear acceleration `a` of the joint and an angular acceleration `alpha` take, both
/// along B: the inertia of the body and its added mass, which are constant there.
#[inline(always)]
fn inertial_wrench<T: Real>(plant: &Plant<T>, a: Vector<T>, alpha: Vector<T>) -> Wrench<T> {
    Wrench {
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
    }
}

#[inline(always)]
pub(crate) fn added<T: Real>(plant: &Plant<T>, v: Vector<T>) -> Vector<T> {
    [plant.added_x * v[0], plant.added_y * v[1], plant.added_z * v[2]]
}

#[inline(always)]
pub(crate) fn inertia_times<T: Real>(plant: &Plant<T>, w: Vector<T>) -> Vector<T> {
    [
        plant.inertia_x * w[0] - plant.inertia_xz * w[2],
        plant.inertia_y * w[1],
        plant.inertia_z * w[2] - plant.inertia_xz * w[0],
    ]
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

/// The free rows of (4) for their accelerations, then the driven rows for the forces of the lines.
#[inline(always)]
pub(crate) fn solve_motion<T: Real>(
    plant: &Plant<T>,
    pose: &Pose<T>,
    rates: &Rates<T>,
    driven: &Driven<T>,
    flow_speed: T,
) -> Motion<T> {
    let c = T::constant;
    let (sin_zenith, cos_zenith, length) = (pose.sin_zenith, pose.cos_zenith, pose.length);
    let sideways = rates.azimuth * sin_zenith;
    let around = rates.azimuth * cos_zenith;
    let (omega, omega_relative) = pose.angular_velocity(rates);
    let flow = pose.flow_velocity(flow_speed);
    let relative = combine(&pose.axes, sub(pose.joint_velocity(rates), flow));

    // Acceleration of the joint along T with the free accelerations at zero.
    let squared = rates.zenith * rates.zenith + sideways * sideways;
    let two_out = c(2.0) * rates.length;
    let joint = combine(
        &pose.axes,
        [
            length * sideways * around - two_out * rates.zenith,
            -(two_out * sideways) - c(2.0) * length * around * rates.zenith,
            length * squared - driven.length,
        ],
    );
    // Angular acceleration along B with the free accelerations at zero.
    let turned = cross(omega_relative, sub(omega, omega_relative));
    let twisting = cross(omega_relative, scale(rates.twist, pose.axes[2]));
    let frame = combine(&pose.axes, [-(around * rates.zenith), c(0.0), -(sideways * rates.zenith)]);
    let rolled = rates.pitch * rates.roll;
    let bridle = [
        driven.roll,
        driven.pitch * pose.cos_roll - rolled * pose.sin_roll,
        -(driven.pitch * pose.sin_roll) - rolled * pose.cos_roll,
    ];
    let alpha = add(sub(sub(frame, turned), twisting), bridle);

    // What the fluid and gravity supply less what the motion at zero free acceleration takes.
    let down = add(scale(-sin_zenith, pose.axes[0]), scale(cos_zenith, pose.axes[2]));
    let gravity = scale(plant.gravity, down);
    let inertia = inertial_wrench(plant, joint, alpha);
    let centripetal = cross(omega, cross_point(omega, plant.cm_x, plant.cm_z));
    let at_cm = scale(plant.mass, sub(centripetal, gravity));
    // Of the added mass d/dt(M_a v_r), v_r = [u, v, w] + omega x r_cb: what is left turns [u, v, w] and M_a v_r with B.
    let through = add(relative, cross_point(omega, plant.cb_x, plant.cb_z));
    let carried = added(plant, through);
    let at_cb =
        add(sub(cross(omega, carried), added(plant, cross(omega, relative))), scale(plant.displaced_mass, gravity));
    let spin = cross(omega, inertia_times(plant, omega));
    let munk = cross(through, carried);
    let moments = add(point_cross(plant.cm_x, plant.cm_z, at_cm), point_cross(plant.cb_x, plant.cb_z, at_cb));
    let air = fluid::aerodynamics(plant, relative, omega);
    let force = sub(air.force, add(inertia.force, add(at_cm, at_cb)));
    let moment = sub(air.moment, add(inertia.moment, add(add(moments, spin), munk)));

    // Rows of Phi, of Theta (less cos Phi times that of Psi, over sin Phi) and of Psi, (4).
    let (force_t, moment_t) = (project(&pose.axes, force), project(&pose.axes, moment));
    let [drag_zenith, drag_azimuth] = fluid::tether_drag(plant, pose, rates, flow);
    let tether = plant.tether_density * length * length;
    let tether_inertia = tether * length * c(1.0 / 3.0);
    let weight = plant.tether_net_density * plant.gravity * length;
    let right = [
        moment_t[1] - length * force_t[0] + drag_zenith - tether * rates.length * rates.zenith
            + tether_inertia * sideways * around
            + c(0.5) * weight * length * sin_zenith,
        -moment_t[0] - length * force_t[1] + drag_azimuth
            - tether * rates.length * sideways
            - c(2.0) * tether_inertia * around * rates.zenith,
        moment_t[2],
    ];

    // Unit accelerations Phi'', Theta'' sin Phi, Psi'' + Theta'' cos Phi along B.
    let [x_t, y_t, z_t] = pose.axes;
    let zero = [c(0.0); 3];
    let linear = [scale(-length, x_t), scale(-length, y_t), zero];
    let angular = [y_t, scale(c(-1.0), x_t), z_t];
    let columns = [
        inertial_wrench(plant, linear[0], angular[0]),
        inertial_wrench(plant, linear[1], angular[1]),
        inertial_wrench(plant, linear[2], angular[2]),
    ];
    let entry = |i: usize, j: usize| dot(linear[i], columns[j].force) + dot(angular[i], columns[j].moment);
    let m00 = entry(0, 0) + tether_inertia;
    let m11 = entry(1, 1) + tether_inertia;
    let (m10, m20, m21, m22) = (entry(0, 1), entry(2, 0), entry(2, 1), dot(angular[2], columns[2].moment));
    let solution = solve([[m00, m10, m20], [m10, m11, m21], [m20, m21, m22]], right);

    let azimuth = solution[1] / sin_zenith;
    let free = [solution[0], azimuth, solution[2] - azimuth * cos_zenith];

    // Driven rows: f = D q'' + C q' + g − tau.
    let mut left_force = force_t[2];
    let mut left_moment = moment;
    let mut j = 0;
    while j < 3 {
        left_force = left_force - solution[j] * dot(z_t, columns[j].force);
        left_moment = sub(left_moment, scale(solution[j], columns[j].moment));
        j += 1;
    }
    let line = plant.tether_density * length;
    let supplied = [
        left_force
            + line * (driven.length - c(0.5) * length * squared)
            + c(0.5) * plant.tether_density * rates.length * rates.length
            + weight * cos_zenith,
        -dot(pose.pitch_axis(), left_moment),
        -left_moment[0],
    ];
    Motion { free, supplied }
}

/// Tension of each line in N: center, starboard, port.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tensions<T = f64> {
    /// Line 1.
    pub center: T,
    /// Line 2.
    pub starboard: T,
    /// Line 3.
    pub port: T,
}

/// A line that a tether model without slack cannot describe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slack {
    /// `center`, `starboard` or `port`.
    pub line: &'static str,
    /// The tension, negative, in N: how far the model is from where it holds.
    pub tension_n: f64,
}

impl Tensions {
    /// The lines by name.
    #[must_use]
    pub fn named(&self) -> [(&'static str, f64); 3] {
        [("center", self.center), ("starboard", self.starboard), ("port", self.port)]
    }

    /// The smallest of the three: the margin to slack.
    #[must_use]
    pub fn margin_n(&self) -> f64 {
        self.center.min(self.starboard).min(self.port)
    }

    /// The line with the most negative tension, if any is below zero.
    #[must_use]
    pub fn slack(&self) -> Option<Slack> {
        let (line, tension_n) =
            self.named().into_iter().fold(("center", f64::INFINITY), |a, b| if b.1 < a.1 { b } else { a });
        (tension_n < 0.0).then_some(Slack { line, tension_n })
    }
}

/// `T_i = −Σ_j (∂q_j/∂l_i) f_j` over the driven coordinates.
#[inline(always)]
pub(crate) fn tensions<T: Real>(plant: &Plant<T>, pose: &Pose<T>, supplied: [T; 3]) -> Tensions<T> {
    let pitch = plant.per_long * pose.cos_pitch * pose.cos_pitch * supplied[1];
    let roll = plant.per_lat * pose.cos_roll * pose.cos_roll * supplied[2];
    let mean = supplied[0] * T::constant(1.0 / 3.0);
    let aft = T::constant(0.5) * pitch - mean;
    Tensions { center: -(mean + pitch), starboard: aft + roll, port: aft - roll }
}

/// What the equation of motion says at one configuration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accelerations {
    /// Accelerations of Phi, Theta, Psi in rad/s².
    pub free_rad_s2: [f64; 3],
    /// Generalized forces that the lines supply on L_t (N), theta' and phi' (N·m).
    pub supplied: [f64; 3],
    /// Tensions of the lines. They mean something where lines can give the induced angles, within a quarter turn
    /// (a [`FlightState`], which holds the lines themselves, is always there); the rest holds at any angle.
    pub tensions: Tensions,
}

/// Accelerations of the free coordinates when the driven ones follow their winches, and the line tensions.
///
/// `q` are the coordinates, `q_rate` their rates, `driven` the accelerations of `[L_t, theta', phi']` in m/s²
/// and rad/s². Source: (4), rows of Phi, Theta, Psi for the accelerations, the other three for the forces.
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
        return Err(Error::Argument { name: "acceleration of a driven coordinate", value, allowed: "finite" });
    }
    let pose = Pose::of_coordinates(q, flow);
    let motion = solve_motion(
        plant,
        &pose,
        &Rates::of_array(q_rate),
        &Driven { length: driven[0], pitch: driven[1], roll: driven[2] },
        flow.speed_m_s,
    );
    Ok(Accelerations {
        free_rad_s2: motion.free,
        supplied: motion.supplied,
        tensions: tensions(plant, &pose, motion.supplied),
    })
}

/// |sin Phi| below which azimuth and twist count as coincident.
pub const SINGULAR_SIN_ZENITH: f64 = 1e-6;

/// Checks what the equations of motion need, naming the offender.
pub(crate) fn check_coordinates(q: &Coordinates, q_rate: &Coordinates) -> Result<(), Error> {
    const NAMES: [&str; 6] = [
        "zenith angle Phi",
        "azimuth Theta",
        "twist Psi",
        "tether length L_t",
        "induced pitch theta'",
        "induced roll phi'",
    ];
    const UNITS: [&str; 6] = ["rad", "rad", "rad", "m", "rad", "rad"];
    for k in 0..6 {
        for value in [q[k], q_rate[k]] {
            if !value.is_finite() {
                return Err(Error::State { name: NAMES[k], value, unit: UNITS[k], time_s: 0.0, allowed: "finite" });
            }
        }
    }
    if q[3] <= 0.0 {
        return Err(Error::State { name: NAMES[3], value: q[3], unit: "m", time_s: 0.0, allowed: "more than zero" });
    }
    check_zenith(q[0], 0.0)
}

/// Checks that the azimuth is defined.
pub(crate) fn check_zenith(zenith_rad: f64, time_s: f64) -> Result<(), Error> {
    if zenith_rad.sin().abs() > SINGULAR_SIN_ZENITH {
        return Ok(());
    }
    Err(Error::State {
        name: "zenith angle Phi",
        value: zenith_rad,
        unit: "rad",
        time_s,
        allowed: "away from 0 and pi, where azimuth and twist coincide",
    })
}

/// Derivative of a flight state under held winch commands, and what a camera sees at that state.
#[derive(Clone, Copy, Debug)]
pub struct Evaluation<T = f64> {
    /// Time derivative of the state.
    pub derivative: FlightState<T>,
    /// Position and attitude seen from the flow's direction.
    pub sight: Sight<T>,
    /// Line tensions in N.
    pub tensions: Tensions<T>,
}

/// The right-hand side of a flight: equation (4) with the winches
/// `dl_i/dt = u_i`, `du_i/dt = (clamp(u_cmd,i, ±u_max) − u_i)/tau_winch`, (3).
///
/// `commands` are the commanded reel speeds in m/s, in the order center, starboard, port. Nothing is checked
/// here: a state that leaves the model gives non-finite numbers, which [`check_state`] names.
#[inline(always)]
pub fn evaluate<T: Real>(plant: &Plant<T>, state: &FlightState<T>, commands: [T; 3], flow: &Flow<T>) -> Evaluation<T> {
    let &[zenith, azimuth, twist, zenith_rate, azimuth_rate, twist_rate, l1, l2, l3, u1, u2, u3] = state;
    let reel = [u1, u2, u3];
    // In this order a command that is not a number stays one.
    let limited = |command: T| (-plant.reel_limit).max(plant.reel_limit.min(command));
    let pull = |command: T, speed: T| (limited(command) - speed) * plant.per_winch;
    let reel_acceleration = [pull(commands[0], u1), pull(commands[1], u2), pull(commands[2], u3)];
    let bridle = Bridle::of_lines(plant, [l1, l2, l3], reel, reel_acceleration);
    let pose = bridle.pose([zenith, azimuth, twist], flow);
    let rates = bridle.rates([zenith_rate, azimuth_rate, twist_rate]);
    let driven =
        Driven { length: bridle.length_acceleration, pitch: bridle.pitch.acceleration, roll: bridle.roll.acceleration };
    let motion = solve_motion(plant, &pose, &rates, &driven, flow.speed_m_s);
    Evaluation {
        derivative: [
            zenith_rate,
            azimuth_rate,
            twist_rate,
            motion.free[0],
            motion.free[1],
            motion.free[2],
            u1,
            u2,
            u3,
            reel_acceleration[0],
            reel_acceleration[1],
            reel_acceleration[2],
        ],
        sight: pose.sight(plant),
        tensions: tensions(plant, &pose, motion.supplied),
    }
}

/// What a camera sees of a flight state, without the dynamics of [`evaluate`].
#[inline(always)]
#[must_use]
pub fn sight<T: Real>(plant: &Plant<T>, state: &FlightState<T>, flow: &Flow<T>) -> Sight<T> {
    let zero = [T::constant(0.0); 3];
    let bridle = Bridle::of_lines(plant, [state[6], state[7], state[8]], zero, zero);
    bridle.pose([state[0], state[1], state[2]], flow).sight(plant)
}

/// Names what is wrong with a flight state at `time_s`.
///
/// # Errors
/// [`Error::State`] for a non-finite entry, lines whose mean is zero or less, or a singular zenith angle.
pub fn check_state(state: &FlightState, time_s: f64) -> Result<(), Error> {
    use crate::kinematics::{STATE_NAMES, STATE_UNITS};
    for ((value, name), unit) in state.iter().zip(STATE_NAMES).zip(STATE_UNITS) {
        if !value.is_finite() {
            return Err(Error::State { name, value: *value, unit, time_s, allowed: "finite" });
        }
    }
    let length = (state[6] + state[7] + state[8]) / 3.0;
    if length <= 0.0 {
        return Err(Error::State {
            name: "tether length L_t",
            value: length,
            unit: "m",
            time_s,
            allowed: "more than zero",
        });
    }
    check_zenith(state[0], time_s)
}
