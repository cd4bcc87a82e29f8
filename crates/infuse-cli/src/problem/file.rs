//! `campaign.toml` as it stands, before its numbers are checked. A key that is not here is an error.

use std::collections::BTreeMap;
use std::path::PathBuf;

use infuse::{
    Role,
    correction::Gain,
    global::{SpreadFallback, SurfaceKinds},
    pooled::StopBy,
};
use serde::{Deserialize, Serialize};

/// The name of the file in the folder of a campaign.
pub(crate) const PROBLEM: &str = "campaign.toml";

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ProblemFile {
    pub(crate) title: String,
    #[serde(default = "one")]
    pub(crate) seed: u64,
    #[serde(default)]
    pub(crate) sheets: SheetFormat,
    #[serde(rename = "parameter")]
    pub(crate) parameters: Vec<ParameterEntry>,
    pub(crate) response: ResponseEntry,
    pub(crate) simulator: Option<SimulatorEntry>,
    pub(crate) experiment: Option<ExperimentEntry>,
    #[serde(default, rename = "constraint")]
    pub(crate) constraints: Vec<ConstraintEntry>,
    #[serde(default, rename = "linear_constraint")]
    pub(crate) linear_constraints: Vec<LinearEntry>,
    pub(crate) can_be_built: Option<ProgramEntry>,
    #[serde(default, rename = "loop")]
    pub(crate) rule: LoopEntry,
    #[serde(default)]
    pub(crate) stop: StopEntry,
}

/// As what the sheets are written.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum SheetFormat {
    #[default]
    Csv,
    Xlsx,
}

fn one() -> u64 {
    1
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ParameterEntry {
    pub(crate) name: String,
    /// As bounds, levels and step: of a number.
    pub(crate) unit: Option<String>,
    pub(crate) lower: Option<f64>,
    pub(crate) upper: Option<f64>,
    pub(crate) levels: Option<u32>,
    pub(crate) step: Option<f64>,
    /// In place of bounds, of what is no number.
    pub(crate) choices: Option<Vec<String>>,
    /// What it costs to set it anew.
    pub(crate) change_cost: Option<f64>,
    /// Nothing follows from it but what is shown, and what a plant is where no `change_cost` says it.
    pub(crate) role: Option<Role>,
}

/// A response that has to stay within bounds.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ConstraintEntry {
    pub(crate) name: String,
    pub(crate) unit: String,
    pub(crate) lower: Option<f64>,
    pub(crate) upper: Option<f64>,
    pub(crate) probability: Option<f64>,
    pub(crate) noise: Option<f64>,
}

/// Settings that go together: a sum of parameters, each with its factor.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct LinearEntry {
    pub(crate) sum: BTreeMap<String, f64>,
    pub(crate) lower: Option<f64>,
    pub(crate) upper: Option<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Goal {
    Minimize,
    Maximize,
}

/// On what scale differences of the response count alike.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Scale {
    #[default]
    Linear,
    /// Of what spans powers of ten: twice as much is as far everywhere, and differences are factors.
    Log,
}

impl Scale {
    pub(crate) fn is_linear(&self) -> bool {
        *self == Self::Linear
    }
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ResponseEntry {
    pub(crate) name: String,
    pub(crate) unit: String,
    pub(crate) goal: Goal,
    #[serde(default)]
    pub(crate) scale: Scale,
    pub(crate) lower: Option<f64>,
    pub(crate) upper: Option<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SimulatorEntry {
    pub(crate) table: Option<PathBuf>,
    pub(crate) command: Option<Vec<String>>,
    pub(crate) input: Option<Input>,
    pub(crate) timeout_seconds: Option<f64>,
    pub(crate) jobs: Option<usize>,
    pub(crate) queue: Option<QueueEntry>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct QueueEntry {
    pub(crate) kind: Option<QueueKind>,
    pub(crate) options: Option<Vec<String>>,
    pub(crate) submit: Option<Vec<String>>,
    pub(crate) list: Option<Vec<String>>,
    pub(crate) cancel: Option<Vec<String>>,
    pub(crate) poll_seconds: Option<f64>,
    pub(crate) tries: Option<usize>,
    pub(crate) runs_per_task: Option<usize>,
}

/// A scheduler whose commands are known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum QueueKind {
    Slurm,
    HyperQueue,
    Pbs,
    Lsf,
    Parallel,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ProgramEntry {
    pub(crate) command: Vec<String>,
    pub(crate) input: Option<Input>,
    pub(crate) timeout_seconds: Option<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ExperimentEntry {
    pub(crate) command: Vec<String>,
    pub(crate) input: Option<Input>,
    pub(crate) timeout_seconds: Option<f64>,
    pub(crate) queue: Option<QueueEntry>,
}

/// How a program gets a point.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Input {
    /// Only by the placeholders of its command.
    #[default]
    Arguments,
    /// Also as an object on standard input.
    Json,
}

/// By which loop a campaign goes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Method {
    /// All data in one surface, with the simulation inside.
    #[default]
    Pooled,
    /// The dissertation's loop, batch by batch.
    Dissertation,
}

#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct LoopEntry {
    pub(crate) method: Option<Method>,
    pub(crate) experiments: Option<usize>,
    pub(crate) simulations: Option<SimulationsEntry>,
    pub(crate) batches: Option<usize>,
    pub(crate) confidence: Option<f64>,
    /// Of the pooled loop alone, as the next five.
    pub(crate) noise: Option<f64>,
    /// Whether the simulation may be right of another design.
    pub(crate) displaced: Option<bool>,
    /// Whether runs of a batch share an error.
    pub(crate) blocks: Option<bool>,
    /// Plants in a batch, at most.
    pub(crate) plants: Option<usize>,
    /// In the unit of the costs of changes.
    pub(crate) experiment_cost: Option<f64>,
    pub(crate) cost_unit: Option<String>,
    /// Of the dissertation's loop alone, as all that follow.
    pub(crate) model: Option<ModelEntry>,
    pub(crate) replicates: Option<usize>,
    pub(crate) drop_from: Option<usize>,
    pub(crate) gain: Option<Gain>,
    pub(crate) experiment_weight: Option<f64>,
    pub(crate) simulation_weight: Option<f64>,
    pub(crate) surfaces: Option<SurfaceKinds>,
    pub(crate) without_spread: Option<SpreadFallback>,
}

/// Simulations per batch, or as many as are of use.
#[derive(Debug, Clone, Deserialize)]
#[serde(untagged, expecting = "expected a whole number from 2 on, simulations per batch, or \"all\"")]
pub(crate) enum SimulationsEntry {
    Count(usize),
    Named(String),
}

#[derive(Debug, Clone, Deserialize)]
#[serde(untagged, expecting = "expected \"linear\", \"additive quadratic\", \"quadratic\" or a list of terms")]
pub(crate) enum ModelEntry {
    Named(String),
    /// One table per term: the exponent of each parameter in it, those left out 0.
    Listed(Vec<BTreeMap<String, u8>>),
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct StopEntry {
    pub(crate) worth: Option<f64>,
    pub(crate) by: Option<StopBy>,
    pub(crate) smooth: Option<bool>,
}
