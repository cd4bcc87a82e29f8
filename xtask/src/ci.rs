//! `cargo xtask ci`: everything that a change must pass, one step after the other, up to the first that fails.

use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use anyhow::{Context as _, Result, bail, ensure};
use serde::Deserialize;

use crate::{tidy, tutorials, workspace};

/// One heading of the output.
struct Step {
    heading: &'static str,
    run: fn() -> Result<()>,
}

/// Cheap steps first, so that a small slip costs seconds.
const STEPS: &[Step] = &[
    Step { heading: "format", run: || cargo(&["fmt", "--all", "--check"]) },
    Step { heading: "tidy", run: tidy::check },
    // All targets: benches, too, are compiled here.
    Step { heading: "clippy", run: || cargo(&["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"]) },
    // Optimized, as studies fly: the lanes are other machine code then, and one build of the dependencies serves all.
    Step { heading: "tests", run: || cargo(&["test", "--release", "--workspace", "--lib", "--bins", "--tests"]) },
    Step { heading: "tests in the documentation", run: || cargo(&["test", "--release", "--workspace", "--doc"]) },
    Step { heading: "documentation", run: documentation },
    Step { heading: "examples", run: examples },
    Step { heading: "tutorials", run: tutorials::check },
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

/// Builds what users run, the examples and `infuse`, optimized. All at once: one package at a time, each would have the
/// features of its own, and the large dependencies would be compiled anew for many of them.
pub(crate) fn build_programs() -> Result<()> {
    cargo(&["build", "--release", "--workspace", "--examples", "--bin", "infuse", "--all-features"])
}

/// Runs every example.
fn examples() -> Result<()> {
    build_programs()?;
    let metadata = metadata()?;
    for name in example_names(&metadata)? {
        let program = metadata.target_directory.join("release/examples").join(name);
        let mut command = Command::new(program.with_extension(std::env::consts::EXE_EXTENSION));
        run_quietly(command.current_dir(workspace::root()?))?;
    }
    Ok(())
}

/// Packs every crate, and compiles it from what was packed.
///
/// Cargo's own verification unpacks into cargo's home under a name that holds the version but not the content, and finds
/// there what an earlier run has left. So it is done here: the packages are the members of a workspace of their own, in
/// which they find each other, and nothing needs to be published. All else was fetched by the steps before, and
/// `--offline` keeps cargo from asking the registry for news.
fn packages() -> Result<()> {
    cargo(&["package", "--workspace", "--exclude", "xtask", "--allow-dirty", "--offline", "--no-verify"])?;
    let metadata = metadata()?;
    let folder = metadata.target_directory.join("package");
    let unpacked = folder.join("unpacked");
    if unpacked.exists() {
        fs::remove_dir_all(&unpacked).with_context(|| unpacked.display().to_string())?;
    }
    fs::create_dir_all(&unpacked).with_context(|| unpacked.display().to_string())?;
    let packed = metadata.packages.iter().filter(|package| package.name != "xtask");
    let packed: Vec<(&str, String)> =
        packed.map(|package| (&*package.name, format!("{}-{}", package.name, package.version))).collect();
    for (_, stem) in &packed {
        let archive = folder.join(format!("{stem}.crate"));
        run_quietly(Command::new("tar").arg("-xzf").arg(archive).arg("-C").arg(&unpacked))?;
    }
    let manifest = unpacked.join("Cargo.toml");
    fs::write(&manifest, workspace_of(&packed)).with_context(|| manifest.display().to_string())?;
    let lock = "Cargo.lock";
    fs::copy(workspace::root()?.join(lock), unpacked.join(lock)).context(lock)?;
    let arguments = ["check", "--workspace", "--offline"];
    let mut check = workspace::cargo(&arguments)?;
    run_quietly(check.current_dir(&unpacked).arg("--target-dir").arg(&metadata.target_directory))
}

/// A workspace of these unpacked packages, each in the folder of its own name.
fn workspace_of(packed: &[(&str, String)]) -> String {
    let stems: Vec<&String> = packed.iter().map(|(_, stem)| stem).collect();
    let patches: Vec<String> = packed.iter().map(|(name, stem)| format!("{name} = {{ path = {stem:?} }}\n")).collect();
    // The profile of the workspace itself, so that what was compiled with it is used again.
    let profile = "[profile.dev]\nopt-level = 1\ndebug = \"line-tables-only\"\n";
    format!("[workspace]\nresolver = \"3\"\nmembers = {stems:?}\n\n[patch.crates-io]\n{}\n{profile}", patches.concat())
}

/// Where cargo puts what it builds.
pub(crate) fn target_directory() -> Result<PathBuf> {
    Ok(metadata()?.target_directory)
}

fn metadata() -> Result<Metadata> {
    let output = workspace::cargo(&["metadata", "--no-deps", "--format-version", "1"])?
        .output()
        .context("cannot start cargo")?;
    if !output.status.success() {
        bail!("cargo metadata: {}", String::from_utf8_lossy(&output.stderr));
    }
    serde_json::from_slice(&output.stdout).context("cargo metadata")
}

/// Runs cargo and shows what it said only if it failed.
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
    let program = Path::new(command.get_program()).file_stem().unwrap_or_default().to_string_lossy();
    let arguments = command.get_args().map(|argument| argument.to_string_lossy());
    std::iter::once(program).chain(arguments).collect::<Vec<_>>().join(" ")
}

#[derive(Deserialize)]
struct Metadata {
    packages: Vec<Package>,
    target_directory: PathBuf,
}

#[derive(Deserialize)]
struct Package {
    name: String,
    version: String,
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
        let text = r#"{"target_directory": "target", "packages": [{"name": "a", "version": "0.1.0", "targets": [
            {"name": "a", "kind": ["lib"]}, {"name": "first", "kind": ["example"]}]},
            {"name": "b", "version": "0.1.0", "targets": [{"name": "it", "kind": ["test"]}, {"name": "SECOND", "kind": ["example"]}]}]}"#;
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
