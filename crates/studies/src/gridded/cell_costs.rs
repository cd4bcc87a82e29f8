//! Where a campaign finds the cost of a cell: a grid that is flown in whole, or flights when a cell is asked for.

use std::fmt::Debug;

use bat_dynamics::Fidelity;
use design_space::Cell;

use super::grid::FlownGrid;
use super::space::Space;
use crate::bat::Bat;
use crate::costs::Cost;

/// The costs of one physics over the cells of a space.
pub(crate) trait CellCosts: Debug + Sync {
    fn cost(&self, cell: Cell) -> Cost;

    /// The costs of several cells, in their order.
    fn costs(&self, cells: &[Cell]) -> Vec<Cost> {
        cells.iter().map(|cell| self.cost(*cell)).collect()
    }

    /// What the noise of an experiment is a part of.
    fn range(&self) -> f64;
}

impl CellCosts for FlownGrid {
    fn cost(&self, cell: Cell) -> Cost {
        Self::cost(self, cell).clone()
    }

    fn range(&self) -> f64 {
        Self::range(self)
    }
}

/// Cells of a space that is too large to be flown, each flown when it is first asked for.
#[derive(Debug)]
pub(crate) struct OnDemand<'a> {
    pub(crate) bat: &'a Bat,
    pub(crate) space: &'a Space,
    pub(crate) fidelity: Fidelity,
    /// What the noise of an experiment is a part of, of another grid.
    pub(crate) range: f64,
}

impl OnDemand<'_> {
    fn point(&self, cell: Cell) -> Result<Vec<f64>, String> {
        self.space.point(cell).map_err(|error| format!("{error:#}"))
    }
}

impl CellCosts for OnDemand<'_> {
    fn cost(&self, cell: Cell) -> Cost {
        self.bat.cost(&self.point(cell)?, self.fidelity)
    }

    /// Those that are not known fly side by side.
    fn costs(&self, cells: &[Cell]) -> Vec<Cost> {
        match cells.iter().map(|cell| self.point(*cell)).collect::<Result<Vec<_>, _>>() {
            Ok(points) => self.bat.costs(&points, self.fidelity, |_| {}),
            Err(_) => cells.iter().map(|cell| self.cost(*cell)).collect(),
        }
    }

    fn range(&self) -> f64 {
        self.range
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::bat::MODEL;
    use crate::study_file::{FilesEntry, NumericsEntry};

    #[test]
    fn a_cell_on_demand_costs_what_it_does_in_a_flown_grid_and_is_remembered() {
        let space = Space::of_two([46.0, 50.0], [5.0, 10.0], 2);
        let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/bat");
        let files = FilesEntry::of_chapter7();
        let folder = tempfile::tempdir().expect("a writable directory");
        let bat = || {
            let bat =
                Bat::read(&fixtures, &files, space.variables.clone(), &NumericsEntry::COARSE).expect("the case study");
            bat.keep_in(folder.path(), space.region(), &[MODEL]).expect("a writable store");
            bat
        };
        let first = bat();
        let demand = OnDemand { bat: &first, space: &space, fidelity: MODEL, range: 1.0 };
        let some = [3, 1, 3].map(Cell::new);
        assert_eq!(demand.costs(&some), some.map(|cell| demand.cost(cell)));

        let second = bat();
        assert_eq!(second.n_known(MODEL), 2, "two by demand, in the file");
        let grid = FlownGrid::fly(&second, &space, MODEL, |_| {}).expect("a grid");
        let third = bat();
        assert_eq!(third.n_known(MODEL), 4, "two by demand, two by the grid, in one file");
        let again = OnDemand { bat: &third, space: &space, fidelity: MODEL, range: 1.0 };
        for cell in space.cells() {
            assert_eq!(again.cost(cell), *grid.cost(cell), "cell {cell}");
        }
        let [last, ..] = some;
        let fresh = third.flown_costs(&[space.point(last).expect("a cell")], MODEL, |_| {});
        assert_eq!(again.cost(last).ok(), fresh[0].clone().ok(), "what was written is what flies");
    }

    #[test]
    fn flights_kept_with_the_sources_are_taken_over_if_a_sample_costs_the_same() {
        let space = Space::of_two([46.0, 50.0], [5.0, 10.0], 2);
        let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/bat");
        let files = FilesEntry::of_chapter7();
        let folder = tempfile::tempdir().expect("a writable directory");
        let bat =
            || Bat::read(&fixtures, &files, space.variables.clone(), &NumericsEntry::COARSE).expect("the case study");
        let first = bat();
        first.keep_in(folder.path(), space.region(), &[MODEL]).expect("a writable store");
        FlownGrid::fly(&first, &space, MODEL, |_| {}).expect("a grid");

        let second = bat();
        second.take_over(folder.path(), space.region(), &[MODEL]).expect("what this program flies");
        assert_eq!(second.n_known(MODEL), 4);

        let [file] = std::fs::read_dir(folder.path())
            .expect("the folder")
            .flatten()
            .collect::<Vec<_>>()
            .try_into()
            .expect("one");
        let text = std::fs::read_to_string(file.path()).expect("just written");
        let (point, costs) = text.split_once('\t').expect("four lines");
        std::fs::write(file.path(), format!("{point}\t9{costs}")).expect("a writable file");
        let error = bat().take_over(folder.path(), space.region(), &[MODEL]).expect_err("another cost");
        assert!(error.to_string().contains("reproduce-all --keep"), "{error}");
        bat().take_over(&folder.path().join("none"), space.region(), &[MODEL]).expect("nothing is kept");
    }
}
