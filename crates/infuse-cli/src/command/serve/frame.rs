//! What all pages share: the document around them, and sentences.

use maud::{DOCTYPE, Markup, PreEscaped, html};
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

/// Sentences, each with what belongs to it, as the report shows them.
pub(super) fn sentences(findings: &[Finding]) -> Markup {
    PreEscaped(page::findings_html(findings))
}

/// Words as the report shows them: what stands between two backticks is code.
pub(super) fn text(text: &str) -> Markup {
    PreEscaped(page::text_html(text))
}
