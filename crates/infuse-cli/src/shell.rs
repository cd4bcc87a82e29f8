//! Commands and paths as one would type them from here.

use std::path::{Path, PathBuf};

use crate::problem::SheetFormat;

/// Where the sheet of a batch is: as it is there, or else as it is to be written.
pub(crate) fn sheet_path(folder: &Path, format: SheetFormat, batch: usize, given: Option<&Path>) -> PathBuf {
    if let Some(path) = given {
        return path.to_path_buf();
    }
    let of = |ending: &str| {
        let name = format!("sheet-{batch}.{ending}");
        if folder == Path::new(".") { PathBuf::from(name) } else { folder.join(name) }
    };
    let (path, other) = match format {
        SheetFormat::Csv => (of("csv"), of("xlsx")),
        SheetFormat::Xlsx => (of("xlsx"), of("csv")),
    };
    if !path.exists() && other.exists() { other } else { path }
}

/// The program, with the folder of the campaign if that is another.
pub(crate) fn infuse(folder: &Path) -> String {
    if folder == Path::new(".") { "infuse".to_owned() } else { format!("infuse -C {}", quoted(folder)) }
}

/// The command that takes a sheet back.
pub(crate) fn tell_with(folder: &Path, sheet: &Path) -> String {
    format!("{} tell {}", infuse(folder), quoted(sheet))
}

fn quoted(path: &Path) -> String {
    let text = path.display().to_string();
    let is_plain = text.chars().all(|c| c.is_alphanumeric() || "._-/\\:".contains(c));
    if is_plain { text } else { in_quotes(&text) }
}

/// One word of a shell, whatever is in it.
pub(crate) fn in_quotes(word: &str) -> String {
    format!("'{}'", word.replace('\'', "'\\''"))
}
