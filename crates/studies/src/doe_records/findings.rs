//! What is searched for, how hard, and what was found.

use doe::Found;

use super::file::{Kept, Record, Size};

/// Share of the best known efficiency at which a search of this run stops.
pub(super) const GOAL: f64 = 0.99;
/// Starts after which it gives up.
pub(super) const MOST_STARTS: u64 = 400;
/// Levels of each of the four factors of the case study's grid.
pub(super) const GRID: [u32; 4] = [24; 4];
/// Starts of a search over that grid.
pub(super) const GRID_STARTS: u64 = 32;
/// Runs of a design over a list of candidates.
pub(super) const LIST_RUNS: usize = 18;
/// Starts of a search over a list.
pub(super) const LIST_STARTS: u64 = 4;
/// Starts of a search for a size beyond the record.
pub(super) const LARGE_STARTS: u64 = 2;

/// A kept design beside the record.
pub(super) struct Row {
    pub(super) size: Size,
    pub(super) kept: Kept,
    /// The largest prediction variance on a dense lattice over that over the cube: at most 1.
    pub(super) lattice_share: f64,
}

/// The kept designs, verified.
pub(super) struct Verified {
    pub(super) record: Record,
    pub(super) rows: Vec<Row>,
}

/// A search over the grid of the case study.
pub(super) struct GridRow {
    pub(super) model: &'static str,
    pub(super) runs: usize,
    pub(super) found: Found,
}

/// Everything that the study found.
pub(super) struct Findings {
    pub(super) verified: Verified,
    /// For the like of each row.
    pub(super) again: Vec<Found>,
    pub(super) grid: Vec<GridRow>,
    pub(super) large: Vec<(Size, Found)>,
    /// Searches over lists, by the number of their candidates.
    pub(super) lists: Vec<(usize, Found)>,
    pub(super) seconds: f64,
}
