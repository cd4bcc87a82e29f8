//! Results that are kept, and pages that are written straight into `docs/` from them.

use std::fs::{self, File};
use std::io::Write as _;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, ensure};
#[cfg(feature = "benchmark")]
use rayon::prelude::*;
#[cfg(feature = "benchmark")]
use serde::{Serialize, de::DeserializeOwned};

#[cfg(feature = "benchmark")]
use crate::reproduction::progress;
use crate::seal::{self, Form};

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

/// Runs what is missing, so many at once, and keeps all rows whenever these are through: a killed run loses no more.
#[cfg(feature = "benchmark")]
pub(crate) fn run_missing<W: Sync, T: Serialize + Send>(
    path: &Path,
    rows: &mut Vec<T>,
    missing: &[W],
    at_once: usize,
    run: impl Fn(&W) -> Result<Vec<T>> + Sync,
) -> Result<()> {
    let bar = progress("campaigns", missing.len());
    for some in missing.chunks(at_once) {
        let new = some.par_iter().map(|which| run(which).inspect(|_| bar.inc(1))).collect::<Result<Vec<_>>>()?;
        rows.extend(new.into_iter().flatten());
        replace_rows(path, rows)?;
    }
    bar.finish();
    Ok(())
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

/// The same where there are few and each takes long.
pub(crate) const SAMPLE_OF_LONG: usize = 10;

/// That a sample came out as it is kept.
pub(crate) fn ensure_same<T: PartialEq + std::fmt::Debug>(what: &str, kept: &T, anew: &T) -> Result<()> {
    ensure_same_in(Path::new(KEPT), what, kept, anew, "`cargo xtask reproduce-all --keep` makes all of it anew")
}

/// The same of what lies elsewhere; `remedy` follows where it did not.
fn ensure_same_in<T: PartialEq + std::fmt::Debug>(
    path: &Path,
    what: &str,
    kept: &T,
    anew: &T,
    remedy: &str,
) -> Result<()> {
    let path = path.display();
    ensure!(kept == anew, "{path}: {what} is kept as {kept:?}, and this program finds {anew:?}: {remedy}");
    Ok(())
}

/// A file of flights or costs that a check takes over, with what it has to be made from: all that decides them, and what this program
/// makes of some of them, so that of other files or of another program nothing is taken over.
#[derive(Debug)]
pub(crate) struct KeptFile {
    pub(crate) path: PathBuf,
    pub(crate) key: String,
    /// What somebody has to do about rows that do not fit.
    pub(crate) remedy: &'static str,
}

impl KeptFile {
    /// Its rows, which are what the program wrote; none where there is no file, or one that was made from something else.
    pub(crate) fn rows(&self) -> Result<Option<String>> {
        let Self { path, key, remedy } = self;
        if !path.exists() {
            return Ok(None);
        }
        let text = fs::read_to_string(path).with_context(|| path.display().to_string())?;
        let opened = seal::open(path, Form::Comment, &text, key, remedy)?;
        opened.check_sum(path, remedy)?;
        let is_of_today = opened.check_key(path, key, String::new).is_ok();
        Ok(is_of_today.then(|| opened.rows.to_owned()))
    }

    /// Puts rows in the place of those that are there.
    pub(crate) fn write(&self, rows: &str) -> Result<()> {
        replace(&self.path, seal::sealed(Form::Comment, &self.key, rows).as_bytes())
    }

    /// That a sample came out as it is kept.
    pub(crate) fn ensure_same<T: PartialEq + std::fmt::Debug>(&self, what: &str, kept: &T, anew: &T) -> Result<()> {
        ensure_same_in(&self.path, what, kept, anew, self.remedy)
    }

    /// Says how many were needed that are not there.
    pub(crate) fn warn(&self, n_missing: usize, what: &str) {
        if n_missing > 0 {
            let path = self.path.display();
            eprintln!("warning: {path}: {n_missing} {what} were needed that are not kept, and made; {}", self.remedy);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_of_other_files_are_none_and_changed_ones_are_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = |key: &str| KeptFile { path: folder.path().join("a.tsv"), key: key.to_owned(), remedy: "remove it" };
        assert_eq!(file("abc").rows().expect("no file"), None);
        file("abc").write("1\t2\n").expect("written");
        assert_eq!(file("abc").rows().expect("rows").as_deref(), Some("1\t2\n"));
        assert_eq!(file("abd").rows().expect("rows of another"), None);
        let path = folder.path().join("a.tsv");
        let text = fs::read_to_string(&path).expect("a file");
        fs::write(&path, text.replace("\t2", "\t3")).expect("written");
        for key in ["abc", "abd"] {
            let error = file(key).rows().expect_err("a digit was changed").to_string();
            assert!(error.contains("a.tsv") && error.contains("remove it"), "{error}");
        }
        let error = file("abc").ensure_same("the cost", &1.0, &1.5).expect_err("another").to_string();
        assert!(error.contains("a.tsv: the cost is kept as 1.0, and this program finds 1.5: remove it"), "{error}");
    }
}
