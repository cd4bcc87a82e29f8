//! Tables in workbooks: the first sheet of an `.xlsx`.

use std::collections::BTreeMap;
use std::io::Cursor;

use anyhow::{Context as _, Result, bail, ensure};
use calamine::{Data, ExcelDateTime, Reader as _, Xlsx, XlsxFormulaMetadata};

use super::bounds::{self, MOST_COLUMNS, MOST_ROWS};
use super::cells::{Cell, Kind, Records, Separator};

/// With which every `.xlsx` begins.
const ZIP: &[u8] = b"PK\x03\x04";
/// With which older workbooks begin, and those with a password.
const COMPOUND: &[u8] = b"\xd0\xcf\x11\xe0";
/// A workbook of more cells is no table of experiments.
const MOST_CELLS: usize = 5_000_000;

/// The rows of the first sheet, if these bytes are a workbook.
pub(super) fn records(bytes: &[u8]) -> Result<Option<Records>> {
    if bytes.starts_with(COMPOUND) {
        bail!("it is an old workbook, or one with a password: save it as .xlsx without a password, or as CSV");
    }
    if !bytes.starts_with(ZIP) {
        return Ok(None);
    }
    let advice = "save it as .xlsx, or as CSV";
    bounds::check(bytes)
        .map_err(|error| anyhow::anyhow!("it is no workbook that can be read ({error:#}): {advice}"))?;
    let mut book = Xlsx::new(Cursor::new(bytes))
        .map_err(|error| anyhow::anyhow!("it is no workbook that can be read ({error}): {advice}"))?;
    let name = book.sheet_names().first().cloned().with_context(|| format!("the workbook has no sheet: {advice}"))?;
    let rows = rows_of(&mut book, &name).map_err(|error| anyhow::anyhow!("sheet `{name}`: {error:#}: {advice}"))?;
    let is_remark =
        |row: &[Cell]| row.first().is_some_and(|cell| cell.kind == Kind::Plain && cell.text.starts_with('#'));
    let rows: Vec<_> = rows.into_iter().filter(|(_, row)| !is_remark(row)).collect();
    ensure!(
        rows.iter().any(|(_, row)| row.iter().any(|cell| !cell.text.is_empty())),
        "its first sheet, `{name}`, is empty, expected headings and rows"
    );
    Ok(Some(Records { rows, separator: Separator::Workbook }))
}

/// The rows that hold anything, each from the first column that does to its own last cell.
///
/// What lies between is not asked for: a stray cell in the last corner of a sheet costs one long row, not all cells before it.
fn rows_of(book: &mut Xlsx<Cursor<&[u8]>>, name: &str) -> Result<Vec<(usize, Vec<Cell>)>> {
    let mut cells: BTreeMap<(u32, u32), Cell> = BTreeMap::new();
    let mut reader = book.worksheet_cells_reader(name)?;
    // Formulas stay as they stand: to repeat a shared one for each of its cells is of no use here.
    while let Some(record) = reader.next_cell_with_formula_metadata()? {
        let is_formula = match &record.formula {
            Some(XlsxFormulaMetadata::Normal { formula }) => !formula.is_empty(),
            other => other.is_some(),
        };
        let (row, column) = record.pos;
        ensure!(
            row < MOST_ROWS && column < MOST_COLUMNS,
            "it has a cell beyond the {MOST_ROWS} rows and {MOST_COLUMNS} columns of a sheet"
        );
        let cell = cell(&record.value.into(), is_formula);
        if !cell.text.is_empty() {
            cells.insert(record.pos, cell);
        }
    }
    let left = cells.keys().map(|&(_, column)| column).min().unwrap_or(0);
    let mut rows: Vec<(usize, Vec<Cell>)> = Vec::new();
    let mut room = MOST_CELLS;
    for ((row, column), cell) in cells {
        let number = row as usize + 1;
        if rows.last().is_none_or(|(last, _)| *last != number) {
            rows.push((number, Vec::new()));
        }
        if let Some((_, row)) = rows.last_mut() {
            let before = row.len();
            row.resize((column - left) as usize, Cell::default());
            row.push(cell);
            room = room.checked_sub(row.len() - before).context("it has too many cells")?;
        }
    }
    Ok(rows)
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
