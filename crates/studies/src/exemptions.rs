//! What the dissertation shows without saying anything of results, so that no study has a claim of it.

use anyhow::{Result, ensure};

use crate::claims::{Claim, Place};
use page::{Column, Table};

const N_CONTRIBUTIONS: u8 = 6;
const N_TABLES: u8 = 6;
const N_FIGURES: u8 = 28;

/// Figures by number, each with the reason why nothing in it could come out.
const FIGURES: [(u8, &str); 13] = [
    (1, "A drawing of ways to optimize plant and controller, from other work."),
    (2, "Photographs of machines by several makers."),
    (3, "A flow chart: the steps of `infuse::gradient::Loop`."),
    (4, "A flow chart: the steps of `infuse::global::Loop`."),
    (5, "A photograph of the full-scale machine."),
    (6, "A drawing of the coordinates: those of `bat-dynamics`."),
    (7, "A photograph of the water channel, which we do not have."),
    (8, "Views of the 1/100 model, to show how it is taken apart."),
    (9, "A block diagram of the controller: `tether-control`."),
    (10, "A photograph of the three scale models; what they do is Figures 11 and 12."),
    (13, "A flow chart of the nested optimization: `infuse::codesign` inside of `infuse::gradient::Loop`."),
    (19, "A flow chart: the steps of `infuse::global::Loop` in detail."),
    (25, "A picture of the model with removable fins."),
];

/// Every contribution, table and figure of the dissertation.
fn all() -> impl Iterator<Item = Place> {
    let contributions = (1..=N_CONTRIBUTIONS).map(Place::Contribution);
    contributions.chain((1..=N_TABLES).map(Place::Table)).chain((1..=N_FIGURES).map(Place::Figure))
}

fn is_exempt(place: &Place) -> bool {
    FIGURES.iter().any(|(number, _)| *place == Place::Figure(*number))
}

/// That every contribution, table and figure either has a claim or is listed here, and none both.
pub(crate) fn check<'a>(claims: impl Iterator<Item = &'a Claim>) -> Result<()> {
    let claimed: Vec<&Place> = claims.map(|claim| &claim.place).collect();
    let listed = |wrong: &dyn Fn(&Place) -> bool| {
        all().filter(|place| wrong(place)).map(|place| place.to_string()).collect::<Vec<_>>().join(", ")
    };
    let missing = listed(&|place| !claimed.contains(&place) && !is_exempt(place));
    ensure!(missing.is_empty(), "neither claimed by a study nor exempt: {missing}");
    let both = listed(&|place| claimed.contains(&place) && is_exempt(place));
    ensure!(both.is_empty(), "exempt, though a study has a claim of it: {both}");
    Ok(())
}

/// What is exempt, with the reasons.
pub(crate) fn table() -> Table {
    let mut table = Table::new(vec![Column::new("Where", ""), Column::new("Why nothing in it could come out", "")]);
    for (number, reason) in FIGURES {
        table.push(vec![Place::Figure(number).to_string(), reason.to_owned()]);
    }
    table
}

/// How a page divides its width among the columns of [`table`], in per cent.
pub(crate) const WIDTHS_PCT: [u32; 2] = [15, 85];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::claims::Verdict;

    fn claims_of(places: impl Iterator<Item = Place>) -> Vec<Claim> {
        places.map(|place| Claim::new(place, "it", Verdict::InKind, String::new())).collect()
    }

    #[test]
    fn every_contribution_table_and_figure_is_claimed_or_exempt_on_the_committed_page() {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/reproduction.md");
        let page = std::fs::read_to_string(path).expect("the committed page");
        let is_there = |place: &Place| page.lines().any(|line| line.starts_with(&format!("| {place} |")));
        let missing: Vec<String> = all().filter(|place| !is_there(place)).map(|place| place.to_string()).collect();
        assert!(missing.is_empty(), "not on the page: {missing:?}");
        assert_eq!(all().count(), 40, "six contributions, six tables and 28 figures");
    }

    #[test]
    fn what_is_neither_claimed_nor_exempt_is_named() {
        let claimed = || all().filter(|place| !is_exempt(place));
        check(claims_of(claimed()).iter()).expect("all are accounted for");
        let without = claims_of(claimed().filter(|place| !matches!(place, Place::Figure(23) | Place::Table(4))));
        let error = check(without.iter()).expect_err("two are missing").to_string();
        assert_eq!(error, "neither claimed by a study nor exempt: Table 4, Figure 23");
        let twice = claims_of(claimed().chain([Place::Figure(25)]));
        let error = check(twice.iter()).expect_err("one is both").to_string();
        assert_eq!(error, "exempt, though a study has a claim of it: Figure 25");
    }

    #[test]
    fn every_exemption_has_its_reason() {
        assert!(FIGURES.iter().all(|(_, reason)| reason.len() > 20), "a sentence each");
        assert!(FIGURES.windows(2).all(|pair| pair[0].0 < pair[1].0), "in their order, none twice");
    }
}
