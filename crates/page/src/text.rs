//! Text as HTML shows it. Templates escape on their own; here are the marks that a text may carry.

use maud::{Markup, PreEscaped, Render};

/// A text in an element or in an attribute: what HTML would read as its own is escaped, line breaks are spaces, and control
/// characters, which no HTML may hold, are left out.
pub(crate) fn escaped(text: &str) -> Markup {
    let clean: String = text
        .chars()
        .map(|character| if matches!(character, '\n' | '\t') { ' ' } else { character })
        .filter(|character| !character.is_control())
        .collect();
    // maud leaves the apostrophe, which ends an attribute in single quotes.
    PreEscaped(clean.render().0.replace('\'', "&#39;"))
}

/// A text in an element: what stands between two backticks is code, and no line breaks before a per cent sign.
pub(crate) fn marked_up(text: &str) -> Markup {
    let text = text.replace(" %", "\u{a0}%");
    let mut parts: Vec<String> = text.split('`').map(str::to_owned).collect();
    // Without its partner a backtick is one.
    if parts.len().is_multiple_of(2)
        && let Some(last) = parts.pop()
        && let Some(before) = parts.last_mut()
    {
        before.push('`');
        before.push_str(&last);
    }
    let mut html = String::new();
    for (number, part) in parts.iter().enumerate() {
        let part = escaped(part).0;
        html.push_str(&if number % 2 == 0 { part } else { format!("<code>{part}</code>") });
    }
    PreEscaped(html)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn backticks_become_code_and_a_single_one_stays() {
        let shown = |text: &str| marked_up(text).0;
        assert_eq!(shown("run `a < b`, then `c`"), "run <code>a &lt; b</code>, then <code>c</code>");
        assert_eq!(shown("a ` b"), "a ` b");
        assert_eq!(shown("set `worth` to `1"), "set <code>worth</code> to `1");
        assert_eq!(shown("`"), "`");
        assert_eq!(shown("5 %"), "5\u{a0}%");
    }

    #[test]
    fn what_no_html_may_hold_is_left_out() {
        assert_eq!(escaped("a\nb\u{1}c<'\">").0, "a bc&lt;&#39;&quot;&gt;");
    }
}
