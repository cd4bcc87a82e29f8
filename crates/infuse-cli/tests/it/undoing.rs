//! What was done is taken back, one thing after the other, and nothing is erased.

use serde_json::{Value, json};

use crate::journals::without_checksums;
use crate::rig::Rig;

/// How it is called when it is taken back, and how it is done.
type Deed<'a> = (&'a str, &'a dyn Fn(&Rig));

fn undo(rig: &Rig) -> Value {
    serde_json::from_str(&rig.infuse(&["undo", "--json"]).ok()).unwrap()
}

/// Does one thing after the other, and takes all of them back: each time everything is as it was.
fn assert_there_and_back(rig: &Rig, deeds: &[Deed<'_>]) {
    let mut before = Vec::new();
    for (_, deed) in deeds {
        before.push((rig.status(), rig.infuse(&["status"]).ok()));
        deed(rig);
    }
    for ((name, _), (status, text)) in deeds.iter().zip(&before).rev() {
        let journal = rig.read("journal.jsonl");
        assert_eq!(undo(rig)["undone"], json!(name));
        assert!(rig.read("journal.jsonl").starts_with(&journal), "nothing is erased");
        assert_eq!(rig.read("journal.jsonl").lines().count(), journal.lines().count() + 1);
        assert_eq!(&rig.status(), status, "{name}");
        assert_eq!(&rig.infuse(&["status"]).ok(), text, "{name}");
        rig.infuse(&["report"]).ok();
    }
    let error = rig.infuse(&["undo"]).error();
    assert!(error.contains("nothing can be taken back"), "{error}");
}

fn ask(rig: &Rig) {
    rig.infuse(&["ask", "--anyway"]).ok();
}

fn tell(rig: &Rig, batch: usize) {
    let sheet = format!("sheet-{batch}.csv");
    rig.fill(&sheet, |_| true);
    rig.infuse(&["tell", &sheet]).ok();
}

fn correct(rig: &Rig) {
    rig.infuse(&["tell", "--id", "12", "--value", "11", "--correct"]).ok();
}

fn import(rig: &Rig) {
    rig.write("old.csv", "spring [N/mm],damper gain [N s/mm],vibration [mm/s]\n21,1.8,7.5\n24,1.8,7.8\n");
    rig.infuse(&["import", "old.csv", "--source", "notebook"]).ok();
}

fn withdraw(rig: &Rig) {
    rig.infuse(&["import", "--withdraw", "notebook"]).ok();
}

#[test]
fn a_pooled_campaign_is_taken_back_to_its_beginning() {
    let rig = Rig::pooled();
    let deeds: [Deed<'_>; 9] = [
        ("ask", &ask),
        ("tell", &|rig| tell(rig, 1)),
        ("import", &import),
        ("ask", &ask),
        ("tell", &|rig| tell(rig, 2)),
        ("tell", &correct),
        ("withdraw", &withdraw),
        ("confirm", &|rig| drop(rig.infuse(&["confirm"]).ok())),
        ("tell", &|rig| tell(rig, 3)),
    ];
    assert_there_and_back(&rig, &deeds);
}

#[test]
fn a_campaign_of_the_dissertation_is_taken_back_to_its_beginning() {
    let rig = Rig::new();
    let deeds: [Deed<'_>; 7] = [
        ("ask", &ask),
        ("tell", &|rig| tell(rig, 1)),
        ("ask", &ask),
        ("tell", &|rig| tell(rig, 2)),
        ("tell", &correct),
        ("import", &import),
        ("withdraw", &withdraw),
    ];
    assert_there_and_back(&rig, &deeds);
}

#[test]
fn what_was_taken_back_may_be_done_otherwise() {
    let (rig, other) = (Rig::pooled(), Rig::pooled());
    ask(&rig);
    rig.infuse(&["tell", "--id", "1", "--value", "99"]).ok();
    undo(&rig);
    assert_eq!(rig.status()["told"], 0);
    // Nothing counts that was told, so that the file may be put right, as before the first result.
    rig.edit("goal = \"minimize\"", "goal = \"maximize\"");
    rig.infuse(&["status"]).ok();
    rig.edit("goal = \"maximize\"", "goal = \"minimize\"");
    for rig in [&rig, &other] {
        ask(rig);
        tell(rig, 1);
    }
    assert_eq!(rig.status(), other.status());
}

#[test]
fn what_was_simulated_stays_known() {
    let rig = Rig::pooled();
    rig.edit("table = \"simulation.csv\"", "command = [\"sh\", \"-c\", \"echo x >> ran; echo {spring}{damper gain}\"]");
    rig.edit("experiments = 10", "experiments = 4\nsimulations = 6");
    ask(&rig);
    let n = rig.read("ran").len();
    let said = rig.infuse(&["undo"]);
    assert!(said.stderr.contains("sheet-1.csv belongs to what was taken back"), "{}", said.stderr);
    assert!(said.ok().contains("Taken back: batch 1, of 4 experiments none of which was told."));
    std::fs::remove_file(rig.path("sheet-1.csv")).unwrap();
    ask(&rig);
    assert!(rig.read("ran").len() <= n + 8, "{} after {n}", rig.read("ran").len());
}

#[test]
fn a_line_that_takes_back_what_was_not_last_is_refused() {
    let rig = Rig::pooled();
    ask(&rig);
    tell(&rig, 1);
    undo(&rig);
    let journal = without_checksums(&rig.read("journal.jsonl"));
    let (before, last) = journal.trim_end().rsplit_once('\n').unwrap();
    let last = last.trim_end_matches('}');
    let bare = last.split(",\"check\"").next().unwrap();
    for (from, to) in [("\"tell\"", "\"import\""), ("\"lines\":11", "\"lines\":10")] {
        assert!(bare.contains(from), "{bare}");
        rig.write("journal.jsonl", &format!("{before}\n{}}}\n", bare.replace(from, to)));
        let error = rig.infuse(&["status"]).error();
        assert!(error.contains("journal.jsonl: line 14") && error.contains("not the last thing"), "{error}");
    }
}

/// It would be the wrong experiments, whose results no `infuse tell` takes.
#[test]
fn a_sheet_of_a_batch_that_was_taken_back_is_not_said_to_be_run() {
    let rig = Rig::pooled();
    ask(&rig);
    undo(&rig);
    rig.edit("seed = 1", "seed = 2");
    let error = rig.infuse(&["ask"]).error();
    assert!(error.contains("sheet-1.csv is there already"), "{error}");
    let text = rig.infuse(&["status"]).ok();
    assert!(text.contains("ask writes the sheet of batch 1, but ") && text.contains("move it"), "{text}");
    assert!(!text.contains("run what is left"), "{text}");
    std::fs::remove_file(rig.path("sheet-1.csv")).unwrap();
    ask(&rig);
    assert!(rig.infuse(&["status"]).ok().contains("run what is left in"), "it is its own");
}

#[test]
fn the_log_says_what_happened_in_order() {
    let rig = Rig::pooled();
    ask(&rig);
    tell(&rig, 1);
    undo(&rig);
    rig.infuse(&["tell", "--id", "3", "--value", "8.25"]).ok();
    rig.infuse(&["tell", "--id", "4", "--failed", "it fell over"]).ok();
    import(&rig);
    withdraw(&rig);
    let sheet = rig.read("sheet-1.csv");
    let is_left = |line: &&str| !["3", "4"].contains(&line.split(',').nth(1).unwrap());
    rig.write("left.csv", &sheet.lines().filter(is_left).map(|line| format!("{line}\n")).collect::<String>());
    rig.infuse(&["tell", "left.csv"]).ok();
    let log: Value = serde_json::from_str(&rig.infuse(&["log", "--json"]).ok()).unwrap();
    let log = log["log"].as_array().unwrap();
    let what: Vec<(&str, bool)> =
        log.iter().map(|entry| (entry["what"].as_str().unwrap(), entry["taken_back"].as_bool().unwrap())).collect();
    let expected = [
        ("begun", false),
        ("asked", false),
        ("told", true),
        ("learned", true),
        ("undone", false),
        ("told", false),
        ("told", false),
        ("imported", false),
        ("withdrawn", false),
        ("told", false),
        ("learned", false),
    ];
    assert_eq!(what, expected);
    let text = rig.infuse(&["log"]).ok();
    for words in [
        "8.25 mm/s",
        "it fell over",
        "2 experiments from old.csv",
        "`notebook`",
        "(taken back)",
        "batch 1: 10 experiments",
    ] {
        assert!(text.contains(words), "{words} is not in {text}");
    }
    assert_eq!(text.lines().count(), expected.len());
    // Settings that changed between batches, and the end.
    rig.edit("batches = 6", "batches = 2\nconfidence = 0.95");
    ask(&rig);
    tell(&rig, 2);
    let text = rig.infuse(&["log"]).ok();
    assert!(text.contains("changed    campaign.toml: ") && text.contains("`confidence` was 0.9 and is 0.95"), "{text}");
    assert!(text.contains("`batches` was 6 and is 2"), "by the keys of the file: {text}");
    assert!(text.trim_end().lines().last().unwrap().contains("stopped    all 2 batches"), "{text}");
}

/// Each setting that a batch was asked for with is there, however many are asked for before the first is complete.
#[test]
fn the_log_has_what_was_changed_before_a_batch_was_complete() {
    let rig = Rig::pooled();
    ask(&rig);
    for (then, now) in [(10, 8), (8, 6)] {
        rig.edit(&format!("experiments = {then}"), &format!("experiments = {now}"));
        rig.infuse(&["ask", "--more"]).ok();
    }
    for batch in 1..=3 {
        tell(&rig, batch);
    }
    let text = rig.infuse(&["log"]).ok();
    let changed = text.lines().filter(|line| line.contains("changed    campaign.toml: "));
    let changed: Vec<&str> = changed.filter_map(|line| line.split_once("toml: ")).map(|(_, what)| what).collect();
    assert_eq!(changed, ["`experiments` was 10 and is 8.", "`experiments` was 8 and is 6."], "{text}");
}

/// A sheet is a person's and stays as it is, so that it is said what would be told again with it.
#[test]
fn a_sheet_that_still_has_results_that_were_taken_back_is_named() {
    let rig = Rig::pooled();
    ask(&rig);
    rig.fill("sheet-1.csv", |id| id <= 3);
    rig.infuse(&["tell", "sheet-1.csv"]).ok();
    let still = "sheet-1.csv still has what was taken back, of experiments 1, 2, 3: empty it there or put it right, or `infuse tell` takes it again";
    let said = rig.infuse(&["undo"]).stderr;
    assert!(said.contains(still), "{said}");
    let said = rig.infuse(&["ask"]).stderr;
    assert!(said.contains(still), "{said}");
    // What is put right, empty, or told since is no danger.
    rig.infuse(&["tell", "--id", "2", "--value", "8.25"]).ok();
    let sheet = rig.read("sheet-1.csv").lines().map(|line| put_right(line, "3", "7.125")).collect::<String>();
    rig.write("sheet-1.csv", &sheet);
    let said = rig.infuse(&["ask"]).stderr;
    assert!(said.contains("of experiment 1: ") && !said.contains('3'), "{said}");
    rig.infuse(&["undo"]).ok();
    rig.infuse(&["undo"]).ok();
    let said = rig.infuse(&["ask"]).stderr;
    assert!(said.contains("of experiments 1, 2: "), "the same batch, asked for anew: {said}");
}

/// What a person wrote into the sheet of an ask that is taken back is in no journal: nobody is told to remove it.
#[test]
fn results_that_were_never_told_are_named_when_their_ask_is_taken_back() {
    let rig = Rig::pooled();
    ask(&rig);
    rig.fill("sheet-1.csv", |id| id == 2 || id == 5);
    let sheet = rig.read("sheet-1.csv");
    let said = rig.infuse(&["undo"]).stderr;
    let named = "sheet-1.csv belongs to what was taken back, and has results that were never told, of experiments 2, 5: they stand nowhere else.";
    assert!(said.contains(named) && !said.contains("remove"), "{said}");
    assert_eq!(rig.read("sheet-1.csv"), sheet, "it is a person's");
    // The same is asked for again.
    ask(&rig);
    assert!(rig.infuse(&["tell", "sheet-1.csv"]).ok().contains("Taken: 2 results."), "{sheet}");
    // What was told is in the journal.
    rig.infuse(&["undo"]).ok();
    let said = rig.infuse(&["undo"]).stderr;
    let named = "sheet-1.csv belongs to what was taken back, and has results that were told and taken back, of experiments 2, 5: move or remove it";
    assert!(said.contains(named), "{said}");
    // A row that cannot be read hides no other.
    ask(&rig);
    rig.write("sheet-1.csv", &sheet.replacen("\n1,", "\n1,x", 1));
    let said = rig.infuse(&["undo"]).stderr;
    let named = "and has results that were told and taken back, of experiments 2, 5. It has 1 row that cannot be read, and may hold more that \
                 stands nowhere else: row 2, column `id`: is `x3`";
    assert!(said.contains(named), "{said}");
    rig.write("sheet-1.csv", &sheet);
    ask(&rig);
    rig.write("sheet-1.csv", &sheet.replacen("id,", "di,", 1));
    let said = rig.infuse(&["undo"]).stderr;
    assert!(said.contains("whether it has results that were never told cannot be read ("), "{said}");
}

/// The sheet that was asked for under another name is named, and not an older one of the usual name.
#[test]
fn a_sheet_under_another_name_is_named_when_what_was_told_from_it_is_taken_back() {
    let rig = Rig::pooled();
    ask(&rig);
    undo(&rig);
    std::fs::create_dir(rig.path("desk")).unwrap();
    rig.infuse(&["ask", "--sheet", "desk/other.csv"]).ok();
    let next = rig.infuse(&["status"]).ok();
    assert!(next.contains("run what is left in desk/other.csv, then: infuse tell desk/other.csv"), "{next}");
    rig.fill("desk/other.csv", |id| id <= 2);
    rig.infuse(&["tell", "desk/other.csv"]).ok();
    let said = rig.infuse(&["undo"]).stderr;
    assert!(said.contains("desk/other.csv still has what was taken back, of experiments 1, 2: "), "{said}");
    let said = rig.infuse(&["undo"]).stderr;
    assert!(said.contains("desk/other.csv belongs to what was taken back"), "{said}");
    assert!(!said.contains("sheet-1.csv"), "that is older: {said}");
    // Asked for anew it is the usual one again.
    ask(&rig);
    let said = rig.infuse(&["undo"]).stderr;
    assert!(said.contains("sheet-1.csv belongs to") && !said.contains("other.csv"), "{said}");
}

/// One batch may stand in several sheets, and a copy of one may be told: each is named that belongs to what was taken back.
#[test]
fn all_sheets_of_what_was_taken_back_are_named() {
    let rig = Rig::pooled();
    ask(&rig);
    rig.infuse(&["ask", "--sheet", "other.csv"]).ok();
    rig.fill("sheet-1.csv", |id| id == 4);
    std::fs::copy(rig.path("sheet-1.csv"), rig.path("copy.csv")).unwrap();
    rig.infuse(&["tell", "copy.csv"]).ok();
    let said = rig.infuse(&["undo"]).stderr;
    for sheet in ["copy.csv", "sheet-1.csv"] {
        assert!(said.contains(&format!("{sheet} still has what was taken back, of experiment 4: ")), "{sheet}: {said}");
    }
    assert!(!said.contains("other.csv"), "it is empty: {said}");
    let said = rig.infuse(&["undo"]).stderr;
    for sheet in ["other.csv", "sheet-1.csv"] {
        assert!(said.contains(&format!("{sheet} belongs to what was taken back")), "{sheet}: {said}");
    }
    // From elsewhere it is named as one would type it there.
    let rig = Rig::new();
    rig.infuse(&["ask", "--sheet", "other.csv"]).ok();
    let mut from_above = rig.command(&["-C", rig.folder().to_str().unwrap(), "undo"]);
    let said = from_above.current_dir(rig.folder().parent().unwrap()).output().unwrap();
    let said = String::from_utf8_lossy(&said.stderr);
    let path = rig.path("other.csv");
    assert!(said.contains(&format!("{} belongs to what was taken back", path.display())), "{said}");
}

/// A row of a sheet, with another value if it is of this experiment.
fn put_right(line: &str, id: &str, value: &str) -> String {
    let mut cells: Vec<&str> = line.split(',').collect();
    if cells[1] == id {
        cells[5] = value;
    }
    format!("{}\n", cells.join(","))
}

/// A value that nothing can be made of, in a journal that nobody has checked: what came after it is taken back all the same.
#[test]
fn what_is_left_may_be_of_no_use_and_something_is_taken_back_all_the_same() {
    let rig = Rig::pooled();
    ask(&rig);
    tell(&rig, 1);
    ask(&rig);
    let journal = without_checksums(&rig.read("journal.jsonl"));
    let at = journal.find("\"value\":").unwrap() + "\"value\":".len();
    let end = at + journal[at..].find([',', '}']).unwrap();
    rig.write("journal.jsonl", &format!("{}1e308{}", &journal[..at], &journal[end..]));
    let said = rig.infuse(&["undo"]);
    assert!(said.stderr.contains("what is left cannot be used as it is"), "{}", said.stderr);
    assert!(said.ok().contains("Taken back: batch 2"));
}
