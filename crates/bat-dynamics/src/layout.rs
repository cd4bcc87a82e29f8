//! Where the three lines leave the body.

use serde::{Deserialize, Serialize};

/// Where the single line of the pair-and-single arrangement sits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum TetherLayout {
    /// Line 1 forward in the middle, lines 2 (starboard) and 3 (port) aft: equations (1), (2).
    #[default]
    OneForwardTwoAft,
    /// Line 1 aft in the middle, lines 2 and 3 forward (Figure 14): the induced pitch changes sign.
    TwoForwardOneAft,
}

impl TetherLayout {
    /// Sign of the induced pitch: +1 where a longer line 1 raises the nose.
    #[must_use]
    pub fn pitch_sign(self) -> f64 {
        match self {
            Self::OneForwardTwoAft => 1.0,
            Self::TwoForwardOneAft => -1.0,
        }
    }
}
