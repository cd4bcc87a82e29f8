//! A design space of levels, as a study file has it.

use anyhow::{Context as _, Result, ensure};
use design_space::{Cell, Grid, Region};

use crate::study_file::ParameterEntry;
use crate::variable::{Variable, point_words};

/// Cells of one space: more flights would take days.
const MOST_CELLS: u64 = 1_000_000;

/// Some of the parameters with their levels.
#[derive(Clone, Debug)]
pub(crate) struct Space {
    grid: Grid,
    pub(crate) variables: Vec<Variable>,
    n_cells: usize,
}

impl Space {
    /// The parameters of these names, all with the same number of levels.
    pub(crate) fn of(entries: &[ParameterEntry], names: &[String], levels: u32) -> Result<Self> {
        let (mut parameters, mut variables) = (Vec::new(), Vec::new());
        for name in names {
            let entry = entries.iter().find(|entry| entry.name == *name);
            let entry = entry.with_context(|| format!("parameters: `{name}` is no [[parameter]] of this file"))?;
            let (variable, parameter) = Variable::within(&entry.name, &entry.unit, entry.lower, entry.upper)?;
            variables.push(variable);
            parameters.push(parameter);
        }
        Self::over(&Region::new(parameters)?, variables, levels)
    }

    /// A box whose parameters are these variables, all with the same number of levels.
    pub(crate) fn over(region: &Region, variables: Vec<Variable>, levels: u32) -> Result<Self> {
        let parameters = region.parameters().iter().cloned().map(|parameter| parameter.with_levels(levels));
        let parameters = parameters.collect::<Result<Vec<_>, _>>().with_context(|| format!("levels = {levels}"))?;
        let grid = Grid::of(&Region::new(parameters)?)?;
        let n_cells = grid.n_cells();
        ensure!(
            n_cells <= MOST_CELLS,
            "levels = {levels}: {n_cells} cells, and each is flown: at most {MOST_CELLS} are allowed"
        );
        Ok(Self { grid, variables, n_cells: usize::try_from(n_cells)? })
    }

    pub(crate) fn region(&self) -> &Region {
        self.grid.region()
    }

    pub(crate) fn n_cells(&self) -> usize {
        self.n_cells
    }

    /// The cells, counted as the loop counts them.
    pub(crate) fn cells(&self) -> impl Iterator<Item = Cell> + use<> {
        self.grid.cells()
    }

    /// The natural coordinates of a cell.
    pub(crate) fn point(&self, cell: Cell) -> Result<Vec<f64>> {
        Ok(self.grid.point(cell)?)
    }

    /// Its coded ones.
    pub(crate) fn coded(&self, cell: Cell) -> Result<Vec<f64>> {
        Ok(self.grid.coded(cell)?)
    }

    /// Those of all cells, in their order.
    pub(crate) fn points(&self) -> Result<Vec<Vec<f64>>> {
        self.cells().map(|cell| self.point(cell)).collect()
    }

    /// The cell nearest to a point of the region, both in natural coordinates.
    pub(crate) fn nearest(&self, point: &[f64]) -> Result<Cell> {
        Ok(self.grid.nearest(point)?)
    }

    /// The cell of these levels, one for each parameter, from 0.
    pub(crate) fn of_levels(&self, levels: &[usize]) -> Result<Cell> {
        let digits: Vec<u64> = levels.iter().map(|level| *level as u64).collect();
        Ok(self.grid.of_digits(&digits)?)
    }

    /// A point with its units.
    pub(crate) fn words(&self, point: &[f64]) -> String {
        point_words(&self.variables, point).join(", ")
    }

    /// The levels of a parameter, rising.
    pub(crate) fn levels(&self, parameter: usize) -> Result<Vec<f64>> {
        let parameter = &self.region().parameters()[parameter];
        let design_space::Levels::Count(count) = parameter.levels() else { return Ok(Vec::new()) };
        Ok((0..count).map(|index| parameter.level(index)).collect::<std::result::Result<_, _>>()?)
    }
}

#[cfg(test)]
impl Space {
    /// Center of mass and pitch set point within these bounds.
    pub(crate) fn of_two(center_of_mass: [f64; 2], pitch_set_point: [f64; 2], levels: u32) -> Self {
        let entries = ParameterEntry::two(center_of_mass, pitch_set_point);
        Self::of(&entries, &entries.each_ref().map(|entry| entry.name.clone()), levels).expect("a space")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_and_points_belong_to_each_other() {
        let space = Space::of_two([45.65, 51.25], [0.0, 15.0], 7);
        assert_eq!(space.n_cells(), 49, "seven levels of two parameters");
        for cell in space.cells() {
            let point = space.point(cell).expect("a cell");
            assert_eq!(space.grid.nearest(&point).expect("a point of the grid"), cell, "cell {cell} at {point:?}");
        }
        // The last parameter runs fastest.
        let second = space.of_levels(&[0, 1]).expect("levels of the space");
        assert_eq!(second, Cell::new(1));
        assert_eq!(space.point(second).expect("the second cell"), [45.65, 2.5]);
    }

    #[test]
    fn an_unknown_parameter_is_named() {
        let entries = ParameterEntry::two([45.65, 51.25], [0.0, 15.0]);
        let error = Space::of(&entries, &["vertical_area".to_owned()], 7).expect_err("not in the list");
        assert!(error.to_string().contains("`vertical_area` is no [[parameter]]"), "{error:#}");
    }
}
