//! A second description of the plant for the tests: positions as products of rotations, velocities by complex step,
//! forces from the definitions of the frames. It shares no code with the crate.

use bat_dynamics::{Coordinates, FlightState, Flow, Parameters, TetherLayout};
use nalgebra::{Complex, Matrix3, Vector3};

type C = Complex<f64>;

/// The complex step has no cancellation: it may be as small as one likes.
const STEP: f64 = 1e-30;

fn c(value: f64) -> C {
    C::new(value, 0.0)
}

fn rx(angle: C) -> Matrix3<C> {
    let (s, k) = (angle.sin(), angle.cos());
    Matrix3::new(c(1.0), c(0.0), c(0.0), c(0.0), k, -s, c(0.0), s, k)
}

fn ry(angle: C) -> Matrix3<C> {
    let (s, k) = (angle.sin(), angle.cos());
    Matrix3::new(k, c(0.0), s, c(0.0), c(1.0), c(0.0), -s, c(0.0), k)
}

fn rz(angle: C) -> Matrix3<C> {
    let (s, k) = (angle.sin(), angle.cos());
    Matrix3::new(k, -s, c(0.0), s, k, c(0.0), c(0.0), c(0.0), c(1.0))
}

fn stepped(q: &Coordinates, rate: &Coordinates) -> [C; 6] {
    core::array::from_fn(|k| C::new(q[k], STEP * rate[k]))
}

fn unit_rate(k: usize) -> Coordinates {
    core::array::from_fn(|i| if i == k { 1.0 } else { 0.0 })
}

fn attitude(q: &[C; 6]) -> Matrix3<C> {
    rz(q[1]) * ry(q[0]) * rz(q[2]) * ry(q[4]) * rx(q[5])
}

fn tether_direction(q: &[C; 6]) -> Vector3<C> {
    -(rz(q[1]) * ry(q[0]) * Vector3::new(c(0.0), c(0.0), c(1.0)))
}

/// Body to ground.
pub(crate) fn rotation(q: &Coordinates) -> Matrix3<f64> {
    attitude(&q.map(c)).map(|entry| entry.re)
}

/// Position in G of the point `point_b` of the body.
pub(crate) fn position(q: &Coordinates, point_b: Vector3<f64>) -> Vector3<f64> {
    let q = q.map(c);
    (tether_direction(&q) * q[3] + attitude(&q) * point_b.map(c)).map(|entry| entry.re)
}

/// Velocity in G of the point `point_b` of the body.
pub(crate) fn velocity(q: &Coordinates, rate: &Coordinates, point_b: Vector3<f64>) -> Vector3<f64> {
    let q = stepped(q, rate);
    (tether_direction(&q) * q[3] + attitude(&q) * point_b.map(c)).map(|entry| entry.im / STEP)
}

/// Angular velocity in B: the axial vector of RᵀṘ.
pub(crate) fn angular_velocity(q: &Coordinates, rate: &Coordinates) -> Vector3<f64> {
    let r = attitude(&stepped(q, rate));
    let spin = r.map(|entry| entry.re).transpose() * r.map(|entry| entry.im / STEP);
    Vector3::new(spin[(2, 1)], spin[(0, 2)], spin[(1, 0)])
}

/// Direction from the winches to the joint, in G.
pub(crate) fn direction(q: &Coordinates) -> Vector3<f64> {
    tether_direction(&q.map(c)).map(|entry| entry.re)
}

/// Rate of [`direction`].
pub(crate) fn direction_rate(q: &Coordinates, rate: &Coordinates) -> Vector3<f64> {
    tether_direction(&stepped(q, rate)).map(|entry| entry.im / STEP)
}

/// The flow's velocity in G.
pub(crate) fn flow_velocity(flow: &Flow) -> Vector3<f64> {
    -flow.speed_m_s * Vector3::new(flow.direction_rad.cos(), flow.direction_rad.sin(), 0.0)
}

/// A point of the hull in B.
pub(crate) fn point(p: &Parameters, chord_fraction: f64, height_m: f64) -> Vector3<f64> {
    Vector3::new(-(chord_fraction - p.body.joint_x) * p.body.chord_m, 0.0, -height_m)
}

/// Aerodynamic centers of hull, horizontal and vertical stabilizer in B.
pub(crate) fn centers(p: &Parameters) -> [Vector3<f64>; 3] {
    let (h, v) = (&p.horizontal_stabilizer, &p.vertical_stabilizer);
    let (h_growth, v_growth) = (h.area_factor.sqrt(), v.area_factor.sqrt());
    [
        point(p, p.hull.center_x, p.hull.center_height_m),
        point(p, h.root_x + h_growth * h.offset_x, h.root_height_m + h_growth * h.offset_height_m),
        point(p, v.root_x + v_growth * v.offset_x, v.root_height_m + v_growth * v.offset_height_m),
    ]
}

/// The lift law beyond stall, for a plant that has it.
fn lift_angle(attack: f64, stall: f64) -> f64 {
    if attack.abs() > stall { 2.0 * stall * attack.signum() - attack } else { attack }
}

fn component_force(q_area: f64, v: Vector3<f64>, drag: f64, lift: f64, side: f64) -> Vector3<f64> {
    let e_d = -v.normalize();
    let e_l = e_d.cross(&Vector3::y()).normalize();
    let e_s = e_l.cross(&e_d);
    q_area * v.norm_squared() * (drag * e_d + lift * e_l + side * e_s)
}

/// Forces at the three centers and the hull's moment, in B, with stall; `relative` is the joint's velocity relative to
/// the flow.
pub(crate) fn aerodynamics(
    p: &Parameters,
    relative: Vector3<f64>,
    omega: Vector3<f64>,
) -> ([Vector3<f64>; 3], Vector3<f64>) {
    let [f, h, v] = centers(p).map(|center| relative + omega.cross(&center));
    let attack = |v: &Vector3<f64>| v.z.atan2(v.x);
    let slip = |v: &Vector3<f64>| (v.y / v.norm()).asin();
    let half = 0.5 * p.fluid.density_kg_m3;

    let hull = &p.hull;
    let (alpha, beta) = (attack(&f), slip(&f));
    let lift = hull.lift_zero + hull.lift_slope_per_rad * lift_angle(alpha, p.stall.hull_rad);
    let side = hull.side_force_slope_per_rad * beta;
    let drag = hull.drag_zero_lift + hull.drag_due_to_lift * (lift * lift + side * side);
    let force_f = component_force(half * hull.area_m2, f, drag, lift, side);
    let moment = half
        * f.norm_squared()
        * hull.area_m2
        * p.body.chord_m
        * Vector3::new(
            hull.roll_moment_slope_per_rad * beta,
            hull.pitch_moment_zero + hull.pitch_moment_slope_per_rad * alpha,
            hull.yaw_moment_slope_per_rad * beta,
        );

    let fin = &p.horizontal_stabilizer;
    let angle = lift_angle(attack(&h) + fin.incidence_rad, p.stall.horizontal_stabilizer_rad);
    let lift = fin.lift_zero + fin.lift_slope_per_rad * angle;
    let drag = fin.drag_zero_lift + fin.drag_due_to_lift * lift * lift;
    let force_h = component_force(half * fin.area_m2 * fin.area_factor, h, drag, lift, 0.0);

    let fin = &p.vertical_stabilizer;
    let side = fin.side_force_slope_per_rad * slip(&v);
    let drag = fin.drag_zero_lift + fin.drag_due_to_side_force * side * side;
    let force_v = component_force(half * fin.area_m2 * fin.area_factor, v, drag, 0.0, side);
    ([force_f, force_h, force_v], moment)
}

/// Nodes and weights of three-point Gauss–Legendre on (0, 1).
pub(crate) fn gauss() -> [(f64, f64); 3] {
    let half_width = 0.5 * 0.6_f64.sqrt();
    [(0.5 - half_width, 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.5 + half_width, 5.0 / 18.0)]
}

/// Virtual work of all fluid forces on each coordinate: points of the body and of the tether moved one by one.
pub(crate) fn generalized_forces(p: &Parameters, q: &Coordinates, rate: &Coordinates, flow: &Flow) -> [f64; 6] {
    let r = rotation(q);
    let relative = r.transpose() * (velocity(q, rate, Vector3::zeros()) - flow_velocity(flow));
    let (forces, moment) = aerodynamics(p, relative, angular_velocity(q, rate));
    let width = 3.0 * p.tether.line_diameter_m;
    core::array::from_fn(|k| {
        let unit = unit_rate(k);
        let body: f64 = centers(p).iter().zip(&forces).map(|(at, f)| velocity(q, &unit, *at).dot(&(r * f))).sum();
        let lines: f64 = gauss()
            .iter()
            .map(|&(share, weight)| {
                let (s, e) = (share * q[3], direction(q));
                let wind = flow_velocity(flow) - s * direction_rate(q, rate);
                let across = wind - e * e.dot(&wind);
                let force = 0.5 * p.fluid.density_kg_m3 * width * p.tether.drag_coefficient * across.norm() * across;
                weight * q[3] * s * direction_rate(q, &unit).dot(&force)
            })
            .sum();
        body + angular_velocity(q, &unit).dot(&moment) + lines
    })
}

/// Weight and buoyancy of body and tether, from altitudes.
pub(crate) fn potential_energy(p: &Parameters, q: &Coordinates) -> f64 {
    let altitude = |x, h| -position(q, point(p, x, h)).z;
    let tether_volume = 3.0 * core::f64::consts::PI * p.tether.line_diameter_m.powi(2) / 4.0 * q[3];
    let tether_mass = p.tether.linear_density_kg_m * q[3] - p.fluid.density_kg_m3 * tether_volume;
    p.fluid.gravity_m_s2
        * (p.body.mass_kg * altitude(p.body.center_of_mass_x, p.body.center_of_mass_height_m)
            - p.fluid.density_kg_m3
                * p.body.volume_m3
                * altitude(p.body.center_of_buoyancy_x, p.body.center_of_buoyancy_height_m)
            + tether_mass * -0.5 * q[3] * direction(q).z)
}

/// Coordinates and their rates of a flight state: (1), (2), (3).
pub(crate) fn coordinates(p: &Parameters, state: &FlightState) -> (Coordinates, Coordinates) {
    let sign = match p.layout {
        TetherLayout::OneForwardTwoAft => 1.0,
        TetherLayout::TwoForwardOneAft => -1.0,
    };
    let lines = |l: &[f64]| {
        (
            (l[0] + l[1] + l[2]) / 3.0,
            sign * (l[0] - (l[1] + l[2]) / 2.0) / p.tether.separation_longitudinal_m,
            (l[2] - l[1]) / p.tether.separation_lateral_m,
        )
    };
    let (length, tan_pitch, tan_roll) = lines(&state[6..9]);
    let (length_rate, pitch, roll) = lines(&state[9..12]);
    (
        [state[0], state[1], state[2], length, tan_pitch.atan(), tan_roll.atan()],
        [
            state[3],
            state[4],
            state[5],
            length_rate,
            pitch / (1.0 + tan_pitch * tan_pitch),
            roll / (1.0 + tan_roll * tan_roll),
        ],
    )
}

/// d/dt f at t = 0 by central differences of eighth order.
pub(crate) fn slope<T>(step: f64, f: impl Fn(f64) -> T) -> T
where
    T: core::ops::Sub<Output = T> + core::ops::Add<Output = T> + core::ops::Mul<f64, Output = T>,
{
    let pair = |k: f64, weight: f64| (f(k * step) - f(-k * step)) * (weight / step);
    pair(1.0, 4.0 / 5.0) + pair(2.0, -1.0 / 5.0) + pair(3.0, 4.0 / 105.0) + pair(4.0, -1.0 / 280.0)
}

/// `n` steps of the classical Runge–Kutta method from t = 0.
pub(crate) fn fly<const N: usize>(
    mut x: [f64; N],
    step_s: f64,
    n_steps: usize,
    mut rate: impl FnMut(f64, &[f64; N]) -> [f64; N],
) -> [f64; N] {
    let along = |x: &[f64; N], k: &[f64; N], h: f64| core::array::from_fn(|i| x[i] + h * k[i]);
    for step in 0..n_steps {
        let t = step as f64 * step_s;
        let k1 = rate(t, &x);
        let k2 = rate(t + 0.5 * step_s, &along(&x, &k1, 0.5 * step_s));
        let k3 = rate(t + 0.5 * step_s, &along(&x, &k2, 0.5 * step_s));
        let k4 = rate(t + step_s, &along(&x, &k3, step_s));
        x = core::array::from_fn(|i| x[i] + step_s / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
    }
    x
}
