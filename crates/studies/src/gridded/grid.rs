//! The cost at every cell of a design space.

use anyhow::{Context as _, Result};
use bat_dynamics::Fidelity;
use design_space::Cell;

use super::per_cell::PerCell;
use super::space::Space;
use crate::bat::Bat;
use crate::costs::Cost;

/// Flights between two writes: an interrupt loses a few seconds.
const PIECE: usize = 1024;

/// The cost at every cell of a space.
#[derive(Clone, Debug)]
pub(crate) struct FlownGrid {
    costs: PerCell<Cost>,
}

impl FlownGrid {
    /// The costs at every cell, flown where none is known; `done` is called with how many cells each batch adds.
    pub(crate) fn fly(bat: &Bat, space: &Space, fidelity: Fidelity, done: impl Fn(usize) + Sync) -> Result<Self> {
        let points = space.points()?;
        let costs = points.chunks(PIECE).flat_map(|piece| bat.costs(piece, fidelity, &done)).collect();
        Ok(Self { costs })
    }

    /// Costs that were not flown.
    #[cfg(any(test, feature = "ensemble"))]
    pub(crate) fn of_costs(costs: Vec<Cost>) -> Self {
        Self { costs: costs.into_iter().collect() }
    }

    pub(crate) fn cost(&self, cell: Cell) -> &Cost {
        &self.costs[cell]
    }

    /// The costs, NaN where there is none.
    pub(crate) fn values(&self) -> PerCell<f64> {
        self.costs.map(|cost| cost.as_ref().copied().unwrap_or(f64::NAN))
    }

    pub(crate) fn n_failed(&self) -> usize {
        self.costs.iter().filter(|(_, cost)| cost.is_err()).count()
    }

    fn flown(&self) -> impl Iterator<Item = (Cell, f64)> {
        self.costs.iter().filter_map(|(cell, cost)| Some((cell, *cost.as_ref().ok()?)))
    }

    /// The cell of the lowest cost, of equals the first.
    pub(crate) fn lowest(&self) -> Result<(Cell, f64)> {
        self.flown().min_by(|a, b| a.1.total_cmp(&b.1)).context("no design of the space flies")
    }

    /// Highest less lowest cost.
    pub(crate) fn range(&self) -> f64 {
        let (lowest, highest) = self
            .flown()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (_, cost)| (low.min(cost), high.max(cost)));
        highest - lowest
    }
}
