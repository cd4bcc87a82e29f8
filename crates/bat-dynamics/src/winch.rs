//! The winches: how fast the lines follow their commands, (3).

use crate::plant::Plant;
use crate::real::Real;

/// Accelerations of the three reels in m/s² at the speeds `reel` under held `commands`, both in m/s.
///
/// ```text
/// dl_i/dt = u_i
/// du_i/dt = (clamp(u_cmd,i, −u_max, u_max) − u_i) / tau_winch
/// ```
///
/// Lag and limit are ours.
///
/// Source: (3).
#[inline(always)]
pub(crate) fn reel_accelerations<T: Real>(plant: &Plant<T>, reel: [T; 3], commands: [T; 3]) -> [T; 3] {
    // In this order a command that is not a number stays one.
    let limited = |command: T| (-plant.reel_limit).max(plant.reel_limit.min(command));
    let pull = |command: T, speed: T| (limited(command) - speed) * plant.per_winch;
    [pull(commands[0], reel[0]), pull(commands[1], reel[1]), pull(commands[2], reel[2])]
}
