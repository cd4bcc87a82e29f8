//! The name by which a queue knows what was handed to it.

use std::fmt;

use serde::{Deserialize, Serialize};

/// A batch of runs, and which submission of it this is; in a journal and in a queue one word, `BATCH-ATTEMPT`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub(crate) struct SubmissionName {
    pub(crate) batch: String,
    /// From 1.
    pub(crate) attempt: usize,
}

impl fmt::Display for SubmissionName {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        write!(formatter, "{}-{}", self.batch, self.attempt)
    }
}

impl From<SubmissionName> for String {
    fn from(name: SubmissionName) -> Self {
        name.to_string()
    }
}

impl TryFrom<String> for SubmissionName {
    type Error = String;

    fn try_from(written: String) -> Result<Self, String> {
        let parts = written.rsplit_once('-').and_then(|(batch, attempt)| Some((batch, attempt.parse().ok()?)));
        let (batch, attempt) =
            parts.ok_or_else(|| format!("the name of a submission is `{written}`, expected `BATCH-1`"))?;
        Ok(Self { batch: batch.to_owned(), attempt })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_in_journals_of_any_version_are_one_word() {
        for (written, batch, attempt) in [("infuse-1a2b3c4d-1", "infuse-1a2b3c4d", 1), ("a-12-30", "a-12", 30)] {
            let name: SubmissionName = serde_json::from_str(&format!("\"{written}\"")).unwrap();
            assert_eq!((name.batch.as_str(), name.attempt), (batch, attempt));
            assert_eq!(serde_json::to_string(&name).unwrap(), format!("\"{written}\""));
        }
        let error = serde_json::from_str::<SubmissionName>("\"infuse\"").unwrap_err().to_string();
        assert!(error.contains("`infuse`") && error.contains("`BATCH-1`"), "{error}");
    }
}
