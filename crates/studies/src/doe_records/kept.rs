//! What searches found, kept with the sources: a check searches for some of it anew.
//!
//! Whoever runs the study searches for all of it.

use std::path::Path;

use anyhow::{Result, ensure};
use doe::Found;

use super::file::Record;
use super::searches::Search;
use crate::costs::key::Key;
use crate::kept::{KeptFile, SAMPLE_OF_LONG};

const FILE: &str = "fixtures/doe/searches.tsv";
const REMEDY: &str = "take it back from version control, or remove it and run `cargo xtask doe-records`";

/// All kinds, and in each all searches; so their lines stand.
pub(super) fn kinds(record: &Record) -> [Vec<Search>; 4] {
    [Search::again(record), Search::over_grid(), Search::over_lists(), Search::large()]
}

/// The file, and what it must be made from: what is searched for and how hard, and the functions of this platform that searches use.
pub(super) fn file(root: &Path, kinds: &[Vec<Search>]) -> KeptFile {
    let mut key = Key::default();
    for search in kinds.iter().flatten() {
        key = key.with(search.name()).with(format!("{:?}", search.settings()));
    }
    for x in (1..=32_u32).map(|k| f64::from(k) / 7.0) {
        key = [x.ln(), x.exp()].into_iter().fold(key, |key, value| key.with(value.to_le_bytes()));
    }
    KeptFile { path: root.join(FILE), key: key.name(), remedy: REMEDY }
}

/// What is kept of a search: starts, efficiency, and a name for the design.
pub(super) fn line(search: Search, found: &Found) -> String {
    let design = found.design.runs().flatten().fold(Key::default(), |key, x| key.with(x.to_le_bytes()));
    let (starts, percent) = (found.report.starts, found.efficiency.percent);
    format!("{}\t{starts} starts\t{percent} %\t{}", search.name(), design.name())
}

/// That a sample of each kind of search finds what is kept, the same bit for bit. Where nothing is kept of these searches all of them are
/// run, and there is nothing to hold them against.
pub(super) fn check(file: &KeptFile, kinds: &[Vec<Search>]) -> Result<()> {
    let Some(rows) = file.rows()? else {
        for search in kinds.iter().flatten() {
            search.run()?;
        }
        file.warn(kinds.iter().map(Vec::len).sum(), "searches");
        return Ok(());
    };
    let mut lines = rows.lines();
    for searches in kinds {
        for (number, search) in searches.iter().enumerate() {
            let kept = lines.next().unwrap_or_default().to_owned();
            if number % SAMPLE_OF_LONG == 0 {
                file.ensure_same("a search", &kept, &line(*search, &search.run()?))?;
            }
        }
    }
    ensure!(lines.next().is_none(), "{}: it has more searches than the study; {REMEDY}", file.path.display());
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Searches of a millisecond.
    fn kinds() -> Vec<Vec<Search>> {
        let again = |runs| Search::Again((1, runs), 80.0);
        vec![(3..15).map(again).collect(), vec![Search::Again((2, 6), 74.0)]]
    }

    fn kept(folder: &Path) -> (KeptFile, String) {
        let found = |search: &Search| line(*search, &search.run().expect("a design")) + "\n";
        let file = file(folder, &kinds());
        (file, kinds().iter().flatten().map(found).collect())
    }

    #[test]
    fn searches_that_find_something_else_are_noticed() {
        let folder = tempfile::tempdir().expect("a folder");
        let (file, rows) = kept(folder.path());
        file.write(&rows).expect("written");
        check(&file, &kinds()).expect("the same");
        let lines: Vec<&str> = rows.lines().collect();
        let refused = |number: usize, to: &str| {
            let changed: String = lines
                .iter()
                .enumerate()
                .map(|(k, line)| format!("{}\n", if k == number { to } else { line }))
                .collect();
            file.write(&changed).expect("written");
            check(&file, &kinds()).err().map(|error| error.to_string())
        };
        // The first and the eleventh of the first kind, and the first of the second.
        for number in [0, 10, 12] {
            let (line, design) = lines[number].rsplit_once('\t').expect("a design");
            for to in [lines[number].replace("16 starts", "17 starts"), format!("{line}\t0{design}")] {
                let error = refused(number, &to).expect("it was changed");
                assert!(error.contains("searches.tsv") && error.contains("this program finds"), "{error}");
            }
        }
        assert_eq!(refused(1, "what nobody looks at"), None);
        file.write(&format!("{rows}one more\n")).expect("written");
        let error = check(&file, &kinds()).expect_err("one too many").to_string();
        assert!(error.contains("more searches than the study"), "{error}");
    }

    #[test]
    fn key_follows_from_what_is_searched_for_and_how_hard() {
        let root = Path::new(".");
        let key = |kinds: &[Vec<Search>]| file(root, kinds).key;
        let base = key(&kinds());
        assert_eq!(base, key(&kinds()));
        for other in
            [Search::Again((2, 6), 74.5), Search::Again((2, 7), 74.0), Search::Large((2, 6)), Search::OverList(6)]
        {
            assert_ne!(base, key(&[kinds()[0].clone(), vec![other]]), "{other:?}");
        }
    }
}
