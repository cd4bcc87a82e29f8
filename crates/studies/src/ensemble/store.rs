//! What is kept on disk: three tables that grow by one unit of work at a time, and survive being cut anywhere.
//!
//! A unit counts as done when its last line is in the last table; what an interrupted run left of another is dropped when the
//! store is opened, with a word. The first line of each table names what its rows follow from.

use std::collections::BTreeSet;
use std::fs::{self, OpenOptions};
use std::io::Write as _;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, ensure};

use super::row::{Fact, Row, Unit, fact_head, row_head};
use crate::kept;

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
            return Ok(Self { torn: path.exists(), path, first, lines: Vec::new() });
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

    /// Keeps lines of these units only.
    fn keep(&mut self, units: &BTreeSet<Unit>) {
        let before = self.lines.len();
        self.lines.retain(|(unit, _)| units.contains(unit));
        self.torn |= self.lines.len() < before;
    }

    /// Writes what is kept where the file holds something else; whether something was dropped.
    fn drop_unfinished(&self) -> Result<bool> {
        if self.torn || !self.path.exists() {
            let text: String = self.lines.iter().map(|(unit, cells)| text_of(unit, cells)).collect();
            kept::replace(&self.path, (self.first.clone() + &text).as_bytes())?;
        }
        Ok(self.torn)
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

const OTHER: &str =
    "its first line does not name the study, the plants and the rig of today: remove it to run all campaigns anew";

fn text_of(unit: &Unit, cells: &[String]) -> String {
    format!("{},{},{}\n", unit.0, unit.1, cells.join(","))
}

/// The tables of a folder.
#[derive(Debug)]
pub(super) struct Store {
    rows: Lines,
    times: Lines,
    facts: Lines,
    pub(super) done: Vec<Done>,
}

/// The fact that ends a unit.
pub(super) const LAST: &str = "flights";

impl Store {
    /// What a folder holds of the study with this key; nothing is written.
    pub(super) fn read(folder: &Path, key: &str) -> Result<Self> {
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
        [&mut rows, &mut times, &mut facts].into_iter().for_each(|table| table.keep(&ended));
        let done = units.into_iter().map(|unit| {
            let found = Found {
                rows: rows.of(&unit).map(|cells| Row::read(cells)).collect::<Result<_>>()?,
                facts: facts.of(&unit).map(|cells| Fact::read(cells)).collect::<Result<_>>()?,
                seconds: times.of(&unit).next().and_then(|cells| cells.first()?.parse().ok()).unwrap_or(0.0),
            };
            Ok(Done { unit, found })
        });
        let done = done.collect::<Result<Vec<_>>>().with_context(|| folder.display().to_string())?;
        Ok(Self { rows, times, facts, done })
    }

    /// Drops from the files what an interrupted run has left, so that units can be added; whether there was any.
    pub(super) fn drop_unfinished(&self) -> Result<bool> {
        let dropped = [self.rows.drop_unfinished()?, self.times.drop_unfinished()?, self.facts.drop_unfinished()?];
        Ok(dropped.contains(&true))
    }

    pub(super) fn has(&self, unit: &Unit) -> bool {
        self.done.iter().any(|done| done.unit == *unit)
    }

    /// Keeps what a unit found; the last line that is written says that it is whole.
    pub(super) fn add(&mut self, unit: Unit, mut found: Found, n_flights: usize) -> Result<()> {
        let of_row = found.rows.first().map(|row| (row.study, row.world));
        let of_fact = found.facts.first().map(|fact| (fact.study, fact.world));
        let (study, world) = of_row.or(of_fact).context("a unit that found nothing")?;
        found.facts.push(Fact { study, world, name: LAST.to_owned(), value: n_flights as f64 });
        let rows: Vec<_> = found.rows.iter().map(Row::cells).collect();
        let facts: Vec<_> = found.facts.iter().map(Fact::cells).collect();
        self.rows.append(&unit, &rows)?;
        self.times.append(&unit, &[vec![format!("{:.1}", found.seconds)]])?;
        self.facts.append(&unit, &facts)?;
        // As a later run will read it, so that what follows from it does not depend on when that is.
        found.rows = rows.iter().map(|cells| Row::read(cells)).collect::<Result<_>>()?;
        found.facts = facts.iter().map(|cells| Fact::read(cells)).collect::<Result<_>>()?;
        self.done.push(Done { unit, found });
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::row::{Method, N_READINGS, Study, World};
    use super::*;

    fn found(number: u64) -> Found {
        let row = |seed: u64| Row {
            study: Study::Two,
            world: World::Moving,
            method: Method::Dissertation,
            seed,
            step: 3,
            point: vec![48.25, 1.0 / 3.0 * seed as f64],
            share: 0.5,
            spread: f64::NAN,
            keeps_best: 1.0,
            bound: f64::NAN,
            readings: core::array::from_fn::<f64, N_READINGS, _>(|k| 0.125 * (k as u64 + number) as f64),
        };
        let fact = Fact { study: Study::Two, world: World::Still, name: "a/1".to_owned(), value: 0.25 };
        Found { rows: (1..4).map(row).collect(), facts: vec![fact], seconds: 1.5 }
    }

    const NAMES: [&str; 3] = ["designs.csv", "times.csv", "facts.csv"];

    fn texts(folder: &Path) -> [String; 3] {
        NAMES.map(|name| fs::read_to_string(folder.join(name)).expect("a table"))
    }

    /// Adds what is missing of three units.
    fn go_on(folder: &Path) -> Store {
        let mut store = Store::read(folder, "key").expect("a store");
        store.drop_unfinished().expect("a writable store");
        for number in 0..3 {
            let unit = ("two".to_owned(), number);
            if !store.has(&unit) {
                store.add(unit, found(number), 7).expect("written");
            }
        }
        store
    }

    #[test]
    fn wherever_the_tables_are_cut_a_run_goes_on_to_the_same_tables() {
        let folder = tempfile::tempdir().expect("a folder");
        go_on(folder.path());
        let whole = texts(folder.path());
        // A kill leaves the tables as they were written: one after the other, and each up to some byte.
        let ends = whole.each_ref().map(String::len);
        for cut in (0..ends.iter().sum::<usize>()).step_by(43) {
            for (k, name) in NAMES.iter().enumerate() {
                let before: usize = ends[..k].iter().sum();
                let end = cut.saturating_sub(before).min(ends[k]);
                fs::write(folder.path().join(name), &whole[k][..end]).expect("written");
            }
            go_on(folder.path());
            let again = texts(folder.path());
            let sorted = |text: &String| {
                let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
                lines[2..].sort();
                lines
            };
            for (whole, again) in whole.iter().zip(&again) {
                assert_eq!(sorted(whole), sorted(again), "cut at {cut}");
            }
        }
    }

    #[test]
    fn rows_are_read_as_they_were_written_to_six_digits() {
        let folder = tempfile::tempdir().expect("a folder");
        go_on(folder.path());
        let store = Store::read(folder.path(), "key").expect("a store");
        assert_eq!(store.done.len(), 3);
        let (own, read) = (&found(1), &store.done[1].found);
        assert_eq!(own.rows[2].cells(), read.rows[2].cells());
        assert_eq!(read.rows[0].point[1].to_bits(), 0.333_333_f64.to_bits());
        assert_eq!((read.facts.len(), read.facts[1].name.as_str(), read.seconds), (2, LAST, 1.5));
    }

    #[test]
    fn another_study_is_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        go_on(folder.path());
        let error = format!("{:#}", Store::read(folder.path(), "other").expect_err("another key"));
        assert!(error.contains("designs.csv") && error.contains("first line"), "{error}");
    }
}
