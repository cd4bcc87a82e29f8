//! Journals that were cut short, edited, or written by two at once.

use std::process::Stdio;

use crate::rig::{Rig, told};

fn two_batches() -> Rig {
    let rig = Rig::new();
    rig.batch();
    rig.infuse(&["ask"]).ok();
    rig.fill("sheet-2.csv", |_| true);
    rig.infuse(&["tell", "sheet-2.csv"]).ok();
    rig
}

/// As earlier versions wrote it: a checksum only where a batch of the pooled loop is complete.
pub(crate) fn unchecked(journal: &str) -> String {
    let line = |line: &str| match line.split_once(",\"check\":") {
        Some((before, _)) if !line.contains("\"event\":\"assessed\"") => format!("{before}}}\n"),
        _ => format!("{line}\n"),
    };
    journal.lines().map(line).collect()
}

/// All lines taken at their word.
pub(crate) fn without_checksums(journal: &str) -> String {
    let bare =
        |line: &str| line.split_once(",\"check\":").map_or_else(|| line.to_owned(), |(line, _)| format!("{line}}}"));
    journal.lines().map(|line| bare(line) + "\n").collect()
}

#[test]
fn a_journal_cut_anywhere_is_gone_on_with() {
    let rig = two_batches();
    let whole = rig.read("journal.jsonl");
    let expected = rig.status();
    for step in 0..60 {
        // Irregular places, the very first and the very last bytes among them.
        let end = if step == 0 {
            1
        } else {
            whole.len() * (step * step + 37 * step) / (59 * 59 + 37 * 59) - usize::from(step == 59)
        };
        rig.write("journal.jsonl", &whole[..end]);
        let read_only = rig.infuse(&["status"]);
        assert!(read_only.is_success, "{end}: {}", read_only.stderr);
        assert_eq!(rig.read("journal.jsonl").len(), end, "reading changes nothing");
        // Telling both sheets again brings back what was cut off.
        rig.infuse(&["ask"]).ok();
        rig.infuse(&["tell", "sheet-1.csv"]).ok();
        rig.infuse(&["ask"]).ok();
        rig.infuse(&["tell", "sheet-2.csv"]).ok();
        assert_eq!(rig.status(), expected, "{end}");
    }
}

#[test]
fn what_an_interrupted_call_has_left_is_set_aside_and_said() {
    let rig = two_batches();
    let whole = unchecked(&rig.read("journal.jsonl"));
    let n_told = told(&rig.journal()).len();
    // Two of three lines told at once, and half of the third.
    let line = |row: usize| {
        format!("{{\"event\":\"told\",\"row\":{row},\"rows\":3,\"id\":1,\"value\":1.0,\"from\":\"x\",\"at\":\"\"}}\n")
    };
    rig.write("journal.jsonl", &format!("{whole}{}{}{}", line(1), line(2), &line(3)[..20]));
    let said = rig.infuse(&["ask"]);
    assert!(said.stderr.contains("were moved to journal.torn, nothing else is lost"), "{}", said.stderr);
    said.ok();
    assert!(rig.read("journal.torn").starts_with("{\"event\":\"told\",\"row\":1,\"rows\":3"));
    assert_eq!(told(&rig.journal()).len(), n_told);
    assert!(rig.infuse(&["ask"]).stderr.is_empty(), "said once");
}

/// Whether a batch is complete or not, and whatever the line says.
#[test]
fn a_digit_changed_anywhere_is_refused() {
    let rig = Rig::pooled();
    rig.infuse(&["ask"]).ok();
    rig.fill("sheet-1.csv", |id| id < 3);
    rig.infuse(&["tell", "sheet-1.csv"]).ok();
    rig.write("old.csv", "spring [N/mm],damper gain [N s/mm],vibration [mm/s]\n21,1.8,5.5\n");
    rig.infuse(&["import", "old.csv", "--source", "notebook"]).ok();
    rig.infuse(&["tell", "--id", "7", "--value", "8.25"]).ok();
    rig.infuse(&["undo"]).ok();
    rig.infuse(&["status"]).ok();
    let whole = rig.read("journal.jsonl");
    let digits = whole.bytes().enumerate().filter(|(_, byte)| byte.is_ascii_digit()).map(|(at, _)| at);
    for at in digits.step_by(4) {
        let mut bytes = whole.clone().into_bytes();
        bytes[at] = if bytes[at] == b'1' { b'2' } else { b'1' };
        std::fs::write(rig.path("journal.jsonl"), &bytes).unwrap();
        let error = rig.infuse(&["status"]).error();
        let line = whole[..at].matches('\n').count() + 1;
        // A line cut to another number of rows is named where that shows.
        assert!(error.contains("journal.jsonl, line ") && error.contains(&format!("line {line}")), "{line}: {error}");
    }
}

/// In journals from before every line had its checksum only what the last batch taught can tell that a result was changed.
#[test]
fn a_digit_changed_in_the_last_batch_is_refused() {
    let rig = two_batches();
    let whole = unchecked(&rig.read("journal.jsonl"));
    let lines: Vec<&str> = whole.lines().collect();
    assert!(lines.last().unwrap().contains("\"event\":\"learned\",\"batch\":2"), "{}", lines.last().unwrap());
    let told = lines.iter().enumerate().rfind(|(_, line)| line.contains("\"event\":\"told\"")).unwrap().0;
    let event: serde_json::Value = serde_json::from_str(lines[told]).unwrap();
    let value = event["value"].as_f64().unwrap();
    let changed = lines[told].replace(&format!("\"value\":{value:?}"), &format!("\"value\":{:?}", value + 0.1));
    assert_ne!(changed, lines[told]);
    rig.write("journal.jsonl", &whole.replace(lines[told], &changed));
    for command in [["status"], ["ask"], ["report"]] {
        let error = rig.infuse(&command).error();
        let place = format!("journal.jsonl, line {}", lines.len());
        assert!(error.contains(&place) && error.contains("says that batch 2 found"), "{error}");
        assert!(error.contains("one of them was changed"), "{error}");
    }
}

/// Earlier versions wrote down what a batch taught when the next one was planned.
#[test]
fn a_journal_that_does_not_say_what_its_last_batch_taught_is_read_and_completed() {
    let rig = two_batches();
    let expected = rig.status();
    let whole = rig.read("journal.jsonl");
    let (before, last) = whole.trim_end().rsplit_once('\n').unwrap();
    rig.write("journal.jsonl", &format!("{before}\n"));
    assert_eq!(rig.status(), expected);
    assert_eq!(rig.read("journal.jsonl"), format!("{before}\n"), "reading changes nothing");
    rig.infuse(&["tell", "sheet-2.csv"]).ok();
    assert_eq!(rig.read("journal.jsonl"), format!("{before}\n{last}\n"));
    assert_eq!(rig.status(), expected);
}

#[test]
fn what_was_learned_is_said_anew_when_a_result_is_put_right() {
    let rig = two_batches();
    let learned = || rig.journal().iter().filter(|line| line["event"] == "learned" && line["batch"] == 2).count();
    let before = rig.status();
    rig.infuse(&["tell", "--id", "12", "--value", "11", "--correct"]).ok();
    assert_eq!(learned(), 2);
    assert_ne!(rig.status()["predicted"], before["predicted"]);
    rig.infuse(&["ask", "--anyway"]).ok();
    assert_eq!(learned(), 2);
}

#[test]
fn what_is_imported_after_a_batch_counts_from_the_next_one_on() {
    let rig = two_batches();
    let before = rig.status();
    rig.write("old.csv", "spring [N/mm],damper gain [N s/mm],vibration [mm/s]\n21,1.8,5.5\n");
    assert!(rig.infuse(&["import", "old.csv", "--source", "notebook"]).ok().contains("From batch 3 on"));
    let after = rig.status();
    assert_eq!((&after["predicted"], &after["imported"]), (&before["predicted"], &serde_json::json!(1)));
    rig.infuse(&["tell", "--id", "12", "--value", "11", "--correct"]).ok();
    assert_eq!(rig.status()["imported"], 1);
    rig.infuse(&["ask", "--anyway"]).ok();
    rig.fill("sheet-3.csv", |_| true);
    rig.infuse(&["tell", "sheet-3.csv"]).ok();
    rig.infuse(&["import", "--withdraw", "notebook"]).ok();
    rig.infuse(&["status"]).ok();
}

/// Another machine rounds differently: what follows from the lines before may differ by that, and by no more.
#[test]
fn what_was_learned_may_differ_by_rounding_and_not_by_more() {
    let rig = two_batches();
    rig.infuse(&["ask", "--anyway"]).ok();
    let whole = unchecked(&rig.read("journal.jsonl"));
    let learned = whole.lines().find(|line| line.contains("\"event\":\"learned\"")).unwrap();
    let with = |factor: f64| {
        let mut event: serde_json::Value = serde_json::from_str(learned).unwrap();
        event["predicted"] = serde_json::json!(event["predicted"].as_f64().unwrap() * factor);
        rig.write("journal.jsonl", &whole.replace(learned, &event.to_string()));
        rig.infuse(&["status"])
    };
    with(1.0 + 1e-12).ok();
    assert!(with(1.0 + 1e-6).error().contains("one of them was changed"));
}

/// What another machine wrote down about a batch stands, even where this one finds other last digits or another design.
#[test]
fn what_was_assessed_stands_as_it_was_written_and_is_computed_with_nowhere() {
    let rig = Rig::pooled();
    rig.batch();
    let before = rig.status();
    let mut n_assessed = 0;
    let as_elsewhere = rig.journal().into_iter().map(|mut line| {
        line.as_object_mut().unwrap().remove("check");
        if line["event"] == "assessed" {
            n_assessed += 1;
            line["expected"] = serde_json::json!(line["expected"].as_f64().unwrap() + 1.0);
            line["bound"] = serde_json::json!(line["bound"].as_f64().unwrap() * 2.0);
        }
        line.to_string() + "\n"
    });
    let as_elsewhere: String = as_elsewhere.collect();
    assert_eq!(n_assessed, 1);
    rig.write("journal.jsonl", &as_elsewhere);
    let mut after = rig.status();
    let (said, found) = (&after["batches"][0], &before["batches"][0]);
    assert_eq!(said["expected"], serde_json::json!(found["expected"].as_f64().unwrap() + 1.0));
    assert_eq!(said["bound"], serde_json::json!(found["bound"].as_f64().unwrap() * 2.0));
    after["batches"] = before["batches"].clone();
    assert_eq!(after, before, "what is known now follows from the readings alone");
}

#[test]
fn lines_that_were_edited_are_named_by_their_number() {
    let rig = two_batches();
    // Beginning the third batch writes down what the second taught.
    rig.infuse(&["ask", "--anyway"]).ok();
    let whole = unchecked(&rig.read("journal.jsonl"));
    let lines: Vec<&str> = whole.lines().collect();
    let position =
        |event: &str| lines.iter().position(|line| line.contains(&format!("\"event\":\"{event}\""))).unwrap();
    let with = |index: usize, line: &str| {
        let mut lines = lines.clone();
        lines[index] = line;
        rig.write("journal.jsonl", &(lines.join("\n") + "\n"));
        rig.infuse(&["status"]).error()
    };
    let at = position("told");
    let error = with(at, "{\"event\":\"told\",");
    assert!(error.contains(&format!("journal.jsonl, line {}:", at + 1)), "{error}");
    let error = with(at, &lines[at].replace("\"id\"", "\"ident\""));
    assert!(error.contains(&format!("line {}: ", at + 1)) && error.contains("id"), "{error}");
    // A value that was changed contradicts what was learned from it.
    let learned = position("learned");
    let changed: serde_json::Value = serde_json::from_str(lines[at]).unwrap();
    let value = changed["value"].as_f64().unwrap();
    let error = with(at, &lines[at].replace(&format!("\"value\":{value:?}"), &format!("\"value\":{:?}", value + 3.0)));
    assert!(error.contains(&format!("line {}", learned + 1)) && error.contains("one of them was changed"), "{error}");
    let error = with(learned, &lines[learned].replace("\"batch\":1", "\"batch\":2"));
    assert!(error.contains("batch 2 is not complete"), "{error}");
    // A line that was taken away.
    rig.write("journal.jsonl", &(lines[1..].join("\n") + "\n"));
    let error = rig.infuse(&["status"]).error();
    assert!(error.contains("line 1") && error.contains("expected the event `campaign` on the first line"), "{error}");
    // An editor's own ways: a byte order mark, other line breaks, an empty line, none at the end.
    rig.write("journal.jsonl", &format!("\u{feff}{}\r\n\r\n{}", lines[0], lines[1..].join("\r\n")));
    rig.infuse(&["status"]).ok();
    assert!(rig.infuse(&["ask", "--anyway"]).ok().contains("Batch 3"));
}

#[test]
fn two_at_once_wait_for_each_other_and_lose_nothing() {
    let rig = Rig::new();
    rig.infuse(&["ask"]).ok();
    rig.fill("sheet-1.csv", |_| true);
    let sheet = rig.read("sheet-1.csv");
    let (headings, rows) = sheet.split_once('\n').unwrap();
    let children = rows.lines().enumerate().map(|(index, row)| {
        let name = format!("row-{index}.csv");
        rig.write(&name, &format!("{headings}\n{row}\n"));
        let mut command = rig.command(&["tell", &name, "--wait", "60"]);
        command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
    });
    let children: Vec<_> = children.collect();
    for mut child in children {
        assert!(child.wait().unwrap().success());
    }
    assert_eq!(told(&rig.journal()).len(), 10);
    let reference = Rig::new();
    reference.batch();
    assert_eq!(rig.status(), reference.status());
}

#[test]
fn one_that_does_not_wait_says_who_is_at_work() {
    let rig = Rig::new();
    rig.edit(
        "table = \"simulation.csv\"",
        "command = [\"sh\", \"-c\", \"sleep 3; echo {spring} {damper gain} | cut -d' ' -f1\"]\njobs = 20",
    );
    let mut asking = rig.command(&["ask"]).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let is_simulating = || rig.journal().iter().any(|line| line["event"] == "planned");
    while !is_simulating() {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let error = rig.infuse(&["ask", "--wait", "0"]).error();
    assert!(error.contains(&format!("another `infuse` (process {}) is at work in", asking.id())), "{error}");
    rig.infuse(&["status"]).ok();
    assert!(asking.wait().unwrap().success());
    assert!(rig.infuse(&["ask", "--wait", "x"]).error().contains("--wait"));
}

/// A limit on the size of files stands for a full disk: a write fails when it is half done.
#[cfg(unix)]
#[test]
fn a_full_disk_takes_nothing_and_loses_nothing() {
    let rig = Rig::new();
    rig.infuse(&["ask"]).ok();
    rig.fill("sheet-1.csv", |_| true);
    let before = rig.read("journal.jsonl");
    // In blocks of 512 bytes: the next block boundary is within what is to be written.
    let blocks = before.len() / 512 + 1;
    let limited = |arguments: &str| {
        let script = format!("ulimit -f {blocks}; exec \"$0\" {arguments}");
        let mut command = std::process::Command::new("sh");
        command.args(["-c", &script, env!("CARGO_BIN_EXE_infuse")]).current_dir(rig.folder());
        crate::rig::Said::from(command.output().unwrap())
    };
    let error = limited("tell sheet-1.csv").error();
    assert!(error.contains("journal.jsonl") && error.contains("nothing was written down"), "{error}");
    assert_eq!(rig.read("journal.jsonl"), before);
    rig.infuse(&["tell", "sheet-1.csv"]).ok();
    assert_eq!(told(&rig.journal()).len(), 10);
}

/// Whoever changes a number cannot be rid of what would tell by taking the checksums off.
#[test]
fn a_line_without_a_checksum_after_one_that_has_it_is_refused() {
    let rig = two_batches();
    let whole = rig.read("journal.jsonl");
    let (line, _) = whole.lines().enumerate().find(|(_, line)| line.contains("\"event\":\"told\"")).unwrap();
    let kept: String = whole.lines().take(line).map(|line| format!("{line}\n")).collect();
    let rest: String = whole.lines().skip(line).map(|line| format!("{line}\n")).collect();
    rig.write("journal.jsonl", &format!("{kept}{}", unchecked(&rest)));
    let error = rig.infuse(&["status"]).error();
    assert!(error.contains(&format!("line {}", line + 1)) && error.contains("it has no checksum"), "{error}");
    let anew = whole.lines().map(|line| line.replace(":", ": ") + "\n").collect::<String>();
    rig.write("journal.jsonl", &anew);
    let error = rig.infuse(&["status"]).error();
    assert!(error.contains("line 1") && error.contains("another program has written the line anew"), "{error}");
}
