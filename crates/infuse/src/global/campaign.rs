//! A campaign of the dissertation's loop: its state, and what can be read from it.

use std::collections::BTreeSet;

use design_space::{Cell, Grid, Region};

use crate::Error;
use crate::global::cells::Cells;
use crate::global::earlier::EarlierExperiment;
use crate::global::open_batch::OpenBatch;
use crate::global::report::{Report, StopReason};
use crate::global::retained::RetainedSet;
use crate::global::settings::Settings;
use crate::global::surfaces::BatchSurfaces;
use crate::global::trial::Trial;

/// Experimentally infused optimization over a gridded design space: the loop of Chapters 5 and 6, as ask
/// and tell.
///
/// The value is the whole state. It serializes with serde, a few hundred bytes per run and nothing per cell, provided the
/// format keeps doubles exactly (`serde_json` does so only with its feature `float_roundtrip`); what holds when it is read
/// again, here and on another machine, is said [above](crate::global#a-saved-campaign-here-and-on-another-machine).
/// The simulation is not part of it: give the same one to every [`ask`](Self::ask).
#[derive(Debug, Clone)]
pub struct Loop {
    pub(super) cells: Cells,
    pub(super) settings: Settings,
    pub(super) retained: RetainedSet,
    pub(super) history: Vec<Report>,
    pub(super) surfaces: Vec<BatchSurfaces>,
    pub(super) open: Option<OpenBatch>,
    /// Where simulations failed in calls of `ask` that opened no batch.
    pub(super) failed_cells: BTreeSet<Cell>,
    /// In the order in which they were added.
    pub(super) earlier: Vec<EarlierExperiment>,
}

impl Loop {
    /// A campaign that has not begun, over every combination of the levels of this region.
    ///
    /// # Errors
    ///
    /// [`Error::DesignSpace`] for a parameter without levels, [`Error::TooManyCells`], and those of
    /// [`Settings::validate`].
    pub fn new(region: &Region, settings: Settings) -> Result<Self, Error> {
        settings.validate(region)?;
        region.parameters().iter().try_for_each(design_space::Parameter::check_number)?;
        let cells = Cells::of(region)?;
        let retained = RetainedSet::full(cells.n_cells());
        let (history, surfaces) = (Vec::new(), Vec::new());
        let (failed_cells, earlier) = (BTreeSet::new(), Vec::new());
        Ok(Self { cells, settings, retained, history, surfaces, open: None, failed_cells, earlier })
    }

    /// The parameters and their levels.
    #[must_use]
    pub fn region(&self) -> &Region {
        self.cells.region()
    }

    /// The parameters and their levels as a grid of cells.
    #[must_use]
    pub fn grid(&self) -> &Grid {
        self.cells.grid()
    }

    /// The settings it was begun with.
    #[must_use]
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The closed batches, first to last.
    #[must_use]
    pub fn reports(&self) -> &[Report] {
        &self.history
    }

    /// The surfaces of the closed batches, first to last.
    #[must_use]
    pub fn surfaces(&self) -> &[BatchSurfaces] {
        &self.surfaces
    }

    /// The experiments made outside the campaign.
    #[must_use]
    pub fn earlier(&self) -> &[EarlierExperiment] {
        &self.earlier
    }

    /// The trials handed out whose outcomes are still waited for.
    #[must_use]
    pub fn outstanding(&self) -> Vec<Trial> {
        self.open.iter().flat_map(|open| open.trials.outstanding()).cloned().collect()
    }

    /// Why the campaign has ended; nothing while it goes on.
    #[must_use]
    pub fn stop(&self) -> Option<StopReason> {
        let last = self.history.last()?;
        if self.open.is_some() { None } else { last.stop(&self.settings) }
    }

    /// Settings of a cell, natural.
    ///
    /// # Errors
    ///
    /// [`Error::DesignSpace`] for a cell outside the grid.
    pub fn point(&self, cell: Cell) -> Result<Vec<f64>, Error> {
        self.cells.natural(cell)
    }

    /// Settings of a cell, coded to the original box: where to evaluate [`surfaces`](Self::surfaces).
    ///
    /// # Errors
    ///
    /// [`Error::DesignSpace`] for a cell that does not exist.
    pub fn coded(&self, cell: Cell) -> Result<Vec<f64>, Error> {
        self.cells.coded(cell)
    }

    /// The cell nearest to a natural point.
    ///
    /// # Errors
    ///
    /// [`Error::DesignSpace`] for a point outside the region.
    pub fn cell(&self, point: &[f64]) -> Result<Cell, Error> {
        Ok(self.grid().nearest(point)?)
    }

    /// Number of the batch that is open or comes next, from 1.
    pub(super) fn batch(&self) -> usize {
        self.history.len() + 1
    }

    /// How many trials the closed batches handed out.
    pub(super) fn n_asked(&self) -> u64 {
        self.history.iter().map(|report| report.trials.len() as u64).sum()
    }
}

/// Everything else follows from these.
impl PartialEq for Loop {
    fn eq(&self, other: &Self) -> bool {
        self.region() == other.region()
            && self.settings == other.settings
            && self.history == other.history
            && self.open == other.open
            && self.failed_cells == other.failed_cells
            && self.earlier == other.earlier
    }
}
