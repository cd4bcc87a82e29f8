//! What can go wrong with a page or a table.

use std::path::PathBuf;

/// A fault of a table or of a file that is written.
#[non_exhaustive]
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The columns of a table are not equally long.
    #[error("column `{column}`: {found} values, not {expected}")]
    ColumnLength {
        /// Name of the column.
        column: String,
        /// Number of its values.
        found: usize,
        /// Number of values of the first column.
        expected: usize,
    },
    /// A file cannot be written.
    #[error("{}: {cause}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// Why not.
        cause: std::io::Error,
    },
}
