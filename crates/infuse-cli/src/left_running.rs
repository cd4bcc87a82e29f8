//! Programs that a killed call has left running: whatever is begun is noted in the folder until it has ended.
//!
//! Nobody can stop a program after having been killed. The next call tells which still run, where the system says what runs
//! (`/proc`); a number that belongs to another program by now is known by the time at which that one began.

use std::path::{Path, PathBuf};

/// A file for each program that runs, with its number; in it, when it began.
const NOTE: &str = ".infuse.running-";

/// A program that runs, noted as long as this lives.
#[derive(Debug)]
pub(crate) struct Noted {
    file: PathBuf,
}

impl Noted {
    /// That it is not noted, on a full disk say, is no reason not to run it.
    pub(crate) fn new(folder: &Path, process: u32) -> Self {
        let file = folder.join(format!("{NOTE}{process}"));
        if let Some(began) = began(&process.to_string()) {
            let _ = std::fs::write(&file, began);
        }
        Self { file }
    }
}

impl Drop for Noted {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.file);
    }
}

/// Whether a program runs, or ran when a call was killed.
pub(crate) fn is_any_noted(folder: &Path) -> bool {
    !processes(folder).is_empty()
}

/// The processes of which there is a note.
fn processes(folder: &Path) -> Vec<String> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let mut processes: Vec<String> = entries
        .filter_map(|entry| entry.ok()?.file_name().to_str()?.strip_prefix(NOTE).map(str::to_owned))
        .filter(|process| process.parse::<u32>().is_ok())
        .collect();
    processes.sort();
    processes
}

/// One sentence for each program of a killed call that still runs; those that do not are forgotten. Only for who holds the
/// folder: others' programs run rightly.
pub(crate) fn notices(folder: &Path) -> Vec<String> {
    let mut notices = Vec::new();
    for process in processes(folder) {
        let note = folder.join(format!("{NOTE}{process}"));
        let runs = began(&process).is_some_and(|began| std::fs::read_to_string(&note).is_ok_and(|then| then == began));
        if runs {
            notices.push(format!(
                "process {process}, which a killed call has begun, still runs, and what it finds is not taken: `kill -- -{process}` ends it"
            ));
        } else {
            let _ = std::fs::remove_file(note);
        }
    }
    notices
}

/// When a process began, in ticks since the machine did; none if there is no such process, or no way to tell.
fn began(process: &str) -> Option<String> {
    let stat = std::fs::read_to_string(Path::new("/proc").join(process).join("stat")).ok()?;
    // Its name, in brackets, may hold anything; the 20th number after it is the time.
    let (_, after) = stat.rsplit_once(')')?;
    let mut fields = after.split_whitespace();
    let is_dead = fields.next() == Some("Z");
    fields.nth(18).filter(|_| !is_dead).map(str::to_owned)
}
