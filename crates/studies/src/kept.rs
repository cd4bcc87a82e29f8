//! Results that are kept, and pages that are written straight into `docs/` from them.

use std::fs::{self, File};
use std::io::Write as _;
use std::path::Path;

use anyhow::{Context as _, Result, ensure};
#[cfg(feature = "benchmark")]
use serde::{Serialize, de::DeserializeOwned};

/// Writes texts to their places, and says which.
pub(crate) fn write(root: &Path, texts: &[(&str, String)]) -> Result<()> {
    for (path, text) in texts {
        std::fs::write(root.join(path), text).with_context(|| (*path).to_owned())?;
    }
    eprintln!("{}", texts.iter().map(|(path, _)| *path).collect::<Vec<_>>().join(", "));
    Ok(())
}

/// Puts a whole file in the place of another: a kill leaves the one or the other.
pub(crate) fn replace(path: &Path, text: &[u8]) -> Result<()> {
    let mut name = path.as_os_str().to_owned();
    name.push(".part");
    let beside = Path::new(&name);
    let words = || beside.display().to_string();
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    }
    let mut file = File::create(beside).with_context(words)?;
    file.write_all(text).and_then(|()| file.sync_all()).with_context(words)?;
    fs::rename(beside, path).with_context(|| path.display().to_string())
}

/// All rows of a table with a head; none if there is no file yet.
#[cfg(feature = "benchmark")]
pub(crate) fn rows<T: DeserializeOwned>(path: &Path) -> Result<Vec<T>> {
    if !path.exists() {
        return Ok(Vec::new());
    }
    let words = || format!("{} is not a table of these results", path.display());
    csv::Reader::from_path(path)
        .with_context(|| path.display().to_string())?
        .into_deserialize()
        .collect::<Result<_, _>>()
        .with_context(words)
}

/// Puts a whole table in the place of another.
#[cfg(feature = "benchmark")]
pub(crate) fn replace_rows<T: Serialize>(path: &Path, rows: &[T]) -> Result<()> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        writer.serialize(row)?;
    }
    replace(path, &writer.into_inner().map_err(|error| error.into_error())?)
}

/// That each place holds its text; else `remedy` follows its name.
pub(crate) fn check(root: &Path, texts: &[(&str, String)], remedy: &str) -> Result<()> {
    for (path, text) in texts {
        let committed = std::fs::read_to_string(root.join(path)).with_context(|| (*path).to_owned())?;
        ensure!(committed == *text, "{path} {remedy}");
    }
    Ok(())
}

/// Flights and designs that are kept with the sources.
pub(crate) const KEPT: &str = "fixtures/bat/kept";

/// Every how many of what is kept is made anew by a check.
pub(crate) const SAMPLE: usize = 50;

/// That a sample came out as it is kept.
pub(crate) fn ensure_same<T: PartialEq + std::fmt::Debug>(what: &str, kept: &T, anew: &T) -> Result<()> {
    ensure!(
        kept == anew,
        "{KEPT}: {what} is kept as {kept:?}, and this program finds {anew:?}: `cargo xtask reproduce-all --keep` makes all of it anew"
    );
    Ok(())
}
