//! Names that follow from what they name depends on.

use sha2::{Digest as _, Sha256};

/// Letters of a name: 64 bits.
const LETTERS: usize = 16;

/// A name for a list of parts, different for different lists.
#[derive(Clone, Debug, Default)]
pub(crate) struct Key(Sha256);

impl Key {
    /// The same with one more part.
    pub(crate) fn with(mut self, part: impl AsRef<[u8]>) -> Self {
        let part = part.as_ref();
        // With its length, so that no two lists of parts run into the same bytes.
        self.0.update((part.len() as u64).to_le_bytes());
        self.0.update(part);
        self
    }

    pub(crate) fn name(self) -> String {
        let hash = self.0.finalize();
        let letters: String = hash.iter().map(|byte| format!("{byte:02x}")).collect();
        letters[..LETTERS].to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_sha_256_of_lengths_and_parts() {
        // echo of: struct.pack('<Q', 1) + b'a' + struct.pack('<Q', 2) + b'bc', by Python's hashlib.
        let key = |parts: [&str; 2]| parts.into_iter().fold(Key::default(), Key::with).name();
        assert_eq!(key(["a", "bc"]), "9a8acca1b6c6c0be");
        assert_ne!(key(["a", "bc"]), key(["ab", "c"]), "where a part ends matters");
    }
}
