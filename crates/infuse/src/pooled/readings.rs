//! What was measured, out of all that was told.

use std::collections::BTreeSet;

use design_space::Cell;

use crate::Error;
use crate::pooled::block::Block;
use crate::pooled::campaign::{Earlier, Loop, Record};
use crate::pooled::measurements::{Measurements, Reading};
use crate::pooled::plants::Assemblies;

impl Loop {
    /// All responses: earlier ones first, then those of the trials in their order.
    pub(super) fn readings(&self) -> Result<Vec<Reading>, Error> {
        let measured = |earlier: &Earlier| Some(self.reading(&earlier.point, earlier.outcome.cost()?));
        let earlier = self.earlier.iter().filter_map(measured);
        let measured = self.records.iter().filter_map(|record| record.cost().map(|response| (record, response)));
        let own = measured.map(|(record, response)| match &record.actual {
            Some(actual) => self.reading(actual, response),
            None => {
                let cell = record.trial.cell;
                Ok(Reading { coded: self.designs.coded_of(cell)?, cell, response, number: 0, assembly: None })
            }
        });
        let numbered = |(number, reading): (usize, Result<Reading, Error>)| Ok(Reading { number, ..reading? });
        let mut readings: Vec<Reading> = earlier.chain(own).enumerate().map(numbered).collect::<Result<_, Error>>()?;
        self.assemble(&mut readings, &self.response_blocks());
        Ok(readings)
    }

    /// The block of each of them.
    fn response_blocks(&self) -> Vec<Block> {
        self.blocks(|earlier| earlier.outcome.cost().is_some(), |record| record.cost().is_some())
    }

    /// The blocks of the earlier experiments and of the records that count, in the order of their readings.
    fn blocks(&self, counts: impl Fn(&Earlier) -> bool, has_counted: impl Fn(&Record) -> bool) -> Vec<Block> {
        let earlier =
            self.earlier.iter().filter(|earlier| counts(earlier)).map(|one| Block::Source(one.source.clone()));
        let own = self.records.iter().filter(|record| has_counted(record)).map(|one| Block::Batch(one.trial.batch));
        earlier.chain(own).collect()
    }

    /// Says which readings share an error, where there are plants: those of one plant in one batch, what was made before standing alone.
    fn assemble(&self, readings: &mut [Reading], blocks: &[Block]) {
        let Some(plants) = &self.settings.plants else { return };
        let mut assemblies = Assemblies::default();
        for (reading, block) in readings.iter_mut().zip(blocks) {
            reading.assembly = Some(match block {
                Block::Batch(_) => assemblies.of(block, plants.of(&self.designs, reading.cell)),
                Block::Source(_) => assemblies.alone(),
            });
        }
    }

    /// All that was measured.
    pub(super) fn measurements(&self) -> Result<Measurements, Error> {
        let mut failed = self.failed_cells()?;
        failed.extend(&self.refused);
        let constrained = (0..self.settings.constraints.len()).map(|index| self.constrained_readings(index));
        let (constrained, refused) = (constrained.collect::<Result<_, _>>()?, self.refused.clone());
        let readings = self.readings()?;
        let n_earlier = self.earlier.iter().filter(|earlier| earlier.outcome.cost().is_some()).count();
        let n_failed = self.n_failed(&readings);
        let blocks = self.response_blocks();
        let constrained_blocks =
            (0..self.settings.constraints.len()).map(|index| self.constrained_blocks(index)).collect();
        Ok(Measurements { readings, constrained, failed, refused, n_earlier, n_failed, blocks, constrained_blocks })
    }

    /// Designs of the campaign that gave no response in any experiment.
    fn n_failed(&self, readings: &[Reading]) -> usize {
        let measured: BTreeSet<Cell> = readings.iter().map(|reading| reading.cell).collect();
        let failed = self.records.iter().filter(|record| record.is_failed()).map(|record| record.trial.cell);
        failed.collect::<BTreeSet<Cell>>().difference(&measured).count()
    }

    /// All readings of a constrained response: earlier ones first.
    fn constrained_readings(&self, index: usize) -> Result<Vec<Reading>, Error> {
        let value = |values: &[Option<f64>]| values.get(index).copied().flatten();
        let earlier = self.earlier.iter().filter_map(|one| Some(self.reading(&one.point, value(&one.constrained)?)));
        let own = self.records.iter().filter_map(|record| {
            let response = value(self.constrained(record.trial.id))?;
            Some(self.reading(record.actual.as_ref().unwrap_or(&record.trial.point), response))
        });
        let numbered = |(number, reading): (usize, Result<Reading, Error>)| Ok(Reading { number, ..reading? });
        let mut readings: Vec<Reading> = earlier.chain(own).enumerate().map(numbered).collect::<Result<_, Error>>()?;
        self.assemble(&mut readings, &self.constrained_blocks(index));
        Ok(readings)
    }

    /// The block of each of them.
    fn constrained_blocks(&self, index: usize) -> Vec<Block> {
        let is_there = |values: &[Option<f64>]| values.get(index).copied().flatten().is_some();
        let was_measured = |record: &Record| is_there(self.constrained(record.trial.id));
        self.blocks(|earlier| is_there(&earlier.constrained), was_measured)
    }

    /// Where an experiment failed: at the settings really made, as far as they are known.
    fn failed_cells(&self) -> Result<BTreeSet<Cell>, Error> {
        let nearest = |point: &[f64]| Ok(self.designs.grid().nearest_clamped(point)?);
        let earlier = self.earlier.iter().filter(|earlier| earlier.outcome.cost().is_none());
        let own = self.records.iter().filter(|record| record.is_failed()).map(|record| match &record.actual {
            Some(actual) => nearest(actual),
            None => Ok(record.trial.cell),
        });
        earlier.map(|earlier| nearest(&earlier.point)).chain(own).collect()
    }

    /// A response at natural settings, on the grid or off it.
    fn reading(&self, point: &[f64], response: f64) -> Result<Reading, Error> {
        let cell = self.designs.grid().nearest_clamped(point)?;
        let (on_grid, here) = (self.designs.coded_of(cell)?, self.designs.coded_point(point)?);
        // Settings of the grid, however they were written, are those of the grid.
        let same = on_grid.iter().zip(&here).all(|(a, b)| (a - b).abs() < 1e-9);
        Ok(Reading { coded: if same { on_grid } else { here }, cell, response, number: 0, assembly: None })
    }

    /// The cells of the trials without an outcome.
    pub(super) fn pending_cells(&self) -> Vec<Cell> {
        self.records.iter().filter(|record| record.outcome.is_none()).map(|record| record.trial.cell).collect()
    }
}
