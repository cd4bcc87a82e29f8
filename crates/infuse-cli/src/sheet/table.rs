//! Tables that people fill in: read whole, with every fault by row, column and value.

use std::fmt;
use std::fs::File;
use std::io::Read as _;
use std::path::Path;

use anyhow::{Context as _, Result, bail, ensure};
use design_space::Parameter;

use super::cells::{Cell, Records, Separator};
use super::decimal::Commas;
use super::{text, workbook};
use crate::echo::{echo, echo_all};
use crate::number::NoNumber;
use crate::problem::parse_setting;
use crate::wording::place_in_any_case;

/// Columns that hold whatever people write.
const TEXTS: [&str; 3] = ["failed", "note", "source"];

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
        let value = if value.is_empty() { "is empty".to_owned() } else { format!("is `{}`", echo(value)) };
        let column = echo(column);
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
    /// Of each known column.
    units: Vec<String>,
    /// Where each known column stands in the file.
    places: Vec<Option<usize>>,
    rows: Vec<Row>,
    commas: Commas,
}

/// A table of experiments is no longer; what has no end would take all memory.
const MOST_BYTES: u64 = 100_000_000;

fn bytes_of(path: &Path) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    File::open(path)?.take(MOST_BYTES + 1).read_to_end(&mut bytes)?;
    ensure!(
        bytes.len() as u64 <= MOST_BYTES,
        "it holds more than {} MB, expected a table of experiments",
        MOST_BYTES / 1_000_000
    );
    Ok(bytes)
}

/// A row that is not empty.
#[derive(Debug)]
pub(crate) struct Row {
    pub(crate) number: usize,
    cells: Vec<Cell>,
}

impl Table {
    /// Reads a file whose columns are among these, in any order: a text with commas, semicolons or tabs, or a workbook.
    pub(crate) fn read(path: &Path, columns: &[Column]) -> Result<Self> {
        let bytes = bytes_of(path).with_context(|| path.display().to_string())?;
        Self::parse(&bytes, columns).with_context(|| path.display().to_string())
    }

    pub(crate) fn parse(bytes: &[u8], columns: &[Column]) -> Result<Self> {
        let Records { rows: records, separator } = match workbook::records(bytes)? {
            Some(records) => records,
            None => text::records(bytes)?,
        };
        Self::of(records, separator, columns)
    }

    /// From one row of cells under all of these columns, as a form has them: a comma may be the decimal point.
    pub(super) fn of_row(columns: &[Column], cells: &[String]) -> Result<Self> {
        let headings = columns.iter().map(|column| Cell::plain(column.heading())).collect();
        let cells = cells.iter().map(Cell::plain).collect();
        Self::of(vec![(1, headings), (2, cells)], Separator::Form, columns)
    }

    fn of(records: Vec<(usize, Vec<Cell>)>, separator: Separator, columns: &[Column]) -> Result<Self> {
        let mut records = records.into_iter().filter(|(_, cells)| cells.iter().any(|cell| !cell.text.is_empty()));
        let headings = records.next().map(|(_, headings)| headings).unwrap_or_default();
        let headings: Vec<String> = headings.into_iter().map(|cell| cell.text).collect();
        let places = places(&headings, columns)?;
        let mut rows = Vec::new();
        for (number, mut cells) in records {
            cells.iter_mut().for_each(Cell::on_one_line);
            // A workbook has no cells too many, but empty ones.
            let n = cells.iter().rposition(|cell| !cell.text.is_empty()).map_or(0, |last| last + 1);
            let n = if separator == Separator::Workbook { n } else { cells.len() };
            ensure!(
                n <= headings.len(),
                "row {number} has {n} cells, expected {}, one per heading{}",
                headings.len(),
                if separator == Separator::Comma { "; a comma for a decimal point makes two cells of one" } else { "" }
            );
            rows.push(Row { number, cells });
        }
        let numbers = columns.iter().zip(&places).filter(|(column, _)| !TEXTS.contains(&&*column.name));
        let numbers: Vec<usize> = numbers.filter_map(|(_, place)| *place).collect();
        let cells = rows.iter().flat_map(|row| {
            let cells = numbers.iter().filter_map(|&place| row.cells.get(place));
            cells.map(|cell| (row.number, &*cell.text))
        });
        let commas = Commas::of(separator, cells);
        let table =
            Self { units: columns.iter().map(|column| column.unit.clone()).collect(), headings, places, rows, commas };
        none_of("the table", &table.broken_cells(columns))?;
        Ok(table)
    }

    /// Cells that are to be a text and cannot be one.
    fn broken_cells(&self, columns: &[Column]) -> Vec<Fault> {
        let texts = (0..columns.len()).filter(|&column| TEXTS.contains(&&*columns[column].name));
        let cells = self.rows.iter().flat_map(|row| texts.clone().map(move |column| (row, column)));
        let fault = |(row, column): (&Row, usize)| Some(self.fault(row, column, self.at(row, column)?.is_no_text()?));
        cells.filter_map(fault).collect()
    }

    fn at<'a>(&self, row: &'a Row, column: usize) -> Option<&'a Cell> {
        row.cells.get(self.places[column]?)
    }

    /// The number in a known column of a row, or what was expected instead.
    pub(crate) fn number(&self, row: &Row, column: usize) -> Result<f64, NoNumber> {
        match self.at(row, column).and_then(Cell::is_no_number) {
            Some(expected) => Err(expected.into()),
            None => self.commas.number(self.cell(row, column), &self.units[column]),
        }
    }

    /// The setting in a known column of a row: a number, or the name of a choice.
    pub(crate) fn setting(&self, row: &Row, column: usize, parameter: &Parameter) -> Result<f64, String> {
        match parameter.choices() {
            Some(_) => parse_setting(parameter, self.cell(row, column)),
            None => self.number(row, column).map_err(|fault| fault.to_string()),
        }
    }

    pub(crate) fn rows(&self) -> &[Row] {
        &self.rows
    }

    /// Whether the file has a known column.
    pub(crate) fn has(&self, column: usize) -> bool {
        self.places[column].is_some()
    }

    /// The text of a known column in a row; empty if the file has no such column.
    pub(crate) fn cell<'a>(&self, row: &'a Row, column: usize) -> &'a str {
        self.at(row, column).map_or("", |cell| &*cell.text)
    }

    pub(crate) fn fault(&self, row: &Row, column: usize, expected: impl fmt::Display) -> Fault {
        let heading = self.places[column].map_or_else(String::new, |place| self.headings[place].clone());
        let value = self.cell(row, column).to_owned();
        Fault { row: row.number, column: heading, value, expected: expected.to_string() }
    }
}

/// Finds each known column among the headings.
fn places(headings: &[String], columns: &[Column]) -> Result<Vec<Option<usize>>> {
    let mut places = vec![None; columns.len()];
    for (place, heading) in headings.iter().enumerate().filter(|(_, heading)| !heading.is_empty()) {
        let at = || format!("heading of column {}", place + 1);
        let column = find(heading, columns).with_context(at)?;
        ensure!(places[column].is_none(), "{}: `{}` comes twice", at(), echo(heading));
        places[column] = Some(place);
    }
    if let Some(missing) = (0..columns.len()).find(|&index| columns[index].is_required && places[index].is_none()) {
        let headings = echo_all(headings.iter().map(String::as_str));
        bail!("no column `{}`; the headings are {headings}", columns[missing].heading());
    }
    Ok(places)
}

/// The column with this heading: its name in any case, and its unit as it is.
fn find(heading: &str, columns: &[Column]) -> Result<usize> {
    let (name, unit) = match heading.strip_suffix(']').and_then(|heading| heading.rsplit_once('[')) {
        Some((name, unit)) => (name.trim(), Some(unit.trim())),
        None => (heading.trim(), None),
    };
    match place_in_any_case(columns.iter().map(|column| &*column.name), name) {
        Some(column) if unit.unwrap_or_default() == columns[column].unit => Ok(column),
        Some(column) if unit.is_some() => {
            bail!("`{}` has another unit, expected `{}`", echo(heading), columns[column].heading())
        }
        Some(column) => bail!("`{}` has no unit, expected `{}`", echo(heading), columns[column].heading()),
        None => {
            let known: Vec<String> = columns.iter().map(|column| format!("`{}`", column.heading())).collect();
            bail!(
                "`{}` is not known, expected one of {}; a column that is of no use any more may be removed",
                echo(heading),
                known.join(", ")
            )
        }
    }
}
