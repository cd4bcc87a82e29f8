//! Campaigns that are kept.

use std::path::{Path, PathBuf};

use anyhow::Result;

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
        Ok(Self { path: path.to_path_buf(), rows: kept::rows(path)? })
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
        kept::replace_rows(&self.path, &self.rows)
    }
}
