//! What the dissertation claims, and what of it a run finds again.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::words::capitalized;
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

/// What became of a claim.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Verdict {
    /// It comes out, and nothing was fitted to it.
    Reproduced,
    /// What it says comes out, on a stand-in instead of an experiment or with other numbers.
    InKind,
    /// It comes out in some cases and not in others.
    InPart,
    /// It does not come out.
    NotReproduced,
    /// It comes out, but both ends of it were fitted: that the loop goes from one towards the other is all that it shows.
    PartlyCalibrated,
    /// It was fitted, so that it counts for nothing.
    Calibrated,
    /// It says what is put in, not what comes out.
    TakenOver,
}

impl Verdict {
    /// Of a claim about experiments: a stand-in cannot do more than show it in kind.
    pub(crate) fn in_kind_if(holds: bool) -> Self {
        if holds { Self::InKind } else { Self::NotReproduced }
    }

    /// The same where it was looked at in several cases.
    pub(crate) fn in_kind_of(n_holding: usize, n_cases: usize) -> Self {
        match n_holding {
            0 => Self::NotReproduced,
            n if n < n_cases => Self::InPart,
            _ => Self::InKind,
        }
    }

    /// The same of something whose two ends were fitted: it can fail, but it cannot count as reproduced.
    pub(crate) fn between_fitted_ends(self) -> Self {
        match self {
            Self::Reproduced | Self::InKind | Self::InPart => Self::PartlyCalibrated,
            other => other,
        }
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Reproduced => "reproduced",
            Self::InKind => "reproduced in kind",
            Self::InPart => "reproduced in part",
            Self::NotReproduced => "not reproduced",
            Self::PartlyCalibrated => "partly calibrated",
            Self::Calibrated => "calibrated",
            Self::TakenOver => "taken over",
        })
    }
}

/// One claim and what a study found about it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Claim {
    pub(crate) place: Place,
    pub(crate) says: String,
    pub(crate) verdict: Verdict,
    /// The numbers that decide it, in a few words; empty where there are none.
    pub(crate) in_short: String,
    pub(crate) found: String,
    /// Names of the pictures of the study that show it.
    pub(crate) pictures: Vec<String>,
}

impl Claim {
    pub(crate) fn new(place: Place, says: &str, verdict: Verdict, found: String) -> Self {
        Self { place, says: says.to_owned(), verdict, in_short: String::new(), found, pictures: Vec::new() }
    }

    /// The same with the numbers that decide it.
    pub(crate) fn in_short(self, numbers: impl Into<String>) -> Self {
        Self { in_short: numbers.into(), ..self }
    }

    /// What it says, with the numbers that decide it.
    pub(crate) fn in_numbers(&self) -> String {
        if self.in_short.is_empty() { self.says.clone() } else { format!("{}: {}", self.says, self.in_short) }
    }

    /// The same, shown by these pictures.
    pub(crate) fn shown_in(self, pictures: &[&str]) -> Self {
        Self { pictures: pictures.iter().map(|name| (*name).to_owned()).collect(), ..self }
    }
}

/// Verdicts in the order in which a page begins with them.
pub(crate) const ORDER: [Verdict; 7] = [
    Verdict::Reproduced,
    Verdict::InKind,
    Verdict::InPart,
    Verdict::NotReproduced,
    Verdict::PartlyCalibrated,
    Verdict::Calibrated,
    Verdict::TakenOver,
];

/// What was found in words: the claims by what became of them, with the numbers that decide them.
pub(crate) fn by_verdict(claims: &[Claim]) -> Vec<Finding> {
    let of = |verdict: Verdict| claims.iter().filter(move |claim| claim.verdict == verdict);
    let finding = |verdict: Verdict| {
        let n = of(verdict).count();
        let head = Finding::new(format!("{}, {n} of {}:", capitalized(&verdict.to_string()), claims.len()));
        let head = head.with("claims", n as f64, "1");
        of(verdict).fold(head, |head, claim| head.detail(Finding::new(format!("{}.", claim.in_numbers()))))
    };
    ORDER.into_iter().filter(|verdict| of(*verdict).next().is_some()).map(finding).collect()
}

/// One claim with its place, its numbers and its verdict.
pub(crate) fn finding(claim: &Claim) -> Finding {
    Finding::new(format!("{}: {} ({}).", claim.place, claim.in_numbers(), claim.verdict))
}

/// Heading of [`by_verdict`] on every page.
pub(crate) const BY_VERDICT: &str = "What became of the claims";

/// The same for a page of `docs/`.
pub(crate) fn by_verdict_markdown(claims: &[Claim]) -> String {
    let list: String = by_verdict(claims).iter().map(Finding::markdown).collect();
    format!("## {BY_VERDICT}\n\n{list}")
}

/// Claims with what became of them, for the page of their study.
pub(crate) fn table<'a>(claims: impl IntoIterator<Item = &'a Claim>) -> Table {
    let mut table =
        Table::new(vec![Column::new("Where", ""), Column::new("The dissertation says", ""), Column::new("Here", "")]);
    for claim in claims {
        table.push(vec![claim.place.to_string(), claim.says.clone(), claim.verdict.to_string()]);
    }
    table
}

/// What the latest run found about each, to be read below the table.
pub(crate) fn found<'a>(claims: impl IntoIterator<Item = &'a Claim>) -> Vec<String> {
    claims.into_iter().map(|claim| format!("{}, {}: {}", claim.place, claim.says, claim.found)).collect()
}

/// What decides each, by its place and its verdict, for a page that has said before what the dissertation says.
pub(crate) fn decided(claims: &[Claim]) -> Vec<String> {
    claims.iter().map(|claim| format!("{}, {}: {}", claim.place, claim.verdict, claim.found)).collect()
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
        let claim = |says, verdict| Claim::new(Place::Table(1), says, verdict, String::new());
        let claims = [
            claim("It flies", Verdict::NotReproduced).in_short("0 of 20"),
            claim("It costs", Verdict::Reproduced),
            claim("It turns", Verdict::NotReproduced),
        ];
        assert_eq!(
            by_verdict_markdown(&claims),
            "## What became of the claims\n\n- Reproduced, 1 of 3:\n  - It costs.\n- Not reproduced, 2 of 3:\n  - It flies: 0 of \
             20.\n  - It turns.\n"
        );
    }

    #[test]
    fn what_was_fitted_never_counts_as_reproduced() {
        use Verdict::{Calibrated, InKind, InPart, NotReproduced, PartlyCalibrated, Reproduced};
        let verdicts = [Reproduced, InKind, InPart, NotReproduced, Calibrated].map(Verdict::between_fitted_ends);
        assert_eq!(verdicts, [PartlyCalibrated, PartlyCalibrated, PartlyCalibrated, NotReproduced, Calibrated]);
    }
}
