//! What the dissertation shows without saying anything of results, so that no study has a claim of it.

use anyhow::{Result, ensure};

use crate::claims::Place;
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

/// Every section by its number; a number alone is the text at the beginning of a chapter.
const ALL_SECTIONS: [&str; 38] = [
    "1.1", "1.2", "1.3", "2.1", "2.2", "2.3", "2.4", "2.4.1", "2.4.2", "2.4.3", "2.4.4", "3.1", "3.2", "3.3", "3.4",
    "3.5", "4.1", "5", "5.1", "5.2", "5.3", "5.3.1", "5.3.2", "5.3.3", "5.4", "5.5", "6", "6.1", "6.2", "6.2.1",
    "6.2.2", "7.1", "7.2", "7.2.1", "7.2.2", "7.2.3", "7.2.4", "7.3",
];

/// Sections by number, each with the reason why nothing of it stands by itself in the table. Equations have a page of their own, on which
/// each has its code or the reason why it has none.
const SECTIONS: [(&str, &str); 24] = [
    ("1.2", "Other work on airborne wind energy, and what the machine is for."),
    ("1.3", "The questions, and six contributions that are listed one by one."),
    ("2.1", "(1) to (9): two derivations in `bat-dynamics`, held together by tests."),
    ("2.2", "What the channel consists of, which we do not have; its cameras are in `water_channel::Sensing`."),
    ("2.4.3", "What it shows is in Table 2 and Figures 10 to 12."),
    ("2.4.4", "A summary of the sections before it."),
    ("3.1", "The terms of the cost (21), which are put in."),
    ("3.3", "How the model is optimized: `infuse::codesign`; which strategy is better is said in Section 1.1."),
    ("3.4", "Experiments around an optimum: steps of `infuse::gradient::Loop`."),
    (
        "3.5",
        "The correction (27), whose sign is repaired; what it leads to is in Table 3. The other way of correction, numbers of the plant identified: `docs/results-identification.md`.",
    ),
    ("4.1", "What it shows is in Table 3 and Figures 16 to 18."),
    ("5.2", "That all runs are made under the same conditions."),
    ("5.3", "Which surfaces there are: steps of `infuse::global::Loop`."),
    ("5.3.1", "The regression (30), (31), which is put in."),
    ("5.3.3", "The surface (34), which is put in."),
    ("5.4", "The correction (35), (36); that it brings the model close to the truth is said in Section 6.1."),
    ("6", "The questions that the chapter answers."),
    ("6.2", "Which parameters are looked at: Table 4."),
    ("6.2.1", "Why a stand-in takes the place of experiments, and (58), (59), which are put in."),
    ("7.2", "Which parameters are looked at: Table 4."),
    ("7.2.1", "How the model is printed so that its fins can be changed."),
    ("7.2.2", "How the parts of the model are joined."),
    ("7.2.3", "How the model is printed watertight."),
    ("7.3", "What was done, in short; that the system becomes better is contribution 6."),
];

/// Every contribution, section, table and figure of the dissertation.
fn all() -> impl Iterator<Item = Place> {
    let contributions = (1..=N_CONTRIBUTIONS).map(Place::Contribution);
    let sections = ALL_SECTIONS.iter().map(|number| Place::Section((*number).to_owned()));
    let tables = (1..=N_TABLES).map(Place::Table);
    contributions.chain(sections).chain(tables).chain((1..=N_FIGURES).map(Place::Figure))
}

/// What is exempt, with the reasons.
fn exempt() -> impl Iterator<Item = (Place, &'static str)> {
    let sections = SECTIONS.iter().map(|(number, reason)| (Place::Section((*number).to_owned()), *reason));
    sections.chain(FIGURES.iter().map(|(number, reason)| (Place::Figure(*number), *reason)))
}

fn is_exempt(place: &Place) -> bool {
    exempt().any(|(exempt, _)| exempt == *place)
}

/// That every contribution, section, table and figure either has a claim or is listed here, and none both.
pub(crate) fn check<'a>(claimed: impl Iterator<Item = &'a Place>) -> Result<()> {
    let claimed: Vec<&Place> = claimed.collect();
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
    for (place, reason) in exempt() {
        table.push(vec![place.to_string(), reason.to_owned()]);
    }
    table
}

/// How a page divides its width among the columns of [`table`], in per cent.
pub(crate) const WIDTHS_PCT: [u32; 2] = [15, 85];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_contribution_section_table_and_figure_is_claimed_or_exempt_on_the_committed_page() {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/reproduction.md");
        let page = std::fs::read_to_string(path).expect("the committed page");
        let is_there = |place: &Place| page.lines().any(|line| line.starts_with(&format!("| {place} |")));
        let missing: Vec<String> = all().filter(|place| !is_there(place)).map(|place| place.to_string()).collect();
        assert!(missing.is_empty(), "not on the page: {missing:?}");
        assert_eq!(all().count(), 6 + ALL_SECTIONS.len() + 6 + 28, "contributions, sections, tables and figures");
    }

    #[test]
    fn what_is_neither_claimed_nor_exempt_is_named() {
        let claimed: Vec<Place> = all().filter(|place| !is_exempt(place)).collect();
        check(claimed.iter()).expect("all are accounted for");
        let lost = [Place::Figure(23), Place::Table(4), Place::Section("5.5".to_owned())];
        let error = check(claimed.iter().filter(|place| !lost.contains(place))).expect_err("three are missing");
        assert_eq!(error.to_string(), "neither claimed by a study nor exempt: Section 5.5, Table 4, Figure 23");
        let twice = [Place::Figure(25)];
        let error = check(claimed.iter().chain(&twice)).expect_err("one is both").to_string();
        assert_eq!(error, "exempt, though a study has a claim of it: Figure 25");
    }

    #[test]
    fn every_exemption_has_its_reason_and_its_place() {
        let exempt: Vec<(Place, &str)> = exempt().collect();
        assert!(exempt.iter().all(|(_, reason)| reason.len() > 20), "a sentence each");
        assert!(exempt.windows(2).all(|pair| pair[0].0 < pair[1].0), "in their order, none twice");
        assert!(exempt.iter().all(|(place, _)| all().any(|one| one == *place)), "places of the dissertation");
    }
}
