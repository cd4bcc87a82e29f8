//! The tests of the workspace: compiled by cargo, then run side by side. Cargo runs one program of tests after the other,
//! and those of the shell mostly wait for others' programs.

use std::fs;
use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context as _, Result, bail, ensure};
use serde::Deserialize;

use crate::workspace::{self, run_side_by_side};

/// The seed of the cases that properties are tested on.
const CASES: &str = "PROPTEST_RNG_SEED";

const THREADS: &str = "RUST_TEST_THREADS";
/// A package whose tests mostly wait, and how many of them are run for each processor.
const WAITING: &str = "infuse-cli";
const AT_ONCE: usize = 2;

/// A program of tests, and the folder of its package, where it expects to be run.
#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
struct TestProgram {
    path: PathBuf,
    folder: PathBuf,
}

impl TestProgram {
    /// Whether it is of the package whose tests mostly wait.
    fn waits(&self) -> bool {
        self.folder.ends_with(WAITING)
    }
}

/// Compiles and runs the tests that these arguments of `cargo test` select.
pub(crate) fn run(selection: &[&str]) -> Result<()> {
    let arguments = [&["test", "--no-run", "--message-format", "json-render-diagnostics"], selection].concat();
    let output = workspace::cargo(&arguments)?.output().context("cannot start cargo")?;
    if !output.status.success() {
        bail!("cargo {}\n{}", arguments.join(" "), String::from_utf8_lossy(&output.stderr));
    }
    let mut programs = programs(&String::from_utf8_lossy(&output.stdout))?;
    ensure!(!programs.is_empty(), "cargo {} selects no test", selection.join(" "));
    // Those that wait first, and then the largest: nobody should wait for one that was begun last.
    programs.sort_by_key(|program| {
        (!program.waits(), std::cmp::Reverse(fs::metadata(&program.path).map_or(0, |data| data.len())))
    });
    let command = |program: &TestProgram| {
        let mut command = Command::new(&program.path);
        command.current_dir(&program.folder);
        if program.waits() && std::env::var_os(THREADS).is_none() {
            let n_processors = std::thread::available_parallelism().map_or(1, NonZero::get);
            command.env(THREADS, (AT_ONCE * n_processors).to_string());
        }
        // What passed today passes tomorrow; whoever types `cargo test` has cases that nobody saw.
        if std::env::var_os(CASES).is_none() {
            command.env(CASES, "1");
        }
        command
    };
    run_side_by_side(programs.iter().map(command).collect())
}

/// What cargo says of what it compiled.
#[derive(Deserialize)]
struct Message {
    reason: String,
    executable: Option<PathBuf>,
    manifest_path: Option<PathBuf>,
    profile: Option<Profile>,
}

#[derive(Deserialize)]
struct Profile {
    test: bool,
}

/// The programs among cargo's messages, a line each.
fn programs(messages: &str) -> Result<Vec<TestProgram>> {
    let mut programs = Vec::new();
    for line in messages.lines().filter(|line| line.starts_with('{')) {
        let message: Message = serde_json::from_str(line).context("a message of cargo")?;
        let is_test = message.reason == "compiler-artifact" && message.profile.is_some_and(|profile| profile.test);
        if let (true, Some(path), Some(manifest)) = (is_test, message.executable, message.manifest_path) {
            programs.push(TestProgram { path, folder: manifest.parent().unwrap_or(Path::new(".")).to_owned() });
        }
    }
    Ok(programs)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(reason: &str, test: bool, executable: &str) -> String {
        format!(
            r#"{{"reason": "{reason}", "manifest_path": "/w/crates/a/Cargo.toml", "profile": {{"test": {test}}}, "executable": {executable}}}"#
        )
    }

    #[test]
    fn programs_of_tests_are_told_from_all_else_that_is_compiled() {
        let messages = [
            message("compiler-artifact", true, r#""/w/target/a-1""#),
            message("compiler-artifact", false, r#""/w/target/a""#),
            message("compiler-artifact", true, "null"),
            r#"{"reason": "build-finished", "success": true}"#.to_owned(),
        ];
        let expected = TestProgram { path: "/w/target/a-1".into(), folder: "/w/crates/a".into() };
        assert_eq!(programs(&messages.join("\n")).expect("messages"), [expected]);
    }
}
