//! What stands in a folder beside the file that is changed.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context as _, Result, ensure};

use crate::workspace::{root, run_quietly};

/// What a campaign has learnt, line by line.
pub(super) const JOURNAL: &str = "journal.jsonl";
/// What was measured before the campaign that `infuse new` makes.
const EARLIER: &str = "spring [N/mm],damper gain [N s/mm],vibration [mm/s],note\n20,1.1,5.5,\n22.0,0.9,6.25,at noon\n";

/// Rig, test and cost of the turbine.
pub(super) fn turbine(folder: &Path) -> Result<()> {
    fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    for file in ["rig.toml", "test-profile.toml", "cost-chapter7.toml"] {
        fs::copy(root()?.join("fixtures/bat").join(file), folder.join(file)).context(file)?;
    }
    Ok(())
}

/// A campaign that has asked for its first batch.
pub(super) fn asked(folder: &Path, program: &Path) -> Result<()> {
    run_quietly(Command::new(program).arg("new").arg(folder))?;
    infuse(folder, program, &["ask"])?;
    fs::write(folder.join("earlier.csv"), EARLIER).context("earlier.csv")
}

/// A campaign that was told its first batch, one run of it without a result, and earlier experiments, and that waits for the
/// second.
pub(super) fn told(folder: &Path, program: &Path, method: &str) -> Result<()> {
    run_quietly(Command::new(program).arg("new").arg(folder))?;
    edit(&folder.join("campaign.toml"), |text| {
        text.replacen("\n[loop]\n", &format!("\n[loop]\nmethod = {method:?}\n"), 1)
    })?;
    infuse(folder, program, &["ask"])?;
    edit(&folder.join("sheet-1.csv"), filled)?;
    infuse(folder, program, &["tell", "sheet-1.csv"])?;
    fs::write(folder.join("earlier.csv"), EARLIER).context("earlier.csv")?;
    infuse(folder, program, &["import", "--source", "a notebook", "earlier.csv"])?;
    infuse(folder, program, &["ask"])?;
    edit(&folder.join(JOURNAL), without_checksums)
}

fn infuse(folder: &Path, program: &Path, arguments: &[&str]) -> Result<()> {
    run_quietly(Command::new(program).args(arguments).current_dir(folder))
}

/// Changes a file, which must change.
fn edit(file: &Path, change: impl FnOnce(&str) -> String) -> Result<()> {
    let text = fs::read_to_string(file).with_context(|| file.display().to_string())?;
    let changed = change(&text);
    ensure!(changed != text, "{}: nothing to change, in\n{text}", file.display());
    fs::write(file, changed).with_context(|| file.display().to_string())
}

/// The sheet with a result in every run but the second, of which a line broke.
fn filled(sheet: &str) -> String {
    let mut rows: Vec<String> = Vec::new();
    let mut runs = 0_u32;
    for line in sheet.lines() {
        let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        // Rows begin with the number of their run; five columns later is what was measured, then why nothing was.
        if let (Some(Ok(_)), [_, _, _, _, _, measured, failed, ..]) =
            (line.split(',').next().map(str::parse::<u32>), &mut *cells)
        {
            runs += 1;
            if runs == 2 {
                *failed = "a line broke".to_owned();
            } else {
                *measured = (5.0 + 0.25 * f64::from(runs)).to_string();
            }
        }
        rows.push(cells.join(",") + "\n");
    }
    rows.concat()
}

fn without_checksums(journal: &str) -> String {
    let bare =
        |line: &str| line.split_once(",\"check\":").map_or_else(|| line.to_owned(), |(line, _)| format!("{line}}}"));
    journal.lines().map(|line| bare(line) + "\n").collect()
}

/// In the order of their names.
pub(super) fn files_in(folder: &Path) -> Result<Vec<PathBuf>> {
    let entries = fs::read_dir(folder).with_context(|| folder.display().to_string())?;
    let mut files = Vec::new();
    for entry in entries {
        let path = entry.with_context(|| folder.display().to_string())?.path();
        if path.is_file() {
            files.push(path);
        }
    }
    files.sort();
    Ok(files)
}
