//! The starts that were tried and the plants that were kept, on disk after each: a killed run goes on where it was.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, ensure};

use super::outcome::{Member, Refusal, Start};
use crate::kept;

/// Both tables of a folder.
#[derive(Debug)]
pub(super) struct Store {
    folder: PathBuf,
    keys: Vec<String>,
    /// By number.
    pub(super) starts: Vec<Start>,
    /// By number of their start.
    pub(super) members: Vec<Member>,
}

const KEPT: &str = "kept";

impl Store {
    /// What a folder holds; nothing if there is none yet.
    pub(super) fn read(folder: &Path, keys: Vec<String>) -> Result<Self> {
        let mut store = Self { folder: folder.to_owned(), keys, starts: Vec::new(), members: Vec::new() };
        for row in store.rows("starts.csv", &["start", "outcome", "worst_residual"].map(str::to_owned))? {
            let refusal = match row[1].as_str() {
                KEPT => None,
                words => {
                    let known = Refusal::ALL.into_iter().find(|refusal| refusal.words() == words);
                    Some(known.with_context(|| format!("starts.csv: no outcome `{words}`"))?)
                }
            };
            let worst =
                if row[2].is_empty() { None } else { Some(row[2].parse().context("starts.csv: worst_residual")?) };
            store.starts.push(Start { number: row[0].parse().context("starts.csv: start")?, refusal, worst });
        }
        for row in store.rows("members.csv", &store.head())? {
            let start = row[0].parse().context("members.csv: start")?;
            let values = row[1..].iter().map(|text| text.parse().with_context(|| format!("members.csv: `{text}`")));
            store.members.push(Member { start, values: values.collect::<Result<_>>()? });
        }
        // A run that was killed between both files knows a member whose start it does not know.
        let starts = &store.starts;
        store.members.retain(|member| starts.iter().any(|start| start.number == member.start));
        Ok(store)
    }

    fn head(&self) -> Vec<String> {
        std::iter::once("start".to_owned()).chain(self.keys.iter().cloned()).collect()
    }

    fn rows(&self, name: &str, head: &[String]) -> Result<Vec<Vec<String>>> {
        let path = self.folder.join(name);
        if !path.exists() {
            return Ok(Vec::new());
        }
        let words = || path.display().to_string();
        let mut reader = csv::Reader::from_path(&path).with_context(words)?;
        let found: Vec<String> = reader.headers().with_context(words)?.iter().map(str::to_owned).collect();
        ensure!(
            found == head,
            "{}: other columns than the ranges of today have: remove it to calibrate anew",
            path.display()
        );
        let rows = reader.records().map(|record| Ok(record.with_context(words)?.iter().map(str::to_owned).collect()));
        rows.collect()
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
        self.write("members.csv", &self.head(), members)?;
        let starts = self.starts.iter().map(|start| {
            let outcome = start.refusal.map_or(KEPT, Refusal::words);
            let worst = start.worst.map_or_else(String::new, |worst| format!("{worst:.3}"));
            vec![start.number.to_string(), outcome.to_owned(), worst]
        });
        self.write("starts.csv", &["start", "outcome", "worst_residual"].map(str::to_owned), starts)
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
        kept::replace(&path, &text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_killed_run_goes_on_and_forgets_a_member_without_its_start() {
        let folder = tempfile::tempdir().expect("a folder");
        let keys = || vec!["a".to_owned(), "b".to_owned()];
        let mut store = Store::read(folder.path(), keys()).expect("empty");
        let kept = |number| Start { number, refusal: None, worst: Some(0.25) };
        let member = |start| Member { start, values: vec![1e-7, 0.1 + 0.2] };
        let refused = Start { number: 1, refusal: Some(Refusal::NotMet), worst: None };
        store.add(vec![(kept(2), Some(member(2))), (refused, None)]).expect("written");
        let again = Store::read(folder.path(), keys()).expect("read");
        assert_eq!(again.starts, [refused, kept(2)]);
        assert_eq!(again.members, [member(2)], "to the last bit");
        // Killed after the members.
        let path = folder.path().join("members.csv");
        let text = std::fs::read_to_string(&path).expect("members");
        std::fs::write(&path, text + "3,1,2\n").expect("written");
        assert_eq!(Store::read(folder.path(), keys()).expect("read").members, [member(2)]);
        let error = Store::read(folder.path(), vec!["a".to_owned()]).expect_err("another range");
        assert!(error.to_string().contains("other columns"), "{error}");
    }
}
