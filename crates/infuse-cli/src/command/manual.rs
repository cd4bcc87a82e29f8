//! What a system installs beside the program: completions for shells, and manual pages. Both follow from what can be typed.

use std::fs;
use std::path::Path;

use anyhow::{Context as _, Result};
use clap::CommandFactory as _;
use clap_complete::Shell;
use clap_mangen::Man;
use serde_json::json;

use super::output::Output;
use crate::arguments::Arguments;

/// Completions of this shell.
pub(super) fn completions(shell: Shell) -> Result<Output> {
    let mut written = Vec::new();
    clap_complete::generate(shell, &mut Arguments::command(), "infuse", &mut written);
    let text = String::from_utf8(written).context("the completions are no text")?;
    Ok(Output { json: json!({ "shell": shell.to_string(), "completions": text }), text, notices: Vec::new() })
}

/// The license of the program, and of what it contains of others.
pub(super) fn licenses() -> Output {
    let (own, others) = (include_str!("../../LICENSE"), include_str!("../../THIRD-PARTY-LICENSES.txt"));
    let text = format!("{}\n\n{}", own.trim_end(), others.trim_end());
    Output { json: json!({ "license": own, "of_others": others }), text, notices: Vec::new() }
}

/// The manual page of the program, or all pages into a folder: that of the program and one for each command.
pub(super) fn manual(folder: Option<&Path>) -> Result<Output> {
    let command = Arguments::command();
    let Some(folder) = folder else {
        let text = page(command)?;
        return Ok(Output { json: json!({ "manual": text }), text, notices: Vec::new() });
    };
    fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    clap_mangen::generate_to(command, folder).with_context(|| folder.display().to_string())?;
    let mut pages = Vec::new();
    for entry in fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let name = entry.with_context(|| folder.display().to_string())?.file_name().to_string_lossy().into_owned();
        pages.extend(Some(name).filter(|name| name.starts_with("infuse") && name.ends_with(".1")));
    }
    pages.sort();
    let text = format!("{} manual pages written to {}.", pages.len(), folder.display());
    Ok(Output { json: json!({ "folder": folder, "pages": pages }), text, notices: Vec::new() })
}

fn page(command: clap::Command) -> Result<String> {
    let mut written = Vec::new();
    Man::new(command).render(&mut written).context("the manual page cannot be written")?;
    String::from_utf8(written).context("the manual page is no text")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn completions_know_every_command() {
        for shell in [Shell::Bash, Shell::Zsh, Shell::Fish] {
            let text = completions(shell).expect("completions").text;
            for command in Arguments::command().get_subcommands() {
                assert!(text.contains(command.get_name()), "{shell} does not know {}", command.get_name());
            }
        }
    }

    #[test]
    fn each_command_has_a_page() {
        let folder = tempfile::tempdir().expect("a folder");
        manual(Some(folder.path())).expect("pages");
        let ask = fs::read_to_string(folder.path().join("infuse-ask.1")).expect("a page");
        assert!(ask.contains("Say which experiments to run now") && ask.contains(r"\-\-resimulate"), "{ask}");
        let pages = fs::read_dir(folder.path()).expect("a folder").count();
        assert!(pages > Arguments::command().get_subcommands().count(), "{pages} pages");
        assert!(
            manual(None).expect("a page").text.contains(r"infuse\-ask(1)"),
            "the page of the program names the others"
        );
    }
}
