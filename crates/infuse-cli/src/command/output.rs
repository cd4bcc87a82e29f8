//! What a command gives to print, whichever it is.

use page::Finding;
use serde_json::{Value, json};

/// What a command says.
#[derive(Debug)]
pub(crate) struct Output {
    pub(crate) text: String,
    pub(crate) json: Value,
    /// For standard error.
    pub(crate) notices: Vec<String>,
}

impl Output {
    /// Sentences, as text and for machines, beside what else a machine is told.
    pub(super) fn new(findings: &[Finding], mut json: Value, notices: Vec<String>) -> Self {
        json["findings"] = json!(findings);
        json["notices"] = json!(notices);
        Self { text: findings.iter().map(Finding::to_string).collect(), json, notices }
    }
}
