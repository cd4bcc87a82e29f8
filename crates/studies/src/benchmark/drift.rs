//! Campaigns on a rig that reads otherwise from batch to batch: what is missing, and is it said?

use std::ops::RangeInclusive;

use anyhow::{Context as _, Result};
use design_space::Cell;
use infuse::Outcome;
use infuse::pooled::{Ask, Loop, Settings};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde::{Deserialize, Serialize};

use super::families::{FAMILIES, Family};
use super::task::{Task, lowest};

pub(super) const BATCHES: usize = 4;
/// Nothing was chosen on these.
pub(super) const SEEDS: RangeInclusive<u64> = 611..=620;
/// Two to four parameters, smooth and not.
pub(super) const NAMES: [&str; 7] = ["bowl-2", "wells-2", "branin", "cliff-2", "bowl-4", "park-1", "wells-4"];

/// How a rig drifts.
#[derive(Debug, Clone, Copy)]
pub(super) struct Kind {
    pub(super) name: &'static str,
    pub(super) words: &'static str,
    /// What all runs of a batch, counted from 0, read above the truth, in noises of one run, by a standard normal of its own and a sign of the
    /// campaign.
    above: fn(usize, f64, f64) -> f64,
}

pub(super) const KINDS: [Kind; 5] = [
    Kind { name: "none", words: "no drift", above: |_, _, _| 0.0 },
    Kind { name: "random-1", words: "anew each batch, one noise", above: |_, normal, _| normal },
    Kind { name: "random-3", words: "anew each batch, three noises", above: |_, normal, _| 3.0 * normal },
    Kind { name: "steady", words: "one noise a batch, steadily", above: |batch, _, sign| sign * batch as f64 },
    Kind {
        name: "jump",
        words: "three noises from batch 3 on",
        above: |batch, _, sign| if batch < 2 { 0.0 } else { 3.0 * sign },
    },
];

/// Whether the loop is told that runs of a batch share an error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Way {
    pub(super) name: &'static str,
    pub(super) words: &'static str,
    blocks: Option<bool>,
}

/// The last one is what the loop does by itself.
pub(super) const WAYS: [Way; 3] = [
    Way { name: "as-they-are", words: "results as they are", blocks: Some(false) },
    Way { name: "blocks", words: "`blocks`", blocks: Some(true) },
    Way { name: "if-sure", words: "once results are sure", blocks: None },
];

/// After a batch.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Row {
    pub(super) family: String,
    pub(super) kind: String,
    pub(super) way: String,
    pub(super) seed: u64,
    /// From 1.
    pub(super) batch: usize,
    /// Truth of the recommended design less the lowest; the truth goes from 0 to 1.
    pub(super) regret: f64,
    /// No design is better by more, said the certificate.
    pub(super) bound: f64,
    /// What the readings say of a drift; empty where it is allowed for, and while they are too few.
    pub(super) gain: Option<f64>,
    /// Whether that is believed.
    pub(super) is_said: bool,
    /// Standard deviation of the error that runs of a batch share, in noises of one run, where it is allowed for.
    pub(super) shared: Option<f64>,
}

impl Row {
    pub(super) fn agrees(&self, other: &Self) -> bool {
        let close = |a: f64, b: f64| (a - b).abs() <= 1e-6 * (1.0 + a.abs());
        let both =
            |a: Option<f64>, b: Option<f64>| a.zip(b).is_none_or(|(a, b)| close(a, b)) && a.is_some() == b.is_some();
        let of = |row: &Self| (row.family.clone(), row.kind.clone(), row.way.clone(), row.seed, row.batch, row.is_said);
        of(self) == of(other)
            && close(self.regret, other.regret)
            && close(self.bound, other.bound)
            && both(self.gain, other.gain)
            && both(self.shared, other.shared)
    }
}

/// Which campaign.
#[derive(Debug, Clone, Copy)]
pub(super) struct Which {
    family: &'static Family,
    kind: Kind,
    way: Way,
    seed: u64,
}

impl Which {
    pub(super) fn all() -> impl Iterator<Item = Self> {
        let families = || FAMILIES.iter().filter(|family| NAMES.contains(&family.name));
        let of_seeds = SEEDS.flat_map(move |seed| families().map(move |family| (seed, family)));
        let of_kinds = of_seeds.flat_map(|(seed, family)| KINDS.map(|kind| (seed, family, kind)));
        of_kinds.flat_map(|(seed, family, kind)| WAYS.map(|way| Self { family, kind, way, seed }))
    }

    pub(super) fn words(&self) -> String {
        format!("{}, {}, {}, seed {}", self.family.name, self.kind.words, self.way.words, self.seed)
    }

    pub(super) fn is_of(&self, row: &Row) -> bool {
        row.family == self.family.name
            && row.kind == self.kind.name
            && row.way == self.way.name
            && row.seed == self.seed
    }

    /// A row for each batch.
    pub(super) fn run(&self) -> Result<Vec<Row>> {
        let pair = self.family.pair(self.seed);
        let task = Task::new(self.family, &pair, self.seed)?;
        let best = lowest(&task.grid, &*pair.truth)?;
        let mut settings = Settings::new(task.n_experiments);
        (settings.max_batches, settings.seed, settings.blocks) = (BATCHES, self.seed, self.way.blocks);
        let mut campaign = Loop::new(&task.region, settings)?;
        let mut simulate = |_: Cell, point: &[f64]| Ok((pair.simulation)(point));
        let mut readings = task.readings();
        let mut of_batches = ChaCha8Rng::seed_from_u64(self.seed);
        of_batches.set_stream(3);
        let sign = if self.seed.is_multiple_of(2) { 1.0 } else { -1.0 };
        let mut rows = Vec::new();
        for batch in 1..=BATCHES {
            let above = pair.noise * (self.kind.above)(batch - 1, StandardNormal.sample(&mut of_batches), sign);
            let Ask::Run { trials, .. } = campaign.ask(Some(&mut simulate))? else {
                anyhow::bail!("the campaign ended early");
            };
            for trial in trials {
                campaign.tell(trial.id, Outcome::Value(readings(trial.cell)? + above))?;
            }
            let found = campaign.assess(Some(&mut simulate))?.context("no response")?;
            rows.push(Row {
                family: self.family.name.to_owned(),
                kind: self.kind.name.to_owned(),
                way: self.way.name.to_owned(),
                seed: self.seed,
                batch,
                regret: (pair.truth)(&found.recommended.point) - best,
                bound: found.certificate.bound,
                gain: found.drift.as_ref().map(|drift| drift.gain),
                is_said: found.is_drifting(),
                shared: found.assembly.map(|shared| shared / pair.noise),
            });
        }
        Ok(rows)
    }
}
