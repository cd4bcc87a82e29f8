//! One combination of levels.

use std::fmt;

use serde::{Deserialize, Serialize};

/// One combination of levels of a [`Grid`](crate::Grid), by its index: the last parameter varies fastest.
///
/// In a file it is its index.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Cell(u64);

impl Cell {
    /// The cell with this index; whether a grid has it is checked where the grid is asked.
    #[must_use]
    pub const fn new(index: u64) -> Self {
        Self(index)
    }

    /// The index, from 0.
    #[must_use]
    pub const fn index(self) -> u64 {
        self.0
    }
}

impl fmt::Display for Cell {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        self.0.fmt(formatter)
    }
}
