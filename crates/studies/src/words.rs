//! Text that studies share.

/// A number within text, with a minus sign and not a hyphen where it is negative.
pub(crate) fn number(value: f64, decimals: usize) -> String {
    with_minus(&format!("{value:.decimals$}"))
}

/// Of a goal.
#[cfg(feature = "benchmark")]
pub(crate) fn verdict(is_met: bool) -> &'static str {
    if is_met { "met" } else { "missed" }
}

/// Three digits.
pub(crate) fn digits(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let decimals = (2 - value.abs().log10().floor() as i32).max(0) as usize;
    if decimals > 5 { with_minus(&format!("{value:.2e}")) } else { number(value, decimals) }
}

/// A noun that is counted often.
pub(crate) const PLANTS: [&str; 2] = ["plant", "plants"];

/// "1 run", "2 runs".
pub(crate) fn counted(n: usize, [one, many]: [&str; 2]) -> String {
    format!("{n} {}", if n == 1 { one } else { many })
}

/// The same as [`number`] with its sign.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_three_digits_and_a_minus() {
        let all = [0.0, 1234.6, -0.012_345, 1.0e-9].map(digits);
        assert_eq!(all, ["0", "1235", "−0.0123", "1.00e−9"]);
        assert_eq!(signed(-1.25, 1), "−1.2");
    }

    #[test]
    fn nouns_follow_their_numbers() {
        assert_eq!([1, 2].map(|n| counted(n, ["run", "runs"])), ["1 run", "2 runs"]);
    }

    #[test]
    fn words_are_listed_as_in_a_sentence() {
        let words = ["a", "b", "c"].map(str::to_owned);
        assert_eq!([0, 1, 2, 3].map(|n| listed(&words[..n])), ["", "a", "a and b", "a, b and c"]);
    }

    #[test]
    fn sentences_end_before_a_capital_a_digit_or_a_bracket() {
        let text = "It is 3.5 s, e.g. so. Then it ends. 33 are left. (55) holds.";
        assert_eq!(sentences(text), ["It is 3.5 s, e.g. so.", "Then it ends.", "33 are left.", "(55) holds."]);
    }
}
