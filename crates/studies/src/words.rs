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

/// With a capital letter first.
pub(crate) fn capitalized(words: &str) -> String {
    let mut letters = words.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

/// How many of something, by the word for one: `1 plant`, `2 plants`.
pub(crate) fn counted(n: usize, one: &str) -> String {
    if n == 1 { format!("1 {one}") } else { format!("{n} {one}s") }
}
