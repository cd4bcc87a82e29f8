//! What is kept on disk: three tables that grow by one unit of work at a time, and survive being cut anywhere.
//!
//! A unit counts as done when its last line is in the last table; what an interrupted run left of another is dropped when the
//! store is opened, with a word. The first line of each table names what its rows follow from.
//!
//! Beside the time that a unit took stands how many lines it has in the other tables, and their sums ([`crate::seal`]): a line that
//! was changed, taken out or added is an error when the store is opened.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File, OpenOptions};
use std::io::{Read as _, Write as _};
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Error, Result, anyhow, bail, ensure};

use super::row::{Fact, Row, Unit, fact_head, row_head};
use crate::calibration::CAMPAIGN_TABLES;
use crate::{kept, seal};

/// What a unit of work found.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Found {
    pub(super) rows: Vec<Row>,
    pub(super) facts: Vec<Fact>,
    pub(super) seconds: f64,
}

impl Found {
    /// Whether another run found the same, to the digits that are kept; how many flights that took may differ.
    pub(super) fn agrees_with(&self, other: &Self) -> bool {
        let rows = |found: &Self| found.rows.iter().map(Row::cells).collect::<Vec<_>>();
        let facts =
            |found: &Self| found.facts.iter().filter(|fact| fact.name != LAST).map(Fact::cells).collect::<Vec<_>>();
        rows(self) == rows(other) && facts(self) == facts(other)
    }
}

/// One unit with its name.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Done {
    pub(super) unit: Unit,
    pub(super) found: Found,
}

/// A line of a table.
#[derive(Debug)]
struct Line {
    /// From 1, of the file.
    number: usize,
    unit: Unit,
    /// Behind those of the unit.
    cells: Vec<String>,
}

/// One table: lines of cells, the first two of them the unit.
#[derive(Debug)]
struct Lines {
    path: PathBuf,
    first: String,
    lines: Vec<Line>,
    /// Whether the file holds more than whole lines.
    torn: bool,
}

impl Lines {
    /// One that begins as it has to ([`check_first_lines`]).
    fn read(path: PathBuf, key: &str, head: &[String]) -> Result<Self> {
        let first = first_lines(key, head);
        let text = if path.exists() {
            fs::read_to_string(&path).with_context(|| path.display().to_string())?
        } else {
            String::new()
        };
        let Some(rest) = text.strip_prefix(&first) else {
            // Killed while it was begun.
            return Ok(Self { torn: path.exists(), path, first, lines: Vec::new() });
        };
        let whole = rest.rfind('\n').map_or(0, |end| end + 1);
        let line = |number: usize, line: &str| -> Result<Line> {
            let mut cells = line.split(',').map(str::to_owned);
            let (work, plant) = cells.next().zip(cells.next()).context("no unit")?;
            let plant = plant.parse().ok().with_context(|| format!("column `plant`: `{plant}` is no number"))?;
            Ok(Line { number, unit: (work, plant), cells: cells.collect() })
        };
        let lines = (LINES_BEFORE + 1..).zip(rest[..whole].lines());
        let lines = lines.map(|(number, text)| line(number, text).with_context(|| place(&path, number)));
        Ok(Self { torn: whole < rest.len(), lines: lines.collect::<Result<_>>()?, path, first })
    }

    /// Keeps lines of these units only.
    fn keep(&mut self, units: &BTreeSet<Unit>) {
        let before = self.lines.len();
        self.lines.retain(|line| units.contains(&line.unit));
        self.torn |= self.lines.len() < before;
    }

    /// Writes what is kept where the file holds something else; whether something was dropped.
    fn drop_unfinished(&self) -> Result<bool> {
        if self.torn || !self.path.exists() {
            let text: String = self.lines.iter().map(|line| text_of(&line.unit, &line.cells)).collect();
            kept::replace(&self.path, (self.first.clone() + &text).as_bytes())?;
        }
        Ok(self.torn)
    }

    fn append(&mut self, unit: &Unit, lines: &[Vec<String>]) -> Result<()> {
        let text: String = lines.iter().map(|cells| text_of(unit, cells)).collect();
        let first = LINES_BEFORE + 1 + self.lines.len();
        let line = |(number, cells): (usize, &Vec<String>)| Line { number, unit: unit.clone(), cells: cells.clone() };
        self.lines.extend((first..).zip(lines).map(line));
        let words = || self.path.display().to_string();
        let mut file = OpenOptions::new().append(true).open(&self.path).with_context(words)?;
        file.write_all(text.as_bytes()).with_context(words)?;
        file.sync_all().with_context(words)
    }

    /// The lines of each unit.
    fn by_unit(&self) -> BTreeMap<&Unit, Vec<&Line>> {
        let mut lines: BTreeMap<&Unit, Vec<&Line>> = BTreeMap::new();
        for line in &self.lines {
            lines.entry(&line.unit).or_default().push(line);
        }
        lines
    }

    /// What lines say, by one reader; an error names file and line.
    fn read_all<T>(&self, lines: &[&Line], read: fn(&[String]) -> Result<T>) -> Result<Vec<T>> {
        let read = |line: &&Line| {
            let words = |error: Error| anyhow!("{}: {error:#}; {REMEDY}", place(&self.path, line.number));
            read(&line.cells).map_err(words)
        };
        lines.iter().map(read).collect()
    }

    /// That the lines of a unit are those that were counted and summed when it was done.
    fn check(&self, unit: &Unit, lines: &[&Line], Sum { count, sum }: &Sum) -> Result<()> {
        let found = Sum::of(unit, lines.iter().map(|line| &line.cells));
        let words = || format!("{}: {}, plant {}", self.path.display(), unit.0, unit.1);
        ensure!(found.count == *count, "{}: {} lines of {count} are there; {REMEDY}", words(), found.count);
        let first = lines.first().map_or(0, |line| line.number);
        ensure!(found.sum == *sum, "{}: some of its lines, from line {first} on, were changed; {REMEDY}", words());
        Ok(())
    }
}

/// How many lines a unit has in a table, and the sum of their text.
#[derive(Debug, PartialEq)]
struct Sum {
    count: usize,
    sum: String,
}

impl Sum {
    fn of<'a>(unit: &Unit, lines: impl Iterator<Item = &'a Vec<String>>) -> Self {
        let texts: Vec<String> = lines.map(|cells| text_of(unit, cells)).collect();
        Self { count: texts.len(), sum: seal::sum(&texts.concat()) }
    }
}

/// What stands in the table of times.
#[derive(Debug)]
struct Time {
    seconds: f64,
    /// Of designs, and of facts.
    sums: [Sum; 2],
}

const TIME_HEAD: [&str; 5] = ["seconds", "designs", "sum_of_designs", "facts", "sum_of_facts"];

impl Time {
    fn cells(&self) -> Vec<String> {
        let sums = self.sums.iter().flat_map(|Sum { count, sum }| [count.to_string(), sum.clone()]);
        std::iter::once(format!("{:.1}", self.seconds)).chain(sums).collect()
    }

    fn read(cells: &[String]) -> Result<Self> {
        let [seconds, designs, sum_of_designs, facts, sum_of_facts] = cells else {
            bail!("{} cells, {} are needed", cells.len(), TIME_HEAD.len());
        };
        let sum = |column: &str, count: &String, sum: &String| -> Result<Sum> {
            let count = count.parse().ok().with_context(|| format!("column `{column}`: `{count}` is no number"))?;
            Ok(Sum { count, sum: sum.clone() })
        };
        Ok(Self {
            seconds: seconds.parse().ok().with_context(|| format!("column `seconds`: `{seconds}` is no number"))?,
            sums: [sum("designs", designs, sum_of_designs)?, sum("facts", facts, sum_of_facts)?],
        })
    }
}

/// The first line and the head.
const LINES_BEFORE: usize = 2;
const REMEDY: &str = "take the tables back from version control, or take all lines of this plant and work out of all three tables and run \
                      `cargo xtask reproduce-all --ensemble`";

fn place(path: &Path, number: usize) -> String {
    format!("{}: line {number}", path.display())
}

/// The first line and the head of a table.
fn first_lines(key: &str, head: &[String]) -> String {
    format!("# {key}\nwork,plant,{}\n", head.join(","))
}

/// The tables with what stands in their heads behind the unit.
fn tables() -> [(&'static str, Vec<String>); 3] {
    let [designs, facts, times] = CAMPAIGN_TABLES;
    [(designs, row_head()), (facts, fact_head()), (times, TIME_HEAD.map(str::to_owned).to_vec())]
}

/// Whether a file begins with a text, or is the beginning of it: a run may be killed while it writes that.
fn begins_with(path: &Path, first: &str) -> Result<bool> {
    let words = || path.display().to_string();
    let mut bytes = Vec::new();
    File::open(path).with_context(words)?.take(first.len() as u64).read_to_end(&mut bytes).with_context(words)?;
    Ok(first.as_bytes().starts_with(&bytes))
}

/// That the tables of some folders are those of the study with this key, each: one error names all that are not.
pub(super) fn check_first_lines(stores: &[(PathBuf, &str)]) -> Result<()> {
    let mut others = Vec::new();
    for (folder, key) in stores {
        for (name, head) in tables() {
            let path = folder.join(name);
            if path.exists() && !begins_with(&path, &first_lines(key, &head))? {
                others.push(format!("{} (`# {key}`)", path.display()));
            }
        }
    }
    ensure!(
        others.is_empty(),
        "{}: the first line does not name the study, the plants and the rig of today, as in brackets: take the tables back from version control, \
         or remove all that are named here to run their campaigns anew",
        others.join(", ")
    );
    Ok(())
}

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
const LAST: &str = "flights";

impl Store {
    /// What a folder holds of the study with this key; nothing is written.
    pub(super) fn read(folder: &Path, key: &str) -> Result<Self> {
        check_first_lines(&[(folder.to_owned(), key)])?;
        let [rows, facts, times] = tables().map(|(name, head)| Lines::read(folder.join(name), key, &head));
        let (mut rows, mut facts, mut times) = (rows?, facts?, times?);
        let is_last = |cells: &Vec<String>| cells.get(2).is_some_and(|name| name == LAST);
        let mut units: Vec<Unit> = Vec::new();
        for Line { unit, cells, .. } in &facts.lines {
            if is_last(cells) && !units.contains(unit) {
                units.push(unit.clone());
            }
        }
        let ended: BTreeSet<Unit> = units.iter().cloned().collect();
        let lines = [&rows, &times, &facts].into_iter().flat_map(|table| &table.lines);
        let unfinished: BTreeSet<&Unit> = lines.map(|line| &line.unit).filter(|unit| !ended.contains(*unit)).collect();
        if unfinished.len() > 1
            && let Some((work, plant)) = unfinished.first()
        {
            bail!(
                "{}: {} studies of a plant are not whole, {work} of plant {plant} first, and a run that is killed leaves one at most; {REMEDY}",
                folder.display(),
                unfinished.len()
            );
        }
        [&mut rows, &mut times, &mut facts].into_iter().for_each(|table| table.keep(&ended));
        let (of_rows, of_times, of_facts) = (rows.by_unit(), times.by_unit(), facts.by_unit());
        let none = Vec::new();
        let done = units.into_iter().map(|unit| {
            let [rows_of, times_of, facts_of] =
                [&of_rows, &of_times, &of_facts].map(|lines| lines.get(&unit).unwrap_or(&none));
            let found_rows = rows.read_all(rows_of, Row::read)?;
            let found_facts = facts.read_all(facts_of, Fact::read)?;
            let [Time { seconds, sums: [designs, of_the_facts] }] = &times.read_all(times_of, Time::read)?[..] else {
                bail!(
                    "{}: {} lines of {}, plant {}: there must be one; {REMEDY}",
                    times.path.display(),
                    times_of.len(),
                    unit.0,
                    unit.1
                );
            };
            rows.check(&unit, rows_of, designs)?;
            facts.check(&unit, facts_of, of_the_facts)?;
            Ok(Done { found: Found { rows: found_rows, facts: found_facts, seconds: *seconds }, unit })
        });
        let done = done.collect::<Result<Vec<_>>>()?;
        Ok(Self { rows, times, facts, done })
    }

    /// Drops from the files what an interrupted run has left, so that units can be added; whether there was any.
    pub(super) fn drop_unfinished(&self) -> Result<bool> {
        let dropped = [self.rows.drop_unfinished()?, self.times.drop_unfinished()?, self.facts.drop_unfinished()?];
        Ok(dropped.contains(&true))
    }

    /// Flights, and seconds.
    pub(super) fn took(&self) -> [f64; 2] {
        let facts = self.done.iter().flat_map(|done| &done.found.facts);
        let flights = facts.filter(|fact| fact.name == LAST).map(|fact| fact.value).sum();
        [flights, self.done.iter().map(|done| done.found.seconds).sum()]
    }

    pub(super) fn has(&self, unit: &Unit) -> bool {
        self.done.iter().any(|done| done.unit == *unit)
    }

    /// What is kept of a unit, and how many flights it took.
    pub(super) fn of(&self, unit: &Unit) -> Option<(Found, usize)> {
        let mut found = self.done.iter().find(|done| done.unit == *unit)?.found.clone();
        let last = found.facts.iter().position(|fact| fact.name == LAST)?;
        let n_flights = found.facts.remove(last).value as usize;
        Some((found, n_flights))
    }

    /// Takes out what is kept of a unit. What counts it as done goes first, so that a run that is killed leaves it to be run.
    pub(super) fn take_out(&mut self, unit: &Unit) -> Result<()> {
        self.done.retain(|done| done.unit != *unit);
        let units: BTreeSet<Unit> = self.done.iter().map(|done| done.unit.clone()).collect();
        for table in [&mut self.facts, &mut self.times, &mut self.rows] {
            table.keep(&units);
            table.drop_unfinished()?;
            table.torn = false;
        }
        Ok(())
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
        let sums = [Sum::of(&unit, rows.iter()), Sum::of(&unit, facts.iter())];
        self.times.append(&unit, &[Time { seconds: found.seconds, sums }.cells()])?;
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
        go_on_to(folder, 3)
    }

    fn go_on_to(folder: &Path, end: u64) -> Store {
        let mut store = Store::read(folder, "key").expect("a store");
        store.drop_unfinished().expect("a writable store");
        for number in 0..end {
            let unit = ("two".to_owned(), number);
            if !store.has(&unit) {
                store.add(unit, found(number), 7).expect("written");
            }
        }
        store
    }

    /// However often, in whatever order; and a run that is killed in between has it missing, no more.
    #[test]
    fn what_is_taken_out_is_missing_until_it_is_kept_anew() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut store = go_on(folder.path());
        for number in [1, 0] {
            let unit = ("two".to_owned(), number);
            let (kept, n_flights) = store.of(&unit).expect("it was kept");
            assert_eq!((kept.facts.len(), n_flights), (1, 7));
            store.take_out(&unit).expect("written");
            let read = Store::read(folder.path(), "key").expect("a store");
            assert!(!read.has(&unit) && read.done.len() == 2, "{number}");
            store.add(unit, Found { seconds: 9.0, ..found(number + 10) }, 8).expect("written");
        }
        let read = Store::read(folder.path(), "key").expect("a store");
        let numbers: Vec<u64> = read.done.iter().map(|done| done.unit.1).collect();
        assert_eq!(numbers, [2, 1, 0]);
        for (at, expected) in [(0, found(2)), (1, found(11)), (2, found(10))] {
            assert!(read.done[at].found.agrees_with(&expected), "{:?}", read.done[at]);
        }
        let expected = [23.0, 19.5];
        assert!(read.took().iter().zip(expected).all(|(took, one)| (took - one).abs() < 1e-9), "{:?}", read.took());
    }

    #[test]
    fn wherever_a_run_is_killed_it_goes_on_to_the_same_tables() {
        let folder = tempfile::tempdir().expect("a folder");
        go_on(folder.path());
        let whole = texts(folder.path());
        for units in 0..3 {
            let before = tempfile::tempdir().expect("a folder");
            go_on_to(before.path(), units);
            let ends = texts(before.path()).map(|text| text.len());
            go_on_to(before.path(), units + 1);
            let after = texts(before.path());
            // A kill leaves the tables as they are written: one after the other, and each up to some byte.
            let added: Vec<usize> = after.iter().zip(ends).map(|(text, end)| text.len() - end).collect();
            for cut in (0..added.iter().sum::<usize>()).step_by(17) {
                for (k, name) in NAMES.iter().enumerate() {
                    let end = ends[k] + cut.saturating_sub(added[..k].iter().sum()).min(added[k]);
                    fs::write(folder.path().join(name), &after[k][..end]).expect("written");
                }
                go_on(folder.path());
                assert_eq!(whole, texts(folder.path()), "{units} units, cut at {cut}");
            }
        }
    }

    #[test]
    fn more_than_a_kill_can_have_left_is_refused_and_nothing_is_dropped() {
        let folder = tempfile::tempdir().expect("a folder");
        go_on(folder.path());
        let path = folder.path().join(NAMES[2]);
        let text = fs::read_to_string(&path).expect("a table");
        // The facts of the last two units.
        let lines: Vec<&str> = text.lines().take(4).collect();
        fs::write(&path, lines.join("\n") + "\n").expect("written");
        let cut = texts(folder.path());
        let error = format!("{:#}", Store::read(folder.path(), "key").expect_err("two units are not whole"));
        assert!(error.contains("2 studies of a plant are not whole, two of plant 1 first"), "{error}");
        assert_eq!(texts(folder.path()), cut);
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
    fn damage_is_named_with_file_line_and_column() {
        let refuse = |name: &str, change: &dyn Fn(&str) -> String, words: &[&str]| {
            let folder = tempfile::tempdir().expect("a folder");
            go_on(folder.path());
            let path = folder.path().join(name);
            let text = fs::read_to_string(&path).expect("a table");
            let changed = change(&text);
            assert_ne!(text, changed);
            fs::write(&path, changed).expect("written");
            let error = format!("{:#}", Store::read(folder.path(), "key").expect_err("a damaged table"));
            assert!(words.iter().chain(&["version control", name]).all(|word| error.contains(word)), "{error}");
        };
        // Lines 3 to 5 are of plant 0, 6 to 8 of plant 1.
        let in_line = |number: usize, from: &'static str, to: &'static str| {
            move |text: &str| -> String {
                let lines = (1..).zip(text.lines()).map(|(k, line)| {
                    let line = if k == number { line.replacen(from, to, 1) } else { line.to_owned() };
                    line + "\n"
                });
                lines.collect()
            }
        };
        let without = |number: usize| {
            move |text: &str| -> String {
                (1..).zip(text.lines()).filter(|(k, _)| *k != number).map(|(_, line)| line.to_owned() + "\n").collect()
            }
        };
        refuse("designs.csv", &in_line(7, "0.125", "xyz"), &["line 7", "column `cost_s`", "`xyz`"]);
        refuse("designs.csv", &in_line(7, ",dissertation", ""), &["line 7", "22 cells, 23"]);
        refuse("designs.csv", &in_line(7, "moving", "mowing"), &["line 7", "column `world`", "`mowing`"]);
        refuse("designs.csv", &in_line(7, ",3,", ",x,"), &["line 7", "column `step`", "`x`"]);
        refuse("designs.csv", &in_line(7, "0.125", "0.126"), &["two, plant 1", "from line 6 on", "changed"]);
        refuse("designs.csv", &without(7), &["two, plant 1", "2 lines of 3"]);
        refuse("facts.csv", &in_line(3, "0.25", "0.5"), &["two, plant 0", "changed"]);
        refuse("facts.csv", &in_line(3, "0.25", "a"), &["line 3", "column `value`", "`a`"]);
        refuse("facts.csv", &without(3), &["two, plant 0", "1 lines of 2"]);
        refuse("times.csv", &without(4), &["0 lines of two, plant 1"]);
        refuse("times.csv", &in_line(4, "1.5", "?"), &["line 4", "column `seconds`"]);
    }

    #[test]
    fn another_study_is_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        go_on(folder.path());
        let error = format!("{:#}", Store::read(folder.path(), "other").expect_err("another key"));
        assert!(error.contains("designs.csv") && error.contains("first line"), "{error}");
    }

    /// Whoever follows the error need not read three more.
    #[test]
    fn one_error_names_all_tables_of_another_study_in_both_folders() {
        let folders = [(); 2].map(|()| tempfile::tempdir().expect("a folder"));
        for folder in &folders {
            go_on(folder.path());
        }
        let [near, beyond] = folders.each_ref().map(|folder| folder.path().to_owned());
        let check = |keys: [&str; 2]| check_first_lines(&[(near.clone(), keys[0]), (beyond.clone(), keys[1])]);
        check(["key", "key"]).expect("tables of this study");
        let named = |keys: [&str; 2]| {
            let error = format!("{:#}", check(keys).expect_err("another study"));
            [&near, &beyond].map(|folder| NAMES.map(|name| error.contains(&folder.join(name).display().to_string())))
        };
        assert_eq!(named(["other", "others"]), [[true; 3]; 2]);
        assert_eq!(named(["key", "others"]), [[false; 3], [true; 3]], "what is whole is not removed");
        fs::remove_file(near.join("facts.csv")).expect("removed");
        fs::write(near.join("times.csv"), "# key\nwork,pl").expect("written");
        check(["key", "key"]).expect("none, and one that was killed while it was begun");
    }
}
