//! Runs the studies: `studies <command>`, from the root of the workspace.
#![cfg_attr(
    not(feature = "ensemble"),
    expect(
        dead_code,
        reason = "some of what the studies share is for those with the dissertation's loop, or for the page over all"
    )
)]

mod bat;
#[cfg(feature = "benchmark")]
mod benchmark;
mod blind;
#[cfg(feature = "calibration")]
mod calibration;
#[cfg(feature = "similarity")]
mod chapter2;
mod chapter3;
mod chapter4;
#[cfg(feature = "global")]
mod chapter6;
#[cfg(feature = "global")]
mod chapter7;
mod claims;
#[cfg(feature = "calibration")]
mod correlation;
mod costs;
#[cfg(feature = "global")]
mod decisive;
#[cfg(feature = "global")]
mod design_page;
#[cfg(feature = "global")]
mod doe_records;
#[cfg(feature = "ensemble")]
mod ensemble;
#[cfg(feature = "ensemble")]
mod exemptions;
mod first_screen;
#[cfg(feature = "global")]
mod gridded;
mod handover;
#[cfg(feature = "identification")]
mod identification;
#[cfg(feature = "global")]
mod kept;
#[cfg(any(feature = "benchmark", feature = "identification"))]
mod known;
mod lock;
mod logged;
#[cfg(feature = "global")]
mod memory;
#[cfg(feature = "benchmark")]
mod plants;
mod provenance;
#[cfg(feature = "ensemble")]
mod reproduce_all;
mod reproduction;
mod rules;
#[cfg(feature = "global")]
mod seal;
#[cfg(feature = "benchmark")]
mod speed;
mod study_file;
mod together;
mod variable;
mod words;

use std::path::Path;
#[cfg(feature = "global")]
use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::ensure;
use lock::alone;
use reproduction::{Extent, Reproduction};

const STUDIES: &[Reproduction] = &[
    #[cfg(feature = "similarity")]
    chapter2::CHAPTER,
    chapter3::CHAPTER,
    chapter4::CHAPTER,
    #[cfg(feature = "global")]
    chapter6::CHAPTER,
    #[cfg(feature = "global")]
    chapter7::CHAPTER,
    #[cfg(feature = "global")]
    doe_records::RECORDS,
];

/// The exit code for a command that does not exist.
const USAGE_ERROR: u8 = 2;
/// The words that commands have, one form a line, those of `cargo xtask` without a study among them.
const FORMS: &str = include_str!("../../../xtask/src/forms.txt");

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let Some(outcome) = run(&words) else {
        match words.as_slice() {
            [] => eprintln!("error: which study? `cargo xtask help` lists them"),
            _ => eprintln!("error: {}", unknown(&words)),
        }
        return ExitCode::from(USAGE_ERROR);
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

/// What is said of words that no study has: what the command has instead, where there is one of this name.
fn unknown(words: &[&str]) -> String {
    let of_command = |form: &&str| form.split(' ').next() == words.first().copied();
    let forms: String = FORMS.lines().filter(of_command).map(|form| format!("\n  {form}")).collect();
    let words = words.join(" ");
    if forms.is_empty() || FORMS.lines().any(|form| form == words) {
        return format!("no study `{words}`, or not with the features of this build");
    }
    format!("no study `{words}`: it must be one of{forms}")
}

/// Runs a command; none if there is none of this name.
fn run(words: &[&str]) -> Option<anyhow::Result<()>> {
    let (root, work) = (Path::new("."), work(words)?);
    Some(in_workspace(root).and_then(|()| alone(root, words)).and_then(|_alone| work(root)))
}

/// What a command does in the folder of the workspace.
type Work = Box<dyn FnOnce(&Path) -> anyhow::Result<()>>;

/// By the study that the command belongs to; none if it belongs to none.
fn work(words: &[&str]) -> Option<Work> {
    let work = of_study(words);
    #[cfg(feature = "ensemble")]
    let work = work.or_else(|| of_all(words));
    #[cfg(feature = "calibration")]
    let work = work.or_else(|| of_calibration(words));
    #[cfg(feature = "identification")]
    let work = work.or_else(|| of_identification(words));
    #[cfg(feature = "benchmark")]
    let work = work.or_else(|| of_benchmark(words)).or_else(|| of_plants(words));
    #[cfg(feature = "global")]
    let work = work.or_else(|| of_designs(words));
    work
}

fn of_study(words: &[&str]) -> Option<Work> {
    let (name, options) = words.split_first()?;
    let study = STUDIES.iter().find(|study| study.command == *name)?;
    let work: Work = match options {
        [] => Box::new(|root| study.run(root, Extent::Default)),
        ["--full"] => Box::new(|root| study.run(root, Extent::Full)),
        ["--check"] => Box::new(|root| study.check(root)),
        _ => return None,
    };
    Some(work)
}

#[cfg(feature = "ensemble")]
fn of_all(words: &[&str]) -> Option<Work> {
    let work: Work = match words {
        ["reproduce-all"] => Box::new(|root| reproduce_all::run(root, STUDIES, Extent::Default)),
        ["reproduce-all", "--keep"] => Box::new(|root| reproduce_all::keep(root, STUDIES)),
        ["reproduce-all", "--page"] => Box::new(|root| reproduce_all::write_page(root, STUDIES, false)),
        ["reproduce-all", "--check"] => Box::new(|root| reproduce_all::run(root, STUDIES, Extent::WithKept)),
        ["reproduce-all", "--ensemble"] => Box::new(ensemble::run),
        ["reproduce-all", "--ensemble", "--pooled"] => Box::new(ensemble::run_pooled),
        ["reproduce-all", "--ensemble", "--page"] => Box::new(ensemble::write_page),
        ["reproduce-all", "--ensemble", "--check"] => Box::new(ensemble::check),
        ["reproduce-all", "--ensemble", "--check", "--all"] => Box::new(ensemble::check_all),
        _ => return None,
    };
    Some(work)
}

#[cfg(feature = "calibration")]
fn of_calibration(words: &[&str]) -> Option<Work> {
    let work: Work = match words {
        ["calibrate"] => Box::new(calibration::run),
        ["calibrate", "--page"] => Box::new(calibration::write_page),
        ["calibrate", "--default"] => Box::new(calibration::write_default),
        ["calibrate", "--check"] => Box::new(|root| calibration::check(root, calibration::Look::AtSome)),
        ["calibrate", "--check", "--all"] => Box::new(|root| calibration::check(root, calibration::Look::AtAll)),
        _ => return None,
    };
    Some(work)
}

#[cfg(feature = "identification")]
fn of_identification(words: &[&str]) -> Option<Work> {
    let work: Work = match words {
        ["identify"] => Box::new(identification::run),
        ["identify", "--page"] => Box::new(identification::write_page),
        ["identify", "--check"] => Box::new(identification::check),
        _ => return None,
    };
    Some(work)
}

#[cfg(feature = "benchmark")]
fn of_plants(words: &[&str]) -> Option<Work> {
    let work: Work = match words {
        ["plants"] => Box::new(plants::run),
        ["plants", "--page"] => Box::new(plants::write_page),
        ["plants", "--check"] => Box::new(plants::check),
        _ => return None,
    };
    Some(work)
}

#[cfg(feature = "benchmark")]
fn of_benchmark(words: &[&str]) -> Option<Work> {
    let work: Work = match words {
        ["speed"] => Box::new(speed::run),
        ["speed", "--flights"] => Box::new(speed::flights),
        ["speed", "--guard"] => Box::new(speed::guard),
        ["benchmark"] => Box::new(benchmark::run),
        ["benchmark", "--page"] => Box::new(benchmark::write_page),
        ["benchmark", "--check"] => Box::new(benchmark::check),
        ["benchmark", "--constrained"] => Box::new(benchmark::constrained_run::run),
        ["benchmark", "--constrained", "--page"] => Box::new(benchmark::constrained_run::write_page),
        ["benchmark", "--constrained", "--check"] => Box::new(benchmark::constrained_run::check),
        ["benchmark", "--drift"] => Box::new(benchmark::drift_run::run),
        ["benchmark", "--drift", "--page"] => Box::new(benchmark::drift_run::write_page),
        ["benchmark", "--drift", "--check"] => Box::new(benchmark::drift_run::check),
        ["benchmark", "--serve", family, seed] => {
            let [family, seed] = [family, seed].map(|word| (*word).to_owned());
            Box::new(move |_| benchmark::serve(&family, &seed))
        }
        _ => return None,
    };
    Some(work)
}

#[cfg(feature = "global")]
fn of_designs(words: &[&str]) -> Option<Work> {
    let ["design-page", evaluation, page] = words else { return None };
    let [evaluation, page] = [evaluation, page].map(PathBuf::from);
    Some(Box::new(move |_| design_page::run(&evaluation, &page)))
}

/// That the files of the studies can be found from here.
fn in_workspace(root: &Path) -> anyhow::Result<()> {
    ensure!(root.join("fixtures/bat").is_dir(), "no fixtures/bat here: start studies by `cargo xtask`");
    Ok(())
}

#[cfg(all(test, feature = "benchmark", feature = "identification", feature = "ensemble", feature = "similarity"))]
mod tests {
    use super::*;

    /// Of the program of the checks.
    const CHECKS: [&str; 11] = [
        "ci",
        "tidy",
        "equations",
        "fuzz",
        "tutorials",
        "python",
        "licenses",
        "machines",
        "packages",
        "proofs",
        "semver",
    ];

    #[test]
    fn every_form_is_known_and_others_are_answered_by_these() {
        for form in FORMS.lines() {
            let words: Vec<&str> = form.split(' ').collect();
            assert_ne!(work(&words).is_some(), CHECKS.contains(&words[0]), "{form}");
        }
        let words = ["reproduce-all", "--ensemble", "--nonsense"];
        assert!(work(&words).is_none());
        let error = unknown(&words);
        assert!(error.contains("`reproduce-all --ensemble --nonsense`: "), "{error}");
        assert!(
            error.contains("\n  reproduce-all --ensemble --check --all") && !error.contains("calibrate"),
            "{error}"
        );
        assert!(unknown(&["reproduce-chapter9"]).contains("no study `reproduce-chapter9`, or not"));
    }
}
