//! An HTML document that stands alone: text, tables and figures, no script and nothing from elsewhere.

use std::fmt::Write as _;

/// A page under construction, from top to bottom.
#[derive(Debug)]
pub(super) struct Page {
    title: String,
    /// What stands between the title and the contents.
    body: String,
    /// Anchor and heading of each section.
    sections: Vec<(&'static str, &'static str)>,
}

/// A column: words, or numbers that line up on the right.
#[derive(Debug, Clone)]
pub(super) struct Column {
    heading: String,
    class: &'static str,
}

impl Column {
    pub(super) fn words(heading: impl Into<String>) -> Self {
        Self { heading: heading.into(), class: "words" }
    }

    pub(super) fn number(heading: impl Into<String>) -> Self {
        Self { heading: heading.into(), class: "number" }
    }

    /// A number, or words instead of it.
    pub(super) fn result(heading: impl Into<String>) -> Self {
        Self { heading: heading.into(), class: "result" }
    }
}

#[derive(Debug)]
pub(super) struct Table {
    pub(super) caption: String,
    pub(super) columns: Vec<Column>,
    pub(super) rows: Vec<Vec<String>>,
}

/// A drawing with what is written around it, so that no text ever runs into it.
#[derive(Debug)]
pub(super) struct Figure {
    /// What goes up.
    pub(super) y_label: String,
    pub(super) svg: String,
    pub(super) width_px: f64,
    /// What goes to the right.
    pub(super) x_label: String,
    pub(super) legend: Vec<Key>,
}

/// A line of a legend.
#[derive(Debug, Clone)]
pub(super) struct Key {
    /// SVG around the middle of a sample, in pixels.
    pub(super) sample: String,
    pub(super) text: String,
}

impl Page {
    pub(super) fn new(title: &str) -> Self {
        Self { title: title.to_owned(), body: String::new(), sections: Vec::new() }
    }

    pub(super) fn section(&mut self, anchor: &'static str, heading: &'static str) {
        self.sections.push((anchor, heading));
        let _ = writeln!(self.body, "<h2 id=\"{anchor}\">{heading}</h2>");
    }

    pub(super) fn heading(&mut self, text: &str) {
        let _ = writeln!(self.body, "<h3>{}</h3>", escape(text));
    }

    pub(super) fn paragraph(&mut self, text: &str) {
        let _ = writeln!(self.body, "<p>{}</p>", inline(text));
    }

    /// Text that a reader should see before the rest.
    pub(super) fn note(&mut self, text: &str) {
        let _ = writeln!(self.body, "<p class=\"note\">{}</p>", lines(text));
    }

    /// Text as a terminal shows it: lines that are indented go with the one before them, as a list after a colon.
    pub(super) fn terminal_text(&mut self, text: &str) {
        let mut head = String::new();
        for line in text.lines().chain([""]) {
            if line.starts_with(' ') {
                head.push('\n');
                head.push_str(line.trim_start());
                continue;
            }
            match head.split_once('\n') {
                Some((first, rest)) if first.ends_with(':') => {
                    self.paragraph(first);
                    self.list(rest.lines().map(str::to_owned));
                }
                _ if head.is_empty() => {}
                _ => {
                    let _ = writeln!(self.body, "<p>{}</p>", lines(&with_capitals(&head)));
                }
            }
            head = line.to_owned();
        }
    }

    pub(super) fn list(&mut self, items: impl IntoIterator<Item = String>) {
        self.body.push_str("<ul>\n");
        for item in items {
            let _ = writeln!(self.body, "<li>{}</li>", inline(&item));
        }
        self.body.push_str("</ul>\n");
    }

    pub(super) fn table(&mut self, table: &Table) {
        let body = &mut self.body;
        let _ =
            write!(body, "<div class=\"scroll\"><table>\n<caption>{}</caption>\n<thead><tr>", inline(&table.caption));
        for Column { heading, class } in &table.columns {
            let _ = write!(body, "<th class=\"{class}\">{}</th>", inline(&unbroken_unit(heading)));
        }
        body.push_str("</tr></thead>\n<tbody>\n");
        for row in &table.rows {
            body.push_str("<tr>");
            for (cell, Column { class, .. }) in row.iter().zip(&table.columns) {
                let _ = write!(body, "<td class=\"{class}\">{}</td>", inline(cell));
            }
            body.push_str("</tr>\n");
        }
        body.push_str("</tbody></table></div>\n");
    }

    /// Figures side by side, as many as fit, with a legend and a caption for all of them.
    pub(super) fn figures(&mut self, figures: &[Figure], legend: &[Key], caption: &str) {
        let body = &mut self.body;
        body.push_str("<div class=\"figures\">\n");
        for figure in figures {
            let _ = writeln!(body, "<figure style=\"width: {}px\">", figure.width_px);
            let _ = write!(body, "<div class=\"y\">{}</div>\n{}\n", escape(&figure.y_label), figure.svg);
            let _ = writeln!(body, "<div class=\"x\">{}</div>", escape(&figure.x_label));
            write_legend(body, &figure.legend);
            body.push_str("</figure>\n");
        }
        body.push_str("</div>\n");
        write_legend(body, legend);
        let _ = writeln!(body, "<p class=\"caption\">{}</p>", inline(caption));
    }

    /// The document.
    pub(super) fn html(&self) -> String {
        let title = escape(&self.title);
        let link = |(anchor, heading): &(&str, &str)| format!("<a href=\"#{anchor}\">{heading}</a>");
        let contents: Vec<String> = self.sections.iter().map(link).collect();
        format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <title>{title}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<main>\n<h1>{title}</h1>\n\
             <nav>{}</nav>\n{}</main>\n</body>\n</html>\n",
            contents.join("\n"),
            self.body
        )
    }
}

fn write_legend(body: &mut String, legend: &[Key]) {
    if legend.is_empty() {
        return;
    }
    body.push_str("<ul class=\"legend\">\n");
    for Key { sample, text } in legend {
        let _ = writeln!(
            body,
            "<li><svg width=\"26\" height=\"24\" viewBox=\"-13 -12 26 24\">{sample}</svg> {}</li>",
            escape(text)
        );
    }
    body.push_str("</ul>\n");
}

/// A heading whose unit stays on one line.
fn unbroken_unit(heading: &str) -> String {
    match heading.rsplit_once(" [") {
        Some((name, unit)) => format!("{name} [{}", unit.replace(' ', "\u{a0}")),
        None => heading.to_owned(),
    }
}

/// Escaped, what stands between backticks in the type of commands.
fn inline(text: &str) -> String {
    let mut parts: Vec<String> = text.split('`').map(escape).collect();
    // Without its partner a backtick is one.
    if parts.len().is_multiple_of(2)
        && let Some(last) = parts.pop()
        && let Some(before) = parts.last_mut()
    {
        before.push('`');
        before.push_str(&last);
    }
    let typed = |(index, part): (usize, &String)| match index % 2 {
        0 => part.clone(),
        _ => format!("<code>{part}</code>"),
    };
    parts.iter().enumerate().map(typed).collect()
}

/// The same, line by line; a line that ends with a comma goes on.
fn lines(text: &str) -> String {
    let mut html = String::new();
    for (index, line) in text.trim().lines().enumerate() {
        let separator = if html.ends_with(',') { " " } else { "<br>\n" };
        html.push_str(if index == 0 { "" } else { separator });
        html.push_str(&inline(line.trim()));
    }
    html
}

/// Each line that follows a whole sentence begins with a capital.
fn with_capitals(text: &str) -> String {
    let mut capitals = String::with_capacity(text.len());
    for line in text.lines() {
        let begins = capitals.ends_with(".\n");
        let mut letters = line.chars();
        match letters.next().filter(|_| begins) {
            Some(first) => capitals.extend(first.to_uppercase().chain(letters)),
            None => capitals.push_str(line),
        }
        capitals.push('\n');
    }
    capitals
}

/// A text as HTML shows it, in an element or in an attribute. Control characters, which no HTML may hold, are left out.
pub(super) fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&#39;"),
            '\n' | '\t' => escaped.push(' '),
            other if other.is_control() => {}
            other => escaped.push(other),
        }
    }
    escaped
}

const STYLE: &str = "\
body { margin: 0; background: #fff; color: #222; font: 16px/1.5 'DejaVu Sans', Verdana, Arial, sans-serif; }
main { max-width: 960px; margin: 0 auto; padding: 24px 20px 64px; }
h1 { font-size: 26px; line-height: 1.25; margin: 16px 0; overflow-wrap: anywhere; }
h2 { font-size: 20px; margin: 44px 0 8px; border-bottom: 1px solid #ccc; padding-bottom: 4px; }
h3 { font-size: 16px; margin: 28px 0 4px; }
nav { display: flex; flex-wrap: wrap; gap: 4px 18px; font-size: 14px; }
a { color: #0072b2; }
p, ul { max-width: 50em; margin: 12px 0; overflow-wrap: anywhere; }
code { font: 0.92em 'DejaVu Sans Mono', Menlo, Consolas, monospace; }
.note { border-left: 4px solid #0072b2; background: #f3f7fa; padding: 8px 14px; }
.figures { display: flex; flex-wrap: wrap; gap: 24px 20px; margin: 20px 0 0; align-items: flex-start; }
figure { margin: 0; max-width: 100%; }
figure svg { display: block; }
figure > svg { max-width: 100%; height: auto; }
.y, .x { font-size: 13px; overflow-wrap: anywhere; }
.y { font-weight: bold; margin-bottom: 4px; }
.x { text-align: center; }
.legend { list-style: none; display: flex; flex-wrap: wrap; gap: 0 16px; padding: 0; margin: 8px 0 0; font-size: 13px; max-width: none; }
.legend li { display: flex; align-items: center; gap: 4px; }
.legend svg { flex: none; }
.caption, caption { color: #444; font-size: 14px; line-height: 1.4; text-align: left; padding: 6px 0 4px; max-width: 58em; margin: 0; }
.scroll { overflow-x: auto; margin: 12px 0 20px; }
table { border-collapse: collapse; font-size: 14px; line-height: 1.35; }
th, td { padding: 5px 9px; border-bottom: 1px solid #ddd; vertical-align: top; }
thead th { border-bottom: 2px solid #222; vertical-align: bottom; }
.number { text-align: right; font-variant-numeric: tabular-nums; }
td.number { white-space: nowrap; }
.words { text-align: left; overflow-wrap: break-word; }
.result { text-align: right; max-width: 18em; overflow-wrap: break-word; }
.left, .dropped { shape-rendering: crispEdges; }
@media print { figure, table, .note { break-inside: avoid; } h2, h3 { break-after: avoid; } nav { display: none; } }
";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_escaped_in_every_place() {
        let evil = "<b>&\"'\u{1}";
        let mut page = Page::new(evil);
        page.heading(evil);
        page.paragraph(evil);
        page.note(evil);
        page.terminal_text(&format!("{evil}:\n  {evil}\n{evil}\n  {evil}\n"));
        let (columns, rows) = (vec![Column::words(evil)], vec![vec![evil.to_owned()]]);
        page.table(&Table { caption: evil.to_owned(), columns, rows });
        let key = Key { sample: String::new(), text: evil.to_owned() };
        let (label, legend) = (evil.to_owned(), vec![key.clone()]);
        page.figures(
            &[Figure { y_label: label.clone(), svg: String::new(), width_px: 1.0, x_label: label, legend }],
            &[key],
            evil,
        );
        let html = page.html();
        assert!(!html.contains("<b>") && !html.contains('\u{1}'), "{html}");
        assert_eq!(html.matches("&lt;b&gt;&amp;&quot;&#39;").count(), 17, "{html}");
    }

    #[test]
    fn lines_of_a_terminal_keep_their_order() {
        let mut page = Page::new("t");
        page.terminal_text("Taught:\n  one\n  two\n\nMore,\n  and more.\n  less\nAlone.\n  below\n");
        for part in [
            "<p>Taught:</p>\n<ul>\n<li>one</li>\n<li>two</li>\n</ul>",
            "<p>More, and more.<br>\nLess</p>",
            "Alone.<br>\nBelow",
        ] {
            assert!(page.body.contains(part), "{part} in {}", page.body);
        }
    }

    #[test]
    fn only_pairs_of_backticks_are_commands() {
        assert_eq!(inline("set `worth` to `1"), "set <code>worth</code> to `1");
        assert_eq!(inline("`"), "`");
        assert_eq!(inline("a `b`"), "a <code>b</code>");
    }
}
