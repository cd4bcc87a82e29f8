//! The things that a person does to a campaign.

use serde::{Deserialize, Serialize};

/// A thing that a person did.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Deed {
    Ask,
    Confirm,
    Tell,
    Import,
    Withdraw,
}

impl Deed {
    pub(crate) fn in_words(self) -> &'static str {
        match self {
            Self::Ask => "an ask",
            Self::Confirm => "a confirm",
            Self::Tell => "a tell",
            Self::Import => "an import",
            Self::Withdraw => "a withdrawal",
        }
    }
}
