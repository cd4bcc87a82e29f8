//! `cargo xtask ci`: everything that a change must pass, one step after the other, up to the first that fails.

use std::io::Write as _;
use std::path::PathBuf;
use std::process::Command;
use std::time::Instant;

use anyhow::{Context as _, Result, bail, ensure};
use serde::Deserialize;

use crate::{tidy, workspace};

/// One heading of the output.
struct Step {
    heading: &'static str,
    run: fn() -> Result<()>,
}

/// Cheap steps first, so that a small slip costs seconds.
const STEPS: &[Step] = &[
    Step { heading: "format", run: || cargo(&["fmt", "--all", "--check"]) },
    Step { heading: "tidy", run: tidy::check },
    Step { heading: "clippy", run: || cargo(&["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"]) },
    Step { heading: "tests", run: || cargo(&["test", "--workspace", "--lib", "--bins", "--tests"]) },
    Step { heading: "tests in the documentation", run: || cargo(&["test", "--workspace", "--doc"]) },
    Step { heading: "documentation", run: documentation },
    // The lanes are other machine code in a release build, and they are what studies fly with.
    Step { heading: "rig, optimized", run: || cargo(&["test", "--release", "--package", "water-channel", "--tests"]) },
    Step { heading: "examples", run: examples },
    Step { heading: "benches compile", run: || cargo(&["bench", "--workspace", "--no-run"]) },
    Step { heading: "packages", run: packages },
    Step { heading: "optimal designs", run: || cargo(&["xtask", "doe-records", "--check"]) },
    Step { heading: "all chapters", run: || cargo(&["xtask", "reproduce-all", "--check"]) },
];

/// Runs the steps.
pub(crate) fn run() -> Result<()> {
    let start = Instant::now();
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

fn documentation() -> Result<()> {
    let mut command = workspace::cargo(&["doc", "--workspace", "--no-deps"])?;
    run_quietly(command.env("RUSTDOCFLAGS", "-D warnings"))
}

/// Runs every example; optimized, as a user would. All are built at once: one package at a time, each would have the
/// features of its own, and the large dependencies would be compiled anew for many of them.
fn examples() -> Result<()> {
    cargo(&["build", "--release", "--workspace", "--examples", "--all-features"])?;
    let output = workspace::cargo(&["metadata", "--no-deps", "--format-version", "1"])?
        .output()
        .context("cannot start cargo")?;
    if !output.status.success() {
        bail!("cargo metadata: {}", String::from_utf8_lossy(&output.stderr));
    }
    let metadata: Metadata = serde_json::from_slice(&output.stdout).context("cargo metadata")?;
    for name in example_names(&metadata)? {
        let program = metadata.target_directory.join("release/examples").join(name);
        let mut command = Command::new(program.with_extension(std::env::consts::EXE_EXTENSION));
        run_quietly(command.current_dir(workspace::root()?))?;
    }
    Ok(())
}

/// Packs every crate and builds it from its package.
///
/// Crates that need each other are found in the packages made just before, so nothing needs to be published; all else was
/// fetched by the steps before, and `--offline` keeps cargo from asking the registry for news.
fn packages() -> Result<()> {
    cargo(&["package", "--workspace", "--exclude", "xtask", "--allow-dirty", "--offline"])
}

fn cargo(arguments: &[&str]) -> Result<()> {
    run_quietly(&mut workspace::cargo(arguments)?)
}

/// Runs a command and shows what it said only if it failed.
fn run_quietly(command: &mut Command) -> Result<()> {
    let output = command.output().with_context(|| format!("cannot start {command:?}"))?;
    if output.status.success() {
        return Ok(());
    }
    bail!(
        "{}\n{}{}",
        describe(command),
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr),
    )
}

/// The command line as one would type it.
fn describe(command: &Command) -> String {
    let arguments = command.get_args().map(|argument| argument.to_string_lossy());
    std::iter::once("cargo".into()).chain(arguments).collect::<Vec<_>>().join(" ")
}

#[derive(Deserialize)]
struct Metadata {
    packages: Vec<Package>,
    target_directory: PathBuf,
}

#[derive(Deserialize)]
struct Package {
    targets: Vec<Target>,
}

#[derive(Deserialize)]
struct Target {
    name: String,
    kind: Vec<String>,
}

/// The examples of all packages. No two may share a name: they are built into one folder.
fn example_names(metadata: &Metadata) -> Result<Vec<&str>> {
    let targets = metadata.packages.iter().flat_map(|package| &package.targets);
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

    #[test]
    fn failing_command_is_shown_with_what_it_said() {
        let error = cargo(&["no-such-command"]).expect_err("no such command");
        let text = format!("{error:#}");
        assert!(text.starts_with("cargo no-such-command\n"), "{text}");
        assert!(text.contains("no such command: `no-such-command`"), "{text}");
    }

    fn metadata(second: &str) -> Metadata {
        let text = r#"{"target_directory": "target", "packages": [{"name": "a", "targets": [
            {"name": "a", "kind": ["lib"]}, {"name": "first", "kind": ["example"]}]},
            {"name": "b", "targets": [{"name": "it", "kind": ["test"]}, {"name": "SECOND", "kind": ["example"]}]}]}"#;
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
