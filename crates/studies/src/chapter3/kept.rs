//! The panels that are kept with the sources: what the page in `docs/` was written from.
//!
//! A check takes them over and makes some of their designs anew; who keeps writes them; every other run flies them all.

use std::fs;
use std::path::Path;

use anyhow::{Context as _, Result, ensure};

use super::file::Setup;
use super::panels::{Design, FIDELITIES, Failure, PanelFlights, Panels, fly, fly_panels, lattice};
use crate::costs::key::Key;
use crate::decisive::decisive;
use crate::kept::{self, SAMPLE};
use crate::memory;
use crate::reproduction::Extent;
use crate::seal::{self, Form};

const FOLDER: &str = "fixtures/bat";
pub(super) const FILE: &str = "chapter3.toml";

/// Designs of a panel that stand for the program.
const N_PROBES: usize = 4;

const REMEDY: &str = "take it back from version control, or make it anew by `cargo xtask reproduce-all --keep`";

/// What a line keeps of a design: the terms of its cost and the fastest growth, or why there are none. Where it lies follows
/// from the number of the line.
type Row = (Result<[f64; 2], Failure>, Result<f64, String>);

fn row(design: &Design) -> Row {
    (design.outcome.clone(), design.growth_per_s.clone())
}

/// Every panel: taken over where a check finds it, otherwise flown.
pub(super) fn panels<'a>(
    setup: &'a Setup,
    root: &Path,
    extent: Extent,
    done: impl Fn(usize) + Sync,
) -> Result<Panels<'a>> {
    let file = |folder: &Path| Ok::<_, anyhow::Error>(folder.join(format!("{}.jsonl", key(setup, root)?)));
    match extent {
        Extent::WithKept => {
            let path = file(&memory::kept_panels(root))?;
            if path.exists() { taken_over(setup, &path, done) } else { Ok(fly_panels(setup, done)) }
        }
        Extent::Anew => {
            let panels = fly_panels(setup, done);
            write(&file(&memory::panels_made_anew(root))?, &panels)?;
            Ok(panels)
        }
        Extent::Default | Extent::Full => Ok(fly_panels(setup, done)),
    }
}

/// A name for all that decides what the panels are. The plant, the integration and the modes of this program are in it by what they
/// make of some designs.
fn key(setup: &Setup, root: &Path) -> Result<String> {
    let folder = root.join(FOLDER);
    let mut key = Key::default();
    for name in std::iter::once(FILE).chain(setup.files.iter().map(String::as_str)) {
        key = key.with(decisive(&folder.join(name), &[])?.to_string());
    }
    let all = lattice(setup);
    let probes: Vec<[f64; 2]> = (0..N_PROBES).map(|k| all[(2 * k + 1) * all.len() / (2 * N_PROBES)]).collect();
    for fidelity in FIDELITIES {
        for configuration in &setup.configurations {
            for design in fly(setup, configuration, &probes, fidelity, |_| {}) {
                key = key.with(serde_json::to_string(&row(&design))?);
            }
        }
    }
    Ok(key.name())
}

fn write(path: &Path, panels: &Panels<'_>) -> Result<()> {
    let designs = panels.iter().flatten().flat_map(PanelFlights::designs);
    let lines = designs.map(|design| Ok(serde_json::to_string(&row(design))? + "\n"));
    let text = lines.collect::<Result<String>>()?;
    kept::replace(path, seal::sealed(Form::Json, &name(path), &text).as_bytes())
}

/// The key that a file is named after.
fn name(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// The panels of a file, if they are what this program flies: of every so many designs one is flown anew, and has to come out the
/// same bit for bit.
fn taken_over<'a>(setup: &'a Setup, path: &Path, done: impl Fn(usize) + Sync) -> Result<Panels<'a>> {
    let mut rows = read(path)?.into_iter();
    let all = lattice(setup);
    let mut panel = |configuration, fidelity| -> Result<PanelFlights<'a>> {
        let of = |(at, (outcome, growth_per_s)): (&[f64; 2], Row)| Design { at: *at, outcome, growth_per_s };
        let designs: Vec<Design> = all.iter().zip(rows.by_ref()).map(of).collect();
        ensure!(designs.len() == all.len(), "{}: designs are missing; {REMEDY}", path.display());
        let places: Vec<[f64; 2]> = all.iter().step_by(SAMPLE).copied().collect();
        let anew = fly(setup, configuration, &places, fidelity, |_| {});
        for (kept, anew) in designs.iter().step_by(SAMPLE).zip(&anew) {
            kept::ensure_same(&format!("the design at {:?}", kept.at), &row(kept), &row(anew))?;
        }
        done(designs.len());
        Ok(PanelFlights::of(setup, configuration, designs))
    };
    let mut of = |fidelity| setup.configurations.iter().map(|one| panel(one, fidelity)).collect::<Result<Vec<_>>>();
    let [first, second] = FIDELITIES;
    let panels = [of(first)?, of(second)?];
    ensure!(rows.next().is_none(), "{}: it has more designs than the study; {REMEDY}", path.display());
    Ok(panels)
}

/// The rows of a file as they were written.
fn read(path: &Path) -> Result<Vec<Row>> {
    let words = || path.display().to_string();
    let text = fs::read_to_string(path).with_context(words)?;
    let key = name(path);
    let opened = seal::open(path, Form::Json, &text, &key, REMEDY)?;
    opened.check_key(path, &key, || format!("; {REMEDY}"))?;
    opened.check_sum(path, REMEDY)?;
    opened.rows.lines().map(|line| Ok(serde_json::from_str(line)?)).collect::<Result<_>>().with_context(words)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seal::Copies;

    /// The study with a lattice of two by two.
    fn study<T>(read: impl Fn(&Copies) -> T) -> T {
        let copies = Copies::of(&[FILE, "rig.toml", "test-profile-open-loop.toml"]);
        let (across, along) = (["step = 0.7", "step = 14.0"], ["step = 1.0", "step = 28.0"]);
        copies.with(FILE, across, || copies.with(FILE, along, || read(&copies)))
    }

    fn setup(copies: &Copies) -> Setup {
        Setup::read(&copies.root().join(FOLDER).join(FILE)).expect("a study")
    }

    fn key_of(copies: &Copies) -> String {
        key(&setup(copies), copies.root()).expect("a key")
    }

    fn bits(panels: &Panels<'_>) -> Vec<String> {
        panels.iter().flatten().flat_map(PanelFlights::designs).map(|design| format!("{design:?}")).collect()
    }

    #[test]
    fn panels_are_taken_over_as_they_were_kept() {
        study(|copies| {
            let (setup, root) = (setup(copies), copies.root());
            let flown = panels(&setup, root, Extent::Anew, |_| {}).expect("flown");
            let path = memory::panels_made_anew(root).join(format!("{}.jsonl", key_of(copies)));
            assert_eq!(bits(&taken_over(&setup, &path, |_| {}).expect("the same")), bits(&flown));
        });
    }

    /// Whoever changes a number by hand, with its sum or without, and whoever takes a line out.
    #[test]
    fn a_flipped_digit_and_a_missing_line_are_noticed() {
        study(|copies| {
            let (setup, path) = (setup(copies), copies.root().join("abc.jsonl"));
            write(&path, &fly_panels(&setup, |_| {})).expect("written");
            let text = fs::read_to_string(&path).expect("a file");
            let (_, rows) = text.split_once('\n').expect("a first line");
            let refused = |text: &str| {
                fs::write(&path, text).expect("written");
                format!("{:#}", taken_over(&setup, &path, |_| {}).expect_err("it was changed"))
            };
            let digit = rows.rfind(|letter: char| letter.is_ascii_digit()).expect("a digit");
            let flipped = |at: usize, rows: &str| {
                let other = if &rows[at..=at] == "1" { "2" } else { "1" };
                format!("{}{other}{}", &rows[..at], &rows[at + 1..])
            };
            let error = refused(&text.replace(rows, &flipped(digit, rows)));
            assert!(error.contains("abc.jsonl") && error.contains("not what the program wrote"), "{error}");
            // The first design of the first panel is one of the sample.
            let first = rows.find(|letter: char| letter.is_ascii_digit()).expect("a digit");
            let error = refused(&seal::sealed(Form::Json, "abc", &flipped(first, rows)));
            assert!(error.contains("the design at [40.05, -6.0]") && error.contains("this program finds"), "{error}");
            let (_, fewer) = rows.split_once('\n').expect("a second line");
            let error = refused(&seal::sealed(Form::Json, "abc", fewer));
            assert!(error.contains("this program finds") || error.contains("missing"), "{error}");
            let error = refused(&seal::sealed(Form::Json, "abc", &format!("{rows}{rows}")));
            assert!(error.contains("more designs than the study"), "{error}");
            let error = refused(&text.replace("abc", "abd"));
            assert!(error.contains("were made from `abd`"), "{error}");
        });
    }

    #[test]
    fn key_follows_from_what_decides() {
        study(|copies| {
            let base = key_of(copies);
            let with = |name: &str, change: [&str; 2]| copies.with(name, change, || key_of(copies));
            assert_eq!(base, with(FILE, ["label = \"fin 0 deg, one", "label = \"no fin, one"]));
            assert_ne!(base, with(FILE, ["lateral = 0.0125", "lateral = 0.0126"]));
            assert_ne!(base, with(FILE, ["steps_per_sample = 1", "steps_per_sample = 2"]));
            assert_ne!(base, with(FILE, ["step = 28.0", "step = 14.0"]));
            assert_ne!(base, with("rig.toml", ["value = 1000.0", "value = 1000.1"]));
            assert_ne!(base, with("test-profile-open-loop.toml", ["value = 0.245", "value = 0.246"]));
        });
    }
}
