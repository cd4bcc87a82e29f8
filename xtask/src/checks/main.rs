//! Runs the checks of the workspace; `cargo xtask` starts it.
#![expect(clippy::print_stdout, reason = "a program of the command line talks")]

mod ci;
mod compiler;
mod fuzz;
mod licenses;
mod machines;
mod packages;
mod proofs;
mod python;
mod semver;
mod test_programs;
mod tidy;
mod tutorials;
mod workspace;

use std::process::ExitCode;

use tutorials::Texts;

/// The exit code for arguments that a command does not have.
const USAGE_ERROR: u8 = 2;

fn main() -> ExitCode {
    if let Some(code) = compiler::stand_in() {
        return code;
    }
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let outcome = match words.as_slice() {
        ["ci"] => ci::run(),
        ["tidy"] => tidy::run(),
        ["fuzz"] => fuzz::replay(),
        ["fuzz", reader, minutes] => fuzz::run(reader, minutes),
        ["machines"] => machines::run(),
        ["proofs"] => proofs::run(),
        ["packages"] => packages::check(packages::Features::OfThePublished),
        ["semver", revision] => semver::check(revision),
        ["licenses"] => licenses::run(Texts::Compare),
        ["licenses", "--write"] => licenses::run(Texts::Write),
        ["python"] => python::check(python::Build::Wheel),
        ["equations"] => tidy::write_equations(),
        ["tutorials"] => tutorials::run(Texts::Compare),
        ["tutorials", "--write"] => tutorials::run(Texts::Write),
        unknown => {
            eprintln!("error: no command `{}`: `cargo xtask help` lists them", unknown.join(" "));
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
