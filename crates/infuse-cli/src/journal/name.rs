//! What the files of a journal are called.

/// The name of the file in the folder of a campaign.
pub(crate) const JOURNAL: &str = "journal.jsonl";
/// Where lines go that an interrupted call has left behind.
pub(super) const TORN: &str = "journal.torn";
