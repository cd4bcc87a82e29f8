//! Fluid forces: the build-up, stall, the edges of the flow angles, the tether's drag.

use bat_dynamics::{Fidelity, Flow, Parameters, Plant, aerodynamic_wrench, generalized_forces, lift_coefficients};
use nalgebra::Vector3;

use crate::oracle;
use crate::plants::{Sample, everything, rig, without_surfaces};

fn plant(p: &Parameters, fidelity: Fidelity) -> Plant {
    Plant::new(p, fidelity).unwrap()
}

/// The wrench about the joint by the second description.
fn expected(p: &Parameters, v: Vector3<f64>, omega: Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
    let (forces, moment) = oracle::aerodynamics(p, v, omega);
    let centers = oracle::centers(p);
    (forces.iter().sum(), moment + centers.iter().zip(forces).map(|(at, f)| at.cross(&f)).sum::<Vector3<f64>>())
}

#[test]
fn wrench_is_the_sum_of_three_components_in_their_own_flow() {
    let mut sample = Sample(41);
    for _ in 0..500 {
        let mut p = everything();
        p.horizontal_stabilizer.area_factor = sample.within(0.0, 2.0);
        p.vertical_stabilizer.area_factor = sample.within(0.0, 2.0);
        p.horizontal_stabilizer.incidence_rad = sample.within(-0.3, 0.3);
        let (v, omega): ([f64; 3], [f64; 3]) = (sample.array(-0.5, 0.5), sample.array(-2.0, 2.0));
        let (force, moment) = aerodynamic_wrench(&plant(&p, Fidelity::STALLED), v, omega);
        let (f, m) = expected(&p, v.into(), omega.into());
        assert!((Vector3::from(force) - f).amax() < 1e-12 * f.amax().max(1.0), "force {force:?} against {f}");
        assert!((Vector3::from(moment) - m).amax() < 1e-12 * m.amax().max(1.0), "moment {moment:?} against {m}");
    }
}

#[test]
fn factor_zero_removes_a_stabilizer_exactly() {
    let (v, omega) = ([0.3, 0.07, 0.05], [0.2, -0.1, 0.3]);
    for stabilizer in ["horizontal_stabilizer", "vertical_stabilizer"] {
        let [mut by_factor, mut by_area] = [everything(), everything()];
        let set =
            |p: &mut Parameters, name, value| (bat_dynamics::Field::find(stabilizer, name).unwrap().set)(p, value);
        set(&mut by_factor, "area_factor", 0.0);
        set(&mut by_area, "area", 0.0);
        let [a, b] = [by_factor, by_area].map(|p| aerodynamic_wrench(&plant(&p, Fidelity::STALLED), v, omega));
        assert_eq!(a, b, "{stabilizer}");
        assert_ne!(a, aerodynamic_wrench(&plant(&everything(), Fidelity::STALLED), v, omega), "{stabilizer} matters");
    }
}

#[test]
fn factor_four_of_a_stabilizer_doubles_its_offset_from_the_root() {
    // Only the vertical stabilizer, in a plain side slip without rotation: (57) about its own center.
    let mut p = without_surfaces(rig());
    p.vertical_stabilizer.area_m2 = 0.004;
    let v = [0.25, 0.05, 0.0];
    let [one, four] = [1.0, 4.0].map(|factor| {
        p.vertical_stabilizer.area_factor = factor;
        aerodynamic_wrench(&plant(&p, Fidelity::NUMERICAL), v, [0.0; 3])
    });
    for k in 0..3 {
        assert!((four.0[k] - 4.0 * one.0[k]).abs() < 1e-15, "force {k}: {} and {}", one.0[k], four.0[k]);
    }
    // Moment in yaw = x F_y: the arm follows from moment and force.
    let arm = |w: &([f64; 3], [f64; 3])| w.1[2] / w.0[1];
    let moved = p.vertical_stabilizer.offset_x * p.body.chord_m;
    assert!((arm(&four) - (arm(&one) - moved)).abs() < 1e-14, "arms {} m and {} m", arm(&one), arm(&four));
    let root = -(p.vertical_stabilizer.root_x - p.body.joint_x) * p.body.chord_m;
    assert!((arm(&one) - (root - moved)).abs() < 1e-14, "arm {} m", arm(&one));
    // Moment in roll = -z F_y, z = -height.
    let height = |w: &([f64; 3], [f64; 3])| w.1[0] / w.0[1];
    let v = &p.vertical_stabilizer;
    assert!((height(&one) - v.root_height_m - v.offset_height_m).abs() < 1e-14, "height {}", height(&one));
    assert!((height(&four) - v.root_height_m - 2.0 * v.offset_height_m).abs() < 1e-14, "height {}", height(&four));
}

#[test]
fn lift_follows_the_stall_law_and_is_continuous_and_odd() {
    let p = everything();
    let (hull, fin) = (&p.hull, &p.horizontal_stabilizer);
    let [attached, stalled] = [Fidelity::NUMERICAL, Fidelity::STALLED].map(|f| plant(&p, f));
    let stalls = [p.stall.hull_rad, p.stall.horizontal_stabilizer_rad];
    for k in 0..2 {
        let (zero, slope, stall) =
            [(hull.lift_zero, hull.lift_slope_per_rad, stalls[0]), (fin.lift_zero, fin.lift_slope_per_rad, stalls[1])]
                [k];
        let at = |plant: &Plant, attack: f64| lift_coefficients(plant, attack)[k];
        for attack in [0.0, 0.1, -0.1, 0.2, -0.2] {
            assert!((at(&stalled, attack) - zero - slope * attack).abs() < 1e-15, "linear at {attack}");
        }
        for attack in [0.5, -0.5, 1.5, -1.5, 3.0, -3.0] {
            assert!((at(&attached, attack) - zero - slope * attack).abs() < 1e-14, "attached at {attack}");
            // (58), (59): C_L0 + 2 C_La a_stall - C_La a above, mirrored below.
            let beyond = zero + attack.signum() * (2.0 * slope * stall - slope * attack.abs());
            assert!((at(&stalled, attack) - beyond).abs() < 1e-14, "stalled at {attack}");
            assert!((at(&stalled, attack) + at(&stalled, -attack) - 2.0 * zero).abs() < 1e-14, "odd at {attack}");
        }
        for edge in [stall, -stall] {
            let [below, above] = [edge * (1.0 - 1e-12), edge * (1.0 + 1e-12)].map(|attack| at(&stalled, attack));
            assert!((above - below).abs() < 1e-11, "jump of {} at {edge}", above - below);
            // As printed the law would jump by four slopes times the angle at the lower edge.
            let printed = zero + 2.0 * slope * stall - slope * edge;
            let jump = printed - at(&stalled, edge);
            assert!((jump - if edge < 0.0 { 4.0 * slope * stall } else { 0.0 }).abs() < 1e-12, "printed law at {edge}");
        }
    }
}

#[test]
fn lift_coefficients_are_at_the_angle_of_the_surface_and_leave_out_its_incidence() {
    // The horizontal stabilizer alone, without drag, at rest in a flow under the angle of attack alpha.
    let mut p = without_surfaces(rig());
    let fin = &mut p.horizontal_stabilizer;
    (fin.area_m2, fin.drag_zero_lift, fin.drag_due_to_lift) = (0.0017, 0.0, 0.0);
    let without = plant(&p, Fidelity::STALLED);
    p.horizontal_stabilizer.incidence_rad = 0.15;
    let with = plant(&p, Fidelity::STALLED);
    for alpha in [-0.3_f64, -0.05, 0.0, 0.1, 0.4] {
        assert_eq!(lift_coefficients(&with, alpha), lift_coefficients(&without, alpha), "at {alpha} rad");
        let speed = 0.3;
        let (force, _) = aerodynamic_wrench(&with, [speed * alpha.cos(), 0.0, speed * alpha.sin()], [0.0; 3]);
        let lift = force[0] * alpha.sin() - force[2] * alpha.cos();
        let expected = 0.5 * 1000.0 * speed * speed * 0.0017 * lift_coefficients(&with, alpha + 0.15)[1];
        assert!((lift - expected).abs() < 1e-15, "{lift} N against {expected} N at {alpha} rad");
    }
}

#[test]
fn side_slip_mirrors_the_forces_bit_for_bit() {
    let plant = plant(&everything(), Fidelity::STALLED);
    let mut sample = Sample(42);
    for _ in 0..200 {
        let ([u, v, w], [a, b, c]) = (sample.array(-0.5, 0.5), sample.array(-2.0, 2.0));
        let (f, m) = aerodynamic_wrench(&plant, [u, v, w], [a, b, c]);
        let (f_other, m_other) = aerodynamic_wrench(&plant, [u, -v, w], [-a, b, -c]);
        // Lift and drag even, side force odd, in the slip.
        assert_eq!(f_other, [f[0], -f[1], f[2]]);
        assert_eq!(m_other, [-m[0], m[1], -m[2]]);
    }
}

#[test]
fn no_flow_means_no_force_and_no_nan() {
    let plant = plant(&everything(), Fidelity::STALLED);
    let zero = ([0.0; 3], [0.0; 3]);
    assert_eq!(aerodynamic_wrench(&plant, [0.0; 3], [0.0; 3]), zero);
    assert_eq!(aerodynamic_wrench(&plant, [-0.0, 0.0, -0.0], [0.0; 3]), zero);
    // Forces vanish with the square of the speed, also where the square underflows.
    for speed in [1e-6, 1e-100, 1e-160, 1e-200, f64::MIN_POSITIVE, 5e-324] {
        let (force, moment) = aerodynamic_wrench(&plant, [speed, speed, -speed], [0.0; 3]);
        for value in force.into_iter().chain(moment) {
            assert!(value.abs() <= 20.0 * speed * speed, "{value} at {speed} m/s");
        }
    }
}

#[test]
fn flow_from_behind_and_from_the_side_is_defined() {
    let p = everything();
    let plant = plant(&p, Fidelity::STALLED);
    for v in [
        [-0.3, 0.0, 0.0],
        [0.0, 0.3, 0.0],
        [0.0, -0.3, 0.0],
        [0.0, 0.0, 0.3],
        [0.0, 0.0, -0.3],
        [0.0, 1.0, 0.0],
        [0.0, -20.0, 0.0],
    ] {
        let (force, moment) = aerodynamic_wrench(&plant, v, [0.0; 3]);
        assert!(force.into_iter().chain(moment).all(f64::is_finite), "{force:?} {moment:?} at {v:?}");
        assert!(Vector3::from(force).dot(&Vector3::from(v)) < 0.0, "drag opposes {v:?}: {force:?}");
    }
    // alpha = pi from behind, by the linear law of the moments and the law beyond stall of the lift.
    let (force, _) = aerodynamic_wrench(&plant, [-0.3, 0.0, 0.0], [0.0; 3]);
    let (f, _) = expected(&p, Vector3::new(-0.3, 0.0, 0.0), Vector3::zeros());
    assert!((Vector3::from(force) - f).amax() < 1e-14, "{force:?} against {f}");
}

#[test]
fn side_flow_without_axial_flow_pushes_like_the_limit_of_nearly_so() {
    // At u = w = 0 the lift has no direction; side force and drag keep theirs, in the limit of a vanishing u.
    let plant = plant(&everything(), Fidelity::STALLED);
    let (exact, _) = aerodynamic_wrench(&plant, [0.0, 0.3, 0.0], [0.0; 3]);
    let (near, _) = aerodynamic_wrench(&plant, [1e-9, 0.3, 0.0], [0.0; 3]);
    assert!((exact[1] - near[1]).abs() < 1e-8, "{exact:?} and {near:?}");
}

#[test]
fn tether_drag_has_its_closed_forms_and_approaches_the_integral() {
    let mut p = without_surfaces(rig());
    p.tether.drag_coefficient = 1.1;
    let plant = plant(&p, Fidelity::NUMERICAL);
    let per_length = 0.5 * 1000.0 * 3.0 * p.tether.line_diameter_m * 1.1;
    let (zenith, length) = (0.4_f64, 0.7_f64);
    let q = [zenith, 0.0, 0.2, length, 0.1, 0.0];
    // At rest in the flow: uniform normal velocity V cos Phi downstream, moment per_length (V cos Phi)² L²/2.
    let tau = generalized_forces(&plant, &q, &[0.0; 6], &Flow::straight(0.3));
    let moment = per_length * (0.3 * zenith.cos()).powi(2) * length * length / 2.0;
    assert!((tau[0] - moment).abs() < 1e-15, "{} against {moment}", tau[0]);
    assert!([tau[1], tau[2], tau[3], tau[4], tau[5]].iter().all(|t| t.abs() < 1e-15), "only Phi is driven: {tau}");
    // Swinging in still fluid: normal velocity s Phi', moment -per_length Phi'|Phi'| L⁴/4.
    let tau = generalized_forces(&plant, &q, &[-0.8, 0.0, 0.0, 0.0, 0.0, 0.0], &Flow::straight(0.0));
    let moment = per_length * 0.8 * 0.8 * length.powi(4) / 4.0;
    assert!((tau[0] - moment).abs() < 1e-14, "{} against {moment}", tau[0]);
    // Around the vertical: normal velocity s sin Phi Theta', arm s sin Phi.
    let tau = generalized_forces(&plant, &q, &[0.0, 0.9, 0.0, 0.0, 0.0, 0.0], &Flow::straight(0.0));
    let moment = -per_length * (0.9 * zenith.sin()).powi(2) * zenith.sin() * length.powi(4) / 4.0;
    assert!((tau[1] - moment).abs() < 1e-14, "{} against {moment}", tau[1]);
    // Reeling moves the lines along themselves.
    let tau = generalized_forces(&plant, &q, &[0.0, 0.0, 0.0, 0.2, 0.0, 0.0], &Flow::straight(0.0));
    assert!(tau.amax() < 1e-16, "reeling: {tau}");
    // Both at once: three points against a fine integral.
    let (rate, flow) = ([-0.3, 0.4, 0.0, 0.1, 0.0, 0.0], Flow { speed_m_s: 0.3, direction_rad: 0.5 });
    let tau = generalized_forces(&plant, &q, &rate, &flow);
    for (k, unit) in [[1.0, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0, 0.0, 0.0]].iter().enumerate() {
        let n = 2000;
        let exact: f64 = (0..n)
            .map(|i| {
                let s = (f64::from(i) + 0.5) / f64::from(n) * length;
                let e = oracle::direction(&q);
                let wind = oracle::flow_velocity(&flow) - e * rate[3] - s * oracle::direction_rate(&q, &rate);
                let across = wind - e * e.dot(&wind);
                per_length * across.norm() * across.dot(&oracle::direction_rate(&q, unit)) * s * length / f64::from(n)
            })
            .sum();
        assert!((tau[k] - exact).abs() < 1e-4 * exact.abs(), "row {k}: {} against {exact}", tau[k]);
    }
}
