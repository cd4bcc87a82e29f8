//! What stands where there is nothing to say.

/// In a cell of a table.
pub(super) const NOTHING: &str = "–";
