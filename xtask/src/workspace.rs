//! Where the workspace is, and how to call cargo in it.

use std::env;
use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context as _, Result};

/// The directory of the root manifest.
///
/// # Errors
/// When neither cargo says where this package is nor a directory above the current one holds a workspace.
pub(crate) fn root() -> Result<PathBuf> {
    let start = match env::var_os("CARGO_MANIFEST_DIR") {
        Some(package) => PathBuf::from(package),
        None => env::current_dir().context("no current directory")?,
    };
    start
        .ancestors()
        .find(|directory| directory.join("xtask").is_dir() && directory.join("Cargo.lock").is_file())
        .map(PathBuf::from)
        .with_context(|| format!("no workspace at or above {}", start.display()))
}

/// The cargo that runs this program, called in the root of the workspace.
pub(crate) fn cargo(arguments: &[&str]) -> Result<Command> {
    let mut command = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.args(arguments).current_dir(root()?);
    Ok(command)
}
