//! What the studies of the dissertation's loop share: a design space of levels, its cost at every cell, campaigns over it, and how
//! far their models are from the truth.

mod accuracy;
mod campaign;
mod cell_costs;
mod designs;
mod grid;
mod panels;
mod per_cell;
mod regressor;
mod space;
#[cfg(test)]
mod tests;

pub(crate) use accuracy::{Accuracy, IterationAccuracy, NORMS, NormAccuracy, Q2, SUP};
pub(crate) use campaign::StandInRig;
pub(crate) use cell_costs::{CellCosts, OnDemand};
pub(crate) use designs::Designs;
pub(crate) use grid::FlownGrid;
pub(crate) use panels::{cell_panel, design_points};
pub(crate) use regressor::Regressor;
pub(crate) use space::Space;
