//! Equilibrium of a body whose sides differ: azimuth, twist and roll too, by Newton's method from the even equilibrium.

use nalgebra::{SMatrix, SVector};

use crate::bridle::{driven_of_lines, lines_of_driven};
use crate::coordinates::Coordinates;
use crate::error::{Error, NoTrim};
use crate::flow::Flow;
use crate::inertia::{generalized_forces, gravity_vector};
use crate::kinematics::Pose;
use crate::plant::Plant;

/// Which length the trim holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TrimHeight {
    /// Altitude of the center of mass above the winches, in m.
    Altitude(f64),
    /// Mean tether length L_t, in m.
    TetherLength(f64),
}

/// What the lines are to hold, beside the balance of the free rows.
pub(crate) enum Target {
    /// A pitch and a height, with starboard and port winch at the same length.
    Set {
        /// Pitch of the body.
        pitch_rad: f64,
        /// Height or length.
        height: TrimHeight,
    },
    /// Lengths as the winches say them.
    Lines {
        /// Center, starboard, port.
        lines_m: [f64; 3],
        /// Starboard less the mean of starboard and port.
        skew_m: f64,
    },
}

type Six = SVector<f64, 6>;

/// Steps by which the asymmetry is brought in where it does not work at once.
const SHARES: [usize; 3] = [1, 4, 16];
const MAX_ITERATIONS: usize = 40;
/// A step of the coordinates, in rad and m, for the slopes of the residual.
const STEP: f64 = 1e-6;
/// What may be left of a residual, relative to the lift times the length (the rows), in rad and in m.
const LEFT: f64 = 1e-11;

/// The coordinates at which `plant` rests, on the branch that begins at `start`, the equilibrium without the asymmetry.
///
/// # Errors
/// [`NoTrim::NoBalance`] where the branch ends before the whole asymmetry is there.
pub(crate) fn balance(plant: &Plant, flow: &Flow, target: &Target, start: Coordinates) -> Result<Coordinates, Error> {
    let mut left = f64::NAN;
    for steps in SHARES {
        let mut q = Six::from(start);
        let mut done = true;
        for step in 1..=steps {
            let share = step as f64 / steps as f64;
            match newton(&plant.with_asymmetry(share), flow, target, share, q) {
                Ok(found) => q = found,
                Err(size) => {
                    (done, left) = (false, size);
                    break;
                }
            }
        }
        if done {
            return Ok(q.into());
        }
    }
    Err(NoTrim::NoBalance { flow_speed_m_s: flow.speed_m_s, left }.into())
}

/// The root next to `q`, or the size of what is left of the residual.
fn newton(plant: &Plant, flow: &Flow, target: &Target, share: f64, mut q: Six) -> Result<Six, f64> {
    let mut size = f64::INFINITY;
    for _ in 0..MAX_ITERATIONS {
        let residual = residual(plant, flow, target, share, &q);
        let next = residual.amax();
        // At the root rounding is all that is left, and no step makes it smaller.
        if size < LEFT && next >= size {
            return Ok(q);
        }
        size = next;
        if size.is_nan() {
            return Err(size);
        }
        let mut slopes = SMatrix::<f64, 6, 6>::zeros();
        for k in 0..6 {
            let (mut more, mut less) = (q, q);
            more[k] += STEP;
            less[k] -= STEP;
            let difference =
                self::residual(plant, flow, target, share, &more) - self::residual(plant, flow, target, share, &less);
            slopes.set_column(k, &(difference / (2.0 * STEP)));
        }
        let step = slopes.lu().solve(&residual).ok_or(size)?;
        // No step of more than a few degrees or centimeters: a far root is another branch.
        q -= step * (0.1 / step.amax().max(0.1));
        if !(q[0] > 0.0 && q[0] < core::f64::consts::FRAC_PI_2 && q[3] > 0.0) {
            return Err(size);
        }
    }
    if size < LEFT { Ok(q) } else { Err(size) }
}

/// Rows of Phi, Theta and Psi over lift times length, then what the lines miss of the target.
fn residual(plant: &Plant, flow: &Flow, target: &Target, share: f64, q: &Six) -> Six {
    let q: Coordinates = (*q).into();
    let rows = generalized_forces(plant, &q, &[0.0; 6], flow) - gravity_vector(plant, &q);
    let scale = 1.0 / (plant.gravity * plant.displaced_mass * q[3].abs());
    let [zenith, azimuth, twist] = [rows[0] * scale, rows[1] * scale, rows[2] * scale];
    let missed = match *target {
        Target::Set { pitch_rad, height } => {
            let sight = Pose::of_coordinates(&q, flow).sight::<true>(plant);
            let above = match height {
                TrimHeight::Altitude(altitude_m) => sight.altitude_m - altitude_m,
                TrimHeight::TetherLength(length_m) => q[3] - length_m,
            };
            let [_, starboard, port] = lines_of_driven(plant, [q[3], q[4], q[5]]);
            [sight.pitch_rad - pitch_rad, above, starboard - port]
        }
        Target::Lines { lines_m: [center, starboard, port], skew_m } => {
            let eased = (1.0 - share) * skew_m;
            let driven = driven_of_lines(plant, [center, starboard - eased, port + eased]);
            [q[3] - driven[0], q[4] - driven[1], q[5] - driven[2]]
        }
    };
    Six::from([zenith, azimuth, twist, missed[0], missed[1], missed[2]])
}
