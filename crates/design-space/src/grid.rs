//! Every combination of levels, by index.

use crate::{Cell, Combinations, Error, Levels, Parameter, Region};

/// The full grid of a region: every combination of levels is a [`Cell`], the last parameter varying fastest.
///
/// Points are computed from the digits of a cell in whole numbers, so a grid of any size costs no memory.
///
/// ```
/// use design_space::{Cell, Grid, Parameter, Region};
/// let grid = Grid::of(&Region::new(vec![
///     Parameter::continuous("mass", "kg", 1.0, 3.0)?.with_levels(3)?,
///     Parameter::continuous("pitch", "deg", 10.0, 22.0)?.with_levels(25)?,
/// ])?)?;
/// let cell = grid.nearest(&[2.1, 10.6])?;
/// assert_eq!(cell, Cell::new(26));
/// assert_eq!(grid.digits(cell)?, [1, 1]);
/// assert_eq!(grid.point(cell)?, [2.0, 10.5]);
/// assert_eq!(grid.coded(cell)?, [0.0, -11.0 / 12.0]);
/// # Ok::<(), design_space::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    region: Region,
    combinations: Combinations,
}

impl Grid {
    /// All combinations of the levels of a region.
    ///
    /// # Errors
    ///
    /// [`Error::Continuous`] for a parameter without levels, [`Error::GridTooLarge`] beyond 2⁶⁴ − 1 cells.
    pub fn of(region: &Region) -> Result<Self, Error> {
        let count = |parameter: &Parameter| match parameter.levels() {
            Levels::Count(count) => Ok(u64::from(count)),
            Levels::Continuous => Err(Error::Continuous { parameter: parameter.name().to_owned() }),
        };
        let counts: Vec<u64> = region.parameters().iter().map(count).collect::<Result<_, _>>()?;
        Ok(Self { region: region.clone(), combinations: Combinations::new(counts)? })
    }

    /// The region.
    #[must_use]
    pub fn region(&self) -> &Region {
        &self.region
    }

    /// The digits of its cells: one per parameter, from 0 at the lower bound.
    #[must_use]
    pub fn combinations(&self) -> &Combinations {
        &self.combinations
    }

    /// How many cells there are.
    #[must_use]
    pub fn n_cells(&self) -> u64 {
        self.combinations.len()
    }

    /// All cells, in order.
    pub fn cells(&self) -> impl Iterator<Item = Cell> + use<> {
        (0..self.n_cells()).map(Cell::new)
    }

    /// The indices of the levels of a cell, one per parameter.
    ///
    /// # Errors
    ///
    /// [`Error::NoSuchCell`].
    pub fn digits(&self, cell: Cell) -> Result<Vec<u64>, Error> {
        self.check(cell)?;
        Ok(self.combinations.digits(cell.index()))
    }

    /// The cell with these indices of levels.
    ///
    /// # Errors
    ///
    /// [`Error::WrongDimension`], [`Error::NoSuchLevel`].
    pub fn of_digits(&self, digits: &[u64]) -> Result<Cell, Error> {
        self.region.check_dimension(digits.len())?;
        for ((parameter, &count), &digit) in self.region.parameters().iter().zip(self.combinations.counts()).zip(digits)
        {
            if digit >= count {
                return Err(Error::NoSuchLevel {
                    parameter: parameter.name().to_owned(),
                    index: digit,
                    last: count - 1,
                });
            }
        }
        Ok(Cell::new(self.combinations.index(digits)))
    }

    /// The settings of a cell, natural coordinates.
    ///
    /// # Errors
    ///
    /// [`Error::NoSuchCell`].
    pub fn point(&self, cell: Cell) -> Result<Vec<f64>, Error> {
        let levels = self.digits(cell)?;
        let pairs = self.region.parameters().iter().zip(levels);
        pairs.map(|(parameter, level)| parameter.level(u32::try_from(level).unwrap_or(u32::MAX))).collect()
    }

    /// The coded coordinates of a cell: level i of n is (2 i − (n − 1)) / (n − 1), from −1 to 1.
    ///
    /// # Errors
    ///
    /// [`Error::NoSuchCell`].
    pub fn coded(&self, cell: Cell) -> Result<Vec<f64>, Error> {
        let levels = self.digits(cell)?;
        let pairs = levels.into_iter().zip(self.combinations.counts());
        Ok(pairs.map(|(level, &count)| coded_level(level, count)).collect())
    }

    /// The cell nearest to a point in natural coordinates; of two equally near levels the lower.
    ///
    /// # Errors
    ///
    /// Those of [`Region::check`]: nothing is moved into the bounds, or from between two choices to one of them.
    pub fn nearest(&self, point: &[f64]) -> Result<Cell, Error> {
        self.region.check(point)?;
        let pairs = self.region.parameters().iter().zip(point);
        let level = |(parameter, &value): (&Parameter, &f64)| parameter.nearest_level(value).map(u64::from);
        Ok(Cell::new(self.combinations.index(&pairs.map(level).collect::<Result<Vec<_>, _>>()?)))
    }

    /// The cell nearest to a point that may lie outside of the region, or between choices: that of the nearest point within, see
    /// [`Parameter::clamp`].
    ///
    /// # Errors
    ///
    /// [`Error::WrongDimension`], [`Error::NotANumber`].
    pub fn nearest_clamped(&self, point: &[f64]) -> Result<Cell, Error> {
        self.nearest(&self.region.clamp(point)?)
    }

    /// The cells one level away along one parameter: below, then above, parameter by parameter.
    ///
    /// # Errors
    ///
    /// [`Error::NoSuchCell`].
    pub fn neighbors(&self, cell: Cell) -> Result<Vec<Cell>, Error> {
        self.check(cell)?;
        Ok(self.combinations.neighbors(cell.index()).map(Cell::new).collect())
    }

    fn check(&self, cell: Cell) -> Result<(), Error> {
        let n_cells = self.n_cells();
        if cell.index() < n_cells { Ok(()) } else { Err(Error::NoSuchCell { index: cell.index(), n_cells }) }
    }
}

/// Level `level` of `count` equally spaced ones, coded. Every coded axis of the workspace has these very values.
#[must_use]
pub fn coded_level(level: u64, count: u64) -> f64 {
    let last = (count - 1) as f64;
    (2.0 * level as f64 - last) / last
}
