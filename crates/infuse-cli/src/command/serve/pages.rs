//! The pages that ask before something is done.

use maud::html;

use super::frame::{document, text};

/// What is done, in a heading, a sentence, and the word on the button.
#[derive(Debug, Clone, Copy)]
pub(super) struct Question<'a> {
    pub(super) heading: &'a str,
    pub(super) what: &'a str,
    pub(super) button: &'a str,
    /// Where it is sent.
    pub(super) action: &'a str,
}

/// A page with a button, a way back, and the number of lines that the journal had when it was made.
pub(super) fn question(asked: Question<'_>, n_lines: usize, runs: Option<usize>) -> String {
    let Question { heading, what, button, action } = asked;
    let body = html! {
        h1 { (heading) }
        p { (text(what)) }
        form method="post" action=(action) class="question" {
            input type="hidden" name="lines" value=(n_lines);
            @if let Some(runs) = runs {
                label { span { "runs of each design" } input type="text" inputmode="numeric" name="runs" value=(runs); }
            }
            button class="main" { (button) }
            " " a href="/" { "Back, and change nothing" }
        }
    };
    document(heading, None, &body)
}

/// That something was not done, and why.
pub(super) fn fault(error: &str) -> String {
    let body = html! {
        h1 { "Not done" }
        p class="fault" role="alert" { (text(error)) }
        p { a href="/" { "Back to the sheet" } }
    };
    document("Not done", None, &body)
}
