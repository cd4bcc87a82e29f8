//! A small campaign, for tests of single steps.

use std::collections::BTreeSet;

use design_space::{Cell, Parameter, Region};
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;

use crate::pooled::designs::Designs;
use crate::pooled::knowledge::Knowledge;
use crate::pooled::measurements::{Measurements, Reading};
use crate::pooled::settings::Settings;
use crate::pooled::simulated::{Simulate, Simulated, Source};

/// Numbers from 0 to 1 with levels, and what was measured of them.
pub(crate) struct Scene {
    pub(crate) designs: Designs,
    pub(crate) settings: Settings,
    pub(crate) readings: Vec<Reading>,
    simulated: Simulated,
}

impl Scene {
    pub(crate) fn new(levels: &[u32]) -> Self {
        let number = |(index, &levels): (usize, &u32)| {
            Parameter::continuous(format!("x{index}"), "1", 0.0, 1.0).unwrap().with_levels(levels).unwrap()
        };
        let region = Region::new(levels.iter().enumerate().map(number).collect()).unwrap();
        let mut settings = Settings::new(6);
        settings.particles = 4;
        Self {
            designs: Designs::of(&region, &[], &mut ChaCha8Rng::seed_from_u64(1)).unwrap(),
            settings,
            readings: Vec::new(),
            simulated: Simulated::default(),
        }
    }

    pub(crate) fn cell(&self, digits: &[u64]) -> Cell {
        Cell::new(self.designs.combinations().index(digits))
    }

    /// One more reading, at these levels.
    pub(crate) fn read(&mut self, digits: &[u64], response: f64) {
        let cell = self.cell(digits);
        let (coded, number) = (self.designs.coded_of(cell).unwrap(), self.readings.len());
        self.readings.push(Reading { coded, cell, response, number, assembly: None });
    }

    /// What is known after all readings, with a simulation or without.
    pub(crate) fn knowledge<'a>(&'a mut self, simulate: Option<&'a mut dyn Simulate>) -> Knowledge<'a, 'a> {
        let measurements = Measurements {
            readings: self.readings.clone(),
            constrained: Vec::new(),
            failed: BTreeSet::new(),
            refused: BTreeSet::new(),
            ..Measurements::default()
        };
        let cheap = |simulate| Source::cheap(&self.designs, self.settings.seed, &mut self.simulated, simulate).unwrap();
        let source = simulate.map_or(Source::Nothing, cheap);
        Knowledge::of(&measurements, &self.designs, &self.settings, &mut self.simulated, source).unwrap()
    }
}
