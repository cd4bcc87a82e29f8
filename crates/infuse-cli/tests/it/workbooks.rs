//! Sheets as workbooks: written, filled in as a spreadsheet would, and taken back.

use std::collections::BTreeMap;

use calamine::{Data, Reader as _, Xlsx};
use rust_xlsxwriter::{ExcelDateTime, Format, Formula, Workbook};

use crate::rig::{Rig, measured, told};

/// What a person puts into a cell.
enum Entry {
    Number(f64),
    Text(&'static str),
    Truth(bool),
    Date,
    /// A formula, with the value that the spreadsheet has computed.
    Formula(&'static str, &'static str),
}

/// The first sheet, cell by cell.
fn cells(rig: &Rig, name: &str) -> Vec<Vec<Data>> {
    let bytes = std::fs::read(rig.path(name)).unwrap();
    let mut book = Xlsx::new(std::io::Cursor::new(bytes)).unwrap();
    let range = book.worksheet_range_at(0).unwrap().unwrap();
    assert_eq!(range.start(), Some((0, 0)));
    range.rows().map(<[Data]>::to_vec).collect()
}

/// Writes these cells with some replaced, by row and heading; the headings are row 1.
fn fill(rig: &Rig, cells: &[Vec<Data>], entries: &[(u32, &str, Entry)], name: &str) {
    let mut book = Workbook::new();
    let sheet = book.add_worksheet();
    for (row, line) in (0_u32..).zip(cells) {
        for (column, cell) in (0_u16..).zip(line) {
            match cell {
                Data::Float(value) => sheet.write_number(row, column, *value).unwrap(),
                Data::String(text) => sheet.write_string(row, column, text).unwrap(),
                _ => continue,
            };
        }
    }
    let date = Format::new().set_num_format("yyyy-mm-dd");
    for (row, heading, entry) in entries {
        let is_it = |cell: &Data| matches!(cell, Data::String(text) if text == heading);
        let (row, column) = (row - 1, cells[0].iter().position(is_it).unwrap() as u16);
        match entry {
            Entry::Number(value) => sheet.write_number(row, column, *value),
            Entry::Text(text) => sheet.write_string(row, column, *text),
            Entry::Truth(value) => sheet.write_boolean(row, column, *value),
            Entry::Date => {
                sheet.write_datetime_with_format(row, column, ExcelDateTime::from_ymd(2026, 5, 7).unwrap(), &date)
            }
            Entry::Formula(formula, result) => {
                sheet.write_formula(row, column, Formula::new(*formula).set_result(*result))
            }
        }
        .unwrap();
    }
    book.save(rig.path(name)).unwrap();
}

fn asked() -> Rig {
    let rig = Rig::pooled();
    rig.edit("seed = 1", "seed = 1\nsheets = \"xlsx\"");
    rig.infuse(&["ask"]).ok();
    rig
}

const RESPONSE: &str = "vibration [mm/s]";

/// The same campaign with text tables and with workbooks says the same, batch after batch.
#[test]
fn a_campaign_with_workbooks_is_that_with_text_tables() {
    let (books, texts) = (asked(), Rig::pooled());
    for batch in 1..=2 {
        books.infuse(&["ask", "--anyway"]).ok();
        let name = format!("sheet-{batch}.xlsx");
        let cells = cells(&books, &name);
        let of = |cell: &Data| if let Data::Float(value) = cell { *value } else { panic!("{cell:?}") };
        let entries: Vec<_> = (2_u32..)
            .zip(&cells[1..])
            .filter(|(_, row)| matches!(row[1], Data::Float(_)))
            .map(|(number, row)| {
                let value = measured(of(&row[1]) as u64, of(&row[3]), of(&row[4]));
                (number, RESPONSE, Entry::Number(value.parse().unwrap()))
            })
            .collect();
        assert_eq!(entries.len(), 10);
        fill(&books, &cells, &entries, &name);
        assert!(books.infuse(&["tell", &name]).ok().contains("Taken: 10 results."));
        texts.infuse(&["ask", "--anyway"]).ok();
        texts.fill(&format!("sheet-{batch}.csv"), |_| true);
        texts.infuse(&["tell", &format!("sheet-{batch}.csv")]).ok();
    }
    assert_eq!(books.status(), texts.status());
}

#[test]
fn the_same_sheet_has_the_same_bytes_and_is_left_alone() {
    let (one, other) = (asked(), asked());
    let bytes = |rig: &Rig| std::fs::read(rig.path("sheet-1.xlsx")).unwrap();
    assert_eq!(bytes(&one), bytes(&other));
    assert!(one.infuse(&["ask"]).ok().contains("sheet-1.xlsx, which was there already"));
    assert!(one.infuse(&["status"]).ok().contains("infuse tell sheet-1.xlsx"));
    // Whatever campaign.toml says, a name says what is meant.
    let rig = Rig::pooled();
    for name in ["old.xls", "open.ODS"] {
        assert!(
            rig.infuse(&["ask", "--sheet", name]).error().contains("as text (.csv) or as a workbook (.xlsx)"),
            "{name}"
        );
    }
    assert!(!rig.path("journal.jsonl").exists(), "nothing was handed out");
    rig.infuse(&["ask", "--sheet", "mine.XLSX"]).ok();
    assert_eq!(cells(&rig, "mine.XLSX")[0][5], Data::String(RESPONSE.to_owned()));
    rig.edit("seed = 1", "seed = 1\nsheets = \"ods\"");
    assert!(rig.infuse(&["ask"]).error().contains("expected `csv` or `xlsx`"));
}

#[test]
fn headings_and_settings_are_locked_and_what_is_to_be_filled_in_is_checked() {
    let rig = asked();
    let bytes = std::fs::read(rig.path("sheet-1.xlsx")).unwrap();
    let part = |name: &str| {
        let mut archive = zip_part(&bytes, name);
        archive.retain(|c| c != '\n');
        archive
    };
    let sheet = part("xl/worksheets/sheet1.xml");
    assert!(sheet.contains("<sheetProtection sheet=\"1\""), "{sheet}");
    let rule = |cells: &str, from: &str, to: &str| {
        let at = sheet.find(&format!("sqref=\"{cells}\"")).unwrap();
        let rule = &sheet[at..at + sheet[at..].find("</dataValidation>").unwrap()];
        assert!(
            rule.contains(&format!("<formula1>{from}</formula1>"))
                && rule.contains(&format!("<formula2>{to}</formula2>"))
        );
    };
    // The bounds of spring are 10 to 34, and what was made may lie half the width beside them.
    rule("H2:H61", "-2", "46");
    rule("F2:F61", "0", &format!("1{}", "0".repeat(100)));
    let notes = part("xl/comments1.xml");
    for words in ["what was measured, in mm/s", "Asked for are 10 to 34 N/mm", "not to be changed"] {
        assert!(notes.contains(words), "{words}");
    }
    // Which style is unlocked, by the place of its cell format.
    let styles = part("xl/styles.xml");
    let formats = styles.split_once("<cellXfs").unwrap().1.split_once("</cellXfs>").unwrap().0;
    let formats: Vec<&str> = formats.split("<xf ").skip(1).collect();
    let style = |cell: &str| -> usize {
        let at = sheet.find(&format!("r=\"{cell}\"")).unwrap();
        let tag = &sheet[at..at + sheet[at..].find('>').unwrap()];
        tag.split_once("s=\"").map_or(0, |(_, rest)| rest.split('"').next().unwrap().parse().unwrap())
    };
    for (cell, is_free) in [
        ("A1", false),
        ("F1", false),
        ("B2", false),
        ("D2", false),
        ("F2", true),
        ("H3", true),
        ("J2", true),
        ("C12", true),
    ] {
        assert_eq!(formats[style(cell)].contains("locked=\"0\""), is_free, "{cell}: {}", formats[style(cell)]);
    }
}

/// One file of a workbook, by the same library that reads workbooks for us.
fn zip_part(bytes: &[u8], name: &str) -> String {
    use std::io::Read as _;
    let mut archive = zip::ZipArchive::new(std::io::Cursor::new(bytes)).unwrap();
    let mut text = String::new();
    archive.by_name(name).unwrap().read_to_string(&mut text).unwrap();
    text
}

#[test]
fn cells_of_all_kinds_are_taken_or_named() {
    let rig = asked();
    let cells = cells(&rig, "sheet-1.xlsx");
    let told_of = |entries: &[(u32, &str, Entry)]| {
        fill(&rig, &cells, entries, "back.xlsx");
        rig.infuse(&["tell", "back.xlsx"])
    };
    let before = rig.read("journal.jsonl");
    for (entry, words) in [
        (Entry::Date, "is `2026-05-07`, expected a number; the cell holds a date"),
        (Entry::Truth(true), "is `true`, expected a number; the cell holds true or false"),
        (Entry::Formula("=1/0", "#DIV/0!"), "expected a value; the cell holds the error of a formula"),
        (Entry::Text("7,5"), "is `7,5`, expected a number with a decimal point, not a comma"),
        (Entry::Text("7.5 m/s"), "in `mm/s`, the unit of the column, and not in `m/s`"),
        (Entry::Number(-1.0), "at least 0 mm/s"),
    ] {
        let error = told_of(&[(3, RESPONSE, entry), (4, RESPONSE, Entry::Number(8.0))]).error();
        assert!(error.contains("row 3, column `vibration [mm/s]`:") && error.contains(words), "{error}");
    }
    let error = told_of(&[(3, "failed", Entry::Formula("=1/0", "#DIV/0!"))]).error();
    assert!(error.contains("row 3, column `failed`"), "{error}");
    assert_eq!(rig.read("journal.jsonl"), before, "nothing is half taken");
    let ids: Vec<u64> =
        cells[1..].iter().filter_map(|row| if let Data::Float(id) = row[1] { Some(id as u64) } else { None }).collect();
    told_of(&[
        (2, RESPONSE, Entry::Number(7.25)),
        (3, RESPONSE, Entry::Formula("=15/2", "7.5")),
        (4, RESPONSE, Entry::Text("8.25 mm/s")),
        (5, "failed", Entry::Text("it fell over")),
        (5, "note", Entry::Date),
        (6, RESPONSE, Entry::Number(9.0)),
        (6, "actual spring [N/mm]", Entry::Number(20.5)),
        // One more run of the first, in a free row.
        (12, "repeats", Entry::Number(ids[0] as f64)),
        (12, RESPONSE, Entry::Number(7.5)),
    ])
    .ok();
    let values: BTreeMap<u64, f64> = told(&rig.journal());
    let taken = [1, 2, 4].map(|index| values[&ids[index]].to_string());
    assert_eq!(taken, ["7.5", "8.25", "9"]);
    let journal = rig.journal();
    assert!(journal.iter().any(|line| line["failed"] == "it fell over" && line["note"] == "2026-05-07"));
    assert!(journal.iter().any(|line| line["repeat"] == 1 && line["value"] == 7.5));
}

#[test]
fn older_experiments_come_from_a_workbook_and_other_files_are_told_apart() {
    let rig = Rig::pooled();
    let headings = ["Spring [N/mm]", "damper gain [N s/mm]", RESPONSE, "source"];
    let row = |spring: f64| vec![Data::Float(spring), Data::Float(1.1), Data::Float(8.5), Data::Empty];
    let table = vec![
        vec![Data::String("# by Ann".to_owned())],
        headings.iter().map(|heading| Data::String((*heading).to_owned())).collect(),
        row(20.0),
        Vec::new(),
        row(22.0),
    ];
    fill(&rig, &table, &[], "old.xlsx");
    assert!(rig.infuse(&["import", "old.xlsx", "--source", "notebook"]).ok().contains("2 experiments"));
    std::fs::write(rig.path("old.xls"), b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1").unwrap();
    assert!(rig.infuse(&["import", "old.xls", "--source", "x"]).error().contains("save it as .xlsx"));
    std::fs::write(rig.path("cut.xlsx"), &std::fs::read(rig.path("old.xlsx")).unwrap()[..900]).unwrap();
    assert!(rig.infuse(&["import", "cut.xlsx", "--source", "x"]).error().contains("no workbook that can be read"));
    fill(&rig, &[], &[], "empty.xlsx");
    assert!(rig.infuse(&["import", "empty.xlsx", "--source", "x"]).error().contains("is empty"));
}

/// The workbook with one of its files replaced.
fn with_part(bytes: &[u8], name: &str, change: impl FnOnce(String) -> String) -> Vec<u8> {
    let mut archive = zip::ZipArchive::new(std::io::Cursor::new(bytes)).unwrap();
    let mut changed = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    for index in 0..archive.len() {
        let part = archive.by_index(index).unwrap();
        if part.name().unwrap() != name {
            changed.raw_copy_file(part).unwrap();
        }
    }
    changed.start_file(name, zip::write::SimpleFileOptions::default()).unwrap();
    std::io::Write::write_all(&mut changed, change(zip_part(bytes, name)).as_bytes()).unwrap();
    changed.finish().unwrap().into_inner()
}

/// What stands in a workbook decides how much of it is read, not what it says to hold.
#[test]
fn a_workbook_takes_no_more_memory_than_its_cells() {
    let rig = Rig::pooled();
    let setting = |text: &str| Data::String(text.to_owned());
    let headings = [setting("spring [N/mm]"), setting("damper gain [N s/mm]"), setting(RESPONSE)];
    let table = vec![headings.to_vec(), vec![Data::Float(20.0), Data::Float(1.1), Data::Float(8.5)]];
    fill(&rig, &table, &[], "old.xlsx");
    let bytes = std::fs::read(rig.path("old.xlsx")).unwrap();
    let import = |bytes: Vec<u8>| {
        std::fs::write(rig.path("changed.xlsx"), bytes).unwrap();
        rig.infuse(&["import", "changed.xlsx", "--source", "x"])
    };
    const SHEET: &str = "xl/worksheets/sheet1.xml";
    let cell =
        |text: &'static str| move |sheet: String| sheet.replacen("</sheetData>", &format!("{text}</sheetData>"), 1);
    // The last corner of all sheets: a table with all cells before it would hold 17 billion.
    let corner = cell("<row r=\"1048576\"><c r=\"XFD1048576\"><v>1</v></c></row>");
    let error = import(with_part(&bytes, SHEET, corner)).error();
    assert!(error.contains("row 1048576 has 16384 cells, expected 3"), "{error}");
    let beyond = cell("<row r=\"1048577\"><c r=\"A1048577\"><v>1</v></c></row>");
    assert!(
        import(with_part(&bytes, SHEET, beyond)).error().contains("lies beyond the 1048576 rows and 16384 columns")
    );
    let nowhere = cell("<row r=\"3\"><c r=\"A/3\"><v>1</v></c></row>");
    assert!(import(with_part(&bytes, SHEET, nowhere)).error().contains("`A/3` is no cell"));
    let texts = |part: String| part.replace("uniqueCount=\"3\"", "uniqueCount=\"99999999999\"");
    let error = import(with_part(&bytes, "xl/sharedStrings.xml", texts)).error();
    assert!(error.contains("it says to hold `99999999999` texts"), "{error}");
    // Whatever stands where the reading ends: a blank, or the middle of a tag.
    for n_before in 0..3 {
        let tags = |sheet: String| sheet + &" ".repeat(n_before) + &"<a></a>".repeat(15_000_000);
        let error = import(with_part(&bytes, SHEET, tags)).error();
        assert!(error.contains("more than 100 MB when it is unpacked"), "{error}");
    }
    // A formula that says to fill all of the sheet fills nothing.
    let shared = "<row r=\"3\"><c r=\"A3\"><f t=\"shared\" ref=\"A3:XFD1048576\" si=\"4294967295\">1+1</f><v>22</v></c>\
                  <c r=\"B3\"><v>0.9</v></c><c r=\"C3\"><f t=\"shared\" si=\"4294967295\"/><v>7.5</v></c></row>";
    assert!(import(with_part(&bytes, SHEET, cell(shared))).ok().contains("2 experiments"));
}
