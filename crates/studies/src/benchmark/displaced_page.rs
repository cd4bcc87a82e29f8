//! The part of the page on simulations that are right of another design.

use std::ops::RangeInclusive;

use page::{Column, Finding, Table};

use super::families::{DISPLACED, Family, names};
use super::figure::{PICTURED, Regrets};
use super::methods::{DEAR, METHODS};
use super::results::{Beside, Displaced, Results, Row};
use super::summary::{FLOOR, Paired, paired, percent, promised, regret, typical};
use super::task::{BATCHES, DISPLACED_SEEDS};

pub(super) const PICTURE: &str = "docs/results-displaced.svg";
/// Batches after which is compared.
const AFTER: [usize; 3] = [1, 3, BATCHES];

/// Regret, beside those that take the simulation as it stands or know experiments only; and what was promised.
pub(super) fn section(kept: &Displaced) -> String {
    let mut text = format!(
        "\n## Where the simulation is displaced\n\nFamilies whose simulation is right of another design, seeds {} to {}, on which nothing was \
         tuned: median and 90th percentile of the regret, in % of the range, and in brackets the mean of log10(regret of the pooled loop / \
         regret of the other) with its standard error, and how many seeds both ran. BoTorch knows experiments only.\n\n",
        DISPLACED_SEEDS.start(),
        DISPLACED_SEEDS.end()
    );
    text += &format!(
        "![Regret where the simulation is displaced](results-displaced.svg)\n\nGeometric mean over families of the mean over the seeds that all ran, \
         {} % added to each: {}; {}.\n\n",
        percent(FLOOR),
        Pictured::of(kept, PICTURED[0]).words(),
        Pictured::of(kept, PICTURED[1]).words(),
    );
    text += &regrets(&kept.cheap).markdown();
    text += &format!(
        "\nThe same where the simulation is dear: {DEAR} runs of it a parameter and batch, as many as the shell makes of a program if nothing is \
         said, and a surface through those.\n\n"
    );
    text += &regrets(&kept.dear).markdown();
    text += "\nIts certificate there: in how many campaigns it was broken after each batch, and the median of c in % of the range.\n\n";
    text += &certificates(kept).markdown();
    text += "\nHow far the simulation is displaced, where the results are sure of it: in how many of the batches they are, along how many axes together \
             the true displacement lies in the band that is said (nine in ten), and the share.\n\n";
    text += &bands(kept).markdown();
    text
}

/// Families of a number of parameters, and the seeds from the first on that all ran.
struct Pictured {
    families: Vec<&'static Family>,
    seeds: RangeInclusive<u64>,
}

impl Pictured {
    fn of(kept: &Displaced, n_factors: usize) -> Self {
        let families: Vec<&Family> = DISPLACED.iter().filter(|family| family.n_factors == n_factors).collect();
        let of_each = [&kept.cheap, &kept.dear];
        let all =
            || of_each.iter().flat_map(|one| [&one.ours].into_iter().chain(one.others.iter().map(|(_, other)| other)));
        let ran = |seed: &u64| all().all(|results| families.iter().all(|family| results.has(family.name, *seed)));
        let n = DISPLACED_SEEDS.take_while(ran).count() as u64;
        Self { families, seeds: *DISPLACED_SEEDS.start()..=DISPLACED_SEEDS.start() + n - 1 }
    }

    fn words(&self) -> String {
        format!("{}, seeds {} to {}", names(&self.families), self.seeds.start(), self.seeds.end())
    }
}

pub(super) fn picture(kept: &Displaced) -> String {
    let ways = [(&kept.cheap, "all simulated"), (&kept.dear, "few simulated")];
    let panels = PICTURED.into_iter().flat_map(|n_factors| {
        ways.map(|(one, which)| {
            let Pictured { families, seeds } = Pictured::of(kept, n_factors);
            let ours = [(METHODS[0].words, &one.ours)].into_iter();
            let all = ours.chain(one.others.iter().map(|(words, results)| (*words, results)));
            let curves =
                all.filter_map(|(words, results)| Some((words, typical(results, &families, &seeds)?))).collect();
            (format!("{n_factors} parameters, {which}"), curves)
        })
    });
    let title = "How much worse the recommended design is than the best, where the simulation is displaced";
    Regrets { title, panels: panels.collect(), is_one_scale: true }.picture()
}

fn bands(kept: &Displaced) -> Table {
    let heads = ["family", "simulated", "batches", "sure", "axes", "in their band", "share, %"];
    let mut table = Table::new(heads.map(Column::words).to_vec());
    for (words, one) in [("all", &kept.cheap), ("few", &kept.dear)] {
        for family in &DISPLACED {
            let told = Told::of(one.ours.rows.iter().filter(|row| row.family == family.name));
            table.push(vec![
                family.name.to_owned(),
                words.to_owned(),
                told.batches.to_string(),
                told.sure.to_string(),
                told.axes.to_string(),
                told.hold.to_string(),
                told.share().map_or_else(|| "–".to_owned(), percent),
            ]);
        }
    }
    table
}

/// How often it is said how far a simulation is displaced, and how often that holds.
#[derive(Debug, Clone, Copy, Default)]
struct Told {
    batches: usize,
    sure: usize,
    axes: usize,
    hold: usize,
}

impl Told {
    fn of<'r>(rows: impl Iterator<Item = &'r Row>) -> Self {
        rows.fold(Self::default(), |sum, row| Self {
            batches: sum.batches + 1,
            sure: sum.sure + usize::from(row.bands.is_some()),
            axes: sum.axes + row.bands.unwrap_or(0),
            hold: sum.hold + row.bands_hold.unwrap_or(0),
        })
    }

    fn share(self) -> Option<f64> {
        (self.axes > 0).then(|| self.hold as f64 / self.axes as f64)
    }
}

fn regrets(kept: &Beside) -> Table {
    let mut columns = ["family", "after batch", "pooled loop"].map(Column::words).to_vec();
    columns.extend(kept.others.iter().map(|(words, _)| Column::words(words)));
    let mut table = Table::new(columns);
    for family in &DISPLACED {
        for batch in AFTER {
            let mut row = vec![family.name.to_owned(), batch.to_string(), both(&kept.ours, family, batch)];
            row.extend(kept.others.iter().map(|(_, other)| {
                let there = both(other, family, batch);
                paired(&kept.ours, other, family, batch).map_or(there.clone(), |pair| {
                    format!("{there} ({:+.2} ± {:.2}, {})", pair.mean, pair.error, pair.n_pairs)
                })
            }));
            table.push(row);
        }
    }
    table
}

fn both(results: &Results, family: &Family, batch: usize) -> String {
    match regret(results, family, batch) {
        Some([median, most]) => format!("{} / {}", percent(median), percent(most)),
        None => "–".to_owned(),
    }
}

fn certificates(kept: &Displaced) -> Table {
    let heads = ["family", "simulated", "campaigns", "broken, by batch", "median c, by batch"];
    let mut table = Table::new(heads.map(Column::words).to_vec());
    for (words, one) in [("all", &kept.cheap), ("few", &kept.dear)] {
        for family in &DISPLACED {
            let of_each: Vec<_> = (1..=BATCHES).filter_map(|batch| promised(&one.ours, family, batch)).collect();
            let list = |of: &dyn Fn(usize) -> String| (0..of_each.len()).map(of).collect::<Vec<_>>().join(", ");
            table.push(vec![
                family.name.to_owned(),
                words.to_owned(),
                of_each.first().map_or(0, |one| one.campaigns).to_string(),
                list(&|batch| of_each[batch].breached.to_string()),
                list(&|batch| percent(of_each[batch].width)),
            ]);
        }
    }
    table
}

/// In how many families less is missing, and more, by more than two standard errors; and how often the certificate was broken.
pub(super) fn finding(kept: &Displaced) -> Finding {
    let head = "Where the simulation is right of another design, by more than two standard errors:";
    let of_all = kept.cheap.others.iter().map(|(words, other)| against(&kept.cheap.ours, words, other, ""));
    let of_few = kept
        .dear
        .others
        .iter()
        .map(|(words, other)| against(&kept.dear.ours, words, other, ", where few are simulated"));
    let certificate = [&kept.cheap, &kept.dear].map(|one| {
        let promises = DISPLACED.iter().map(|family| {
            let of_family = (1..=BATCHES).filter_map(|batch| promised(&one.ours, family, batch));
            let sum = of_family.fold([0, 0], |[n, broken], one| [n + one.campaigns, broken + one.breached]);
            (family.name, sum)
        });
        let promises: Vec<(&str, [usize; 2])> = promises.collect();
        let [n, broken] = promises.iter().fold([0, 0], |[n, broken], (_, one)| [n + one[0], broken + one[1]]);
        let most = promises.iter().max_by_key(|(_, [_, broken])| *broken);
        most.map_or_else(String::new, |(name, [n_there, broken_there])| {
            format!("after {broken} of {n} batches, most often on `{name}`, {broken_there} of {n_there}")
        })
    });
    let [all, few] = certificate;
    let certificate = Finding::new(format!("Its certificate was broken {all}; where few are simulated {few}."));
    of_all.chain(of_few).fold(Finding::new(head), Finding::detail).detail(certificate).detail(told(kept))
}

/// How often the band of a displacement holds.
fn told(kept: &Displaced) -> Finding {
    let [all, few] = [&kept.cheap, &kept.dear].map(|one| Told::of(one.ours.rows.iter()));
    let words = |told: Told| {
        let share = told.share().map_or_else(|| "–".to_owned(), percent);
        format!("{} % of {} axes, sure in {} of {} batches", share, told.axes, told.sure, told.batches)
    };
    Finding::new(format!(
        "How far it is displaced lies in the band of nine in ten that is said along {}; where few are simulated along {}.",
        words(all),
        words(few)
    ))
}

fn against(ours: &Results, words: &str, other: &Results, which: &str) -> Finding {
    let after = AFTER.map(|batch| {
        // Those that the other ran, too.
        let both: Vec<Paired> = DISPLACED.iter().filter_map(|family| paired(ours, other, family, batch)).collect();
        let count = |is_so: fn(Paired) -> bool| both.iter().filter(|pair| is_so(**pair)).count();
        let (less, more) = (count(Paired::is_ours_better), count(Paired::is_theirs_better));
        format!("after batch {batch} less in {less} of {}, more in {more}", both.len())
    });
    Finding::new(format!("What is missing, against {words}{which}: {}.", after.join("; ")))
}
