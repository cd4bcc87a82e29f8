//! The lines of a journal.

use std::collections::BTreeMap;

use design_space::Cell;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// The format of the lines below.
pub(crate) const FORMAT: u32 = 1;

/// One thing that happened. Nothing else is ever written down, and all a campaign knows follows from these lines and its
/// problem.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "event", rename_all = "snake_case", deny_unknown_fields)]
pub(crate) enum Event {
    /// The first line.
    Campaign { format: u32, at: String, problem: Value },
    /// A batch was designed: cells of the grid.
    Planned { batch: usize, at: String, experiments: Vec<Cell>, simulations: Vec<Cell> },
    /// A simulation was run, or looked up.
    Simulated {
        cell: Cell,
        point: Vec<f64>,
        #[serde(flatten)]
        result: Measured,
        by: String,
    },
    /// What was simulated before is not to be used in batches to come.
    #[serde(rename = "forgotten")]
    Discarded { at: String },
    /// All simulations of the batch are there, and the experiments can be handed out.
    Opened { batch: usize, at: String },
    /// An experiment was told.
    Told {
        /// Place of this line in what was told at once, and how many lines that has.
        row: usize,
        rows: usize,
        id: u64,
        #[serde(flatten)]
        result: Measured,
        /// Settings really made, where they are not those asked for.
        #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
        actual: BTreeMap<String, f64>,
        /// Besides the run that was asked for there may be more at its settings: their number, from 1.
        #[serde(default, skip_serializing_if = "is_zero")]
        repeat: usize,
        /// Takes the place of what was told before.
        #[serde(default, skip_serializing_if = "is_false")]
        corrects: bool,
        #[serde(default, skip_serializing_if = "String::is_empty")]
        note: String,
        from: String,
        at: String,
    },
    /// An experiment from before the campaign.
    Imported { row: usize, rows: usize, point: Vec<f64>, value: f64, source: String, from: String, at: String },
    /// Everything that was imported from this source is not to be used any longer.
    Withdrawn { source: String, at: String },
    /// What a closed batch taught; it follows from the lines before, and is here for people and as a check.
    Learned(Learned),
}

/// A value, or why there is none.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Measured {
    Value(f64),
    Failed(String),
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Learned {
    pub(crate) batch: usize,
    pub(crate) optimum: Vec<f64>,
    pub(crate) predicted: f64,
    pub(crate) spread: Option<f64>,
    pub(crate) kept: u64,
    pub(crate) of: u64,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde hands out references")]
fn is_zero(count: &usize) -> bool {
    *count == 0
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde hands out references")]
fn is_false(flag: &bool) -> bool {
    !flag
}

impl Event {
    /// Place and number of lines of what was written at once.
    pub(crate) fn group(&self) -> (usize, usize) {
        match *self {
            Self::Told { row, rows, .. } | Self::Imported { row, rows, .. } => (row, rows),
            _ => (1, 1),
        }
    }
}

/// The time as it stands in the lines: nothing is ever computed from it.
pub(crate) fn now() -> String {
    humantime::format_rfc3339_seconds(std::time::SystemTime::now()).to_string()
}
