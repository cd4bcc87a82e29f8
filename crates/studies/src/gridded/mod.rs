//! What the studies of the global loop share: a design space of levels, its cost at every cell, campaigns over it, and how
//! far their models are from the truth.

mod accuracy;
mod campaign;
mod flown;
mod key;
mod on_demand;
mod panels;
mod regressor;
mod source;
mod space;
#[cfg(test)]
mod tests;

pub(crate) use accuracy::{Accuracy, IterationAccuracy, NORMS, NormAccuracy, Q2, SUP};
pub(crate) use campaign::{Campaigns, SurrogateRig};
pub(crate) use flown::{FlightStore, FlownGrid};
pub(crate) use on_demand::OnDemand;
pub(crate) use panels::{cell_panel, design_points};
pub(crate) use regressor::Regressor;
pub(crate) use source::CellCosts;
pub(crate) use space::{ParameterEntry, Space};
