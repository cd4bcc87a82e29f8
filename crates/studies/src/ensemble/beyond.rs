//! What becomes of the claims on the few plants that were found from starts farther away, which are a sample of nothing.

use page::{Column, Finding, Table};

use super::evidence::{N_DRAWS, by_chance};
use super::judge::{Judged, judge};
use super::kept::{Case, Kept};
use super::row::World;
use super::sentences;
use super::tables::Both;
use crate::rules::Verdict;
use crate::words::{PLANTS, capitalized, counted};

/// A claim in a world on the plants of the ensemble, and on those from farther away.
struct Row<'a> {
    both: &'a Both,
    world: usize,
    beyond: Judged,
}

impl Row<'_> {
    fn near(&self) -> &Judged {
        &self.both.judged[self.world]
    }

    fn counts(&self) -> bool {
        self.near().verdict().is_some_and(Verdict::counts)
    }

    fn changes(&self) -> bool {
        self.near().verdict() != self.beyond.verdict()
    }

    /// Which claim, and from which word to which.
    fn change(&self) -> Option<String> {
        let (from, to) = self.near().verdict().zip(self.beyond.verdict())?;
        let claim = &self.both.claim;
        let world = World::OF_CAMPAIGNS[self.world].name();
        Some(format!("{} ({}), {world} water: {}, would be {}", claim.words(), claim.place, from.short(), to.short()))
    }
}

/// Claims on plants from farther away.
pub(super) struct Beyond<'a> {
    kept: &'a Kept,
    cases: &'a [Case<'a>],
    n_near: usize,
    rows: Vec<Row<'a>>,
    /// How many words change on as many plants of the ensemble drawn at random, median and nine tenths of the draws.
    by_chance: [f64; 2],
}

impl<'a> Beyond<'a> {
    pub(super) fn of(kept: &'a Kept, all: &'a [Both], cases: &'a [Case<'a>]) -> Self {
        let rows = rows(all, cases);
        let near: Vec<&Judged> = rows.iter().map(Row::near).collect();
        let n_near = near.iter().map(|judged| judged.shares.len()).max().unwrap_or(0);
        let by_chance = by_chance(&near, kept.setup.plants.len());
        Self { kept, cases, n_near, rows, by_chance }
    }

    fn n(&self) -> usize {
        self.kept.setup.plants.len()
    }

    /// How many words would change, beside what so few plants of the ensemble would do; none without such plants.
    fn changes(&self) -> Option<[String; 2]> {
        if self.rows.is_empty() {
            return None;
        }
        let changed =
            |counts: bool| self.rows.iter().filter(move |row| row.counts() == counts && row.changes()).count();
        let [of_counting, of_others] = [changed(true), changed(false)];
        let [median, most] = self.by_chance;
        let (n, n_near) = (self.n(), counted(self.n_near, PLANTS));
        let than = if (of_counting + of_others) as f64 > most { "more" } else { "no more" };
        Some([
            format!(
                "of {} words {} would change, {of_counting} of them words that count",
                self.rows.len(),
                of_counting + of_others
            ),
            format!(
                "on {n} of the {n_near} drawn at random {median} do in the median of {N_DRAWS} draws, and up to {most} in nine of ten, so \
                 that this is {than} than so few plants bring by themselves"
            ),
        ])
    }

    /// With what the page begins.
    pub(super) fn finding(&self) -> Option<Finding> {
        let which = if self.n() == 1 { "is no fair sample and counts" } else { "are no fair sample and count" };
        let head =
            format!("On {} from farther away, which {which} for no word of this page:", counted(self.n(), PLANTS));
        Some(Finding::new(head).with_sentences(self.changes()?.map(|changes| format!("{}.", capitalized(&changes)))))
    }

    /// The section.
    pub(super) fn section(&self) -> String {
        let Some(changes) = self.changes().map(|changes| changes.join("; ")) else { return String::new() };
        let (n, n_near) = (self.n(), self.n_near);
        let [flights, seconds] = self.kept.store.took();
        let mut text = format!(
            "\n## On plants from farther away\n\nThe {n_near} plants of this page are a cloud about one plant. The same campaigns, with the same seeds, were run on the {n} that \
             came of starts farther away ([how](results-calibration.md)): {flights:.0} flights in {:.0} minutes, kept in `fixtures/bat/ensemble/beyond`; `--check` flies the center of the box on two of these plants again, too, and `--check --all` \
             a unit of each kind on the last of them. \
             They are no fair sample of the plants that meet the published numbers: they are what is left of starts most of which were refused, the campaigns on one plant are no \
             independent answers, and a share of {} estimates nothing. They count for no word of this page. The table says in how many of them a claim holds, and which \
             word the same rules would give if there were no other plants: to show where a word may hang on where the cloud lies, and for nothing else. So read, {changes}.\n",
            seconds / 60.0,
            counted(n, PLANTS)
        );
        for (counts, words) in [(true, "that count"), (false, "that do not count")] {
            let mine = self.rows.iter().filter(|row| row.counts() == counts && row.changes());
            let changes: String = mine.filter_map(Row::change).map(|change| format!("- {change}.\n")).collect();
            text += &if changes.is_empty() {
                format!("\nOf the words {words} none would change.\n")
            } else {
                format!("\nOf the words {words} these would change:\n\n{changes}")
            };
        }
        text += &format!(
            "\nEach claim that counts in one of the waters, or whose word would change. A plant is counted as above, where the claim would be in kind on it alone.\n\n{}",
            self.table().markdown()
        );
        text += &format!(
            "\nThe model's optimum and one last design of each plant were seen by the three cameras here, too. {}\n",
            sentences::blind_cameras(&self.kept.setup, self.cases)
        );
        text
    }

    fn table(&self) -> Table {
        let heads = ["Still water", "Moving water"].map(|water| {
            [format!("{water}, {}", counted(self.n_near, PLANTS)), format!("{water}, these {}", self.n())]
        });
        let heads = heads.iter().flatten().map(|name| Column::words(name));
        let heads = std::iter::once(Column::words("Claim")).chain(heads);
        let mut table = Table::new(heads.collect());
        let mut claims: Vec<&Both> = self.rows.iter().map(|row| row.both).collect();
        claims.dedup_by(|a, b| std::ptr::eq(*a, *b));
        for both in claims {
            let mine = |world: usize| self.rows.iter().find(|row| std::ptr::eq(row.both, both) && row.world == world);
            let worlds = [mine(0), mine(1)];
            if !worlds.iter().flatten().any(|row| row.counts() || row.changes()) {
                continue;
            }
            let mut cells = vec![format!("{}: {}", both.claim.place, both.claim.words())];
            cells.extend(worlds.into_iter().flat_map(|row| row.map_or(["–".to_owned(), "–".to_owned()], cells_of)));
            table.push(cells);
        }
        table
    }
}

/// What became of a claim on the plants of the ensemble, and in how many others it holds; a word that would change is bold.
fn cells_of(row: &Row<'_>) -> [String; 2] {
    let words = |judged: &Judged| judged.words().unwrap_or_default();
    let word = |judged: &Judged| judged.verdict().map_or("–", Verdict::short);
    let would = if row.changes() { format!("; would be **{}**", word(&row.beyond)) } else { String::new() };
    [format!("{}: {}", word(row.near()), words(row.near())), format!("{}{would}", words(&row.beyond))]
}

/// All claims about plants that are judged on both.
fn rows<'a>(all: &'a [Both], cases: &[Case<'_>]) -> Vec<Row<'a>> {
    let mut rows = Vec::new();
    for both in all {
        for (world, near) in both.judged.iter().enumerate() {
            let beyond = near.on(&judge(&both.claim, World::OF_CAMPAIGNS[world], cases, &[]));
            if beyond.by_rule.is_some() {
                rows.push(Row { both, world, beyond });
            }
        }
    }
    rows
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::claims::{Claim, Test};
    use super::super::file::Setup;
    use super::super::row::{self, Fact, Study};
    use super::super::store::Store;
    use super::*;
    use crate::calibration::Origin;
    use crate::claims::Place;

    fn kept(folder: &Path) -> Kept {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let setup = Setup::read_of(&root, Origin::Beyond).expect("plants from farther away");
        Kept { setup, store: Store::read(folder, "key").expect("an empty store") }
    }

    /// Of a plant: a fact, above zero where the claim holds.
    fn claim() -> Claim {
        let test = |case: &Case<'_>| Some(case.fact("holds")? > 0.0);
        Claim::new(Place::Table(3), "It is so", Study::Two, "it is", Test::Plant(Box::new(test))).still()
    }

    fn facts(holds: &[bool]) -> Vec<Fact> {
        let name = || "holds".to_owned();
        let value = |holds: &bool| f64::from(u8::from(*holds));
        holds
            .iter()
            .map(|one| Fact { study: Study::Two, world: World::Still, name: name(), value: value(one) })
            .collect()
    }

    fn cases(facts: &[Fact]) -> Vec<Case<'_>> {
        let case = |(plant, fact)| {
            let rows: Vec<&row::Row> = Vec::new();
            Case { study: Study::Two, world: World::Still, plant, rows, facts: vec![fact] }
        };
        (0..).zip(facts).map(case).collect()
    }

    fn both(near: &[bool]) -> Both {
        let facts = facts(near);
        let cases = cases(&facts);
        let claim = claim();
        Both { judged: World::OF_CAMPAIGNS.map(|world| judge(&claim, world, &cases, &[])), claim }
    }

    /// What a page says of a claim that holds on these plants of the ensemble, and on these others.
    fn page(near: &[bool], others: &[bool]) -> (Option<String>, String) {
        let folder = tempfile::tempdir().expect("a folder");
        let (kept, all, facts) = (kept(folder.path()), [both(near)], facts(others));
        let cases = cases(&facts);
        let beyond = Beyond::of(&kept, &all, &cases);
        (beyond.finding().map(|finding| finding.markdown()), beyond.section())
    }

    #[test]
    fn a_word_that_would_change_is_told_and_counts_for_nothing() {
        let (finding, section) = page(&[true; 30], &[true, false, false, true]);
        let finding = finding.expect("words that would change");
        assert!(finding.contains("no fair sample") && finding.contains("1 words 1 would change, 1 of"), "{finding}");
        assert!(finding.contains("0 do in the median") && finding.contains("more than so few plants"), "{finding}");
        assert!(!finding.contains("no more than"), "on no plant of the ensemble does it fail: {finding}");
        assert!(section.contains("no fair sample") && section.contains("estimates nothing"), "{section}");
        assert!(section.contains("- It is so (Table 3), still water: in kind, would be in part.\n"), "{section}");
        let row = "| Table 3: It is so | in kind: 30 of 30 plants | 2 of 4 plants; would be **in part** | – | – |";
        assert!(section.contains(row), "{section}");
    }

    #[test]
    fn a_word_that_stays_is_not_bold() {
        let near: Vec<bool> = (0..30).map(|plant| plant % 2 == 0).collect();
        let (finding, section) = page(&near, &[true, false, false, true]);
        assert!(finding.expect("no change is said, too").contains("1 words 0 would change"));
        assert!(section.contains("Of the words that count none would change."), "{section}");
        assert!(section.contains("| in part: 15 of 30 plants | 2 of 4 plants | – | – |"), "{section}");
    }

    #[test]
    fn without_such_plants_nothing_is_said() {
        assert_eq!(page(&[true; 30], &[]), (None, String::new()));
    }
}
