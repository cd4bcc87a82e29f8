//! `cargo xtask semver`: whether the versions of the libraries say what changed in them since a revision.

use anyhow::Result;

use crate::workspace::{cargo, run_quietly};

/// Not on a registry, or programs.
const LEFT_OUT: [&str; 4] = ["infuse-cli", "infuse-python", "studies", "xtask"];

/// Compares with this revision; says so, and nothing else, where `cargo-semver-checks` is not installed.
pub(crate) fn check(revision: &str) -> Result<()> {
    if !cargo(&["semver-checks", "--version"])?.output().is_ok_and(|output| output.status.success()) {
        println!("NOT CHECKED: `cargo install cargo-semver-checks --locked` gets what is needed");
        return Ok(());
    }
    let mut command = cargo(&["semver-checks", "--workspace", "--baseline-rev", revision])?;
    command.args(LEFT_OUT.iter().flat_map(|package| ["--exclude", package]));
    run_quietly(&mut command)?;
    println!("The versions say what changed since {revision}.");
    Ok(())
}
