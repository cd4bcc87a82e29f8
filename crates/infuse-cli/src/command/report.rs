//! `infuse report`: all of a campaign on one page.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use anyhow::{Result, ensure};
use page::Finding;
use serde_json::json;

use super::output::Output;
use crate::disk;
use crate::folder;
use crate::journal::Journal;

pub(crate) fn report(folder: &Path, output: Option<&Path>) -> Result<Output> {
    let path = match output {
        Some(path) => path.to_path_buf(),
        None if folder == Path::new(".") => PathBuf::from("report.html"),
        None => folder.join("report.html"),
    };
    // Anything else may be a sheet, or the journal.
    ensure!(
        path.extension().and_then(OsStr::to_str).is_some_and(|extension| ["html", "htm"].contains(&extension)),
        "--output is {}, expected a file that ends in .html",
        path.display()
    );
    let mut campaign = folder::read(folder)?;
    let page = campaign.page(&Journal::read(folder)?)?;
    disk::replace(&path, page.as_bytes())?;
    let written = Finding::new(format!("Written to {}: open it in a browser, or send it.", path.display()));
    let notices = campaign.take_notices();
    let json = json!({ "report": path, "bytes": page.len(), "batches": campaign.n_closed() });
    Ok(Output::new(&[written], json, notices))
}
