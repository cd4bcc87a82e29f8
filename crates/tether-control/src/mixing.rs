//! From the three loops to the three lines, and back.

use serde::{Deserialize, Serialize};

/// Where the three lines leave the body: line 1 is the center one, line 2 starboard, line 3 port.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum TetherLayout {
    /// The center line is ahead of the other two, (13) and (14): a longer center line raises the nose.
    #[default]
    OneForwardTwoAft,
    /// The center line is behind the other two, Figure 14: a longer center line lowers the nose.
    TwoForwardOneAft,
}

/// The matrix A of `u = A v`, for one layout.
///
/// ```text
///     ⎡ 1  −σ   0 ⎤        u = [center, starboard, port], release speeds of the lines in m/s
/// A = ⎢ 1   σ   1 ⎥        v = [v_z, v_theta, v_phi], in m/s
///     ⎣ 1   σ  −1 ⎦        σ = 1 with one line forward, −1 with two
/// ```
///
/// The source gives σ = 1; σ = −1 is ours.
/// Whatever the layout, v_theta > 0 takes the nose down, v_phi > 0 the starboard side up, and v_z > 0 the whole
/// body up. The mean of the three lines moves at `v_z + σ v_theta/3`: turning the nose also moves the body.
///
/// Source: (13), (14).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mixing {
    pitch_sign: f64,
}

impl Mixing {
    /// The matrix for a layout.
    #[must_use]
    pub fn new(layout: TetherLayout) -> Self {
        Self {
            pitch_sign: match layout {
                TetherLayout::OneForwardTwoAft => 1.0,
                TetherLayout::TwoForwardOneAft => -1.0,
            },
        }
    }

    /// A, row by row.
    #[must_use]
    pub fn matrix(&self) -> [[f64; 3]; 3] {
        let sigma = self.pitch_sign;
        [[1.0, -sigma, 0.0], [1.0, sigma, 1.0], [1.0, sigma, -1.0]]
    }

    /// `u = A v`: the release speeds [center, starboard, port] for the loops' [v_z, v_theta, v_phi], all in m/s.
    #[inline]
    #[must_use]
    pub fn line_speeds_m_s(&self, loop_speeds_m_s: [f64; 3]) -> [f64; 3] {
        let [v_z, v_theta, v_phi] = loop_speeds_m_s;
        let turn = self.pitch_sign * v_theta;
        [v_z - turn, v_z + turn + v_phi, v_z + turn - v_phi]
    }

    /// `v = A⁻¹ u`: the loops' [v_z, v_theta, v_phi] that give the release speeds [center, starboard, port], all in m/s.
    #[inline]
    #[must_use]
    pub fn loop_speeds_m_s(&self, line_speeds_m_s: [f64; 3]) -> [f64; 3] {
        let [center, starboard, port] = line_speeds_m_s;
        let sides = 0.5 * (starboard + port);
        [0.5 * (sides + center), self.pitch_sign * 0.5 * (sides - center), 0.5 * (starboard - port)]
    }
}
