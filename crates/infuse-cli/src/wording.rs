//! What a parser says about a file, in the words of those who wrote it.

/// Names that are a program's, and what they mean.
const WORDS: [(&str, &str); 16] = [
    ("expected u64", "expected a whole number from 0"),
    ("expected u32", "expected a whole number from 0"),
    ("expected u8", "expected a whole number from 0 to 255"),
    ("expected usize", "expected a whole number from 0"),
    ("expected f64", "expected a number"),
    ("expected path string", "expected the name of a file in quotes"),
    ("expected a string", "expected a text in quotes"),
    ("expected a sequence", "expected a list, like [\"program\", \"argument\"]"),
    ("wanted string or table", "expected a name in quotes"),
    ("invalid type: floating point ", "it is "),
    ("invalid type: integer ", "it is "),
    ("invalid type: boolean ", "it is "),
    ("invalid type: string ", "it is "),
    ("invalid type: sequence", "it is a list"),
    ("invalid type: map", "it is a table"),
    ("invalid value: integer ", "it is "),
];
/// Of a line so many characters are shown.
const LONGEST: usize = 160;

/// The message without names of a program, and with no line that nobody would read.
pub(crate) fn in_plain_words(message: &str) -> String {
    let short = |line: &str| match line.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}...", &line[..end]),
        None => line.to_owned(),
    };
    let message = message.trim_end().lines().map(short).collect::<Vec<_>>().join("\n");
    // What is wrong stands on the last line; the lines before it show the file.
    let (before, last) = message.rsplit_once('\n').map_or(("", &*message), |(before, last)| (before, last));
    let last = WORDS.iter().fold(last.to_owned(), |last, (theirs, ours)| last.replacen(theirs, ours, 1));
    if before.is_empty() { last } else { format!("{before}\n{last}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_types_are_put_into_words_and_long_lines_cut() {
        let message = "TOML parse error at line 6, column 8\n  |\n6 | seed = -1\n  |        ^^\ninvalid value: integer `-1`, expected u64\n";
        let said = in_plain_words(message);
        assert!(said.ends_with("\nit is `-1`, expected a whole number from 0"), "{said}");
        assert!(said.contains("6 | seed = -1"), "{said}");
        assert!(in_plain_words(&format!("x\n{}\ny", "z".repeat(10_000_000))).len() < 200);
        assert_eq!(in_plain_words("unknown field `a`, expected `b`"), "unknown field `a`, expected `b`");
    }
}
