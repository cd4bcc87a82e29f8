//! `cargo xtask proofs`: what holds, and takes too long to be looked at after every change. `docs/proofs.md` keeps what was found.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::Instant;

use anyhow::{Context as _, Result, ensure};

use crate::workspace::{cargo, root, run_cargo, run_quietly, study, target_directory};

const PAGE: &str = "docs/proofs.md";
/// Where a test writes a number that it has measured.
const FOUND: &str = "PROOF_FOUND";

/// What is proven, and by what.
struct Proof {
    claim: &'static str,
    by: By,
}

enum By {
    /// A test that is ignored otherwise: its package and its name.
    Test(&'static str, &'static str),
    /// A command of the studies.
    Study(&'static [&'static str]),
}

const PROOFS: &[Proof] = &[
    Proof {
        claim: "two batches of the dissertation's loop over 24^6 designs take less than 300 MB",
        by: By::Test("infuse-cli", "memory::the_loop_of_the_dissertation_takes_no_more"),
    },
    Proof {
        claim: "what is kept of each plant of the ensemble over its box is what it flies",
        by: By::Study(&["calibrate", "--check", "--all"]),
    },
    Proof {
        claim: "kept campaigns on a plant of the ensemble, one unit of each kind, are those of this program",
        by: By::Study(&["reproduce-all", "--ensemble", "--check", "--all"]),
    },
];

/// A proof that held.
struct Held {
    claim: &'static str,
    command: String,
    found: String,
    time_s: f64,
}

/// Runs them all, and writes the page.
pub(crate) fn run() -> Result<()> {
    let mut held = Vec::new();
    for Proof { claim, by } in PROOFS {
        by.build()?;
        let start = Instant::now();
        let found = by.run().with_context(|| format!("no longer so: {claim}"))?;
        let time_s = start.elapsed().as_secs_f64();
        println!("{time_s:7.1} s  {claim}");
        held.push(Held { claim, command: by.command(), found, time_s });
    }
    let page = root()?.join(PAGE);
    fs::write(&page, markdown(&held, &revision()?)).context(PAGE)
}

impl By {
    fn build(&self) -> Result<()> {
        match self {
            Self::Test(package, _) => run_cargo(&["test", "--release", "--no-run", "--package", package]),
            Self::Study(_) => run_cargo(&["build", "--release", "--package", "studies"]),
        }
    }

    /// What somebody types.
    fn command(&self) -> String {
        match self {
            Self::Test(package, name) => {
                format!("cargo test --release --package {package} -- --ignored --exact {name}")
            }
            Self::Study(words) => format!("cargo xtask {}", words.join(" ")),
        }
    }

    /// What was measured, if anything.
    fn run(&self) -> Result<String> {
        match self {
            Self::Test(package, name) => {
                let found = target_directory()?.join("proof-found");
                // Of an earlier run.
                if found.exists() {
                    fs::remove_file(&found).with_context(|| found.display().to_string())?;
                }
                let mut test = cargo(&["test", "--release", "--package", package, "--", "--ignored", "--exact", name])?;
                let output = test.env(FOUND, &found).output().context("cannot start cargo")?;
                let said = String::from_utf8_lossy(&output.stdout);
                ensure!(output.status.success(), "{said}{}", String::from_utf8_lossy(&output.stderr));
                ensure!(said.contains(&format!("test {name} ... ok")), "there is no test `{name}`");
                read(&found)
            }
            Self::Study(words) => {
                run_quietly(&mut study(words)?)?;
                Ok("all the same".to_owned())
            }
        }
    }
}

fn read(found: &Path) -> Result<String> {
    if found.exists() { fs::read_to_string(found).context("what a test has measured") } else { Ok("held".to_owned()) }
}

/// Of the sources, shortened.
fn revision() -> Result<String> {
    let output = Command::new("git").args(["rev-parse", "--short", "HEAD"]).current_dir(root()?).output();
    let known = output.ok().filter(|output| output.status.success());
    Ok(known.map_or_else(|| "unknown".to_owned(), |output| String::from_utf8_lossy(&output.stdout).trim().to_owned()))
}

fn markdown(held: &[Held], revision: &str) -> String {
    let mut text = format!(
        "# Slow proofs\n\nAll {} held at revision {revision}. They take too long for every change, so `cargo xtask ci` leaves them out; `cargo \
         xtask proofs` runs them and writes this page.\n\n| what holds | found | time (s) | command |\n| --- | --- | ---: | --- |\n",
        held.len()
    );
    for Held { claim, command, found, time_s } in held {
        let _ = writeln!(text, "| {claim} | {found} | {time_s:.0} | `{command}` |");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A proof that nobody runs would be worse than none: each test that is ignored is one of the list.
    #[test]
    fn every_slow_test_is_a_proof_and_every_proof_a_test() {
        let root = root().expect("a workspace");
        for Proof { by, .. } in PROOFS {
            let By::Test(package, name) = by else { continue };
            let (module, test) = name.split_once("::").expect("a module and a name");
            let path = root.join(format!("crates/{package}/tests/it/{module}.rs"));
            let text = fs::read_to_string(&path).expect("a module of tests");
            let at = text.find(&format!("fn {test}(")).expect("a test");
            assert!(text[..at].trim_end().ends_with("#[ignore = \"a slow proof: `cargo xtask proofs`\"]"), "{name}");
        }
        let crates = fs::read_dir(root.join("crates")).expect("crates").flatten();
        let modules = crates.filter_map(|entry| fs::read_dir(entry.path().join("tests/it")).ok()).flatten().flatten();
        let ignored = modules.filter_map(|entry| fs::read_to_string(entry.path()).ok());
        let n_ignored: usize = ignored.map(|text| text.matches("#[ignore").count()).sum();
        assert_eq!(n_ignored, PROOFS.iter().filter(|proof| matches!(proof.by, By::Test(..))).count());
    }

    #[test]
    fn page_says_what_held_and_how_to_see_it() {
        let held = Held { claim: "it holds", command: "cargo xtask x".into(), found: "7 MB".into(), time_s: 3.2 };
        let text = markdown(&[held], "abc");
        assert!(text.contains("All 1 held at revision abc."));
        assert!(text.ends_with("| it holds | 7 MB | 3 | `cargo xtask x` |\n"), "{text}");
    }
}
