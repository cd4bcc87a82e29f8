//! `cargo xtask ci`: everything that a change must pass, one step after the other, up to the first that fails.

use std::fs;
use std::io::Write as _;
use std::process::Command;
use std::time::Instant;

use anyhow::{Context as _, Result, ensure};

use crate::workspace::{self, Metadata, metadata, run_cargo, run_quietly};
use crate::{licenses, python, tidy, tutorials};

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
    Step { heading: "clippy", run: clippy },
    Step { heading: "tests", run: tests },
    Step {
        heading: "tests in the documentation",
        run: || run_cargo(&["test", "--release", "--workspace", "--exclude", python::PACKAGE, "--doc"]),
    },
    Step { heading: "documentation", run: documentation },
    Step { heading: "examples", run: examples },
    Step { heading: "tutorials", run: tutorials::check },
    Step { heading: "packages", run: packages },
    Step { heading: "licenses", run: || licenses::run(tutorials::Texts::Compare) },
    Step { heading: "python", run: python::check },
    Step { heading: "optimal designs", run: || study(&["doe-records", "--check"]) },
    Step { heading: "calibrated plants", run: || study(&["calibrate", "--check"]) },
    Step { heading: "identified plants", run: || study(&["identify", "--check"]) },
    Step { heading: "claims over the ensemble", run: || study(&["reproduce-all", "--ensemble", "--check"]) },
    Step { heading: "all chapters", run: || study(&["reproduce-all", "--check"]) },
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

/// The whole workspace, and the least that each feature leaves: of these packages together, because none of them turns on
/// a feature of another, and what they share is then checked once.
fn clippy() -> Result<()> {
    let deny = ["--", "-D", "warnings"];
    let all = ["clippy", "--release", "--workspace", "--exclude", python::PACKAGE, "--all-targets"];
    run_cargo(&[all.as_slice(), &deny].concat())?;
    let packages = ["--package", "infuse-loop", "--package", "infuse-scaling", "--package", "studies"];
    let command = ["clippy", "--release", "--no-default-features"];
    run_cargo(&[command.as_slice(), &packages, &deny].concat())
}

/// The examples are compiled with the tests, whose dependencies they share.
fn tests() -> Result<()> {
    let all = ["test", "--release", "--workspace", "--exclude", python::PACKAGE];
    run_cargo(&[all.as_slice(), &["--lib", "--bins", "--tests", "--examples"]].concat())
}

fn documentation() -> Result<()> {
    let mut command =
        workspace::cargo(&["doc", "--release", "--workspace", "--exclude", python::PACKAGE, "--no-deps"])?;
    run_quietly(command.env("RUSTDOCFLAGS", "-D warnings"))
}

/// Runs a study by the program that was built with all others.
fn study(words: &[&str]) -> Result<()> {
    workspace::build_programs()?;
    let program = metadata()?.target_directory.join("release/studies").with_extension(std::env::consts::EXE_EXTENSION);
    run_quietly(Command::new(program).args(words).current_dir(workspace::root()?))
}

/// Runs every example.
fn examples() -> Result<()> {
    workspace::build_programs()?;
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
    run_cargo(&[
        "package",
        "--workspace",
        "--exclude",
        "xtask",
        "--exclude",
        "studies",
        "--exclude",
        python::PACKAGE,
        "--allow-dirty",
        "--offline",
        "--no-verify",
    ])?;
    let metadata = metadata()?;
    let folder = metadata.target_directory.join("package");
    let unpacked = folder.join("unpacked");
    if unpacked.exists() {
        fs::remove_dir_all(&unpacked).with_context(|| unpacked.display().to_string())?;
    }
    fs::create_dir_all(&unpacked).with_context(|| unpacked.display().to_string())?;
    let packed =
        metadata.packages.iter().filter(|package| !["studies", "xtask", python::PACKAGE].contains(&&*package.name));
    let packed: Vec<(&str, String)> =
        packed.map(|package| (&*package.name, format!("{}-{}", package.name, package.version))).collect();
    for (_, stem) in &packed {
        let archive = folder.join(format!("{stem}.crate"));
        run_quietly(Command::new("tar").arg("-xzf").arg(archive).arg("-C").arg(&unpacked))?;
    }
    let manifest = unpacked.join("Cargo.toml");
    let root_manifest = fs::read_to_string(workspace::root()?.join("Cargo.toml")).context("Cargo.toml")?;
    fs::write(&manifest, workspace_of(&packed, &root_manifest)).with_context(|| manifest.display().to_string())?;
    let lock = "Cargo.lock";
    fs::copy(workspace::root()?.join(lock), unpacked.join(lock)).context(lock)?;
    let arguments = ["check", "--release", "--workspace", "--offline"];
    let mut check = workspace::cargo(&arguments)?;
    run_quietly(check.current_dir(&unpacked).arg("--target-dir").arg(&metadata.target_directory))
}

/// A workspace of these unpacked packages, each in the folder of its own name, with the profiles of the workspace itself,
/// so that what was compiled with them is used again.
fn workspace_of(packed: &[(&str, String)], root_manifest: &str) -> String {
    let stems: Vec<&String> = packed.iter().map(|(_, stem)| stem).collect();
    let patches: Vec<String> = packed.iter().map(|(name, stem)| format!("{name} = {{ path = {stem:?} }}\n")).collect();
    let profiles = root_manifest.find("[profile.").map_or("", |at| &root_manifest[at..]);
    format!("[workspace]\nresolver = \"3\"\nmembers = {stems:?}\n\n[patch.crates-io]\n{}\n{profiles}", patches.concat())
}

/// The examples of all packages. No two may share a name: they are built into one folder.
fn example_names(metadata: &Metadata) -> Result<Vec<&str>> {
    let packages = metadata.packages.iter().filter(|package| package.name != python::PACKAGE);
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
