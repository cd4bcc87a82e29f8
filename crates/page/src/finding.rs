//! What was found: a sentence with its numbers, for a terminal, a page and a machine.

use std::fmt;

use serde::Serialize;

/// A sentence, the numbers in it by name, and what belongs to it.
///
/// The same finding is printed ([`Display`](fmt::Display)), shown on a page ([`Page::finding`](crate::Page::finding)), kept in
/// a text ([`Finding::markdown`]) and given to programs (`Serialize`), so that nobody needs to read a number out of a sentence.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Finding {
    sentence: String,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    numbers: Vec<Number>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    details: Vec<Finding>,
}

/// A number of a finding.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Number {
    /// What it is, in a word.
    pub name: String,
    /// Without the rounding of the sentence.
    pub value: f64,
    /// "1" or empty for a pure number.
    pub unit: String,
}

impl Finding {
    /// A finding in words.
    pub fn new(sentence: impl Into<String>) -> Self {
        Self { sentence: sentence.into(), ..Self::default() }
    }

    /// The same with a number that its sentence tells; `unit` is "1" or empty for a pure number.
    pub fn with(mut self, name: &str, value: f64, unit: &str) -> Self {
        self.numbers.push(Number { name: name.to_owned(), value, unit: unit.to_owned() });
        self
    }

    /// The same with a finding that belongs to it, shown below it.
    pub fn detail(mut self, detail: Finding) -> Self {
        self.details.push(detail);
        self
    }

    /// The same with sentences that belong to it, each shown below it.
    pub fn with_sentences(self, sentences: impl IntoIterator<Item = impl Into<String>>) -> Self {
        sentences.into_iter().map(Finding::new).fold(self, Finding::detail)
    }

    /// What is said.
    pub fn sentence(&self) -> &str {
        &self.sentence
    }

    /// The numbers of the sentence.
    pub fn numbers(&self) -> &[Number] {
        &self.numbers
    }

    /// What belongs to it.
    pub fn details(&self) -> &[Finding] {
        &self.details
    }

    /// An item of a list in Markdown, with what belongs to it as a list of its own.
    pub fn markdown(&self) -> String {
        fn write(finding: &Finding, indent: usize, text: &mut String) {
            text.push_str(&format!("{:indent$}- {}\n", "", finding.sentence));
            finding.details.iter().for_each(|detail| write(detail, indent + 2, text));
        }
        let mut text = String::new();
        write(self, 0, &mut text);
        text
    }

    fn write(&self, formatter: &mut fmt::Formatter<'_>, indent: usize) -> fmt::Result {
        writeln!(formatter, "{:indent$}{}", "", self.sentence)?;
        self.details.iter().try_for_each(|detail| detail.write(formatter, indent + 2))
    }
}

/// A line for the sentence, and an indented one for everything that belongs to it.
impl fmt::Display for Finding {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write(formatter, 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn terminal_has_a_line_for_each_sentence() {
        let finding = Finding::new("Best: gap 3 mm.")
            .with("gap", 3.0, "mm")
            .detail(Finding::new("4.2 N there.").with("force", 4.201, "N").detail(Finding::new("Measured twice.")));
        assert_eq!(finding.to_string(), "Best: gap 3 mm.\n  4.2 N there.\n    Measured twice.\n");
        assert_eq!(finding.markdown(), "- Best: gap 3 mm.\n  - 4.2 N there.\n    - Measured twice.\n");
        let sentences = Finding::new("Best: gap 3 mm.").with_sentences(["4.2 N there.", "Measured twice."]);
        assert_eq!(sentences.markdown(), "- Best: gap 3 mm.\n  - 4.2 N there.\n  - Measured twice.\n");
        assert_eq!(finding.numbers()[0].name, "gap");
        assert_eq!(finding.details()[0].sentence(), "4.2 N there.");
    }
}
