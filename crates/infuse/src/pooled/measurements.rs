//! What was measured, as the surfaces take it.

use std::collections::BTreeSet;

use design_space::Cell;

/// One experiment that gave a response.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Reading {
    pub(crate) coded: Vec<f64>,
    pub(crate) cell: Cell,
    pub(crate) response: f64,
    /// Position among all readings.
    pub(crate) number: usize,
}

/// All that was measured.
#[derive(Debug, Clone, Default)]
pub(crate) struct Measurements {
    pub(crate) readings: Vec<Reading>,
    /// Readings of each constrained response.
    pub(crate) constrained: Vec<Vec<Reading>>,
    /// Where experiments failed.
    pub(crate) failed: BTreeSet<Cell>,
}
