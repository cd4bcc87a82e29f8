//! What becomes of the claims on those plants alone whose models are worth most, beside as many plants drawn at random.

use page::{Column, Table, quantile};
use rand::{SeedableRng as _, seq::SliceRandom as _};
use rand_chacha::ChaCha8Rng;

use super::judge::Judged;
use super::kept::Case;
use super::row::World;
use super::tables::Both;
use crate::rules::Verdict;
use crate::words::{PLANTS, counted, number};

/// One in so many plants is taken.
const ONE_IN: usize = 3;
/// Draws of as many plants at random.
pub(super) const N_DRAWS: usize = 999;

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

/// The plants that anything was judged on.
fn plants_of(all: &[&Judged]) -> Vec<u64> {
    let mut plants: Vec<u64> = all.iter().flat_map(|judged| &judged.shares).map(|share| share.plant).collect();
    plants.sort_unstable();
    plants.dedup();
    plants
}

/// How many verdicts change on so many of the plants drawn at random, median and nine tenths of the draws.
pub(super) fn by_chance(all: &[&Judged], n: usize) -> [f64; 2] {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut order = plants_of(all);
    let n = n.min(order.len());
    let counts: Vec<f64> = (0..N_DRAWS)
        .map(|_| {
            order.shuffle(&mut rng);
            let changes = |judged: &&&Judged| judged.among(&order[..n]).verdict() != judged.verdict();
            all.iter().filter(changes).count() as f64
        })
        .collect();
    [0.5, 0.9].map(|share| quantile(&counts, share).unwrap_or(f64::NAN))
}

/// The section; nothing where there are not as many plants that one can be taken.
pub(super) fn section(all: &[Both], cases: &[Case<'_>]) -> String {
    let chosen = WORTH.map(|(fact, _)| best(cases, fact));
    let n = chosen[0].0.len();
    if chosen.iter().any(|(plants, _)| plants.is_empty()) {
        return String::new();
    }
    let mut rows = Vec::new();
    for both in all {
        for (world, judged) in both.judged.iter().enumerate() {
            // Without any: it is about designs of experiments, and about no plant.
            if !judged.shares.is_empty() {
                rows.push(Row { both, world, chosen: chosen.iter().map(|(plants, _)| judged.among(plants)).collect() });
            }
        }
    }
    let least = |k: usize| number(chosen[k].1, 2);
    let mut text = format!(
        "\n## On the plants with the better models\n\nWhat a model is worth was no evidence in the calibration: only the published rows are. The dissertation's \
         spaces shrank to 15 and 20 %, so its surfaces may have fitted better than ours. Here the claims are judged once more on {n} of the plants alone: those of \
         the highest rank correlation of model and stand-in, at least {} (none is good), and those where the regressor (61) fits best, R² at least {}; means \
         over the studies, in still water. For the rank correlation the stand-in is flown at the points of a Sobol sequence and the model taken at the nearest cell \
         of its grid, up to half a level away in each parameter. Claims about designs of experiments know no plant and are left out.\n\n",
        least(0),
        least(1)
    );
    text += &counts(&rows).markdown();
    let changed = |row: &&Row<'_>, k: usize| row.chosen[k].verdict() != row.all().verdict();
    let [by_rank, by_fit] = [0, 1].map(|k| rows.iter().filter(|row| changed(row, k)).count());
    let on_all: Vec<&Judged> = rows.iter().map(Row::all).collect();
    let [median, most] = by_chance(&on_all, n);
    text += &format!(
        "\nOf {} verdicts {by_rank} change with the rank correlation and {by_fit} with R²; on {} drawn at random {median} do in the median of {N_DRAWS} \
         draws, and up to {most} in nine of ten.",
        rows.len(),
        counted(n, PLANTS)
    );
    let changed: Vec<&Row<'_>> =
        rows.iter().filter(|row| row.verdicts().any(|verdict| verdict != row.all().verdict())).collect();
    if changed.is_empty() {
        text += "\n";
    } else {
        text += &format!(" What changes, with what chance would give:\n\n{}", changes(&changed, n).markdown());
    }
    text
}

/// How many claims become what.
fn counts(rows: &[Row<'_>]) -> Table {
    let mut heads = vec![Column::new("Verdict", ""), Column::new("All plants", "claims")];
    heads.extend(WORTH.map(|(_, words)| Column::new(&format!("best by {words}"), "claims")));
    let mut table = Table::new(heads);
    for verdict in
        [Verdict::InKind, Verdict::InPart, Verdict::NotReproduced, Verdict::NotDiscriminating, Verdict::OutOfReach]
    {
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
    let cell = |judged: &Judged| match judged.by_rule {
        Some(rule) => format!("{}, {}{}", rule.verdict().short(), rule.count, rule.chance_words()),
        None => "–".to_owned(),
    };
    for row in rows {
        let mut cells = vec![
            format!("{}: {}", row.both.claim.place, row.both.claim.words()),
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
