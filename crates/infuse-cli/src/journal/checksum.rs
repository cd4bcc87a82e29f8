//! A checksum over the lines of a journal, so that a digit that was changed later is noticed.

use anyhow::{Context as _, Result, ensure};
use sha2::{Digest as _, Sha256};

use super::event::{Assessed, Event};

/// Of the lines so far.
#[derive(Debug, Clone, Default)]
pub(crate) struct Checksum {
    digest: Sha256,
}

impl Checksum {
    /// Takes one more line in, without the spaces at its ends; empty lines do not count.
    pub(crate) fn add(&mut self, line: &[u8]) {
        let line = line.trim_ascii();
        if !line.is_empty() {
            self.digest.update(line);
            self.digest.update(b"\n");
        }
    }

    /// The event with the checksum of itself and all lines before it, if it is of the kind that has one.
    pub(crate) fn sign(&self, event: &Event) -> Result<Event> {
        match event {
            Event::Assessed(assessed) => {
                Ok(Event::Assessed(Assessed { check: self.of(assessed)?, ..assessed.clone() }))
            }
            other => Ok(other.clone()),
        }
    }

    /// Whether an event that has a checksum agrees with the lines before it.
    pub(crate) fn check(&self, event: &Event) -> Result<()> {
        if let Event::Assessed(assessed) = event {
            let found = self.of(assessed)?;
            ensure!(
                found == assessed.check,
                "its checksum is {:?}, and from it and the lines before follows {found:?}: one of them was changed",
                assessed.check
            );
        }
        Ok(())
    }

    fn of(&self, assessed: &Assessed) -> Result<String> {
        let unsigned = Event::Assessed(Assessed { check: String::new(), ..assessed.clone() });
        let mut with_it = self.digest.clone();
        with_it.update(serde_json::to_vec(&unsigned).context("cannot write an event")?);
        Ok(with_it.finalize().iter().take(8).map(|byte| format!("{byte:02x}")).collect())
    }
}
