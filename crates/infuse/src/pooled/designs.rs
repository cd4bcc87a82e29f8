//! The designs that a campaign chooses from: cells of a grid, however many.

use design_space::{Cell, Combinations, Grid, Levels, Parameter, Region};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use surface::process::Places;

use crate::Error;

/// All designs: combinations of levels. A parameter without levels has as many as make no difference.
#[derive(Debug, Clone)]
pub(crate) struct Designs {
    region: Region,
    grid: Grid,
}

impl Designs {
    /// Levels along a continuous parameter: steps of a thousandth of its width, or of the first of these shares with which all
    /// designs can be counted.
    pub(crate) const FINE: [u32; 7] = [1001, 501, 201, 101, 51, 21, 11];

    pub(crate) fn of(region: &Region) -> Result<Self, Error> {
        let with = |fine: u32| -> Result<Grid, Error> {
            let finely = |parameter: &Parameter| match parameter.levels() {
                Levels::Count(_) => Ok(parameter.clone()),
                Levels::Continuous => parameter.clone().with_levels(fine),
            };
            let parameters = region.parameters().iter().map(finely).collect::<Result<_, _>>()?;
            Ok(Grid::of(&Region::new(parameters)?)?)
        };
        let [finest, coarser @ ..] = Self::FINE;
        // The first refusal names what a person may change.
        let grid = with(finest).or_else(|error| coarser.into_iter().find_map(|fine| with(fine).ok()).ok_or(error))?;
        Ok(Self { region: region.clone(), grid })
    }

    pub(crate) fn region(&self) -> &Region {
        &self.region
    }

    pub(crate) fn grid(&self) -> &Grid {
        &self.grid
    }

    pub(crate) fn n_factors(&self) -> usize {
        self.region.n_parameters()
    }

    pub(crate) fn n_cells(&self) -> u64 {
        self.grid.n_cells()
    }

    pub(crate) fn combinations(&self) -> &Combinations {
        self.grid.combinations()
    }

    /// Coded coordinates of cells, row by row.
    pub(crate) fn coded(&self, cells: &[Cell]) -> Result<Vec<f64>, Error> {
        let mut coordinates = Vec::with_capacity(cells.len() * self.n_factors());
        for &cell in cells {
            coordinates.extend(self.grid.coded(cell)?);
        }
        Ok(coordinates)
    }

    /// Cells as places, without a simulation.
    pub(crate) fn places(&self, cells: &[Cell]) -> Result<Places, Error> {
        Ok(Places::new(self.n_factors(), &self.coded(cells)?)?)
    }

    /// The cell in which a point of the unit cube lies.
    pub(crate) fn cell_of_unit(&self, unit: impl Iterator<Item = f64>) -> Cell {
        let digits: Vec<u64> = self
            .combinations()
            .counts()
            .iter()
            .zip(unit)
            .map(|(&count, u)| ((u * count as f64) as u64).min(count - 1))
            .collect();
        Cell::new(self.combinations().index(&digits))
    }

    /// A cell drawn evenly.
    pub(crate) fn random(&self, rng: &mut ChaCha8Rng) -> Cell {
        Cell::new(rng.random_range(0..self.n_cells()))
    }

    /// A cell some steps away: every digit moves by up to `share` of its axis, at least one step for some.
    pub(crate) fn near(&self, cell: Cell, share: f64, rng: &mut ChaCha8Rng) -> Cell {
        let mut digits = self.combinations().digits(cell.index());
        for (digit, &count) in digits.iter_mut().zip(self.combinations().counts()) {
            let reach = ((count - 1) as f64 * share).max(1.0);
            let step = (reach * (2.0 * rng.random::<f64>() - 1.0)).round();
            *digit = (*digit as f64 + step).clamp(0.0, (count - 1) as f64) as u64;
        }
        Cell::new(self.combinations().index(&digits))
    }

    /// The cells that differ from this one by `stride` steps along one axis, for each axis and both directions.
    pub(crate) fn star(&self, cell: Cell, shares: f64) -> Vec<Cell> {
        let digits = self.combinations().digits(cell.index());
        let mut star = Vec::with_capacity(2 * digits.len());
        for (axis, &count) in self.combinations().counts().iter().enumerate() {
            let stride = (((count - 1) as f64 * shares).round() as u64).max(1);
            let mut push = |digit: u64| {
                if digit != digits[axis] {
                    let mut moved = digits.clone();
                    moved[axis] = digit;
                    star.push(Cell::new(self.combinations().index(&moved)));
                }
            };
            push(digits[axis].saturating_sub(stride));
            push((digits[axis] + stride).min(count - 1));
        }
        star
    }
}
