//! A folder, a command, and a rig whose truth is known.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;
use tempfile::TempDir;

/// What a call of the command gave.
#[derive(Debug)]
pub(crate) struct Said {
    pub(crate) is_success: bool,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

impl Said {
    /// On standard output, of a call that succeeded.
    #[track_caller]
    pub(crate) fn ok(self) -> String {
        assert!(self.is_success, "{}{}", self.stdout, self.stderr);
        self.stdout
    }

    /// On standard error, of a call that failed.
    #[track_caller]
    pub(crate) fn error(self) -> String {
        assert!(!self.is_success, "no error: {}", self.stdout);
        assert!(!self.stderr.contains("panicked"), "{}", self.stderr);
        self.stderr
    }
}

impl From<Output> for Said {
    fn from(output: Output) -> Self {
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        Self { is_success: output.status.success(), stdout: text(&output.stdout), stderr: text(&output.stderr) }
    }
}

/// A folder with a campaign in it.
#[derive(Debug)]
pub(crate) struct Rig {
    folder: TempDir,
}

impl Rig {
    /// The campaign of `infuse new`, by the pooled loop.
    pub(crate) fn pooled() -> Self {
        let rig = Self::empty();
        rig.infuse(&["new", "."]).ok();
        rig
    }

    /// The same by the dissertation's loop.
    pub(crate) fn new() -> Self {
        let rig = Self::pooled();
        let text = rig.read("campaign.toml");
        let (before, after) = text.split_once("[loop]\n").unwrap();
        let (_, stop) = after.split_once("[stop]").unwrap();
        rig.write("campaign.toml", &format!("{before}{DISSERTATION}\n[stop]{stop}"));
        rig
    }

    pub(crate) fn empty() -> Self {
        Self { folder: TempDir::new().unwrap() }
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub(crate) fn folder(&self) -> &Path {
        self.folder.path()
    }

    pub(crate) fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.path(name)).unwrap()
    }

    pub(crate) fn write(&self, name: &str, text: &str) {
        std::fs::write(self.path(name), text).unwrap();
    }

    /// The problem with its first `from` replaced by `to`.
    #[track_caller]
    pub(crate) fn edit(&self, from: &str, to: &str) {
        let text = self.read("campaign.toml");
        assert!(text.contains(from), "{from}");
        self.write("campaign.toml", &text.replacen(from, to, 1));
    }

    pub(crate) fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_infuse"));
        command.args(arguments).current_dir(self.folder());
        command
    }

    pub(crate) fn infuse(&self, arguments: &[&str]) -> Said {
        self.command(arguments).output().unwrap().into()
    }

    pub(crate) fn status(&self) -> Value {
        serde_json::from_str(&self.infuse(&["status", "--json"]).ok()).unwrap()
    }

    /// The complete lines of the journal.
    pub(crate) fn journal(&self) -> Vec<Value> {
        let text = std::fs::read_to_string(self.path("journal.jsonl")).unwrap_or_default();
        let whole = text.rfind('\n').map_or("", |end| &text[..end]);
        whole.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
    }

    /// Fills in the rows of a sheet for which `choose` is true, by their ids.
    pub(crate) fn fill(&self, sheet: &str, choose: impl Fn(u64) -> bool) {
        let mut sheet_read = csv::Reader::from_path(self.path(sheet)).unwrap();
        let headings = sheet_read.headers().unwrap().clone();
        let at = |heading: &str| headings.iter().position(|found| found == heading).unwrap();
        let (id, spring, damper, value) =
            (at("id"), at("spring [N/mm]"), at("damper gain [N s/mm]"), at("vibration [mm/s]"));
        let mut filled = csv::Writer::from_writer(Vec::new());
        filled.write_record(&headings).unwrap();
        for record in sheet_read.records() {
            let mut cells: Vec<String> = record.unwrap().iter().map(str::to_owned).collect();
            let number: u64 = cells[id].parse().unwrap();
            if choose(number) {
                cells[value] = measured(number, cells[spring].parse().unwrap(), cells[damper].parse().unwrap());
            }
            filled.write_record(&cells).unwrap();
        }
        std::fs::write(self.path(sheet), filled.into_inner().unwrap()).unwrap();
    }

    /// Asks, fills and tells one batch; false at the end of the campaign.
    pub(crate) fn batch(&self) -> bool {
        let asked: Value = serde_json::from_str(&self.infuse(&["ask", "--json"]).ok()).unwrap();
        let Some(sheet) = asked["sheet"].as_str() else {
            return false;
        };
        self.fill(sheet, |_| true);
        self.infuse(&["tell", sheet]).ok();
        true
    }
}

/// The settings with which the tests of the dissertation's loop go.
const DISSERTATION: &str = "[loop]\nmethod = \"dissertation\"\nmodel = \"quadratic\"\nexperiments = 10\nreplicates = 2\n\
                            simulations = 20\nbatches = 6\n";

/// The truth of the template's rig: smallest at (22, 1.9), where its simulation has (18, 1.3).
pub(crate) fn truth(spring: f64, damper: f64) -> f64 {
    let (a, b) = ((spring - 22.0) / 12.0, (damper - 1.9) / 1.2);
    7.0 + 4.0 * a * a + 5.0 * b * b + 1.5 * a * b
}

/// What experiment `id` reads, off by at most 0.2.
pub(crate) fn measured(id: u64, spring: f64, damper: f64) -> String {
    format!("{:.3}", truth(spring, damper) + 0.2 * (12.9898 * id as f64).sin())
}

/// Told values by id, of a journal.
pub(crate) fn told(journal: &[Value]) -> BTreeMap<u64, f64> {
    let lines = journal.iter().filter(|line| line["event"] == "told");
    lines.filter_map(|line| Some((line["id"].as_u64()?, line["value"].as_f64()?))).collect()
}
