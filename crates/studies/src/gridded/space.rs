//! A design space of levels, as a study file has it.

use anyhow::{Context as _, Result, ensure};
use doe::{Parameter, Region};
use serde::Deserialize;

use crate::study::Variable;

/// A parameter as written.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ParameterEntry {
    pub(crate) name: String,
    pub(crate) unit: String,
    pub(crate) lower: f64,
    pub(crate) upper: f64,
}

/// Cells of one space: more flights would take days.
const MOST_CELLS: u64 = 1_000_000;

/// Some of the parameters with their levels.
#[derive(Clone, Debug)]
pub(crate) struct Space {
    region: Region,
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
            variables.push(Variable::named(&entry.name, &entry.unit)?);
            let parameter = Parameter::continuous(&entry.name, &entry.unit, entry.lower, entry.upper)?;
            parameters.push(parameter.with_levels(levels).with_context(|| format!("levels = {levels}"))?);
        }
        let region = Region::new(parameters)?;
        let n_cells = design_space::Grid::of(&region)?.n_cells();
        ensure!(
            n_cells <= MOST_CELLS,
            "levels = {levels}: {n_cells} cells, and each is flown: at most {MOST_CELLS} are allowed"
        );
        Ok(Self { region, variables, n_cells: usize::try_from(n_cells)? })
    }

    pub(crate) fn region(&self) -> &Region {
        &self.region
    }

    pub(crate) fn n_cells(&self) -> usize {
        self.n_cells
    }

    /// The natural coordinates of a cell, counted as the loop counts them.
    pub(crate) fn point(&self, cell: usize) -> Result<Vec<f64>> {
        Ok(design_space::Grid::of(&self.region)?.point(design_space::Cell::new(cell as u64))?)
    }

    /// The cell of a point that lies on the levels.
    pub(crate) fn cell(&self, point: &[f64]) -> Result<usize> {
        let mut cell = 0;
        for (parameter, x) in self.region.parameters().iter().zip(point) {
            let count = match parameter.levels() {
                doe::Levels::Count(count) => count as usize,
                doe::Levels::Continuous => 1,
            };
            cell = cell * count + parameter.nearest_level(*x)? as usize;
        }
        Ok(cell)
    }

    /// The levels of a parameter, rising.
    pub(crate) fn levels(&self, parameter: usize) -> Result<Vec<f64>> {
        let parameter = &self.region.parameters()[parameter];
        let doe::Levels::Count(count) = parameter.levels() else { return Ok(Vec::new()) };
        Ok((0..count).map(|index| parameter.level(index)).collect::<std::result::Result<_, _>>()?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entries() -> Vec<ParameterEntry> {
        let entry = |name: &str, unit: &str, lower, upper| ParameterEntry {
            name: name.to_owned(),
            unit: unit.to_owned(),
            lower,
            upper,
        };
        vec![entry("center_of_mass", "% chord", 45.65, 51.25), entry("pitch_set_point", "deg", 0.0, 15.0)]
    }

    #[test]
    fn cells_and_points_belong_to_each_other() {
        let names = ["center_of_mass".to_owned(), "pitch_set_point".to_owned()];
        let space = Space::of(&entries(), &names, 7).expect("a space");
        assert_eq!(space.n_cells(), 49, "seven levels of two parameters");
        for cell in 0..space.n_cells() {
            let point = space.point(cell).expect("a cell");
            assert_eq!(space.cell(&point).expect("a point of the grid"), cell, "cell {cell} at {point:?}");
        }
        // The last parameter runs fastest.
        assert_eq!(space.point(1).expect("the second cell"), [45.65, 2.5]);
    }

    #[test]
    fn an_unknown_parameter_is_named() {
        let error = Space::of(&entries(), &["vertical_area".to_owned()], 7).expect_err("not in the list");
        assert!(error.to_string().contains("`vertical_area` is no [[parameter]]"), "{error:#}");
    }
}
