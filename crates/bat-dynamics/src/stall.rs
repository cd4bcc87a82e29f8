//! Lift beyond the stall angle: (58), (59).

use crate::plant::Plant;
use crate::real::Real;

/// The angle of attack that a linear lift curve must be given to follow (58), (59), with 2 α_stall carrying
/// the sign of α so that the curve is continuous and odd at both stall angles.
#[inline(always)]
pub(crate) fn effective_attack<T: Real>(attack: T, stall: T) -> T {
    let beyond = (T::constant(2.0) * stall).copysign(attack) - attack;
    stall.select_below(attack.abs(), beyond, attack)
}

/// Lift coefficients `[hull, horizontal stabilizer]`, each at the angle of attack `attack_rad` of that surface in rad.
///
/// Up to the stall angle this is the linear law, beyond it the law that falls; a plant of attached lift is linear
/// throughout. The incidence i_H of the stabilizer is not added: on a body at the angle alpha its coefficient is the
/// second entry at `alpha + i_H`.
///
/// Source: (58), (59).
/// Differs from the source: for negative angles the printed form jumps by 4 C_Lα α_stall at −α_stall; here 2 α_stall
/// carries the sign of α.
#[must_use]
pub fn lift_coefficients(plant: &Plant, attack_rad: f64) -> [f64; 2] {
    [
        plant.hull_cl0 + plant.hull_cla * effective_attack(attack_rad, plant.hull_stall),
        plant.fin_h_cl0 + plant.fin_h_cla * effective_attack(attack_rad, plant.fin_h_stall),
    ]
}
