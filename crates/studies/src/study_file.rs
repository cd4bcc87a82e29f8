//! Study files: read by one reader, made of the same entries in every chapter.

use std::path::Path;

use anyhow::{Context as _, Result, anyhow, ensure};
use serde::Deserialize;
use serde::de::DeserializeOwned;

/// Reads a study file; `check` makes of its entries what a chapter needs, with the folder in which other files are looked
/// up. Errors name the file.
pub(crate) fn read<F: DeserializeOwned, T>(path: &Path, check: impl FnOnce(F, &Path) -> Result<T>) -> Result<T> {
    let name = || path.display().to_string();
    let text = std::fs::read_to_string(path).with_context(name)?;
    let directory = path.parent().unwrap_or(Path::new("."));
    entries(&text).and_then(|file| check(file, directory)).with_context(name)
}

/// The entries of a text; an error names the key, what it holds and what is allowed.
fn entries<F: DeserializeOwned>(text: &str) -> Result<F> {
    let read = serde_path_to_error::deserialize(toml::Deserializer::parse(text)?);
    read.map_err(|error| anyhow!("{}: {}", error.path(), error.inner()))
}

/// The step sizes.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct NumericsEntry {
    steps_per_sample: usize,
    report_steps_per_sample: usize,
}

impl NumericsEntry {
    /// RK4 steps per sample: in searches and landscapes, and for reported designs.
    pub(crate) fn steps(&self) -> [usize; 2] {
        [self.steps_per_sample, self.report_steps_per_sample]
    }
}

/// A design variable with its bounds.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ParameterEntry {
    pub(crate) name: String,
    pub(crate) unit: String,
    pub(crate) lower: f64,
    pub(crate) upper: f64,
}

/// The noise of experiments: its largest share, and the seeds with which it is drawn.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct NoiseEntry {
    /// Of the cost in Chapter 4, of the range of the cost in Chapter 7.
    pub(crate) share: f64,
    pub(crate) first_seed: u64,
    pub(crate) seeds: u64,
}

impl NoiseEntry {
    /// The share and the number of seeds checked.
    pub(crate) fn check(&self) -> Result<()> {
        check_share("noise.share", self.share)?;
        check_seeds("noise.seeds", self.seeds)
    }

    /// So many seeds.
    pub(crate) fn numbers(&self, count: u64) -> Vec<u64> {
        (self.first_seed..self.first_seed.saturating_add(count)).collect()
    }
}

/// That a share is one of noise.
pub(crate) fn check_share(name: &str, share: f64) -> Result<()> {
    ensure!((0.0..1.0).contains(&share), "{name} = {share}: it must be 0 or more and less than 1");
    Ok(())
}

/// That a number of seeds is allowed.
pub(crate) fn check_seeds(name: &str, seeds: u64) -> Result<()> {
    ensure!((1..=1000).contains(&seeds), "{name} = {seeds}: from 1 to 1000 are allowed");
    Ok(())
}

/// That every list has an entry.
pub(crate) fn check_not_empty<'a>(lists: impl IntoIterator<Item = (&'a str, usize)>) -> Result<()> {
    for (name, count) in lists {
        ensure!(count > 0, "{name}: at least one is needed");
    }
    Ok(())
}

/// That no label is there twice.
pub(crate) fn check_labels(name: &str, labels: impl IntoIterator<Item = String>) -> Result<()> {
    let labels: Vec<String> = labels.into_iter().collect();
    let twice = labels.iter().enumerate().find(|(at, label)| labels[..*at].contains(label));
    ensure!(twice.is_none(), "{name}: {} is there twice", twice.map_or("", |(_, label)| label));
    Ok(())
}

/// Reads a study file of `fixtures/bat` after a change of its text.
#[cfg(test)]
pub(crate) fn read_changed<F: DeserializeOwned, T>(
    name: &str,
    check: impl FnOnce(F, &Path) -> Result<T>,
    change: impl FnOnce(String) -> String,
) -> Result<T> {
    let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/bat");
    let text = std::fs::read_to_string(directory.join(name)).expect("the study file");
    let changed = change(text.clone());
    assert_ne!(changed, text, "the change changes something");
    entries(&changed).and_then(|file| check(file, &directory))
}

/// That a study file of `fixtures/bat` with its first `from` replaced by `to` is refused in these words.
#[cfg(test)]
#[track_caller]
pub(crate) fn assert_refused<F: DeserializeOwned, T: std::fmt::Debug>(
    name: &str,
    check: impl FnOnce(F, &Path) -> Result<T>,
    [from, to]: [&str; 2],
    words: &[&str],
) {
    let read = read_changed(name, check, |text| text.replacen(from, to, 1));
    let error = format!("{:#}", read.expect_err("an error"));
    for word in words {
        assert!(error.contains(word), "`{word}` is not in: {error}");
    }
}
