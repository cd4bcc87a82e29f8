//! Numbers, and reasons why there are none, in a line of a file.

/// What stands before the reason why something has no cost.
pub(crate) const FAILED: &str = "failed ";

/// A reason with the words that fit into a line.
pub(crate) fn in_a_line(words: &str) -> String {
    words.replace(['\n', '\t'], " ")
}

/// Numbers parted by blanks, printed so that they come back bit for bit.
pub(crate) fn numbers(values: &[f64]) -> String {
    values.iter().map(ToString::to_string).collect::<Vec<_>>().join(" ")
}
