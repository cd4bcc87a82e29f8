//! Runs that may share an error.

use serde::{Deserialize, Serialize};

/// Runs that may share an error: those of one batch, or those of one source outside of the campaign.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Block {
    /// The batch of this number.
    Batch(usize),
    /// What was added as [earlier](crate::pooled::Loop::add_earlier) from this source.
    Source(String),
}
