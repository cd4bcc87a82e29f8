//! Text tables as laboratories write them: commas for points, other encodings, units in the cells, remarks between the rows.

use crate::rig::{Rig, told};

/// A rig with a batch handed out.
fn asked() -> Rig {
    let rig = Rig::pooled();
    rig.infuse(&["ask"]).ok();
    rig
}

/// What the results of experiments 3 to 5 are once this was told.
#[track_caller]
fn assert_told(bytes: &[u8], expected: &[(u64, f64)]) {
    let rig = asked();
    std::fs::write(rig.path("back.csv"), bytes).unwrap();
    rig.infuse(&["tell", "back.csv"]).ok();
    assert_eq!(told(&rig.journal()).into_iter().collect::<Vec<_>>(), expected);
}

#[track_caller]
fn assert_refused(text: &str, words: &[&str]) {
    let rig = asked();
    rig.write("back.csv", text);
    let error = rig.infuse(&["tell", "back.csv"]).error();
    for word in words {
        assert!(error.contains(word), "`{word}` is not in {error}");
    }
    assert!(told(&rig.journal()).is_empty());
}

const EXPECTED: [(u64, f64); 3] = [(3, 7.5), (4, 8.125), (5, 9.0)];

#[test]
fn a_comma_is_the_decimal_point_between_semicolons_or_tabs() {
    let text = "id;vibration [mm/s];note\n3;7,5;1,2 or 3,4\n4;8,125;\n5;9;\n";
    assert_told(text.as_bytes(), &EXPECTED);
    assert_told(text.replace(';', "\t").as_bytes(), &EXPECTED);
    assert_told(format!("sep=;\r\n{}", text.replace('\n', "\r\n")).as_bytes(), &EXPECTED);
}

#[test]
fn what_may_be_read_in_two_ways_is_refused() {
    assert_refused("id,vibration [mm/s]\n3,\"1,234\"\n", &["row 2", "`1,234`", "it may be 1.234 or 1234"]);
    assert_refused("id,vibration [mm/s]\n3,\"7,5\"\n", &["row 2", "a decimal point, not a comma"]);
    assert_refused(
        "id;vibration [mm/s]\n3;7,5\n4;8.125\n",
        &["row 2, column `vibration [mm/s]`: is `7,5`", "not a comma, as row 3 has `8.125`"],
    );
    assert_refused("id;vibration [mm/s]\n3;1.234,5\n", &["`1.234,5`", "nothing between the thousands"]);
}

#[test]
fn utf_16_and_byte_order_marks_are_read() {
    let text = "id\tvibration [mm/s]\tnote\r\n3\t7,5\tüber µ\r\n4\t8,125\t\r\n5\t9\t\r\n";
    let units = || std::iter::once(0xfeff).chain(text.encode_utf16());
    assert_told(&units().flat_map(u16::to_le_bytes).collect::<Vec<u8>>(), &EXPECTED);
    assert_told(&units().flat_map(u16::to_be_bytes).collect::<Vec<u8>>(), &EXPECTED);
    assert_told(format!("\u{feff}{text}").as_bytes(), &EXPECTED);
    let rig = asked();
    let mut odd: Vec<u8> = units().flat_map(u16::to_le_bytes).collect();
    odd.push(b'x');
    std::fs::write(rig.path("odd.csv"), odd).unwrap();
    assert!(rig.infuse(&["tell", "odd.csv"]).error().contains("begins like UTF-16"));
    let without_mark: Vec<u8> = text.replace(['ü', 'µ'], "u").encode_utf16().flat_map(u16::to_le_bytes).collect();
    std::fs::write(rig.path("odd.csv"), without_mark).unwrap();
    assert!(rig.infuse(&["tell", "odd.csv"]).error().contains("save it as CSV in UTF-8"));
}

#[test]
fn headings_in_any_case_comments_and_units_in_cells_are_read() {
    let text = "# by Ann\nID, Vibration [mm/s] ,Note\n# morning\n3,7.5 mm/s,\n\n4,8.125mm/s,\n5,9 [mm/s],\n";
    assert_told(text.as_bytes(), &EXPECTED);
    // Comments and empty rows count, as in a spreadsheet; the unit keeps its case.
    assert_refused("# by Ann\nid,vibration [mm/s]\n# a\n# b\n\n3,7.5 m/s\n", &["row 6", "`mm/s`", "`m/s`"]);
    assert_refused("id,vibration [Mm/s]\n3,7.5\n", &["another unit, expected `vibration [mm/s]`"]);
    assert_refused("id,vibration [mm/s],VIBRATION [mm/s]\n3,7.5,7.5\n", &["comes twice"]);
}

#[test]
fn tables_of_earlier_experiments_and_of_simulations_are_read_alike() {
    let rig = Rig::pooled();
    let old = "# notebook 3\nSpring [N/mm];Damper Gain [N s/mm];Vibration [mm/s]\n21,5 N/mm;1,8;7,25\n";
    rig.write("old.csv", old);
    rig.infuse(&["import", "old.csv", "--source", "notebook"]).ok();
    assert_eq!(rig.journal().last().unwrap()["point"], serde_json::json!([21.5, 1.8]));
    let table = rig.read("simulation.csv").replace(',', ";").replace('.', ",");
    let before = rig.infuse(&["ask", "--json"]).ok();
    let other = Rig::pooled();
    other.write("old.csv", old);
    other.infuse(&["import", "old.csv", "--source", "notebook"]).ok();
    other.write("simulation.csv", &table);
    assert_eq!(other.infuse(&["ask", "--json"]).ok(), before);
}

#[test]
fn long_texts_are_not_said_back_whole() {
    let long = "x".repeat(3_000_000);
    for text in [
        format!("id,{long}\n3,7\n"),
        format!("{long}\n3\n"),
        format!("id,vibration [{long}]\n3,7\n"),
        format!("id,vibration [mm/s]\n3,{long}\n"),
        format!("id,vibration [mm/s]\n{long},7\n"),
        format!("id,vibration [mm/s]\n3,7 {long}\n"),
    ] {
        let rig = asked();
        rig.write("long.csv", &text);
        let error = rig.infuse(&["tell", "long.csv"]).error();
        assert!(error.len() < 1000, "{}", error.len());
    }
}

/// However few columns the table has, and wherever the next quote stands.
/// A number that is cut is another number; who leaves out empty cells ends the row.
#[test]
fn a_file_that_ends_within_a_row_is_refused() {
    for text in ["id,vibration [mm/s],note\n3,7.5,\n4,8", "id,vibration [mm/s],note\n3,8"] {
        assert_refused(text, &["the file ends within it, after 2 of 3 cells", "end it with a line break"]);
    }
    assert_told(b"id,vibration [mm/s],note\n3,7.5\n4,8.125\n5,9\n", &EXPECTED);
    assert_told(b"id,vibration [mm/s],note\n3,7.5\n4,8.125\n5,9,", &EXPECTED);
}

#[test]
fn a_quote_that_is_never_closed_swallows_no_rows() {
    for text in [
        "id,vibration [mm/s],note\n3,7.5,\"oops\n4,7\n5,8\n",
        "id,note,vibration [mm/s]\n3,\"oops,7.5\n4,,7\n5,\"b\",8\n",
        "# \"\nid,note,vibration [mm/s]\n3,\"oops,7.5\n4,,7\n",
        "id,note,vibration [mm/s]\n3,\"a \"\"b\"\" c\",7.5\n4,\"oops\"\"\n",
    ] {
        let row = text.lines().position(|line| line.contains("oops")).unwrap() + 1;
        assert_refused(text, &[&format!("row {row}: a quote"), "expected a second one"]);
    }
    assert_told(
        b"id,note,vibration [mm/s]\r\n3,\"two\r\nlines\" ,7.5\r\n4,a\"b,8.125\r\n5,\"\"\"c\"\"\",9\r\n",
        &EXPECTED,
    );
}
