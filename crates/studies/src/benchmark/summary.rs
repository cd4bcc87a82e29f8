//! What the rows of a method come to.

use page::quantile;

use super::families::Family;
use super::results::{Results, Row};
use super::task::{BATCHES, SEEDS};

/// Regrets below this share of the range count as equal: a tenth of the smallest noise.
const FLOOR: f64 = 0.003;

/// The rows of a family after a batch, in the order of the seeds.
pub(super) fn rows_of<'a>(results: &'a Results, family: &Family, batch: usize) -> Vec<&'a Row> {
    let mut rows: Vec<&Row> =
        results.rows.iter().filter(|row| row.family == family.name && row.batch == batch).collect();
    rows.sort_by_key(|row| row.seed);
    rows.dedup_by_key(|row| row.seed);
    rows
}

/// Median and 90th percentile of the regret.
pub(super) fn regret(results: &Results, family: &Family, batch: usize) -> Option<[f64; 2]> {
    let regrets: Vec<f64> = rows_of(results, family, batch).iter().map(|row| row.regret).collect();
    Some([quantile(&regrets, 0.5)?, quantile(&regrets, 0.9)?])
}

/// Mean and standard error of log10 of our regret over that of another, both on the same pairs; regrets below the floor count as
/// the floor.
pub(super) fn paired(
    ours: &Results,
    other: &Results,
    family: &Family,
    batch: usize,
    batch_of_other: usize,
) -> Option<[f64; 2]> {
    let (a, b) = (rows_of(ours, family, batch), rows_of(other, family, batch_of_other));
    let ratio = |row: &&Row| {
        let same = b.iter().find(|candidate| candidate.seed == row.seed)?;
        Some(((row.regret + FLOOR) / (same.regret + FLOOR)).log10())
    };
    let ratios: Vec<f64> = a.iter().filter_map(ratio).collect();
    let n = ratios.len() as f64;
    if n < 2.0 {
        return None;
    }
    let mean = ratios.iter().sum::<f64>() / n;
    let variance = ratios.iter().map(|ratio| (ratio - mean).powi(2)).sum::<f64>() / (n - 1.0);
    Some([mean, (variance / n).sqrt()])
}

/// Share of the campaigns in which more was missing than promised, and the median of the promise.
pub(super) fn certificate(results: &Results, family: &Family, batch: usize) -> Option<[f64; 2]> {
    let rows = rows_of(results, family, batch);
    let promised: Vec<(f64, f64)> = rows.iter().filter_map(|row| row.bound.map(|bound| (row.regret, bound))).collect();
    let breached = promised.iter().filter(|(regret, bound)| regret > &(bound + 1e-12)).count();
    let width = quantile(&promised.iter().map(|(_, bound)| *bound).collect::<Vec<_>>(), 0.5)?;
    Some([breached as f64 / promised.len() as f64, width])
}

/// Campaigns that would have stopped when the promise was at most `worth`.
pub(super) struct Stops {
    pub(super) stopped: usize,
    /// Of these, more was missing than `worth`.
    pub(super) too_early: usize,
    /// Campaigns in which no more was missing than `worth` a batch or more before the stop, or at the end without one.
    pub(super) late: usize,
    /// Batches until the stop, mean over those that stopped.
    pub(super) batches: f64,
}

pub(super) fn stops(results: &Results, family: &Family, worth: f64) -> Stops {
    let mut stops = Stops { stopped: 0, too_early: 0, late: 0, batches: 0.0 };
    for seed in 1..=SEEDS {
        let rows = results.of(family.name, seed);
        let stop = rows.iter().find(|row| row.bound.is_some_and(|bound| bound <= worth));
        let good_from = (1..=BATCHES).find(|&batch| rows.iter().all(|row| row.batch < batch || row.regret <= worth));
        if let Some(stop) = stop {
            stops.stopped += 1;
            stops.too_early += usize::from(stop.regret > worth);
            stops.batches += stop.batch as f64;
        }
        let end = stop.map_or(BATCHES + 1, |stop| stop.batch);
        stops.late += usize::from(!rows.is_empty() && good_from.is_some_and(|good| good < end));
    }
    stops.batches /= stops.stopped.max(1) as f64;
    stops
}

/// Geometric mean over families of the median regret, each at least the floor.
pub(super) fn typical(results: &Results, families: &[&Family], batch: usize) -> Option<f64> {
    let medians: Vec<f64> = families
        .iter()
        .map(|family| regret(results, family, batch).map(|[median, _]| median))
        .collect::<Option<_>>()?;
    let logs: f64 = medians.iter().map(|median| (median.max(0.0) + FLOOR).ln()).sum();
    Some((logs / medians.len().max(1) as f64).exp())
}
