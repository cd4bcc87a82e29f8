//! Where the workspace is, and how to call cargo in it.

use std::env;
use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Mutex, OnceLock, PoisonError};
use std::thread;

use anyhow::{Context as _, Result, bail};
use serde::Deserialize;

/// The library that Python loads.
pub(crate) const PYTHON_PACKAGE: &str = "infuse-python";

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

/// What compiles our own packages, if it is not the compiler itself.
static COMPILER: OnceLock<PathBuf> = OnceLock::new();
/// By this cargo knows it.
pub(crate) const COMPILED_BY: &str = "RUSTC_WORKSPACE_WRAPPER";

/// From now on, cargo compiles our own packages by this program.
pub(crate) fn compile_by(program: PathBuf) {
    COMPILER.get_or_init(|| program);
}

/// What [`compile_by`] was given.
pub(crate) fn compiler() -> Option<&'static Path> {
    COMPILER.get().map(PathBuf::as_path)
}

/// The cargo that runs this program, called in the root of the workspace.
pub(crate) fn cargo(arguments: &[&str]) -> Result<Command> {
    let mut command = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.args(arguments).current_dir(root()?);
    if let Some(program) = COMPILER.get() {
        command.env(COMPILED_BY, program);
    }
    Ok(command)
}

/// A Python that can make an environment with pip: the one in `PYTHON`, or `python3`.
pub(crate) fn interpreter() -> Option<PathBuf> {
    let python = PathBuf::from(env::var_os("PYTHON").unwrap_or_else(|| "python3".into()));
    let found = Command::new(&python).args(["-c", "import venv, ensurepip"]).output();
    found.is_ok_and(|output| output.status.success()).then_some(python)
}

/// All packages, but for the Python package where there is no Python. Whatever is compiled, it is these at once: one package
/// at a time, each would have the features of its own, and the large dependencies would be compiled anew for many of them.
pub(crate) fn packages() -> &'static [&'static str] {
    if interpreter().is_some() { &["--workspace"] } else { &["--workspace", "--exclude", PYTHON_PACKAGE] }
}

/// Builds what users run, optimized, with the examples.
pub(crate) fn build_programs() -> Result<()> {
    run_cargo(&[&["build", "--release"], packages(), &["--lib", "--bins", "--examples"]].concat())
}

/// A command of the studies, which were built before.
pub(crate) fn study(words: &[&str]) -> Result<Command> {
    let program = target_directory()?.join("release/studies").with_extension(env::consts::EXE_EXTENSION);
    let mut command = Command::new(program);
    command.args(words).current_dir(root()?);
    Ok(command)
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

/// Runs as many commands at a time as there are processors; all are run, and the first complaint counts.
pub(crate) fn run_side_by_side(commands: Vec<Command>) -> Result<()> {
    let n_threads = thread::available_parallelism().map_or(1, NonZero::get).min(commands.len());
    let waiting = Mutex::new(commands.into_iter());
    let next = || waiting.lock().unwrap_or_else(PoisonError::into_inner).next();
    let work = || {
        let mut outcome = Ok(());
        while let Some(mut command) = next() {
            let ran = run_quietly(&mut command);
            outcome = outcome.and(ran);
        }
        outcome
    };
    thread::scope(|scope| {
        let threads: Vec<_> = (0..n_threads).map(|_| scope.spawn(work)).collect();
        let ended = threads.into_iter().map(|thread| thread.join().unwrap_or_else(|_| bail!("a thread panicked")));
        ended.fold(Ok(()), Result::and)
    })
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
    pub(crate) manifest_path: PathBuf,
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

    #[test]
    fn one_that_fails_is_told_though_others_pass() {
        let commands = |failing: Option<usize>| {
            (0..3).map(|place| Command::new(if failing == Some(place) { "false" } else { "true" })).collect()
        };
        run_side_by_side(commands(None)).expect("all pass");
        for place in 0..3 {
            let error = run_side_by_side(commands(Some(place))).expect_err("one fails");
            assert!(error.to_string().contains("false"), "{error}");
        }
    }
}
