//! The first line of a file of results: what its rows were made from, and the sum of what the program wrote below.
//!
//! Rows of another file, and rows that a hand or a disk has changed, are refused when they are read, never used in silence.

use std::path::Path;

use anyhow::{Context as _, Result, ensure};

use crate::costs::key::Key;

/// Drops entries by their keys, `SECTION.NAME` each, of those keys that begin with `before`.
pub(crate) fn drop_entries(table: &mut toml::Table, before: &str, keys: &[String]) {
    for key in keys.iter().filter_map(|key| key.strip_prefix(before)) {
        let mut path: Vec<&str> = key.split('.').collect();
        let last = path.pop().unwrap_or_default();
        let section = path.iter().try_fold(&mut *table, |table, name| table.get_mut(*name)?.as_table_mut());
        section.and_then(|section| section.remove(last));
    }
}

/// How the line is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Form {
    /// `# made from KEY, sum SUM`, above a table.
    Comment,
    /// `{"made_from":"KEY","sum":"SUM"}`, above lines of JSON.
    Json,
}

impl Form {
    /// What stands before, between and after key and sum.
    const fn words(self) -> [&'static str; 3] {
        match self {
            Self::Comment => ["# made from ", ", sum ", ""],
            Self::Json => ["{\"made_from\":\"", "\",\"sum\":\"", "\"}"],
        }
    }

    fn line(self, key: &str, rows: &str) -> String {
        let [before, between, after] = self.words();
        format!("{before}{key}{between}{}{after}", sum(rows))
    }

    fn key_and_sum(self, line: &str) -> Option<(&str, &str)> {
        let [before, between, after] = self.words();
        line.strip_prefix(before)?.strip_suffix(after)?.split_once(between)
    }
}

/// The sum of a text: 16 letters.
pub(crate) fn sum(text: &str) -> String {
    Key::default().with(text).name()
}

/// Rows below their first line.
pub(crate) fn sealed(form: Form, key: &str, rows: &str) -> String {
    format!("{}\n{rows}", form.line(key, rows))
}

/// Rows as they were found.
#[derive(Debug)]
pub(crate) struct Opened<'a> {
    pub(crate) rows: &'a str,
    /// What they say they were made from.
    key: &'a str,
    sum: &'a str,
}

/// Takes the first line off a text; `remedy` follows where it has none.
pub(crate) fn open<'a>(path: &Path, form: Form, text: &'a str, key: &str, remedy: &str) -> Result<Opened<'a>> {
    let (line, rows) = text.split_once('\n').unwrap_or((text, ""));
    let words = || {
        format!(
            "{}: line 1 does not say what the rows were made from: of these rows and today's files it would be `{}`; {remedy}",
            path.display(),
            form.line(key, if form.key_and_sum(line).is_some() { rows } else { text })
        )
    };
    let (key, sum) = form.key_and_sum(line).with_context(words)?;
    Ok(Opened { rows, key, sum })
}

impl Opened<'_> {
    /// That they were made from what `key` names; `words` follow where they were not.
    pub(crate) fn check_key(&self, path: &Path, key: &str, words: impl FnOnce() -> String) -> Result<()> {
        ensure!(
            self.key == key,
            "{}: its rows were made from `{}`, today's files are `{key}`{}",
            path.display(),
            self.key,
            words()
        );
        Ok(())
    }

    /// That they are what the program wrote; `remedy` follows where they are not.
    pub(crate) fn check_sum(&self, path: &Path, remedy: &str) -> Result<()> {
        ensure!(
            self.sum == sum(self.rows),
            "{}: its rows are not what the program wrote: some were changed, added or taken out; {remedy}",
            path.display()
        );
        Ok(())
    }
}

/// Copies of files of `fixtures/bat` in a folder of their own, for what a change in one of them does to a key.
#[cfg(test)]
#[derive(Debug)]
pub(crate) struct Copies(tempfile::TempDir);

#[cfg(test)]
impl Copies {
    pub(crate) fn of(names: &[&str]) -> Self {
        let copies = Self(tempfile::tempdir().expect("a folder"));
        let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        for name in names.iter().map(|name| Path::new(BAT).join(name)) {
            let folder = name.parent().map(|folder| copies.root().join(folder));
            folder.map(std::fs::create_dir_all).transpose().expect("a folder");
            std::fs::copy(fixtures.join(&name), copies.root().join(&name)).expect("a copy");
        }
        copies
    }

    /// What stands in for the folder of the workspace.
    pub(crate) fn root(&self) -> &Path {
        self.0.path()
    }

    /// What is read with `to` in place of `from`, which has to be there; then the file is as before.
    pub(crate) fn with<T>(&self, name: &str, [from, to]: [&str; 2], read: impl Fn() -> T) -> T {
        let path = self.root().join(BAT).join(name);
        let text = std::fs::read_to_string(&path).expect("a file");
        assert!(text.contains(from), "{name} has no {from}");
        std::fs::write(&path, text.replacen(from, to, 1)).expect("written");
        let found = read();
        std::fs::write(&path, text).expect("written");
        found
    }
}

#[cfg(test)]
const BAT: &str = "fixtures/bat";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_those_that_were_sealed() {
        let path = Path::new("a.csv");
        for form in [Form::Comment, Form::Json] {
            let text = sealed(form, "abc", "a,b\n1,2\n");
            let opened = open(path, form, &text, "abc", "again").expect("a first line");
            assert_eq!(opened.rows, "a,b\n1,2\n");
            opened.check_key(path, "abc", String::new).expect("its key");
            opened.check_sum(path, "again").expect("its sum");
            let error = opened.check_key(path, "abd", || ": remove it".to_owned()).expect_err("another key");
            assert_eq!(error.to_string(), "a.csv: its rows were made from `abc`, today's files are `abd`: remove it");
            let changed = text.replace("1,2", "1,3");
            let opened = open(path, form, &changed, "abc", "again").expect("a first line");
            let error = opened.check_sum(path, "run it again").expect_err("a digit").to_string();
            assert!(error.contains("a.csv") && error.contains("run it again"), "{error}");
            let error = open(path, form, "a,b\n1,2\n", "abc", "again").expect_err("no first line").to_string();
            assert!(error.contains(&form.line("abc", "a,b\n1,2\n")), "{error}");
        }
    }
}
