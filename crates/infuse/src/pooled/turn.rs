//! One turn of the pooled loop.

use std::collections::BTreeSet;

use design_space::Cell;
use rand::RngExt;

use crate::Error;
use crate::pooled::assessment::Assessment;
use crate::pooled::campaign::Loop;
use crate::pooled::designs::Designs;
use crate::pooled::evenly::spread;
use crate::pooled::first_batch::first_batch;
use crate::pooled::knowledge::Knowledge;
use crate::pooled::look::Look;
use crate::pooled::measurements::Measurements;
use crate::pooled::outliers::learnt;
use crate::pooled::pool::Pool;
use crate::pooled::reason::{Pick, Reason};
use crate::pooled::settings::Settings;
use crate::pooled::simulated::{Simulate, Simulated, Source};
use crate::pooled::streams::{Purpose, stream};

/// What follows from all that was told.
#[derive(Debug)]
pub(crate) enum Next {
    /// No other design is better by more than another batch is worth, and no measurement speaks against that.
    NotWorthIt,
    /// Cells to simulate ahead of all experiments.
    Simulations(Vec<Cell>),
    /// Cells to experiment at, and those to simulate for them.
    Batch { experiments: Vec<Pick>, simulations: Vec<Cell> },
}

/// The turn.
impl Loop {
    /// From all readings so far to the next batch; nothing of it is handed out yet.
    pub(super) fn turn(&mut self, simulate: Option<&mut dyn Simulate>) -> Result<Next, Error> {
        // Where simulations are dear, some come first.
        if self.needs_first_simulations() {
            return Ok(Next::Simulations(self.first_simulations()));
        }
        if self.is_nothing_left() {
            return Err(Error::EveryDesignRefused { n_refused: self.refused.len() });
        }
        let (batch, pending, measurements) = (self.told_batch(), self.pending_cells(), self.measurements()?);
        let settings = &measurements.settings(&self.settings);
        let (designs, simulated) = (&self.designs, &mut self.simulated);
        let source = Source::of(settings, designs, simulated, simulate)?;
        // Too few readings to tell even a plane from its noise: a batch that is spread.
        if measurements.readings.len() < designs.n_to_tell() {
            return spread_batch(measurements, pending, designs, settings, simulated, source);
        }
        // One surface through all readings, but for those that repeats give the lie to,
        let (mut knowledge, readings) = learnt(measurements, designs, settings, simulated, source)?;
        // its lowest mean, and how much better another design may be.
        let look = Look::at(&mut knowledge, &readings, settings, batch)?;
        let Assessment { contradiction, .. } = &look.assessment;
        let left = look.assessment.bound_to_stop_by(settings.stop_by);
        let is_enough = |worth| contradiction.is_none() && left.is_some_and(|left| left <= worth);
        if settings.worth.is_some_and(is_enough) {
            return Ok(Next::NotWorthIt);
        }
        // The experiments that lower the expected minimum most, and what to simulate for them.
        let experiments = look.picks(&mut knowledge, settings, &pending, batch)?;
        let simulations = match settings.simulations {
            Some(budget) => simulations_of_a_batch(&knowledge, &look.pool, &Pick::cells(&experiments), budget)?,
            None => Vec::new(),
        };
        Ok(Next::Batch { experiments, simulations })
    }
}

/// Its steps.
impl Loop {
    /// Whether simulations are dear and none was run yet.
    fn needs_first_simulations(&self) -> bool {
        self.settings.simulations.is_some_and(|budget| budget > 0) && self.simulated.len() == 0 && self.due.is_empty()
    }

    /// Whether every design was refused.
    fn is_nothing_left(&self) -> bool {
        let n_refused = self.refused.len() as u64;
        n_refused > 0 && n_refused >= self.designs.n_allowed() && self.designs.cells().all(|cell| !self.allows(cell))
    }

    fn first_simulations(&self) -> Vec<Cell> {
        let mut rng = stream(self.settings.seed, Purpose::Simulations, 0);
        spread(&self.designs, self.settings.simulations.unwrap_or(0), rng.random())
    }
}

/// Two thirds over the box, a third over what the simulation likes.
fn spread_batch(
    measurements: Measurements,
    pending: Vec<Cell>,
    designs: &Designs,
    settings: &Settings,
    simulated: &mut Simulated,
    mut source: Source<'_>,
) -> Result<Next, Error> {
    let Measurements { readings, failed: mut tested, refused, .. } = measurements;
    tested.extend(readings.iter().map(|reading| reading.cell).chain(pending));
    let cells = first_batch(designs, settings, (&tested, &refused), simulated, &mut source)?;
    let mut simulations = Vec::new();
    if settings.simulations.is_some() {
        simulations.extend(cells.iter().filter(|&&cell| !simulated.contains(cell)));
    }
    let experiments = cells.into_iter().map(|cell| Pick { cell, reason: Reason::Start }).collect();
    Ok(Next::Batch { experiments, simulations })
}

/// What a batch simulates: its own cells, and as many promising ones as the budget allows, where the emulator knows least.
fn simulations_of_a_batch(
    knowledge: &Knowledge<'_, '_>,
    pool: &Pool,
    cells: &[Cell],
    budget: usize,
) -> Result<Vec<Cell>, Error> {
    let there = |cells: &[Cell]| -> BTreeSet<Cell> {
        let there = cells.iter().map(|&cell| knowledge.simulated_at(cell));
        there.filter(|&cell| !knowledge.simulated.contains(cell)).collect()
    };
    let mut due: Vec<Cell> = there(cells).into_iter().collect();
    if knowledge.displacement().is_some() {
        // What was measured before is compared with other simulations now than with those that were run for it.
        let others: Vec<Cell> = there(&knowledge.measured).into_iter().filter(|cell| !due.contains(cell)).collect();
        due.extend(others.into_iter().take(budget.saturating_sub(due.len())));
    }
    let mut seen: BTreeSet<Cell> = due.iter().copied().collect();
    let new = pool.cells.iter().map(|&cell| knowledge.simulated_at(cell));
    let new: Vec<Cell> = new.filter(|&cell| !knowledge.simulated.contains(cell) && seen.insert(cell)).collect();
    due.extend(knowledge.least_simulated(&new, budget.saturating_sub(due.len()))?);
    Ok(due)
}
