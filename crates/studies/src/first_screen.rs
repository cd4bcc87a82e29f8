//! The first screen of a page: what was found, in a few sentences with their numbers, and one picture of it.

use page::{Finding, Page};

use crate::reproduction::Picture;

/// The words that a page may begin with, those below the picture among them; a finding is not cut, and the first always comes
/// before the picture.
const WORDS: usize = 150;

/// Heading of the findings that do not fit on the first screen.
const MORE: &str = "More findings";

/// Heading of how the page came about and what it rests on, which every page says next.
const MADE: &str = "How this page was made";

/// What a reader sees before any table. Findings that do not fit there follow under a heading of their own, and last comes the
/// heading of how the page was made, below which the page goes on.
pub(crate) struct FirstScreen<'a> {
    pub(crate) findings: Vec<Finding>,
    pub(crate) picture: &'a Picture,
}

impl FirstScreen<'_> {
    pub(crate) fn show_in(&self, page: &mut Page) {
        let (before, after) = parted(&self.findings, &self.picture.caption);
        page.key_findings(before);
        self.picture.show_in(page);
        if !after.is_empty() {
            page.heading(MORE);
        }
        after.iter().for_each(|finding| page.finding(finding));
        page.heading(MADE);
    }

    /// The same for a page of `docs/`, which keeps the picture beside it under this name.
    pub(crate) fn markdown(&self, kept_as: &str) -> String {
        let caption = &self.picture.caption;
        around(&self.findings, &format!("![{}]({kept_as})", first_sentence(caption)), caption)
    }
}

/// Findings about a picture as a page of `docs/` begins with them; `picture` is how it is shown.
pub(crate) fn around(findings: &[Finding], picture: &str, caption: &str) -> String {
    let list = |some: &[Finding]| some.iter().map(Finding::markdown).collect::<String>();
    let (before, after) = parted(findings, caption);
    let more = if after.is_empty() { String::new() } else { format!("\n## {MORE}\n\n{}", list(after)) };
    format!("{}\n{picture}\n\n{caption}\n{more}\n## {MADE}\n", list(before))
}

/// The findings of the first screen, and the others.
fn parted<'a>(findings: &'a [Finding], caption: &str) -> (&'a [Finding], &'a [Finding]) {
    let room = WORDS.saturating_sub(caption.split_whitespace().count());
    let sums = findings.iter().map(n_words).scan(0, |sum, n| {
        *sum += n;
        Some(*sum)
    });
    findings.split_at(sums.enumerate().take_while(|(index, sum)| *index == 0 || *sum <= room).count())
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
        let kept = "- It falls by 15.3 %.\n\n![The cost falls](a.svg)\n\nThe cost falls. Lower is better.\n\n## How this page was made\n";
        assert_eq!(screen.markdown("a.svg"), kept);
        let mut page = Page::new("Costs");
        screen.show_in(&mut page);
        let html = page.html();
        let (words, figure) = (html.find("<p>It falls by 15.3\u{a0}%.</p>"), html.find("<figcaption>The cost falls."));
        assert!(words.is_some() && words < figure && !html.contains(MORE), "{html}");
    }

    #[test]
    fn what_is_too_long_for_the_first_screen_follows_under_a_heading() {
        let long = "word ".repeat(80).trim_end().to_owned();
        let picture = Picture { name: "fall".into(), svg: "<svg></svg>".into(), caption: "Falls.".into() };
        let detailed = Finding::new("Short.").detail(Finding::new(long.clone()));
        let screen = FirstScreen { findings: vec![Finding::new(long.clone()), detailed], picture: &picture };
        let parts = format!(
            "- {long}\n\n![Falls](a.svg)\n\nFalls.\n\n## More findings\n\n- Short.\n  - {long}\n\n## How this page was made\n"
        );
        assert_eq!(screen.markdown("a.svg"), parts);
        let mut page = Page::new("Costs");
        screen.show_in(&mut page);
        let html = page.html();
        assert!(html.find(MORE).is_some_and(|more| Some(more) < html.find("<p>Short.</p>")), "{html}");
    }

    /// The words below the picture are on the first screen, too.
    #[test]
    fn a_long_caption_leaves_room_for_fewer_findings() {
        let findings = ["word ".repeat(130), "word".to_owned()].map(Finding::new);
        let n_before = |caption: &str| parted(&findings, caption).0.len();
        assert_eq!([n_before("Falls."), n_before(&"long ".repeat(20)), n_before(&"long ".repeat(160))], [2, 1, 1]);
    }
}
