//! What a batch is going to run.

use design_space::Cell;
use serde::{Deserialize, Serialize};

/// The designs of a batch, as cells of the grid.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// One cell per experiment, in the order of their trials. A cell that comes again is a repeat.
    pub experiments: Vec<Cell>,
    /// One cell per simulation.
    pub simulations: Vec<Cell>,
}
