//! Programs that a killed call has left running: whatever is begun is noted in the folder until it has ended.
//!
//! Nobody can stop a program after having been killed. The next call tells which still run, where the system says what runs
//! (`/proc`); a number that belongs to another program by now is known by the time at which that one began. What a program has begun
//! itself is of its group, and may live longer than the program.

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
        if let Some(now) = Process::of(&process.to_string()).filter(|now| !now.is_dead) {
            let _ = std::fs::write(&file, now.began);
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
        let now = Process::of(&process);
        let is_it = |then: &Process| std::fs::read_to_string(&note).is_ok_and(|began| began == then.began);
        match now {
            Some(now) if is_it(&now) && !now.is_dead => notices.push(format!(
                "process {process}, which a killed call has begun, still runs, and what it finds is not taken: `kill -- -{process}` ends it"
            )),
            // Its number is not given anew while its group has members.
            now if now.as_ref().is_none_or(is_it) && has_members(&process) => notices.push(format!(
                "process {process}, which a killed call has begun, has ended, but programs that it has begun still run: `kill -- -{process}` \
                 ends them"
            )),
            _ => {
                let _ = std::fs::remove_file(note);
            }
        }
    }
    notices
}

/// What the system says of a process.
struct Process {
    /// In ticks since the machine began.
    began: String,
    group: String,
    /// Ended, and not asked for by who began it.
    is_dead: bool,
}

impl Process {
    /// None if there is no such process, or no way to tell.
    fn of(process: &str) -> Option<Self> {
        let stat = std::fs::read_to_string(Path::new("/proc").join(process).join("stat")).ok()?;
        // Its name, in brackets, may hold anything; after it stand its state, its parent, its group, and 17 numbers later the time.
        let (_, after) = stat.rsplit_once(')')?;
        let mut fields = after.split_whitespace();
        let is_dead = fields.next()? == "Z";
        let group = fields.nth(1)?.to_owned();
        let began = fields.nth(16)?.to_owned();
        Some(Self { began, group, is_dead })
    }
}

/// Whether any process of this group runs.
fn has_members(group: &str) -> bool {
    let Ok(entries) = std::fs::read_dir("/proc") else { return false };
    let numbers = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    let mut processes = numbers.filter(|name| name.parse::<u32>().is_ok()).filter_map(|name| Process::of(&name));
    processes.any(|process| process.group == group && !process.is_dead)
}
