//! Where the three lines leave the body.

use serde::{Deserialize, Serialize};

/// Where the three lines leave the body: line 1 is the center one, line 2 starboard, line 3 port.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum TetherLayout {
    /// The center line is ahead of the other two, (1) and (2): a longer center line raises the nose.
    #[default]
    OneForwardTwoAft,
    /// The center line is behind the other two, Figure 14: a longer center line lowers the nose.
    TwoForwardOneAft,
}

impl TetherLayout {
    /// Sign of the induced pitch: +1 where a longer line 1 raises the nose.
    pub(crate) fn pitch_sign(self) -> f64 {
        match self {
            Self::OneForwardTwoAft => 1.0,
            Self::TwoForwardOneAft => -1.0,
        }
    }
}
