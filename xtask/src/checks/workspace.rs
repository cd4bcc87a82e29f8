//! Where the workspace is, and how to call cargo in it.

use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context as _, Result, bail};
use serde::Deserialize;

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

/// Builds what users run, optimized, with the examples. All at once: one package at a time, each would have the features
/// of its own, and the large dependencies would be compiled anew for many of them.
pub(crate) fn build_programs() -> Result<()> {
    run_cargo(&["build", "--release", "--workspace", "--exclude", "infuse-python", "--bins", "--examples"])
}

/// Where cargo puts what it builds.
pub(crate) fn target_directory() -> Result<PathBuf> {
    Ok(metadata()?.target_directory)
}

/// The packages and where they are built.
pub(crate) fn metadata() -> Result<Metadata> {
    let output = cargo(&["metadata", "--no-deps", "--format-version", "1"])?.output().context("cannot start cargo")?;
    if !output.status.success() {
        bail!("cargo metadata: {}", String::from_utf8_lossy(&output.stderr));
    }
    serde_json::from_slice(&output.stdout).context("cargo metadata")
}

/// Runs cargo and shows what it said only if it failed.
pub(crate) fn run_cargo(arguments: &[&str]) -> Result<()> {
    run_quietly(&mut cargo(arguments)?)
}

/// Runs a command and shows what it said only if it failed.
pub(crate) fn run_quietly(command: &mut Command) -> Result<()> {
    let output = command.output().with_context(|| format!("cannot start {command:?}"))?;
    if output.status.success() {
        return Ok(());
    }
    bail!(
        "{}\n{}{}",
        describe(command),
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr),
    )
}

/// The command line as one would type it.
fn describe(command: &Command) -> String {
    let program = Path::new(command.get_program()).file_stem().unwrap_or_default().to_string_lossy();
    let arguments = command.get_args().map(|argument| argument.to_string_lossy());
    std::iter::once(program).chain(arguments).collect::<Vec<_>>().join(" ")
}

/// What `cargo metadata` says.
#[derive(Debug, Deserialize)]
pub(crate) struct Metadata {
    pub(crate) packages: Vec<Package>,
    pub(crate) target_directory: PathBuf,
}

/// What `cargo metadata` says.
#[derive(Debug, Deserialize)]
pub(crate) struct Package {
    pub(crate) name: String,
    pub(crate) version: String,
    pub(crate) targets: Vec<Target>,
}

/// What `cargo metadata` says.
#[derive(Debug, Deserialize)]
pub(crate) struct Target {
    pub(crate) name: String,
    pub(crate) kind: Vec<String>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn failing_command_is_shown_with_what_it_said() {
        let error = run_cargo(&["no-such-command"]).expect_err("no such command");
        let text = format!("{error:#}");
        assert!(text.starts_with("cargo no-such-command\n"), "{text}");
        assert!(text.contains("no such command: `no-such-command`"), "{text}");
    }
}
