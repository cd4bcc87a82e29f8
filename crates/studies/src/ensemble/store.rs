//! What is kept on disk: three tables that grow by one unit of work at a time, and survive being cut anywhere.
//!
//! A unit counts as done when its last line is in the last table; what an interrupted run left of another is dropped when the
//! store is opened, with a word. The first line of each table names what its rows follow from.

use std::collections::BTreeSet;
use std::fs::{self, File, OpenOptions};
use std::io::Write as _;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, ensure};

use super::row::{Fact, Row, Unit, fact_head, row_head};

/// What a unit of work found.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Found {
    pub(super) rows: Vec<Row>,
    pub(super) facts: Vec<Fact>,
    pub(super) seconds: f64,
}

/// One unit with its name.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Done {
    pub(super) unit: Unit,
    pub(super) found: Found,
}

/// One table: lines of cells, the first two of them the unit.
#[derive(Debug)]
struct Lines {
    path: PathBuf,
    first: String,
    lines: Vec<(Unit, Vec<String>)>,
    /// Whether the file holds more than whole lines.
    torn: bool,
}

impl Lines {
    fn read(path: PathBuf, key: &str, head: &[String]) -> Result<Self> {
        let first = format!("# {key}\nwork,plant,{}\n", head.join(","));
        let text = if path.exists() {
            fs::read_to_string(&path).with_context(|| path.display().to_string())?
        } else {
            String::new()
        };
        if text.len() < first.len() {
            // Killed while it was begun, or another file.
            ensure!(first.starts_with(&text), "{}: {}", path.display(), OTHER);
            return Ok(Self { path, torn: !text.is_empty(), first, lines: Vec::new() });
        }
        let rest = text.strip_prefix(&first).with_context(|| format!("{}: {OTHER}", path.display()))?;
        let whole = rest.rfind('\n').map_or(0, |end| end + 1);
        let line = |line: &str| -> Result<(Unit, Vec<String>)> {
            let mut cells = line.split(',').map(str::to_owned);
            let unit = cells.next().zip(cells.next()).context("no unit")?;
            Ok(((unit.0, unit.1.parse().context("plant")?), cells.collect()))
        };
        let lines = rest[..whole].lines().enumerate();
        let lines =
            lines.map(|(number, text)| line(text).with_context(|| format!("{}: line {}", path.display(), number + 3)));
        Ok(Self { torn: whole < rest.len(), lines: lines.collect::<Result<_>>()?, path, first })
    }

    /// Keeps lines of these units only; whether anything was dropped.
    fn keep(&mut self, units: &BTreeSet<Unit>) -> Result<bool> {
        let before = self.lines.len();
        self.lines.retain(|(unit, _)| units.contains(unit));
        let changed = self.torn || self.lines.len() < before || !self.path.exists();
        if changed {
            let text: String = self.lines.iter().map(|(unit, cells)| text_of(unit, cells)).collect();
            replace(&self.path, &(self.first.clone() + &text))?;
        }
        Ok(self.torn || self.lines.len() < before)
    }

    fn append(&self, unit: &Unit, lines: &[Vec<String>]) -> Result<()> {
        let text: String = lines.iter().map(|cells| text_of(unit, cells)).collect();
        let words = || self.path.display().to_string();
        let mut file = OpenOptions::new().append(true).open(&self.path).with_context(words)?;
        file.write_all(text.as_bytes()).with_context(words)?;
        file.sync_all().with_context(words)
    }

    fn of<'a>(&'a self, unit: &'a Unit) -> impl Iterator<Item = &'a Vec<String>> {
        self.lines.iter().filter(move |(own, _)| own == unit).map(|(_, cells)| cells)
    }
}

const OTHER: &str = "its first line does not name the study, the plants and the rig of today: remove it to run all campaigns anew";

fn text_of(unit: &Unit, cells: &[String]) -> String {
    format!("{},{},{}\n", unit.0, unit.1, cells.join(","))
}

fn replace(path: &Path, text: &str) -> Result<()> {
    let beside = path.with_extension("csv.part");
    let words = || beside.display().to_string();
    let mut file = File::create(&beside).with_context(words)?;
    file.write_all(text.as_bytes()).with_context(words)?;
    file.sync_all().with_context(words)?;
    fs::rename(&beside, path).with_context(|| path.display().to_string())
}

/// The tables of a folder.
#[derive(Debug)]
pub(super) struct Store {
    rows: Lines,
    times: Lines,
    facts: Lines,
    pub(super) done: Vec<Done>,
    /// Whether something was dropped.
    pub(super) was_cut: bool,
}

/// The fact that ends a unit.
pub(super) const LAST: &str = "flights";

impl Store {
    /// What a folder holds of the study with this key.
    pub(super) fn open(folder: &Path, key: &str) -> Result<Self> {
        let lines = |name: &str, head: &[String]| Lines::read(folder.join(name), key, head);
        let mut rows = lines("designs.csv", &row_head())?;
        let mut times = lines("times.csv", &["seconds".to_owned()])?;
        let mut facts = lines("facts.csv", &fact_head())?;
        let is_last = |cells: &Vec<String>| cells.get(2).is_some_and(|name| name == LAST);
        let mut units: Vec<Unit> = Vec::new();
        for (unit, cells) in &facts.lines {
            if is_last(cells) && !units.contains(unit) {
                units.push(unit.clone());
            }
        }
        let ended: BTreeSet<Unit> = units.iter().cloned().collect();
        let mut was_cut = false;
        for table in [&mut rows, &mut times, &mut facts] {
            was_cut |= table.keep(&ended)?;
        }
        let done = units.into_iter().map(|unit| {
            let found = Found {
                rows: rows.of(&unit).map(|cells| Row::read(cells)).collect::<Result<_>>()?,
                facts: facts.of(&unit).map(|cells| Fact::read(cells)).collect::<Result<_>>()?,
                seconds: times.of(&unit).next().and_then(|cells| cells.first()?.parse().ok()).unwrap_or(0.0),
            };
            Ok(Done { unit, found })
        });
        let done = done.collect::<Result<Vec<_>>>().with_context(|| folder.display().to_string())?;
        Ok(Self { rows, times, facts, done, was_cut })
    }

    pub(super) fn has(&self, unit: &Unit) -> bool {
        self.done.iter().any(|done| done.unit == *unit)
    }

    /// Keeps what a unit found; the last line that is written says that it is whole.
    pub(super) fn add(&mut self, unit: Unit, mut found: Found, n_flights: usize) -> Result<()> {
        let first = found.rows.first().map(|row| (row.study, row.world)).context("a unit without rows")?;
        found.facts.push(Fact { study: first.0, world: first.1, name: LAST.to_owned(), value: n_flights as f64 });
        self.rows.append(&unit, &found.rows.iter().map(Row::cells).collect::<Vec<_>>())?;
        self.times.append(&unit, &[vec![format!("{:.1}", found.seconds)]])?;
        self.facts.append(&unit, &found.facts.iter().map(Fact::cells).collect::<Vec<_>>())?;
        self.done.push(Done { unit, found });
        Ok(())
    }
}
