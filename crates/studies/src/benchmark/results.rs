//! Rows of campaigns, kept in files so that a run goes on where the last one ended.

use std::fs::{self, OpenOptions};
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result};
use serde::{Deserialize, Serialize};

/// The peers whose rows a person with Python can write anew: `fixtures/peers/README.md`.
pub(super) const PEER_NAMES: &[&str] = &["botorch", "botorch-multifidelity", "smt", "optuna"];

/// One batch of one campaign.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Row {
    pub(super) family: String,
    pub(super) seed: u64,
    /// From 1.
    pub(super) batch: usize,
    /// Truth at the recommended design less the lowest on the grid; the truth goes from 0 to 1.
    pub(super) regret: f64,
    /// What the method promised to be missing at most, with 90 % probability.
    pub(super) bound: Option<f64>,
    /// To choose the batch.
    pub(super) ask_seconds: f64,
    /// To take its results.
    pub(super) tell_seconds: f64,
}

impl Row {
    /// Whether both say the same, times apart; the last digits differ between machines.
    pub(super) fn agrees(&self, other: &Self) -> bool {
        let close = |a: f64, b: f64| (a - b).abs() <= 1e-6 * (1.0 + a.abs());
        let bounds = match (self.bound, other.bound) {
            (Some(a), Some(b)) => close(a, b),
            (a, b) => a.is_none() == b.is_none(),
        };
        self.family == other.family
            && self.seed == other.seed
            && self.batch == other.batch
            && bounds
            && close(self.regret, other.regret)
    }
}

/// All rows of a method.
#[derive(Debug, Clone)]
pub(super) struct Results {
    pub(super) method: String,
    path: PathBuf,
    pub(super) rows: Vec<Row>,
}

impl Results {
    /// The rows in a folder; none if there is no file yet.
    pub(super) fn read(folder: &Path, method: &str) -> Result<Self> {
        let path = folder.join(method).with_extension("csv");
        let mut rows = Vec::new();
        if path.exists() {
            let mut reader =
                csv::Reader::from_path(&path).with_context(|| format!("cannot read {}", path.display()))?;
            for line in reader.deserialize() {
                rows.push(line.with_context(|| format!("{} is not a table of results", path.display()))?);
            }
        }
        Ok(Self { method: method.to_owned(), path, rows })
    }

    pub(super) fn has(&self, family: &str, seed: u64) -> bool {
        self.rows.iter().any(|row| row.family == family && row.seed == seed)
    }

    pub(super) fn of(&self, family: &str, seed: u64) -> Vec<Row> {
        self.rows.iter().filter(|row| row.family == family && row.seed == seed).cloned().collect()
    }

    /// Adds rows, in memory and in the file.
    pub(super) fn append(&mut self, rows: Vec<Row>) -> Result<()> {
        if let Some(folder) = self.path.parent() {
            fs::create_dir_all(folder)?;
        }
        let is_new = !self.path.exists();
        let file = OpenOptions::new().create(true).append(true).open(&self.path)?;
        let mut writer = csv::WriterBuilder::new().has_headers(is_new).from_writer(file);
        for row in &rows {
            let rounded = |seconds: f64| (1e3 * seconds).round() / 1e3;
            let (ask_seconds, tell_seconds) = (rounded(row.ask_seconds), rounded(row.tell_seconds));
            writer.serialize(Row { ask_seconds, tell_seconds, ..row.clone() })?;
        }
        writer.flush()?;
        self.rows.extend(rows);
        Ok(())
    }
}
