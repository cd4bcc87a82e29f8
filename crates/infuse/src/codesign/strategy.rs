//! The order in which plant and controller are optimized.

use std::fmt;

use serde::{Deserialize, Serialize};

/// The order in which plant and controller parameters are optimized.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Strategy {
    /// The controller is optimized to the end at every step of the plant.
    #[default]
    Nested,
    /// All parameters at once, roles ignored.
    Simultaneous,
    /// The plant with the controller of the start, then the controller on that plant, once.
    Sequential,
    /// Plant and controller in turn until neither moves.
    Iterative,
}

impl fmt::Display for Strategy {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str(match self {
            Self::Nested => "nested",
            Self::Simultaneous => "simultaneous",
            Self::Sequential => "sequential",
            Self::Iterative => "iterative",
        })
    }
}
