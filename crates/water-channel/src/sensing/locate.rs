//! From sightings to a pose: nonlinear least squares over all pixels.

use core::fmt;

use super::bundle::Bundle;
use super::normal_equations::NormalEquations;
use super::pose::{Attitude, Pose};
use super::triple::times;
use multiversion::multiversion;

/// With fewer dots than this in all there is no pose.
pub(crate) const FEWEST_DOTS: usize = 4;
/// A step shorter than this, in m and rad, is the last: the next one would be of the order of its square.
const LAST_STEP: f64 = 3e-6;
const MOST_STEPS: usize = 40;
/// The damping that follows the first step that does not lessen the sum of squares.
const FIRST_DAMPING: f64 = 1e-3;

/// Why there is no new pose, so that the last one is held.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hold {
    /// Three dots or fewer are seen by all cameras together.
    TooFewDots,
    /// The dots seen leave the pose open: all on a line, for example.
    Singular,
    /// No pose close to the last one fits: a dot would have to be behind its camera, or the steps do not end.
    NotConverged,
    /// Because of the delay no image has arrived yet; the pose is the one that the flight begins with.
    NoImageYet,
}

impl Hold {
    /// As the log has it: 1 to 4 in the order of the variants; 0 stands for a new pose.
    #[must_use]
    pub fn code(self) -> u8 {
        match self {
            Self::TooFewDots => 1,
            Self::Singular => 2,
            Self::NotConverged => 3,
            Self::NoImageYet => 4,
        }
    }
}

impl fmt::Display for Hold {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::TooFewDots => "three dots or fewer are seen",
            Self::Singular => "the dots seen leave the pose open",
            Self::NotConverged => "no pose near the last one fits the dots seen",
            Self::NoImageYet => "no image has arrived yet",
        })
    }
}

/// The pose that fits the sightings best, sought from `guess` by Gauss-Newton steps, damped (Levenberg-Marquardt) where one does
/// not lessen the sum of squares.
///
/// Compiled for several instruction sets, none of which contracts a product and a sum: all give the same bits.
#[multiversion(targets("x86_64+avx+avx2"))]
pub(crate) fn locate(bundles: &[Bundle], guess: &Pose) -> Result<Pose, Hold> {
    let (mut pose, mut attitude) = (*guess, guess.attitude());
    let mut sums = NormalEquations::new(bundles, &pose, &attitude).ok_or(Hold::NotConverged)?;
    let mut damping = 0.0;
    for _ in 0..MOST_STEPS {
        let step = sums.step(damping).ok_or(Hold::Singular)?;
        let next = moved(&pose, &attitude, &step).ok_or(Hold::Singular)?;
        if largest(&step) < LAST_STEP && damping <= FIRST_DAMPING {
            return Ok(next.usual());
        }
        let turned = next.attitude();
        match NormalEquations::new(bundles, &next, &turned) {
            Some(after) if after.cost() <= sums.cost() => {
                (pose, attitude, sums) = (next, turned, after);
                damping = if damping > FIRST_DAMPING { 0.1 * damping } else { 0.0 };
            }
            _ => damping = if damping > 0.0 { 10.0 * damping } else { FIRST_DAMPING },
        }
    }
    Err(Hold::NotConverged)
}

#[inline(always)]
fn largest(&[a, b, c, d, e, f]: &[f64; 6]) -> f64 {
    a.abs().max(b.abs()).max(c.abs()).max(d.abs()).max(e.abs()).max(f.abs())
}

/// The pose after a step of shifts and turns along G.
#[inline(always)]
fn moved(pose: &Pose, attitude: &Attitude, step: &[f64; 6]) -> Option<Pose> {
    let &[x, y, z, a, b, c] = step;
    Some(pose.moved([x, y, z], times(&attitude.angles_of_turn()?, [a, b, c])))
}
