//! The name of a campaign.

/// A loop by its place in the file, and its noise.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Which {
    pub(super) index: usize,
    /// None: no noise.
    pub(super) seed: Option<u64>,
}
