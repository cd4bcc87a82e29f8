//! The one reader of study files.

use std::path::Path;

use anyhow::{Context as _, Result, anyhow};
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
