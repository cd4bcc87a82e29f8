//! `cargo xtask <command>`: starts the program that does it, built with no more than it needs.
//!
//! This program depends on nothing, so that the first page of a study waits for no library of the checks.
#![expect(clippy::print_stdout, reason = "a program of the command line talks")]

mod forms;

use std::env;
use std::path::PathBuf;
use std::process::{Command, ExitCode};

const USAGE: &str = include_str!("usage.txt");

/// What a command is done by: a program of a package, with features of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Program {
    package: &'static str,
    name: &'static str,
    features: &'static str,
}

const fn studies(features: &'static str) -> Program {
    Program { package: "studies", name: "studies", features }
}

const CHECKS: Program = Program { package: "xtask", name: "checks", features: "checks" };

/// Chapters 3 and 4 need neither designs of experiments nor surfaces nor similarity.
const COMMANDS: &[(&[&str], Program)] = &[
    (&["reproduce-chapter2"], studies("similarity")),
    (&["reproduce-chapter3", "reproduce-chapter4"], studies("")),
    (&["reproduce-chapter6", "reproduce-chapter7", "doe-records", "design-page"], studies("similarity,global")),
    (&["reproduce-all"], studies("similarity,ensemble")),
    (&["benchmark", "plants", "speed"], studies("similarity,benchmark")),
    (&["calibrate"], studies("similarity,calibration")),
    (&["identify"], studies("similarity,identification")),
    (&["ci", "tidy", "equations", "fuzz", "tutorials", "python"], CHECKS),
    (&["licenses", "machines", "packages", "proofs", "semver"], CHECKS),
];

const USAGE_ERROR: u8 = 2;

fn main() -> ExitCode {
    let words: Vec<String> = env::args().skip(1).collect();
    let Some(first) = words.first() else {
        eprint!("{USAGE}");
        return ExitCode::from(USAGE_ERROR);
    };
    if forms::ask_for_help(&words) {
        print!("{USAGE}");
        return ExitCode::SUCCESS;
    }
    let Some(program) = program(first) else {
        eprintln!("error: no command `{}`\n\n{}", words.join(" "), USAGE.trim_end());
        return ExitCode::from(USAGE_ERROR);
    };
    if let Some(others) = forms::others(&words) {
        eprintln!("error: {others}");
        return ExitCode::from(USAGE_ERROR);
    }
    start(program, &words).unwrap_or_else(|error| {
        eprintln!("error: cannot start cargo: {error}");
        ExitCode::FAILURE
    })
}

fn program(command: &str) -> Option<Program> {
    COMMANDS.iter().find(|(names, _)| names.contains(&command)).map(|(_, program)| *program)
}

/// Builds a program and runs it in the root of the workspace; its output and its exit code are ours.
fn start(Program { package, name, features }: Program, words: &[String]) -> std::io::Result<ExitCode> {
    let mut cargo = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    cargo.args(["run", "--release", "--package", package, "--bin", name]);
    cargo.args(["--no-default-features", "--features", features, "--"]).args(words);
    if let Some(here) = env::var_os("CARGO_MANIFEST_DIR").map(PathBuf::from)
        && let Some(root) = here.parent()
    {
        cargo.current_dir(root);
    }
    let code = cargo.status()?.code().and_then(|code| u8::try_from(code).ok());
    Ok(code.map_or(ExitCode::FAILURE, ExitCode::from))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn usage_and_commands_are_the_same() {
        for command in COMMANDS.iter().flat_map(|(names, _)| *names) {
            let named = |line: &str| line.split_whitespace().next() == Some(*command);
            assert!(USAGE.lines().any(named), "{command} is not in the usage");
            assert!(forms::all().any(|form| form.split(' ').next() == Some(*command)), "{command} has no form");
        }
        assert_eq!(program("reproduce-chapter4"), Some(studies("")));
        assert_eq!(program("no-such-command"), None);
    }
}
