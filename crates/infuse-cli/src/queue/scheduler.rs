//! The commands of a scheduler, run.

use std::path::Path;
use std::process::Command;

use anyhow::{Context as _, Result, ensure};

use crate::problem::Queue;

/// What stands for a placeholder.
pub(super) type Filled<'a> = [(&'a str, String)];

/// Runs a command of the scheduler from the folder of the campaign. What it printed.
pub(super) fn run(folder: &Path, queue: &Queue, command: &[String], filled: &Filled<'_>) -> Result<String> {
    let fill = |word: &String| filled.iter().fold(word.clone(), |word, (name, value)| word.replace(name, value));
    let words: Vec<String> = command
        .iter()
        .flat_map(|word| if word == "{options}" { queue.options.clone() } else { vec![fill(word)] })
        .collect();
    let (program, arguments) = words.split_first().context("an empty command")?;
    let said = Command::new(program)
        .args(arguments)
        .current_dir(folder)
        .stdin(std::process::Stdio::null())
        .output()
        .with_context(|| format!("{}: cannot start `{program}`", queue.section))?;
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).trim().to_owned();
    let errors = text(&said.stderr);
    ensure!(said.status.success(), "`{}`: {}: {errors}", words.join(" "), said.status);
    Ok(text(&said.stdout))
}

/// Whether a name is among those that `list` printed, as a whole word.
pub(super) fn is_listed(listed: &str, name: &str) -> bool {
    listed.split(|c: char| !(c.is_alphanumeric() || c == '-' || c == '_')).any(|word| word == name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_found_as_whole_words() {
        let listed = "infuse-ab-1-2\nsh /data/runs/infuse-ab-1/infuse-ab-1-1.sh 3\n\"name\": \"infuse-cd-7-1\"\ninfuse-ef-1-1[4]";
        for name in ["infuse-ab-1-2", "infuse-ab-1-1", "infuse-cd-7-1", "infuse-ef-1-1"] {
            assert!(is_listed(listed, name), "{name}");
        }
        for name in ["infuse-ab-1-3", "infuse-cd-7", "nfuse-ab-1-2"] {
            assert!(!is_listed(listed, name), "{name}");
        }
    }
}
