//! What the rows of a method come to.

use std::ops::RangeInclusive;

use page::quantile;

use super::families::{FAMILIES, Family};
use super::results::{Results, Row};
use super::task::BATCHES;

/// Regrets below this share of the range count as equal: a tenth of the smallest noise.
pub(super) const FLOOR: f64 = 0.003;

/// Of fewer campaigns of a family neither percentiles nor errors are given.
const FEWEST: usize = 5;

/// The rows of a family after a batch, in the order of the seeds.
pub(super) fn rows_of<'a>(results: &'a Results, family: &Family, batch: usize) -> Vec<&'a Row> {
    let mut rows: Vec<&Row> =
        results.rows.iter().filter(|row| row.family == family.name && row.batch == batch).collect();
    rows.sort_by_key(|row| row.seed);
    rows.dedup_by_key(|row| row.seed);
    rows
}

/// Median and 90th percentile of the regret; none for fewer than five campaigns.
pub(super) fn regret(results: &Results, family: &Family, batch: usize) -> Option<[f64; 2]> {
    let regrets: Vec<f64> = rows_of(results, family, batch).iter().map(|row| row.regret).collect();
    if regrets.len() < FEWEST {
        return None;
    }
    Some([quantile(&regrets, 0.5)?, quantile(&regrets, 0.9)?])
}

/// The regrets of two methods after a batch of a family, ours first, in the campaigns that both ran.
fn both(ours: &Results, other: &Results, family: &Family, batch: usize) -> Vec<[f64; 2]> {
    both_after([(ours, batch), (other, batch)], family)
}

/// The same, each after a batch of its own.
fn both_after([(ours, own), (other, batch)]: [(&Results, usize); 2], family: &Family) -> Vec<[f64; 2]> {
    let theirs = rows_of(other, family, batch);
    let same = |row: &&Row| theirs.iter().find(|candidate| candidate.seed == row.seed);
    rows_of(ours, family, own).iter().filter_map(|row| Some([row.regret, same(row)?.regret])).collect()
}

/// Share of the campaigns of some families in which no more than a limit is missing after a batch.
pub(super) fn share_within<'a>(
    results: &Results,
    families: impl Iterator<Item = &'a Family>,
    batch: usize,
    limit: f64,
) -> f64 {
    let all: Vec<f64> = families.flat_map(|family| rows_of(results, family, batch)).map(|row| row.regret).collect();
    all.iter().filter(|regret| **regret <= limit).count() as f64 / all.len().max(1) as f64
}

/// How close two methods came in the campaigns that both ran.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Shared {
    pub(super) campaigns: usize,
    /// Share of them in which we miss no more than a limit, and in which they do.
    pub(super) within: [f64; 2],
}

pub(super) fn shared(ours: &Results, other: &Results, batch: usize, limit: f64) -> Shared {
    let all: Vec<[f64; 2]> = FAMILIES.iter().flat_map(|family| both(ours, other, family, batch)).collect();
    let share = |which: usize| all.iter().filter(|pair| pair[which] <= limit).count() as f64 / all.len().max(1) as f64;
    Shared { campaigns: all.len(), within: [share(0), share(1)] }
}

/// In percent of the range, two digits.
pub(super) fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    if percent >= 9.95 { format!("{percent:.0}") } else { format!("{percent:.1}") }
}

/// Our regret beside that of another method on the same pairs of a family: mean of log10 of the ratio, with its standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Paired {
    pub(super) mean: f64,
    pub(super) error: f64,
    /// Number of pairs.
    pub(super) n_pairs: usize,
}

impl Paired {
    /// Of the logarithms of ratios; none for fewer than five.
    pub(super) fn of(ratios: &[f64]) -> Option<Self> {
        if ratios.len() < FEWEST {
            return None;
        }
        let n = ratios.len() as f64;
        let mean = ratios.iter().sum::<f64>() / n;
        let variance = ratios.iter().map(|ratio| (ratio - mean).powi(2)).sum::<f64>() / (n - 1.0);
        Some(Self { mean, error: (variance / n).sqrt(), n_pairs: ratios.len() })
    }

    /// By more than two standard errors.
    pub(super) fn is_ours_better(self) -> bool {
        self.mean < -2.0 * self.error
    }

    pub(super) fn is_theirs_better(self) -> bool {
        self.mean > 2.0 * self.error
    }
}

/// None for fewer than five campaigns. To each regret the floor is added.
pub(super) fn paired(ours: &Results, other: &Results, family: &Family, batch: usize) -> Option<Paired> {
    paired_after([(ours, batch), (other, batch)], family)
}

/// The same, each after a batch of its own.
pub(super) fn paired_after(sides: [(&Results, usize); 2], family: &Family) -> Option<Paired> {
    let ratio = |[ours, theirs]: [f64; 2]| ((ours + FLOOR) / (theirs + FLOOR)).log10();
    Paired::of(&both_after(sides, family).into_iter().map(ratio).collect::<Vec<_>>())
}

/// What was promised after a batch of a family.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Promised {
    pub(super) campaigns: usize,
    /// Campaigns in which more was missing than promised.
    pub(super) breached: usize,
    /// Median of the promise.
    pub(super) width: f64,
    /// The same two, had the surface been believed as it is.
    pub(super) believed: Option<(usize, f64)>,
}

/// Whether more is missing than was promised, and not by rounding.
pub(super) fn is_broken(regret: f64, bound: f64) -> bool {
    regret > bound + 1e-12
}

pub(super) fn promised(results: &Results, family: &Family, batch: usize) -> Option<Promised> {
    let rows = rows_of(results, family, batch);
    let of = |promise: fn(&Row) -> Option<f64>| {
        let promised: Vec<(f64, f64)> =
            rows.iter().filter_map(|row| promise(row).map(|bound| (row.regret, bound))).collect();
        let breached = promised.iter().filter(|(regret, bound)| is_broken(*regret, *bound)).count();
        let width = quantile(&promised.iter().map(|(_, bound)| *bound).collect::<Vec<_>>(), 0.5)?;
        Some((promised.len(), breached, width))
    };
    let (campaigns, breached, width) = of(|row| row.bound)?;
    let believed = of(|row| row.quantile).map(|(_, breached, width)| (breached, width));
    Some(Promised { campaigns, breached, width, believed })
}

/// A promise of less than this can be broken: few designs are worse than the best by more.
pub(super) const TELLING: f64 = 0.3;

/// How many promises of a family were of less than [`TELLING`], after any batch, and how many of those were broken.
pub(super) fn telling(results: &Results, family: &Family) -> [usize; 2] {
    let rows = (1..=BATCHES).flat_map(|batch| rows_of(results, family, batch));
    let promised = rows.filter_map(|row| Some((row.regret, row.bound.filter(|bound| *bound < TELLING)?)));
    promised.fold([0, 0], |[n, broken], (regret, bound)| [n + 1, broken + usize::from(is_broken(regret, bound))])
}

/// After each batch, in percent, the geometric mean over families of the mean regret over the seeds, the floor added to each; none where a
/// campaign is missing.
pub(super) fn typical(results: &Results, families: &[&Family], seeds: &RangeInclusive<u64>) -> Option<Vec<f64>> {
    let log_mean = |family: &Family, batch: usize| {
        let rows = rows_of(results, family, batch);
        let regrets: Vec<f64> = rows.iter().filter(|row| seeds.contains(&row.seed)).map(|row| row.regret).collect();
        let is_whole = regrets.len() == seeds.clone().count() && !regrets.is_empty();
        is_whole.then(|| (regrets.iter().sum::<f64>() / regrets.len() as f64 + FLOOR).ln())
    };
    let after = |batch: usize| {
        let logs = families.iter().map(|family| log_mean(family, batch)).collect::<Option<Vec<f64>>>()?;
        (!logs.is_empty()).then(|| 100.0 * (logs.iter().sum::<f64>() / logs.len() as f64).exp())
    };
    (1..=BATCHES).map(after).collect()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    /// A method with one campaign for each list of regrets, in the first family.
    fn method(campaigns: &[&[(f64, f64)]]) -> anyhow::Result<Results> {
        let mut results = Results::read(Path::new("no such folder"), "none")?;
        for (seed, steps) in (1..).zip(campaigns) {
            for (batch, &(regret, bound)) in (1..).zip(*steps) {
                let (family, bound) = (FAMILIES[0].name.to_owned(), Some(bound));
                results.rows.push(Row { family, seed, batch, regret, bound, ..Row::default() });
            }
        }
        Ok(results)
    }

    #[test]
    fn promises_are_broken_by_more_than_rounding() -> anyhow::Result<()> {
        let results = method(&[&[(0.1, 0.1)], &[(0.2, 0.1)], &[(0.0, 0.3)]])?;
        let found = promised(&results, &FAMILIES[0], 1).map(|found| (found.campaigns, found.breached, found.width));
        assert_eq!(found, Some((3, 1, 0.1)));
        assert_eq!(promised(&results, &FAMILIES[0], 2), None);
        assert_eq!(telling(&results, &FAMILIES[0]), [2, 1], "the third is too wide to count");
        Ok(())
    }

    #[test]
    fn pairs_are_of_the_seeds_that_both_ran() -> anyhow::Result<()> {
        let [near, far]: [&[(f64, f64)]; 2] = [&[(0.007, 1.0)], &[(0.097, 1.0)]];
        let ours = method(&[near, far, near, far, near, &[(0.5, 1.0)]])?;
        let theirs = method(&[far, &[(0.997, 1.0)], far, &[(0.997, 1.0)], far])?;
        let found =
            paired(&ours, &theirs, &FAMILIES[0], 1).map(|found| (found.mean, found.error, found.is_ours_better()));
        assert!(matches!(found, Some((mean, error, true)) if (mean + 1.0).abs() < 1e-9 && error < 1e-9), "{found:?}");
        let shared = shared(&ours, &theirs, 1, 0.1);
        assert_eq!((shared.campaigns, shared.within), (5, [1.0, 0.6]));
        assert_eq!(paired(&ours, &method(&[near, far, near, far])?, &FAMILIES[0], 1), None);
        Ok(())
    }
}
