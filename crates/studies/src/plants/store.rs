//! Campaigns that are kept.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result};

use super::campaign::Row;
use crate::kept;

/// All rows of a file.
pub(super) struct Store {
    path: PathBuf,
    pub(super) rows: Vec<Row>,
}

impl Store {
    /// None if there is no file yet.
    pub(super) fn read(path: &Path) -> Result<Self> {
        let mut rows = Vec::new();
        if path.exists() {
            let words = || path.display().to_string();
            for row in csv::Reader::from_path(path).with_context(words)?.deserialize() {
                rows.push(row.with_context(words)?);
            }
        }
        Ok(Self { path: path.to_path_buf(), rows })
    }

    pub(super) fn has(&self, case: &str, method: &str, seed: u64) -> bool {
        self.rows.iter().any(|row| row.case == case && row.method == method && row.seed == seed)
    }

    pub(super) fn of(&self, case: &str, method: &str, seed: u64) -> Vec<Row> {
        let is_meant = |row: &&Row| row.case == case && row.method == method && row.seed == seed;
        self.rows.iter().filter(is_meant).cloned().collect()
    }

    /// Adds rows, in memory and in the file, which is written anew.
    pub(super) fn add(&mut self, rows: Vec<Row>) -> Result<()> {
        self.rows.extend(rows);
        let mut writer = csv::Writer::from_writer(Vec::new());
        for row in &self.rows {
            writer.serialize(row)?;
        }
        let text = writer.into_inner().map_err(|error| error.into_error())?;
        kept::replace(&self.path, &text)
    }
}
