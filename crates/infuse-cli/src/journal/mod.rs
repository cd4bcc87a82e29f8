//! The journal of a campaign: what happened, line by line, only ever added to.

mod checksum;
mod deed;
mod event;
mod lock;
mod name;
mod submission;
mod text;
mod undo;

use std::collections::BTreeSet;
use std::fs::{File, OpenOptions};
use std::io::{ErrorKind, Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::{Context as _, Result, anyhow};

use checksum::Checksum;
pub(crate) use deed::Deed;
pub(crate) use event::{
    Assessed, BY_ITSELF, Constrained, Event, FORMAT, Learned, Measured, OfSimulation, Purpose, Submitted, Told, now,
};
use lock::Lock;
pub(crate) use name::JOURNAL;
use name::TORN;
pub(crate) use submission::SubmissionName;
pub(crate) use undo::Last;
use undo::Standing;

use crate::{disk, left_running};

/// The journal of a folder, for reading.
#[derive(Debug)]
pub(crate) struct Journal {
    /// Those that count, with the numbers of their lines.
    pub(crate) events: Vec<(usize, Event)>,
    /// All of them.
    pub(crate) all: Vec<(usize, Event)>,
    /// The numbers of the lines that were taken back.
    pub(crate) taken_back: BTreeSet<usize>,
    /// What could be taken back.
    pub(crate) last: Option<Last>,
    /// What a person should know about the file.
    pub(crate) notices: Vec<String>,
}

impl Journal {
    /// From all lines.
    pub(crate) fn of(all: Vec<(usize, Event)>, notices: Vec<String>) -> Result<Self> {
        let standing = Standing::of(all.clone()).context(JOURNAL)?;
        let last = standing.last();
        Ok(Self { events: standing.events, all, taken_back: standing.taken_back, last, notices })
    }

    /// Reads without taking hold of the folder: others may be writing.
    pub(crate) fn read(folder: &Path) -> Result<Self> {
        let path = folder.join(JOURNAL);
        let bytes = match std::fs::read(&path) {
            Err(error) if error.kind() == ErrorKind::NotFound => Vec::new(),
            other => other.map_err(|error| disk::unusable(&path, &error))?,
        };
        let text = text::read(&bytes).with_context(|| format!("{} cannot be read", path.display()))?;
        let rest = bytes.len() - text.n_bytes;
        let mut notices = left_running_if_idle(folder);
        if rest > 0 {
            notices.push(format!(
                "the last {rest} bytes of {JOURNAL} are what an interrupted call has left (or one that is writing now); they are not used"
            ));
        }
        Self::of(text.events, notices)
    }
}

/// What killed calls have left running, unless a call is at work, whose programs run rightly.
fn left_running_if_idle(folder: &Path) -> Vec<String> {
    let held = left_running::is_any_noted(folder).then(|| Lock::if_free(folder)).flatten();
    held.map_or_else(Vec::new, |_held| left_running::notices(folder))
}

/// The journal of a folder, held by this process alone.
#[derive(Debug)]
pub(crate) struct Writer {
    path: PathBuf,
    file: File,
    n_bytes: u64,
    /// Of all complete lines.
    checksum: Checksum,
    _lock: Lock,
}

impl Writer {
    /// Takes hold of the folder, and sets aside what an interrupted call has left at the end of the journal.
    pub(crate) fn open(folder: &Path, wait: Duration) -> Result<(Self, Journal)> {
        let lock = Lock::take(folder, wait)?;
        let path = folder.join(JOURNAL);
        let fault = |error| disk::unusable(&path, &error);
        let file = OpenOptions::new().read(true).append(true).create(true).open(&path).map_err(fault)?;
        let mut bytes = Vec::new();
        (&file).read_to_end(&mut bytes).map_err(fault)?;
        if bytes.is_empty() {
            disk::keep_name(&path);
        }
        let text = text::read(&bytes).with_context(|| format!("{} cannot be read", path.display()))?;
        let mut writer =
            Self { path: path.clone(), file, n_bytes: bytes.len() as u64, checksum: text.checksum, _lock: lock };
        let mut notices = left_running::notices(folder);
        let rest = &bytes[text.n_bytes..];
        if !rest.is_empty() {
            writer.set_aside(folder, rest)?;
            notices.push(format!(
                "a call was interrupted while it wrote to {JOURNAL}: {} bytes that it had not finished were moved to {TORN}, nothing else is lost",
                rest.len()
            ));
        }
        if text.is_open {
            writer.write(b"\n")?;
        }
        Ok((writer, Journal::of(text.events, notices)?))
    }

    fn set_aside(&mut self, folder: &Path, rest: &[u8]) -> Result<()> {
        let path = folder.join(TORN);
        let fault = |error| disk::unusable(&path, &error);
        let mut torn = OpenOptions::new().append(true).create(true).open(&path).map_err(fault)?;
        torn.write_all(rest).and_then(|()| torn.write_all(b"\n")).and_then(|()| torn.sync_all()).map_err(fault)?;
        let kept = self.n_bytes - rest.len() as u64;
        self.file
            .set_len(kept)
            .and_then(|()| self.file.sync_all())
            .map_err(|error| disk::unusable(&self.path, &error))?;
        self.n_bytes = kept;
        Ok(())
    }

    /// Adds these lines, all or none: on an error the journal is as before.
    pub(crate) fn add(&mut self, events: &[Event]) -> Result<()> {
        let (mut lines, mut checksum) = (Vec::new(), self.checksum.clone());
        for event in events {
            let line = checksum.line(event)?;
            checksum.add(&line);
            lines.extend(line);
            lines.push(b'\n');
        }
        self.write(&lines)?;
        self.checksum = checksum;
        Ok(())
    }

    fn write(&mut self, bytes: &[u8]) -> Result<()> {
        let written = self.file.write_all(bytes).and_then(|()| self.file.sync_data());
        if let Err(error) = written {
            // What was written in part is taken back; if even that fails, the next call finds it and sets it aside.
            let _ = self.file.set_len(self.n_bytes);
            return Err(anyhow!("{}; nothing was written down", disk::unusable(&self.path, &error)));
        }
        self.n_bytes += bytes.len() as u64;
        let there = std::fs::metadata(&self.path).map(|metadata| metadata.len());
        anyhow::ensure!(
            there.is_ok_and(|n_bytes| n_bytes >= self.n_bytes),
            "{}: another program has removed or cut it since this call began; put it back, nothing more can be written down",
            self.path.display()
        );
        Ok(())
    }
}
