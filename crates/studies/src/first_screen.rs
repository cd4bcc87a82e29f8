//! The first screen of a page: what was found, in sentences with their numbers, and one picture of it.

use page::{Finding, Page};

use crate::reproduction::Picture;

/// What a reader sees before any table.
pub(crate) struct FirstScreen<'a> {
    pub(crate) findings: Vec<Finding>,
    pub(crate) picture: &'a Picture,
}

impl FirstScreen<'_> {
    pub(crate) fn show_in(&self, page: &mut Page) {
        page.key_findings(&self.findings);
        self.picture.show_in(page);
    }

    /// The same for a page of `docs/`, which keeps the picture beside it under this name.
    pub(crate) fn markdown(&self, kept_as: &str) -> String {
        let findings: String = self.findings.iter().map(Finding::markdown).collect();
        let Picture { name, caption, .. } = self.picture;
        format!("{findings}\n![{name}]({kept_as})\n\n{caption}\n")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_kept_page_begins_with_sentences_and_one_picture() {
        let picture = Picture { name: "fall".into(), svg: "<svg></svg>".into(), caption: "The cost falls.".into() };
        let findings = vec![Finding::new("It falls by 15.3 %.").with("fall", 15.3, "%")];
        let screen = FirstScreen { findings, picture: &picture };
        assert_eq!(screen.markdown("a.svg"), "- It falls by 15.3 %.\n\n![fall](a.svg)\n\nThe cost falls.\n");
        let mut page = Page::new("Costs");
        screen.show_in(&mut page);
        let html = page.html();
        let (words, figure) = (html.find("<p>It falls by 15.3\u{a0}%.</p>"), html.find("<figcaption>The cost falls."));
        assert!(words.is_some() && words < figure, "{html}");
    }
}
