//! From line lengths to the driven coordinates and back: equations (1), (2).

use crate::flow::Flow;
use crate::kinematics::{Pose, Rates};
use crate::plant::Plant;
use crate::real::Real;

/// The driven coordinates that follow from line lengths, (1), (2), their rates from (3), and their accelerations.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bridle<T> {
    pub(crate) length: T,
    pub(crate) length_rate: T,
    pub(crate) length_acceleration: T,
    pub(crate) pitch: Induced<T>,
    pub(crate) roll: Induced<T>,
}

/// One induced angle: sine and cosine, rate, acceleration, without an inverse tangent.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Induced<T> {
    sin: T,
    cos: T,
    pub(crate) rate: T,
    pub(crate) acceleration: T,
}

impl<T: Real> Induced<T> {
    /// From the tangent `a` of the angle and its first two derivatives.
    #[inline(always)]
    fn of_tangent(a: T, a_rate: T, a_acceleration: T) -> Self {
        let one = T::constant(1.0);
        let cos_squared = one / (one + a * a);
        let cos = cos_squared.sqrt();
        let rate = a_rate * cos_squared;
        Self {
            sin: a * cos,
            cos,
            rate,
            acceleration: a_acceleration * cos_squared - T::constant(2.0) * a * rate * rate,
        }
    }
}

/// Mean of the lines, and the tangents of induced pitch (2) and induced roll (1).
#[inline(always)]
fn differences<T: Real>(plant: &Plant<T>, lines: [T; 3]) -> (T, T, T) {
    let aft = lines[1] + lines[2];
    (
        (lines[0] + aft) * T::constant(1.0 / 3.0),
        (lines[0] - T::constant(0.5) * aft) * plant.per_long,
        (lines[2] - lines[1]) * plant.per_lat,
    )
}

/// The lines as long as they are where their winches say `lines`.
#[inline(always)]
fn true_lengths<T: Real>(plant: &Plant<T>, lines: [T; 3]) -> [T; 3] {
    [lines[0] + plant.line_center, lines[1] + plant.line_starboard, lines[2] + plant.line_port]
}

impl<T: Real> Bridle<T> {
    /// Lines as long as their winches say, unless `LOPSIDED`.
    #[inline(always)]
    pub(crate) fn of_lines<const LOPSIDED: bool>(
        plant: &Plant<T>,
        lines: [T; 3],
        reel: [T; 3],
        reel_acceleration: [T; 3],
    ) -> Self {
        let lines = if LOPSIDED { true_lengths(plant, lines) } else { lines };
        let (length, pitch, roll) = differences(plant, lines);
        let (length_rate, pitch_rate, roll_rate) = differences(plant, reel);
        let (length_acceleration, pitch_acceleration, roll_acceleration) = differences(plant, reel_acceleration);
        Self {
            length,
            length_rate,
            length_acceleration,
            pitch: Induced::of_tangent(pitch, pitch_rate, pitch_acceleration),
            roll: Induced::of_tangent(roll, roll_rate, roll_acceleration),
        }
    }

    /// The pose that these lines and the free coordinates give.
    #[inline(always)]
    pub(crate) fn pose(&self, free: [T; 3], flow: &Flow<T>) -> Pose<T> {
        Pose::new(
            self.length,
            free[0].sin_cos(),
            (free[1] - flow.direction_rad).sin_cos(),
            free[2].sin_cos(),
            (self.pitch.sin, self.pitch.cos),
            (self.roll.sin, self.roll.cos),
        )
    }

    #[inline(always)]
    pub(crate) fn rates(&self, free_rates: [T; 3]) -> Rates<T> {
        Rates {
            zenith: free_rates[0],
            azimuth: free_rates[1],
            twist: free_rates[2],
            length: self.length_rate,
            pitch: self.pitch.rate,
            roll: self.roll.rate,
        }
    }
}

/// The driven coordinates `[L_t, theta', phi']` of three line lengths `[l1, l2, l3]` in m.
///
/// ```text
/// phi'   = atan((l3 − l2) / l_lat)
/// theta' = atan(sigma (l1 − (l2 + l3)/2) / l_long)
/// ```
///
/// sigma is 1 with one line forward and −1 with two. Lengths are those of the winches: a line that is longer than its winch
/// says ([`Asymmetry`](crate::Asymmetry)) counts with its own length.
///
/// Source: (1), (2).
#[must_use]
pub fn driven_of_lines(plant: &Plant, lines_m: [f64; 3]) -> [f64; 3] {
    let lines_m = if plant.lopsided { true_lengths(plant, lines_m) } else { lines_m };
    let (length, pitch, roll) = differences(plant, lines_m);
    [length, pitch.atan(), roll.atan()]
}

/// The line lengths `[l1, l2, l3]` in m, as the winches say them, that give `[L_t, theta', phi']`: the inverse of (1), (2).
#[must_use]
pub fn lines_of_driven(plant: &Plant, driven: [f64; 3]) -> [f64; 3] {
    let [length, pitch, roll] = driven;
    // l1 − aft mean = a, l3 − l2 = b, mean = L.
    let a = pitch.tan() / plant.per_long;
    let b = roll.tan() / plant.per_lat;
    let aft = length - a / 3.0;
    let [center, starboard, port] = [length + 2.0 * a / 3.0, aft - 0.5 * b, aft + 0.5 * b];
    if plant.lopsided {
        return [center - plant.line_center, starboard - plant.line_starboard, port - plant.line_port];
    }
    [center, starboard, port]
}
