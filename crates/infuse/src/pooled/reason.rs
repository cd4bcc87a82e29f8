//! Why an experiment is asked for.

use design_space::Cell;
use serde::{Deserialize, Serialize};

/// Why the loop asks for an experiment.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Reason {
    /// Nothing is known yet: all designs are to be seen, and those that the simulation likes.
    Start,
    /// It is expected to lower the best response most.
    Gain,
    /// It is expected to lower it most, but by next to nothing, as every other.
    Little,
    /// One who believes neither the simulation nor a trend knows least there of what may be best.
    Doubt,
    /// No run is near.
    Coverage,
    /// What was measured there is far from what all others say.
    Again,
    /// What was measured near it is far better than runs elsewhere say.
    Around,
    /// The noise was given, and hardly anything was run twice.
    Noise,
}

impl Reason {
    /// Whether it is the one that is expected to gain most.
    pub(crate) fn is_gain(self) -> bool {
        matches!(self, Self::Gain | Self::Little)
    }
}

/// An experiment that is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Pick {
    pub(crate) cell: Cell,
    pub(crate) reason: Reason,
}

impl Pick {
    pub(crate) fn cells(picks: &[Self]) -> Vec<Cell> {
        picks.iter().map(|pick| pick.cell).collect()
    }
}
