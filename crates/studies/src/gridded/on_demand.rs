//! Costs of the cells of a space that is too large to be flown, each flown when it is first asked for.

use std::collections::HashMap;
use std::fs::File;
use std::io::Write as _;
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};

use anyhow::{Context as _, Result};
use bat_dynamics::Fidelity;

use super::flown::line;
use super::source::CellCosts;
use super::space::Space;
use crate::study::{Cost, Study};

/// What is known at the start, and where the rest is written.
#[derive(Debug)]
pub(super) struct Begun {
    pub(super) key: String,
    pub(super) range: f64,
    pub(super) known: HashMap<usize, Cost>,
    pub(super) file: File,
    pub(super) path: PathBuf,
}

/// Cells flown on demand, in one fidelity.
#[derive(Debug)]
pub(crate) struct OnDemand<'a> {
    study: &'a Study,
    space: &'a Space,
    fidelity: Fidelity,
    key: String,
    range: f64,
    path: PathBuf,
    state: Mutex<State>,
}

#[derive(Debug)]
struct State {
    known: HashMap<usize, Cost>,
    /// Lines that wait to be written.
    unwritten: String,
    file: File,
}

impl<'a> OnDemand<'a> {
    pub(super) fn new(study: &'a Study, space: &'a Space, fidelity: Fidelity, begun: Begun) -> Self {
        let Begun { key, range, known, file, path } = begun;
        let state = Mutex::new(State { known, unwritten: String::new(), file });
        Self { study, space, fidelity, key, range, path, state }
    }

    /// Held for look-ups and notes only, never while something flies.
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn point(&self, cell: usize) -> std::result::Result<Vec<f64>, String> {
        self.space.point(cell).map_err(|error| format!("{error:#}"))
    }

    fn note(&self, cell: usize, cost: &Cost) {
        let mut state = self.state();
        if state.known.insert(cell, cost.clone()).is_none() {
            state.unwritten.push_str(&line(cell, cost));
        }
    }
}

impl CellCosts for OnDemand<'_> {
    fn key(&self) -> &str {
        &self.key
    }

    fn cost(&self, cell: usize) -> Cost {
        if let Some(known) = self.state().known.get(&cell) {
            return known.clone();
        }
        let cost = self.study.cost(&self.point(cell)?, self.fidelity);
        self.note(cell, &cost);
        cost
    }

    /// Those that are not known fly side by side.
    fn costs(&self, cells: &[usize]) -> Vec<Cost> {
        let missing: Vec<usize> = {
            let state = self.state();
            cells.iter().copied().filter(|cell| !state.known.contains_key(cell)).collect()
        };
        let points: Vec<Vec<f64>> = missing.iter().filter_map(|cell| self.point(*cell).ok()).collect();
        if points.len() == missing.len() {
            for (cell, cost) in missing.iter().zip(self.study.costs(&points, self.fidelity, |_| {})) {
                self.note(*cell, &cost);
            }
        }
        cells.iter().map(|cell| self.cost(*cell)).collect()
    }

    fn range(&self) -> f64 {
        self.range
    }

    fn keep(&self) -> Result<()> {
        let mut state = self.state();
        let lines = std::mem::take(&mut state.unwritten);
        state.file.write_all(lines.as_bytes()).with_context(|| self.path.display().to_string())
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::{FlightStore, ParameterEntry};
    use super::*;
    use crate::study::MODEL;

    #[test]
    fn a_cell_on_demand_costs_what_it_does_in_a_flown_grid_and_is_remembered() {
        let entry = |name: &str, unit: &str, lower, upper| ParameterEntry {
            name: name.to_owned(),
            unit: unit.to_owned(),
            lower,
            upper,
        };
        let entries = [entry("center_of_mass", "% chord", 46.0, 50.0), entry("pitch_set_point", "deg", 5.0, 10.0)];
        let names = entries.each_ref().map(|entry| entry.name.clone());
        let space = Space::of(&entries, &names, 2).expect("a space");
        let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/bat");
        let files = ["rig.toml", "test-profile.toml", "cost-chapter7.toml"];
        let study = Study::read(&fixtures, files, space.variables.clone(), [1, 1]).expect("a study");
        let directory = std::env::temp_dir().join(format!("xtask-{}-on-demand", std::process::id()));
        let store = FlightStore::new(directory.clone());
        {
            let demand = store.on_demand(&study, &space, MODEL, 1.0).expect("a store");
            assert_eq!(demand.costs(&[3, 1, 3]), [3, 1, 3].map(|cell| demand.cost(cell)));
            demand.keep().expect("a writable store");
        }
        let grid = store.fly(&study, &space, MODEL, |_| {}).expect("a grid");
        let again = store.on_demand(&study, &space, MODEL, 1.0).expect("a store");
        assert_eq!(again.state().known.len(), 4, "two by demand, two by the grid, in one file");
        for cell in 0..4 {
            assert_eq!(again.cost(cell), *grid.cost(cell), "cell {cell}");
        }
        let fresh = study.flown_costs(&[space.point(3).expect("a cell")], MODEL, |_| {});
        assert_eq!(again.cost(3), fresh[0], "what was written is what flies");
        std::fs::remove_dir_all(&directory).expect("just written");
    }
}
