//! What all pages share: the document around them, and sentences.

use maud::{DOCTYPE, Markup, html};
use page::Finding;

/// A whole document. `refresh_s` loads it again after so many seconds, without a script.
pub(super) fn document(title: &str, refresh_s: Option<u32>, body: &Markup) -> String {
    let document = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                @if let Some(seconds) = refresh_s { meta http-equiv="refresh" content={ (seconds) "; url=/" }; }
                title { (title) }
                link rel="stylesheet" href="/style.css";
            }
            body { main { (body) } }
        }
    };
    document.into_string()
}

/// Sentences, each with what belongs to it.
pub(super) fn sentences(findings: &[Finding]) -> Markup {
    html! {
        @for finding in findings {
            p { (text(finding.sentence())) }
            (details(finding.details()))
        }
    }
}

fn details(findings: &[Finding]) -> Markup {
    html! {
        @if !findings.is_empty() {
            ul { @for finding in findings { li { (text(finding.sentence())) (details(finding.details())) } } }
        }
    }
}

/// What stands between two backticks is code.
pub(super) fn text(text: &str) -> Markup {
    html! {
        @for (index, part) in text.split('`').enumerate() {
            @if index % 2 == 0 { (part) } @else { code { (part) } }
        }
    }
}
