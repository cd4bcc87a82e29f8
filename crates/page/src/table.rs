//! Tables: columns with units and rows of text, for the page, the terminal and CSV files.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::Error;

/// The head of a column.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Column {
    /// What its values are.
    pub name: String,
    /// "1" for a pure number, empty for words.
    pub unit: String,
}

impl Column {
    /// A column with its unit: "1" for a pure number, empty for words.
    pub fn new(name: &str, unit: &str) -> Self {
        Self { name: name.to_owned(), unit: unit.to_owned() }
    }

    /// A column of words.
    pub fn words(name: &str) -> Self {
        Self::new(name, "")
    }

    /// A column of numbers, also where they have no unit.
    pub fn number(name: &str, unit: &str) -> Self {
        Self::new(name, if unit.is_empty() { "1" } else { unit })
    }

    /// The name with the unit, as a CSV file has it.
    pub fn heading(&self) -> String {
        if self.unit.is_empty() { self.name.clone() } else { format!("{} [{}]", self.name, self.unit) }
    }
}

/// Rows of text under columns.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Table {
    /// From left to right.
    pub columns: Vec<Column>,
    /// From top to bottom. Each as long as `columns`.
    pub rows: Vec<Vec<String>>,
}

impl Table {
    /// A table without rows.
    pub fn new(columns: Vec<Column>) -> Self {
        Self { columns, rows: Vec::new() }
    }

    /// Adds a row below the others.
    ///
    /// # Panics
    /// When the row is not as long as the columns: a mistake in this program.
    pub fn push(&mut self, row: Vec<String>) {
        assert_eq!(row.len(), self.columns.len(), "a row as long as the columns: {row:?}");
        self.rows.push(row);
    }

    /// The table without a column that says the same in every row.
    pub fn without(mut self, name: &str) -> Self {
        if let Some(at) = self.columns.iter().position(|column| column.name == name) {
            self.columns.remove(at);
            self.rows.iter_mut().for_each(|row| {
                row.remove(at);
            });
        }
        self
    }

    /// The table for a terminal.
    pub fn text(&self) -> String {
        let mut table = comfy_table::Table::new();
        table.load_style(comfy_table::presets::NOTHING);
        table.set_header(self.columns.iter().map(|column| match column.unit.as_str() {
            "" | "1" => column.name.clone(),
            unit => format!("{}\n{unit}", column.name),
        }));
        for row in &self.rows {
            table.add_row(row);
        }
        table.to_string()
    }

    /// The table in Markdown.
    pub fn markdown(&self) -> String {
        let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
        let heads = self.columns.iter().map(|column| match column.unit.as_str() {
            "" | "1" => column.name.clone(),
            unit => format!("{} ({unit})", column.name),
        });
        let rules = self.columns.iter().map(|column| if column.unit.is_empty() { "---" } else { "---:" }.to_owned());
        let rows: String = self.rows.iter().map(|row| line(row.clone())).collect();
        line(heads.collect()) + &line(rules.collect()) + &rows
    }

    /// Writes the table as CSV, the units in the header.
    ///
    /// # Errors
    /// [`Error::Write`] when the file cannot be written.
    pub fn write_csv(&self, path: &Path) -> Result<(), Error> {
        write(path, &self.columns, self.rows.iter().cloned())
    }
}

/// Writes numbers as CSV, column by column, the units in the header; every digit that tells one number from the next.
///
/// # Errors
/// When the columns are not equally long, or the file cannot be written.
pub fn write_columns_csv(path: &Path, columns: &[(Column, &[f64])]) -> Result<(), Error> {
    let length = columns.first().map_or(0, |(_, values)| values.len());
    for (column, values) in columns {
        if values.len() != length {
            return Err(Error::ColumnLength { column: column.name.clone(), found: values.len(), expected: length });
        }
    }
    let heads: Vec<Column> = columns.iter().map(|(column, _)| column.clone()).collect();
    let rows = (0..length).map(|row| columns.iter().map(|(_, values)| values[row].to_string()).collect());
    write(path, &heads, rows)
}

fn write(path: &Path, columns: &[Column], rows: impl Iterator<Item = Vec<String>>) -> Result<(), Error> {
    let fault = |cause: csv::Error| Error::Write { path: path.to_path_buf(), cause: cause.into() };
    if let Some(directory) = path.parent() {
        std::fs::create_dir_all(directory).map_err(|cause| Error::Write { path: path.to_path_buf(), cause })?;
    }
    let mut writer = csv::Writer::from_path(path).map_err(fault)?;
    writer.write_record(columns.iter().map(Column::heading)).map_err(fault)?;
    for row in rows {
        writer.write_record(row).map_err(fault)?;
    }
    writer.flush().map_err(|cause| Error::Write { path: path.to_path_buf(), cause })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn temporary(name: &str) -> std::path::PathBuf {
        std::env::temp_dir().join(format!("xtask-{}-{name}.csv", std::process::id()))
    }

    #[test]
    fn csv_has_units_in_its_header_and_quotes_what_needs_it() {
        let mut table = Table::new(vec![Column::new("time", "s"), Column::new("note", "")]);
        table.push(vec!["0.5".into(), "left, then right".into()]);
        let path = temporary("table");
        table.write_csv(&path).expect("a writable directory");
        let text = std::fs::read_to_string(&path).expect("just written");
        std::fs::remove_file(&path).expect("just written");
        assert_eq!(text, "time [s],note\n0.5,\"left, then right\"\n");
    }

    #[test]
    fn csv_numbers_come_back_bit_for_bit() {
        let values = [0.1 + 0.2, 1e-300, -0.0, 12_345_678.9];
        let path = temporary("columns");
        write_columns_csv(&path, &[(Column::new("value", "m"), &values)]).expect("a writable directory");
        let text = std::fs::read_to_string(&path).expect("just written");
        std::fs::remove_file(&path).expect("just written");
        let read: Vec<u64> =
            text.lines().skip(1).map(|line| line.parse::<f64>().expect("a number").to_bits()).collect();
        assert_eq!(read, values.map(f64::to_bits));
    }

    #[test]
    fn columns_of_different_lengths_are_refused() {
        let error = write_columns_csv(
            &temporary("refused"),
            &[(Column::new("a", "m"), &[1.0, 2.0]), (Column::new("b", "m"), &[1.0])],
        )
        .expect_err("different lengths");
        assert_eq!(error.to_string(), "column `b`: 1 values, not 2");
    }

    #[test]
    fn terminal_text_has_units_under_the_names() {
        let mut table = Table::new(vec![Column::new("iteration", "1"), Column::new("cost", "s")]);
        table.push(vec!["1".into(), "4.35".into()]);
        let text = table.text();
        assert!(text.contains("iteration") && text.contains("4.35"), "{text}");
    }
}
