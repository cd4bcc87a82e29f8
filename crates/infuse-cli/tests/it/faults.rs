//! Disks that fill up and machines that lose power, at any write.

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::rig::{Rig, Said};

/// A campaign with one batch told, and a second one asked for and filled in.
fn two_batches() -> Rig {
    let rig = Rig::pooled();
    assert!(rig.batch());
    rig.infuse(&["ask"]).ok();
    rig.fill("sheet-2.csv", |_| true);
    rig.write("old.csv", "spring [N/mm],damper gain [N s/mm],vibration [mm/s]\n21,1.8,5.5\n24,1.2,8.5\n");
    rig
}

fn copy_of(rig: &Rig) -> Rig {
    let copy = Rig::empty();
    for entry in fs::read_dir(rig.folder()).unwrap() {
        let entry = entry.unwrap();
        fs::copy(entry.path(), copy.path(&entry.file_name().to_string_lossy())).unwrap();
    }
    copy
}

/// The lines of the journal without what hangs on the time.
fn events(rig: &Rig) -> Vec<Value> {
    let mut events = rig.journal();
    for event in &mut events {
        let fields = event.as_object_mut().unwrap();
        fields.remove("at");
        fields.remove("check");
    }
    events
}

/// Their names.
fn files(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// Runs it where no file may be longer than so many blocks of 512 bytes: a write fails when it is half done, as on a full disk.
#[cfg(unix)]
fn with_a_full_disk(rig: &Rig, arguments: &[&str], blocks: usize) -> Said {
    let script = format!("ulimit -f {blocks}; exec \"$0\" \"$@\"");
    let mut command = std::process::Command::new("sh");
    command.args(["-c", &script, env!("CARGO_BIN_EXE_infuse")]).args(arguments).current_dir(rig.folder());
    Said::from(command.output().unwrap())
}

#[cfg(unix)]
#[test]
fn a_disk_that_is_full_at_any_write_loses_nothing() {
    let (open, asked) = (two_batches(), Rig::pooled());
    let told = copy_of(&open);
    told.infuse(&["tell", "sheet-2.csv"]).ok();
    for (before, arguments) in [
        (&Rig::empty(), &["new", "."][..]),
        (&asked, &["ask"]),
        (&asked, &["ask", "--sheet", "runs.xlsx"]),
        (&open, &["tell", "sheet-2.csv"]),
        (&open, &["import", "old.csv", "--source", "a notebook"]),
        (&open, &["undo"]),
        (&told, &["confirm"]),
        (&told, &["report"]),
        (&told, &["what-if", "--grid", "grid.csv"]),
    ] {
        let free = copy_of(before);
        free.infuse(arguments).ok();
        let (expected, expected_files) = (events(&free), files(free.folder()));
        let mut blocks = 0;
        loop {
            let rig = copy_of(before);
            let said = with_a_full_disk(&rig, arguments, blocks);
            if said.is_success {
                break;
            }
            let error = said.error();
            assert!(error.starts_with("error: ") && !error.contains("panicked"), "{arguments:?}, {blocks}: {error}");
            assert!(error.contains("File too large"), "{arguments:?}, {blocks}: {error}");
            // What there is of each file is whole.
            for name in files(rig.folder()) {
                let is_noted = name == "journal.jsonl" || name.starts_with(".infuse");
                assert!(is_noted || expected_files.contains(&name), "{arguments:?}, {blocks}: {name}");
                if !is_noted && !name.ends_with(".html") {
                    let same = fs::read(rig.path(&name)).unwrap() == fs::read(free.path(&name)).unwrap();
                    assert!(same, "{arguments:?}, {blocks}: {name}");
                }
            }
            rig.infuse(arguments).ok();
            assert!(events(&rig) == expected, "{arguments:?}, {blocks}: another journal");
            assert_eq!(files(rig.folder()), expected_files, "{arguments:?}, {blocks}");
            // Every block where it is decided, and some of those of a long page.
            blocks += 1 + blocks / 2;
        }
        assert!(blocks > 0, "{arguments:?}: it writes something");
    }
}

/// After a loss of power a file may be as long as it should be, and hold zeros where its last writes were lost, in any order.
#[test]
fn zeros_in_a_journal_are_set_aside_at_its_end_and_named_elsewhere() {
    let rig = two_batches();
    rig.infuse(&["tell", "sheet-2.csv"]).ok();
    let expected = rig.status();
    let whole = fs::read(rig.path("journal.jsonl")).unwrap();
    let ends: Vec<usize> = whole.iter().enumerate().filter(|(_, byte)| **byte == b'\n').map(|(at, _)| at + 1).collect();
    let last_call = ends.iter().rev().take(5).copied();
    for from in last_call.flat_map(|end| [end, end - 3, end - 40]) {
        let mut bytes = whole.clone();
        bytes[from..].fill(0);
        fs::write(rig.path("journal.jsonl"), &bytes).unwrap();
        rig.infuse(&["tell", "sheet-2.csv"]).ok();
        assert_eq!(rig.status(), expected, "zeros from byte {from}");
    }
    // A block that was lost before others that were not.
    for block in 1..whole.len() / 512 {
        let mut bytes = whole.clone();
        bytes[512 * block..512 * (block + 1)].fill(0);
        fs::write(rig.path("journal.jsonl"), &bytes).unwrap();
        if 512 * (block + 1) >= ends[ends.len() - 2] {
            continue;
        }
        let line = ends.iter().filter(|end| **end <= 512 * block).count() + 1;
        for arguments in [&["status"][..], &["ask"], &["tell", "sheet-2.csv"]] {
            let error = rig.infuse(arguments).error();
            assert!(
                error.contains(&format!("journal.jsonl, line {line}"))
                    || error.contains("journal.jsonl cannot be read"),
                "block {block}: {error}"
            );
        }
        assert_eq!(fs::read(rig.path("journal.jsonl")).unwrap(), bytes, "it is left as it is");
    }
}
