//! One HTML document that stands alone: text, tables and figures, no script and nothing from elsewhere.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use crate::figures::{Chart, Key, legend_markup};
use crate::text::{escaped, marked_up};
use crate::{Finding, Table};

/// A page under construction, from top to bottom.
///
/// In every text, what stands between two backticks is code; all else is shown as it is.
#[derive(Clone, Debug)]
pub struct Page {
    title: String,
    /// What stands below the title and the contents.
    body: String,
    /// Anchor and heading of each section.
    contents: Vec<(String, String)>,
    figures: usize,
}

/// A way to another page.
#[derive(Clone, Debug)]
pub struct Link {
    /// Relative to this page, so that the folder may be moved; none where there is nothing yet.
    pub to: Option<String>,
    /// What is linked.
    pub text: String,
    /// What follows the link.
    pub about: String,
}

impl Page {
    /// A page with nothing but its title.
    pub fn new(title: &str) -> Self {
        Self { title: title.to_owned(), body: String::new(), contents: Vec::new(), figures: 0 }
    }

    /// A heading.
    pub fn heading(&mut self, text: &str) {
        self.push(&html! { h2 { (marked_up(text)) } });
    }

    /// A heading that the contents at the beginning of the page lead to; no other section has this anchor, a word.
    pub fn section(&mut self, anchor: &str, heading: &str) {
        self.contents.push((anchor.to_owned(), heading.to_owned()));
        self.push(&html! { h2 id=(escaped(anchor)) { (marked_up(heading)) } });
    }

    /// A heading within a section.
    pub fn subheading(&mut self, text: &str) {
        self.push(&html! { h3 { (marked_up(text)) } });
    }

    /// A paragraph.
    pub fn paragraph(&mut self, text: &str) {
        self.push(&html! { p { (marked_up(text)) } });
    }

    /// A paragraph set off from the others: what a reader should know before the rest.
    pub fn note(&mut self, text: &str) {
        self.push(&html! { p class="note" { (marked_up(text)) } });
    }

    /// Items with a dot each.
    pub fn list(&mut self, items: &[String]) {
        self.push(&html! { ul { @for item in items { li { (marked_up(item)) } } } });
    }

    /// A sentence, and a list of what belongs to it.
    pub fn finding(&mut self, finding: &Finding) {
        self.push(&finding_markup(finding));
    }

    /// Findings set off from the rest: what a reader should know first.
    pub fn key_findings(&mut self, findings: &[Finding]) {
        self.push(&html! { div class="note" { @for finding in findings { (finding_markup(finding)) } } });
    }

    /// A list of other pages.
    pub fn links(&mut self, links: &[Link]) {
        self.push(&html! {
            ul {
                @for link in links {
                    li {
                        @if let Some(to) = &link.to {
                            a href=(escaped(to)) { (marked_up(&link.text)) }
                        } @else {
                            (marked_up(&link.text))
                        }
                        (marked_up(&link.about))
                    }
                }
            }
        });
    }

    /// A figure in SVG with its caption. It has no number of its own: captions name figures of the dissertation, and two
    /// numbers would be one too many.
    pub fn figure(&mut self, svg: &str, caption: &str) {
        self.figures += 1;
        let svg = PreEscaped(with_own_ids(svg, self.figures));
        self.push(&html! {
            figure role="img" aria-label=(escaped(&caption.replace('`', ""))) {
                (svg)
                figcaption { (marked_up(caption)) }
            }
        });
    }

    /// Charts side by side, as many as fit, with a legend and a caption for all of them.
    pub fn charts(&mut self, charts: &[Chart], legend: &[Key], caption: &str) {
        self.push(&html! {
            div class="charts" { @for chart in charts { (chart.markup()) } }
            (legend_markup(legend))
            p class="caption" { (marked_up(caption)) }
        });
    }

    /// A table with its caption, without a number for the same reason. Columns without a unit are words, the others
    /// numbers.
    pub fn table(&mut self, table: &Table, caption: &str) {
        self.push(&table_markup(table, caption, None));
    }

    /// A table of sentences as wide as the page, each column with its part of the width in per cent; every cell wraps.
    pub fn prose_table(&mut self, table: &Table, caption: &str, widths_pct: &[u32]) {
        self.push(&table_markup(table, caption, Some(widths_pct)));
    }

    /// The document.
    pub fn html(&self) -> String {
        let document = html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    title { (escaped(&self.title)) }
                    style { (PreEscaped(include_str!("page.css"))) }
                }
                body {
                    main {
                        h1 { (marked_up(&self.title)) }
                        @if !self.contents.is_empty() {
                            nav { @for (anchor, heading) in &self.contents {
                                a href={ "#" (escaped(anchor)) } { (marked_up(heading)) }
                            } }
                        }
                        (PreEscaped(&self.body))
                    }
                }
            }
        };
        document.into_string()
    }

    fn push(&mut self, markup: &Markup) {
        self.body.push_str(&markup.0);
        self.body.push('\n');
    }
}

/// A text as pages show it, for a document of another kind: escaped, code where it stands between backticks.
pub fn text_html(text: &str) -> String {
    marked_up(text).0
}

/// Findings as pages show them, for a document of another kind: each a paragraph, with a list of what belongs to it.
pub fn findings_html(findings: &[Finding]) -> String {
    findings.iter().map(|finding| finding_markup(finding).0).collect()
}

fn finding_markup(finding: &Finding) -> Markup {
    html! {
        p { (marked_up(finding.sentence())) }
        @if !finding.details().is_empty() {
            ul { @for detail in finding.details() { li { (detail_markup(detail)) } } }
        }
    }
}

fn detail_markup(finding: &Finding) -> Markup {
    html! {
        (marked_up(finding.sentence()))
        @if !finding.details().is_empty() {
            ul { @for detail in finding.details() { li { (detail_markup(detail)) } } }
        }
    }
}

/// Cells up to this length stay on one line.
const LONGEST_UNBROKEN: usize = 32;

fn table_markup(table: &Table, caption: &str, widths_pct: Option<&[u32]>) -> Markup {
    let class = |unit: &str| if unit.is_empty() { "words" } else { "number" };
    let cell_class = |unit: &str, cell: &str| {
        let long = if cell.chars().count() > LONGEST_UNBROKEN { " long" } else { "" };
        format!("{}{long}", class(unit))
    };
    html! {
        div class="scroll" {
            table class=[widths_pct.map(|_| "prose")] {
                caption { (marked_up(caption)) }
                @for width in widths_pct.into_iter().flatten() { col style={ "width:" (width) "%" }; }
                thead { tr {
                    @for column in &table.columns {
                        th class=(class(&column.unit)) {
                            (escaped(&column.name))
                            @if !["", "1"].contains(&column.unit.as_str()) { br; span { (escaped(&column.unit)) } }
                        }
                    }
                } }
                tbody {
                    @for row in &table.rows {
                        tr {
                            @for (cell, column) in row.iter().zip(&table.columns) {
                                td class=(cell_class(&column.unit, cell)) { (marked_up(cell)) }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// The figure with ids that no other figure of the page has: a page has one space of names, and a clip path of the same
/// name in an earlier figure would cut this one.
fn with_own_ids(svg: &str, number: usize) -> String {
    svg.replace("id=\"", &format!("id=\"figure-{number}-")).replace("url(#", &format!("url(#figure-{number}-"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Axis, Column, Grid, MapCell};

    #[test]
    fn text_is_escaped_everywhere() {
        let evil = "<b>&\"'";
        let mut page = Page::new(evil);
        page.heading(evil);
        page.subheading(evil);
        page.section("section", evil);
        page.finding(&Finding::new(evil).detail(Finding::new(evil)));
        let axis = Axis::new(evil, evil).with_range(0.0, 1.0);
        let mut chart = Chart::new((300.0, 200.0), &axis, &axis, Grid::Hidden);
        chart.key(Key::new(evil));
        let (fill, class, title) = (evil.to_owned(), "left".to_owned(), evil.to_owned());
        chart.cell(&MapCell { x: (0.0, 1.0), y: (0.0, 1.0), fill: fill.replace('\'', ""), class, title });
        page.charts(&[chart], &[Key::new(evil)], evil);
        page.paragraph(evil);
        page.note(evil);
        page.list(&[evil.to_owned()]);
        page.links(&[Link { to: Some(evil.to_owned()), text: evil.to_owned(), about: evil.to_owned() }]);
        page.figure("<svg></svg>", evil);
        let mut table = Table::new(vec![Column::new(evil, evil)]);
        table.push(vec![evil.to_owned()]);
        page.table(&table, evil);
        let html = page.html();
        assert!(!html.contains(evil), "{html}");
        assert_eq!(html.matches("&lt;b&gt;&amp;&quot;&#39;").count(), 28, "{html}");
    }

    #[test]
    fn spoken_words_carry_no_marks() {
        let mut page = Page::new("Backticks");
        page.figure("<svg></svg>", "made by `it`");
        assert!(page.html().contains("aria-label=\"made by it\""), "{}", page.html());
    }

    #[test]
    fn contents_lead_to_the_sections() {
        let mut page = Page::new("Sections");
        page.section("bounds", "Bounds & more");
        page.subheading("below");
        let html = page.html();
        for part in
            ["<a href=\"#bounds\">Bounds &amp; more</a>", "<h2 id=\"bounds\">Bounds &amp; more</h2>", "<h3>below</h3>"]
        {
            assert!(html.contains(part), "{part} in {html}");
        }
    }

    #[test]
    fn findings_keep_what_belongs_to_them() {
        let mut page = Page::new("Findings");
        let finding = Finding::new("Batch 1:").detail(Finding::new("`one`.")).detail(Finding::new("two."));
        page.finding(&finding);
        page.key_findings(&[Finding::new("First.")]);
        assert!(page.html().contains(&findings_html(&[finding])), "the same in other documents");
        assert_eq!(text_html("`a` & b"), "<code>a</code> &amp; b");
        let html = page.html();
        for part in [
            "<p>Batch 1:</p><ul><li><code>one</code>.</li><li>two.</li></ul>",
            "<div class=\"note\"><p>First.</p></div>",
        ] {
            assert!(html.contains(part), "{part} in {html}");
        }
    }

    #[test]
    fn table_of_sentences_has_the_widths_it_is_given() {
        let mut table = Table::new(vec![Column::new("a", ""), Column::new("b", "")]);
        table.push(vec!["short".to_owned(), "a sentence".to_owned()]);
        let mut page = Page::new("Sentences");
        page.prose_table(&table, "caption", &[20, 80]);
        let html = page.html();
        assert!(html.contains("<table class=\"prose\">") && html.contains("width:20%") && html.contains("width:80%"));
    }

    #[test]
    fn figures_do_not_share_ids() {
        let svg = "<svg><clipPath id=\"a\"/><g clip-path=\"url(#a)\"/></svg>";
        let mut page = Page::new("Two figures");
        page.figure(svg, "one");
        page.figure(svg, "two");
        for name in ["figure-1-a", "figure-2-a"] {
            assert_eq!(page.html().matches(&format!("id=\"{name}\"")).count(), 1, "{name}");
            assert_eq!(page.html().matches(&format!("url(#{name})")).count(), 1, "{name}");
        }
    }

    #[test]
    fn page_stands_alone() {
        let mut page = Page::new("Alone");
        page.paragraph("Text.");
        let html = page.html();
        for outside in ["<script", "<link", "src=", "@import", "href="] {
            assert!(!html.contains(outside), "{outside}");
        }
    }
}
