//! Limits with a closed form: pendulums, circles, reeling, a free rigid body.

use bat_dynamics::{
    Accelerations, Coordinates, Fidelity, Flow, Linearization, Parameters, Plant, TrimHeight, TrimRequest,
    accelerations, body_to_ground, evaluate, gravity_vector, linearize, mass_matrix, modes, rotation, trim,
};
use core::f64::consts::{FRAC_PI_2, PI};
use nalgebra::{Complex, Matrix2, Matrix3, Vector2, Vector3};

use crate::oracle::fly;
use crate::plants::{POINT_LIFT_N, POINT_MASS_KG, point_body};

const LENGTH_M: f64 = 0.61;
const STILL: Flow = Flow { speed_m_s: 0.0, direction_rad: 0.0 };

/// A point that carries the same added mass in every direction, and its total mass.
fn point_with_added_mass() -> (Plant, f64) {
    let mut p = point_body();
    p.added_mass.x_kg = 0.07;
    p.added_mass.y_kg = 0.07;
    p.added_mass.z_kg = 0.07;
    (Plant::new(&p, Fidelity::ADDED_MASS).unwrap(), POINT_MASS_KG + 0.07)
}

/// The arithmetic-geometric mean.
fn agm(mut a: f64, mut b: f64) -> f64 {
    for _ in 0..8 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    a
}

#[test]
fn pendulum_has_its_period_at_small_and_at_large_amplitude() {
    let (plant, mass) = point_with_added_mass();
    let omega = (POINT_LIFT_N / (mass * LENGTH_M)).sqrt();
    for amplitude in [1e-4, 0.5, 1.2, 1.5_f64] {
        // K(k) = pi / (2 agm(1, sqrt(1 - k²))), T = 4 K(sin(amplitude/2)) / omega
        let quarter = PI / (2.0 * agm(1.0, (0.5 * amplitude).cos())) / omega;
        let mut start = [0.0; 12];
        start[0] = amplitude;
        start[6..9].copy_from_slice(&[LENGTH_M; 3]);
        let rate = |_: f64, x: &[f64; 12]| evaluate(&plant, x, [0.0; 3], &STILL).derivative;
        let n_steps = 2000;
        let low = fly(start, quarter / f64::from(n_steps), n_steps as usize, rate);
        assert!(low[0].abs() < 1e-8 * amplitude, "after a quarter of a period Phi = {} rad", low[0]);
        let other_side = fly(start, quarter / f64::from(n_steps), 2 * n_steps as usize, rate);
        assert!((other_side[0] + amplitude).abs() < 1e-8 * amplitude, "after a half {} rad", other_side[0]);
    }
    // At 1e-4 rad the period is that of small swings, omega² = (rho Vol - m) g / ((m + m_a) L), to 1e-9.
    assert!((agm(1.0, 0.5e-4_f64.cos()) - 1.0).abs() < 1e-9, "small amplitude");
}

#[test]
fn conical_motion_goes_around_steadily() {
    let (plant, mass) = point_with_added_mass();
    for zenith in [0.1, 0.7, 1.3_f64] {
        let around = (POINT_LIFT_N / (mass * LENGTH_M * zenith.cos())).sqrt();
        let start = [zenith, 0.4, 0.2, 0.0, around, 0.0, LENGTH_M, LENGTH_M, LENGTH_M, 0.0, 0.0, 0.0];
        let at = evaluate(&plant, &start, [0.0; 3], &STILL).derivative;
        assert!(at[3].abs() < 1e-10 && at[4].abs() < 1e-10, "accelerations {} and {}", at[3], at[4]);
        let turn = 2.0 * PI / around;
        let end = fly(start, turn / 1000.0, 1000, |_, x| evaluate(&plant, x, [0.0; 3], &STILL).derivative);
        assert!((end[0] - zenith).abs() < 1e-9, "zenith angle {} after one turn", end[0]);
        assert!((end[1] - start[1] - 2.0 * PI).abs() < 1e-9, "azimuth {} after one turn", end[1]);
    }
}

/// A point with the drag of a sphere: `C_D A` in m².
fn sphere(drag_area_m2: f64) -> Parameters {
    let mut p = point_body();
    p.hull.area_m2 = drag_area_m2;
    p.hull.drag_zero_lift = 1.0;
    for inertia in [&mut p.body.inertia_xx_kg_m2, &mut p.body.inertia_yy_kg_m2, &mut p.body.inertia_zz_kg_m2] {
        *inertia = 1e-10;
    }
    p
}

#[test]
fn sphere_in_the_flow_hangs_at_drag_over_lift_and_swings_with_the_sum_of_both() {
    let speed = 0.3;
    for drag_area_m2 in [0.001, 0.01, 0.05] {
        let plant = Plant::new(&sphere(drag_area_m2), Fidelity::NUMERICAL).unwrap();
        let flow = Flow { speed_m_s: speed, direction_rad: 0.4 };
        let request = TrimRequest { flow, pitch_rad: 0.1, height: TrimHeight::TetherLength(LENGTH_M) };
        let found = trim(&plant, &request).unwrap();
        let drag = 0.5 * 1000.0 * speed * speed * drag_area_m2;
        assert!((found.coordinates[0] - (drag / POINT_LIFT_N).atan()).abs() < 1e-10, "{:?}", found.coordinates);

        // Drag grows by rho V A C_D along the flow and half of that across it: m s² + c s + F/L = 0 with
        // c = (drag/V) (1 + cos² Phi) in the plane of the flow, drag/V across.
        let linear = linearize(&plant, &found.state, [0.0; 3], &flow).unwrap();
        let found_modes = modes(&linear.among(&Linearization::FREE)).unwrap().modes;
        let cos = found.coordinates[0].cos();
        for damping in [drag / speed * (1.0 + cos * cos), drag / speed] {
            let (half, stiffness) =
                (0.5 * damping / POINT_MASS_KG, drag.hypot(POINT_LIFT_N) / (POINT_MASS_KG * LENGTH_M));
            let root = Complex::new(half * half - stiffness, 0.0).sqrt() - half;
            let nearest = found_modes.iter().map(|mode| (mode.eigenvalue - root).norm()).fold(f64::INFINITY, f64::min);
            assert!(nearest < 1e-7, "no mode at {root}: {found_modes:?}");
        }
    }
}

#[test]
fn reeling_pulls_at_the_lines_as_the_radial_balance_says() {
    let mut p = point_body();
    p.added_mass.x_kg = 0.07;
    p.added_mass.y_kg = 0.07;
    p.added_mass.z_kg = 0.07;
    let mass = POINT_MASS_KG + 0.07;
    for (density, diameter) in [(0.0, 0.0), (0.03, 0.0), (0.03, 0.002)] {
        p.tether.linear_density_kg_m = density;
        p.tether.line_diameter_m = diameter;
        let plant = Plant::new(&p, Fidelity::ADDED_MASS).unwrap();
        let (zenith, length, length_acceleration) = (0.6_f64, 0.7, 0.4);
        let (zenith_rate, azimuth_rate, length_rate) = (0.8, -1.1, 0.3);
        let q = [zenith, 0.3, -0.2, length, 0.0, 0.0];
        let rate = [zenith_rate, azimuth_rate, 0.0, length_rate, 0.0, 0.0];
        let at = accelerations(&plant, &q, &rate, [length_acceleration, 0.0, 0.0], &STILL).unwrap();
        let swing = zenith_rate.powi(2) + (zenith.sin() * azimuth_rate).powi(2);
        let body = POINT_LIFT_N * zenith.cos() - mass * (length_acceleration - length * swing);
        // The lines' own share, from their Lagrangian; half of lambda L'² of it is not in the balance of momentum.
        let displaced = 1000.0 * 3.0 * PI * diameter * diameter / 4.0;
        let tether = (displaced - density) * 9.81 * length * zenith.cos()
            - density * length * (length_acceleration - 0.5 * length * swing)
            - 0.5 * density * length_rate * length_rate;
        let sum: f64 = at.tensions.named().iter().map(|line| line.1).sum();
        assert!((sum - body - tether).abs() < 1e-10, "tensions add to {sum} N, expected {} N", body + tether);

        // Rows of Phi and Theta: angular momentum of a bob on a rod of uniform mass about the winches.
        if diameter == 0.0 {
            let about = mass * length * length + density * length.powi(3) / 3.0;
            let about_rate = (2.0 * mass * length + density * length * length) * length_rate;
            let torque = (POINT_LIFT_N - 0.5 * density * 9.81 * length) * length;
            let zenith_expected = (-torque * zenith.sin() - about_rate * zenith_rate) / about
                + zenith.sin() * zenith.cos() * azimuth_rate * azimuth_rate;
            let azimuth_expected = -about_rate / about * azimuth_rate - 2.0 * zenith_rate * azimuth_rate / zenith.tan();
            assert!(
                (at.free_rad_s2[0] - zenith_expected).abs() < 1e-9,
                "{} against {zenith_expected}",
                at.free_rad_s2[0]
            );
            assert!(
                (at.free_rad_s2[1] - azimuth_expected).abs() < 1e-9,
                "{} against {azimuth_expected}",
                at.free_rad_s2[1]
            );
        }
    }
}

/// A body whose center of mass and buoyancy is the joint, and whose induced angles follow no winch but are free.
struct FreeBody {
    plant: Plant,
    inertia: Matrix3<f64>,
}

impl FreeBody {
    fn new(inertia: [f64; 3], product: f64) -> Self {
        let mut p = point_body();
        let [xx, yy, zz] = inertia;
        (p.body.inertia_xx_kg_m2, p.body.inertia_yy_kg_m2, p.body.inertia_zz_kg_m2) = (xx, yy, zz);
        p.body.inertia_xz_kg_m2 = product;
        Self {
            plant: Plant::new(&p, Fidelity::NUMERICAL).unwrap(),
            inertia: Matrix3::new(xx, 0.0, -product, 0.0, yy, 0.0, -product, 0.0, zz),
        }
    }

    /// Accelerations of the induced angles that take no moment from the lines, then those of the free coordinates.
    fn rate(&self, x: &[f64; 12]) -> [f64; 12] {
        let (q, rate): (Coordinates, Coordinates) = (x[..6].try_into().unwrap(), x[6..].try_into().unwrap());
        let at = |pitch, roll| -> Accelerations {
            accelerations(&self.plant, &q, &rate, [0.0, pitch, roll], &STILL).unwrap()
        };
        let moments = |a: Accelerations| Vector2::new(a.supplied[1], a.supplied[2]);
        let none = moments(at(0.0, 0.0));
        let columns = Matrix2::from_columns(&[moments(at(1.0, 0.0)) - none, moments(at(0.0, 1.0)) - none]);
        let [pitch, roll]: [f64; 2] = columns.lu().solve(&-none).unwrap().into();
        let [a, b, c] = at(pitch, roll).free_rad_s2;
        let [v, w] = [rate, [a, b, c, 0.0, pitch, roll]];
        core::array::from_fn(|k| if k < 6 { v[k] } else { w[k - 6] })
    }

    /// Body rates, and angular momentum in G.
    fn spin(&self, x: &[f64; 12]) -> (Vector3<f64>, Vector3<f64>) {
        let (q, rate): (Coordinates, Coordinates) = (x[..6].try_into().unwrap(), x[6..].try_into().unwrap());
        let omega = rotation(&self.plant, &q, &rate);
        let omega = Vector3::new(omega[3], omega[4], omega[5]);
        let rows = body_to_ground(&q);
        (omega, Matrix3::from_fn(|i, j| rows[i][j]) * self.inertia * omega)
    }
}

#[test]
fn free_symmetric_top_precesses_at_its_rate() {
    let (along, across) = (4e-4, 2.5e-4);
    let top = FreeBody::new([along, across, across], 0.0);
    let start = [0.4, 0.2, 0.1, 0.6, 0.1, 0.0, 0.3, 0.4, 0.3, 0.0, 0.2, 5.0];
    let (before, momentum) = top.spin(&start);
    let end = fly(start, 1e-3, 1500, |_, x| top.rate(x));
    let (after, momentum_after) = top.spin(&end);
    let angle = (across - along) / across * before.x * 1.5;
    let (sin, cos) = angle.sin_cos();
    let expected = Vector3::new(before.x, before.y * cos + before.z * sin, before.z * cos - before.y * sin);
    assert!(angle.abs() > 3.0, "the case turns by {angle} rad");
    assert!((after - expected).amax() < 1e-9, "{after} against {expected}");
    assert!((momentum - momentum_after).amax() < 1e-12, "angular momentum {momentum}, then {momentum_after}");
}

#[test]
fn free_asymmetric_top_keeps_angular_momentum_and_energy_while_it_tumbles() {
    // About its middle axis, with a product of inertia, so that the axes of B are not the principal ones.
    let top = FreeBody::new([4e-4, 2e-4, 3e-4], 4e-5);
    let start = [0.4, 0.2, 0.1, 0.6, -0.1, 0.05, 0.1, 0.1, 6.0, 0.0, 0.0, 0.0];
    let (omega, momentum) = top.spin(&start);
    let end = fly(start, 2.5e-4, 6000, |_, x| top.rate(x));
    let (omega_after, momentum_after) = top.spin(&end);
    assert!((omega_after - omega).norm() > 1.0, "the case tumbles: {omega} then {omega_after}");
    assert!((momentum - momentum_after).norm() < 1e-9 * momentum.norm(), "{momentum}, then {momentum_after}");
    let energy = |w: Vector3<f64>| 0.5 * w.dot(&(top.inertia * w));
    assert!((energy(omega) - energy(omega_after)).abs() < 1e-9 * energy(omega), "energy of rotation");
}

#[test]
fn body_rolls_about_a_fixed_joint_as_a_buoyancy_pendulum() {
    // The joint at rest and the induced roll free: its row alone, D_66 phi'' + g_6 = 0. The pitch of the body is zero
    // with theta' = -Phi, so that it rolls about a horizontal axis.
    let mut p = point_body();
    p.body.inertia_xx_kg_m2 = 3e-4;
    p.body.inertia_yy_kg_m2 = 3e-4;
    p.body.inertia_zz_kg_m2 = 3e-4;
    p.body.center_of_mass_height_m = 0.04;
    p.body.center_of_buoyancy_height_m = 0.05;
    p.added_mass.y_kg = 0.2;
    p.added_mass.inertia_x_kg_m2 = 5e-5;
    let plant = Plant::new(&p, Fidelity::ADDED_MASS).unwrap();
    let roll = 1e-4;
    let at = |roll| [0.3, 0.2, 0.0, LENGTH_M, -0.3, roll];
    let inertia = mass_matrix(&plant, &at(roll))[(5, 5)];
    let stiffness = gravity_vector(&plant, &at(roll))[5] / roll;
    let expected_inertia = 3e-4 + 0.18 * 0.04 * 0.04 + 5e-5 + 0.2 * 0.05 * 0.05;
    let expected_stiffness = 9.81 * (1000.0 * 2.4e-4 * 0.05 - 0.18 * 0.04);
    assert!((inertia - expected_inertia).abs() < 1e-12, "{inertia} against {expected_inertia}");
    assert!((stiffness / expected_stiffness - 1.0).abs() < 1e-6, "{stiffness} against {expected_stiffness}");
    // At a quarter turn nothing is left but the arm itself.
    let quarter = gravity_vector(&plant, &at(FRAC_PI_2))[5];
    assert!((quarter - expected_stiffness).abs() < 1e-12, "{quarter} N·m against {expected_stiffness} N·m");
}
