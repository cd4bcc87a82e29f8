//! Names that are taken.

/// Headings of sheets, which no parameter may have.
const RESERVED: [&str; 7] = ["run", "id", "repeats", "failed", "note", "source", "actual"];

/// Whether a name would be taken for a heading of sheets.
pub(super) fn is_reserved(name: &str) -> bool {
    RESERVED.contains(&name) || name.starts_with("actual ")
}
