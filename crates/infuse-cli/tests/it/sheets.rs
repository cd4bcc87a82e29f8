//! Sheets with faults: each cell is named, and nothing is half taken.

use crate::rig::Rig;

/// That a filled sheet, with the cell of a row under a heading replaced, is refused in these words.
#[track_caller]
fn assert_refused(row: usize, heading: &str, value: &str, words: &[&str]) {
    let rig = Rig::new();
    rig.infuse(&["ask"]).ok();
    rig.fill("sheet-1.csv", |_| true);
    let before = rig.read("journal.jsonl");
    let mut records: Vec<Vec<String>> =
        rig.read("sheet-1.csv").lines().map(|line| line.split(',').map(str::to_owned).collect()).collect();
    let column = records[0].iter().position(|found| found == heading).unwrap();
    let mut table = csv::Writer::from_writer(Vec::new());
    records[row - 1][column] = value.to_owned();
    records.iter().for_each(|record| table.write_record(record).unwrap());
    std::fs::write(rig.path("sheet-1.csv"), table.into_inner().unwrap()).unwrap();
    let error = rig.infuse(&["tell", "sheet-1.csv"]).error();
    for word in words {
        assert!(error.contains(word), "`{word}` is not in {error}");
    }
    assert_eq!(rig.read("journal.jsonl"), before, "nothing is half taken");
}

#[test]
fn cells_that_cannot_be_are_named_by_row_column_and_value() {
    let response = "vibration [mm/s]";
    let at = |row: usize, heading: &str| format!("row {row}, column `{heading}`");
    assert_refused(3, response, "7,5", &[&at(3, response), "`7,5`", "decimal point, not a comma"]);
    assert_refused(4, response, "NaN", &[&at(4, response), "`NaN`", "finite number", "reported as failed"]);
    assert_refused(11, response, "inf", &[&at(11, response), "finite number"]);
    assert_refused(2, response, "1e300", &["`1e300`", "at most 1e100"]);
    assert_refused(2, "spring [N/mm]", "0,5", &["`0,5`", "decimal point, not a comma"]);
    assert_refused(2, response, "7.5 m/s", &["`7.5 m/s`", "a number in `mm/s`", "not in `m/s`"]);
    assert_refused(2, response, "1,234", &["`1,234`", "may be 1.234 or 1234"]);
    assert_refused(2, response, "-1", &["`-1`", "at least 0 mm/s"]);
    assert_refused(5, "id", "77", &[&at(5, "id"), "`77`", "1 to 10"]);
    assert_refused(5, "id", "x", &["`x`", "1 to 10"]);
    assert_refused(2, "id", "", &[&at(2, "id"), "is empty"]);
    assert_refused(2, "spring [N/mm]", "11", &[&at(2, "spring [N/mm]"), "as it was asked for", "`actual spring`"]);
    assert_refused(2, "actual spring [N/mm]", "100", &["-2 to 46 N/mm", "half the width"]);
    assert_refused(2, "actual spring [N/mm]", "eleven", &["`eleven`", "number"]);
    assert_refused(2, "failed", "lost", &[&at(2, "failed"), "as there is a value"]);
}

#[test]
fn headings_that_cannot_be_are_named_with_what_was_expected() {
    assert_refused(1, "vibration [mm/s]", "vibration", &["column 6", "has no unit, expected `vibration [mm/s]`"]);
    assert_refused(1, "spring [N/mm]", "spring [N/m]", &["column 4", "another unit, expected `spring [N/mm]`"]);
    assert_refused(1, "note", "remark", &["column 10", "`remark` is not known"]);
    assert_refused(1, "note", "id", &["`id` comes twice"]);
    assert_refused(1, "id", "", &["no column `id`"]);
}

#[test]
fn every_fault_is_shown_at_once() {
    let rig = Rig::new();
    rig.infuse(&["ask"]).ok();
    rig.fill("sheet-1.csv", |_| true);
    let text = rig.read("sheet-1.csv");
    let rows: Vec<String> = text
        .lines()
        .enumerate()
        .map(|(index, line)| {
            let mut cells: Vec<&str> = line.split(',').collect();
            if index > 0 {
                cells[5] = "much";
            }
            cells.join(",")
        })
        .collect();
    rig.write("sheet-1.csv", &rows.join("\n"));
    let error = rig.infuse(&["tell", "sheet-1.csv"]).error();
    assert!(error.contains("has 10 faults, and nothing of it was taken"), "{error}");
    assert_eq!(error.matches("`much`").count(), 10, "{error}");
}

#[test]
fn an_id_that_comes_twice_with_different_values_is_refused_and_with_the_same_is_one() {
    let rig = Rig::new();
    rig.infuse(&["ask"]).ok();
    let headings = "id,vibration [mm/s]";
    rig.write("two.csv", &format!("{headings}\n3,7.5\n4,8\n3,7.6\n"));
    let error = rig.infuse(&["tell", "two.csv"]).error();
    assert!(
        error.contains("row 4, column `id`: is `3`, expected one row for it: row 2 says something else"),
        "{error}"
    );
    rig.write("two.csv", &format!("{headings}\n3,7.5\n4,8\n3,7.5\n"));
    let said = rig.infuse(&["tell", "two.csv"]);
    assert!(said.stderr.contains("row 4 says of experiment 3 what row 2 says, and was not counted"), "{}", said.stderr);
    assert!(said.ok().contains("Taken: 2 results."));
    rig.write("two.csv", &format!("{headings}\n3,7.6\n5,9\n"));
    let error = rig.infuse(&["tell", "two.csv"]).error();
    assert!(error.contains("expected the result known before, 7.5 mm/s"), "{error}");
    assert_eq!(rig.status()["told"], 2, "experiment 5 was not taken either");
}

#[test]
fn tables_as_spreadsheets_write_them_are_read() {
    let rig = Rig::new();
    rig.infuse(&["ask"]).ok();
    // A byte order mark, semicolons, line breaks of two characters, empty rows, spaces.
    let text = "\u{feff}id;vibration [mm/s];note\r\n 3 ; 7.5 ;\"later; or not\"\r\n;;\r\n4;8;\r\n5;;\r\n";
    rig.write("sheet.csv", text);
    let said = rig.infuse(&["tell", "sheet.csv"]).ok();
    assert!(said.contains("Taken: 2 results.") && said.contains("1 row not filled in yet."), "{said}");
    rig.write("latin.csv", "");
    std::fs::write(rig.path("latin.csv"), b"id,vibration [mm/s]\n6,7.5\xb5\n").unwrap();
    assert!(rig.infuse(&["tell", "latin.csv"]).error().contains("line 2: byte 25 of the file is no UTF-8"));
    rig.write("none.csv", "");
    assert!(rig.infuse(&["tell", "none.csv"]).error().contains("the file is empty"));
    rig.write("wide.csv", "id,vibration [mm/s]\n6,7,5\n");
    let error = rig.infuse(&["tell", "wide.csv"]).error();
    assert!(error.contains("row 2 has 3 cells, expected 2") && error.contains("comma for a decimal point"), "{error}");
    // The one too many is the last, and empty.
    rig.write("shifted.csv", "id,vibration [mm/s],actual spring [N/mm],note\n6,7.5,10,1,\n");
    let error = rig.infuse(&["tell", "shifted.csv"]).error();
    assert!(error.contains("row 2 has 5 cells, expected 4") && error.contains("comma for a decimal point"), "{error}");
    // Empty rows count, and a line break in a cell does not.
    rig.write("rows.csv", "id,vibration [mm/s],note\n6,7.5,\"two\nlines\"\n\n7,x,\n");
    let error = rig.infuse(&["tell", "rows.csv"]).error();
    assert!(error.contains("row 4, column `vibration [mm/s]`: is `x`"), "{error}");
    assert!(rig.infuse(&["tell", "absent.csv"]).error().contains("absent.csv"));
}
