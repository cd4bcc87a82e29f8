//! Commands and paths as one would type them from here.

use std::path::{Path, PathBuf, absolute};

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

/// A path as the journal keeps it: from the folder of the campaign on, if it is in there. None for one that is no text.
pub(crate) fn kept_name(folder: &Path, path: &Path) -> Option<String> {
    let of = |path: &Path| absolute(path).unwrap_or_else(|_| path.to_path_buf());
    let (folder, path) = (of(folder), of(path));
    path.strip_prefix(&folder).unwrap_or(&path).to_str().map(str::to_owned)
}

/// The path that the journal keeps so, as one would type it from here.
pub(crate) fn typed_name(folder: &Path, kept: &str) -> PathBuf {
    if folder == Path::new(".") { PathBuf::from(kept) } else { folder.join(kept) }
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

/// A name as one word of a shell: in double quotes, which every shell knows, unless something in it means more than itself there.
pub(crate) fn as_one_word(name: &str) -> String {
    if name.contains(['"', '$', '`', '\\', '!', '\n']) { in_quotes(name) } else { format!("\"{name}\"") }
}

/// One word of a shell, whatever is in it.
pub(crate) fn in_quotes(word: &str) -> String {
    format!("'{}'", word.replace('\'', "'\\''"))
}
