//! One run of a command at a time in a folder: two would write the same tables.

use std::fs::{self, File, TryLockError};
use std::path::Path;

use anyhow::{Context as _, Error, Result, bail};

const FOLDER: &str = "target/reproduction";
/// Runs with one of these words write nothing that is kept.
const READERS: [&str; 4] = ["--check", "--guard", "--serve", "design-page"];
/// Runs with one of these write other tables than the command alone.
const APART: [&str; 2] = ["--ensemble", "--constrained"];

/// Held for the length of a run that writes; none for one that does not.
#[derive(Debug)]
pub(crate) struct Alone(
    #[expect(dead_code, reason = "it is unlocked when it is dropped, however the process ends")] Option<File>,
);

/// Keeps others out.
///
/// # Errors
/// When another run of the same command is at work.
pub(crate) fn alone(root: &Path, words: &[&str]) -> Result<Alone> {
    let Some(name) = name(words) else { return Ok(Alone(None)) };
    let folder = root.join(FOLDER);
    fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
    let path = folder.join(format!("{name}.lock"));
    let file = File::create(&path).with_context(|| path.display().to_string())?;
    match file.try_lock() {
        Ok(()) => Ok(Alone(Some(file))),
        Err(TryLockError::WouldBlock) => {
            bail!("another `cargo xtask {name}` is at work in this folder: wait until it ends")
        }
        Err(TryLockError::Error(error)) => Err(Error::from(error).context(path.display().to_string())),
    }
}

/// What is locked.
fn name(words: &[&str]) -> Option<String> {
    if words.iter().any(|word| READERS.contains(word)) {
        return None;
    }
    let apart = words.iter().copied().filter(|word| APART.contains(word));
    Some(words.iter().copied().take(1).chain(apart).collect::<Vec<_>>().join(" "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_second_run_is_refused_until_the_first_ends() {
        let folder = tempfile::tempdir().expect("a folder");
        let run = |words: &[&str]| alone(folder.path(), words);
        let first = run(&["reproduce-all", "--ensemble"]).expect("alone");
        let error = run(&["reproduce-all", "--ensemble", "--page"]).expect_err("the same tables").to_string();
        assert!(error.contains("another `cargo xtask reproduce-all --ensemble` is at work"), "{error}");
        let others = [run(&["reproduce-all"]), run(&["calibrate"]), run(&["reproduce-all", "--ensemble", "--check"])];
        assert!(others.iter().all(Result::is_ok), "{others:?}");
        drop(first);
        assert!(run(&["reproduce-all", "--ensemble", "--page"]).is_ok());
    }
}
