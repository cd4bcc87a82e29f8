//! When campaigns stop, by each of the numbers that they may stop by, and how well that is foretold.

use infuse::pooled::Forecast;
use page::{Column, Finding, Table};

use super::families::{FAMILIES, Family};
use super::results::{Fresh, Results, Row};
use super::summary::{percent, rows_of};
use super::task::{BATCHES, FRESH_SEEDS, fresh_families};

/// What another batch is worth where it is asked when a campaign would stop, of the range of the truth.
pub(super) const WORTH: f64 = 0.02;
/// The same where it is asked how many batches that takes.
const WORTHS: [f64; 3] = [WORTH, 0.05, 0.1];

/// What is promised: no design is better than the recommended one by more.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Promise {
    /// The bound of the certificate.
    Bound,
    /// The same without what is held for a narrow well that no run has met.
    WithoutReserve,
    /// What the surface says.
    Surface,
}

impl Promise {
    const ALL: [Self; 3] = [Self::Bound, Self::WithoutReserve, Self::Surface];

    fn of(self, row: &Row) -> Option<f64> {
        match self {
            Self::Bound => row.bound,
            Self::WithoutReserve => row.drawn,
            Self::Surface => row.quantile,
        }
    }

    fn words(self) -> &'static str {
        match self {
            Self::Bound => "bound",
            Self::WithoutReserve => "bound without the reserve",
            Self::Surface => "surface alone",
        }
    }

    /// How many further batches it is expected to take.
    fn further_batches(self, forecast: &Forecast, worth: f64) -> Option<u64> {
        match self {
            Self::Bound => forecast.further_batches(worth),
            Self::WithoutReserve => Forecast { spread: 0.0, found: 0.0, ..*forecast }.further_batches(worth),
            Self::Surface => Forecast { found: 0.0, ..*forecast }.further_batches_by_the_surface(worth),
        }
    }
}

/// Campaigns that would have stopped when the promise was at most [`WORTH`].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Stops {
    pub(super) campaigns: usize,
    pub(super) stopped: usize,
    /// Of these, more was missing than that.
    pub(super) too_early: usize,
    /// Of these, no more was missing than that from a batch before the stop on.
    late: usize,
    /// Campaigns that did not stop, and at the end missed no more.
    unaware: usize,
    /// Batches until the stop, sum over those that stopped.
    batches: usize,
}

impl Stops {
    fn and(self, other: Self) -> Self {
        Self {
            campaigns: self.campaigns + other.campaigns,
            stopped: self.stopped + other.stopped,
            too_early: self.too_early + other.too_early,
            late: self.late + other.late,
            unaware: self.unaware + other.unaware,
            batches: self.batches + other.batches,
        }
    }

    fn mean_batches(self) -> String {
        match self.stopped {
            0 => "–".to_owned(),
            stopped => format!("{:.1}", self.batches as f64 / stopped as f64),
        }
    }

    /// In percent of those that stopped.
    fn share_too_early(self) -> String {
        percent(self.too_early as f64 / self.stopped.max(1) as f64)
    }

    fn cells(self) -> [String; 6] {
        let Self { campaigns, stopped, too_early, late, unaware, .. } = self;
        let [campaigns, stopped, too_early, late, unaware] =
            [campaigns, stopped, too_early, late, unaware].map(|count| count.to_string());
        [campaigns, stopped, too_early, late, self.mean_batches(), unaware]
    }
}

const HEADS: [&str; 6] = ["campaigns", "stopped", "too early", "late", "batches", "close, not stopped"];

pub(super) fn stops(results: &Results, family: &Family, by: Promise) -> Stops {
    let mut stops = Stops::default();
    for first in rows_of(results, family, 1) {
        let rows = results.of(family.name, first.seed);
        let Some(last) = rows.last() else { continue };
        stops.campaigns += 1;
        match rows.iter().find(|row| by.of(row).is_some_and(|promise| promise <= WORTH)) {
            Some(stop) => {
                let before = rows.iter().find(|row| row.batch + 1 == stop.batch);
                stops.stopped += 1;
                stops.too_early += usize::from(stop.regret > WORTH);
                stops.late += usize::from(before.is_some_and(|row| row.regret.max(stop.regret) <= WORTH));
                stops.batches += stop.batch;
            }
            None => stops.unaware += usize::from(last.regret <= WORTH),
        }
    }
    stops
}

fn stops_of_all<'a>(results: &Results, families: impl Iterator<Item = &'a Family>, by: Promise) -> Stops {
    families.map(|family| stops(results, family, by)).fold(Stops::default(), Stops::and)
}

/// How many further batches were expected until the promise was at most what another one is worth, and how many it took.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Forecasts {
    /// Those of which it is known: the campaign came to it, or was not there yet when it was to be.
    known: usize,
    right: usize,
    /// Of the others, by one batch.
    off_by_one: usize,
    /// By two or more, and those of which it is only known that they were too low.
    too_few: usize,
    /// By two or more.
    too_many: usize,
}

/// Those of all campaigns of some families, made after a batch.
fn forecasts<'a>(
    results: &Results,
    families: impl Iterator<Item = &'a Family>,
    after: usize,
    worth: f64,
    by: Promise,
) -> Forecasts {
    let mut found = Forecasts::default();
    for family in families {
        for row in rows_of(results, family, after) {
            let Some(forecast) = row.forecast(family) else { continue };
            // Where there is no forecast, it is beyond the end.
            let expected = by.further_batches(&forecast, worth).map_or(usize::MAX, |batches| batches as usize);
            if expected == 0 {
                continue;
            }
            let rows = results.of(family.name, row.seed);
            let enough = |row: &&Row| row.batch > after && by.of(row).is_some_and(|promise| promise <= worth);
            let took = rows.iter().filter(enough).map(|row| row.batch - after).min();
            let last = rows.iter().map(|row| row.batch - after.min(row.batch)).max().unwrap_or(0);
            match took {
                None if expected > last => continue,
                None => found.too_few += 1,
                Some(took) if took == expected => found.right += 1,
                Some(took) if took.abs_diff(expected) == 1 => found.off_by_one += 1,
                Some(took) if took > expected => found.too_few += 1,
                Some(_) => found.too_many += 1,
            }
            found.known += 1;
        }
    }
    found
}

/// When campaigns stop that ask what another batch is worth.
pub(super) fn finding(ours: &Results, fresh: &Fresh) -> Finding {
    let all = |by| stops_of_all(ours, FAMILIES.iter(), by);
    let by_the_bound = all(Promise::Bound);
    let head = Finding::new(format!(
        "If another batch has to be worth {} % of the range, {} of {} campaigns stop within {BATCHES} batches, after {} in the mean:",
        100.0 * WORTH,
        by_the_bound.stopped,
        by_the_bound.campaigns,
        by_the_bound.mean_batches()
    ));
    let alone = all(Promise::Surface);
    let misled = stops_of_all(&fresh.ours, fresh_families(), Promise::Surface);
    let details = [
        format!("{} of them too early, with more than that missing.", by_the_bound.too_early),
        format!("{} at least a batch later than an oracle would.", by_the_bound.late),
        format!("Of the others {} had come as close without knowing it.", by_the_bound.unaware),
        format!(
            "By what the surface alone says, as `by` = \"surface\" in [stop] has it, {} would, after {}, {} of them too early ({} %); where \
             the simulation misleads {} of {}, {} of them too early ({} %): [more](#stopping).",
            alone.stopped,
            alone.mean_batches(),
            alone.too_early,
            alone.share_too_early(),
            misled.stopped,
            misled.campaigns,
            misled.too_early,
            misled.share_too_early()
        ),
    ];
    head.with_sentences(details)
}

/// The part of the page on stops.
pub(super) fn section(ours: &Results, fresh: &Fresh, untold: Option<&Results>) -> String {
    let mut text = format!(
        "\n## Stopping\n\nIf another batch has to be worth {} % of the range: campaigns that stop within {BATCHES} batches, those of them \
         that stop with more than that missing (too early), those that missed no more a batch before already (late), the mean number of \
         batches until the stop, and the campaigns that go on to the end although no more is missing then. By three promises: the bound of the \
         certificate, by which a campaign stops; the same without what is held for a narrow well that no run has met, which `smooth` in [stop] \
         takes away; and what the surface alone says, by which it stops with `by` = \"surface\". Only the promises are compared: in a campaign \
         a find that was not looked around yet, and a measurement that speaks against the recommendation, keep it going, too.\n\n",
        100.0 * WORTH
    );
    text += &by_promise_table(ours, fresh, untold).markdown();
    text += "\nBy family, by the bound:\n\n";
    text += &by_family_table(ours, FAMILIES.iter(), Promise::Bound).markdown();
    text += "\nBy the surface alone:\n\n";
    text += &by_family_table(ours, FAMILIES.iter(), Promise::Surface).markdown();
    text += &format!(
        "\nBy the surface alone where the simulation misleads, seeds {} to {}:\n\n",
        FRESH_SEEDS.start(),
        FRESH_SEEDS.end()
    );
    text += &by_family_table(&fresh.ours, fresh_families(), Promise::Surface).markdown();
    text += &format!(
        "\n### How many more batches it expects\n\nWhat is drawn from the surface is taken to fall as the number of experiments to the power of \
         2.5, near what it did in the median of these campaigns; what is held in reserve until twenty designs a parameter were run falls as it is \
         defined, with as many repeats as there were; and what the surface alone says as the number of experiments to the power of 1.5, chosen \
         on these campaigns. Forecasts of how many batches it takes until the \
         promise is at most {}, {} or {} % of the range, of which the end is known: right, off by one batch, too few by two or more (those \
         among them that should have come true and had not by the end), too many by two or more. Forecasts beyond batch {BATCHES} that had not \
         come true by then are left out. On campaigns on which nothing else was chosen: \
         `{}`, seeds {} to {}.\n\n",
        100.0 * WORTHS[0],
        100.0 * WORTHS[1],
        100.0 * WORTHS[2],
        fresh_families().map(|family| family.name).collect::<Vec<_>>().join("`, `"),
        FRESH_SEEDS.start(),
        FRESH_SEEDS.end()
    );
    text += &forecasts_table(ours, &fresh.ours).markdown();
    text
}

fn by_promise_table(ours: &Results, fresh: &Fresh, untold: Option<&Results>) -> Table {
    let heads = ["stops by", "campaigns of"].iter().chain(&HEADS).map(|head| Column::words(head));
    let mut table = Table::new(heads.collect());
    for by in Promise::ALL {
        let all = Some(("all families", stops_of_all(ours, FAMILIES.iter(), by)));
        let alone = untold.map(|untold| ("all families, no simulation", stops_of_all(untold, FAMILIES.iter(), by)));
        let misled = Some(("where the simulation misleads", stops_of_all(&fresh.ours, fresh_families(), by)));
        for (words, found) in [all, alone, misled].into_iter().flatten() {
            table.push([&[by.words().to_owned(), words.to_owned()][..], &found.cells()].concat());
        }
    }
    table
}

fn by_family_table<'a>(results: &Results, families: impl Iterator<Item = &'a Family>, by: Promise) -> Table {
    let heads = ["family"].iter().chain(&HEADS).map(|head| Column::words(head));
    let mut table = Table::new(heads.collect());
    let mut push = |name: &str, stops: Stops| table.push([&[name.to_owned()][..], &stops.cells()].concat());
    let mut all = Stops::default();
    for family in families {
        let of_family = stops(results, family, by);
        push(family.name, of_family);
        all = all.and(of_family);
    }
    push("all", all);
    table
}

fn forecasts_table(ours: &Results, fresh: &Results) -> Table {
    let heads =
        ["of", "campaigns", "after batch", "forecasts", "right, %", "off by one, %", "too few, %", "too many, %"];
    let mut table = Table::new(heads.map(Column::words).to_vec());
    let fresh_ones: Vec<&Family> = fresh_families().collect();
    for by in [Promise::Bound, Promise::Surface] {
        for (name, results, families) in
            [("all families", ours, FAMILIES.iter().collect()), ("nothing else chosen", fresh, fresh_ones.clone())]
        {
            for after in 1..BATCHES {
                let of_each = WORTHS.map(|worth| forecasts(results, families.iter().copied(), after, worth, by));
                let sum = |of: fn(&Forecasts) -> usize| of_each.iter().map(of).sum::<usize>();
                let known = sum(|one| one.known);
                let share = |n: usize| format!("{:.0}", 100.0 * n as f64 / known.max(1) as f64);
                let shares =
                    [sum(|one| one.right), sum(|one| one.off_by_one), sum(|one| one.too_few), sum(|one| one.too_many)];
                let head = [by.words().to_owned(), name.to_owned(), after.to_string(), known.to_string()];
                table.push([&head[..], &shares.map(share)].concat());
            }
        }
    }
    table
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    /// A method with one campaign for each list of regrets, bounds and what the surface says, in the first family.
    fn method(campaigns: &[&[(f64, f64, f64)]]) -> anyhow::Result<Results> {
        let mut results = Results::read(Path::new("no such folder"), "none")?;
        for (seed, steps) in (1..).zip(campaigns) {
            for (batch, &(regret, bound, quantile)) in (1..).zip(*steps) {
                results.rows.push(Row {
                    family: FAMILIES[0].name.to_owned(),
                    seed,
                    batch,
                    regret,
                    bound: Some(bound),
                    quantile: Some(quantile),
                    drawn: Some(bound),
                    spread: Some(0.0),
                    tried: Some(batch),
                    ..Row::default()
                });
            }
        }
        Ok(results)
    }

    #[test]
    fn stops_are_in_time_too_early_late_or_missing() -> anyhow::Result<()> {
        let results = method(&[
            &[(0.1, 0.3, 0.02), (0.01, 0.02, 0.02), (0.0, 0.01, 0.01)],
            &[(0.1, 0.3, 0.03), (0.03, 0.02, 0.01), (0.0, 0.01, 0.0)],
            &[(0.01, 0.3, 0.01), (0.01, 0.1, 0.01), (0.0, 0.01, 0.01)],
            &[(0.1, 0.3, 0.1), (0.1, 0.2, 0.05), (0.0, 0.1, 0.02)],
        ])?;
        let found = stops(&results, &FAMILIES[0], Promise::Bound);
        let expected = Stops { campaigns: 4, stopped: 3, too_early: 1, late: 1, unaware: 1, batches: 7 };
        assert_eq!(found, expected);
        assert_eq!(stops(&results, &FAMILIES[0], Promise::WithoutReserve), expected, "nothing is held here");
        let found = stops(&results, &FAMILIES[0], Promise::Surface);
        assert_eq!(found, Stops { campaigns: 4, stopped: 4, too_early: 2, late: 0, unaware: 0, batches: 7 });
        Ok(())
    }

    /// By the power of 2.5, from 8 % to 2 % after one batch takes one more, from 50 % three; by that of 1.5 from 8 % two.
    #[test]
    fn forecasts_are_right_too_low_or_too_high() -> anyhow::Result<()> {
        let steps = |[first, second, third]: [f64; 3]| [first, second, third].map(|promise| (0.0, promise, promise));
        let campaigns = [
            [0.08, 0.02, 0.01],
            [0.08, 0.03, 0.02],
            [0.08, 0.04, 0.03],
            [0.5, 0.02, 0.01],
            [0.5, 0.4, 0.3],
            [0.01, 0.01, 0.01],
        ]
        .map(steps);
        let results = method(&campaigns.each_ref().map(|steps| &steps[..]))?;
        let found = forecasts(&results, FAMILIES.iter(), 1, 0.02, Promise::Bound);
        assert_eq!(found, Forecasts { known: 4, right: 1, off_by_one: 1, too_few: 1, too_many: 1 });
        let found = forecasts(&results, FAMILIES.iter(), 1, 0.02, Promise::Surface);
        assert_eq!(found, Forecasts { known: 4, right: 1, off_by_one: 1, too_few: 1, too_many: 1 });
        Ok(())
    }
}
