//! `cargo xtask ci`: everything that a change must pass, one step after the other, up to the first that fails.

use std::io::Write as _;
use std::process::Command;
use std::time::Instant;

use anyhow::{Context as _, Result, ensure};

use crate::compiler::Task;
use crate::workspace::{self, Metadata, metadata, run_cargo, run_quietly, run_side_by_side};
use crate::{compiler, fuzz, licenses, packages, python, test_programs, tidy, tutorials};

/// One heading of the output.
struct Step {
    heading: &'static str,
    run: fn() -> Result<()>,
}

/// Cheap steps first, so that a small slip costs seconds. All in the release profile, so that each dependency is compiled
/// once, and so that what flies is optimized as it is in the studies.
const STEPS: &[Step] = &[
    Step { heading: "format", run: || run_cargo(&["fmt", "--all", "--check"]) },
    Step { heading: "tidy", run: tidy::check },
    Step { heading: "compiler, clippy, rustdoc", run: compile },
    Step { heading: "the least of each feature", run: lints_of_least },
    Step { heading: "tests", run: || test_programs::run(&test_selection()) },
    Step {
        heading: "tests in the documentation",
        run: || run_cargo(&[&["test", "--release"], workspace::packages(), &["--doc"]].concat()),
    },
    Step { heading: "examples", run: examples },
    Step { heading: "files of the fuzzer", run: fuzz::replay },
    Step { heading: "tutorials", run: tutorials::check },
    Step { heading: "packages", run: || packages::check(packages::Features::OfTheWorkspace) },
    Step { heading: "licenses", run: || licenses::run(tutorials::Texts::Compare) },
    Step { heading: "python", run: || python::check(python::Build::Library) },
    Step { heading: "flights in lanes", run: || studies(&[&["speed", "--guard"]]) },
    Step { heading: "chapters, campaigns, designs", run: || studies(STUDIES) },
];

/// Each on one thread for much of its time, the longest first.
const STUDIES: &[&[&str]] = &[
    &["reproduce-all", "--check"],
    &["calibrate", "--check"],
    &["doe-records", "--check"],
    &["reproduce-all", "--ensemble", "--check"],
    &["benchmark", "--constrained", "--check"],
    &["benchmark", "--drift", "--check"],
    &["plants", "--check"],
    &["identify", "--check"],
];

/// Runs the steps.
pub(crate) fn run() -> Result<()> {
    let start = Instant::now();
    python::begin();
    workspace::compile_by(compiler::prepare(&workspace::root()?, &workspace::target_directory()?)?);
    for (number, step) in STEPS.iter().enumerate() {
        print!("[{}/{}] {:28}", number + 1, STEPS.len(), step.heading);
        std::io::stdout().flush().context("standard output")?;
        let step_start = Instant::now();
        let outcome = (step.run)();
        let verdict = if outcome.is_ok() { "ok" } else { "FAILED" };
        println!("{:7.1} s  {verdict}", step_start.elapsed().as_secs_f64());
        outcome.with_context(|| format!("step `{}` failed", step.heading))?;
    }
    println!("All passed in {:.0} s.", start.elapsed().as_secs_f64());
    Ok(())
}

/// Compiles everything, and reads it for lints and for its documentation. The examples are compiled with the tests, whose
/// dependencies they share. No kind of target is named: a library that has no tests, as its manifest says, would be compiled for
/// them all the same.
fn compile() -> Result<()> {
    run_cargo(&[&["test", "--no-run"], test_selection().as_slice()].concat())?;
    run_cargo(&[&["build", "--release"], workspace::packages(), &["--bench", "*"]].concat())
}

fn test_selection() -> Vec<&'static str> {
    [&["--release"], workspace::packages()].concat()
}

/// What each feature leaves at the least: of these packages together, because none of them turns on a feature of another, and what
/// they share is then checked once. Of others' packages it is what was compiled for programs.
fn lints_of_least() -> Result<()> {
    let packages = ["--package", "infuse-loop", "--package", "infuse-scaling", "--package", "studies"];
    let command = ["build", "--release", "--no-default-features"];
    let mut cargo = workspace::cargo(&[command.as_slice(), &packages].concat())?;
    let compiler = workspace::compiler().context("nothing stands in for the compiler")?;
    run_quietly(compiler::for_task(&mut cargo, compiler, Task::Lints))
}

/// Runs studies by the program that was built with all others.
fn studies(commands: &[&[&str]]) -> Result<()> {
    workspace::build_programs()?;
    run_side_by_side(commands.iter().map(|words| workspace::study(words)).collect::<Result<_>>()?)
}

/// Runs every example, where what it writes is in nobody's way.
fn examples() -> Result<()> {
    workspace::build_programs()?;
    let metadata = metadata()?;
    let folder = metadata.target_directory.join("examples");
    std::fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
    let command = |name: &str| {
        let program = metadata.target_directory.join("release/examples").join(name);
        let mut command = Command::new(program.with_extension(std::env::consts::EXE_EXTENSION));
        command.current_dir(&folder);
        command
    };
    run_side_by_side(example_names(&metadata)?.into_iter().map(command).collect())
}

/// The examples of all packages. No two may share a name: they are built into one folder.
fn example_names(metadata: &Metadata) -> Result<Vec<&str>> {
    let packages = metadata.packages.iter().filter(|package| package.name != workspace::PYTHON_PACKAGE);
    let targets = packages.flat_map(|package| &package.targets);
    let examples = targets.filter(|target| target.kind.iter().any(|kind| kind == "example"));
    let mut names: Vec<&str> = Vec::new();
    for example in examples {
        ensure!(!names.contains(&example.name.as_str()), "two examples are called `{}`", example.name);
        names.push(&example.name);
    }
    Ok(names)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn metadata(second: &str) -> Metadata {
        let text = r#"{"target_directory": "target", "packages": [{"name": "a", "version": "0.1.0", "manifest_path": "a/Cargo.toml", "targets": [
            {"name": "a", "kind": ["lib"]}, {"name": "first", "kind": ["example"]}]},
            {"name": "b", "version": "0.1.0", "manifest_path": "b/Cargo.toml", "targets": [{"name": "it", "kind": ["test"]}, {"name": "SECOND", "kind": ["example"]}]}]}"#;
        serde_json::from_str(&text.replace("SECOND", second)).expect("valid")
    }

    #[test]
    fn examples_are_found_by_their_kind() {
        assert_eq!(example_names(&metadata("second")).expect("different names"), ["first", "second"]);
    }

    #[test]
    fn two_examples_of_one_name_are_refused() {
        let error = example_names(&metadata("first")).expect_err("the same name");
        assert_eq!(error.to_string(), "two examples are called `first`");
    }

    #[test]
    fn steps_have_different_headings() {
        let mut headings: Vec<_> = STEPS.iter().map(|step| step.heading).collect();
        headings.sort_unstable();
        headings.dedup();
        assert_eq!(headings.len(), STEPS.len());
    }
}
