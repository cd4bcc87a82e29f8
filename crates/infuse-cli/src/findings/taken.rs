//! What was taken from a sheet or a table.

use page::Finding;

use crate::number::count;

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

/// Rows that are like ones from another source, which may be the same runs.
pub(crate) fn as_from_elsewhere(n: usize, earlier: &str, source: &str) -> Finding {
    let are = if n == 1 { "has" } else { "have" };
    let sentence = format!(
        "{} {are} settings and results that were imported before, from `{earlier}`, and count as runs of their own. If they are \
         the same runs: `infuse import --withdraw \"{source}\"`.",
        count(n, "row")
    );
    Finding::new(sentence).with("rows as from elsewhere", n as f64, "1")
}

/// That experiments from two sources have the same settings and results, which may be the same runs.
pub(crate) fn there_twice(n: usize, earlier: &str, source: &str) -> Finding {
    let sentence = format!(
        "Careful: {} from `{source}` {} settings and results of others from `{earlier}`, and {} as runs of their own: if they are the \
         same runs, the noise seems smaller than it is, and `infuse import --withdraw \"{source}\"` takes them back.",
        count(n, "experiment"),
        if n == 1 { "has" } else { "have" },
        if n == 1 { "counts" } else { "count" }
    );
    Finding::new(sentence).with("experiments that are there twice", n as f64, "1")
}

/// Earlier experiments that count no longer.
pub(crate) fn withdrawn(n: usize) -> Finding {
    let sentence = format!("Withdrawn: {}. Batches that rest on them stand.", count(n, "experiment"));
    Finding::new(sentence).with("experiments withdrawn", n as f64, "1")
}
