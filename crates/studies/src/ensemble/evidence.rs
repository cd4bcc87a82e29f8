//! What becomes of the claims where what a model is worth counts as evidence, too: on those plants alone whose models are worth most.

use page::{Column, Table};

use super::judge::{Judged, judge};
use super::kept::Case;
use super::row::World;
use super::tables::Both;
use crate::rules::Verdict;
use crate::words::number;

/// One in so many plants is taken.
const ONE_IN: usize = 3;

/// What a model is worth: the name of a fact, and in words.
const WORTH: [(&str, &str); 2] = [("rank_correlation", "rank correlation"), ("fit_of_61", "R² of (61)")];

/// The plants whose models are worth most, and the least that one of them is worth.
fn best(cases: &[Case<'_>], fact: &str) -> (Vec<u64>, f64) {
    let mut plants: Vec<u64> = cases.iter().filter(|case| case.fact(fact).is_some()).map(|case| case.plant).collect();
    plants.sort_unstable();
    plants.dedup();
    let mean = |plant: u64| {
        let mine = cases.iter().filter(|case| case.plant == plant && case.world == World::Still);
        let values: Vec<f64> = mine.filter_map(|case| case.fact(fact)).collect();
        values.iter().sum::<f64>() / values.len() as f64
    };
    let mut ranked: Vec<(u64, f64)> = plants.into_iter().map(|plant| (plant, mean(plant))).collect();
    ranked.sort_by(|a, b| b.1.total_cmp(&a.1));
    ranked.truncate(ranked.len() / ONE_IN);
    let least = ranked.last().map_or(f64::NAN, |(_, worth)| *worth);
    (ranked.into_iter().map(|(plant, _)| plant).collect(), least)
}

/// A claim on all plants, and on those whose models are worth most.
struct Row<'a> {
    both: &'a Both,
    world: usize,
    chosen: Vec<Judged>,
}

impl Row<'_> {
    fn all(&self) -> &Judged {
        &self.both.judged[self.world]
    }

    fn verdicts(&self) -> impl Iterator<Item = Option<Verdict>> {
        self.chosen.iter().map(Judged::verdict)
    }
}

/// The section.
pub(super) fn section(all: &[Both], cases: &[Case<'_>]) -> String {
    let chosen = WORTH.map(|(fact, _)| best(cases, fact));
    let n = chosen[0].0.len();
    let mut rows = Vec::new();
    for both in all {
        for (world, name) in World::OF_CAMPAIGNS.into_iter().enumerate() {
            // Of one case only: it is about designs of experiments, and about no plant.
            if both.judged[world].shares.len() < 2 {
                continue;
            }
            let on = |(plants, _): &(Vec<u64>, f64)| {
                let mine: Vec<Case<'_>> = cases.iter().filter(|case| plants.contains(&case.plant)).cloned().collect();
                judge(&both.claim, name, &mine)
            };
            rows.push(Row { both, world, chosen: chosen.iter().map(on).collect() });
        }
    }
    let least = |k: usize| number(chosen[k].1, 2);
    let mut text = format!(
        "\n## If a good model were evidence\n\nWhat a model is worth was no evidence in the calibration: only the published rows are. The dissertation's spaces \
         shrank to 15 and 20 %, so its surfaces may have fitted better than ours. Here the claims are judged once more on {n} of the plants alone: those of \
         the highest rank correlation of model and stand-in, at least {}, and those where the regressor (61) fits best, R² at least {}; means over the studies, \
         in still water.\n\n",
        least(0),
        least(1)
    );
    text += &counts(&rows).markdown();
    let changed: Vec<&Row<'_>> =
        rows.iter().filter(|row| row.verdicts().any(|verdict| verdict != row.all().verdict())).collect();
    if changed.is_empty() {
        text += "\nNo verdict changes.\n";
    } else {
        text += &format!("\nWhat changes, {} of {}:\n\n{}", changed.len(), rows.len(), changes(&changed, n).markdown());
    }
    text
}

/// How many claims become what.
fn counts(rows: &[Row<'_>]) -> Table {
    let mut heads = vec![Column::new("Verdict", ""), Column::new("All plants", "claims")];
    heads.extend(WORTH.map(|(_, words)| Column::new(&format!("best by {words}"), "claims")));
    let mut table = Table::new(heads);
    for verdict in [Verdict::InKind, Verdict::InPart, Verdict::NotReproduced, Verdict::NotDiscriminating] {
        let of = |judged: &dyn Fn(&Row<'_>) -> Option<Verdict>| {
            rows.iter().filter(|row| judged(row) == Some(verdict)).count().to_string()
        };
        let mut cells = vec![verdict.short().to_owned(), of(&|row| row.all().verdict())];
        cells.extend((0..WORTH.len()).map(|k| of(&|row| row.chosen[k].verdict())));
        table.push(cells);
    }
    table
}

fn changes(rows: &[&Row<'_>], n: usize) -> Table {
    let mut heads = vec![Column::new("Claim", ""), Column::new("Water", ""), Column::new("All plants", "")];
    heads.extend(WORTH.map(|(_, words)| Column::new(&format!("{n} best by {words}"), "")));
    let mut table = Table::new(heads);
    let cell = |judged: &Judged| {
        let (verdict, count) = (judged.verdict().map_or("–", Verdict::short), judged.by_rule.map(|rule| rule.count));
        format!("{verdict}{}", count.map_or(String::new(), |count| format!(", {count}")))
    };
    for row in rows {
        let mut cells = vec![
            format!("{}: {}", row.both.claim.place, row.both.claim.says),
            World::OF_CAMPAIGNS[row.world].name().to_owned(),
            cell(row.all()),
        ];
        cells.extend(row.chosen.iter().map(cell));
        table.push(cells);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::super::row::{Fact, Study};
    use super::*;

    #[test]
    fn a_third_of_the_plants_is_taken_by_the_mean_over_studies() {
        let fact = |value: f64| Fact { study: Study::Two, world: World::Still, name: "fit_of_61".to_owned(), value };
        let facts: Vec<Fact> = [0.9, 0.1, 0.2, 0.5, 0.7, 0.6].map(fact).into();
        // Plant 0 fits one study well and the other badly.
        let plants = [(0, 0), (0, 1), (1, 2), (2, 3), (3, 4), (4, 5), (5, 1)];
        let cases = plants.map(|(plant, fact)| Case {
            study: if fact == 1 { Study::Four } else { Study::Two },
            world: World::Still,
            plant,
            rows: Vec::new(),
            facts: vec![&facts[fact]],
        });
        let (chosen, least) = best(&cases, "fit_of_61");
        assert_eq!(chosen, [3, 4], "0.7, 0.6; then 0.5 twice, 0.2 and 0.1");
        assert!((least - 0.6).abs() < 1e-12);
    }
}
