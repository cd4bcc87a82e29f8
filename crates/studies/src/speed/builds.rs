//! How long the compiler takes from nothing, for each thing that one waits for.

use std::io::ErrorKind;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Instant;

use anyhow::{Context as _, Result, ensure};

use super::page::Built;

/// In the root; made and removed.
const TARGET: &str = "target/from-nothing";
const BUILD: &[&str] = &["build", "--release", "--locked"];

/// What is built, in words, and by which words after `cargo build --release --locked`.
const BUILDS: [(&str, &[&str]); 3] = [
    ("the first command, Chapter 4", &["--package", "studies", "--bin", "studies", "--no-default-features"]),
    ("the shell `infuse`", &["--package", "infuse-cli"]),
    ("everything, tests and examples too", &["--workspace", "--all-targets"]),
];

/// How many there are.
pub(super) const COUNT: usize = BUILDS.len();

/// Each in a folder of its own, with all packages fetched before; `done` gets each.
pub(super) fn measured(root: &Path, mut done: impl FnMut()) -> Result<Vec<Built>> {
    cargo(root, &["fetch", "--locked"], None)?;
    let target = root.join(TARGET);
    let mut built = Vec::with_capacity(BUILDS.len());
    for (words, arguments) in BUILDS {
        remove(&target)?;
        let start = Instant::now();
        cargo(root, &[BUILD, arguments].concat(), Some(&target))?;
        built.push(Built { words, seconds: start.elapsed().as_secs_f64() });
        done();
    }
    remove(&target)?;
    Ok(built)
}

pub(super) fn remove(folder: &Path) -> Result<()> {
    match std::fs::remove_dir_all(folder) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(error).context(folder.display().to_string()),
        _ => Ok(()),
    }
}

pub(super) fn cargo(root: &Path, arguments: &[&str], target: Option<&Path>) -> Result<()> {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.args(arguments).arg("--quiet").current_dir(root).stdin(Stdio::null());
    if let Some(target) = target {
        command.env("CARGO_TARGET_DIR", target);
    }
    let status = command.status().context("cannot start cargo")?;
    ensure!(status.success(), "`cargo {}` failed", arguments.join(" "));
    Ok(())
}
