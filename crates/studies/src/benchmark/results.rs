//! Rows of campaigns, kept in files so that a run goes on where the last one ended.

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use anyhow::Result;
use infuse::pooled::Forecast;
use serde::{Deserialize, Serialize};

use super::families::Family;
use super::task::{LEVELS, n_experiments};
use crate::kept;

/// An optimizer of others, whose rows a person with Python can write anew: `fixtures/peers/README.md`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Peer {
    /// In file names.
    pub(super) name: &'static str,
    pub(super) words: &'static str,
}

pub(super) const PEERS: &[Peer] = &[
    Peer { name: "botorch", words: "BoTorch" },
    Peer { name: "botorch-multifidelity", words: "BoTorch, two fidelities" },
    Peer { name: "smt", words: "SMT, two fidelities" },
    Peer { name: "baybe", words: "BayBE" },
    Peer { name: "optuna", words: "Optuna TPE" },
];

/// One batch of one campaign.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct Row {
    pub(super) family: String,
    pub(super) seed: u64,
    /// From 1.
    pub(super) batch: usize,
    /// Truth at the recommended design less the lowest on the grid; the truth goes from 0 to 1.
    pub(super) regret: f64,
    /// What the method promised to be missing at most, with 90 % probability.
    pub(super) bound: Option<f64>,
    /// The same as the surface of the method has it, without any allowance.
    #[serde(default)]
    pub(super) quantile: Option<f64>,
    /// What the bound is expected to fall by, as [`Forecast`] has it: of this method's own alone.
    #[serde(default)]
    pub(super) drawn: Option<f64>,
    #[serde(default)]
    pub(super) spread: Option<f64>,
    #[serde(default)]
    pub(super) tried: Option<usize>,
    #[serde(default)]
    pub(super) narrow: Option<f64>,
    /// What is expected at the recommended design less the truth there, and the standard deviation of that.
    #[serde(default)]
    pub(super) off: Option<f64>,
    #[serde(default)]
    pub(super) deviation: Option<f64>,
    /// Where the simulation is taken to be displaced, and is: of how many axes the band of nine in ten is said, and how many of them hold.
    #[serde(default)]
    pub(super) bands: Option<usize>,
    #[serde(default)]
    pub(super) bands_hold: Option<usize>,
    /// To choose the batch.
    pub(super) ask_seconds: f64,
    /// To take its results.
    pub(super) tell_seconds: f64,
}

impl Row {
    /// How the bound was expected to fall, if the method says so.
    pub(super) fn forecast(&self, family: &Family) -> Option<Forecast> {
        let (n_experiments, n_parameters) = (n_experiments(family), family.n_factors);
        let n_readings = self.batch * n_experiments;
        let (drawn, spread, n_tried) = (self.drawn?, self.spread?, self.tried?);
        let n_designs = u64::from(LEVELS).pow(n_parameters as u32);
        // Where the bound is more than the others come to, it is what is held for a well of which a part was found.
        let found = self.bound.unwrap_or(0.0);
        let (most, of_means) = (None, None);
        Some(Forecast {
            drawn,
            believed: self.quantile.unwrap_or(drawn),
            spread,
            found,
            most,
            of_means,
            n_readings,
            n_tried,
            n_failed: 0,
            crowded: 0.0,
            n_designs,
            n_experiments,
            n_parameters,
            narrow: self.narrow,
        })
    }

    /// Whether both say the same, times apart; the last digits differ between machines.
    pub(super) fn agrees(&self, other: &Self) -> bool {
        let close = |a: f64, b: f64| (a - b).abs() <= 1e-6 * (1.0 + a.abs());
        let both = |pair: (Option<f64>, Option<f64>)| match pair {
            (Some(a), Some(b)) => close(a, b),
            (a, b) => a.is_none() == b.is_none(),
        };
        self.family == other.family
            && self.seed == other.seed
            && self.batch == other.batch
            && both((self.bound, other.bound))
            && both((self.quantile, other.quantile))
            && both((self.drawn, other.drawn))
            && both((self.spread, other.spread))
            && self.tried == other.tried
            && both((self.narrow, other.narrow))
            && both((self.off, other.off))
            && both((self.deviation, other.deviation))
            && (self.bands, self.bands_hold) == (other.bands, other.bands_hold)
            && close(self.regret, other.regret)
    }
}

/// All rows of a method.
#[derive(Debug, Clone)]
pub(super) struct Results {
    method: String,
    path: PathBuf,
    pub(super) rows: Vec<Row>,
}

/// Campaigns on fresh seeds, where the simulation misleads.
pub(super) struct Fresh {
    /// By which the certificate is judged.
    pub(super) ours: Results,
    /// Those that others ran, too.
    pub(super) compared: Results,
    /// Of the family whose certificate was broken most often on the seeds of all.
    pub(super) broken: Results,
    /// Those that are not told of it, in words.
    pub(super) untold: Vec<(&'static str, Results)>,
    pub(super) displaced: Displaced,
}

/// Campaigns whose simulation is displaced.
pub(super) struct Displaced {
    /// Those that know what it says of any design.
    pub(super) cheap: Beside,
    /// Those that know it of a few.
    pub(super) dear: Beside,
}

/// Our campaigns, and those of others.
pub(super) struct Beside {
    pub(super) ours: Results,
    /// Those that take it as it stands, or know nothing of it, in words.
    pub(super) others: Vec<(&'static str, Results)>,
}

impl Results {
    /// The rows in a folder; none if there is no file yet.
    pub(super) fn read(folder: &Path, method: &str) -> Result<Self> {
        let path = folder.join(method).with_extension("csv");
        Ok(Self { method: method.to_owned(), rows: kept::rows(&path)?, path })
    }

    /// Its name in file names.
    pub(super) fn method(&self) -> &str {
        &self.method
    }

    pub(super) fn has(&self, family: &str, seed: u64) -> bool {
        self.rows.iter().any(|row| row.family == family && row.seed == seed)
    }

    pub(super) fn of(&self, family: &str, seed: u64) -> Vec<Row> {
        self.rows.iter().filter(|row| row.family == family && row.seed == seed).cloned().collect()
    }

    /// Those of some seeds only.
    pub(super) fn of_seeds(&self, seeds: &RangeInclusive<u64>) -> Self {
        let rows = self.rows.iter().filter(|row| seeds.contains(&row.seed)).cloned().collect();
        Self { rows, method: self.method.clone(), path: self.path.clone() }
    }

    /// Adds rows, in memory and in the file, which is written anew beside itself: what was kept stays whole if that fails.
    pub(super) fn append(&mut self, rows: Vec<Row>) -> Result<()> {
        let rounded = |seconds: f64| (1e3 * seconds).round() / 1e3;
        self.rows.extend(rows.into_iter().map(|row| {
            let (ask_seconds, tell_seconds) = (rounded(row.ask_seconds), rounded(row.tell_seconds));
            Row { ask_seconds, tell_seconds, ..row }
        }));
        kept::replace_rows(&self.path, &self.rows)
    }
}
