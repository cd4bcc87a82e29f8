//! The starts that were tried and the plants that were kept, on disk after each: a killed run goes on where it was.
//!
//! The first line of each table names what its rows were made from ([`crate::seal`]); what is read is looked at: each plant within its
//! ranges, each with its start, no start left out.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use anyhow::{Context as _, Result, anyhow, ensure};

use super::outcome::{Member, Refusal, Start};
use crate::kept;
use crate::seal::{self, Form};

/// What the tables of a calibration hold.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Shape {
    /// Names what plants follow from.
    pub(super) key: String,
    pub(super) ranges: Vec<Range>,
    /// All folders whose tables follow from this key.
    pub(super) folders: &'static [&'static str],
}

impl Shape {
    /// What somebody has to do about plants of other files or of another program, with all tables that have to go at once.
    pub(super) fn remedy(&self) -> String {
        let tables = [STARTS, MEMBERS].into_iter().chain(CAMPAIGN_TABLES).collect::<Vec<_>>().join(", ");
        let folders = self.folders.join(" and ");
        format!(
            "take the tables back from version control, or, to calibrate anew, remove all of {tables} from {folders}, since campaigns follow from \
             the plants"
        )
    }
}

/// A number that is free.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Range {
    pub(super) key: String,
    pub(super) lower: f64,
    pub(super) upper: f64,
}

/// Both tables of a folder.
#[derive(Debug)]
pub(super) struct Store {
    folder: PathBuf,
    shape: Shape,
    /// By number.
    pub(super) starts: Vec<Start>,
    /// By number of their start.
    pub(super) members: Vec<Member>,
}

pub(super) const ENSEMBLE: &str = "fixtures/bat/ensemble";
pub(super) const BEYOND: &str = "fixtures/bat/ensemble/beyond";

/// Starts at once, so that a killed run loses no more than these.
pub(super) const AT_ONCE: u64 = 2;
const KEPT: &str = "kept";
const STARTS: &str = "starts.csv";
const MEMBERS: &str = "members.csv";
const START_HEAD: [&str; 3] = ["start", "outcome", "worst_residual"];
/// The first line and the head.
const LINES_BEFORE: usize = 2;
/// Ends of ranges are met as nearly as this share of them.
const ROUNDING: f64 = 1e-9;
/// What campaigns on the plants are kept in, beside them.
pub(crate) const CAMPAIGN_TABLES: [&str; 3] = ["designs.csv", "facts.csv", "times.csv"];
/// What somebody has to do about rows that are damaged: the same plants come out of the same files.
const REMEDY: &str =
    "take starts.csv and members.csv back from version control, or remove both from this folder to calibrate anew";

const OTHERS: &str = "ranges, evidence, tolerances, seed, reach, rig, test or weights have changed since";

/// A table as it was read.
struct Table {
    path: PathBuf,
    text: String,
    head: Vec<String>,
}

/// The cells of a line.
struct Line<'a> {
    table: &'a Table,
    number: usize,
    cells: Vec<String>,
}

impl Line<'_> {
    fn words(&self) -> String {
        format!("{}: line {}", self.table.path.display(), self.number)
    }

    fn read<T: FromStr>(&self, column: usize) -> Result<T> {
        let cell = &self.cells[column];
        let words =
            || format!("{}: column `{}`: `{cell}` is no number; {REMEDY}", self.words(), self.table.head[column]);
        cell.parse().ok().with_context(words)
    }

    fn start(&self) -> Result<Start> {
        let refusal = match self.cells[1].as_str() {
            KEPT => None,
            name => {
                let known = Refusal::ALL.into_iter().find(|refusal| refusal.name() == name);
                let error = || format!("{}: column `outcome`: no outcome `{name}`; {REMEDY}", self.words());
                Some(known.with_context(error)?)
            }
        };
        let worst = if self.cells[2].is_empty() { None } else { Some(self.read(2)?) };
        Ok(Start { number: self.read(0)?, refusal, worst })
    }

    fn member(&self) -> Result<Member> {
        let values = (1..self.cells.len()).map(|column| self.read(column));
        Ok(Member { start: self.read(0)?, values: values.collect::<Result<_>>()? })
    }
}

impl Table {
    /// None where there is no such file.
    fn read(folder: &Path, name: &str, head: Vec<String>) -> Result<Option<Self>> {
        let path = folder.join(name);
        if !path.exists() {
            return Ok(None);
        }
        let text = std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
        Ok(Some(Self { path, text, head }))
    }

    /// That the head is that of today, and the lines below it.
    fn lines(&self, rows: &str) -> Result<Vec<Line<'_>>> {
        let words = || self.path.display().to_string();
        let mut reader = csv::ReaderBuilder::new().has_headers(false).flexible(true).from_reader(rows.as_bytes());
        let mut lines = Vec::new();
        for (index, record) in reader.records().enumerate() {
            let record = record.with_context(words)?;
            let cells: Vec<String> = record.iter().map(str::to_owned).collect();
            let number = index + LINES_BEFORE;
            if index == 0 {
                ensure!(
                    cells == self.head,
                    "{}: line {number}: other columns than the ranges of today have; {REMEDY}",
                    words()
                );
                continue;
            }
            let (n, needed) = (cells.len(), self.head.len());
            ensure!(n == needed, "{}: line {number}: {n} cells, {needed} are needed; {REMEDY}", words());
            lines.push(Line { table: self, number, cells });
        }
        Ok(lines)
    }
}

impl Store {
    /// What a folder holds; nothing if there is none yet.
    pub(super) fn read(folder: &Path, shape: Shape) -> Result<Self> {
        let mut store = Self { folder: folder.to_owned(), shape, starts: Vec::new(), members: Vec::new() };
        let key = &store.shape.key;
        if let Some(table) = Table::read(folder, MEMBERS, store.head())? {
            let opened = seal::open(&table.path, Form::Comment, &table.text, key, REMEDY)?;
            opened.check_key(&table.path, key, || store.other_words(&table, opened.rows))?;
            for line in table.lines(opened.rows)? {
                let member = line.member()?;
                if let Some(words) = store.misfit(&member) {
                    return Err(anyhow!("{} (start {}): {words}; {REMEDY}", line.words(), member.start));
                }
                store.members.push(member);
            }
            opened.check_sum(&table.path, REMEDY)?;
        }
        if let Some(table) = Table::read(folder, STARTS, START_HEAD.map(str::to_owned).to_vec())? {
            let opened = seal::open(&table.path, Form::Comment, &table.text, key, REMEDY)?;
            opened.check_key(&table.path, key, || format!(": {OTHERS}; {}", store.shape.remedy()))?;
            for (number, line) in (0..).zip(table.lines(opened.rows)?) {
                let start = line.start()?;
                ensure!(
                    start.number == number,
                    "{}: column `start`: {} where {number} has to follow; {REMEDY}",
                    line.words(),
                    start.number
                );
                store.starts.push(start);
            }
            opened.check_sum(&table.path, REMEDY)?;
        }
        store.match_up()?;
        Ok(store)
    }

    /// Where a plant is outside of its ranges.
    fn misfit(&self, member: &Member) -> Option<String> {
        let outside = self.shape.ranges.iter().zip(&member.values).find(|(range, value)| {
            let slack = ROUNDING * (range.upper - range.lower);
            !(range.lower - slack..=range.upper + slack).contains(*value)
        });
        outside.map(|(Range { key, lower, upper }, value)| {
            format!("`{key}` is {value}: it must be within its range, {lower} to {upper}")
        })
    }

    /// How the plants of other files fit the ranges of today.
    fn other_words(&self, table: &Table, rows: &str) -> String {
        let lines = table.lines(rows).unwrap_or_default();
        let misfits = lines.iter().filter_map(|line| Some((line, self.misfit(&line.member().ok()?)?)));
        let misfits: Vec<String> = misfits.map(|(line, words)| format!("line {}: {words}", line.number)).collect();
        let of = format!("; {} of {} plants lie outside of the ranges of today", misfits.len(), lines.len());
        let first = misfits.first().map_or_else(String::new, |first| format!(", the first in {first}"));
        let fit = if lines.is_empty() { String::new() } else { of + &first };
        format!(": {OTHERS}{fit}; {}", self.shape.remedy())
    }

    /// That each plant has a start that says it was kept, and each such start its plant.
    fn match_up(&mut self) -> Result<()> {
        // A run that was killed between both files knows plants of the starts that would have come next.
        let known = self.starts.len() as u64;
        let folder = self.folder.display();
        if let Some(member) = self.members.iter().find(|member| member.start >= known + AT_ONCE) {
            return Err(anyhow!(
                "{folder}: {MEMBERS} has a plant of start {}, {STARTS} no such start; {REMEDY}",
                member.start
            ));
        }
        self.members.retain(|member| member.start < known);
        for start in &self.starts {
            let n = self.members.iter().filter(|member| member.start == start.number).count();
            let expected = usize::from(start.refusal.is_none());
            ensure!(
                n == expected,
                "{folder}: start {} has {n} plants in {MEMBERS} and {expected} by {STARTS}; {REMEDY}",
                start.number
            );
        }
        Ok(())
    }

    /// The first start that was not tried.
    pub(super) fn next(&self) -> u64 {
        self.starts.last().map_or(0, |start| start.number + 1)
    }

    /// What is to be done about plants that are no longer met by this program.
    pub(super) fn remedy(&self) -> String {
        self.shape.remedy()
    }

    /// Where the plant of this place stands.
    pub(super) fn place(&self, index: usize) -> String {
        let path = self.folder.join(MEMBERS);
        format!("{}: line {} (start {})", path.display(), index + LINES_BEFORE + 1, self.members[index].start)
    }

    fn head(&self) -> Vec<String> {
        std::iter::once("start")
            .chain(self.shape.ranges.iter().map(|range| range.key.as_str()))
            .map(str::to_owned)
            .collect()
    }

    /// Keeps what came of some starts. Members are written first: a start that is known is known with its member.
    pub(super) fn add(&mut self, found: Vec<(Start, Option<Member>)>) -> Result<()> {
        for (start, member) in found {
            self.starts.push(start);
            self.members.extend(member);
        }
        self.starts.sort_by_key(|start| start.number);
        self.members.sort_by_key(|member| member.start);
        let members = self.members.iter().map(|member| {
            std::iter::once(member.start.to_string()).chain(member.values.iter().map(f64::to_string)).collect()
        });
        self.write(MEMBERS, &self.head(), members)?;
        let starts = self.starts.iter().map(|start| {
            let outcome = start.refusal.map_or(KEPT, Refusal::name);
            let worst = start.worst.map_or_else(String::new, |worst| format!("{worst:.3}"));
            vec![start.number.to_string(), outcome.to_owned(), worst]
        });
        self.write(STARTS, &START_HEAD.map(str::to_owned), starts)
    }

    /// Replaces a table as a whole.
    fn write(&self, name: &str, head: &[String], rows: impl Iterator<Item = Vec<String>>) -> Result<()> {
        let path = self.folder.join(name);
        let words = || path.display().to_string();
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.write_record(head).with_context(words)?;
        for row in rows {
            writer.write_record(&row).with_context(words)?;
        }
        let text = writer.into_inner().map_err(|error| error.into_error()).with_context(words)?;
        let rows = String::from_utf8(text).with_context(words)?;
        kept::replace(&path, seal::sealed(Form::Comment, &self.shape.key, &rows).as_bytes())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shape() -> Shape {
        let range = |key: &str, lower, upper| Range { key: key.to_owned(), lower, upper };
        let ranges = vec![range("a", 0.0, 1e-6), range("b", 0.1, 0.5)];
        Shape { key: "abc".to_owned(), ranges, folders: &[ENSEMBLE, BEYOND] }
    }

    fn kept(number: u64) -> Start {
        Start { number, refusal: None, worst: Some(0.25) }
    }

    fn refused(number: u64) -> Start {
        Start { number, refusal: Some(Refusal::NotMet), worst: None }
    }

    fn member(start: u64) -> Member {
        Member { start, values: vec![1e-7, 0.1 + 0.2] }
    }

    /// Starts 0 to 3, of which 0 and 2 were kept.
    fn written(folder: &Path) {
        let mut store = Store::read(folder, shape()).expect("empty");
        let first = vec![(kept(0), Some(member(0))), (refused(1), None)];
        store.add(first).expect("written");
        store.add(vec![(kept(2), Some(member(2))), (refused(3), None)]).expect("written");
    }

    fn error_after(name: &str, from: &str, to: &str) -> String {
        let folder = tempfile::tempdir().expect("a folder");
        written(folder.path());
        let path = folder.path().join(name);
        let text = std::fs::read_to_string(&path).expect("a table");
        assert!(text.contains(from), "{text}");
        std::fs::write(&path, text.replacen(from, to, 1)).expect("written");
        format!("{:#}", Store::read(folder.path(), shape()).expect_err("a damaged table"))
    }

    fn assert_words(error: &str, words: &[&str]) {
        assert!(words.iter().all(|word| error.contains(word)), "{error}");
        assert!(error.contains("version control"), "what to do: {error}");
    }

    #[test]
    fn a_killed_run_goes_on_and_forgets_a_member_without_its_start() {
        let folder = tempfile::tempdir().expect("a folder");
        written(folder.path());
        let again = Store::read(folder.path(), shape()).expect("read");
        assert_eq!(again.starts, [kept(0), refused(1), kept(2), refused(3)]);
        assert_eq!(again.members, [member(0), member(2)], "to the last bit");
        assert!(again.place(1).ends_with("members.csv: line 4 (start 2)"), "{}", again.place(1));
        // Killed after the members of the next starts.
        let path = folder.path().join(STARTS);
        let before = std::fs::read_to_string(&path).expect("starts");
        let mut store = again;
        store.add(vec![(kept(4), Some(member(4)))]).expect("written");
        std::fs::write(&path, before).expect("written");
        assert_eq!(Store::read(folder.path(), shape()).expect("read").members, [member(0), member(2)]);
    }

    #[test]
    fn rows_of_another_file_are_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        written(folder.path());
        let refuse = |change: fn(&mut Shape), words: &[&str]| {
            let mut other = shape();
            change(&mut other);
            assert_words(&format!("{:#}", Store::read(folder.path(), other).expect_err("another file")), words);
        };
        refuse(|other| other.key = "abd".to_owned(), &["members.csv", "`abc`", "`abd`", "0 of 2 plants"]);
        let narrow = |other: &mut Shape| {
            (other.key, other.ranges[1].upper) = ("abd".to_owned(), 0.2);
        };
        refuse(
            |other| other.key = "abd".to_owned(),
            &["remove all of starts.csv, members.csv, designs.csv, facts.csv, times.csv", "ensemble and", "beyond"],
        );
        refuse(narrow, &["2 of 2 plants", "line 3: `b` is 0.30000000000000004", "0.1 to 0.2"]);
        // Should two files ever have one key.
        refuse(|other| other.ranges[1].upper = 0.2, &["members.csv: line 3 (start 0)", "`b`", "0.1 to 0.2"]);
        refuse(|other| drop(other.ranges.pop()), &["members.csv: line 2", "other columns"]);
    }

    #[test]
    fn damage_is_named_with_file_line_and_column() {
        assert_words(&error_after(MEMBERS, "2,0.0000001,", "2,1e-7x,"), &["members.csv: line 4", "`a`", "`1e-7x`"]);
        assert_words(&error_after(MEMBERS, "2,0.0000001,", "2,"), &["members.csv: line 4", "2 cells, 3"]);
        assert_words(&error_after(MEMBERS, "2,0.0000001,", "2,NaN,"), &["members.csv: line 4", "`a` is NaN"]);
        assert_words(&error_after(MEMBERS, "2,0.0000001,", "2,0.0000002,"), &["members.csv", "changed"]);
        assert_words(&error_after(STARTS, "1,evidence", "1,evidences"), &["starts.csv: line 4", "evidences not met"]);
        assert_words(
            &error_after(STARTS, "0,kept,0.250", "0,kept,x"),
            &["starts.csv: line 3", "worst_residual", "`x`"],
        );
        assert_words(&error_after(STARTS, "1,evidence not met,\n", ""), &["starts.csv: line 4", "2 where 1"]);
        assert_words(&error_after(STARTS, "3,evidence not met,\n", ""), &["starts.csv", "taken out"]);
        assert_words(&error_after(STARTS, "0,kept,0.250", "0,evidence not met,0.250"), &["starts.csv", "changed"]);
        assert_words(&error_after(MEMBERS, "# made from", "# from"), &["members.csv", "line 1"]);
    }
}
