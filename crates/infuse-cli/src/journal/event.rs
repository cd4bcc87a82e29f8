//! The lines of a journal.

use std::collections::BTreeMap;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use design_space::Cell;
use infuse::pooled::Reason;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::deed::Deed;
use super::submission::SubmissionName;
use crate::problem::Scale;

/// Where results come from that nobody typed.
pub(crate) const BY_ITSELF: &str = "infuse run";

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
    Planned {
        batch: usize,
        at: String,
        experiments: Vec<Cell>,
        simulations: Vec<Cell>,
        /// Why it was planned, if not by the loop.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        purpose: Option<Purpose>,
        /// Why the loop asks for each experiment, in the same order.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        reasons: Vec<Reason>,
        /// The settings of the loop at that time; journals of an earlier version have none.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        settings: Option<Value>,
    },
    /// A simulation was run, or looked up.
    Simulated {
        cell: Cell,
        point: Vec<f64>,
        #[serde(flatten)]
        result: Measured,
        /// Of the responses that have to stay within bounds.
        #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
        constrained: Constrained,
        by: String,
    },
    /// It was asked whether a design can be built.
    Checked { cell: Cell, point: Vec<f64>, can_be_built: bool, by: String, at: String },
    /// Runs are to be handed to a queue; written down before they are.
    Submitted(Submitted),
    /// What was simulated before is not to be used in batches to come.
    #[serde(rename = "forgotten")]
    Discarded { at: String },
    /// All simulations of the batch are there, and the experiments can be handed out.
    Opened { batch: usize, at: String },
    /// The experiments of a batch stand in this file, too, or instead of the one with the usual name; see
    /// [`kept_name`](crate::shell::kept_name).
    Sheet { batch: usize, path: String, at: String },
    /// An experiment was told.
    Told(Told),
    /// An experiment from before the campaign.
    Imported {
        row: usize,
        rows: usize,
        point: Vec<f64>,
        #[serde(flatten)]
        result: Measured,
        /// Of the responses that have to stay within bounds.
        #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
        constrained: Constrained,
        /// The units of those, by name, as they were then.
        #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
        units: BTreeMap<String, String>,
        source: String,
        /// What a person wrote beside it.
        #[serde(default, skip_serializing_if = "String::is_empty")]
        note: String,
        from: String,
        at: String,
    },
    /// Everything that was imported from this source is not to be used any longer.
    Withdrawn { source: String, at: String },
    /// The last thing that a person did before does not count, whatever it was; so many lines.
    Undone { deed: Deed, lines: usize, at: String },
    /// What a closed batch taught; it follows from the lines before, and is here for people and as a check.
    Learned(Learned),
    /// What was known once a batch of the pooled loop was complete, for the history, with a checksum of all lines before.
    Assessed(Assessed),
}

/// Runs that were handed to a queue.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Submitted {
    /// By which the queue knows it.
    pub(crate) name: SubmissionName,
    /// All runs of the batch, numbered from 1 in this order, those with a result included.
    pub(crate) cells: Vec<Cell>,
    /// Of experiments the id of each, in the same order; 0 for one that was taken back, whose result is not read any more.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) experiments: Vec<u64>,
    /// The simulator, or the command of the experiments.
    pub(crate) by: String,
    pub(crate) at: String,
}

impl Submitted {
    /// Whether they are experiments, and no simulations.
    pub(crate) fn is_of_experiments(&self) -> bool {
        !self.experiments.is_empty()
    }
}

/// Why a batch was planned, if not by the loop.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Purpose {
    /// To measure what was gained.
    Confirm,
}

/// What was told about an experiment.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Told {
    /// Place of this line in what was told at once, and how many lines that has.
    pub(crate) row: usize,
    pub(crate) rows: usize,
    pub(crate) id: u64,
    #[serde(flatten)]
    pub(crate) result: Measured,
    /// Of the responses that have to stay within bounds.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub(crate) constrained: Constrained,
    /// The units of those, by name, as they were then.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub(crate) units: BTreeMap<String, String>,
    /// Settings really made, where they are not those asked for.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub(crate) actual: BTreeMap<String, f64>,
    /// Besides the run that was asked for there may be more at its settings: their number, from 1.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub(crate) repeat: usize,
    /// Takes the place of what was told before.
    #[serde(default, skip_serializing_if = "is_false")]
    pub(crate) corrects: bool,
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub(crate) note: String,
    pub(crate) from: String,
    pub(crate) at: String,
}

/// What was measured or simulated of the responses that have to stay within bounds, by their names.
pub(crate) type Constrained = BTreeMap<String, f64>;

/// A value, or why there is none.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Measured {
    Value(f64),
    Failed(String),
}

/// The state of knowledge after a batch.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Assessed {
    pub(crate) batch: usize,
    pub(crate) recommended: Vec<f64>,
    /// The response that is expected there, and the standard deviation of that.
    pub(crate) expected: f64,
    pub(crate) deviation: f64,
    /// With this probability no design is better by more than `bound`; none where that could not be said.
    pub(crate) probability: f64,
    pub(crate) bound: Option<f64>,
    /// The same by the surface alone; none in journals of an earlier version.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) alone: Option<f64>,
    /// Share of the designs that may still be the best.
    pub(crate) left: f64,
    pub(crate) noise: f64,
    /// On a logarithmic one `deviation`, `bound` and `noise` are differences of natural logarithms.
    #[serde(default, skip_serializing_if = "Scale::is_linear")]
    pub(crate) scale: Scale,
    /// The settings of the loop at that time.
    pub(crate) settings: Value,
    /// The simulator at that time, empty if there was none; journals that do not have it go on without.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) by: Option<String>,
    /// What the surface made of the simulation; none without one, and in journals of an earlier version.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) simulation: Option<OfSimulation>,
    /// The responses of which results were sure that they drift from batch to batch.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) drifting: Vec<String>,
    /// Of this line and all before it; see [`Checksum`](super::checksum::Checksum).
    #[serde(default)]
    pub(crate) check: String,
}

/// What a surface made of the simulation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct OfSimulation {
    pub(crate) factor: f64,
    /// Probability that the response is better learnt without it.
    pub(crate) ignored: f64,
    /// How far it is displaced, in the unit of each parameter, if it is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) displacement: Option<Vec<f64>>,
    /// Standard deviations of that; journals of before have none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) deviations: Option<Vec<f64>>,
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
            Self::Told(Told { row, rows, .. }) | Self::Imported { row, rows, .. } => (row, rows),
            _ => (1, 1),
        }
    }

    /// When it was written down, of those that say.
    pub(crate) fn time(&self) -> Option<&str> {
        match self {
            Self::Campaign { at, .. }
            | Self::Planned { at, .. }
            | Self::Discarded { at }
            | Self::Submitted(Submitted { at, .. })
            | Self::Opened { at, .. }
            | Self::Sheet { at, .. }
            | Self::Told(Told { at, .. })
            | Self::Imported { at, .. }
            | Self::Checked { at, .. }
            | Self::Withdrawn { at, .. }
            | Self::Undone { at, .. } => Some(at),
            Self::Simulated { .. } | Self::Learned(_) | Self::Assessed(_) => None,
        }
    }
}

/// The time as it stands in the lines: nothing is ever computed from it.
pub(crate) fn now() -> String {
    written(SystemTime::now())
}

/// A clock may be set to any time, also to one that has no such text.
fn written(time: SystemTime) -> String {
    let end_of_9999 = UNIX_EPOCH + Duration::from_secs(253_402_300_799);
    humantime::format_rfc3339_seconds(time.clamp(UNIX_EPOCH, end_of_9999)).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clock_may_be_wrong_by_any_amount() {
        let hour = Duration::from_secs(3600);
        for (time, expected) in [
            (UNIX_EPOCH, "1970-01-01T00:00:00Z"),
            (UNIX_EPOCH - hour, "1970-01-01T00:00:00Z"),
            (UNIX_EPOCH + Duration::from_secs(951_782_400), "2000-02-29T00:00:00Z"),
            (UNIX_EPOCH + Duration::from_secs(253_402_300_799) + hour, "9999-12-31T23:59:59Z"),
        ] {
            assert_eq!(written(time), expected);
        }
    }
}
