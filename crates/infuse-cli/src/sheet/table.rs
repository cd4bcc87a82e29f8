//! Tables that people fill in: read whole, with every fault by row, column and value.

use std::fmt;
use std::path::Path;

use anyhow::{Context as _, Result, bail, ensure};

/// More faults than this are counted, not shown.
const MOST_SHOWN: usize = 20;

/// What is wrong with a cell.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Fault {
    /// As a spreadsheet counts: the headings are row 1.
    pub(crate) row: usize,
    pub(crate) column: String,
    pub(crate) value: String,
    pub(crate) expected: String,
}

impl fmt::Display for Fault {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { row, column, value, expected } = self;
        let value = if value.is_empty() { "is empty".to_owned() } else { format!("is `{value}`") };
        // Not from a table.
        if *row == 0 {
            return write!(formatter, "`{column}` {value}, expected {expected}");
        }
        write!(formatter, "row {row}, column `{column}`: {value}, expected {expected}")
    }
}

/// All faults of a file, unless there are none.
pub(crate) fn none_of(name: &str, faults: &[Fault]) -> Result<()> {
    if faults.is_empty() {
        return Ok(());
    }
    let mut lines: Vec<String> = faults.iter().take(MOST_SHOWN).map(|fault| format!("  {fault}")).collect();
    if faults.len() > MOST_SHOWN {
        lines.push(format!("  and {} more", faults.len() - MOST_SHOWN));
    }
    let cells = crate::number::count(faults.len(), "fault");
    bail!("{name} has {cells}, and nothing of it was taken:\n{}", lines.join("\n"))
}

/// A column that a table may have.
#[derive(Debug, Clone)]
pub(crate) struct Column {
    pub(crate) name: String,
    pub(crate) unit: String,
    pub(crate) is_required: bool,
}

impl Column {
    pub(crate) fn required(name: &str, unit: &str) -> Self {
        Self { name: name.to_owned(), unit: unit.to_owned(), is_required: true }
    }

    pub(crate) fn optional(name: &str, unit: &str) -> Self {
        Self { name: name.to_owned(), unit: unit.to_owned(), is_required: false }
    }

    pub(crate) fn heading(&self) -> String {
        crate::problem::heading(&self.name, &self.unit)
    }
}

/// The cells of a file under columns that are known.
#[derive(Debug)]
pub(crate) struct Table {
    headings: Vec<String>,
    /// Where each known column stands in the file.
    places: Vec<Option<usize>>,
    rows: Vec<Row>,
}

/// A row that is not empty.
#[derive(Debug)]
pub(crate) struct Row {
    pub(crate) number: usize,
    cells: Vec<String>,
}

impl Table {
    /// Reads a file whose columns are among these, in any order. Commas, semicolons or tabs separate cells.
    pub(crate) fn read(path: &Path, columns: &[Column]) -> Result<Self> {
        let bytes = std::fs::read(path).with_context(|| path.display().to_string())?;
        let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&bytes);
        Self::parse(bytes, columns).with_context(|| path.display().to_string())
    }

    pub(crate) fn parse(bytes: &[u8], columns: &[Column]) -> Result<Self> {
        let text = std::str::from_utf8(bytes).map_err(|error| {
            anyhow::anyhow!("byte {} is no UTF-8: save the table as CSV in UTF-8", error.valid_up_to())
        })?;
        ensure!(!text.trim().is_empty(), "the file is empty, expected headings and rows");
        let first = text.lines().next().unwrap_or_default();
        let separator = [b',', b';', b'\t'].into_iter().max_by_key(|&separator| {
            // Of equals the last wins, so commas count a little more.
            2 * first.bytes().filter(|&byte| byte == separator).count() + usize::from(separator == b',')
        });
        let mut reader = csv::ReaderBuilder::new();
        reader.has_headers(false).flexible(true).trim(csv::Trim::All).delimiter(separator.unwrap_or(b','));
        let mut records: Vec<(usize, Vec<String>)> = Vec::new();
        let mut n_breaks = 0;
        for record in reader.from_reader(text.as_bytes()).records() {
            let record = record?;
            // Rows as a spreadsheet counts them: empty ones, too, and one with a line break in a cell once.
            let (start, line) = record.position().map_or((0, 0), |at| (at.byte(), at.line()));
            // The position is that of the empty lines before the record.
            let before = text.as_bytes().get(usize::try_from(start).unwrap_or(usize::MAX)..).unwrap_or_default();
            let n_empty =
                before.iter().take_while(|byte| b"\r\n".contains(byte)).filter(|&&byte| byte == b'\n').count();
            let line = usize::try_from(line).unwrap_or(usize::MAX).saturating_add(n_empty);
            records.push((line.saturating_sub(n_breaks), record.iter().map(str::to_owned).collect()));
            n_breaks += record.iter().map(|cell| cell.matches('\n').count()).sum::<usize>();
        }
        if let Some((number, _)) =
            records.iter().find(|(_, cells)| cells.iter().any(|cell| holds_rows(cell, separator)))
        {
            bail!("row {number}: a cell holds whole rows, expected a second quote (\") where its text ends");
        }
        let headings = records.first().map(|(_, headings)| headings.clone()).unwrap_or_default();
        let places = places(&headings, columns)?;
        let mut rows = Vec::new();
        for (number, cells) in records.into_iter().skip(1) {
            if cells.iter().all(String::is_empty) {
                continue;
            }
            ensure!(
                cells.len() <= headings.len(),
                "row {number} has {} cells, expected {}, one per heading{}",
                cells.len(),
                headings.len(),
                if separator == Some(b',') { "; a comma for a decimal point makes two cells of one" } else { "" }
            );
            rows.push(Row { number, cells });
        }
        Ok(Self { headings, places, rows })
    }

    pub(crate) fn rows(&self) -> &[Row] {
        &self.rows
    }

    /// The text of a known column in a row; empty if the file has no such column.
    pub(crate) fn cell<'a>(&self, row: &'a Row, column: usize) -> &'a str {
        self.places[column].and_then(|place| row.cells.get(place)).map_or("", String::as_str)
    }

    pub(crate) fn fault(&self, row: &Row, column: usize, expected: impl Into<String>) -> Fault {
        let heading = self.places[column].map_or_else(String::new, |place| self.headings[place].clone());
        let value = self.cell(row, column).to_owned();
        Fault { row: row.number, column: heading, value, expected: expected.into() }
    }
}

/// Whether a cell goes on over lines that are rows of their own: a quote that was opened and never closed.
fn holds_rows(cell: &str, separator: Option<u8>) -> bool {
    let separator = char::from(separator.unwrap_or(b','));
    cell.lines().skip(1).any(|line| line.matches(separator).count() >= 3)
}

/// Finds each known column among the headings.
fn places(headings: &[String], columns: &[Column]) -> Result<Vec<Option<usize>>> {
    let known: Vec<String> = columns.iter().map(|column| format!("`{}`", column.heading())).collect();
    let mut places = vec![None; columns.len()];
    for (place, heading) in headings.iter().enumerate() {
        if heading.is_empty() {
            continue;
        }
        let at = format!("heading of column {}", place + 1);
        let name = heading.split(" [").next().unwrap_or_default();
        match columns.iter().position(|column| column.heading() == *heading) {
            Some(column) if places[column].is_some() => bail!("{at}: `{heading}` comes twice"),
            Some(column) => places[column] = Some(place),
            None => match columns.iter().find(|column| column.name == name) {
                Some(column) if heading.contains('[') => {
                    bail!("{at}: `{heading}` has another unit, expected `{}`", column.heading())
                }
                Some(column) => bail!("{at}: `{heading}` has no unit, expected `{}`", column.heading()),
                None => bail!("{at}: `{heading}` is not known, expected one of {}", known.join(", ")),
            },
        }
    }
    if let Some(missing) = (0..columns.len()).find(|&index| columns[index].is_required && places[index].is_none()) {
        bail!("no column `{}`; the headings are {}", columns[missing].heading(), headings.join(", "));
    }
    Ok(places)
}
