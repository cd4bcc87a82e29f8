//! The order in which plant and controller are optimized.

use std::fmt;

use serde::{Deserialize, Serialize};

/// The order in which plant and controller parameters are optimized, each search by BOBYQA in coded coordinates.
///
/// What they find in two parameters, coded from −1 to 1, with default settings, in numbers of simulations; `tests/it/strategies.rs` asserts them:
///
/// | problem, start | nested | simultaneous | sequential | iterative |
/// |---|---|---|---|---|
/// | bowl without coupling, (0, 0) | found, 102 | found, 15 | found, 21 | found, 43 |
/// | coupled bowl, (0, 0) | found, 139 | found, 48 | **missed**, 20 | within 0.005, 535 |
/// | two basins with steep coupling, (−0.5, −0.5) | found, 236 | found, 38 | **missed**, 23 | **missed**, 140 |
/// | crease along p_p = p_c, (−0.5, −0.5) | found, 186 | **missed**, 23 | **missed**, 30 | **missed**, 30 |
///
/// * Sequential optimizes the plant for a controller it will not keep.
/// * Iterative stops where neither parameter alone can improve; that can be a worse basin, although each of its searches looks at the whole axis, or any point of a crease.
///   On a smooth bowl it does arrive, slowly when the coupling is strong.
/// * Simultaneous depends on its starts, and its smooth model stalls on a crease.
/// * Nested depends on its starts too: with the warm start alone (`n_starts` = 0) both nested and simultaneous stay in the worse of the two basins.
///   A basin narrower than the lattice of starts, a quarter of the range with the default of 5, can be missed by every strategy.
///
/// A search starts from the warm start and those of 5 lattice points that have no better start nearby, so one bowl costs one descent.
/// The nested, sequential and iterative strategies need at least one parameter of each kind; simultaneous takes any.
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
