//! Runs the studies and the checks of the workspace: `cargo xtask <command>`.
#![expect(clippy::print_stdout, reason = "a program of the command line talks")]

mod chapter4;
mod ci;
mod figures;
mod page;
mod study;
mod table;
mod tidy;
mod workspace;

use std::process::ExitCode;

const USAGE: &str = "\
cargo xtask <command>

Studies:
  reproduce-chapter4   the loop of Chapter 3 on the case study of Chapter 4; writes target/reproduction/chapter4/;
                       with --check, fails when docs/results-chapter4.md says something else

Checks:
  ci      everything that a change must pass; quiet until a step fails
  tidy    the rules of the tree that no compiler checks

  help    this text";

/// The exit code for a command that does not exist.
const USAGE_ERROR: u8 = 2;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let outcome = match words.as_slice() {
        ["reproduce-chapter4"] => workspace::root().and_then(|root| chapter4::reproduce(&root)),
        ["reproduce-chapter4", "--check"] => workspace::root().and_then(|root| chapter4::check(&root)),
        ["ci"] => ci::run(),
        ["tidy"] => tidy::run(),
        ["help" | "--help" | "-h"] => {
            println!("{USAGE}");
            Ok(())
        }
        [] => {
            eprintln!("{USAGE}");
            return ExitCode::from(USAGE_ERROR);
        }
        unknown => {
            eprintln!("error: no command `{}`\n\n{USAGE}", unknown.join(" "));
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
