//! What was taken from a sheet or a table.

use page::Finding;

use crate::campaign::Imported;
use crate::number::count;
use crate::shell::as_one_word;

/// Results taken, and rows that were known before or are still empty.
pub(crate) fn taken(n: usize, n_failed: usize, n_known: usize, n_empty: usize) -> Vec<Finding> {
    let known = if n_known > 0 { format!(", {n_known} known before") } else { String::new() };
    let failed = match n_failed {
        0 => String::new(),
        1 if n == 1 => ", without a value".to_owned(),
        n_failed if n_failed == n => ", all without a value".to_owned(),
        n_failed => format!(", {n_failed} of them without a value"),
    };
    let taken = Finding::new(format!("Taken: {}{failed}{known}.", count(n, "result")))
        .with("results", n as f64, "1")
        .with("known before", n_known as f64, "1");
    let empty = (n_empty > 0).then(|| {
        let sentence = format!("{} not filled in yet.", count(n_empty, "row"));
        Finding::new(sentence).with("rows not filled in", n_empty as f64, "1")
    });
    std::iter::once(taken).chain(empty).collect()
}

/// That a sheet says nothing of some constraints, because it has no column for them.
pub(crate) fn without_columns(headings: &[String], n: usize, again: &str) -> Finding {
    let named: Vec<String> = headings.iter().map(|heading| format!("`{heading}`")).collect();
    let says = if n == 1 { "says" } else { "say" };
    let [columns, them, they_were, add] = match headings.len() {
        1 => ["column", "it", "it was", "the column"],
        _ => ["columns", "them", "they were", "the columns"],
    };
    let sentence = format!(
        "The sheet has no {columns} {}: {} {says} nothing of {them}. Where {they_were} measured, add {add} and tell the sheet once more: \
         `{again}`.",
        named.join(", "),
        count(n, "result")
    );
    Finding::new(sentence).with("results without it", n as f64, "1")
}

/// What a batch still waits for.
pub(crate) fn outstanding(batch: usize, n: usize) -> Finding {
    let sentence = format!("Batch {batch} waits for {}.", count(n, "more experiment"));
    Finding::new(sentence).with("batch", batch as f64, "1").with("experiments waited for", n as f64, "1")
}

/// Earlier experiments taken, and what they are used for.
pub(crate) fn imported(n: usize, used_for: &str) -> Finding {
    let sentence = format!("Imported: {}. {used_for}", count(n, "experiment"));
    Finding::new(sentence).with("experiments imported", n as f64, "1")
}

/// Experiments of one source with the settings and results of experiments of another: so many.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Twice {
    pub(crate) earlier: String,
    pub(crate) source: String,
    pub(crate) n: usize,
}

impl Twice {
    /// Of experiments from this place on, those with the settings and results of an earlier one from another source: each pair of sources once,
    /// in their order.
    pub(crate) fn among(all: &[Imported], from: usize) -> Vec<Self> {
        let mut found: Vec<Self> = Vec::new();
        for (at, one) in all.iter().enumerate().skip(from) {
            let is_like = |earlier: &&Imported| earlier.source != one.source && earlier.is_alike(one);
            let Some(Imported { source: earlier, .. }) = all[..at].iter().find(is_like) else { continue };
            match found.iter_mut().find(|twice| twice.earlier == *earlier && twice.source == one.source) {
                Some(twice) => twice.n += 1,
                None => found.push(Self { earlier: earlier.clone(), source: one.source.clone(), n: 1 }),
            }
        }
        found
    }

    /// "6 rows from `copy` have settings and results of others from `notebook`, and count as runs of their own".
    fn in_words(&self, what: &str) -> String {
        let Self { earlier, source, n } = self;
        let (have, count_as) = match n {
            1 => ("has", "counts as a run of its own"),
            _ => ("have", "count as runs of their own"),
        };
        format!(
            "{} from `{source}` {have} settings and results of others from `{earlier}`, and {count_as}",
            count(*n, what)
        )
    }

    fn withdraw(&self) -> String {
        let Self { earlier, source, .. } = self;
        let [source, earlier] = [source, earlier].map(|name| as_one_word(name));
        format!("`infuse import --withdraw {source}` or `infuse import --withdraw {earlier}`")
    }
}

/// So many pairs of sources are named.
const MOST_PAIRS: usize = 5;

/// A sentence for each pair of sources, the first few of many.
fn of_each_pair(twice: &[Twice], said: impl Fn(&Twice) -> Finding) -> Vec<Finding> {
    let n_more = twice.len().saturating_sub(MOST_PAIRS);
    let more = (n_more > 0).then(|| {
        let pairs = if n_more == 1 { "1 more pair".to_owned() } else { format!("{n_more} more pairs") };
        Finding::new(format!("The same holds of {pairs} of sources."))
    });
    twice.iter().take(MOST_PAIRS).map(said).chain(more).collect()
}

/// Rows that are like ones from another source, which may be the same runs.
pub(crate) fn as_from_elsewhere(twice: &[Twice]) -> Vec<Finding> {
    of_each_pair(twice, |one| {
        let sentence = format!(
            "{}. If they are the same runs, take one of the two back, with all that is from it: {}.",
            one.in_words("row"),
            one.withdraw()
        );
        Finding::new(sentence).with("rows as from elsewhere", one.n as f64, "1")
    })
}

/// That experiments from two sources have the same settings and results, which may be the same runs.
pub(crate) fn there_twice(twice: &[Twice]) -> Vec<Finding> {
    of_each_pair(twice, |one| {
        let sentence = format!(
            "Careful: {}: if they are the same runs, the noise seems smaller than it is. One of the two is taken back, with all that is \
             from it, by {}.",
            one.in_words("experiment"),
            one.withdraw()
        );
        Finding::new(sentence).with("experiments that are there twice", one.n as f64, "1")
    })
}

/// Earlier experiments that count no longer.
pub(crate) fn withdrawn(n: usize) -> Finding {
    let sentence = format!("Withdrawn: {}. Batches that rest on them stand.", count(n, "experiment"));
    Finding::new(sentence).with("experiments withdrawn", n as f64, "1")
}
