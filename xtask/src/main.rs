//! Runs the studies and the checks of the workspace: `cargo xtask <command>`.
#![expect(clippy::print_stdout, reason = "a program of the command line talks")]

mod chapter2;
mod chapter3;
mod chapter4;
mod ci;
mod doe_records;
mod figures;
mod page;
mod reproduction;
mod study;
mod table;
mod tidy;
mod workspace;

use std::path::Path;
use std::process::ExitCode;

use reproduction::Reproduction;

const USAGE: &str = "\
cargo xtask <command>

Studies:
  reproduce-chapter2   similarity: dimensionless groups, Table 2, flights of three models, the rig at full scale
  reproduce-chapter3   open loop: Figure 14, cost over trim pitch and center of mass for four configurations
  reproduce-chapter4   the loop of Chapter 3 on the case study of Chapter 4

  doe-records          optimal designs: the kept ones verified beside the published record, and searched for anew

  Each writes to its folder in target/reproduction/; with --check it fails when its page docs/results-*.md says something else.

Checks:
  ci      everything that a change must pass; quiet until a step fails
  tidy    the rules of the tree that no compiler checks

  help    this text";

static STUDIES: [Reproduction; 4] = [chapter2::CHAPTER, chapter3::CHAPTER, chapter4::CHAPTER, doe_records::RECORDS];

/// The study that a command names.
fn study(command: &str) -> Option<&'static Reproduction> {
    STUDIES.iter().find(|study| study.command == command)
}

fn run_study(command: &str, run: impl Fn(&Reproduction, &Path) -> anyhow::Result<()>) -> anyhow::Result<()> {
    let root = workspace::root()?;
    study(command).map_or(Ok(()), |study| run(study, &root))
}

/// The exit code for a command that does not exist.
const USAGE_ERROR: u8 = 2;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let outcome = match words.as_slice() {
        [name] if study(name).is_some() => run_study(name, |study, root| (study.run)(root)),
        [name, "--check"] if study(name).is_some() => run_study(name, Reproduction::check),
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
