//! The compiler as `ci` calls it for tests: what they call of other crates is optimized, they themselves are not, and a crate with the
//! tests within it neither.
//!
//! A program of tests is used once, and takes longer to optimize than to run. Cargo has one profile for a package and its tests; so
//! this program stands between cargo and the compiler (`RUSTC_WRAPPER`), and takes the optimization off what is compiled with
//! `--test`. All else is compiled as cargo says, and what cargo has compiled without it is taken over.

use std::env;
use std::ffi::{OsStr, OsString};
use std::process::{Command, ExitCode};

use anyhow::{Context as _, Result};

/// Says that this program stands for the compiler; holds a wrapper that a person has set, or nothing.
const MARK: &str = "CHECKS_STAND_FOR_THE_COMPILER";
const WRAPPER: &str = "RUSTC_WRAPPER";

/// Lets cargo compile by this program.
pub(crate) fn set_for(cargo: &mut Command) -> Result<()> {
    let next = env::var_os(WRAPPER).unwrap_or_default();
    cargo.env(MARK, next).env(WRAPPER, env::current_exe().context("where this program is")?);
    Ok(())
}

/// Compiles, if that is what this program was started for.
pub(crate) fn stand_in() -> Option<ExitCode> {
    let wrapper = env::var_os(MARK)?;
    let command: Vec<OsString> = env::args_os().skip(1).collect();
    let code = match compile(&wrapper, &command) {
        Ok(code) => code,
        Err(error) => {
            eprintln!("error: {error:#}");
            1
        }
    };
    Some(ExitCode::from(code))
}

fn compile(wrapper: &OsStr, command: &[OsString]) -> Result<u8> {
    let words: Vec<&OsStr> = Some(wrapper).filter(|wrapper| !wrapper.is_empty()).into_iter().collect();
    let words: Vec<&OsStr> = words.into_iter().chain(command.iter().map(OsString::as_os_str)).collect();
    let (program, arguments) = words.split_first().context("cargo names no compiler")?;
    let mut compiler = Command::new(program);
    compiler.args(arguments).args(added(arguments)).env_remove(MARK);
    let status = compiler.status().with_context(|| format!("cannot start {}", program.display()))?;
    Ok(status.code().and_then(|code| u8::try_from(code).ok()).unwrap_or(1))
}

/// What is added to the arguments of the compiler: of two levels, it takes the last.
fn added(arguments: &[&OsStr]) -> &'static [&'static str] {
    if arguments.iter().any(|argument| *argument == "--test") { &["-C", "opt-level=0"] } else { &[] }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn added_to(line: &str) -> &'static [&'static str] {
        added(&line.split(' ').map(OsStr::new).collect::<Vec<_>>())
    }

    #[test]
    fn tests_alone_are_compiled_without_optimization() {
        assert_eq!(added_to("--crate-name it tests/it/main.rs -C opt-level=3 --test"), ["-C", "opt-level=0"]);
        assert!(added_to("--crate-name surface src/lib.rs -C opt-level=3").is_empty(), "a library");
    }
}
