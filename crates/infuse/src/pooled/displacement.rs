//! How far a simulation is displaced: what it says of one design, experiments say of another.
//!
//! A model whose spring is softer than the real one, or whose sensor is off by a degree, is right about everything but the place. Neither
//! a factor nor a smooth discrepancy makes up for that where the response has features: between the simulated place of one and the real
//! one the discrepancy is as steep as the feature itself.

use design_space::Cell;

use crate::pooled::designs::Designs;

/// In levels along each axis: an experiment at a design gives what the simulation says of the design so many levels farther on.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Default)]
pub(crate) struct Displacement(pub(crate) Vec<i64>);

impl Displacement {
    pub(crate) fn is_none(&self) -> bool {
        self.0.iter().all(|step| *step == 0)
    }

    /// In the unit of each parameter.
    pub(crate) fn natural(&self, designs: &Designs) -> Vec<f64> {
        let counts = designs.combinations().counts();
        let axes = self.0.iter().zip(counts).zip(designs.region().parameters());
        axes.map(|((step, count), parameter)| share(*step, *count) * parameter.width()).collect()
    }

    /// The design whose simulation tells of this one; the nearest one at a bound. Where that is none, it tells of itself.
    pub(crate) fn of(&self, designs: &Designs, cell: Cell) -> Cell {
        self.moved(designs, cell, 1)
    }

    /// The design of which the simulation of this one tells.
    pub(crate) fn back(&self, designs: &Designs, cell: Cell) -> Cell {
        self.moved(designs, cell, -1)
    }

    fn moved(&self, designs: &Designs, cell: Cell, sign: i64) -> Cell {
        if self.is_none() {
            return cell;
        }
        let combinations = designs.combinations();
        let mut digits = combinations.digits(cell.index());
        for ((digit, step), count) in digits.iter_mut().zip(&self.0).zip(combinations.counts()) {
            *digit = digit.saturating_add_signed(sign * step).min(count - 1);
        }
        let moved = Cell::new(combinations.index(&digits));
        if designs.allows(moved) { moved } else { cell }
    }
}

/// Steps as a share of the range.
pub(crate) fn share(step: i64, count: u64) -> f64 {
    step as f64 / (count - 1).max(1) as f64
}
