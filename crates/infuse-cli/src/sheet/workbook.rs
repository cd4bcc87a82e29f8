//! Tables in workbooks: the first sheet of an `.xlsx`.

use std::io::Cursor;

use anyhow::{Context as _, Result, bail, ensure};
use calamine::{Data, ExcelDateTime, Range, Reader as _, Xlsx};

use super::cells::{Cell, Kind, Records, Separator};

/// With which every `.xlsx` begins.
const ZIP: &[u8] = b"PK\x03\x04";
/// With which older workbooks begin, and those with a password.
const COMPOUND: &[u8] = b"\xd0\xcf\x11\xe0";
/// A workbook of more cells is no table of experiments.
const MOST_CELLS: usize = 50_000_000;

/// The rows of the first sheet, if these bytes are a workbook.
pub(super) fn records(bytes: &[u8]) -> Result<Option<Records>> {
    if bytes.starts_with(COMPOUND) {
        bail!("it is an old workbook, or one with a password: save it as .xlsx without a password, or as CSV");
    }
    if !bytes.starts_with(ZIP) {
        return Ok(None);
    }
    let advice = "save it as .xlsx, or as CSV";
    let mut book = Xlsx::new(Cursor::new(bytes))
        .map_err(|error| anyhow::anyhow!("it is no workbook that can be read ({error}): {advice}"))?;
    let name = book.sheet_names().first().cloned().with_context(|| format!("the workbook has no sheet: {advice}"))?;
    let cells = book.worksheet_range(&name).map_err(|error| anyhow::anyhow!("sheet `{name}`: {error}: {advice}"))?;
    let formulas = book.worksheet_formula(&name).unwrap_or_default();
    let (height, width) = cells.get_size();
    ensure!(height.saturating_mul(width) <= MOST_CELLS, "sheet `{name}` has {height} rows of {width} cells: {advice}");
    let mut rows = rows_of(&cells, &formulas);
    rows.retain(|(_, row)| !row.first().is_some_and(|cell| cell.kind == Kind::Plain && cell.text.starts_with('#')));
    ensure!(
        rows.iter().any(|(_, row)| row.iter().any(|cell| !cell.text.is_empty())),
        "its first sheet, `{name}`, is empty, expected headings and rows"
    );
    Ok(Some(Records { rows, separator: Separator::Workbook }))
}

/// All rows from the first that is not empty, from the first column on.
fn rows_of(cells: &Range<Data>, formulas: &Range<String>) -> Vec<(usize, Vec<Cell>)> {
    let Some(((first, left), (last, right))) = extent(cells).into_iter().chain(extent(formulas)).reduce(|a, b| {
        let ((top_a, left_a), (bottom_a, right_a)) = a;
        let ((top_b, left_b), (bottom_b, right_b)) = b;
        ((top_a.min(top_b), left_a.min(left_b)), (bottom_a.max(bottom_b), right_a.max(right_b)))
    }) else {
        return Vec::new();
    };
    let row = |row: u32| {
        let cell = |column: u32| {
            let formula = formulas.get_value((row, column)).is_some_and(|formula| !formula.is_empty());
            cell(cells.get_value((row, column)).unwrap_or(&Data::Empty), formula)
        };
        (row as usize + 1, (left..=right).map(cell).collect())
    };
    (first..=last).map(row).collect()
}

fn extent<T: calamine::CellType>(range: &Range<T>) -> Option<((u32, u32), (u32, u32))> {
    range.start().zip(range.end())
}

fn cell(data: &Data, is_formula: bool) -> Cell {
    let of = |text: String, kind: Kind| Cell { text, kind };
    match data {
        Data::Empty if is_formula => of("a formula".to_owned(), Kind::Formula),
        Data::String(text) if is_formula && text.is_empty() => of(String::new(), Kind::Plain),
        Data::Empty => Cell::default(),
        Data::Int(value) => Cell::plain(value.to_string()),
        Data::Float(value) => Cell::plain(number(*value)),
        Data::String(text) => Cell::plain(text.trim()),
        Data::Bool(value) => of(value.to_string(), Kind::Boolean),
        Data::DateTime(date) => of(date_in_words(date), Kind::Date),
        Data::DateTimeIso(text) | Data::DurationIso(text) => of(text.clone(), Kind::Date),
        Data::Error(error) => of(error.to_string(), Kind::Error),
    }
}

/// With all its digits.
fn number(value: f64) -> String {
    if value != 0.0 && !(1e-5..1e15).contains(&value.abs()) { format!("{value:e}") } else { value.to_string() }
}

fn date_in_words(date: &ExcelDateTime) -> String {
    if date.is_duration() {
        return format!("{} h", number(24.0 * date.as_f64()));
    }
    let (year, month, day, hour, minute, second, _) = date.to_ymd_hms_milli();
    let time =
        if (hour, minute, second) == (0, 0, 0) { String::new() } else { format!(" {hour:02}:{minute:02}:{second:02}") };
    format!("{year:04}-{month:02}-{day:02}{time}")
}
