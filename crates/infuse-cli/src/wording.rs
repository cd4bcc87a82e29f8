//! What a parser says about a file, in the words of those who wrote it.

use std::io;

use crate::echo::echo;

/// What a program expects, and what that means.
const WORDS: [(&str, &str); 7] = [
    ("u8", "a whole number from 0 to 255"),
    ("f64", "a number"),
    ("a boolean", "true or false"),
    ("path string", "the name of a file in quotes"),
    ("a string", "a text in quotes"),
    ("a map", "a table, like { name = 1 }"),
    ("string or table", "a name in quotes"),
];
/// How a program calls whole numbers that are not negative.
const COUNTS: [&str; 3] = ["u32", "u64", "usize"];
/// The least of these that is of use, where it is not 0.
const LEAST: [(&str, u32); 9] = [
    ("experiments", 1),
    ("batches", 1),
    ("plants", 1),
    ("drop_from", 1),
    ("jobs", 1),
    ("tries", 1),
    ("runs_per_task", 1),
    ("simulations", 2),
    ("levels", 2),
];
/// How a program begins to say what it found.
const FOUND: [(&str, &str); 9] = [
    ("invalid type: floating point ", ""),
    ("invalid type: integer ", ""),
    ("invalid type: boolean ", ""),
    ("invalid type: string ", ""),
    ("invalid type: sequence", "a list"),
    ("invalid type: map", "a table"),
    ("invalid value: integer ", ""),
    ("invalid value: string ", ""),
    ("unknown variant ", ""),
];
/// Of a line so many characters are shown.
const LONGEST: usize = 160;

/// "a, b and c".
pub(crate) fn all_of(names: &[String]) -> String {
    match names {
        [] => String::new(),
        [one] => one.clone(),
        [before @ .., last] => format!("{} and {last}", before.join(", ")),
    }
}

/// The place of the name that this is, or else of the only one that differs from it in case alone.
pub(crate) fn place_in_any_case<'a>(names: impl Iterator<Item = &'a str> + Clone, name: &str) -> Option<usize> {
    let exact = names.clone().position(|other| other == name);
    exact.or_else(|| {
        let name = name.to_lowercase();
        let mut alike = names.enumerate().filter(|(_, other)| other.to_lowercase() == name);
        alike.next().filter(|_| alike.next().is_none()).map(|(place, _)| place)
    })
}

/// An error and its causes in one line, those of the system without the number that it gives them.
pub(crate) fn of_error(error: &anyhow::Error) -> String {
    let causes = error.chain().map(|cause| match cause.downcast_ref::<io::Error>() {
        Some(of_system) => of_the_system(of_system),
        None => cause.to_string(),
    });
    causes.collect::<Vec<_>>().join(": ")
}

/// What the system says of a file.
fn of_the_system(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::NotFound => "there is none of that name".to_owned(),
        _ => {
            let said = error.to_string();
            said.split_once(" (os error ").map_or_else(|| said.clone(), |(said, _)| said.to_owned())
        }
    }
}

/// A key of a file, and what stands there as its value or in it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Entry<'a> {
    key: &'a str,
    value: &'a str,
    /// Whether it is one of several in a list.
    is_listed: bool,
}

impl<'a> Entry<'a> {
    /// What stands in these bytes of a file, if it is a value on the line of its key.
    pub(crate) fn at(text: &'a str, span: std::ops::Range<usize>) -> Option<Self> {
        let value = text.get(span.clone())?.trim();
        let line = text.get(..span.start)?.rsplit('\n').next()?;
        let (key, between) = line.split_once('=')?;
        // In a table on one line the key is the last one.
        let (key, between) = match between.trim_start().starts_with('{') {
            true => {
                let (before, between) = line.rsplit_once('=')?;
                (before.rsplit(['{', ',']).next()?, between)
            }
            false => (key, between),
        };
        let key = key.trim().trim_matches('"');
        let is_named = !key.is_empty() && !value.is_empty() && !value.contains('\n');
        is_named.then_some(Self { key, value, is_listed: between.contains('[') })
    }

    fn has(self) -> String {
        let Self { key, value, is_listed } = self;
        format!("`{key}` {} {}", if is_listed { "has" } else { "is" }, echo(value))
    }
}

/// The message without names of a program, and with no line that nobody would read. What is allowed is never cut.
pub(crate) fn in_plain_words(message: &str, of: Option<Entry<'_>>) -> String {
    let message = message.trim_end();
    // What is wrong stands on the last line; the lines before it show the file.
    let (before, last) = message.rsplit_once('\n').map_or(("", message), |(before, last)| (before, last));
    let last = fault(last, of);
    let before: String = before.lines().map(|line| format!("{}\n", cut(line))).collect();
    format!("{before}{last}")
}

fn cut(line: &str) -> String {
    match line.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}...", &line[..end]),
        None => line.to_owned(),
    }
}

/// What is wrong: what was found, and what is allowed.
fn fault(said: &str, of: Option<Entry<'_>>) -> String {
    let (found, expected) = match said.rsplit_once(", expected ") {
        Some(parts) => parts,
        None => match said.strip_prefix("expected ").or_else(|| said.strip_prefix("wanted ")) {
            Some(expected) => ("", expected),
            None => return cut(said),
        },
    };
    let their_word = FOUND.iter().find_map(|(theirs, ours)| Some((found.strip_prefix(theirs)?, *ours)));
    let expected = allowed(expected, of.map_or("", |of| of.key));
    match (their_word, of) {
        (Some(_), Some(of)) => format!("{}, expected {expected}", of.has()),
        (None, Some(of)) if found.is_empty() => format!("{}, expected {expected}", of.has()),
        (Some((value, ours)), None) => format!("it is {ours}{}, expected {expected}", cut(value)),
        (None, None) if found.is_empty() => format!("expected {expected}"),
        (None, _) => format!("{}, expected {expected}", cut(found)),
    }
}

/// What is allowed of a key.
fn allowed(expected: &str, key: &str) -> String {
    if COUNTS.contains(&expected) {
        let least = LEAST.iter().find(|(name, _)| *name == key).map_or(0, |(_, least)| *least);
        let most = if expected == "u32" { format!("to {}", u32::MAX) } else { "on".to_owned() };
        return format!("a whole number from {least} {most}");
    }
    if expected == "a sequence" {
        let like = if key == "choices" { "[\"round\", \"flat\"]" } else { "[\"program\", \"argument\"]" };
        return format!("a list, like {like}");
    }
    WORDS.iter().find(|(theirs, _)| *theirs == expected).map_or(expected, |(_, ours)| *ours).to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_types_are_put_into_words_and_long_lines_cut() {
        let message = "TOML parse error at line 6, column 8\n  |\n6 | seed = -1\n  |        ^^\ninvalid value: integer `-1`, expected u64\n";
        let said = in_plain_words(message, None);
        assert!(said.ends_with("\nit is `-1`, expected a whole number from 0 on"), "{said}");
        assert!(said.contains("6 | seed = -1"), "{said}");
        let long = "z".repeat(10_000_000);
        assert!(in_plain_words(&format!("x\n{long}\ny"), None).len() < 200);
        assert!(in_plain_words(&format!("unknown field `{long}`, expected `b`"), None).ends_with("..., expected `b`"));
        assert_eq!(in_plain_words("unknown field `a`, expected `b`", None), "unknown field `a`, expected `b`");
    }

    #[test]
    fn the_key_and_its_value_are_found_on_their_line() {
        let entry = |text: &str, value: &str| {
            let start = text.find(value).expect("it is there");
            Entry::at(text, start..start + value.len()).map(Entry::has)
        };
        assert_eq!(entry("a = 1\nseed = -1\n", "-1").as_deref(), Some("`seed` is -1"));
        assert_eq!(entry("command = [\"a=b\", 3]", "3").as_deref(), Some("`command` has 3"));
        assert_eq!(entry("sum = { \"damper gain\" = \"x\" }", "\"x\"").as_deref(), Some("`damper gain` is \"x\""));
        assert_eq!(entry("command = [\n  3,\n]", "3"), None, "the key stands on another line");
        assert_eq!(entry("[stop.smooth]\n", "[stop.smooth]"), None);
    }
}
