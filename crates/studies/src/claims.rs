//! What the dissertation claims, and what of it a run finds again.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::rules::Judged;
pub(crate) use crate::rules::Verdict;
use crate::words::{capitalized, sentences};
use page::{Column, Finding, Table};

/// Where the dissertation says it; in the order in which the claims are listed.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub(crate) enum Place {
    /// Of the list in Section 1.3, from 1.
    Contribution(u8),
    Section(String),
    Table(u8),
    Figure(u8),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Contribution(number) => write!(f, "Section 1.3, contribution {number}"),
            Self::Section(number) => write!(f, "Section {number}"),
            Self::Table(number) => write!(f, "Table {number}"),
            Self::Figure(number) => write!(f, "Figure {number}"),
        }
    }
}

/// With which truth a claim is judged that is judged twice.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Truth {
    /// It is judged once, and none is named.
    Unnamed,
    /// That of the dissertation: the model with stall.
    Printed,
    /// Ours, which is harder.
    StandIn,
}

impl Truth {
    /// What is said with it, where people read it.
    pub(crate) fn after(self, says: &str) -> String {
        let named = match self {
            Self::Unnamed => "",
            Self::Printed => " (with stall alone, as printed)",
            Self::StandIn => " (with our stand-in)",
        };
        format!("{says}{named}")
    }
}

/// One claim and what a study found about it. Place, words and truth say which it is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Claim {
    pub(crate) place: Place,
    /// Without the truth; people read [`Self::words`].
    pub(crate) says: String,
    pub(crate) truth: Truth,
    pub(crate) verdict: Verdict,
    /// What the verdict follows from by the rule; none of what was put in or fitted.
    pub(crate) judged: Option<Judged>,
    /// The numbers that decide it, in a few words; empty where there are none.
    pub(crate) in_short: String,
    pub(crate) found: String,
    /// Names of the pictures of the study that show it.
    pub(crate) pictures: Vec<String>,
}

impl Claim {
    /// What was put in or fitted.
    pub(crate) fn given(place: Place, says: &str, verdict: Verdict, found: String) -> Self {
        let (says, in_short) = (says.to_owned(), String::new());
        Self { place, says, truth: Truth::Unnamed, verdict, judged: None, in_short, found, pictures: Vec::new() }
    }

    /// What was judged: by the one rule.
    pub(crate) fn new(place: Place, says: &str, judged: Judged, found: String) -> Self {
        Self { judged: Some(judged), ..Self::given(place, says, judged.verdict(), found) }
    }

    /// The same, judged with one truth of two.
    pub(crate) fn with_truth(self, truth: Truth) -> Self {
        Self { truth, ..self }
    }

    /// Whether both are the same claim, whatever was found about it.
    pub(crate) fn is_same(&self, other: &Self) -> bool {
        (&self.place, &self.says, self.truth) == (&other.place, &other.says, other.truth)
    }

    /// What it says, with the truth.
    pub(crate) fn words(&self) -> String {
        self.truth.after(&self.says)
    }

    /// The verdict with what it follows from.
    pub(crate) fn verdict_words(&self) -> String {
        self.judged.map_or(self.verdict.to_string(), |judged| {
            let (count, ties) = (judged.count, judged.tie_words());
            format!("{}: {count}{}{ties}", self.verdict, judged.chance_words())
        })
    }

    /// The same with the numbers that decide it.
    pub(crate) fn in_short(self, numbers: impl Into<String>) -> Self {
        Self { in_short: numbers.into(), ..self }
    }

    /// What it says, with the numbers that decide it.
    pub(crate) fn in_numbers(&self) -> String {
        let words = self.words();
        if self.in_short.is_empty() { words } else { format!("{words}: {}", self.in_short) }
    }

    /// The same, shown by these pictures.
    pub(crate) fn shown_in(self, pictures: &[&str]) -> Self {
        self.with_pictures(pictures.iter().map(|name| (*name).to_owned()).collect())
    }

    pub(crate) fn with_pictures(self, pictures: Vec<String>) -> Self {
        Self { pictures, ..self }
    }
}

/// What was found in words: the claims by what became of them, with the numbers that decide them.
pub(crate) fn by_verdict(claims: &[Claim]) -> Vec<Finding> {
    let of = |verdict: Verdict| claims.iter().filter(move |claim| claim.verdict == verdict);
    let finding = |verdict: Verdict| {
        let n = of(verdict).count();
        let head = Finding::new(format!("{}, {n} of {}:", capitalized(&verdict.to_string()), claims.len()));
        let head = head.with("claims", n as f64, "1");
        of(verdict).fold(head, |head, claim| head.detail(Finding::new(format!("{}.", claim.in_numbers()))))
    };
    Verdict::ALL.into_iter().filter(|verdict| of(*verdict).next().is_some()).map(finding).collect()
}

/// One claim with its place, its numbers and its verdict.
pub(crate) fn finding(claim: &Claim) -> Finding {
    Finding::new(format!("{}: {} ({}).", claim.place, claim.in_numbers(), claim.verdict))
}

/// Heading of [`by_verdict`] on every page.
pub(crate) const BY_VERDICT: &str = "What became of the claims";

/// Where more of it stands.
const ELSEWHERE: &str = "The words are those of the [page over all chapters](reproduction.md), which has their rules; this is one plant, and many stand on \
    the [page of the ensemble](results-ensemble.md).";

/// The same for a page of `docs/`.
pub(crate) fn by_verdict_markdown(claims: &[Claim]) -> String {
    format!("## {BY_VERDICT}\n\n{}\n{ELSEWHERE}\n", markdown(&by_verdict(claims)))
}

/// Claims with what became of them, for the page of their study.
pub(crate) fn table<'a>(claims: impl IntoIterator<Item = &'a Claim>) -> Table {
    let mut table =
        Table::new(vec![Column::new("Where", ""), Column::new("The dissertation says", ""), Column::new("Here", "")]);
    for claim in claims {
        table.push(vec![claim.place.to_string(), claim.words(), claim.verdict_words()]);
    }
    table
}

/// Letters of a claim and a sentence about it that stand on one line.
const LONGEST: usize = 300;

/// What the latest run found about each, to be read below the table: a sentence beside the claim, more of them below it.
pub(crate) fn found<'a>(claims: impl IntoIterator<Item = &'a Claim>) -> Vec<Finding> {
    let finding = |claim: &Claim| {
        let head = format!("{}, {}:", claim.place, claim.words());
        match sentences(&claim.found).as_slice() {
            [one] if head.len() + one.len() <= LONGEST => Finding::new(format!("{head} {one}")),
            all => below(&head, all),
        }
    };
    claims.into_iter().map(finding).collect()
}

/// What decides each, with its verdict.
pub(crate) fn decided(claims: &[Claim]) -> Vec<Finding> {
    let finding = |claim: &Claim| {
        let head = format!("{}, {}: {}.", claim.place, claim.words(), claim.verdict_words());
        below(&head, &sentences(&claim.found))
    };
    claims.iter().map(finding).collect()
}

fn below(head: &str, sentences: &[&str]) -> Finding {
    Finding::new(head).with_sentences(sentences.iter().copied())
}

/// Findings as a list of a page of `docs/`.
pub(crate) fn markdown(findings: &[Finding]) -> String {
    findings.iter().map(Finding::markdown).collect()
}

/// What stands above them.
pub(crate) const FOUND: &str = "What the latest run found, claim by claim:";

/// How a page divides its width among the columns of [`table`], in per cent.
pub(crate) const WIDTHS_PCT: [u32; 3] = [16, 64, 20];

/// Claims of several studies, each with the command that gives it.
pub(crate) fn table_with_commands<'a>(claims: impl IntoIterator<Item = (&'a Claim, &'a str)>) -> Table {
    let (claims, commands): (Vec<_>, Vec<_>) = claims.into_iter().unzip();
    let mut table = table(claims);
    table.columns.push(Column::new("Command", ""));
    for (row, command) in table.rows.iter_mut().zip(commands) {
        row.push(format!("`{command}`"));
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rules::{Count, Standing};

    #[test]
    fn places_are_listed_as_the_dissertation_is_read() {
        let mut places =
            [Place::Figure(3), Place::Table(6), Place::Section("2.4".into()), Place::Contribution(2), Place::Table(5)];
        places.sort();
        let words: Vec<String> = places.iter().map(ToString::to_string).collect();
        assert_eq!(words, ["Section 1.3, contribution 2", "Section 2.4", "Table 5", "Table 6", "Figure 3"]);
    }

    #[test]
    fn claims_are_listed_by_verdict_with_their_numbers() {
        let claim = |says, verdict| Claim::given(Place::Table(1), says, verdict, String::new());
        let claims = [
            claim("It flies", Verdict::NotReproduced).in_short("0 of 20"),
            claim("It costs", Verdict::Reproduced),
            claim("It turns", Verdict::NotReproduced),
        ];
        assert_eq!(
            by_verdict_markdown(&claims).replace(ELSEWHERE, "").trim_end(),
            "## What became of the claims\n\n- Reproduced, 1 of 3:\n  - It costs.\n- Not reproduced, 2 of 3:\n  - It flies: 0 of \
             20.\n  - It turns."
        );
    }

    #[test]
    fn sentences_stand_below_a_claim_where_there_are_more_than_one() {
        let claim = |found: &str| Claim::given(Place::Table(1), "It flies", Verdict::Reproduced, found.to_owned());
        let claims = [claim("It does, (55)."), claim("It does at 3.5 s. So it was.")];
        assert_eq!(
            markdown(&found(&claims)),
            "- Table 1, It flies: It does, (55).\n- Table 1, It flies:\n  - It does at 3.5 s.\n  - So it was.\n"
        );
        assert_eq!(markdown(&decided(&claims[..1])), "- Table 1, It flies: reproduced.\n  - It does, (55).\n");
    }

    #[test]
    fn a_verdict_is_read_with_what_it_follows_from() {
        let judged = Judged::of(Count { holding: 18, cases: 20 }, Standing::StandIn).beside(0.63);
        let words = |judged| Claim::new(Place::Table(1), "It turns", judged, String::new()).verdict_words();
        assert_eq!(words(judged), "not discriminating: 18 of 20; by chance 63 %");
        assert_eq!(
            words(judged.beside(0.2)),
            "reproduced in kind: 18 of 20; by chance 20 % (count exactly at the limit)"
        );
        let given = Claim::given(Place::Table(1), "It is put in", Verdict::TakenOver, String::new());
        assert_eq!(given.verdict_words(), "taken over");
    }
}
