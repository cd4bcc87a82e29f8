//! Tensions of the lines, and what makes one slack.

use crate::kinematics::Pose;
use crate::plant::Plant;
use crate::real::Real;

/// Tension of each line in N: center, starboard, port.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tensions<T = f64> {
    /// Line 1.
    pub center_n: T,
    /// Line 2.
    pub starboard_n: T,
    /// Line 3.
    pub port_n: T,
}

/// A line that a tether model without slack cannot describe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slack {
    /// `center`, `starboard` or `port`.
    pub line: &'static str,
    /// The tension, negative, in N: how far the model is from where it holds.
    pub tension_n: f64,
}

impl Tensions {
    /// The lines by name.
    #[must_use]
    pub fn named(&self) -> [(&'static str, f64); 3] {
        [("center", self.center_n), ("starboard", self.starboard_n), ("port", self.port_n)]
    }

    /// The smallest of the three: the margin to slack.
    #[must_use]
    pub fn margin_n(&self) -> f64 {
        self.center_n.min(self.starboard_n).min(self.port_n)
    }

    /// The line with the most negative tension, if any is below zero.
    #[must_use]
    pub fn slack(&self) -> Option<Slack> {
        let (line, tension_n) =
            self.named().into_iter().fold(("center", f64::INFINITY), |a, b| if b.1 < a.1 { b } else { a });
        (tension_n < 0.0).then_some(Slack { line, tension_n })
    }
}

/// `T_i = −Σ_j (∂q_j/∂l_i) f_j` over the driven coordinates.
#[inline(always)]
pub(crate) fn tensions<T: Real>(plant: &Plant<T>, pose: &Pose<T>, supplied: [T; 3]) -> Tensions<T> {
    let pitch = plant.per_long * pose.cos_pitch * pose.cos_pitch * supplied[1];
    let roll = plant.per_lat * pose.cos_roll * pose.cos_roll * supplied[2];
    let mean = supplied[0] * T::constant(1.0 / 3.0);
    let aft = T::constant(0.5) * pitch - mean;
    Tensions { center_n: -(mean + pitch), starboard_n: aft + roll, port_n: aft - roll }
}
