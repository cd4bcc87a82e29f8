//! The campaigns that were run, on disk after each few: a killed run goes on where it was.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, ensure};
use serde::{Deserialize, Serialize};

use super::file::Study;
use super::which::Which;
use crate::kept;

/// One iteration.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct KeptTurn {
    pub(super) design: Vec<f64>,
    /// Of the model with the unknowns of this turn.
    pub(super) model_cost: f64,
    pub(super) corrected_cost: f64,
    /// As it was read.
    pub(super) measured_cost: Option<f64>,
    pub(super) unknowns: Vec<f64>,
    pub(super) carried_slope: Vec<f64>,
    pub(super) carried_offset: f64,
}

/// One number of the plant after all experiments.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct KeptUnknown {
    pub(super) value: f64,
    pub(super) standard_error: Option<f64>,
    pub(super) bound: Option<String>,
}

/// What a campaign identified in the end.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Found {
    pub(super) unknowns: Vec<KeptUnknown>,
    /// How many times as large as the noise the residuals are.
    pub(super) misfit: f64,
    pub(super) singular_values: Vec<f64>,
    pub(super) warnings: Vec<String>,
}

/// One campaign.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Kept {
    pub(super) which: Which,
    pub(super) turns: Vec<KeptTurn>,
    /// Nothing where the loop identifies nothing.
    pub(super) found: Option<Found>,
}

/// A line of the file: one campaign, its loop by name.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Line {
    #[serde(rename = "loop")]
    label: String,
    seed: Option<u64>,
    turns: Vec<KeptTurn>,
    found: Option<Found>,
}

impl Kept {
    /// Whether both say the same; the last digits differ between machines.
    pub(super) fn agrees(&self, other: &Self) -> bool {
        let numbers = |kept: &Self| -> Vec<f64> {
            let turns = kept.turns.iter().flat_map(|turn| [&turn.design[..], &[turn.corrected_cost]].concat());
            let found = kept.found.iter().flat_map(|found| &found.unknowns);
            turns.chain(found.map(|unknown| unknown.value)).collect()
        };
        let (a, b) = (numbers(self), numbers(other));
        const CLOSE: f64 = 1e-3;
        a.len() == b.len() && a.iter().zip(&b).all(|(a, b)| (a - b).abs() <= CLOSE * a.abs())
    }
}

/// All campaigns of a folder.
pub(super) struct Store {
    path: PathBuf,
    labels: Vec<String>,
    campaigns: Vec<Kept>,
}

impl Store {
    pub(super) fn read(folder: &Path, study: &Study) -> Result<Self> {
        let path = folder.join("campaigns.jsonl");
        let labels: Vec<String> = study.loops.iter().map(|entry| entry.label.clone()).collect();
        let mut store = Self { path, labels, campaigns: Vec::new() };
        if !store.path.exists() {
            return Ok(store);
        }
        let words = || store.path.display().to_string();
        let text = std::fs::read_to_string(&store.path).with_context(words)?;
        for (number, line) in text.lines().enumerate() {
            let here = || format!("{}, line {}", store.path.display(), number + 1);
            let line: Line = serde_json::from_str(line).with_context(here)?;
            let index = store.labels.iter().position(|label| *label == line.label);
            let index = index.with_context(|| format!("{}: no loop is called `{}`", here(), line.label))?;
            let n = study.unknowns.len();
            let fits = line.turns.iter().all(|turn| turn.unknowns.len() == n);
            ensure!(fits, "{}: other unknowns than the {n} of today: remove it", here());
            let Line { seed, turns, found, .. } = line;
            store.campaigns.push(Kept { which: Which { index, seed }, turns, found });
        }
        Ok(store)
    }

    pub(super) fn find(&self, which: Which) -> Option<&Kept> {
        self.campaigns.iter().find(|kept| kept.which == which)
    }

    /// Those of a loop, by seed; the one without noise is not among them.
    pub(super) fn noisy(&self, index: usize) -> Vec<&Kept> {
        self.campaigns.iter().filter(|kept| kept.which.index == index && kept.which.seed.is_some()).collect()
    }

    pub(super) fn campaigns(&self) -> &[Kept] {
        &self.campaigns
    }

    pub(super) fn add(&mut self, found: Vec<Kept>) -> Result<()> {
        self.campaigns.extend(found);
        self.campaigns.sort_by_key(|kept| (kept.which.index, kept.which.seed));
        let lines = self.campaigns.iter().map(|kept| {
            let Kept { which, turns, found } = kept.clone();
            let label = self.labels[which.index].clone();
            let line = Line { label, seed: which.seed, turns, found };
            Ok(serde_json::to_string(&line)? + "\n")
        });
        let text = lines.collect::<Result<String>>()?;
        kept::replace(&self.path, text.as_bytes())
    }
}
