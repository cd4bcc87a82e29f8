//! Parameters that are hard to change: what is built stays for several runs, what is typed costs nothing.

use std::collections::BTreeMap;

use design_space::{Cell, Combinations, Region};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use crate::Error;
use crate::pooled::block::Block;
use crate::pooled::designs::Designs;

/// Which parameters make a plant, and what another plant costs.
///
/// A batch is then run plant by plant: each is put together once, and all its runs are made before it is taken apart. Runs of one
/// assembly share an error that those of another do not have, as in a split-plot design.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plants {
    /// The parameters that are part of the plant, by their places in the region: of a
    /// [`CodesignProblem`](crate::CodesignProblem) those of [`indices`](crate::CodesignProblem::indices) with
    /// [`Role::Plant`](crate::Role::Plant).
    pub parameters: Vec<usize>,
    /// What it costs to change each of them, in experiments: how many runs could be made instead. Default: nothing, so that only
    /// their number counts.
    #[serde(default)]
    pub change_costs: Vec<f64>,
    /// At most so many plants in a batch. Default: as many as are worth their cost.
    #[serde(default)]
    pub most: Option<usize>,
}

impl Plants {
    /// These parameters make the plant; at most so many plants in a batch.
    #[must_use]
    pub fn at_most(most: usize, parameters: Vec<usize>) -> Self {
        Self { parameters, change_costs: Vec::new(), most: Some(most) }
    }

    /// These parameters make the plant, and changing each costs as much as so many experiments.
    #[must_use]
    pub fn of_cost(parameters: Vec<usize>, change_costs: Vec<f64>) -> Self {
        Self { parameters, change_costs, most: None }
    }

    pub(crate) fn validate(&self, region: &Region) -> Result<(), Error> {
        let fault =
            |field, value, expected| Err(Error::Constraint { constraint: "plants".to_owned(), field, value, expected });
        if self.parameters.is_empty() {
            return fault("parameters", 0.0, "at least one");
        }
        if let Some(twice) = (1..self.parameters.len()).find(|&at| self.parameters[..at].contains(&self.parameters[at]))
        {
            return fault("parameters", self.parameters[twice] as f64, "each parameter once");
        }
        if let Some(&beyond) = self.parameters.iter().find(|&&parameter| parameter >= region.n_parameters()) {
            return fault("parameters", beyond as f64, "places of parameters in the region, from 0");
        }
        if !self.change_costs.is_empty() && self.change_costs.len() != self.parameters.len() {
            return fault("change_costs", self.change_costs.len() as f64, "one per parameter of the plant, or none");
        }
        if let Some(&cost) = self.change_costs.iter().find(|cost| !(0.0..=1e9).contains(*cost)) {
            return fault("change_costs", cost, "0 to 1e9 experiments");
        }
        if self.most == Some(0) { fault("most", 0.0, "at least 1") } else { Ok(()) }
    }

    /// The plant of a cell: its digits along the parameters of the plant.
    pub(crate) fn of(&self, designs: &Designs, cell: Cell) -> Plant {
        let digits = designs.combinations().digits(cell.index());
        self.parameters.iter().map(|&parameter| digits[parameter]).collect()
    }

    /// Its axes among those of the places; none where all are, as each run is then a plant of its own.
    pub(crate) fn axes(&self, designs: &Designs) -> Vec<usize> {
        let axes = designs.axes_of(&self.parameters);
        if axes.len() < designs.n_factors() { axes } else { Vec::new() }
    }

    /// How many there are.
    pub(crate) fn n_plants(&self, designs: &Designs) -> f64 {
        let counts = designs.combinations().counts();
        self.parameters.iter().map(|&parameter| counts[parameter] as f64).product()
    }

    /// The same cell with another plant.
    pub(crate) fn with(&self, designs: &Designs, cell: Cell, plant: &Plant) -> Cell {
        let mut digits = designs.combinations().digits(cell.index());
        for (&parameter, &digit) in self.parameters.iter().zip(plant) {
            digits[parameter] = digit;
        }
        Cell::new(designs.combinations().index(&digits))
    }

    /// What it costs to go from one plant to another, in experiments.
    pub(crate) fn change(&self, from: &Plant, to: &Plant) -> f64 {
        let changed = (0..self.parameters.len()).filter(|&at| from[at] != to[at]);
        changed.map(|at| self.change_costs.get(at).copied().unwrap_or(0.0)).sum()
    }

    /// What a new plant costs beside those of a batch: the least change from any of them, or to all of it if there is none.
    pub(crate) fn addition(&self, built: &[Plant], plant: &Plant) -> f64 {
        let least = built.iter().map(|other| self.change(other, plant)).fold(f64::INFINITY, f64::min);
        if least.is_finite() { least } else { self.change_costs.iter().sum() }
    }

    /// Cells of each plant: every way to set the other parameters, or so many of them.
    pub(crate) fn cells_of(
        &self,
        designs: &Designs,
        plants: &[Plant],
        near: &[Cell],
        rng: &mut ChaCha8Rng,
    ) -> Vec<Cell> {
        let counts = designs.combinations().counts();
        let others: Vec<usize> = (0..counts.len()).filter(|axis| !self.parameters.contains(axis)).collect();
        let of_others = Combinations::saturating(others.iter().map(|&axis| counts[axis]).collect::<Vec<_>>());
        let most = (MOST / plants.len().max(1)).max(1);
        let mut cells = Vec::new();
        for plant in plants {
            let digits: Vec<u64> = vec![0; counts.len()];
            let start = self.with(designs, Cell::new(designs.combinations().index(&digits)), plant);
            let mut of_plant: Vec<Cell> = Vec::with_capacity(most);
            if of_others.len() <= most as u64 {
                let mut digits = designs.combinations().digits(start.index());
                for setting in of_others.all() {
                    others.iter().zip(setting).for_each(|(&axis, digit)| digits[axis] = digit);
                    of_plant.push(Cell::new(designs.combinations().index(&digits)));
                }
            } else {
                // What is promising elsewhere, on this plant; and others at random.
                of_plant.extend(near.iter().take(most / 2).map(|&cell| self.with(designs, cell, plant)));
                while of_plant.len() < most {
                    let random = Cell::new(rng.random_range(0..designs.n_cells()));
                    of_plant.push(self.with(designs, random, plant));
                }
            }
            of_plant.retain(|&cell| designs.allows(cell));
            cells.extend(of_plant);
        }
        cells.sort_unstable();
        cells.dedup();
        cells
    }

    /// Cells on at most [`most`](Self::most) of their plants: those whose plant comes too late get the settings of their own on
    /// one of the others, wherever that is allowed.
    pub(crate) fn gathered(&self, designs: &Designs, cells: &[Cell]) -> Vec<Cell> {
        let Some(most) = self.most else { return cells.to_vec() };
        let mut plants: Vec<Plant> = Vec::new();
        let mut next = 0;
        let mut gathered = Vec::with_capacity(cells.len());
        for &cell in cells {
            let own = self.of(designs, cell);
            if plants.contains(&own) {
                gathered.push(cell);
            } else if plants.len() < most {
                plants.push(own);
                gathered.push(cell);
            } else {
                let moved =
                    (0..plants.len()).map(|step| self.with(designs, cell, &plants[(next + step) % plants.len()]));
                let moved = moved.into_iter().find(|&moved| designs.allows(moved));
                gathered.push(moved.unwrap_or(gathered[next % gathered.len()]));
                next += 1;
            }
        }
        gathered
    }
}

/// Digits of the parameters that are built.
pub(crate) type Plant = Vec<u64>;

/// Cells that are looked at on chosen plants.
const MOST: usize = 400;

/// A number for each assembly: one plant in one block.
#[derive(Debug, Default)]
pub(crate) struct Assemblies {
    known: BTreeMap<(Block, Plant), usize>,
    next: usize,
}

impl Assemblies {
    pub(crate) fn of(&mut self, block: &Block, plant: Plant) -> usize {
        let next = &mut self.next;
        *self.known.entry((block.clone(), plant)).or_insert_with(|| {
            *next += 1;
            *next
        })
    }

    /// One that no other measurement belongs to.
    pub(crate) fn alone(&mut self) -> usize {
        self.next += 1;
        self.next
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_assembly_is_one_plant_in_one_batch() {
        let mut assemblies = Assemblies::default();
        let first = assemblies.of(&Block::Batch(0), vec![1, 2]);
        let others = [
            assemblies.of(&Block::Batch(0), vec![2, 1]),
            assemblies.of(&Block::Batch(1), vec![1, 2]),
            assemblies.alone(),
            assemblies.alone(),
        ];
        assert_eq!(assemblies.of(&Block::Batch(0), vec![1, 2]), first, "the same plant in the same batch");
        assert_eq!(assemblies.of(&Block::Batch(1), vec![1, 2]), others[1]);
        let all: std::collections::BTreeSet<usize> = others.into_iter().chain([first]).collect();
        assert_eq!(all.len(), 5, "{first} and {others:?}");
    }
}
