//! Random plants and states: nothing becomes undefined, and still fluid gives nothing away.

use bat_dynamics::{
    Allowed, FIELDS, Fidelity, Flow, Parameters, Plant, evaluate, generalized_forces, kinetic_energy, potential_energy,
};

use crate::oracle::{self, fly};
use crate::plants::{Sample, rig};

/// A valid plant: every number of the rig times a factor, some at zero, hull moments as asked.
fn parameters(seed: u64, hull_moments: bool) -> Parameters {
    let mut sample = Sample(seed);
    let mut p = rig();
    for field in FIELDS {
        let value = (field.get)(&p);
        let factor = match field.allowed {
            Allowed::Positive | Allowed::AcuteAngle => sample.within(0.5, 2.0),
            Allowed::NonNegative if sample.within(0.0, 1.0) < 0.1 => 0.0,
            Allowed::NonNegative => sample.within(0.0, 3.0),
            Allowed::Finite | Allowed::ShortOfHalfTurn => sample.within(-2.0, 3.0),
        };
        (field.set)(&mut p, value * factor);
    }
    // Moments of inertia from second moments of mass: any three of them make a body.
    let [x, y, z] = sample.array(1e-5, 5e-4);
    (p.body.inertia_xx_kg_m2, p.body.inertia_yy_kg_m2, p.body.inertia_zz_kg_m2) = (y + z, z + x, x + y);
    p.body.inertia_xz_kg_m2 = sample.within(-0.99, 0.99) * f64::sqrt(x * z);
    p.horizontal_stabilizer.incidence_rad = sample.within(-0.3, 0.3);
    p.horizontal_stabilizer.lift_zero = sample.within(-0.3, 0.3);
    p.hull.pitch_moment_zero = sample.within(-0.1, 0.1);
    p.hull.pitch_moment_slope_per_rad = sample.within(-0.2, 0.2);
    if !hull_moments {
        p.hull.roll_moment_slope_per_rad = 0.0;
        p.hull.pitch_moment_zero = 0.0;
        p.hull.pitch_moment_slope_per_rad = 0.0;
        p.hull.yaw_moment_slope_per_rad = 0.0;
    }
    p
}

fn fidelity(choice: u64) -> Fidelity {
    [Fidelity::NUMERICAL, Fidelity::STALLED, Fidelity::ADDED_MASS, Fidelity::STALLED_WITH_ADDED_MASS]
        [(choice % 4) as usize]
}

#[test]
fn random_plants_never_give_nan() {
    for seed in 0..10_000 {
        let plant = Plant::new(&parameters(seed, true), fidelity(seed)).unwrap();
        let mut sample = Sample(seed ^ 1);
        let flow = Flow { speed_m_s: sample.within(0.0, 0.5), direction_rad: sample.within(-3.0, 3.0) };
        let at = evaluate(&plant, &sample.state(), sample.array(-0.05, 0.05), &flow);
        assert!(at.derivative.iter().all(|rate| rate.is_finite()), "seed {seed}: {:?}", at.derivative);
        assert!(at.tensions.named().iter().all(|line| line.1.is_finite()), "seed {seed}: {:?}", at.tensions);
    }
}

#[test]
fn still_fluid_never_supplies_power() {
    for seed in 0..10_000 {
        // Without added mass, whose energy still fluid does give back: the flights below count it.
        let plant = Plant::new(&parameters(seed, false), fidelity(seed % 2)).unwrap();
        let mut sample = Sample(seed ^ 2);
        let (q, rate) = (sample.coordinates(), sample.rates());
        let tau = generalized_forces(&plant, &q, &rate, &Flow::straight(0.0));
        let power: f64 = tau.iter().zip(rate).map(|(tau, rate)| tau * rate).sum();
        let size: f64 = tau.iter().zip(rate).map(|(tau, rate)| (tau * rate).abs()).sum();
        assert!(power <= 1e-14 * size, "seed {seed}: {power} W at {q:?}, {rate:?}");
    }
}

#[test]
fn flights_in_still_fluid_never_gain_energy() {
    for seed in 0..1000 {
        let p = parameters(seed, false);
        let plant = Plant::new(&p, fidelity(seed)).unwrap();
        let mut start = Sample(seed ^ 3).state();
        start[9..].fill(0.0);
        let energy = |state: &[f64; 12]| {
            let (q, rate) = oracle::coordinates(&p, state);
            kinetic_energy(&plant, &q, &rate) + potential_energy(&plant, &q)
        };
        // Small steps: the drag of attached lift at a right angle to the flow stops a light body within a millisecond.
        let end = fly(start, 5e-5, 200, |_, x| evaluate(&plant, x, [0.0; 3], &Flow::straight(0.0)).derivative);
        let gain = energy(&end) - energy(&start);
        assert!(gain <= 1e-8, "seed {seed}: {gain} J from {start:?} to {end:?}");
    }
}
