//! The campaigns that were run, on disk after each few: a killed run goes on where it was.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, anyhow, ensure};
use design_space::Region;
use serde::{Deserialize, Serialize};

use super::file::Study;
use super::which::Which;
use crate::kept;
use crate::seal::{self, Form};

/// What somebody has to do about lines that do not fit.
pub(super) const REMEDY: &str = "take it back from version control, or remove it and run `cargo xtask identify`";
/// The first line.
const LINES_BEFORE: usize = 1;

/// One iteration.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct KeptTurn {
    pub(super) design: Vec<f64>,
    /// Of the model with the unknowns of this turn.
    pub(super) model_cost: f64,
    pub(super) corrected_cost: f64,
    /// As it was read.
    pub(super) measured_cost: Option<f64>,
    pub(super) unknowns: Vec<f64>,
    pub(super) carried_slope: Vec<f64>,
    pub(super) carried_offset: f64,
}

/// One number of the plant after all experiments.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct KeptUnknown {
    pub(super) value: f64,
    pub(super) standard_error: Option<f64>,
    pub(super) bound: Option<String>,
}

/// What a campaign identified in the end.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Found {
    pub(super) unknowns: Vec<KeptUnknown>,
    /// How many times as large as the noise the residuals are.
    pub(super) misfit: f64,
    pub(super) singular_values: Vec<f64>,
    pub(super) warnings: Vec<String>,
}

/// One campaign.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Kept {
    pub(super) which: Which,
    pub(super) turns: Vec<KeptTurn>,
    /// Nothing where the loop identifies nothing.
    pub(super) found: Option<Found>,
}

/// A line of the file: one campaign, its loop by name.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Line {
    #[serde(rename = "loop")]
    label: String,
    seed: Option<u64>,
    turns: Vec<KeptTurn>,
    found: Option<Found>,
}

impl Kept {
    /// Whether both say the same; the last digits differ between machines.
    pub(super) fn agrees(&self, other: &Self) -> bool {
        let numbers = |kept: &Self| -> Vec<f64> {
            let turns = kept.turns.iter().flat_map(|turn| [&turn.design[..], &[turn.corrected_cost]].concat());
            let found = kept.found.iter().flat_map(|found| &found.unknowns);
            turns.chain(found.map(|unknown| unknown.value)).collect()
        };
        let (a, b) = (numbers(self), numbers(other));
        const CLOSE: f64 = 1e-3;
        a.len() == b.len() && a.iter().zip(&b).all(|(a, b)| (a - b).abs() <= CLOSE * a.abs())
    }
}

/// All campaigns of a folder.
pub(super) struct Store {
    path: PathBuf,
    /// Names what campaigns follow from.
    key: String,
    labels: Vec<String>,
    campaigns: Vec<Kept>,
}

impl Store {
    /// What a folder holds of the study with this key: each line of one of its loops, within the box and the ranges.
    pub(super) fn read(folder: &Path, study: &Study, key: String) -> Result<Self> {
        let path = folder.join("campaigns.jsonl");
        let labels: Vec<String> = study.loops.iter().map(|entry| entry.label.clone()).collect();
        let mut store = Self { path, key, labels, campaigns: Vec::new() };
        if !store.path.exists() {
            return Ok(store);
        }
        let words = || store.path.display().to_string();
        let text = std::fs::read_to_string(&store.path).with_context(words)?;
        let opened = seal::open(&store.path, Form::Json, &text, &store.key, REMEDY)?;
        opened.check_key(&store.path, &store.key, || {
            format!(": the study, its loops, unknowns, noise, rig, test or weights have changed since; {REMEDY}")
        })?;
        for (number, line) in opened.rows.lines().enumerate() {
            let here = || format!("{}: line {}", store.path.display(), number + LINES_BEFORE + 1);
            let line: Line = serde_json::from_str(line).with_context(|| format!("{}; {REMEDY}", here()))?;
            let index = store.labels.iter().position(|label| *label == line.label);
            let index = index.with_context(|| format!("{}: no loop is called `{}`; {REMEDY}", here(), line.label))?;
            for (turn, number) in line.turns.iter().zip(1..) {
                if let Some(misfit) = misfit(study, turn) {
                    return Err(anyhow!("{}, iteration {number}: {misfit}; {REMEDY}", here()));
                }
            }
            let Line { seed, turns, found, .. } = line;
            let which = Which { index, seed };
            ensure!(store.find(which).is_none(), "{}: this campaign stands twice; {REMEDY}", here());
            store.campaigns.push(Kept { which, turns, found });
        }
        opened.check_sum(&store.path, REMEDY)?;
        Ok(store)
    }

    /// Where a campaign stands.
    pub(super) fn place(&self, index: usize) -> String {
        format!("{}: line {}", self.path.display(), index + LINES_BEFORE + 1)
    }

    pub(super) fn find(&self, which: Which) -> Option<&Kept> {
        self.campaigns.iter().find(|kept| kept.which == which)
    }

    /// Those of a loop, by seed; the one without noise is not among them.
    pub(super) fn noisy(&self, index: usize) -> Vec<&Kept> {
        self.campaigns.iter().filter(|kept| kept.which.index == index && kept.which.seed.is_some()).collect()
    }

    pub(super) fn campaigns(&self) -> &[Kept] {
        &self.campaigns
    }

    pub(super) fn add(&mut self, found: Vec<Kept>) -> Result<()> {
        self.campaigns.extend(found);
        self.campaigns.sort_by_key(|kept| (kept.which.index, kept.which.seed));
        let lines = self.campaigns.iter().map(|kept| {
            let Kept { which, turns, found } = kept.clone();
            let label = self.labels[which.index].clone();
            let line = Line { label, seed: which.seed, turns, found };
            Ok(serde_json::to_string(&line)? + "\n")
        });
        let text = lines.collect::<Result<String>>()?;
        kept::replace(&self.path, seal::sealed(Form::Json, &self.key, &text).as_bytes())
    }
}

/// Where an iteration has a design outside of the box, or an unknown outside of its range.
fn misfit(study: &Study, turn: &KeptTurn) -> Option<String> {
    let region = study.unknowns.region();
    if turn.unknowns.len() != region.parameters().len() {
        return Some(format!("{} unknowns, {} are needed", turn.unknowns.len(), region.parameters().len()));
    }
    if turn.design.len() != study.setup.problem.region().parameters().len() {
        return Some(format!("a design of {} numbers", turn.design.len()));
    }
    let of = |region: &Region, values: &[f64]| {
        let outside = region.parameters().iter().zip(values).find(|(parameter, value)| {
            let slack = 1e-9 * (parameter.upper() - parameter.lower());
            !(parameter.lower() - slack..=parameter.upper() + slack).contains(*value)
        });
        outside.map(|(parameter, value)| {
            let (name, lower, upper) = (parameter.name(), parameter.lower(), parameter.upper());
            format!("`{name}` is {value}: it must be within {lower} to {upper}")
        })
    };
    of(study.setup.problem.region(), &turn.design).or_else(|| of(region, &turn.unknowns))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seal::Copies;

    fn root() -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
    }

    fn written(folder: &Path) -> (Study, PathBuf) {
        let study = Study::read(&root()).expect("a study");
        let mut store = Store::read(folder, &study, "abc".to_owned()).expect("empty");
        let turn = |pitch: f64| KeptTurn {
            design: vec![48.0, pitch],
            model_cost: 4.5,
            corrected_cost: 4.25,
            measured_cost: Some(6.0),
            unknowns: study.unknowns.start().to_vec(),
            carried_slope: vec![0.0, 0.0],
            carried_offset: 0.0,
        };
        let kept = |seed| Kept { which: Which { index: 1, seed }, turns: vec![turn(12.0), turn(13.0)], found: None };
        store.add(vec![kept(None), kept(Some(1))]).expect("written");
        (study, folder.join("campaigns.jsonl"))
    }

    #[test]
    fn campaigns_are_read_as_they_were_written() {
        let folder = tempfile::tempdir().expect("a folder");
        let (study, path) = written(folder.path());
        let store = Store::read(folder.path(), &study, "abc".to_owned()).expect("a store");
        assert_eq!(store.campaigns().len(), 2);
        assert_eq!(store.campaigns()[1].turns[1].design, [48.0, 13.0]);
        assert!(store.place(1).ends_with("campaigns.jsonl: line 3"));
        let text = std::fs::read_to_string(path).expect("a file");
        assert!(text.lines().all(|line| serde_json::from_str::<serde_json::Value>(line).is_ok()), "lines of JSON");
    }

    #[test]
    fn lines_of_another_study_and_damaged_ones_are_refused() {
        let refuse = |from: &str, to: &str, key: &str, words: &[&str]| {
            let folder = tempfile::tempdir().expect("a folder");
            let (study, path) = written(folder.path());
            let text = std::fs::read_to_string(&path).expect("a file");
            assert!(text.contains(from), "{text}");
            std::fs::write(&path, text.replacen(from, to, 1)).expect("written");
            let error = Store::read(folder.path(), &study, key.to_owned()).err().expect("an error");
            let error = format!("{error:#}");
            assert!(words.iter().all(|word| error.contains(word)) && error.contains("campaigns.jsonl"), "{error}");
        };
        refuse("4.25", "4.25", "abd", &["`abc`", "`abd`", "cargo xtask identify"]);
        refuse("4.25", "4.35", "abc", &["changed", "version control"]);
        refuse("4.25", "4.2x5", "abc", &["line 2", "version control"]);
        refuse("13.0", "33.0", "abc", &["line 2, iteration 2", "`pitch_set_point` is 33"]);
        refuse("\"unknowns\":[", "\"unknowns\":[9.0,", "abc", &["line 2, iteration 1", "8 unknowns, 7"]);
        refuse("\"seed\":1", "\"seed\":null", "abc", &["line 3", "twice"]);
        refuse("made_from", "made", "abc", &["line 1"]);
    }

    /// Numbers of the study and of the files that it names decide; words and the count of seeds do not.
    #[test]
    fn key_follows_from_what_decides() {
        let names = ["identification.toml", "chapter4.toml", "rig.toml", "test-profile.toml", "cost-chapter4.toml"];
        let copies = Copies::of(&names);
        let key = || Study::read(copies.root()).and_then(|study| study.key(copies.root())).expect("a key");
        let before = key();
        let after = |name: &str, from: &str, to: &str| copies.with(name, [from, to], key);
        assert_eq!(before, after("identification.toml", "seeds = 20", "seeds = 10"));
        assert_eq!(before, after("identification.toml", "reason = \"a rotor", "reason = \"one rotor"));
        assert_eq!(before, after("chapter4.toml", "experiment_cost = 6.85", "experiment_cost = 6.86"));
        for (name, from, to) in [
            ("identification.toml", "upper = 0.5", "upper = 0.6"),
            ("identification.toml", "difference_step = 1e-5", "difference_step = 1e-6"),
            ("chapter4.toml", "share = 0.02", "share = 0.03"),
            ("rig.toml", "value = 1000.0", "value = 1001.0"),
            ("cost-chapter4.toml", "value = 0.", "value = 0.1"),
        ] {
            assert_ne!(before, after(name, from, to), "{name}: {to}");
        }
    }
}
