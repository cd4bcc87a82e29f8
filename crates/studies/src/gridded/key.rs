//! Names of files that follow from what the files depend on.

use std::sync::OnceLock;

use anyhow::{Context as _, Result};
use sha2::{Digest as _, Sha256};

/// Letters of a name: 64 bits.
const LETTERS: usize = 16;

/// A name for whatever these parts say, different for different parts.
pub(crate) fn key<'a>(parts: impl IntoIterator<Item = &'a str>) -> String {
    let mut hash = Sha256::new();
    for part in parts {
        // With its length, so that no two lists of parts run into the same bytes.
        hash.update((part.len() as u64).to_le_bytes());
        hash.update(part.as_bytes());
    }
    shortened(hash)
}

/// A name for the program that runs: what a changed program would have done otherwise must not be remembered.
pub(crate) fn program() -> Result<&'static str> {
    static PROGRAM: OnceLock<String> = OnceLock::new();
    if let Some(known) = PROGRAM.get() {
        return Ok(known);
    }
    let path = std::env::current_exe().context("the path of this program")?;
    let bytes = std::fs::read(&path).with_context(|| path.display().to_string())?;
    Ok(PROGRAM.get_or_init(|| shortened(Sha256::new_with_prefix(bytes))))
}

fn shortened(hash: Sha256) -> String {
    let hash = hash.finalize();
    let letters: String = hash.iter().map(|byte| format!("{byte:02x}")).collect();
    letters[..LETTERS].to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_sha_256_of_lengths_and_parts() {
        // echo of: struct.pack('<Q', 1) + b'a' + struct.pack('<Q', 2) + b'bc', by Python's hashlib.
        assert_eq!(key(["a", "bc"]), "9a8acca1b6c6c0be");
        assert_ne!(key(["a", "bc"]), key(["ab", "c"]), "where a part ends matters");
    }
}
