//! What a long table of simulations says, kept so that it is read once and not at every call.
//!
//! The file can be removed at any time, and is written again. It is taken for what it is only if it was made from this
//! table, for these parameters, and is whole.

use std::path::Path;

use design_space::{Cell, Grid, Levels};
use sha2::{Digest as _, Sha256};

use super::rows::Rows;
use crate::disk::replace;
use crate::problem::Problem;
use crate::sheet::point_columns;

/// A shorter table is read as fast.
pub(super) const LEAST_BYTES: usize = 1 << 20;

/// Beside the journal.
pub(crate) const FILE: &str = ".infuse-index";

/// Of a table, and of all that it is read by.
pub(super) fn key(table: &[u8], problem: &Problem) -> [u8; 32] {
    let mut digest = Sha256::new();
    part(&mut digest, env!("CARGO_PKG_VERSION"));
    for parameter in problem.region.parameters() {
        part(&mut digest, parameter.name());
        part(&mut digest, parameter.unit());
        part(&mut digest, parameter.lower().to_le_bytes());
        part(&mut digest, parameter.upper().to_le_bytes());
        let levels = match parameter.levels() {
            Levels::Continuous => 0,
            Levels::Count(count) => count,
        };
        part(&mut digest, levels.to_le_bytes());
        let choices = parameter.choices().unwrap_or_default();
        part(&mut digest, (choices.len() as u64).to_le_bytes());
        choices.iter().for_each(|choice| part(&mut digest, choice));
    }
    for column in point_columns(problem) {
        part(&mut digest, &column.name);
        part(&mut digest, &column.unit);
        part(&mut digest, [u8::from(column.is_required)]);
    }
    // On this scale some values are faults.
    part(&mut digest, [u8::from(problem.response.scale.is_linear())]);
    part(&mut digest, table);
    digest.finalize().into()
}

/// With its length, so that no two lists of parts run into the same bytes.
fn part(digest: &mut Sha256, part: impl AsRef<[u8]>) {
    let part = part.as_ref();
    digest.update((part.len() as u64).to_le_bytes());
    digest.update(part);
}

/// What was kept under this key; nothing if it isn't there, or is another's, or is broken.
pub(super) fn read(folder: &Path, key: &[u8; 32], grid: &Grid) -> Option<Rows> {
    let bytes = std::fs::read(folder.join(FILE)).ok()?;
    let (content, checksum) = bytes.split_last_chunk::<32>()?;
    let is_whole = *Sha256::digest(content) == checksum[..];
    let (kept_key, content) = content.split_first_chunk::<32>()?;
    if !is_whole || kept_key != key {
        return None;
    }
    let (n_constraints, content) = content.split_first_chunk::<8>()?;
    let n_constraints = usize::try_from(u64::from_le_bytes(*n_constraints)).ok()?;
    let (words, rest) = content.as_chunks::<8>();
    let rows = words.chunks_exact(n_constraints.checked_add(2)?);
    if !rest.is_empty() || !rows.remainder().is_empty() {
        return None;
    }
    let mut read = Rows::none(n_constraints);
    let mut constrained = Vec::with_capacity(n_constraints);
    for row in rows {
        let [cell, value, others @ ..] = row else { return None };
        let cell = u64::from_le_bytes(*cell);
        if cell >= grid.n_cells() {
            return None;
        }
        constrained.clear();
        constrained.extend(others.iter().map(|&bytes| f64::from_le_bytes(bytes)));
        read.push(Cell::new(cell), f64::from_le_bytes(*value), &constrained);
    }
    (read.len() > 0).then_some(read)
}

/// Keeps it if it can be kept: a folder that cannot be written to only costs time.
pub(super) fn write(folder: &Path, key: &[u8; 32], rows: &Rows) {
    let mut bytes = Vec::with_capacity(72 + rows.len() * 8 * (2 + rows.n_constraints()));
    bytes.extend_from_slice(key);
    bytes.extend_from_slice(&(rows.n_constraints() as u64).to_le_bytes());
    for (cell, row) in rows.iter() {
        bytes.extend_from_slice(&cell.index().to_le_bytes());
        bytes.extend_from_slice(&row.value.to_le_bytes());
        bytes.extend(row.numbers().iter().flat_map(|value| value.to_le_bytes()));
    }
    let checksum = Sha256::digest(&bytes);
    bytes.extend_from_slice(&checksum);
    drop(replace(&folder.join(FILE), &bytes));
}
