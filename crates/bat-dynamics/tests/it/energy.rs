//! What is conserved, what is lost and what is supplied along a flight.

use bat_dynamics::{
    Fidelity, FlightState, Flow, Parameters, Plant, Tensions, aerodynamic_wrench, evaluate, generalized_forces,
    kinetic_energy, mass_matrix, potential_energy,
};
use nalgebra::Vector3;

use crate::oracle::{self, fly};
use crate::plants::{Sample, everything, without_surfaces};

/// Swinging on every free coordinate, fast enough around the vertical to keep away from it; lines at rest.
const SWINGING: FlightState = [0.45, 0.2, 0.3, 0.3, 1.6, -0.4, 0.612, 0.603, 0.608, 0.0, 0.0, 0.0];

fn energy(p: &Parameters, plant: &Plant, state: &FlightState) -> f64 {
    let (q, rate) = oracle::coordinates(p, state);
    kinetic_energy(plant, &q, &rate) + potential_energy(plant, &q)
}

/// Largest departure of `quantity` from its start over `duration_s`, and the state reached.
fn drift(
    start: FlightState,
    step_s: f64,
    duration_s: f64,
    rate: impl Fn(f64, &FlightState) -> FlightState,
    quantity: impl Fn(&FlightState) -> f64,
) -> f64 {
    let (mut state, mut worst) = (start, 0.0_f64);
    for step in 0..(duration_s / step_s).round() as usize {
        let from = step as f64 * step_s;
        state = fly(state, step_s, 1, |t, x| rate(from + t, x));
        worst = worst.max((quantity(&state) - quantity(&start)).abs());
    }
    worst
}

#[test]
fn energy_is_conserved_in_still_fluid_without_surfaces() {
    for fidelity in [Fidelity::NUMERICAL, Fidelity::ADDED_MASS] {
        let p = without_surfaces(everything());
        let plant = Plant::new(&p, fidelity).unwrap();
        let rate = |_: f64, x: &FlightState| evaluate(&plant, x, [0.0; 3], &Flow::straight(0.0)).derivative;
        let [coarse, middle, fine] =
            [0.04, 0.02, 0.01].map(|step_s| drift(SWINGING, step_s, 20.0, rate, |x| energy(&p, &plant, x)));
        for order in [(coarse / middle).log2(), (middle / fine).log2()] {
            assert!((3.7..5.3).contains(&order), "the drift falls with order {order}: {coarse} {middle} {fine}");
        }
        let finest = drift(SWINGING, 5e-4, 20.0, rate, |x| energy(&p, &plant, x));
        assert!(finest < 1e-11, "energy drifts by {finest} J");
    }
}

#[test]
fn steady_flow_conserves_the_jacobi_integral_of_the_added_mass() {
    // T_2 - T_0 + V with T_0 the energy of the added mass in the flow that passes a body at rest: its change is the
    // Munk moment and the forces of the flow on a turning body.
    let p = without_surfaces(everything());
    let plant = Plant::new(&p, Fidelity::ADDED_MASS).unwrap();
    let flow = Flow { speed_m_s: 0.4, direction_rad: 0.3 };
    let integral = |x: &FlightState| {
        let (q, _) = oracle::coordinates(&p, x);
        let passing = oracle::rotation(&q).transpose() * oracle::flow_velocity(&flow);
        let a = &p.added_mass;
        let at_rest = 0.5 * Vector3::new(a.x_kg, a.y_kg, a.z_kg).component_mul(&passing).dot(&passing);
        energy(&p, &plant, x) - at_rest
    };
    let rate = |_: f64, x: &FlightState| evaluate(&plant, x, [0.0; 3], &flow).derivative;
    let found = drift(SWINGING, 2.5e-4, 5.0, rate, integral);
    assert!(found < 1e-11, "the integral drifts by {found} J");
    let alone = drift(SWINGING, 2.5e-4, 5.0, rate, |x| energy(&p, &plant, x));
    assert!(alone > 1e-4, "the flow's part matters in this case: {alone} J");
}

#[test]
fn power_of_fluid_and_winches_is_the_rate_of_energy() {
    for fidelity in [Fidelity::NUMERICAL, Fidelity::STALLED_WITH_ADDED_MASS] {
        let p = everything();
        let plant = Plant::new(&p, fidelity).unwrap();
        let flow = |t: f64| Flow { speed_m_s: 0.25 + 0.1 * (1.3 * t).sin(), direction_rad: 0.2 * (0.7 * t).cos() };
        let command = |t: f64| [0.01 * (2.0 * t).sin(), 0.008 * (3.0 * t).cos(), -0.006 * (1.5 * t).sin()];
        // A gentle start: with the flow from behind the attached lift law jumps from pi to -pi.
        let start = [0.3, 0.1, 0.05, 0.2, 0.2, 0.1, 0.612, 0.603, 0.608, 0.0, 0.0, 0.0, 0.0];
        let first = energy(&p, &plant, start[..12].try_into().unwrap());
        let end = fly(start, 1e-3, 5000, |t, x| {
            let state: FlightState = x[..12].try_into().unwrap();
            let at = evaluate(&plant, &state, command(t), &flow(t));
            let (q, rate) = oracle::coordinates(&p, &state);
            let fluid: f64 =
                generalized_forces(&plant, &q, &rate, &flow(t)).iter().zip(rate).map(|(tau, q)| tau * q).sum();
            // A line that is paid out under tension takes energy out of the body.
            let Tensions { center_n, starboard_n, port_n } = at.tensions;
            let winches = -(center_n * state[9] + starboard_n * state[10] + port_n * state[11]);
            let mut derivative = [0.0; 13];
            derivative[..12].copy_from_slice(&at.derivative);
            derivative[12] = fluid + winches;
            derivative
        });
        let change = energy(&p, &plant, end[..12].try_into().unwrap()) - first;
        assert!(change.abs() > 1e-3, "the case exchanges energy: {change} J");
        assert!((change - end[12]).abs() < 1e-8 * change.abs(), "energy {change} J, work {} J", end[12]);
    }
}

#[test]
fn fluid_at_rest_takes_the_power_of_drag_and_of_nothing_else() {
    // Lift and side force are normal to the motion of their own center: what is left is the drag of each component.
    let mut p = everything();
    p.hull.roll_moment_slope_per_rad = 0.0;
    p.hull.pitch_moment_zero = 0.0;
    p.hull.pitch_moment_slope_per_rad = 0.0;
    p.hull.yaw_moment_slope_per_rad = 0.0;
    let plant = Plant::new(&p, Fidelity::STALLED).unwrap();
    let mut sample = Sample(11);
    for _ in 0..500 {
        let (v, omega): ([f64; 3], [f64; 3]) = (sample.array(-0.5, 0.5), sample.array(-2.0, 2.0));
        let (v, omega) = (Vector3::from(v), Vector3::from(omega));
        let (force, moment) = aerodynamic_wrench(&plant, v.into(), omega.into());
        let found = Vector3::from(force).dot(&v) + Vector3::from(moment).dot(&omega);
        let (forces, _) = oracle::aerodynamics(&p, v, omega);
        let expected: f64 = oracle::centers(&p)
            .iter()
            .zip(forces)
            .map(|(at, force)| {
                let local = v + omega.cross(at);
                assert!(force.dot(&local) <= 0.0, "a component feeds on still fluid");
                force.dot(&local)
            })
            .sum();
        assert!(found <= 0.0, "still fluid supplies {found} W");
        assert!((found - expected).abs() < 1e-13 * expected.abs().max(1e-2), "{found} W against {expected} W");
    }
}

#[test]
fn energy_falls_without_a_break_in_still_fluid() {
    let mut p = everything();
    p.hull.roll_moment_slope_per_rad = 0.0;
    p.hull.pitch_moment_zero = 0.0;
    p.hull.pitch_moment_slope_per_rad = 0.0;
    p.hull.yaw_moment_slope_per_rad = 0.0;
    for fidelity in [Fidelity::NUMERICAL, Fidelity::STALLED_WITH_ADDED_MASS] {
        let plant = Plant::new(&p, fidelity).unwrap();
        let rate = |_: f64, x: &FlightState| evaluate(&plant, x, [0.0; 3], &Flow::straight(0.0)).derivative;
        let (mut state, mut last) = (SWINGING, energy(&p, &plant, &SWINGING));
        for step in 0..4000 {
            state = fly(state, 1e-3, 1, rate);
            let now = energy(&p, &plant, &state);
            assert!(now < last + 1e-12, "step {step}: {last} J, then {now} J");
            last = now;
        }
    }
}

#[test]
fn angular_momentum_about_the_vertical_is_conserved_also_while_reeling() {
    for fidelity in [Fidelity::NUMERICAL, Fidelity::ADDED_MASS] {
        let p = without_surfaces(everything());
        let plant = Plant::new(&p, fidelity).unwrap();
        let momentum = |x: &FlightState| {
            let (q, rate) = oracle::coordinates(&p, x);
            mass_matrix(&plant, &q).row(1).iter().zip(rate).map(|(d, q)| d * q).sum::<f64>()
        };
        let rate = |t: f64, x: &FlightState| {
            evaluate(&plant, x, [0.01, 0.01 * (3.0 * t).sin(), -0.01 * t.cos()], &Flow::straight(0.0)).derivative
        };
        let found = drift(SWINGING, 1e-3, 10.0, rate, momentum);
        assert!(
            found < 1e-10 * momentum(&SWINGING),
            "angular momentum {} drifts by {found} N·m·s",
            momentum(&SWINGING)
        );
    }
}
