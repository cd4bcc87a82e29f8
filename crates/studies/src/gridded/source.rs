//! Where a campaign finds the cost of a cell.

use std::fmt::Debug;

use anyhow::Result;

use super::flown::FlownGrid;
use crate::study::Cost;

/// The costs of one physics over the cells of a space.
pub(crate) trait CellCosts: Debug + Sync {
    /// A name for all that these costs depend on.
    fn key(&self) -> &str;

    fn cost(&self, cell: usize) -> Cost;

    /// The costs of several cells, in their order.
    fn costs(&self, cells: &[usize]) -> Vec<Cost> {
        cells.iter().map(|cell| self.cost(*cell)).collect()
    }

    /// What the noise of an experiment is a part of.
    fn range(&self) -> f64;

    /// Writes down what was flown since the last time.
    fn keep(&self) -> Result<()> {
        Ok(())
    }
}

impl CellCosts for FlownGrid {
    fn key(&self) -> &str {
        &self.key
    }

    fn cost(&self, cell: usize) -> Cost {
        Self::cost(self, cell).clone()
    }

    fn range(&self) -> f64 {
        Self::range(self)
    }
}
