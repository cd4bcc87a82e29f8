//! Runs the studies and the checks of the workspace: `cargo xtask <command>`.
#![expect(clippy::print_stdout, reason = "a program of the command line talks")]

mod chapter2;
mod chapter3;
mod chapter4;
mod chapter6;
mod chapter7;
mod ci;
mod claims;
mod design_page;
mod doe_records;
mod exemptions;
mod figures;
mod gridded;
mod handover;
mod page;
mod reproduce_all;
mod reproduction;
mod study;
mod table;
mod tidy;
mod tutorials;
mod workspace;

use std::path::Path;
use std::process::ExitCode;

use reproduction::{Extent, Reproduction};
use tutorials::Texts;

const USAGE: &str = include_str!("usage.txt");

static STUDIES: [Reproduction; 6] = [
    chapter2::CHAPTER,
    chapter3::CHAPTER,
    chapter4::CHAPTER,
    chapter6::CHAPTER,
    chapter7::CHAPTER,
    doe_records::RECORDS,
];

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
        [name] if study(name).is_some() => run_study(name, |study, root| study.run(root, Extent::Default)),
        [name, "--full"] if study(name).is_some() => run_study(name, |study, root| study.run(root, Extent::Full)),
        [name, "--check"] if study(name).is_some() => run_study(name, Reproduction::check),
        ["reproduce-all"] => workspace::root().and_then(|root| reproduce_all::run(&root, &STUDIES, false)),
        ["reproduce-all", "--check"] => workspace::root().and_then(|root| reproduce_all::run(&root, &STUDIES, true)),
        ["design-page", evaluation, page] => design_page::run(Path::new(evaluation), Path::new(page)),
        ["ci"] => ci::run(),
        ["tidy"] => tidy::run(),
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
