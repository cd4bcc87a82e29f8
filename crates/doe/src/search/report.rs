//! What a search found and how.

use std::time::Duration;

use serde::{Deserialize, Serialize};

use crate::{Cell, Design, Efficiency};

/// The best design of a search, its efficiency, and how the search went.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Found {
    /// Fixed runs first, then the others, planned replicates last. Two runs are equal to the last bit or differ by more than
    /// 1e-6 in some coordinate, so that whoever groups runs finds the same [replicates](crate::Replicates); fixed runs stay
    /// as they are.
    pub design: Design,
    /// Where the space is a list, the index of the candidate that each run is, in the order of the runs: a planned
    /// replicate has that of the run it repeats, a fixed run that of the candidate nearest to it. Empty for boxes.
    pub candidates: Vec<usize>,
    /// Where the space is a grid, the cell that each run is, in the order of the runs: those of the
    /// [`Grid`](crate::Grid) of the region that the space is [of](crate::Space::of_region), where it is of one; levels
    /// of one's own are counted alike, and forbidden cells count. Empty for lists, with a continuous axis, and beyond
    /// 2⁶⁴ − 1 cells.
    pub cells: Vec<Cell>,
    /// Efficiency by the criterion searched for, and over which set; computed anew from the design.
    pub efficiency: Efficiency,
    /// How the search went.
    pub report: Report,
}

/// How a search went.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Report {
    /// Why it ended.
    pub stop: StopReason,
    /// Starts 0 to this less one were made. Where nothing was left [`unfinished`](Self::unfinished),
    /// [`Settings::starts`](crate::Settings::starts) with this number repeats the search; otherwise that number, and at
    /// least one more than [`best_start`](Self::best_start), leads to this design or a better one.
    pub starts: u64,
    /// The start that found the best.
    pub best_start: u64,
    /// Number of starts that came within one part in a million of the best.
    pub times_found: u64,
    /// Starts that were given up because they fell behind.
    pub abandoned: u64,
    /// Starts that led to no usable design.
    pub failed: u64,
    /// Starts and refinements that were cut on their way. A refinement keeps what it has reached; of the starts cut the
    /// best is the result where no start is whole.
    pub unfinished: u64,
    /// How long it took. Nothing is computed with it.
    pub elapsed: Duration,
}

/// Why a search ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StopReason {
    /// All starts were made.
    StartsDone,
    /// The time limit passed.
    TimeLimit,
    /// The target was reached.
    TargetReached,
    /// The caller interrupted.
    Interrupted,
}

/// What a search knows on its way.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Progress {
    /// Starts made.
    pub starts: u64,
    /// Value of the criterion of the best design so far; smaller is better.
    pub best_value: f64,
    /// Efficiency of the best design so far, per cent.
    pub best_percent: f64,
    /// Time since the search began.
    pub elapsed: Duration,
}
