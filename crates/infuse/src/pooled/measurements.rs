//! What was measured, as the surfaces take it.

use std::collections::BTreeSet;

use design_space::Cell;
use surface::Data;
use surface::process::Sites;

use crate::Error;

/// One experiment that gave a response.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Reading {
    pub(crate) coded: Vec<f64>,
    pub(crate) cell: Cell,
    pub(crate) response: f64,
    /// Position among all readings.
    pub(crate) number: usize,
    /// Which readings it shares an error with, where plants are told apart.
    pub(crate) assembly: Option<usize>,
}

impl Reading {
    /// Measurements with what the simulation says of each, as a process takes them.
    pub(crate) fn sites(readings: &[&Self], n_factors: usize, simulated: Option<&[f64]>) -> Result<Sites, Error> {
        let coordinates = readings.iter().flat_map(|reading| &reading.coded).copied().collect();
        let responses = readings.iter().map(|reading| reading.response).collect();
        let data = Data::new(n_factors, coordinates, responses)?;
        let assemblies: Option<Vec<usize>> = readings.iter().map(|reading| reading.assembly).collect();
        Ok(match assemblies.filter(|_| !readings.is_empty()) {
            Some(assemblies) => Sites::in_assemblies(&data, simulated, &assemblies)?,
            None => Sites::new(&data, simulated)?,
        })
    }
}

/// All that was measured.
#[derive(Debug, Clone, Default)]
pub(crate) struct Measurements {
    pub(crate) readings: Vec<Reading>,
    /// Readings of each constrained response.
    pub(crate) constrained: Vec<Vec<Reading>>,
    /// Where experiments failed, and what nobody can build.
    pub(crate) failed: BTreeSet<Cell>,
    /// Of these what nobody can build any more, whatever was measured there.
    pub(crate) refused: BTreeSet<Cell>,
}
