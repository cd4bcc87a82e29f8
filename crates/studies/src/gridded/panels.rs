//! What figures show of an iteration over two parameters.

use anyhow::Result;
use design_space::Cell;
use infuse::global::{self, RetainedSet, TrialUse};

use super::space::Space;
use page::{CellPanel, Points};

/// The cells of a space of two parameters that are left, with a value each.
pub(crate) fn cell_panel(
    space: &Space,
    retained: &RetainedSet,
    value: impl Fn(Cell) -> Result<f64>,
) -> Result<CellPanel> {
    let (x, y) = (space.levels(0)?, space.levels(1)?);
    let at = |i: usize, j: usize| -> Result<f64> {
        let cell = space.of_levels(&[i, j])?;
        if retained.contains(cell) { value(cell) } else { Ok(f64::NAN) }
    };
    let row = |j: usize| (0..x.len()).map(|i| at(i, j)).collect::<Result<Vec<_>>>();
    let z = (0..y.len()).map(row).collect::<Result<_>>()?;
    Ok(CellPanel { title: String::new(), x, y, z, points: Vec::new(), minimum: None })
}

/// The runs of an iteration, by what they are for.
pub(crate) fn design_points(report: &global::Report) -> Vec<Points> {
    let experiments = |used_for: TrialUse| {
        let trials = report.trials.iter().filter(move |record| record.trial.used_for == used_for);
        trials.map(|record| (record.trial.point[0], record.trial.point[1])).collect()
    };
    let of = |label: &str, points, fill, radius_px| Points { label: label.to_owned(), points, fill, radius_px };
    let simulations = report.simulations.iter().map(|run| (run.point[0], run.point[1])).collect();
    vec![
        // Often several runs share a cell: each is smaller than what it is drawn over, so that all are seen.
        of("training experiment", experiments(TrialUse::Training), "#e69f00", 7.0),
        of("validation experiment", experiments(TrialUse::Validation), "#ffffff", 4.4),
        of("simulation", simulations, "#000000", 1.8),
    ]
}
