//! The page from equation number to code: made of the marks `Source: (n)` in the documentation of the code.

use std::collections::BTreeMap;

use super::source::{Word, words};

/// Where the page is.
pub(super) const PAGE: &str = "docs/equations.md";

/// The last numbered equation of the dissertation.
const LAST: u32 = 61;

/// Equations that no code computes, and why.
const NOT_IN_CODE: &[(u32, &str)] = &[
    (48, "a step of the proof from (47) to (49)"),
    (49, "the exact error after n batches; `infuse::convergence::Bound` sums the magnitudes of its terms"),
    (50, "(49) in the limit, which the bound does not need: it holds at every n"),
    (51, "the remainder of (49) cut in two; the bound takes its sum whole"),
    (52, "an upper limit of the remainder that is wider than its sum"),
    (53, "the same, the geometric series added up"),
    (54, "the same in the limit"),
];

/// An item that an equation has its home in.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Home {
    /// From the root.
    file: String,
    line: usize,
    item: String,
    /// The first sentence of its documentation.
    what: String,
}

/// Complaints about equations without a home.
pub(super) fn complaints(files: &[(String, String)]) -> Vec<String> {
    let homes = homes(files);
    let reason = |number: &u32| NOT_IN_CODE.iter().any(|(without, _)| without == number);
    let lost = (1..=LAST).filter(|number| !homes.contains_key(number) && !reason(number));
    let lost =
        lost.map(|number| format!("equation ({number}) has no home: no documentation says `Source: ({number})`"));
    let both = homes.keys().filter(|number| reason(number));
    let both = both.map(|number| format!("equation ({number}) has a home and is listed as not in code"));
    let unknown = homes.keys().filter(|number| !(1..=LAST).contains(*number));
    let unknown = unknown.map(|number| format!("equation ({number}) does not exist"));
    lost.chain(both).chain(unknown).collect()
}

/// The page, from the names from the root and the texts of all sources.
pub(super) fn page(files: &[(String, String)]) -> String {
    let homes = homes(files);
    let mut page = "# From equation to code\n\n\
        Every numbered equation of the dissertation, with the items that compute it.\n\
        This page is made by `cargo xtask equations` from the marks `Source: (n)` in the documentation of the code.\n\n\
        | equation | item | what it gives |\n|---|---|---|\n"
        .to_owned();
    for (number, homes) in &homes {
        for home in homes {
            let Home { file, line, item, what } = home;
            page += &format!("| ({number}) | [`{item}`](../{file}#L{line}) in `{file}` | {what} |\n");
        }
    }
    if !NOT_IN_CODE.is_empty() {
        page += "\n## Not in code\n\n";
        for (number, why) in NOT_IN_CODE {
            page += &format!("- ({number}): {why}\n");
        }
    }
    page
}

fn homes(files: &[(String, String)]) -> BTreeMap<u32, Vec<Home>> {
    let mut homes: BTreeMap<u32, Vec<Home>> = BTreeMap::new();
    for (file, text) in files {
        let lines: Vec<&str> = text.lines().collect();
        for (at, line) in lines.iter().enumerate() {
            let numbers = marked(line);
            if numbers.is_empty() {
                continue;
            }
            let home = home(file, &lines, at);
            for number in numbers {
                homes.entry(number).or_default().push(home.clone());
            }
        }
    }
    homes
}

/// The numbers after `Source:` in a line of documentation: `(4)`, `(10), (11)` or `(10)–(12)`.
fn marked(line: &str) -> Vec<u32> {
    let line = line.trim_start();
    let is_documentation = line.starts_with("///") || line.starts_with("//!");
    let Some((_, marks)) = line.split_once("Source: ").filter(|_| is_documentation) else {
        return Vec::new();
    };
    let mut numbers: Vec<u32> = Vec::new();
    let mut rest = marks;
    let mut is_range = false;
    while let Some((number, after)) = rest
        .strip_prefix('(')
        .and_then(|inner| inner.split_once(')'))
        .and_then(|(n, after)| Some((n.parse().ok()?, after)))
    {
        match numbers.last().filter(|_| is_range) {
            Some(&last) => numbers.extend(last + 1..=number),
            None => numbers.push(number),
        }
        let separators = [(", ", false), (" and ", false), ("–", true), (" to ", true)];
        let Some((next, range)) = separators.iter().find_map(|(sign, range)| Some((after.strip_prefix(sign)?, *range)))
        else {
            break;
        };
        (rest, is_range) = (next, range);
    }
    numbers
}

/// The item below the documentation around line `at`.
fn home(file: &str, lines: &[&str], at: usize) -> Home {
    let is_documentation = |line: &str| line.trim_start().starts_with("///");
    let of_file = lines[at].trim_start().starts_with("//!");
    let first = (0..at).rev().take_while(|&k| is_documentation(lines[k])).last().unwrap_or(at);
    let first = if of_file { 0 } else { first };
    let what = sentence(lines[first..].iter().map(|line| line.trim_start().trim_start_matches(['/', '!'])));
    let below = lines.iter().enumerate().skip(at + 1);
    let mut below = below.filter(|(_, line)| {
        let line = line.trim_start();
        !(line.starts_with("///") || line.starts_with('#') || line.is_empty())
    });
    let (line, item) = match below.next() {
        Some((line, text)) if !of_file => (line + 1, name(text)),
        _ => (1, file.rsplit('/').next().unwrap_or(file).to_owned()),
    };
    Home { file: file.to_owned(), line, item, what }
}

/// Up to the first full stop, without what would end a cell of a table.
fn sentence<'a>(lines: impl Iterator<Item = &'a str>) -> String {
    let mut text = String::new();
    for line in lines.map(str::trim).take_while(|line| !line.is_empty()) {
        text = if text.is_empty() { line.to_owned() } else { format!("{text} {line}") };
        if let Some(end) = text.find(". ").or_else(|| text.ends_with('.').then(|| text.len() - 1)) {
            text.truncate(end);
            break;
        }
    }
    text.replace('|', "\\|").replace(['[', ']'], "")
}

/// The name of the item that a line declares.
fn name(line: &str) -> String {
    const BEFORE: &[&str] = &["const", "enum", "fn", "mod", "static", "struct", "trait", "type"];
    let words = words(line);
    let declared = words.windows(2).find_map(|pair| match pair {
        [Word::Name(kind), Word::Name(name)] if BEFORE.contains(&kind.as_str()) && name != "fn" => Some(name.clone()),
        _ => None,
    });
    let first = words.iter().find_map(|word| match word {
        Word::Name(name) if name != "pub" && name != "crate" => Some(name.clone()),
        _ => None,
    });
    declared.or(first).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_are_read_as_they_are_written() {
        assert_eq!(marked("/// Source: (4), rows of Phi."), [4]);
        assert_eq!(marked("    /// Rates. Source: (10), (12) and (14)."), [10, 12, 14]);
        assert_eq!(marked("/// Source: (10)–(12); the split."), [10, 11, 12]);
        assert!(marked("/// Source: beyond the text.").is_empty(), "no number");
        assert!(marked("let source = \"Source: (4)\";").is_empty(), "no documentation");
    }

    #[test]
    fn a_mark_belongs_to_the_item_below_it() {
        let text = "//! File.\n\n/// What it gives. More.\n///\n/// Source: (1)–(3).\n#[must_use]\npub const fn f(x: f64) -> f64 {\n";
        let homes = homes(&[("a/src/b.rs".to_owned(), text.to_owned())]);
        let home = Home { file: "a/src/b.rs".into(), line: 7, item: "f".into(), what: "What it gives".into() };
        assert_eq!(homes.keys().copied().collect::<Vec<_>>(), [1, 2, 3]);
        assert_eq!(homes[&2], [home]);
        assert_eq!(name("    AsPrinted36,"), "AsPrinted36");
    }
}
