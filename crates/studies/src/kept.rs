//! Pages that are written straight into `docs/`, from results that are kept.

use std::path::Path;

use anyhow::{Context as _, Result, ensure};

/// Writes texts to their places, which are told.
pub(crate) fn write(root: &Path, texts: &[(&str, String)]) -> Result<()> {
    for (path, text) in texts {
        std::fs::write(root.join(path), text).with_context(|| (*path).to_owned())?;
    }
    eprintln!("{}", texts.iter().map(|(path, _)| *path).collect::<Vec<_>>().join(", "));
    Ok(())
}

/// That each place holds its text; else `remedy` follows its name.
pub(crate) fn check(root: &Path, texts: &[(&str, String)], remedy: &str) -> Result<()> {
    for (path, text) in texts {
        let committed = std::fs::read_to_string(root.join(path)).with_context(|| (*path).to_owned())?;
        ensure!(committed == *text, "{path} {remedy}");
    }
    Ok(())
}
