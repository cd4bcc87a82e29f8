//! The gridded design space: the grid of a region, and its points as surfaces take them.

use design_space::{Cell, Grid, Region};
use doe::Space;
use surface::{GridPoints, PointSource};

use crate::Error;

/// The grid of a region, nothing stored per cell.
#[derive(Debug, Clone)]
pub(crate) struct Cells {
    grid: Grid,
    points: GridPoints,
}

impl Cells {
    /// The loop goes through all of them several times a batch, and a set of some of them takes up to 128 MiB.
    pub(crate) const MOST: u64 = 1 << 30;

    pub(crate) fn of(region: &Region) -> Result<Self, Error> {
        let grid = Grid::of(region)?;
        if grid.n_cells() > Self::MOST {
            return Err(Error::TooManyCells { n_cells: grid.n_cells(), most: Self::MOST });
        }
        let points = GridPoints::of_space(&Space::of_region(region)?)?;
        Ok(Self { grid, points })
    }

    pub(crate) fn grid(&self) -> &Grid {
        &self.grid
    }

    pub(crate) fn region(&self) -> &Region {
        self.grid.region()
    }

    /// All cells, coded to the original box.
    pub(crate) fn points(&self) -> &GridPoints {
        &self.points
    }

    pub(crate) fn n_factors(&self) -> usize {
        self.points.n_factors()
    }

    pub(crate) fn n_cells(&self) -> u64 {
        self.points.n_points()
    }

    /// Number of levels of the last parameter: cells of one line lie side by side.
    pub(crate) fn line(&self) -> u64 {
        self.grid.combinations().counts().last().copied().unwrap_or(1)
    }

    /// Coded to the original box.
    pub(crate) fn coded(&self, cell: Cell) -> Result<Vec<f64>, Error> {
        self.all_coded(&[cell])
    }

    /// The same of many, one after the other.
    pub(crate) fn all_coded(&self, cells: &[Cell]) -> Result<Vec<f64>, Error> {
        let (axes, n_cells) = (self.points.levels(), self.n_cells());
        let (mut coordinates, mut digits) = (Vec::with_capacity(cells.len() * axes.len()), vec![0; axes.len()]);
        for index in cells.iter().map(|cell| cell.index()) {
            if index >= n_cells {
                return Err(design_space::Error::NoSuchCell { index, n_cells }.into());
            }
            self.grid.combinations().fill_digits(index, &mut digits);
            coordinates.extend(axes.iter().zip(&digits).map(|(axis, &digit)| axis[digit as usize]));
        }
        Ok(coordinates)
    }

    pub(crate) fn natural(&self, cell: Cell) -> Result<Vec<f64>, Error> {
        Ok(self.grid.point(cell)?)
    }
}

#[cfg(test)]
impl Cells {
    /// A box from -1 to 1 along every axis, with so many levels each.
    pub(crate) fn with_levels(levels: &[u32]) -> Self {
        let parameter = |(index, &count): (usize, &u32)| {
            design_space::Parameter::continuous(format!("p{index}"), "m", -1.0, 1.0)
                .unwrap()
                .with_levels(count)
                .unwrap()
        };
        Self::of(&Region::new(levels.iter().enumerate().map(parameter).collect()).unwrap()).unwrap()
    }
}
