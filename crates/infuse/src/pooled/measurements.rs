//! What was measured, as the surfaces take it.

use std::collections::BTreeSet;

use design_space::Cell;
use surface::Data;
use surface::process::Sites;

use crate::Error;
use crate::pooled::settings::Settings;
use crate::pure_error::PureError;

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

/// So many repeats that do not differ at all say that there is no noise.
const ENOUGH_EQUAL: usize = 3;

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

impl Measurements {
    /// Whether readings are the same whenever settings are: nothing is learnt from one more of the same settings.
    fn are_exact(&self) -> bool {
        let readings = self.readings.iter().map(|reading| (reading.coded.clone(), reading.response));
        PureError::of_readings(readings)
            .is_some_and(|repeats| repeats.degrees_of_freedom >= ENOUGH_EQUAL && repeats.variance <= 0.0)
    }

    /// The settings, without noise where nothing was said of it and repeats show none.
    pub(crate) fn settings(&self, settings: &Settings) -> Settings {
        let noise = settings.noise.or_else(|| self.are_exact().then_some(0.0));
        Settings { noise, ..settings.clone() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_repeats_that_are_equal_say_that_there_is_no_noise() {
        let measured = |pairs: &[(f64, f64)]| {
            let reading = |(number, &(x, response)): (usize, &(f64, f64))| Reading {
                coded: vec![x],
                cell: Cell::new(0),
                response,
                number,
                assembly: None,
            };
            let readings = pairs.iter().enumerate().map(reading).collect();
            Measurements { readings, ..Measurements::default() }
        };
        let equal = [(0.1, 1.0), (0.2, 2.0), (0.1, 1.0), (0.1, 1.0), (0.2, 2.0)];
        let noise = |pairs: &[(f64, f64)], noise: Option<f64>| {
            let mut settings = Settings::new(4);
            settings.noise = noise;
            measured(pairs).settings(&settings).noise
        };
        assert_eq!(noise(&equal, None), Some(0.0));
        assert_eq!(noise(&equal, Some(0.3)), Some(0.3), "what was said counts");
        assert_eq!(noise(&equal[..4], None), None, "two are chance");
        let other = [&equal[..], &[(0.2, 2.0 + 1e-9)]].concat();
        assert_eq!(noise(&other, None), None);
    }
}
