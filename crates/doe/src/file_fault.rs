//! What can be wrong with a file of a design.

use std::fmt;

use crate::wording::counted;

/// What is wrong with a file of a design. Lines are counted from 1, the header and comments included.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
pub enum FileFault {
    /// The file cannot be read.
    Unreadable {
        /// Why.
        reason: String,
    },
    /// A parameter of the region has no column.
    MissingColumn {
        /// The parameter.
        name: String,
        /// The header that was found.
        header: Vec<String>,
    },
    /// A parameter of the region has two columns.
    DuplicateColumn {
        /// The parameter.
        name: String,
    },
    /// A column states another unit than the parameter has.
    WrongUnit {
        /// The parameter.
        name: String,
        /// The unit in the header.
        found: String,
        /// The unit of the parameter.
        expected: String,
    },
    /// An empty field.
    Missing {
        /// Line of the file.
        line: u64,
        /// The parameter.
        name: String,
    },
    /// A field that is not a finite number.
    NotANumber {
        /// Line of the file.
        line: u64,
        /// The parameter.
        name: String,
        /// What the field holds.
        text: String,
    },
    /// A number outside the bounds of its parameter.
    OutOfBounds {
        /// Line of the file.
        line: u64,
        /// The parameter.
        name: String,
        /// The number, in the unit of the parameter.
        value: f64,
        /// Lower bound.
        lower: f64,
        /// Upper bound.
        upper: f64,
        /// Unit of the bounds.
        unit: String,
    },
    /// A number within the bounds of a choice that is the place of none.
    NotAChoice {
        /// Line of the file.
        line: u64,
        /// The parameter.
        name: String,
        /// The number.
        value: f64,
        /// The places there are, with the names of their choices.
        expected: String,
    },
    /// Nothing in the file but empty lines and comments.
    Empty,
    /// Columns separated by something else than commas.
    Separator {
        /// What separates them.
        found: char,
    },
    /// A line with another number of fields than the header.
    FieldCount {
        /// Line of the file.
        line: u64,
        /// Number of its fields.
        found: usize,
        /// Number of columns of the header.
        expected: usize,
    },
    /// No line after the header.
    NoRuns,
    /// The name of a parameter cannot be told from another in the header of a file.
    AmbiguousName {
        /// The name.
        name: String,
    },
    /// A parameter bears the name of a column that is written beside the settings.
    ReservedName {
        /// The name.
        name: &'static str,
    },
}

impl fmt::Display for FileFault {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unreadable { reason } => write!(formatter, "the file cannot be read: {reason}"),
            Self::MissingColumn { name, header } => {
                write!(formatter, "no column `{name}`, the columns are: {}", header.join(", "))
            }
            Self::DuplicateColumn { name } => write!(formatter, "two columns `{name}`, expected one"),
            Self::WrongUnit { name, found, expected } => {
                write!(formatter, "column `{name}` is in {found}, expected {expected}")
            }
            Self::Missing { line, name } => {
                write!(formatter, "line {line}, column `{name}`: nothing, expected a number")
            }
            Self::NotANumber { line, name, text } => {
                write!(formatter, "line {line}, column `{name}`: \"{text}\", expected a finite number")?;
                let is_decimal_comma = text.matches(',').count() == 1 && text.replace(',', ".").parse::<f64>().is_ok();
                if is_decimal_comma { write!(formatter, " with a decimal point, not a comma") } else { Ok(()) }
            }
            Self::OutOfBounds { line, name, value, lower, upper, unit } => {
                write!(formatter, "line {line}, column `{name}`: {value:?}, expected {lower:?} to {upper:?}")?;
                if unit.is_empty() { Ok(()) } else { write!(formatter, " {unit}") }
            }
            Self::NotAChoice { line, name, value, expected } => {
                write!(formatter, "line {line}, column `{name}`: {value:?}, expected the place of a choice: {expected}")
            }
            Self::Empty => write!(formatter, "the file is empty, expected a header with the names of the parameters"),
            Self::Separator { found } => {
                let name = match found {
                    ';' => "semicolons",
                    '\t' => "tabs",
                    _ => "other characters",
                };
                write!(formatter, "the columns are separated by {name}, expected commas, and decimal points in numbers")
            }
            Self::FieldCount { line, found, expected } => {
                let fields = counted(*found as u64, "field", "fields");
                write!(formatter, "line {line}: {fields}, expected {expected} as in the header")?;
                if found > expected { write!(formatter, " (numbers with decimal commas?)") } else { Ok(()) }
            }
            Self::NoRuns => write!(formatter, "no runs after the header, expected at least one"),
            Self::AmbiguousName { name } => write!(
                formatter,
                "the name `{name}` cannot be told from another in the header of a file: expected names that differ in more \
                 than spaces around them and units in brackets"
            ),
            Self::ReservedName { name } => {
                write!(formatter, "a parameter is called `{name}`, which is the name of a column beside the settings")
            }
        }
    }
}
