//! Runs the studies: `studies <command>`, from the root of the workspace.
#![cfg_attr(
    not(feature = "ensemble"),
    expect(
        dead_code,
        reason = "some of what the studies share is for those with the global loop, or for the page over all"
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
mod costs;
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
#[cfg(feature = "calibration")]
mod seal;
#[cfg(feature = "benchmark")]
mod speed;
mod study_file;
mod variable;
mod words;

use std::path::Path;
use std::process::ExitCode;

use anyhow::ensure;
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

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let Some(outcome) = run(&words) else {
        eprintln!("error: no study `{}`, or not with the features of this build", words.join(" "));
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

/// Runs a command; none if there is none of this name.
fn run(words: &[&str]) -> Option<anyhow::Result<()>> {
    let root = Path::new(".");
    let study = words.first().and_then(|name| STUDIES.iter().find(|study| study.command == *name));
    let run: Box<dyn FnOnce() -> anyhow::Result<()>> = match (study, words) {
        (Some(study), [_]) => Box::new(|| study.run(root, Extent::Default)),
        (Some(study), [_, "--full"]) => Box::new(|| study.run(root, Extent::Full)),
        (Some(study), [_, "--check"]) => Box::new(|| study.check(root)),
        #[cfg(feature = "ensemble")]
        (None, ["reproduce-all"]) => Box::new(|| reproduce_all::run(root, STUDIES, Extent::Default)),
        #[cfg(feature = "ensemble")]
        (None, ["reproduce-all", "--keep"]) => Box::new(|| reproduce_all::keep(root, STUDIES)),
        #[cfg(feature = "ensemble")]
        (None, ["reproduce-all", "--page"]) => Box::new(|| reproduce_all::write_page(root, STUDIES, false)),
        #[cfg(feature = "ensemble")]
        (None, ["reproduce-all", "--check"]) => Box::new(|| reproduce_all::run(root, STUDIES, Extent::WithKept)),
        #[cfg(feature = "ensemble")]
        (None, ["reproduce-all", "--ensemble"]) => Box::new(|| ensemble::run(root)),
        #[cfg(feature = "ensemble")]
        (None, ["reproduce-all", "--ensemble", "--page"]) => Box::new(|| ensemble::write_page(root)),
        #[cfg(feature = "ensemble")]
        (None, ["reproduce-all", "--ensemble", "--check"]) => Box::new(|| ensemble::check(root)),
        #[cfg(feature = "calibration")]
        (None, ["calibrate"]) => Box::new(|| calibration::run(root)),
        #[cfg(feature = "calibration")]
        (None, ["calibrate", "--page"]) => Box::new(|| calibration::write_page(root)),
        #[cfg(feature = "calibration")]
        (None, ["calibrate", "--default"]) => Box::new(|| calibration::write_default(root)),
        #[cfg(feature = "calibration")]
        (None, ["calibrate", "--check"]) => Box::new(|| calibration::check(root)),
        #[cfg(feature = "identification")]
        (None, ["identify"]) => Box::new(|| identification::run(root)),
        #[cfg(feature = "identification")]
        (None, ["identify", "--page"]) => Box::new(|| identification::write_page(root)),
        #[cfg(feature = "identification")]
        (None, ["identify", "--check"]) => Box::new(|| identification::check(root)),
        #[cfg(feature = "benchmark")]
        (None, ["speed"]) => Box::new(|| speed::run(root)),
        #[cfg(feature = "benchmark")]
        (None, ["speed", "--flights"]) => Box::new(|| speed::flights(root)),
        #[cfg(feature = "benchmark")]
        (None, ["plants"]) => Box::new(|| plants::run(root)),
        #[cfg(feature = "benchmark")]
        (None, ["plants", "--page"]) => Box::new(|| plants::write_page(root)),
        #[cfg(feature = "benchmark")]
        (None, ["plants", "--check"]) => Box::new(|| plants::check(root)),
        #[cfg(feature = "benchmark")]
        (None, ["benchmark"]) => Box::new(|| benchmark::run(root)),
        #[cfg(feature = "benchmark")]
        (None, ["benchmark", "--page"]) => Box::new(|| benchmark::write_page(root)),
        #[cfg(feature = "benchmark")]
        (None, ["benchmark", "--constrained"]) => Box::new(|| benchmark::constrained_run::run(root)),
        #[cfg(feature = "benchmark")]
        (None, ["benchmark", "--constrained", "--page"]) => Box::new(|| benchmark::constrained_run::write_page(root)),
        #[cfg(feature = "benchmark")]
        (None, ["benchmark", "--constrained", "--check"]) => Box::new(|| benchmark::constrained_run::check(root)),
        #[cfg(feature = "benchmark")]
        (None, ["benchmark", "--check"]) => Box::new(|| benchmark::check(root)),
        #[cfg(feature = "benchmark")]
        (None, ["benchmark", "--serve", family, seed]) => Box::new(move || benchmark::serve(family, seed)),
        #[cfg(feature = "global")]
        (None, ["design-page", evaluation, page]) => {
            let (evaluation, page) = (Path::new(*evaluation), Path::new(*page));
            Box::new(move || design_page::run(evaluation, page))
        }
        _ => return None,
    };
    Some(in_workspace(root).and_then(|()| run()))
}

/// That the files of the studies can be found from here.
fn in_workspace(root: &Path) -> anyhow::Result<()> {
    ensure!(root.join("fixtures/bat").is_dir(), "no fixtures/bat here: start studies by `cargo xtask`");
    Ok(())
}
