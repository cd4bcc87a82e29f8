//! What experiments cost, and which parameters are built.

use std::collections::BTreeSet;

use anyhow::{Result, bail, ensure};
use design_space::Region;
use infuse::Role;
use infuse::pooled::Plants;

use super::file::{LoopEntry, ParameterEntry};
use crate::number::with_unit;

/// What the runs of a campaign cost, where parameters are hard to change.
#[derive(Debug, Clone)]
pub(crate) struct Costs {
    /// The parameters that make the plant, by their places.
    plant: Vec<usize>,
    /// To change each of them.
    changes: Vec<f64>,
    experiment: f64,
    unit: String,
    most: Option<usize>,
}

impl Costs {
    /// None where every parameter is as easy to set as the others.
    pub(super) fn of(parameters: &[ParameterEntry], entry: &LoopEntry) -> Result<Option<Self>> {
        for parameter in parameters {
            if let Some(cost) = parameter.change_cost {
                ensure!(
                    (0.0..=1e9).contains(&cost),
                    "parameter `{}`: `change_cost` is {cost:?}, expected 0 to 1e9, in the unit of `experiment_cost`",
                    parameter.name
                );
            }
        }
        let experiment = entry.experiment_cost.unwrap_or(1.0);
        ensure!(
            experiment > 0.0 && experiment <= 1e9,
            "[loop]: `experiment_cost` is {experiment:?}, expected a positive number up to 1e9"
        );
        ensure!(entry.plants != Some(0), "[loop]: `plants` is 0, expected at least 1 per batch");
        let dear = |parameter: &ParameterEntry| parameter.change_cost.is_some_and(|cost| cost > 0.0);
        let any_is_dear = parameters.iter().any(dear);
        let is_built = |parameter: &ParameterEntry| match any_is_dear {
            true => dear(parameter),
            // Where no cost is given, what is built is what is not programmed.
            false => entry.plants.is_some() && parameter.role == Some(Role::Plant),
        };
        let built = parameters.iter().enumerate().filter(|(_, parameter)| is_built(parameter));
        let (plant, changes): (Vec<usize>, Vec<f64>) =
            built.map(|(place, parameter)| (place, parameter.change_cost.unwrap_or(0.0))).unzip();
        if plant.is_empty() {
            if entry.plants.is_some() {
                bail!("[loop]: `plants` needs a parameter with `change_cost`, or one with `role` = \"plant\"");
            }
            return Ok(None);
        }
        let unit = entry.cost_unit.clone().unwrap_or_default();
        Ok(Some(Self { plant, changes, experiment, unit, most: entry.plants }))
    }

    /// The parameters that make the plant, the dearest to change first; of equals in the order of the file.
    pub(super) fn by_falling_cost(&self) -> Vec<usize> {
        let mut order: Vec<(usize, f64)> = self.plant.iter().copied().zip(self.changes.iter().copied()).collect();
        order.sort_by(|a, b| b.1.total_cmp(&a.1));
        order.into_iter().map(|(place, _)| place).collect()
    }

    /// As the loop has it: in experiments.
    pub(crate) fn plants(&self) -> Plants {
        let costs = self.changes.iter().map(|change| change / self.experiment).collect();
        let mut plants = Plants::of_cost(self.plant.clone(), costs);
        plants.most = self.most;
        plants
    }

    /// Of runs in this order, each by its settings, after one at `last`: what they cost, and how many plants are put together.
    pub(crate) fn of_runs(&self, last: Option<&[f64]>, runs: &[&[f64]]) -> (f64, usize) {
        let (mut cost, mut n_plants, mut last) = (0.0, 0, last);
        for &run in runs {
            let differs = |place: usize| last.is_none_or(|last| (last[place] - run[place]).abs() > 0.0);
            let changed = self.plant.iter().zip(&self.changes).filter(|(place, _)| differs(**place));
            let changes: Vec<f64> = changed.map(|(_, change)| *change).collect();
            n_plants += usize::from(!changes.is_empty());
            cost += self.experiment + changes.iter().sum::<f64>();
            last = Some(run);
        }
        (cost, n_plants)
    }

    /// How many plants these runs are of.
    pub(crate) fn n_plants_of(&self, runs: &[&[f64]]) -> usize {
        let plant = |run: &&[f64]| self.plant.iter().map(|&place| run[place].to_bits()).collect::<Vec<_>>();
        runs.iter().map(plant).collect::<BTreeSet<_>>().len()
    }

    /// Of runs in this order, after how many of them another plant is put together.
    pub(crate) fn changes_of_plant(&self, runs: &[&[f64]]) -> Vec<usize> {
        let differs = |pair: &[&[f64]]| self.plant.iter().any(|&place| (pair[0][place] - pair[1][place]).abs() > 0.0);
        let pairs = runs.windows(2).enumerate();
        pairs.filter(|(_, pair)| differs(pair)).map(|(index, _)| index + 1).collect()
    }

    /// Of so many runs, at most: each on a plant of its own as far as a batch may have them, all of it set anew.
    pub(crate) fn at_most(&self, runs: usize) -> (f64, usize) {
        let n_plants = self.most.map_or(runs, |most| most.min(runs));
        let change: f64 = self.changes.iter().sum();
        (runs as f64 * self.experiment + n_plants as f64 * change, n_plants)
    }

    /// "12.5 h".
    pub(crate) fn shown(&self, cost: f64) -> String {
        with_unit(&crate::number::short(cost), &self.unit)
    }

    pub(crate) fn unit(&self) -> &str {
        &self.unit
    }

    /// For the table of settings.
    pub(crate) fn in_words(&self, region: &Region) -> String {
        let of = |(&place, change): (&usize, &f64)| {
            format!("{} ({} to change)", region.parameters()[place].name(), self.shown(*change))
        };
        let built: Vec<String> = self.plant.iter().zip(&self.changes).map(of).collect();
        let most = self.most.map_or_else(String::new, |most| format!("; at most {most} plants a batch"));
        format!("{}; an experiment {}{most}", built.join(", "), self.shown(self.experiment))
    }
}
