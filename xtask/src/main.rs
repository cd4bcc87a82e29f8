//! Runs the studies and the checks of the workspace: `cargo xtask <command>`.
#![expect(clippy::print_stdout, reason = "a program of the command line talks")]

mod ci;
mod studies;
mod tidy;
mod tutorials;
mod workspace;

use std::process::ExitCode;

use tutorials::Texts;

const USAGE: &str = include_str!("usage.txt");

/// The exit code for a command that does not exist.
const USAGE_ERROR: u8 = 2;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let outcome = match words.as_slice() {
        [name, ..] if studies::is_study(name) => studies::run(&words),
        ["ci"] => ci::run(),
        ["tidy"] => tidy::run(),
        ["equations"] => tidy::write_equations(),
        ["tutorials"] => tutorials::run(Texts::Compare),
        ["tutorials", "--write"] => tutorials::run(Texts::Write),
        ["help" | "--help" | "-h"] => {
            print!("{USAGE}");
            Ok(())
        }
        [] => {
            eprint!("{USAGE}");
            return ExitCode::from(USAGE_ERROR);
        }
        unknown => {
            eprintln!("error: no command `{}`\n\n{}", unknown.join(" "), USAGE.trim_end());
            return ExitCode::from(USAGE_ERROR);
        }
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}
