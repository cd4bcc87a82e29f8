//! Water that moves beside its mean flow: the same as another flow where there is one, and virtual work of the wake's force.

use bat_dynamics::{Disturbance, Fidelity, Flow, Plant, evaluate, evaluate_disturbed, mass_matrix, sight};
use nalgebra::{Matrix3, Vector3};

use crate::oracle;
use crate::plants::{Sample, everything};

fn plant() -> Plant {
    Plant::new(&everything(), Fidelity::STALLED_WITH_ADDED_MASS).unwrap()
}

#[test]
fn level_gust_is_a_flow_of_another_speed_and_direction() {
    let (mut sample, plant) = (Sample(71), plant());
    for _ in 0..300 {
        let (state, command) = (sample.state(), sample.array(-0.02, 0.02));
        let flow = Flow { speed_m_s: sample.within(0.15, 0.3), direction_rad: sample.within(-1.0, 1.0) };
        let [ahead, right] = sample.array(-0.05, 0.05);
        let gust = Disturbance { velocity_m_s: [ahead, right, 0.0], ..Disturbance::none() };
        let found = evaluate_disturbed(&plant, &state, command, &flow, &gust);
        // The flow comes from where it goes to, turned by half a turn.
        let (along, across) = (flow.speed_m_s - ahead, -right);
        let other = Flow { speed_m_s: along.hypot(across), direction_rad: flow.direction_rad + across.atan2(along) };
        let expected = evaluate(&plant, &state, command, &other);
        for (k, (a, b)) in expected.derivative.iter().zip(found.derivative).enumerate() {
            assert!((a - b).abs() < 1e-11 * a.abs().max(10.0), "rate {k}: {b} instead of {a}");
        }
        for ((line, a), (_, b)) in expected.tensions.named().iter().zip(found.tensions.named()) {
            assert!((a - b).abs() < 1e-12, "{line}: {b} N instead of {a} N");
        }
        let seen = sight(&plant, &state, &flow);
        assert_eq!(
            [found.sight.heading_rad, found.sight.right_m],
            [seen.heading_rad, seen.right_m],
            "seen from the mean flow"
        );
    }
}

#[test]
fn without_a_disturbance_nothing_changes() {
    let (mut sample, plant) = (Sample(72), plant());
    for _ in 0..100 {
        let (state, command) = (sample.state(), sample.array(-0.02, 0.02));
        let flow = Flow { speed_m_s: sample.within(0.15, 0.3), direction_rad: sample.within(-1.0, 1.0) };
        let [a, b] = [
            evaluate(&plant, &state, command, &flow),
            evaluate_disturbed(&plant, &state, command, &flow, &Disturbance::none()),
        ];
        for (k, (a, b)) in a.derivative.iter().zip(b.derivative).enumerate() {
            assert!((a - b).abs() <= 1e-12 * a.abs().max(10.0), "rate {k}: {a} and {b}");
        }
    }
}

/// Rising water carries the fluid forces of a body that sinks: with the tether's drag off, they depend on the motion relative to
/// the water alone.
#[test]
fn rising_water_acts_like_a_sinking_body() {
    let mut sample = Sample(73);
    let mut p = everything();
    p.tether.drag_coefficient = 0.0;
    let plant = Plant::new(&p, Fidelity::STALLED).unwrap();
    for _ in 0..100 {
        let (state, flow) = (sample.state(), Flow { speed_m_s: 0.25, direction_rad: sample.within(-1.0, 1.0) });
        let (q, rate) = oracle::coordinates(&p, &state);
        let down = sample.within(-0.05, 0.05);
        let gust = Disturbance { velocity_m_s: [0.0, 0.0, down], ..Disturbance::none() };
        let [still, moved] = [Disturbance::none(), gust].map(|d| {
            Vector3::from_column_slice(&evaluate_disturbed(&plant, &state, [0.0; 3], &flow, &d).derivative[3..6])
        });
        // Virtual work of what the fluid forces change, from vectors of the ground frame.
        let r = oracle::rotation(&q);
        let omega = oracle::angular_velocity(&q, &rate);
        let water = oracle::flow_velocity(&flow);
        let forces = [water, water + Vector3::new(0.0, 0.0, down)].map(|water| {
            let relative = r.transpose() * (oracle::velocity(&q, &rate, Vector3::zeros()) - water);
            oracle::aerodynamics(&p, relative, omega)
        });
        let unit = |k: usize| core::array::from_fn(|i| if i == k { 1.0 } else { 0.0 });
        let work = Vector3::from_fn(|k, _| {
            let on = |(forces, moment): &([Vector3<f64>; 3], Vector3<f64>)| {
                let at = oracle::centers(&p).into_iter().zip(forces);
                at.map(|(at, f)| oracle::velocity(&q, &unit(k), at).dot(&(r * f))).sum::<f64>()
                    + oracle::angular_velocity(&q, &unit(k)).dot(moment)
            };
            on(&forces[1]) - on(&forces[0])
        });
        let d = mass_matrix(&plant, &q);
        let d: Matrix3<f64> = d.fixed_view::<3, 3>(0, 0).into_owned();
        let expected = d.lu().solve(&work).unwrap();
        assert!((moved - still - expected).amax() < 1e-9 * expected.amax().max(1.0), "{} at {state:?}", moved - still);
    }
}

#[test]
fn wake_does_the_work_of_its_force_at_the_center_of_buoyancy() {
    let (mut sample, p, plant) = (Sample(74), everything(), plant());
    for _ in 0..100 {
        let (state, flow) = (sample.state(), Flow { speed_m_s: 0.25, direction_rad: sample.within(-1.0, 1.0) });
        let (q, _) = oracle::coordinates(&p, &state);
        let wake: [f64; 3] = sample.array(-0.05, 0.05);
        let pushed = Disturbance { wake_m2_s2: wake, ..Disturbance::none() };
        let [still, moved] = [Disturbance::none(), pushed].map(|d| {
            Vector3::from_column_slice(&evaluate_disturbed(&plant, &state, [0.0; 3], &flow, &d).derivative[3..6])
        });
        let (s, c) = flow.direction_rad.sin_cos();
        let in_ground = Vector3::new(c * wake[0] - s * wake[1], s * wake[0] + c * wake[1], wake[2]);
        let force = 0.5 * p.fluid.density_kg_m3 * p.hull.area_m2 * in_ground;
        let center = oracle::point(&p, p.body.center_of_buoyancy_x, p.body.center_of_buoyancy_height_m);
        let unit = |k: usize| core::array::from_fn(|i| if i == k { 1.0 } else { 0.0 });
        let work = Vector3::from_fn(|k, _| oracle::velocity(&q, &unit(k), center).dot(&force));
        let d = mass_matrix(&plant, &q);
        let d: Matrix3<f64> = d.fixed_view::<3, 3>(0, 0).into_owned();
        let expected = d.lu().solve(&work).unwrap();
        assert!((moved - still - expected).amax() < 1e-9 * expected.amax().max(1.0), "{} at {state:?}", moved - still);
    }
}
