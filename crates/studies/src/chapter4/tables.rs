//! The tables of Chapter 4 that hold its iterations and seeds.

use super::file::Setup;
use super::loops::Seeded;
use super::rows::{Row, Rows, fall_pct};
use super::seeds::{followed, over_seeds};
use page::Summary;
use page::{Column, Table};
use water_channel::TERM_NAMES;

/// How numbers stand in a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Digits {
    /// Few digits, for a person.
    Few,
    /// Every digit, for a program.
    All,
}

impl Digits {
    pub(crate) fn show(self, value: f64, few: usize) -> String {
        if !value.is_finite() {
            return if self == Self::Few { "–".to_owned() } else { String::new() };
        }
        match self {
            // Adding zero turns −0 into 0.
            Self::All => (value + 0.0).to_string(),
            // A rounded −0 is 0.
            Self::Few if value.abs() < 0.5 * 0.1_f64.powi(few as i32) => format!("{:.few$}", 0.0),
            Self::Few => format!("{value:.few$}"),
        }
    }
}

/// What a row owes to fitting: the first one was fitted, in design and in both costs.
pub(crate) fn standing(iteration: usize) -> &'static str {
    if iteration == 1 { "calibrated" } else { "predicted" }
}

/// Ours beside Table 3, "published / this run" in each cell: for a page and a terminal.
pub(crate) fn side_by_side(setup: &Setup, rows: &Rows) -> Table {
    let full = iteration_table(setup, rows, Digits::Few);
    let mut table = Table::new(vec![
        Column::new("Iteration", "1"),
        Column::new("Row is", ""),
        setup.variable(0).column(),
        setup.variable(1).column(),
        Column::new("Corrected numerical cost", "s"),
        Column::new("Experimental cost", "s"),
        Column::new("Change", "%"),
    ]);
    for row in full.rows {
        let pair = |k: usize| format!("{} / {}", row[k], row[k + 1]);
        table.push(vec![row[0].clone(), row[1].clone(), pair(2), pair(4), pair(6), pair(8), pair(10)]);
    }
    table
}

/// Ours beside Table 3, a column each.
pub(crate) fn iteration_table(setup: &Setup, rows: &Rows, digits: Digits) -> Table {
    let [x, y] = [0, 1].map(|k| setup.variable(k));
    let mut table = Table::new(vec![
        Column::new("Iteration", "1"),
        Column::new("Row is", ""),
        Column::new(&format!("{}, published", x.title()), x.unit()),
        Column::new("ours", x.unit()),
        Column::new(&format!("{}, published", y.title()), y.unit()),
        Column::new("ours", y.unit()),
        Column::new("Corrected numerical cost, published", "1"),
        Column::new("ours", "s"),
        Column::new("Experimental cost, published", "1"),
        Column::new("ours (stand-in)", "s"),
        Column::new("Change since iteration 1, published", "%"),
        Column::new("ours", "%"),
    ]);
    let published = &setup.file.published;
    for k in 0..rows.rows.len().max(published.len()) {
        let (theirs, ours) = (published.get(k), rows.rows.get(k));
        let their = |f: &dyn Fn(&super::file::Table3Row) -> f64, few| digits.show(theirs.map_or(f64::NAN, f), few);
        let our = |f: &dyn Fn(&Row) -> f64, few| digits.show(ours.map_or(f64::NAN, f), few);
        table.push(vec![
            (k + 1).to_string(),
            standing(k + 1).to_owned(),
            their(&|row| row.center_of_mass, 1),
            our(&|row| row.point[0], 2),
            their(&|row| row.pitch_set_point, 1),
            our(&|row| row.point[1], 2),
            their(&|row| row.corrected_cost, 2),
            our(&|row| row.corrected_cost, 3),
            their(&|row| row.experiment_cost, 2),
            our(&|row| row.cost(), 3),
            their(&|row| -fall_pct(published[0].experiment_cost, row.experiment_cost), 1),
            our(&|row| -fall_pct(rows.first().cost(), row.cost()), 1),
        ]);
    }
    table
}

/// Every variant, row by row.
pub(crate) fn variant_table(setup: &Setup, all: &[Rows], digits: Digits) -> Table {
    let mut table = Table::new(vec![
        Column::new("Loop", ""),
        Column::new("Iteration", "1"),
        Column::new("Row is", ""),
        setup.variable(0).column(),
        setup.variable(1).column(),
        Column::new("Model alone", "s"),
        Column::new("Model corrected", "s"),
        Column::new("Experiment", "s"),
        Column::new("Change", "%"),
        Column::new("Trials", "1"),
        Column::new("Model flights", "1"),
    ]);
    for rows in all {
        for row in &rows.rows {
            table.push(vec![
                rows.label.clone(),
                row.iteration.to_string(),
                standing(row.iteration).to_owned(),
                digits.show(row.point[0], 2),
                digits.show(row.point[1], 2),
                digits.show(row.model_cost, 3),
                digits.show(row.corrected_cost, 3),
                digits.show(row.cost(), 3),
                digits.show(-fall_pct(rows.first().cost(), row.cost()), 1),
                row.n_experiments.to_string(),
                row.n_simulations.to_string(),
            ]);
        }
    }
    table
}

/// What each design of the printed loop costs in the stand-in, term by term.
pub(crate) fn cost_table(rows: &Rows, digits: Digits) -> Table {
    let mut columns = vec![Column::new("Iteration", "1")];
    columns.extend(TERM_NAMES.iter().map(|name| Column::new(name, "s")));
    columns.push(Column::new("sum J", "s"));
    let mut table = Table::new(columns);
    for row in &rows.rows {
        let mut cells = vec![row.iteration.to_string()];
        cells.extend(row.logged.cost.terms.iter().chain([&row.cost()]).map(|term| digits.show(*term, 3)));
        table.push(cells);
    }
    table
}

/// How each design of the printed loop flies in the stand-in: footprint and margins.
pub(crate) fn flight_table(rows: &Rows, digits: Digits) -> Table {
    let mut table = Table::new(vec![
        Column::new("Iteration", "1"),
        Column::new("Footprint, mean", "cm²"),
        Column::new("at trim", "cm²"),
        Column::new("mean, full scale", "m²"),
        Column::new("Peak heading", "deg"),
        Column::new("Largest zenith angle", "deg"),
        Column::new("Smallest tension", "N"),
        Column::new("in line", ""),
        Column::new("Yaw mode, damping ratio", "1"),
        Column::new("frequency", "rad/s"),
    ]);
    for row in &rows.rows {
        let extremes = &row.logged.flight.extremes;
        let mean = row.mean_footprint_m2();
        table.push(vec![
            row.iteration.to_string(),
            digits.show(mean * 1e4, 1),
            digits.show(row.logged.flight.trim_footprint_m2() * 1e4, 1),
            // Areas grow with the square of the scale, 1/100.
            digits.show(mean * 1e4, 1),
            digits.show(extremes.peak_heading_rad.to_degrees(), 1),
            digits.show(extremes.largest_zenith_rad.to_degrees(), 1),
            digits.show(extremes.smallest_tension_n, 3),
            extremes.smallest_tension_line.to_owned(),
            row.yaw_mode.map_or("–".to_owned(), |mode| digits.show(mode.damping_ratio, 3)),
            row.yaw_mode.map_or("–".to_owned(), |mode| digits.show(mode.frequency_rad_s, 2)),
        ]);
    }
    table
}

/// Median and spread over the seeds, in one cell each.
pub(crate) fn seed_table(setup: &Setup, all: &[Seeded]) -> Table {
    let mut columns = vec![Column::new("Loop", ""), Column::new("Iteration", "1"), Column::new("Row is", "")];
    columns.extend(followed(setup).map(|followed| followed.column));
    let mut table = Table::new(columns);
    for (start, summaries) in seed_summaries(setup, all) {
        let cells = summaries.iter().map(|s| {
            let [median, least, most] = [s.median, s.minimum, s.maximum].map(|value| Digits::Few.show(value, 2));
            if least == most { median } else { format!("{median} ({least} … {most})") }
        });
        table.push(start.into_iter().chain(cells).collect());
    }
    table
}

/// The same as data: a column for each statistic.
pub(crate) fn seed_data(setup: &Setup, all: &[Seeded]) -> Table {
    let mut columns = vec![Column::new("Loop", ""), Column::new("Iteration", "1"), Column::new("Row is", "")];
    for Column { name, unit, .. } in followed(setup).map(|followed| followed.column) {
        let statistics = ["minimum", "lower quartile", "median", "upper quartile", "maximum"];
        columns.extend(statistics.map(|what| Column::new(&format!("{name}, {what}"), &unit)));
    }
    let mut table = Table::new(columns);
    for (start, summaries) in seed_summaries(setup, all) {
        let numbers =
            summaries.iter().flat_map(|s| [s.minimum, s.lower_quartile, s.median, s.upper_quartile, s.maximum]);
        let cells = numbers.map(|value| Digits::All.show(value, 0));
        table.push(start.into_iter().chain(cells).collect());
    }
    table
}

/// Loop, iteration and standing, and the summary of each reading over the seeds.
pub(crate) fn seed_summaries(setup: &Setup, all: &[Seeded]) -> Vec<([String; 3], Vec<Summary>)> {
    let (followed, mut rows) = (followed(setup), Vec::new());
    for seeded in all {
        let readings = followed.each_ref().map(|followed| over_seeds(setup, seeded, followed));
        for k in 0..readings[0].len() {
            let start = [seeded.label.clone(), (k + 1).to_string(), standing(k + 1).to_owned()];
            rows.push((start, readings.iter().filter_map(|reading| Summary::of(&reading[k])).collect()));
        }
    }
    rows
}
