//! What is known, for whoever asks.

use design_space::Cell;

use crate::Error;
use crate::pooled::assessment::{Assessment, Constrained, Expectation, Standing, constrained_at, standing};
use crate::pooled::bands::Bands;
use crate::pooled::campaign::Loop;
use crate::pooled::knowledge::Knowledge;
use crate::pooled::look::Look;
use crate::pooled::outliers::{Readings, learnt, surprises};
use crate::pooled::pool::Pool;
use crate::pooled::recommendation::lowest_mean;
use crate::pooled::settings::Settings;
use crate::pooled::simulated::{Simulate, Source};

impl Loop {
    /// What the experiments so far come to; nothing before the first response.
    ///
    /// # Errors
    ///
    /// [`Error::Surface`] if the responses cannot be fitted.
    pub fn assess(&mut self, simulate: Option<&mut dyn Simulate>) -> Result<Option<Assessment>, Error> {
        self.with_knowledge(simulate, |knowledge, readings, settings, batch| {
            Look::at(knowledge, readings, settings, batch)?.assessment.with_shifts(knowledge, readings, settings)
        })
    }

    /// What is known of these designs, beside the recommended one; nothing before the first response.
    ///
    /// # Errors
    ///
    /// [`Error::Surface`] if the responses cannot be fitted, [`Error::DesignSpace`] for a cell that does not exist.
    pub fn standings(
        &mut self,
        cells: &[Cell],
        simulate: Option<&mut dyn Simulate>,
    ) -> Result<Option<Vec<Standing>>, Error> {
        self.with_knowledge(simulate, |knowledge, readings, settings, batch| {
            let pool = Pool::gather(knowledge, settings.seed, batch)?;
            let recommended = lowest_mean(knowledge, &pool, readings.kept.len(), settings.seed, batch)?;
            let (kept, constrained) = (&readings.kept, &readings.constrained);
            let bands = Bands::of(kept, knowledge.designs.n_terms());
            let at = |&cell| {
                let standing = standing(knowledge, kept, constrained, cell, recommended, settings.confidence)?;
                Ok(standing.widened(bands))
            };
            cells.iter().map(at).collect::<Result<Vec<_>, _>>()
        })
    }

    /// What is expected at these designs, all at once; nothing before the first response.
    ///
    /// # Errors
    ///
    /// Those of [`standings`](Self::standings).
    pub fn expectations(
        &mut self,
        cells: &[Cell],
        simulate: Option<&mut dyn Simulate>,
    ) -> Result<Option<Vec<Expectation>>, Error> {
        self.with_knowledge(simulate, |knowledge, readings, _, _| {
            let bands = Bands::of(&readings.kept, knowledge.designs.n_terms());
            let places = knowledge.places(cells)?;
            let (marginals, chances) = (knowledge.marginals(&places)?, knowledge.chances(cells, &places)?);
            let pairs = marginals.means.into_iter().zip(marginals.variances).zip(chances.responding);
            let pairs = pairs.zip(constrained_at(knowledge, cells)?);
            let expectation = |(((mean, variance), feasible), constrained): (((f64, f64), f64), Vec<Constrained>)| {
                Expectation { mean, deviation: bands.widen(variance.sqrt()), feasible, constrained }
            };
            Ok(pairs.map(expectation).collect())
        })
    }

    /// How far each reading is from what all others say of its settings, in standard deviations; those of
    /// [earlier](Self::earlier) experiments first, then those of the trials in their order. Nothing before the first response.
    ///
    /// # Errors
    ///
    /// [`Error::Surface`] if the responses cannot be fitted.
    pub fn surprises(&mut self, simulate: Option<&mut dyn Simulate>) -> Result<Option<Vec<f64>>, Error> {
        let n = self.readings()?.len();
        self.with_knowledge(simulate, |knowledge, readings, _, _| {
            let mut all = vec![0.0; n];
            for (reading, surprise) in readings.kept.iter().zip(surprises(knowledge, &readings.kept)) {
                all[reading.number] = surprise;
            }
            for outlier in &readings.set_aside {
                all[outlier.reading] = outlier.deviations;
            }
            Ok(all)
        })
    }

    fn with_knowledge<T>(
        &mut self,
        simulate: Option<&mut dyn Simulate>,
        read: impl FnOnce(&mut Knowledge<'_, '_>, &Readings, &Settings, usize) -> Result<T, Error>,
    ) -> Result<Option<T>, Error> {
        let measurements = self.measurements()?;
        if measurements.readings.is_empty() {
            return Ok(None);
        }
        let batch = self.told_batch();
        let (settings, designs) = (&measurements.settings(&self.settings), &self.designs);
        let source = Source::of(settings, designs, &mut self.simulated, simulate)?;
        let (mut knowledge, readings) = learnt(measurements, designs, settings, &mut self.simulated, source)?;
        read(&mut knowledge, &readings, settings, batch).map(Some)
    }
}
