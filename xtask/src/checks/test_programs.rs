//! The tests of the workspace: compiled by cargo, then run side by side. Cargo runs one program of tests after the other,
//! and those of the shell mostly wait for others' programs.

use std::fs;
use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use anyhow::{Context as _, Result, bail, ensure};
use serde::Deserialize;

use crate::workspace::{self, run_quietly};

/// A program of tests, and the folder of its package, where it expects to be run.
#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
struct TestProgram {
    path: PathBuf,
    folder: PathBuf,
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
    // The largest first: nobody should wait for one that was begun last.
    programs.sort_by_key(|program| std::cmp::Reverse(fs::metadata(&program.path).map_or(0, |data| data.len())));
    run_side_by_side(&programs)
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

/// As many at a time as there are processors; all are run, and the first complaint counts.
fn run_side_by_side(programs: &[TestProgram]) -> Result<()> {
    let next = AtomicUsize::new(0);
    let work = || -> Result<()> {
        let mut outcome = Ok(());
        while let Some(program) = programs.get(next.fetch_add(1, Ordering::Relaxed)) {
            let ran = run_quietly(Command::new(&program.path).current_dir(&program.folder));
            outcome = outcome.and(ran);
        }
        outcome
    };
    let n_threads = thread::available_parallelism().map_or(1, NonZero::get).min(programs.len());
    thread::scope(|scope| {
        let threads: Vec<_> = (0..n_threads).map(|_| scope.spawn(work)).collect();
        let ended = threads.into_iter().map(|thread| thread.join().unwrap_or_else(|_| bail!("a thread panicked")));
        ended.fold(Ok(()), Result::and)
    })
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

    #[test]
    fn one_that_fails_is_told_though_others_pass() {
        let program = |name: &str| TestProgram { path: name.into(), folder: std::env::temp_dir() };
        let passing = ["true", "true", "true"].map(program);
        run_side_by_side(&passing).expect("all pass");
        for place in 0..3 {
            let mut programs = ["true", "true", "true"].map(program);
            programs[place] = program("false");
            let error = run_side_by_side(&programs).expect_err("one fails");
            assert!(error.to_string().contains("false"), "{error}");
        }
    }
}
