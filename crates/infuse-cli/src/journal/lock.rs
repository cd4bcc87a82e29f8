//! One process at a time.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read as _, Seek as _, Write as _};
use std::path::Path;
use std::time::{Duration, Instant};

use anyhow::{Result, bail};

use crate::disk::unusable;

const LOCK: &str = ".infuse.lock";
const PAUSE: Duration = Duration::from_millis(20);

/// Held as long as it lives; the system lets go of it when the process ends, however it ends.
#[derive(Debug)]
pub(crate) struct Lock {
    _file: File,
}

impl Lock {
    /// None if another process holds the folder, or none ever did; nothing is written.
    pub(crate) fn if_free(folder: &Path) -> Option<Self> {
        let file = OpenOptions::new().read(true).write(true).open(folder.join(LOCK)).ok()?;
        file.try_lock().ok()?;
        Some(Self { _file: file })
    }

    /// Waits this long for another process to finish.
    pub(crate) fn take(folder: &Path, wait: Duration) -> Result<Self> {
        let path = folder.join(LOCK);
        let fault = |error| unusable(&path, &error);
        let options = || OpenOptions::new().read(true).write(true).create(true).truncate(false).open(&path);
        let mut file = options().map_err(fault)?;
        let start = Instant::now();
        loop {
            match file.try_lock() {
                Ok(()) => break,
                Err(TryLockError::WouldBlock) if start.elapsed() < wait => std::thread::sleep(PAUSE),
                Err(TryLockError::WouldBlock) => bail!(
                    "another `infuse`{} is at work in {}; wait until it has finished, or stop it, and try again: nothing is lost",
                    holder(&mut file),
                    folder.display()
                ),
                Err(TryLockError::Error(error)) => return Err(fault(error)),
            }
        }
        // Who holds it is a courtesy to others, so a full disk is no reason to stop here.
        let _ = file.set_len(0).and_then(|()| file.rewind());
        let _ = write!(file, "{}", std::process::id());
        Ok(Self { _file: file })
    }
}

fn holder(file: &mut File) -> String {
    let mut text = String::new();
    match file.rewind().and_then(|()| file.read_to_string(&mut text)) {
        Ok(_) if !text.is_empty() => format!(" (process {text})"),
        _ => String::new(),
    }
}
