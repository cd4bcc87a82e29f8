//! The first screen of a page: what was found, in a few sentences with their numbers, and one picture of it.

use page::{Finding, Page};

use crate::reproduction::Picture;

/// The words that may stand before the picture; a finding is not cut, and the first always comes before it.
const WORDS: usize = 120;

/// What a reader sees before any table. Findings that do not fit before the picture follow it.
pub(crate) struct FirstScreen<'a> {
    pub(crate) findings: Vec<Finding>,
    pub(crate) picture: &'a Picture,
}

impl FirstScreen<'_> {
    pub(crate) fn show_in(&self, page: &mut Page) {
        let (before, after) = self.parted();
        page.key_findings(before);
        self.picture.show_in(page);
        after.iter().for_each(|finding| page.finding(finding));
    }

    /// The same for a page of `docs/`, which keeps the picture beside it under this name.
    pub(crate) fn markdown(&self, kept_as: &str) -> String {
        let list = |findings: &[Finding]| findings.iter().map(Finding::markdown).collect::<String>();
        let (before, after) = self.parted();
        let Picture { caption, .. } = self.picture;
        let rest = if after.is_empty() { String::new() } else { format!("\n{}", list(after)) };
        format!("{}\n![{}]({kept_as})\n\n{caption}\n{rest}", list(before), first_sentence(caption))
    }

    fn parted(&self) -> (&[Finding], &[Finding]) {
        self.findings.split_at(n_before_picture(self.findings.iter().map(n_words)))
    }
}

/// Sentences about a picture as a page of `docs/` begins with them; `picture` is the picture with what is said below it.
pub(crate) fn around(sentences: &[String], picture: &str) -> String {
    let list = |some: &[String]| some.iter().map(|one| format!("- {one}\n")).collect::<String>();
    let n_words = sentences.iter().map(|one| one.split_whitespace().count());
    let (before, after) = sentences.split_at(n_before_picture(n_words));
    let rest = if after.is_empty() { String::new() } else { format!("{}\n", list(after)) };
    format!("{}\n{picture}\n\n{rest}", list(before))
}

/// How many findings of so many words each come before the picture.
fn n_before_picture(n_words: impl Iterator<Item = usize>) -> usize {
    let sums = n_words.scan(0, |sum, n| {
        *sum += n;
        Some(*sum)
    });
    sums.enumerate().take_while(|(index, sum)| *index == 0 || *sum <= WORDS).count()
}

fn n_words(finding: &Finding) -> usize {
    finding.sentence().split_whitespace().count() + finding.details().iter().map(n_words).sum::<usize>()
}

/// The first sentence of a caption, which is what a picture is called for those who do not see it.
fn first_sentence(caption: &str) -> &str {
    caption.split_once(". ").map_or(caption, |(first, _)| first).trim_end_matches('.')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_kept_page_begins_with_sentences_and_one_picture() {
        let caption = "The cost falls. Lower is better.".to_owned();
        let picture = Picture { name: "fall".into(), svg: "<svg></svg>".into(), caption };
        let findings = vec![Finding::new("It falls by 15.3 %.").with("fall", 15.3, "%")];
        let screen = FirstScreen { findings, picture: &picture };
        let kept = "- It falls by 15.3 %.\n\n![The cost falls](a.svg)\n\nThe cost falls. Lower is better.\n";
        assert_eq!(screen.markdown("a.svg"), kept);
        let mut page = Page::new("Costs");
        screen.show_in(&mut page);
        let html = page.html();
        let (words, figure) = (html.find("<p>It falls by 15.3\u{a0}%.</p>"), html.find("<figcaption>The cost falls."));
        assert!(words.is_some() && words < figure, "{html}");
    }

    #[test]
    fn what_is_too_long_for_the_first_screen_follows_the_picture() {
        let long = "word ".repeat(70).trim_end().to_owned();
        let picture = Picture { name: "fall".into(), svg: "<svg></svg>".into(), caption: "Falls.".into() };
        let detailed = Finding::new("Short.").detail(Finding::new(long.clone()));
        let screen = FirstScreen { findings: vec![Finding::new(long.clone()), detailed], picture: &picture };
        let parts = format!("- {long}\n\n![Falls](a.svg)\n\nFalls.\n\n- Short.\n  - {long}\n");
        assert_eq!(screen.markdown("a.svg"), parts);
        let sentences = [long.clone(), long.clone(), "Short.".to_owned()];
        assert_eq!(around(&sentences, "![a](b)"), format!("- {long}\n\n![a](b)\n\n- {long}\n- Short.\n\n"));
        assert_eq!(around(&sentences[2..], "![a](b)"), "- Short.\n\n![a](b)\n\n");
        assert_eq!(n_before_picture([130, 1].into_iter()), 1, "the first is never left out");
    }
}
