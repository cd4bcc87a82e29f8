//! A checksum over the lines of a journal, so that a digit that was changed later is noticed.

use anyhow::{Context as _, Result};
use sha2::{Digest as _, Sha256};

use super::event::{Assessed, Event};

/// Of the lines so far.
#[derive(Debug, Clone, Default)]
pub(crate) struct Checksum {
    digest: Sha256,
    /// Whether any of them had one that earlier versions did not write.
    is_checked: bool,
}

impl Checksum {
    /// Takes one more line in, without the spaces at its ends; empty lines do not count.
    pub(crate) fn add(&mut self, line: &[u8]) {
        let line = line.trim_ascii();
        if !line.is_empty() {
            self.is_checked |= parted(line).is_some() && !line.starts_with(ASSESSED);
            self.digest.update(line);
            self.digest.update(b"\n");
        }
    }

    /// The line of an event, with the checksum of itself and all lines before it at its end.
    pub(crate) fn line(&self, event: &Event) -> Result<Vec<u8>> {
        let write = |event: &Event| serde_json::to_vec(event).context("cannot write an event");
        match event {
            Event::Assessed(assessed) => {
                write(&Event::Assessed(Assessed { check: self.of(assessed)?, ..assessed.clone() }))
            }
            // It is what follows from the lines before, but for the last digits.
            Event::Learned(_) => write(event),
            other => {
                let line = write(other)?;
                let check = self.with(&line);
                let open = line.strip_suffix(b"}").unwrap_or(&line);
                Ok([open, BEFORE, check.as_bytes(), AFTER].concat())
            }
        }
    }

    /// The event of a line, if its checksum agrees with it and the lines before; lines of earlier versions have none, and none
    /// follows one that has.
    pub(crate) fn event(&self, line: &[u8]) -> Result<Event, Fault> {
        let line = line.trim_ascii();
        let Some((bare, check)) = parted(line) else {
            return self.without(line);
        };
        let found = match serde_json::from_slice(&bare).map_err(Fault::Unreadable)? {
            Event::Assessed(assessed) => {
                let found = self.of(&assessed).map_err(Fault::Changed)?;
                let event = Event::Assessed(Assessed { check: check.to_owned(), ..assessed });
                (event, found)
            }
            event => (event, self.with(&bare)),
        };
        let (event, found) = found;
        if found == check {
            return Ok(event);
        }
        Err(Fault::Changed(anyhow::anyhow!(
            "its checksum is {check:?}, and from it and the lines before follows {found:?}: one of them was changed"
        )))
    }

    /// The event of a line that does not end with a checksum.
    fn without(&self, line: &[u8]) -> Result<Event, Fault> {
        let object: serde_json::Map<String, serde_json::Value> =
            serde_json::from_slice(line).map_err(Fault::Unreadable)?;
        if object.contains_key("check") {
            return Err(Fault::Changed(anyhow::anyhow!(
                "its checksum stands elsewhere than at its end: another program has written the line anew, expected it as it was"
            )));
        }
        match serde_json::from_slice(line).map_err(Fault::Unreadable)? {
            event @ Event::Learned(_) => Ok(event),
            _ if self.is_checked => Err(Fault::Changed(anyhow::anyhow!(
                "it has no checksum, though a line before it has one: it was changed"
            ))),
            event => Ok(event),
        }
    }

    fn with(&self, line: &[u8]) -> String {
        let mut with_it = self.digest.clone();
        with_it.update(line);
        in_digits(with_it)
    }

    fn of(&self, assessed: &Assessed) -> Result<String> {
        let unsigned = Event::Assessed(Assessed { check: String::new(), ..assessed.clone() });
        let mut with_it = self.digest.clone();
        with_it.update(serde_json::to_vec(&unsigned).context("cannot write an event")?);
        Ok(in_digits(with_it))
    }
}

/// How a line begins that has always had a checksum.
const ASSESSED: &[u8] = b"{\"event\":\"assessed\"";
/// What stands before and after the digits of a checksum, at the end of a line.
const BEFORE: &[u8] = b",\"check\":\"";
const AFTER: &[u8] = b"\"}";
const DIGITS: usize = 16;

/// Why a line gives no event.
#[derive(Debug)]
pub(crate) enum Fault {
    Unreadable(serde_json::Error),
    Changed(anyhow::Error),
}

/// A line without its checksum, and that.
fn parted(line: &[u8]) -> Option<(Vec<u8>, &str)> {
    let rest = line.strip_suffix(AFTER)?;
    let (rest, check) = rest.split_at_checked(rest.len().checked_sub(DIGITS)?)?;
    let check = std::str::from_utf8(check).ok()?;
    Some(([rest.strip_suffix(BEFORE)?, b"}"].concat(), check))
}

fn in_digits(digest: Sha256) -> String {
    digest.finalize().iter().take(DIGITS / 2).map(|byte| format!("{byte:02x}")).collect()
}
