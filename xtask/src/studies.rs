//! Starts the program `studies`, built with no more than a command needs.

use anyhow::{Result, bail};

use crate::workspace;

/// A command of `studies`, and what it has to be built with.
struct Study {
    command: &'static str,
    features: &'static [&'static str],
}

/// All that the program can do.
const ALL: &[&str] = &["similarity", "global"];

const STUDIES: &[Study] = &[
    Study { command: "reproduce-chapter2", features: &["similarity"] },
    Study { command: "reproduce-chapter3", features: &[] },
    Study { command: "reproduce-chapter4", features: &[] },
    Study { command: "reproduce-chapter6", features: ALL },
    Study { command: "reproduce-chapter7", features: ALL },
    Study { command: "reproduce-all", features: ALL },
    Study { command: "doe-records", features: ALL },
    Study { command: "design-page", features: ALL },
];

/// Whether a command is one of a study.
pub(crate) fn is_study(command: &str) -> bool {
    STUDIES.iter().any(|study| study.command == command)
}

/// Builds what a command needs and runs it; its output is ours.
pub(crate) fn run(words: &[&str]) -> Result<()> {
    let Some(study) = STUDIES.iter().find(|study| words.first() == Some(&study.command)) else {
        bail!("no study `{}`", words.join(" "));
    };
    let features = study.features.join(",");
    let build = ["run", "--release", "--package", "studies", "--no-default-features", "--features", &features];
    let status = workspace::cargo(&build)?.arg("--").args(words).status()?;
    if status.success() {
        return Ok(());
    }
    bail!("`{}` failed", words.join(" "))
}
