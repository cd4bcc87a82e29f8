//! What of a file decides what follows from it: its numbers, not its words.

use std::path::Path;

use anyhow::{Context as _, Result};

/// What a file decides of what is made from it: neither its words nor what stands under `others` at the top.
pub(crate) fn decisive(path: &Path, others: &[&str]) -> Result<toml::Table> {
    let text = std::fs::read_to_string(path).with_context(|| path.display().to_string())?;
    of_text(&text, others).with_context(|| path.display().to_string())
}

fn of_text(text: &str, others: &[&str]) -> Result<toml::Table> {
    let mut table: toml::Table = text.parse()?;
    others.iter().for_each(|key| drop(table.remove(*key)));
    drop_words(&mut table);
    Ok(table)
}

/// Keys whose words decide nothing.
const WORDS: [&str; 5] = ["title", "label", "reason", "source", "provenance"];

fn drop_words(table: &mut toml::Table) {
    WORDS.iter().for_each(|key| drop(table.remove(*key)));
    for (_, value) in table.iter_mut() {
        drop_words_within(value);
    }
}

fn drop_words_within(value: &mut toml::Value) {
    match value {
        toml::Value::Table(table) => drop_words(table),
        toml::Value::Array(values) => values.iter_mut().for_each(drop_words_within),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Comments, reasons and what is named beside do not count; numbers do.
    #[test]
    fn words_decide_nothing() {
        let text = |lower: &str, reason: &str, members: &str| {
            format!("# why\nmembers = {members}\n[[free]]\nkey = \"a\"\nlower = {lower}\nreason = \"{reason}\"\n")
        };
        let of = |text: String| of_text(&text, &["members"]).expect("a table").to_string();
        assert_eq!(of(text("1.0", "old", "3")), of(text("1.0", "new", "4")));
        assert_ne!(of(text("1.0", "old", "3")), of(text("1.5", "old", "3")));
    }
}
