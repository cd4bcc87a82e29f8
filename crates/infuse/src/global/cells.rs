//! The gridded design space: every combination of levels, by index, nothing stored.

use doe::{Parameter, Region, Space};
use surface::{GridPoints, PointSource};

use crate::Error;

/// The grid of a region. Cells count as in [`doe::Grid`], the last parameter fastest.
#[derive(Debug, Clone)]
pub(crate) struct Cells {
    region: Region,
    counts: Vec<u64>,
    points: GridPoints,
}

impl Cells {
    /// One bit per cell: 2 GiB.
    pub(crate) const MOST: u64 = 1 << 34;

    pub(crate) fn of(region: &Region) -> Result<Self, Error> {
        let n_cells = design_space::Grid::of(region)?.n_cells();
        if n_cells > Self::MOST {
            return Err(Error::TooManyCells { n_cells, most: Self::MOST });
        }
        let points = GridPoints::of_space(&Space::of_region(region)?)?;
        let counts = region.parameters().iter().map(|parameter| match parameter.levels() {
            doe::Levels::Count(count) => u64::from(count),
            // A region with a grid has none.
            doe::Levels::Continuous => 1,
        });
        Ok(Self { region: region.clone(), counts: counts.collect(), points })
    }

    pub(crate) fn region(&self) -> &Region {
        &self.region
    }

    pub(crate) fn points(&self) -> &GridPoints {
        &self.points
    }

    pub(crate) fn n_factors(&self) -> usize {
        self.counts.len()
    }

    pub(crate) fn n_cells(&self) -> u64 {
        self.points.n_points()
    }

    /// Number of levels of the last parameter: cells of one line lie side by side.
    pub(crate) fn line(&self) -> u64 {
        self.counts[self.counts.len() - 1]
    }

    /// Level index of each parameter.
    pub(crate) fn digits(&self, mut cell: u64) -> Vec<u64> {
        let mut digits = vec![0; self.counts.len()];
        for (digit, count) in digits.iter_mut().zip(&self.counts).rev() {
            *digit = cell % count;
            cell /= count;
        }
        digits
    }

    pub(crate) fn of_digits(&self, digits: &[u64]) -> u64 {
        digits.iter().zip(&self.counts).fold(0, |cell, (digit, count)| cell * count + digit)
    }

    /// Coded to the original box.
    pub(crate) fn coded(&self, cell: u64) -> Result<Vec<f64>, Error> {
        self.points.point(cell).ok_or(Error::UnknownCell { cell_idx: cell as usize, n_cells: self.n_cells() as usize })
    }

    pub(crate) fn natural(&self, cell: u64) -> Result<Vec<f64>, Error> {
        Ok(design_space::Grid::of(&self.region)?.point(design_space::Cell::new(cell))?)
    }

    /// The cell nearest to a natural point within the region.
    pub(crate) fn nearest(&self, point: &[f64]) -> Result<u64, Error> {
        self.region.check(point)?;
        let pairs = self.region.parameters().iter().zip(point);
        let level = |(parameter, &value): (&Parameter, &f64)| parameter.nearest_level(value).map(u64::from);
        Ok(self.of_digits(&pairs.map(level).collect::<Result<Vec<_>, _>>()?))
    }
}
