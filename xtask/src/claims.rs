//! What the dissertation claims, and what of it a run finds again.

use std::fmt;
use std::path::Path;

use anyhow::{Context as _, Result};
use serde::{Deserialize, Serialize};

use crate::table::{Column, Table};

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
            Self::Contribution(number) => write!(f, "1.3, contribution {number}"),
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
    /// What it says comes out, on a surrogate instead of an experiment or with other numbers.
    InKind,
    /// It comes out in some cases and not in others.
    InPart,
    /// It does not come out.
    NotReproduced,
    /// It was fitted, so that it counts for nothing.
    Calibrated,
    /// It says what is put in, not what comes out.
    TakenOver,
}

impl Verdict {
    /// Of a claim about experiments: a surrogate cannot do more than show it in kind.
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
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Reproduced => "reproduced",
            Self::InKind => "reproduced in kind",
            Self::InPart => "reproduced in part",
            Self::NotReproduced => "not reproduced",
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
    pub(crate) found: String,
    /// Names of the pictures of the study that show it.
    pub(crate) pictures: Vec<String>,
}

impl Claim {
    pub(crate) fn new(place: Place, says: &str, verdict: Verdict, found: String) -> Self {
        Self { place, says: says.to_owned(), verdict, found, pictures: Vec::new() }
    }

    /// The same, shown by these pictures.
    pub(crate) fn shown_in(self, pictures: &[&str]) -> Self {
        Self { pictures: pictures.iter().map(|name| (*name).to_owned()).collect(), ..self }
    }
}

const FILE: &str = "claims.json";

/// Writes what a study found beside its page.
pub(crate) fn save(out: &Path, claims: &[Claim]) -> Result<()> {
    let path = out.join(FILE);
    std::fs::write(&path, serde_json::to_string_pretty(claims)?).with_context(|| path.display().to_string())
}

/// Reads what the latest run of a study found.
pub(crate) fn read(out: &Path) -> Result<Vec<Claim>> {
    let path = out.join(FILE);
    let text = std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
    serde_json::from_str(&text).with_context(|| path.display().to_string())
}

/// Claims for the page of their study.
pub(crate) fn table<'a>(claims: impl IntoIterator<Item = &'a Claim>) -> Table {
    let mut table = Table::new(vec![
        Column::new("Where", ""),
        Column::new("The dissertation says", ""),
        Column::new("Here", ""),
        Column::new("What the latest run found", ""),
    ]);
    for claim in claims {
        table.push(vec![claim.place.to_string(), claim.says.clone(), claim.verdict.to_string(), claim.found.clone()]);
    }
    table
}

/// Claims of several studies, each with the command that gives it.
pub(crate) fn table_with_commands<'a>(claims: impl IntoIterator<Item = (&'a Claim, &'a str)>) -> Table {
    let (claims, commands): (Vec<_>, Vec<_>) = claims.into_iter().unzip();
    let mut table = table(claims);
    table.columns.push(Column::new("Command", ""));
    for (row, command) in table.rows.iter_mut().zip(commands) {
        row.push(format!("`cargo xtask {command}`"));
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
        assert_eq!(words, ["1.3, contribution 2", "Section 2.4", "Table 5", "Table 6", "Figure 3"]);
    }

    #[test]
    fn claims_come_back_from_their_file() {
        let out = std::env::temp_dir().join(format!("xtask-{}-claims", std::process::id()));
        std::fs::create_dir_all(&out).expect("a writable directory");
        let claims = vec![
            Claim::new(Place::Table(3), "The cost falls", Verdict::in_kind_if(true), "15 %".into()).shown_in(&["a"]),
            Claim::new(Place::Contribution(1), "A loop", Verdict::in_kind_if(false), "none".into()),
        ];
        save(&out, &claims).expect("written");
        let read = read(&out);
        std::fs::remove_dir_all(&out).expect("just written");
        assert_eq!(read.expect("just written"), claims);
    }
}
