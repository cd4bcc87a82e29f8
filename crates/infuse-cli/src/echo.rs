//! What people wrote, said back to them.

/// Of a text of somebody else's so many characters are said back.
const LONGEST: usize = 60;

/// The text on one line, cut where it is longer than anyone reads: between two words, if one of them is no longer than half of that.
pub(crate) fn echo(text: &str) -> String {
    let mut characters = text.chars().map(|c| if c.is_control() { ' ' } else { c });
    let short: String = characters.by_ref().take(LONGEST).collect();
    match characters.next() {
        None => short,
        Some(' ') => format!("{short}..."),
        Some(_) => {
            let at = short.rfind(' ').filter(|&at| at > short.len() / 2);
            format!("{}...", &short[..at.unwrap_or(short.len())])
        }
    }
}

/// Several of them, as many as fit on a few lines.
pub(crate) fn echo_all<'a>(texts: impl IntoIterator<Item = &'a str>) -> String {
    const MOST: usize = 20;
    let all: Vec<&str> = texts.into_iter().collect();
    let shown = all.iter().take(MOST).map(|text| echo(text)).collect::<Vec<_>>().join(", ");
    if all.len() > MOST { format!("{shown} and {} more", all.len() - MOST) } else { shown }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_texts_are_cut_and_stay_on_one_line() {
        assert_eq!(echo("two\nlines"), "two lines");
        assert_eq!(echo(&"x".repeat(60)), "x".repeat(60));
        assert_eq!(echo(&"é".repeat(10_000_000)), format!("{}...", "é".repeat(60)));
        let words = "the probe came loose after the third gust and was not found again";
        assert_eq!(echo(words), "the probe came loose after the third gust and was not found...");
        assert_eq!(
            echo(&format!("{words} anywhere")[1..]),
            "he probe came loose after the third gust and was not found..."
        );
        assert_eq!(echo(&format!("a {}", "x".repeat(60))), format!("a {}...", "x".repeat(58)), "no word to cut at");
        assert_eq!(echo_all(["a"; 22]), format!("{}a and 2 more", "a, ".repeat(19)));
    }
}
