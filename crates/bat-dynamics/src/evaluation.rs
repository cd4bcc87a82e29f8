//! The right-hand side of a flight: lines, winches, motion and tensions together.

use crate::bridle::Bridle;
use crate::coordinates::FlightState;
use crate::disturbance::Disturbance;
use crate::flow::Flow;
use crate::kinematics::{Driven, Sight};
use crate::motion::solve_motion;
use crate::plant::Plant;
use crate::real::Real;
use crate::tensions::{Tensions, tensions};
use crate::winch::reel_accelerations;

/// Derivative of a flight state under held winch commands_m_s, and what a camera sees at that state.
#[derive(Clone, Copy, Debug)]
pub struct Evaluation<T = f64> {
    /// Time derivative of the state.
    pub derivative: FlightState<T>,
    /// Position and attitude seen from the flow's direction.
    pub sight: Sight<T>,
    /// Line tensions in N.
    pub tensions: Tensions<T>,
}

/// The right-hand side of a flight: equation (4) with the winches (3).
///
/// `commands_m_s` are the commanded reel speeds, in the order center, starboard, port. Nothing is checked
/// here: a state that leaves the model gives non-finite numbers, which [`check_state`](crate::check_state) names.
#[inline(always)]
pub fn evaluate<T: Real>(
    plant: &Plant<T>,
    state: &FlightState<T>,
    commands_m_s: [T; 3],
    flow: &Flow<T>,
) -> Evaluation<T> {
    let none = Disturbance::none();
    if plant.lopsided {
        evaluate_with::<T, true, false>(plant, state, commands_m_s, flow, &none)
    } else {
        evaluate_with::<T, false, false>(plant, state, commands_m_s, flow, &none)
    }
}

/// [`evaluate`] in water that moves beside its mean flow.
///
/// The velocity of the disturbance adds to that of the flow wherever the flow acts; heading and position stay those relative to
/// the direction of the mean flow. The wake's force acts at the center of buoyancy. Like the flow the disturbance is taken as
/// steady at each instant.
#[inline(always)]
pub fn evaluate_disturbed<T: Real>(
    plant: &Plant<T>,
    state: &FlightState<T>,
    commands_m_s: [T; 3],
    flow: &Flow<T>,
    disturbance: &Disturbance<T>,
) -> Evaluation<T> {
    if plant.lopsided {
        evaluate_with::<T, true, true>(plant, state, commands_m_s, flow, disturbance)
    } else {
        evaluate_with::<T, false, true>(plant, state, commands_m_s, flow, disturbance)
    }
}

/// [`evaluate_disturbed`] for a loop that knows beforehand what it flies, so that it carries no other code.
///
/// Without `LOPSIDED` what the plant has of [`Asymmetry`](crate::Asymmetry) is left out, without `MOVING` the disturbance;
/// where there is none of it, the bits are those of [`evaluate`].
#[inline(always)]
pub fn evaluate_with<T: Real, const LOPSIDED: bool, const MOVING: bool>(
    plant: &Plant<T>,
    state: &FlightState<T>,
    commands_m_s: [T; 3],
    flow: &Flow<T>,
    disturbance: &Disturbance<T>,
) -> Evaluation<T> {
    let &[zenith, azimuth, twist, zenith_rate, azimuth_rate, twist_rate, l1, l2, l3, u1, u2, u3] = state;
    let reel = [u1, u2, u3];
    let reel_acceleration = reel_accelerations(plant, reel, commands_m_s);
    let bridle = Bridle::of_lines::<LOPSIDED>(plant, [l1, l2, l3], reel, reel_acceleration);
    let pose = bridle.pose([zenith, azimuth, twist], flow);
    let rates = bridle.rates([zenith_rate, azimuth_rate, twist_rate]);
    let driven =
        Driven { length: bridle.length_acceleration, pitch: bridle.pitch.acceleration, roll: bridle.roll.acceleration };
    let motion = solve_motion::<T, LOPSIDED, MOVING>(plant, &pose, &rates, &driven, flow.speed_m_s, disturbance);
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
        sight: pose.sight::<LOPSIDED>(plant),
        tensions: tensions(plant, &pose, motion.supplied),
    }
}

/// What a camera sees of a flight state, without the dynamics of [`evaluate`].
#[inline(always)]
#[must_use]
pub fn sight<T: Real>(plant: &Plant<T>, state: &FlightState<T>, flow: &Flow<T>) -> Sight<T> {
    if plant.lopsided { sight_with::<T, true>(plant, state, flow) } else { sight_with::<T, false>(plant, state, flow) }
}

#[inline(always)]
fn sight_with<T: Real, const LOPSIDED: bool>(plant: &Plant<T>, state: &FlightState<T>, flow: &Flow<T>) -> Sight<T> {
    let zero = [T::constant(0.0); 3];
    let bridle = Bridle::of_lines::<LOPSIDED>(plant, [state[6], state[7], state[8]], zero, zero);
    bridle.pose([state[0], state[1], state[2]], flow).sight::<LOPSIDED>(plant)
}
