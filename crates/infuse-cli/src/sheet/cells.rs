//! The cells of a file, wherever they come from.

/// A cell as it stands in a file.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Cell {
    pub(super) text: String,
    pub(super) kind: Kind,
}

/// What a spreadsheet takes a cell for.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) enum Kind {
    /// A text or a number.
    #[default]
    Plain,
    Boolean,
    Date,
    /// Like `#DIV/0!`.
    Error,
    /// A formula that was never computed.
    Formula,
}

impl Cell {
    pub(super) fn plain(text: impl Into<String>) -> Self {
        Self { text: text.into(), kind: Kind::Plain }
    }

    /// Without characters that would begin a line or steer a terminal.
    pub(super) fn on_one_line(&mut self) {
        if self.text.contains(char::is_control) {
            self.text = self.text.replace(char::is_control, " ");
        }
    }

    /// What is expected instead, if this can't be a number whatever it says.
    pub(super) fn is_no_number(&self) -> Option<&'static str> {
        match self.kind {
            Kind::Plain => None,
            Kind::Boolean => Some("a number; the cell holds true or false"),
            Kind::Date => Some("a number; the cell holds a date or a time, as spreadsheets make of some numbers"),
            Kind::Error | Kind::Formula => self.is_no_text(),
        }
    }

    /// What is expected instead, if this can't even be a text.
    pub(super) fn is_no_text(&self) -> Option<&'static str> {
        match self.kind {
            Kind::Plain | Kind::Boolean | Kind::Date => None,
            Kind::Error => Some("a value; the cell holds the error of a formula"),
            Kind::Formula => Some(
                "a value; the cell holds a formula without its value: open the workbook in a spreadsheet and save it",
            ),
        }
    }
}

/// The rows of a file.
#[derive(Debug)]
pub(super) struct Records {
    /// With their numbers as a spreadsheet counts them, from 1.
    pub(super) rows: Vec<(usize, Vec<Cell>)>,
    pub(super) separator: Separator,
}

/// What stands between the cells of a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Separator {
    Comma,
    /// A semicolon or a tab: a comma within a cell may stand for the decimal point.
    Other,
    /// Fields of a form: the same, where it can be nothing else.
    Form,
    /// Cells are cells.
    Workbook,
}
