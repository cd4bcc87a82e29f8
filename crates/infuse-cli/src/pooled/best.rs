//! The design that measured best. Where runs of a batch share an error that is taken in, results are compared without it.

use std::cmp::Ordering;

use infuse::pooled::Assessment;
use infuse::pooled::reported::Block;
use page::Finding;
use serde_json::{Value, json};

use super::bands::resolution;
use super::campaign::{Campaign, Origin};
use super::drift::named_block;
use crate::campaign::Reading;
use crate::wording::all_of;

/// The design that measured best.
#[derive(Debug, Clone)]
pub(super) struct BestMeasured {
    /// Its best run.
    pub(super) origin: Origin,
    /// Of its runs, in the mean, as measured: of many runs the best is a lucky one.
    pub(super) cost: f64,
    pub(super) n_runs: usize,
    /// As they were made, natural.
    pub(super) settings: Vec<f64>,
    pub(super) off: Off,
}

/// By how much some runs are off with all others of their blocks, as far as that is taken in.
#[derive(Debug, Clone, Default)]
pub(super) struct Off {
    /// In the mean of them, of costs.
    pub(super) by: f64,
    /// Whose runs they are; none where nothing is taken in.
    blocks: Vec<Block>,
}

/// Whether results are compared without what their batches are off by. Of one block alone nobody knows how far it is off.
pub(super) fn has_shifts(found: &Assessment) -> bool {
    found.shifts.len() > 1
}

impl Off {
    /// Of runs of these blocks.
    fn of(found: &Assessment, blocks: &[Block]) -> Self {
        if !has_shifts(found) {
            return Self::default();
        }
        let shift =
            |block: &Block| found.shifts.iter().find(|shift| shift.block == *block).map_or(0.0, |shift| shift.by);
        let by = blocks.iter().map(shift).sum::<f64>() / blocks.len().max(1) as f64;
        Self { by, blocks: each_once(blocks.to_vec()) }
    }

    /// ", in batch 2, which reads 1.1 mm below what is expected of it"; nothing where nothing is taken in.
    pub(super) fn in_words(&self, campaign: &Campaign) -> String {
        let response = &campaign.problem.response;
        let named: Vec<String> = self.blocks.iter().map(named_block).collect();
        let far = format!("{} {}", response.amount(self.by.abs()), response.side(self.by));
        let preposition = if matches!(self.blocks.first(), Some(Block::Batch(_))) { "in" } else { "of" };
        match named.as_slice() {
            [] => String::new(),
            [one] => format!(", {preposition} {one}, which reads {far} what is expected of it"),
            all => {
                format!(", {preposition} {}, which read {far} what is expected of them, in the mean", all_of(all))
            }
        }
    }
}

impl BestMeasured {
    /// What it measured, without what its batch is off by.
    pub(super) fn without_shift(&self) -> f64 {
        self.cost - self.off.by
    }

    /// "Best measured: 3.2 mm, experiment 14 at spring 30 N/mm."
    pub(super) fn in_words(&self, campaign: &Campaign, found: &Assessment) -> Finding {
        let (problem, response) = (&campaign.problem, &campaign.problem.response);
        let shown = |cost: f64| response.value_to(cost, resolution(found));
        let place = problem.describe(&self.settings);
        let why_not = campaign.nearest(&self.settings).ok().and_then(|(_, cell)| campaign.why_not(cell));
        let why_not = why_not.map_or_else(String::new, |why_not| format!("; {why_not}"));
        let off = match self.off.in_words(campaign) {
            nothing if nothing.is_empty() => nothing,
            off => format!("{off}: {} without that, by which it is chosen", shown(self.without_shift())),
        };
        let who = match self.n_runs {
            1 => campaign.name_of(self.origin),
            n => format!("the mean of {n} runs"),
        };
        let sentence = format!("Best measured: {}, {who} at {place}{off}{why_not}.", shown(self.cost));
        Finding::new(sentence).with("best measured", response.of_cost(self.cost), &response.unit)
    }

    pub(super) fn as_json(&self, campaign: &Campaign) -> Value {
        let (problem, response) = (&campaign.problem, &campaign.problem.response);
        let id = match self.origin {
            Origin::Own(id) => Some(id),
            Origin::Imported(_) => None,
        };
        let without_shift = (!self.off.blocks.is_empty()).then(|| response.of_cost(self.without_shift()));
        json!({
            "id": id, "value": response.of_cost(self.cost), "value_without_shift": without_shift, "runs": self.n_runs,
            "settings": problem.named(&self.settings),
        })
    }
}

impl Campaign {
    /// The settings with the best mean of their runs, imported ones too, but for those set aside, those that broke a bound, and those
    /// that are not thought to keep to one that was not measured.
    pub(super) fn best_measured(&self, found: &Assessment) -> Option<BestMeasured> {
        let (response, aside) = (&self.problem.response, self.set_aside(found));
        let imported = self.imported.iter().enumerate().filter_map(|(index, one)| {
            let (cost, settings) = (response.cost(one.result.value()?), one.point.clone());
            let is_allowed = self.problem.allows(|name| one.constrained.get(name).copied());
            let off = Off::of(found, &[Block::Source(one.source.clone())]);
            let one = BestMeasured { origin: Origin::Imported(index), cost, n_runs: 1, settings, off };
            (is_allowed && !self.is_doubtful(&one.settings)).then_some(one)
        });
        let own = self.experiments.readings.iter().filter_map(|(&id, reading)| {
            let cost = reading.outcome(response)?.cost()?;
            let (settings, n_runs) = (self.experiments.settings_of(id), reading.values().count());
            let off = self.off_of(found, id, reading);
            let one = BestMeasured { origin: Origin::Own(id), cost, n_runs, settings, off };
            self.may_be_best_measured(id, reading).then_some(one)
        });
        let mut meant: Vec<BestMeasured> = own.chain(imported).filter(|one| !aside.contains(&one.origin)).collect();
        // Equal settings stand together, the best first.
        let settings = |a: &BestMeasured, b: &BestMeasured| {
            let pairs = a.settings.iter().zip(&b.settings);
            pairs.map(|(a, b)| a.total_cmp(b)).find(|order| order.is_ne()).unwrap_or(Ordering::Equal)
        };
        let better = |a: &BestMeasured, b: &BestMeasured| a.without_shift().total_cmp(&b.without_shift());
        meant.sort_by(|a, b| settings(a, b).then(better(a, b)));
        let designs = meant.chunk_by(|a, b| settings(a, b).is_eq());
        designs.filter_map(of_design).min_by(better)
    }

    /// By how much the runs of an experiment are off.
    pub(super) fn off_of(&self, found: &Assessment, id: u64, reading: &Reading) -> Off {
        let first = reading.first.iter().map(|result| (result, false));
        let runs = first.chain(reading.again.values().map(|result| (result, true)));
        let runs = runs.filter(|(result, _)| result.value().is_some());
        let blocks: Vec<Block> = runs.map(|(_, is_further)| self.block_of(Origin::Own(id), is_further)).collect();
        Off::of(found, &blocks)
    }

    /// By how much the readings of the loop are off that are meant, by their places.
    pub(super) fn off_of_readings(&self, found: &Assessment, is_meant: impl Fn(usize) -> bool) -> Off {
        let meant = self.blocks().into_iter().enumerate().filter(|(at, _)| is_meant(*at));
        Off::of(found, &meant.map(|(_, block)| block).collect::<Vec<_>>())
    }

    /// By how much the cost of each reading of the loop is off, in its order; 0 where nothing is taken in.
    pub(super) fn shifts_of_readings(&self, found: &Assessment) -> Vec<f64> {
        self.blocks().into_iter().map(|block| Off::of(found, &[block]).by).collect()
    }
}

/// All runs of a design in one, the best of them first.
fn of_design(runs: &[BestMeasured]) -> Option<BestMeasured> {
    let n_runs = runs.iter().map(|one| one.n_runs).sum::<usize>();
    let mean =
        |of: fn(&BestMeasured) -> f64| runs.iter().map(|one| of(one) * one.n_runs as f64).sum::<f64>() / n_runs as f64;
    let blocks = runs.iter().flat_map(|one| one.off.blocks.clone()).collect();
    let off = Off { by: mean(|one| one.off.by), blocks: each_once(blocks) };
    Some(BestMeasured { cost: mean(|one| one.cost), n_runs, off, ..runs.first()?.clone() })
}

fn each_once(mut blocks: Vec<Block>) -> Vec<Block> {
    blocks.sort();
    blocks.dedup();
    blocks
}
