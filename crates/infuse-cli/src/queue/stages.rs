//! How far the runs of a queue are, by the files that they write: nobody else is asked.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use super::runs::Runs;
use super::task::Key;
use crate::journal::Submitted;

/// Runs without a result in the journal, counted by what is known of each; what is left of them waits.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Stages {
    /// Their result is there, to be taken.
    pub(crate) n_ended: usize,
    /// They have begun; whether they go on, the scheduler knows.
    pub(crate) n_begun: usize,
    /// Their last submission was stopped by `infuse cancel`.
    pub(crate) n_stopped: usize,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Stage {
    Waiting,
    Stopped,
    Begun,
    Ended,
}

/// Of the runs of `submitted` that are waited for; where a run was submitted by two batches, the further of the two counts.
pub(crate) fn stages<'a>(
    folder: &Path,
    submitted: impl Iterator<Item = &'a Submitted>,
    is_waited_for: impl Fn(Key) -> bool,
) -> Stages {
    // Of every batch its last submission: the numbers of its runs are those of the first.
    let last: BTreeMap<&str, &Submitted> = submitted.map(|one| (one.name.batch.as_str(), one)).collect();
    let mut found: BTreeMap<Key, Stage> = BTreeMap::new();
    for (stem, one) in last {
        let runs = Runs::of(folder, stem);
        let is_stopped = runs.was_stopped(&one.name.to_string());
        let (done, begun) = runs.numbers_done_and_begun();
        for (number, key) in (1..).zip(Key::of(one)).filter(|(_, key)| is_waited_for(*key)) {
            let stage = match () {
                () if done.contains(&number) => Stage::Ended,
                () if is_stopped => Stage::Stopped,
                () if begun.contains(&number) => Stage::Begun,
                () => Stage::Waiting,
            };
            let known = found.entry(key).or_insert(stage);
            *known = stage.max(*known);
        }
    }
    let n = |stage: Stage| found.values().filter(|one| **one == stage).count();
    Stages { n_ended: n(Stage::Ended), n_begun: n(Stage::Begun), n_stopped: n(Stage::Stopped) }
}

impl Runs {
    /// The runs that have left a result, and those that have left anything.
    fn numbers_done_and_begun(&self) -> (BTreeSet<usize>, BTreeSet<usize>) {
        let entries = std::fs::read_dir(self.path()).into_iter().flatten().flatten();
        let (mut done, mut begun) = (BTreeSet::new(), BTreeSet::new());
        for name in entries.filter_map(|entry| entry.file_name().into_string().ok()) {
            let Some((number, kind)) = name.split_once('.') else { continue };
            let Ok(number) = number.parse::<usize>() else { continue };
            match kind {
                "sh" | "in" => continue,
                "done" => done.insert(number),
                _ => begun.insert(number),
            };
        }
        (done, begun)
    }
}
