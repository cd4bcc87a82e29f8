//! Numbers in files: a value with its unit and where it comes from, every key accounted for.

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::path::Path;

use serde::{Deserialize, Serialize};
use toml::{Table, Value};

use crate::error::FileError;

/// Where a number comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Provenance {
    /// Printed in the source; the note names the place.
    Given,
    /// Computed from given numbers; the note is the formula.
    Derived,
    /// From geometry, handbooks or habit; the note says how.
    Estimated,
    /// Fitted; the note says to what. It never counts as a reproduction of that.
    Calibrated,
}

/// A number as it stands in a file, with its key.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Record {
    /// The key with its sections, `plant.body.mass` for example.
    pub key: String,
    /// The value as written.
    pub value: f64,
    /// The unit as written.
    pub unit: String,
    /// Where it comes from.
    pub provenance: Provenance,
    /// The place, the formula, the reason or what it was fitted to.
    pub source: String,
}

/// A range for a number read from a file.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Range {
    Finite,
    NonNegative,
    Positive,
    UnitInterval,
    /// An angle in rad short of a quarter turn.
    WithinQuarterTurn,
    /// An angle in rad short of a half turn.
    WithinHalfTurn,
}

impl Range {
    fn admits(self, value: f64) -> bool {
        value.is_finite()
            && match self {
                Self::Finite => true,
                Self::NonNegative => value >= 0.0,
                Self::Positive => value > 0.0,
                Self::UnitInterval => value.abs() <= 1.0,
                Self::WithinQuarterTurn => value.abs() < core::f64::consts::FRAC_PI_2,
                Self::WithinHalfTurn => value.abs() < core::f64::consts::PI,
            }
    }

    fn words(self) -> &'static str {
        match self {
            Self::Finite => "finite",
            Self::NonNegative => "finite and zero or more",
            Self::Positive => "finite and more than zero",
            Self::UnitInterval => "within -1 and 1",
            Self::WithinQuarterTurn => "finite and short of a quarter turn to either side",
            Self::WithinHalfTurn => "finite and short of a half turn to either side",
        }
    }
}

/// Units that may stand in a file in place of the SI unit, with their factors.
const UNITS: &[(&str, &str, f64)] = &[
    ("% chord", "chord", 0.01),
    ("deg", "rad", core::f64::consts::PI / 180.0),
    ("mm", "m", 1e-3),
    ("cm", "m", 1e-2),
    ("cm/s", "m/s", 1e-2),
    ("mm/s", "m/s", 1e-3),
    ("cm^2", "m^2", 1e-4),
    ("cm^3", "m^3", 1e-6),
    ("g", "kg", 1e-3),
    ("g/m", "kg/m", 1e-3),
    ("ms", "s", 1e-3),
    ("min", "s", 60.0),
    ("%", "1", 0.01),
    ("1/deg", "1/rad", 180.0 / core::f64::consts::PI),
];

fn factor(found: &str, expected: &str) -> Option<f64> {
    if found == expected {
        return Some(1.0);
    }
    UNITS.iter().find(|(unit, si, _)| *unit == found && *si == expected).map(|(_, _, factor)| *factor)
}

fn understood(expected: &str) -> String {
    let mut units = vec![format!("`{expected}`")];
    units.extend(UNITS.iter().filter(|(_, si, _)| *si == expected).map(|(unit, _, _)| format!("`{unit}`")));
    units.join(" or ")
}

/// Everything that was read from one file, key by key.
#[derive(Debug, Default)]
pub(crate) struct Reader {
    records: RefCell<Vec<Record>>,
}

impl Reader {
    /// Parses `text` and lets `read` take what it needs from the top table.
    pub(crate) fn parse<T>(
        text: &str,
        read: impl FnOnce(&Section<'_>) -> Result<T, FileError>,
    ) -> Result<(T, Vec<Record>), FileError> {
        let table: Table = text.parse()?;
        let reader = Self::default();
        let section = Section { path: String::new(), table: &table, known: RefCell::default(), reader: &reader };
        let value = read(&section)?;
        section.finish()?;
        Ok((value, reader.records.into_inner()))
    }
}

/// Reads a file and names it in every error.
pub(crate) fn read_file<T>(path: &Path, parse: impl FnOnce(&str) -> Result<T, FileError>) -> Result<T, FileError> {
    let text = std::fs::read_to_string(path).map_err(|cause| FileError::Read { path: path.to_path_buf(), cause })?;
    parse(&text).map_err(|error| FileError::In { path: path.to_path_buf(), error: Box::new(error) })
}

/// Edits up to which a key counts as a slip of another.
const LARGEST_SLIP: usize = 2;

/// A table of a file that remembers which of its keys were asked for.
pub(crate) struct Section<'a> {
    path: String,
    table: &'a Table,
    known: RefCell<BTreeSet<String>>,
    reader: &'a Reader,
}

impl<'a> Section<'a> {
    pub(crate) fn key(&self, name: &str) -> String {
        if self.path.is_empty() { name.to_owned() } else { format!("{}.{name}", self.path) }
    }

    /// The error that says that the number `name`, `value` in SI, is not `allowed` beside the others.
    pub(crate) fn refuse(&self, name: &str, value: f64, unit: &str, allowed: &str) -> FileError {
        FileError::Range { key: self.key(name), value, unit: unit.to_owned(), allowed: allowed.to_owned() }
    }

    /// The error that says that `name` is missing.
    pub(crate) fn missing(&self, name: &str, expected: &str) -> FileError {
        let known = self.known.borrow();
        let slips = self.table.keys().filter(|key| !known.contains(*key));
        let similar = slips
            .map(|key| (strsim::damerau_levenshtein(key, name), key))
            .filter(|(edits, _)| *edits <= LARGEST_SLIP)
            .min()
            .map(|(_, key)| self.key(key));
        FileError::MissingKey { key: self.key(name), expected: expected.to_owned(), similar }
    }

    fn get(&self, name: &str) -> Option<&'a Value> {
        self.known.borrow_mut().insert(name.to_owned());
        self.table.get(name)
    }

    fn needed(&self, name: &str, expected: &str) -> Result<&'a Value, FileError> {
        self.get(name).ok_or_else(|| self.missing(name, expected))
    }

    fn of(&self, path: String, value: &'a Value) -> Result<Section<'a>, FileError> {
        let table = value.as_table().ok_or_else(|| FileError::Kind {
            key: path.clone(),
            found: value.type_str().to_owned(),
            expected: "a table".to_owned(),
        })?;
        Ok(Section { path, table, known: RefCell::default(), reader: self.reader })
    }

    /// Every key that was not asked for is an error.
    pub(crate) fn finish(&self) -> Result<(), FileError> {
        let known = self.known.borrow();
        match self.table.keys().find(|key| !known.contains(*key)) {
            None => Ok(()),
            Some(key) => Err(FileError::UnknownKey {
                key: self.key(key),
                known: known.iter().map(String::as_str).collect::<Vec<_>>().join(", "),
            }),
        }
    }

    /// The sub-table `name`, read by `read` and then checked for keys that nobody asked for.
    pub(crate) fn section<T>(
        &self,
        name: &str,
        read: impl FnOnce(&Section<'a>) -> Result<T, FileError>,
    ) -> Result<T, FileError> {
        let section = self.of(self.key(name), self.needed(name, "a table")?)?;
        let value = read(&section)?;
        section.finish()?;
        Ok(value)
    }

    /// Like [`Section::section`], `None` when absent.
    pub(crate) fn optional_section<T>(
        &self,
        name: &str,
        read: impl FnOnce(&Section<'a>) -> Result<T, FileError>,
    ) -> Result<Option<T>, FileError> {
        self.get(name).map(|_| self.section(name, read)).transpose()
    }

    /// The array of tables `name`, empty when absent.
    pub(crate) fn list<T>(
        &self,
        name: &str,
        mut read: impl FnMut(&Section<'a>) -> Result<T, FileError>,
    ) -> Result<Vec<T>, FileError> {
        let Some(value) = self.get(name) else { return Ok(Vec::new()) };
        let items = value.as_array().ok_or_else(|| FileError::Kind {
            key: self.key(name),
            found: value.type_str().to_owned(),
            expected: "an array of tables".to_owned(),
        })?;
        let mut out = Vec::with_capacity(items.len());
        for (index, item) in items.iter().enumerate() {
            let section = self.of(format!("{}[{index}]", self.key(name)), item)?;
            out.push(read(&section)?);
            section.finish()?;
        }
        Ok(out)
    }

    /// A text value that is one of serde's names of `T`, or `fallback` when absent.
    pub(crate) fn choice<T: for<'de> Deserialize<'de>>(
        &self,
        name: &str,
        allowed: &str,
        fallback: Option<T>,
    ) -> Result<T, FileError> {
        let value = match (self.get(name), fallback) {
            (Some(value), _) => value,
            (None, Some(fallback)) => return Ok(fallback),
            (None, None) => return Err(self.missing(name, allowed)),
        };
        value.clone().try_into().map_err(|_| FileError::Kind {
            key: self.key(name),
            found: value.to_string(),
            expected: allowed.to_owned(),
        })
    }

    /// A text.
    pub(crate) fn text(&self, name: &str) -> Result<String, FileError> {
        let value = self.needed(name, "a text")?;
        value.as_str().map(str::to_owned).ok_or_else(|| FileError::Kind {
            key: self.key(name),
            found: value.type_str().to_owned(),
            expected: "a text".to_owned(),
        })
    }

    /// A number in `unit` (SI), with its unit and provenance in the file.
    pub(crate) fn quantity(&self, name: &str, unit: &str, range: Range) -> Result<f64, FileError> {
        const FORM: &str = "a table { value, unit, provenance, source }";
        let section = self.of(self.key(name), self.needed(name, FORM)?).map_err(|error| match error {
            FileError::Kind { key, found, .. } => FileError::Kind { key, found, expected: FORM.to_owned() },
            other => other,
        })?;
        let value = section.needed("value", "a number")?;
        let written =
            value.as_float().or_else(|| value.as_integer().map(|n| n as f64)).ok_or_else(|| FileError::Kind {
                key: section.key("value"),
                found: value.type_str().to_owned(),
                expected: "a number".to_owned(),
            })?;
        let found = section.text("unit")?;
        let factor = factor(&found, unit).ok_or_else(|| FileError::Unit {
            key: section.path.clone(),
            found: found.clone(),
            expected: understood(unit),
        })?;
        let provenance = section.choice("provenance", "given, derived, estimated or calibrated", None)?;
        let source = section.text("source")?;
        section.finish()?;
        let si = if found == "% chord" || found == "%" { written / 100.0 } else { written * factor };
        if !range.admits(si) {
            return Err(FileError::Range {
                key: section.path.clone(),
                value: written,
                unit: found,
                allowed: range.words().to_owned(),
            });
        }
        self.reader.records.borrow_mut().push(Record {
            key: section.path,
            value: written,
            unit: found,
            provenance,
            source,
        });
        Ok(si)
    }

    /// Like [`Section::quantity`], `fallback` when absent.
    pub(crate) fn quantity_or(&self, name: &str, unit: &str, range: Range, fallback: f64) -> Result<f64, FileError> {
        match self.get(name) {
            None => Ok(fallback),
            Some(_) => self.quantity(name, unit, range),
        }
    }
}
