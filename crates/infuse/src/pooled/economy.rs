//! What the runs of a batch cost: a run, and another plant where one is needed.

use std::collections::BTreeSet;

use design_space::Cell;

use crate::pooled::designs::Designs;
use crate::pooled::plants::{Plant, Plants};

/// The plants of a batch so far, and what another costs.
#[derive(Debug, Clone)]
pub(crate) struct Economy<'a> {
    of: Option<(&'a Plants, &'a Designs)>,
    /// Built already, or to be.
    built: Vec<Plant>,
    /// Only these may be picked, if not all.
    only: Option<BTreeSet<Plant>>,
}

impl<'a> Economy<'a> {
    /// Every run is set up anew, if there are no plants.
    pub(crate) fn of(plants: Option<&'a Plants>, designs: &'a Designs) -> Self {
        Self { of: plants.map(|plants| (plants, designs)), built: Vec::new(), only: None }
    }

    /// Only these plants.
    pub(crate) fn confined_to(mut self, plants: &[Plant]) -> Self {
        self.built = plants.to_vec();
        self.only = Some(plants.iter().cloned().collect());
        self
    }

    /// What is learnt at a cell counts this much: 1 over the cost of the run with its plant, 0 if it may not be picked.
    pub(crate) fn weight(&self, cell: Cell) -> f64 {
        let Some((plants, designs)) = self.of else { return 1.0 };
        let plant = plants.of(designs, cell);
        let is_new = !self.built.contains(&plant);
        let is_full = plants.most.is_some_and(|most| self.built.len() >= most);
        if self.only.as_ref().is_some_and(|only| !only.contains(&plant)) || (is_new && is_full) {
            return 0.0;
        }
        1.0 / (1.0 + if is_new { plants.addition(&self.built, &plant) } else { 0.0 })
    }

    /// Whether a cell may be picked at all.
    pub(crate) fn allows(&self, cell: Cell) -> bool {
        self.of.is_none() || self.weight(cell) > 0.0
    }

    /// The cell is part of the batch.
    pub(crate) fn take(&mut self, cell: Cell) {
        if let Some((plants, designs)) = self.of {
            let plant = plants.of(designs, cell);
            if !self.built.contains(&plant) {
                self.built.push(plant);
            }
        }
    }

    /// The plants of the batch, in the order in which they came.
    pub(crate) fn built(&self) -> &[Plant] {
        &self.built
    }
}
