//! The terms of (4) against their definitions, and the wrench form that flies against the Lagrangian form.

use bat_dynamics::{
    Coordinates, Fidelity, Flow, Parameters, Plant, accelerations, body_to_ground, christoffel_matrix,
    generalized_forces, gravity_vector, kinetic_energy, mass_matrix, potential_energy, rotation, translation,
};
use nalgebra::{Cholesky, Matrix3, Vector3, Vector6};

use crate::oracle;
use crate::plants::{Sample, everything};

const FIDELITIES: [Fidelity; 4] =
    [Fidelity::NUMERICAL, Fidelity::STALLED, Fidelity::ADDED_MASS, Fidelity::STALLED_WITH_ADDED_MASS];

fn moved(q: &Coordinates, rate: &Coordinates, time: f64) -> Coordinates {
    core::array::from_fn(|k| q[k] + time * rate[k])
}

#[test]
fn mass_matrix_is_symmetric_and_positive_definite() {
    let mut sample = Sample(1);
    for fidelity in [Fidelity::NUMERICAL, Fidelity::ADDED_MASS] {
        let plant = Plant::new(&everything(), fidelity).unwrap();
        for _ in 0..1000 {
            let q = sample.coordinates();
            let d = mass_matrix(&plant, &q);
            assert!((d - d.transpose()).amax() <= 1e-14 * d.amax(), "not symmetric at {q:?}");
            assert!(Cholesky::new(d).is_some(), "not positive definite at {q:?}: {d}");
        }
    }
}

/// Point masses with products of inertia, and the parameters of a body that has the same mass and tensor.
fn assembled_body() -> (Vec<(f64, Vector3<f64>)>, Parameters) {
    let mut p = everything();
    let center = oracle::point(&p, p.body.center_of_mass_x, p.body.center_of_mass_height_m);
    // Pairs about the center of mass, mirrored in the plane of symmetry; x and z of one sign give a positive product.
    let pairs = [(0.03, [0.05, 0.02, 0.03]), (0.02, [0.01, 0.06, -0.01]), (0.04, [-0.02, 0.03, 0.04])];
    let mut masses = Vec::new();
    for (mass, [x, y, z]) in pairs {
        for (sign, y) in [(1.0, y), (1.0, -y), (-1.0, y), (-1.0, -y)] {
            masses.push((mass / 2.0, Vector3::new(sign * x, y, sign * z)));
        }
    }
    let sum = |f: &dyn Fn(&Vector3<f64>) -> f64| masses.iter().map(|(mass, at)| mass * f(at)).sum::<f64>();
    p.body.mass_kg = sum(&|_| 1.0);
    p.body.inertia_xx_kg_m2 = sum(&|at| at.y * at.y + at.z * at.z);
    p.body.inertia_yy_kg_m2 = sum(&|at| at.z * at.z + at.x * at.x);
    p.body.inertia_zz_kg_m2 = sum(&|at| at.x * at.x + at.y * at.y);
    p.body.inertia_xz_kg_m2 = sum(&|at| at.x * at.z);
    (masses.into_iter().map(|(mass, at)| (mass, at + center)).collect(), p)
}

#[test]
fn kinetic_energy_is_that_of_the_point_masses_of_the_body() {
    let (masses, p) = assembled_body();
    assert!(p.body.inertia_xz_kg_m2 > 1e-5, "the product of inertia of the case is {}", p.body.inertia_xz_kg_m2);
    let plant = Plant::new(&p, Fidelity::NUMERICAL).unwrap();
    let mut sample = Sample(2);
    for _ in 0..100 {
        let (q, rate) = (sample.coordinates(), sample.rates());
        let body: f64 =
            masses.iter().map(|(mass, at)| 0.5 * mass * oracle::velocity(&q, &rate, *at).norm_squared()).sum();
        let tether: f64 = oracle::gauss()
            .iter()
            .map(|(share, weight)| {
                let across = share * q[3] * oracle::direction_rate(&q, &rate).norm();
                weight * q[3] * 0.5 * p.tether.linear_density_kg_m * (across * across + rate[3] * rate[3])
            })
            .sum();
        let found = kinetic_energy(&plant, &q, &rate);
        assert!((found - body - tether).abs() < 1e-13 * found.max(1e-2), "{found} against {} at {q:?}", body + tether);
    }
}

#[test]
fn kinetic_energy_takes_the_added_mass_at_the_center_of_buoyancy() {
    let p = everything();
    let [dry, wet] = [Fidelity::NUMERICAL, Fidelity::ADDED_MASS].map(|f| Plant::new(&p, f).unwrap());
    let mut sample = Sample(3);
    for _ in 0..100 {
        let (q, rate) = (sample.coordinates(), sample.rates());
        let center = oracle::point(&p, p.body.center_of_buoyancy_x, p.body.center_of_buoyancy_height_m);
        let v = oracle::rotation(&q).transpose() * oracle::velocity(&q, &rate, center);
        let omega = oracle::angular_velocity(&q, &rate);
        let a = &p.added_mass;
        let carried = Vector3::new(a.x_kg, a.y_kg, a.z_kg).component_mul(&v).dot(&v)
            + Vector3::new(a.inertia_x_kg_m2, a.inertia_y_kg_m2, a.inertia_z_kg_m2).component_mul(&omega).dot(&omega);
        let found = kinetic_energy(&wet, &q, &rate) - kinetic_energy(&dry, &q, &rate);
        assert!((found - 0.5 * carried).abs() < 1e-13, "{found} against {} at {q:?}", 0.5 * carried);
    }
}

#[test]
fn rate_of_the_mass_matrix_less_twice_c_is_skew() {
    let mut sample = Sample(4);
    for fidelity in [Fidelity::NUMERICAL, Fidelity::ADDED_MASS] {
        let plant = Plant::new(&everything(), fidelity).unwrap();
        for _ in 0..200 {
            let (q, rate) = (sample.coordinates(), sample.rates());
            let d_rate = oracle::slope(1e-2, |t| mass_matrix(&plant, &moved(&q, &rate, t)));
            let left = d_rate - christoffel_matrix(&plant, &q, &rate) * 2.0;
            assert!((left + left.transpose()).amax() < 2e-12, "not skew at {q:?}: {left}");
        }
    }
}

#[test]
fn c_times_rates_is_that_of_lagrange() {
    let mut sample = Sample(5);
    let plant = Plant::new(&everything(), Fidelity::ADDED_MASS).unwrap();
    for _ in 0..100 {
        let (q, rate) = (sample.coordinates(), sample.rates());
        let momentum_rate = oracle::slope(1e-2, |t| mass_matrix(&plant, &moved(&q, &rate, t)) * Vector6::from(rate));
        let energy_gradient = Vector6::from_fn(|k, _| {
            let unit = core::array::from_fn(|i| if i == k { 1.0 } else { 0.0 });
            oracle::slope(1e-2, |t| kinetic_energy(&plant, &moved(&q, &unit, t), &rate))
        });
        let found = christoffel_matrix(&plant, &q, &rate) * Vector6::from(rate);
        let left = found - (momentum_rate - energy_gradient);
        assert!(left.amax() < 1e-11, "off by {} at {q:?}", left.amax());
    }
}

#[test]
fn gravity_is_the_gradient_of_weight_and_buoyancy() {
    let mut sample = Sample(6);
    let p = everything();
    let plant = Plant::new(&p, Fidelity::NUMERICAL).unwrap();
    for _ in 0..100 {
        let q = sample.coordinates();
        let energy = oracle::potential_energy(&p, &q);
        assert!((potential_energy(&plant, &q) - energy).abs() < 1e-13, "potential energy at {q:?}");
        let found = gravity_vector(&plant, &q);
        for k in 0..6 {
            let unit = core::array::from_fn(|i| if i == k { 1.0 } else { 0.0 });
            let expected = oracle::slope(1e-2, |t| oracle::potential_energy(&p, &moved(&q, &unit, t)));
            assert!((found[k] - expected).abs() < 1e-12, "row {k}: {} against {expected} at {q:?}", found[k]);
        }
    }
}

#[test]
fn fluid_forces_do_the_virtual_work_of_their_points() {
    let mut sample = Sample(7);
    let p = everything();
    let plant = Plant::new(&p, Fidelity::STALLED).unwrap();
    for _ in 0..300 {
        let (q, rate) = (sample.coordinates(), sample.rates());
        let flow = Flow { speed_m_s: sample.within(0.0, 0.5), direction_rad: sample.within(-3.0, 3.0) };
        let found = generalized_forces(&plant, &q, &rate, &flow);
        let expected = Vector6::from(oracle::generalized_forces(&p, &q, &rate, &flow));
        assert!((found - expected).amax() < 1e-12 * expected.amax().max(1.0), "{found} against {expected} at {q:?}");
    }
}

#[test]
fn position_attitude_and_velocities_are_those_of_the_frames() {
    let mut sample = Sample(8);
    let p = everything();
    let plant = Plant::new(&p, Fidelity::NUMERICAL).unwrap();
    for _ in 0..300 {
        let (q, rate) = (sample.coordinates(), sample.rates());
        let center = oracle::point(&p, p.body.center_of_mass_x, p.body.center_of_mass_height_m);
        let r = oracle::rotation(&q);
        let (at, v) = (oracle::position(&q, center), r.transpose() * oracle::velocity(&q, &rate, center));
        let omega = oracle::angular_velocity(&q, &rate);
        // R = Rz(psi) Ry(theta) Rx(phi)
        let angles = [r[(2, 1)].atan2(r[(2, 2)]), -r[(2, 0)].asin(), r[(1, 0)].atan2(r[(0, 0)])];
        let x = translation(&plant, &q, &rate);
        let o = rotation(&plant, &q, &rate);
        let rows = Matrix3::from_fn(|i, j| body_to_ground(&q)[i][j]);
        assert!((rows - r).amax() < 1e-14, "rotation at {q:?}");
        for k in 0..3 {
            assert!((x[k] - at[k]).abs() < 1e-13, "position {k} at {q:?}");
            assert!((x[k + 3] - v[k]).abs() < 1e-13, "velocity {k} at {q:?}");
            assert!((o[k] - angles[k]).abs() < 1e-12, "angle {k}: {} against {} at {q:?}", o[k], angles[k]);
            assert!((o[k + 3] - omega[k]).abs() < 1e-13, "rate {k} at {q:?}");
        }
    }
}

#[test]
fn wrench_form_satisfies_the_lagrangian_form() {
    let mut sample = Sample(9);
    for fidelity in FIDELITIES {
        let plant = Plant::new(&everything(), fidelity).unwrap();
        for _ in 0..100 {
            let (q, rate, driven) = (sample.coordinates(), sample.rates(), sample.array(-1.0, 1.0));
            let flow = Flow { speed_m_s: sample.within(0.0, 0.4), direction_rad: sample.within(-3.0, 3.0) };
            let at = accelerations(&plant, &q, &rate, driven, &flow).unwrap();
            let [a, b, c] = at.free_rad_s2;
            let acceleration = Vector6::new(a, b, c, driven[0], driven[1], driven[2]);
            let left = mass_matrix(&plant, &q) * acceleration
                + christoffel_matrix(&plant, &q, &rate) * Vector6::from(rate)
                + gravity_vector(&plant, &q)
                - generalized_forces(&plant, &q, &rate, &flow);
            for k in 0..3 {
                assert!(left[k].abs() < 1e-12, "row {k}: {} at {q:?}", left[k]);
                assert!((left[k + 3] - at.supplied[k]).abs() < 1e-12, "row {}: {} at {q:?}", k + 3, left[k + 3]);
            }
        }
    }
}

#[test]
fn attitude_is_defined_with_the_nose_straight_up_or_down() {
    let plant = Plant::new(&everything(), Fidelity::NUMERICAL).unwrap();
    let mut sample = Sample(10);
    for _ in 0..1000 {
        let zenith = sample.within(0.1, 1.4);
        for quarter in [core::f64::consts::FRAC_PI_2, -core::f64::consts::FRAC_PI_2] {
            let q = [zenith, sample.within(-3.0, 3.0), 0.0, 0.6, quarter - zenith, 0.0];
            let [roll, pitch, yaw, ..] = rotation(&plant, &q, &[0.0; 6]);
            assert!((pitch - quarter).abs() < 1e-15, "pitch {pitch} at {q:?}");
            assert!(roll.is_finite() && yaw.is_finite(), "roll {roll}, yaw {yaw} at {q:?}");
        }
    }
}
