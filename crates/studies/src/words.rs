//! Text that studies share.

/// A number within text, with a minus sign and not a hyphen where it is negative.
pub(crate) fn number(value: f64, decimals: usize) -> String {
    with_minus(&format!("{value:.decimals$}"))
}

/// The same with its sign.
pub(crate) fn signed(value: f64, decimals: usize) -> String {
    with_minus(&format!("{value:+.decimals$}"))
}

fn with_minus(digits: &str) -> String {
    digits.replace('-', "−")
}

/// The sentences of a text: each ends with a full stop before a capital letter, a digit or a bracket.
pub(crate) fn sentences(text: &str) -> Vec<&str> {
    let starts_one =
        |rest: &str| rest.starts_with(|letter: char| letter.is_uppercase() || letter.is_ascii_digit() || letter == '(');
    let ends = text.match_indices(". ").filter(|(at, _)| starts_one(&text[at + 2..])).map(|(at, _)| at + 1);
    let mut sentences = Vec::new();
    let mut start = 0;
    for end in ends {
        sentences.push(&text[start..end]);
        start = end + 1;
    }
    sentences.push(&text[start..]);
    sentences
}

/// Words as a sentence lists them: with commas, and with `and` before the last.
pub(crate) fn listed(words: &[String]) -> String {
    match words {
        [] => String::new(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

/// With a capital letter first.
pub(crate) fn capitalized(words: &str) -> String {
    let mut letters = words.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}
