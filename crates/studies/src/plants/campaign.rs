//! Campaigns with many plants, with few, and with plants that nobody chose.

use std::collections::BTreeSet;

use anyhow::{Context as _, Result, bail};
use design_space::Cell;
use infuse::Outcome;
use infuse::pooled::{Ask, Loop, Plants, Settings, Trial};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde::{Deserialize, Serialize};
use surface::process::{Residual, SimulationUse, Structure};

use super::case::Case;

/// Seeds of each method, from 1.
pub(super) const SEEDS: u64 = 10;
pub(super) const BATCHES: usize = 5;
pub(super) const EXPERIMENTS: usize = 12;
/// Standard deviation of a run, and of what goes wrong when a plant is put together, as shares of what 80 % of all designs span.
pub(super) const NOISE: f64 = 0.01;
pub(super) const ASSEMBLY: f64 = 0.02;
const SIMULATIONS: usize = 40;

/// How a campaign goes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Method {
    pub(super) name: &'static str,
    pub(super) words: &'static str,
    /// At most so many plants in a batch; none where each run may have its own.
    most: Option<usize>,
    /// Whether plants and settings are drawn and not chosen.
    is_blind: bool,
}

const fn chosen(name: &'static str, words: &'static str, most: Option<usize>) -> Method {
    Method { name, words, most, is_blind: false }
}

pub(super) const METHODS: [Method; 4] = [
    chosen("each-its-own", "each run its own plant", None),
    chosen("four", "four plants a batch", Some(4)),
    chosen("two", "two plants a batch", Some(2)),
    Method { is_blind: true, ..chosen("two-random", "two random plants a batch, random settings", Some(2)) },
];

/// What is known after a batch.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Row {
    pub(super) case: String,
    pub(super) method: String,
    pub(super) seed: u64,
    /// From 1.
    pub(super) batch: usize,
    /// Plants put together so far.
    pub(super) plants: usize,
    /// What the recommended design costs more than the best, as a share of what 80 % of all designs span.
    pub(super) regret: f64,
    /// What the certificate promised with 90 % probability, as such a share.
    pub(super) bound: f64,
}

impl Row {
    pub(super) fn agrees(&self, other: &Self) -> bool {
        let close = |a: f64, b: f64| (a - b).abs() <= 1e-6 * (1.0 + a.abs());
        let of = |row: &Self| (row.case.clone(), row.method.clone(), row.seed, row.batch, row.plants);
        of(self) == of(other) && close(self.regret, other.regret) && close(self.bound, other.bound)
    }
}

/// A campaign, a row for each batch.
pub(super) fn run(case: &Case, method: Method, seed: u64) -> Result<Vec<Row>> {
    let mut settings = Settings::new(EXPERIMENTS);
    (settings.max_batches, settings.seed, settings.simulations) = (BATCHES, seed, Some(SIMULATIONS));
    settings.plants = method.most.map(|most| Plants::at_most(most, case.plant.clone()));
    if method.is_blind {
        settings.simulations = None;
        settings.structures = vec![Structure { simulation: SimulationUse::Ignored, residual: Residual::Smooth }];
    }
    let mut campaign = Loop::new(&case.region, settings)?;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let (mut rows, mut n_plants) = (Vec::new(), 0);
    for batch in 1..=BATCHES {
        let trials = if method.is_blind { drawn(case, &mut campaign, &mut rng)? } else { asked(case, &mut campaign)? };
        n_plants += measure(case, &mut campaign, trials, &mut rng)?;
        let found = campaign.assess(None)?.context("no experiment gave a response")?;
        let cost = case.on_the_rig(&[found.recommended.cell])?.remove(0).unwrap_or(f64::NAN);
        rows.push(Row {
            case: case.name.to_owned(),
            method: method.name.to_owned(),
            seed,
            batch,
            plants: n_plants,
            regret: (cost - case.best).max(0.0) / case.spread,
            bound: found.certificate.bound / case.spread,
        });
    }
    Ok(rows)
}

/// The next batch of the loop, with its simulations.
fn asked(case: &Case, campaign: &mut Loop) -> Result<Vec<Trial>> {
    loop {
        let Ask::Run { trials, simulations } = campaign.ask(None)? else { bail!("the campaign ended early") };
        for (&cell, cost) in simulations.iter().zip(case.simulated(&simulations)?) {
            campaign.tell_simulation(cell, cost)?;
        }
        if !trials.is_empty() {
            return Ok(trials);
        }
    }
}

/// Two plants and settings on them that nobody chose.
fn drawn(case: &Case, campaign: &mut Loop, rng: &mut ChaCha8Rng) -> Result<Vec<Trial>> {
    let mut random = || case.grid.digits(Cell::new(rng.random_range(0..case.grid.n_cells())));
    let plants = [random()?, random()?];
    let mut cells = Vec::with_capacity(EXPERIMENTS);
    for run in 0..EXPERIMENTS {
        let mut digits = random()?;
        for &place in &case.plant {
            digits[place] = plants[run % plants.len()][place];
        }
        cells.push(case.grid.of_digits(&digits)?);
    }
    Ok(campaign.hand_out(&cells)?)
}

/// Makes experiments plant by plant; how many were put together. Each has an error that its runs share.
fn measure(case: &Case, campaign: &mut Loop, mut trials: Vec<Trial>, rng: &mut ChaCha8Rng) -> Result<usize> {
    let plant = |trial: &Trial| case.plant.iter().map(|&place| trial.point[place].to_bits()).collect::<Vec<u64>>();
    trials.sort_by_key(plant);
    let cells: Vec<Cell> = trials.iter().map(|trial| trial.cell).collect();
    let costs = case.on_the_rig(&cells)?;
    let mut normal = || -> f64 { StandardNormal.sample(rng) };
    let (mut last, mut shared) = (None, 0.0);
    let mut built = BTreeSet::new();
    for (trial, cost) in trials.iter().zip(costs) {
        if last.as_ref() != Some(&plant(trial)) {
            (last, shared) = (Some(plant(trial)), ASSEMBLY * case.spread * normal());
        }
        built.insert(plant(trial));
        let noise = shared + NOISE * case.spread * normal();
        campaign.tell(trial.id, Outcome::from(cost.map(|cost| cost + noise)))?;
    }
    Ok(built.len())
}
