//! What is left of the grid, and why the rest is not.

use design_space::Cell;
use surface::Surface;

use crate::Error;
use crate::checks::check_length;
use crate::convergence::{Norm, coded_cell_measure};
use crate::global::campaign::Loop;
use crate::global::report::Report;
use crate::global::retained::RetainedSet;
use crate::global::screening::{Dropped, z};
use crate::global::trial::TrialRecord;

impl Loop {
    /// What is left of the grid.
    #[must_use]
    pub fn retained(&self) -> &RetainedSet {
        &self.retained
    }

    /// M_i, what was left at the onset of batch i from 1: recomputed from the surfaces of the batches before.
    /// None beyond the batch that is open or comes next.
    #[must_use]
    pub fn retained_at(&self, batch: usize) -> Option<RetainedSet> {
        if !(1..=self.batch()).contains(&batch) {
            return None;
        }
        let mut closed = self.history.iter().zip(&self.surfaces).enumerate().take(batch - 1);
        let full = RetainedSet::full(self.cells.n_cells());
        closed.try_fold(full, |left, (before, (report, surfaces))| {
            let left = self.without_failed(&left, &self.history[..before], &report.trials).ok()?;
            Some(report.screening.reduced(&left, self.cells.points(), &surfaces.combined))
        })
    }

    /// These cells; in a [careful](crate::global::Settings::careful) campaign without those where experiments of this batch or
    /// the closed ones before it failed and none gave a response, unless nothing would be left.
    pub(super) fn without_failed(
        &self,
        left: &RetainedSet,
        closed: &[Report],
        batch: &[TrialRecord],
    ) -> Result<RetainedSet, Error> {
        if !self.settings().careful {
            return Ok(left.clone());
        }
        let others = left.without(&self.experience_with(closed, batch)?.failed);
        Ok(if others.n_retained() > 0 { others } else { left.clone() })
    }

    /// The batch after which a cell was dropped because every experiment there had failed: only in a
    /// [careful](crate::global::Settings::careful) campaign. None if it was not dropped for that.
    #[must_use]
    pub fn failed_in(&self, cell: Cell) -> Option<usize> {
        if !self.settings().careful || self.is_retained(cell) {
            return None;
        }
        let failed = |&batch: &usize| {
            let (before, report) = (&self.history[..batch - 1], &self.history[batch - 1]);
            self.experience_with(before, &report.trials).is_ok_and(|experience| experience.failed.contains(&cell))
        };
        let failed = (1..=self.history.len()).find(failed)?;
        self.dropped_by_test(cell, failed - 1).is_none().then_some(failed)
    }

    /// Whether this cell is among those left.
    #[must_use]
    pub fn is_retained(&self, cell: Cell) -> bool {
        self.retained.contains(cell)
    }

    /// A norm (42) of a surface over M_i, i from 1, cells measured in coordinates coded to the original box. Nothing is
    /// stored per cell, and the number of threads changes no bit.
    ///
    /// # Errors
    ///
    /// [`Error::SettingCount`] for a batch beyond the one that is open or comes next, [`Error::WrongLength`] for a
    /// surface with another number of factors, [`Error::Entry`] with the first cell at which it is not finite,
    /// [`Error::Setting`] if the norm itself is too large for a double.
    pub fn norm_over(&self, batch: usize, surface: &dyn Surface, norm: Norm) -> Result<f64, Error> {
        let k = self.cells.n_factors();
        check_length("surface", k, surface.n_factors())?;
        let expected = "1 to that of the batch that is open or comes next";
        let absent = Error::SettingCount { name: "batch", value: batch, expected };
        let cell = coded_cell_measure(k, usize::try_from(self.cells.n_cells()).unwrap_or(usize::MAX))?;
        let region = self.retained_at(batch).ok_or(absent)?;
        region.norm(self.cells.points(), surface, norm, cell)
    }

    /// When and why a cell was dropped by the test, from the surfaces of that batch; none if it was not, or is no cell. Of a
    /// cell that was dropped for its failures, [`failed_in`](Self::failed_in) says when.
    #[must_use]
    pub fn why_dropped(&self, cell: Cell) -> Option<Dropped> {
        let tested = self.failed_in(cell).map_or(self.history.len(), |failed| failed - 1);
        self.dropped_by_test(cell, tested)
    }

    /// The first test among those of so many batches that a cell does not pass.
    fn dropped_by_test(&self, cell: Cell, n_batches: usize) -> Option<Dropped> {
        let point = self.cells.coded(cell).ok()?;
        self.history.iter().zip(&self.surfaces).take(n_batches).find_map(|(report, surfaces)| {
            let screening = &report.screening;
            let (spread, value) = (screening.tested_spread()?, surfaces.combined.surface().predict(&point));
            let (optimum_value, batch) = (screening.optimum_value, report.number);
            let z = z(value, optimum_value, spread);
            let z0 = screening.threshold;
            (!screening.keeps(value)).then_some(Dropped { batch, value, optimum_value, spread, z, z0 })
        })
    }
}
