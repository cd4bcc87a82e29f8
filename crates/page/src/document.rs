//! One HTML document that stands alone: text, tables and figures, no script and nothing from elsewhere.

use std::fmt::Write as _;

use crate::Table;

/// A page under construction, from top to bottom.
#[derive(Clone, Debug)]
pub struct Page {
    title: String,
    body: String,
    figures: usize,
}

/// A way to another page.
#[derive(Clone, Debug)]
pub struct Link {
    /// Relative to this page, so that the folder may be moved; none where there is nothing yet.
    pub to: Option<String>,
    pub text: String,
    /// What follows the link.
    pub about: String,
}

impl Page {
    pub fn new(title: &str) -> Self {
        let body = format!("<h1>{}</h1>\n", marked_up(title));
        Self { title: title.to_owned(), body, figures: 0 }
    }

    pub fn heading(&mut self, text: &str) {
        self.push(&format!("<h2>{}</h2>\n", marked_up(text)));
    }

    pub fn paragraph(&mut self, text: &str) {
        self.push(&format!("<p>{}</p>\n", marked_up(text)));
    }

    /// A paragraph set off from the others: what a reader should know before the rest.
    pub fn note(&mut self, text: &str) {
        self.push(&format!("<p class=\"note\">{}</p>\n", marked_up(text)));
    }

    pub fn list(&mut self, items: &[String]) {
        let items: String = items.iter().map(|item| format!("<li>{}</li>\n", marked_up(item))).collect();
        self.push(&format!("<ul>\n{items}</ul>\n"));
    }

    /// A list of other pages.
    pub fn links(&mut self, links: &[Link]) {
        let item = |link: &Link| {
            let text = marked_up(&link.text);
            let linked = link.to.as_ref().map(|to| format!("<a href=\"{}\">{text}</a>", escape(to)));
            format!("<li>{}{}</li>\n", linked.unwrap_or(text), marked_up(&link.about))
        };
        let items: String = links.iter().map(item).collect();
        self.push(&format!("<ul>\n{items}</ul>\n"));
    }

    /// A figure in SVG with its caption. It has no number of its own: captions name figures of the dissertation, and two
    /// numbers would be one too many.
    pub fn figure(&mut self, svg: &str, caption: &str) {
        self.figures += 1;
        let (spoken, caption) = (escape(&caption.replace('`', "")), marked_up(caption));
        let svg = with_own_ids(svg, self.figures);
        self.push(&format!(
            "<figure role=\"img\" aria-label=\"{spoken}\">\n{svg}\n<figcaption>{caption}</figcaption>\n</figure>\n"
        ));
    }

    /// A table with its caption, without a number for the same reason. Columns without a unit are words, the others
    /// numbers.
    pub fn table(&mut self, table: &Table, caption: &str) {
        self.table_as(table, caption, None);
    }

    /// A table of sentences as wide as the page, each column with its part of the width in per cent; every cell wraps.
    pub fn prose_table(&mut self, table: &Table, caption: &str, widths_pct: &[u32]) {
        self.table_as(table, caption, Some(widths_pct));
    }

    fn table_as(&mut self, table: &Table, caption: &str, widths_pct: Option<&[u32]>) {
        let class = if widths_pct.is_some() { " class=\"prose\"" } else { "" };
        let columns: String =
            widths_pct.into_iter().flatten().map(|width| format!("<col style=\"width:{width}%\">")).collect();
        let mut html = format!(
            "<div class=\"scroll\"><table{class}>\n<caption>{}</caption>\n{columns}<thead><tr>",
            marked_up(caption)
        );
        let class = |unit: &str| if unit.is_empty() { "words" } else { "number" };
        for column in &table.columns {
            let unit = match column.unit.as_str() {
                "" | "1" => String::new(),
                unit => format!("<br><span>{}</span>", escape(unit)),
            };
            let _ = write!(html, "<th class=\"{}\">{}{unit}</th>", class(&column.unit), escape(&column.name));
        }
        html.push_str("</tr></thead>\n<tbody>\n");
        for row in &table.rows {
            html.push_str("<tr>");
            for (cell, column) in row.iter().zip(&table.columns) {
                let long = if cell.chars().count() > LONGEST_UNBROKEN { " long" } else { "" };
                let _ = write!(html, "<td class=\"{}{long}\">{}</td>", class(&column.unit), marked_up(cell));
            }
            html.push_str("</tr>\n");
        }
        html.push_str("</tbody></table></div>\n");
        self.push(&html);
    }

    /// The document.
    pub fn html(&self) -> String {
        format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <title>{}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<main>\n{}</main>\n</body>\n</html>\n",
            escape(&self.title),
            self.body
        )
    }

    fn push(&mut self, html: &str) {
        self.body.push_str(html);
    }
}

/// Cells up to this length stay on one line.
const LONGEST_UNBROKEN: usize = 32;

const STYLE: &str = "\
body { margin: 0; background: #fff; color: #222; font: 16px/1.5 'DejaVu Sans', Verdana, Arial, sans-serif; }
main { max-width: 960px; margin: 0 auto; padding: 24px 20px 64px; }
h1 { font-size: 26px; line-height: 1.25; margin: 16px 0; }
h2 { font-size: 20px; margin: 40px 0 8px; border-bottom: 1px solid #ccc; padding-bottom: 4px; }
p, ul { max-width: 46em; margin: 12px 0; }
.note { border-left: 4px solid #0072b2; background: #f3f7fa; padding: 8px 14px; }
figure { margin: 24px 0; }
figure svg { display: block; max-width: 100%; height: auto; }
figcaption, caption { color: #444; font-size: 14px; text-align: left; padding: 6px 0; max-width: 62em; }
.scroll { overflow-x: auto; margin: 20px 0; }
table { border-collapse: collapse; font-size: 14px; }
th, td { padding: 5px 9px; border-bottom: 1px solid #ddd; vertical-align: bottom; }
thead th { border-bottom: 2px solid #222; }
th span { font-weight: normal; color: #555; }
.number { text-align: right; font-variant-numeric: tabular-nums; }
td { white-space: nowrap; vertical-align: top; }
.words { text-align: left; }
.long, .prose td { white-space: normal; }
.prose { table-layout: fixed; width: 100%; overflow-wrap: break-word; }
code { font: 0.92em 'DejaVu Sans Mono', Menlo, Consolas, monospace; }
a { color: #0072b2; }
@media print { figure, table { break-inside: avoid; } }
";

/// A text as HTML shows it, in an element or in an attribute.
fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&#39;"),
            other => escaped.push(other),
        }
    }
    escaped
}

/// A text as HTML shows it in an element; what stands between two backticks is code, and no line breaks before a per cent
/// sign.
fn marked_up(text: &str) -> String {
    let text = text.replace(" %", "\u{a0}%");
    let parts: Vec<&str> = text.split('`').collect();
    let is_paired = parts.len() % 2 == 1;
    if !is_paired {
        return escape(&text);
    }
    let mark = |(number, part): (usize, &&str)| match number % 2 {
        0 => escape(part),
        _ => format!("<code>{}</code>", escape(part)),
    };
    parts.iter().enumerate().map(mark).collect()
}

/// The figure with ids that no other figure of the page has: a page has one space of names, and a clip path of the same
/// name in an earlier figure would cut this one.
fn with_own_ids(svg: &str, number: usize) -> String {
    svg.replace("id=\"", &format!("id=\"figure-{number}-")).replace("url(#", &format!("url(#figure-{number}-"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Column;

    #[test]
    fn text_is_escaped_everywhere() {
        let evil = "<b>&\"'";
        let mut page = Page::new(evil);
        page.heading(evil);
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
        assert_eq!(html.matches("&lt;b&gt;&amp;&quot;&#39;").count(), 15, "{html}");
    }

    #[test]
    fn backticks_become_code_and_a_single_one_stays() {
        assert_eq!(marked_up("run `a < b`, then `c`"), "run <code>a &lt; b</code>, then <code>c</code>");
        assert_eq!(marked_up("a ` b"), "a ` b");
        assert_eq!(marked_up("5 %"), "5\u{a0}%");
        let mut page = Page::new("Backticks");
        page.figure("<svg></svg>", "made by `it`");
        assert!(page.html().contains("aria-label=\"made by it\""), "spoken words carry no marks: {}", page.html());
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
