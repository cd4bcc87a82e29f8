//! The scalars: trigonometry without branches, lanes, dual numbers.

use bat_dynamics::{Evaluation, Fidelity, Flow, LANES, Lanes, Plant, Real, evaluate, sight};
use core::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};
use num_dual::Dual64;

use crate::oracle;
use crate::plants::{Sample, everything};

fn sin_cos(x: f64) -> (f64, f64) {
    Real::sin_cos(x)
}

fn atan2(y: f64, x: f64) -> f64 {
    Real::atan2(y, x)
}

#[track_caller]
fn check_sin_cos(x: f64) {
    let (sin, cos) = sin_cos(x);
    // Half a unit in the last place of 1 for the result, and as much for the reference.
    assert!((sin - x.sin()).abs() <= 2.3e-16, "sin({x:e}) = {sin:e}, the platform's {:e}", x.sin());
    assert!((cos - x.cos()).abs() <= 2.3e-16, "cos({x:e}) = {cos:e}, the platform's {:e}", x.cos());
}

#[test]
fn sine_and_cosine_are_accurate_everywhere_and_at_the_edges_of_the_quadrants() {
    let mut sample = Sample(51);
    for _ in 0..200_000 {
        check_sin_cos(sample.within(-8.0, 8.0));
        check_sin_cos(sample.within(-1e5, 1e5));
    }
    for k in -4000..4000 {
        // Multiples of pi/4 in both directions by up to three neighbors: where the reduction changes its quadrant.
        let edge = f64::from(k) * FRAC_PI_4;
        let (mut below, mut above) = (edge, edge);
        for _ in 0..4 {
            check_sin_cos(below);
            check_sin_cos(above);
            (below, above) = (below.next_down(), above.next_up());
        }
    }
}

#[test]
fn sine_and_cosine_keep_their_digits_near_their_zeros() {
    for k in 1..30_000 {
        let (x, half) = (f64::from(k) * PI, (f64::from(k) - 0.5) * PI);
        let (sin, cos) = (sin_cos(x).0, sin_cos(half).1);
        assert!((sin - x.sin()).abs() <= 4.0 * f64::EPSILON * sin.abs(), "sin({x}) = {sin:e}, {:e}", x.sin());
        assert!((cos - half.cos()).abs() <= 4.0 * f64::EPSILON * cos.abs(), "cos({half}) = {cos:e}, {:e}", half.cos());
    }
}

#[test]
fn sine_is_odd_and_small_angles_are_exact() {
    assert_eq!((sin_cos(0.0), sin_cos(-0.0)), ((0.0, 1.0), (0.0, 1.0)));
    for x in [5e-324, 1e-310, 1e-200, 1e-9] {
        assert_eq!(sin_cos(x), (x, 1.0), "at {x:e}");
        assert_eq!(sin_cos(-x).0.to_bits(), (-x).to_bits(), "at {:e}", -x);
    }
    let mut sample = Sample(52);
    for _ in 0..10_000 {
        let x = sample.within(0.0, 100.0);
        let ((sin, cos), (sin_other, cos_other)) = (sin_cos(x), sin_cos(-x));
        assert_eq!((sin_other.to_bits(), cos_other.to_bits()), ((-sin).to_bits(), cos.to_bits()), "at {x}");
    }
}

#[test]
fn angles_that_are_not_finite_have_no_sine() {
    for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let (sin, cos) = sin_cos(x);
        assert!(sin.is_nan() && cos.is_nan(), "{sin}, {cos} at {x}");
    }
}

#[track_caller]
fn check_atan2(y: f64, x: f64) {
    let (found, expected) = (atan2(y, x), y.atan2(x));
    assert!(
        (found - expected).abs() <= 3.0 * f64::EPSILON * expected.abs(),
        "atan2({y:e}, {x:e}) = {found:e}, {expected:e}"
    );
}

#[test]
fn arc_tangent_is_accurate_in_every_octant_and_on_the_axes() {
    let mut sample = Sample(53);
    for _ in 0..200_000 {
        check_atan2(sample.within(-1.0, 1.0), sample.within(-1.0, 1.0));
        let scale = sample.within(-300.0, 300.0);
        check_atan2(sample.within(-1.0, 1.0) * 10f64.powf(scale), sample.within(-1.0, 1.0) * 10f64.powf(scale * 0.9));
    }
    // The ray at which the polynomial's argument is cut, tan(pi/8), and the diagonals.
    for ratio in [0.414_213_562_373_095, 0.414_213_562_373_095_1, 1.0, 1.0_f64.next_up(), 1.0_f64.next_down()] {
        for (y, x) in [(ratio, 1.0), (-ratio, 1.0), (ratio, -1.0), (-ratio, -1.0)] {
            check_atan2(y, x);
            check_atan2(x, y);
        }
    }
    for (y, x, angle) in [
        (0.0, 1.0, 0.0),
        (0.0, -1.0, PI),
        (-0.0, -1.0, -PI),
        (1.0, 0.0, FRAC_PI_2),
        (-1.0, 0.0, -FRAC_PI_2),
        (1.0, 1.0, FRAC_PI_4),
        (0.0, 0.0, 0.0),
        (-0.0, 1.0, -0.0),
    ] {
        assert_eq!(atan2(y, x).to_bits(), f64::to_bits(angle), "atan2({y}, {x}) = {}", atan2(y, x));
    }
}

#[test]
fn selection_takes_the_other_where_a_comparison_fails() {
    assert_eq!(Real::min(1.0_f64, 2.0), 1.0);
    assert_eq!(Real::max(1.0_f64, 2.0), 2.0);
    assert_eq!(Real::min(f64::NAN, 2.0), 2.0);
    assert_eq!(Real::max(f64::NAN, 2.0), 2.0);
    assert!(Real::min(2.0, f64::NAN).is_nan() && Real::max(2.0, f64::NAN).is_nan(), "the other one");
    assert_eq!(1.0_f64.select_below(1.0, 5.0, 6.0), 6.0, "equal is not below");
}

#[test]
fn dual_numbers_carry_the_derivative_of_every_function() {
    let mut sample = Sample(55);
    for _ in 0..200 {
        let (x, y) = (sample.within(-0.9, 0.9), sample.within(0.1, 2.0));
        let dual = |value| Dual64::new(value, 1.0);
        let check = |name: &str, found: Dual64, f: &dyn Fn(f64) -> f64| {
            let expected = oracle::slope(1e-3, f);
            assert!((found.re - f(0.0)).abs() < 1e-15, "{name} at {x}, {y}");
            assert!((found.eps - expected).abs() < 1e-10, "{name} at {x}, {y}: {} against {expected}", found.eps);
        };
        check("sin", Real::sin_cos(dual(x)).0, &|t| (x + t).sin());
        check("cos", Real::sin_cos(dual(x)).1, &|t| (x + t).cos());
        check("sqrt", Real::sqrt(dual(y + 1.0)), &|t| (y + 1.0 + t).sqrt());
        check("atan2 by y", Real::atan2(dual(x), Dual64::constant(y)), &|t| (x + t).atan2(y));
        check("atan2 by x", Real::atan2(Dual64::constant(x), dual(y)), &|t| x.atan2(y + t));
    }
    let one = |value| Dual64::new(value, 1.0);
    assert_eq!(Real::abs(one(-2.0)), Dual64::new(2.0, -1.0));
    assert_eq!(Real::copysign(one(2.0), Dual64::constant(-1.0)), Dual64::new(-2.0, -1.0));
    assert_eq!(Real::min(one(1.0), Dual64::constant(2.0)), one(1.0));
    assert_eq!(Real::max(one(1.0), Dual64::constant(2.0)), Dual64::constant(2.0));
}

/// Four flights of four plants in lanes give the bits of the four flights alone.
#[test]
fn lanes_equal_scalar_bit_for_bit() {
    const FIDELITIES: [Fidelity; 4] =
        [Fidelity::NUMERICAL, Fidelity::STALLED, Fidelity::ADDED_MASS, Fidelity::STALLED_WITH_ADDED_MASS];
    let mut sample = Sample(56);
    for case in 0..2000 {
        let plants: [Plant; LANES] = core::array::from_fn(|i| {
            let mut p = everything();
            p.body.mass_kg = sample.within(0.1, 0.2);
            p.horizontal_stabilizer.area_factor = sample.within(0.0, 2.0);
            p.horizontal_stabilizer.incidence_rad = sample.within(-0.1, 0.1);
            p.vertical_stabilizer.area_factor = sample.within(0.0, 2.0);
            Plant::new(&p, FIDELITIES[(case + i) % 4]).unwrap()
        });
        let states: [[f64; 12]; LANES] = core::array::from_fn(|_| sample.state());
        let commands: [[f64; 3]; LANES] = core::array::from_fn(|_| sample.array(-0.02, 0.02));
        let flows: [Flow; LANES] = core::array::from_fn(|_| Flow {
            speed_m_s: sample.within(0.0, 0.5),
            direction_rad: sample.within(-1.5, 1.5),
        });
        let plant = Plant::gather(plants.each_ref());
        let state: [Lanes; 12] = core::array::from_fn(|k| Lanes(states.map(|state| state[k])));
        let command: [Lanes; 3] = core::array::from_fn(|k| Lanes(commands.map(|command| command[k])));
        let flow =
            Flow { speed_m_s: Lanes(flows.map(|f| f.speed_m_s)), direction_rad: Lanes(flows.map(|f| f.direction_rad)) };
        let together = numbers(&evaluate(&plant, &state, command, &flow));
        let seen = sight(&plant, &state, &flow);
        for i in 0..LANES {
            let alone = evaluate(&plants[i], &states[i], commands[i], &flows[i]);
            for (k, (wide, alone)) in together.iter().zip(numbers(&alone)).enumerate() {
                assert_eq!(wide.0[i].to_bits(), alone.to_bits(), "case {case}, lane {i}, number {k}");
            }
            assert_eq!(sight(&plants[i], &states[i], &flows[i]), alone.sight, "case {case}: the sight by itself");
            assert_eq!(seen.heading_rad.0[i].to_bits(), alone.sight.heading_rad.to_bits(), "case {case}, lane {i}");
        }
    }
}

/// Everything that an evaluation holds.
fn numbers<T: Real>(at: &Evaluation<T>) -> Vec<T> {
    let (t, s) = (at.tensions, at.sight);
    let rest = [
        t.center_n,
        t.starboard_n,
        t.port_n,
        s.forward_m,
        s.right_m,
        s.altitude_m,
        s.roll_rad,
        s.pitch_rad,
        s.heading_rad,
    ];
    at.derivative.into_iter().chain(rest).collect()
}

#[test]
fn cast_plant_has_the_same_numbers_in_every_lane() {
    let plant = Plant::new(&everything(), Fidelity::STALLED).unwrap();
    assert_eq!(plant.cast::<Lanes>(), Plant::gather([&plant; LANES]));
    let flow = Flow { speed_m_s: 0.2, direction_rad: 0.3 };
    assert_eq!(flow.cast::<Lanes>().direction_rad, Lanes([0.3; LANES]));
}
