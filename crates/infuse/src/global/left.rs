//! What is left of the grid, and why the rest is not.

use design_space::Cell;
use surface::Surface;

use crate::Error;
use crate::checks::check_length;
use crate::convergence::{Norm, coded_cell_measure};
use crate::global::campaign::Loop;
use crate::global::retained::RetainedSet;
use crate::global::screening::{Dropped, z};

impl Loop {
    /// What is left of the grid.
    #[must_use]
    pub fn retained(&self) -> &RetainedSet {
        &self.retained
    }

    /// M_i, what was left at the onset of batch i from 1: recomputed from the surfaces of the batches before.
    /// None beyond the batch that is open or comes next.
    #[must_use]
    pub fn retained_at(&self, iteration: usize) -> Option<RetainedSet> {
        if !(1..=self.iteration()).contains(&iteration) {
            return None;
        }
        let closed = self.history.iter().zip(&self.surfaces).take(iteration - 1);
        let full = RetainedSet::full(self.cells.n_cells());
        Some(closed.fold(full, |left, (report, surfaces)| {
            report.screening.reduced(&left, self.cells.points(), &surfaces.combined)
        }))
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
    pub fn norm_over(&self, iteration: usize, surface: &dyn Surface, norm: Norm) -> Result<f64, Error> {
        let k = self.cells.n_factors();
        check_length("surface", k, surface.n_factors())?;
        let expected = "1 to that of the batch that is open or comes next";
        let absent = Error::SettingCount { name: "iteration", value: iteration, expected };
        let cell = coded_cell_measure(k, usize::try_from(self.cells.n_cells()).unwrap_or(usize::MAX))?;
        let region = self.retained_at(iteration).ok_or(absent)?;
        region.norm(self.cells.points(), surface, norm, cell)
    }

    /// When and why a cell was dropped, from the surfaces of that batch; none if it was not, or is no cell.
    #[must_use]
    pub fn why_dropped(&self, cell: Cell) -> Option<Dropped> {
        let point = self.cells.coded(cell).ok()?;
        self.history.iter().zip(&self.surfaces).find_map(|(report, surfaces)| {
            let screening = &report.screening;
            let (spread, value) = (screening.tested_spread()?, surfaces.combined.surface().predict(&point));
            let (optimum_value, iteration) = (screening.optimum_value, report.iteration);
            let z = z(value, optimum_value, spread);
            let z0 = screening.threshold;
            (!screening.keeps(value)).then_some(Dropped { iteration, value, optimum_value, spread, z, z0 })
        })
    }
}
