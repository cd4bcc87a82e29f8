//! The rows of the study: each reported design flown in full, and the tables made of them.

use anyhow::{Context as _, Result};
use infuse::gradient;
use water_channel::{CostBreakdown, Flight, FlightLog, LogRow, TERM_NAMES, closed_loop_modes, footprint_m2};

use super::file::Setup;
use super::loops::{Campaign, Seeded};
use crate::bat::STAND_IN;
use page::Summary;
use page::{Column, Table};

/// Samples per row of a flight log: 0.1 s.
const LOG_EVERY: usize = 4;

/// One iteration of one variant, its design flown in the stand-in.
#[derive(Clone, Debug)]
pub(crate) struct Row {
    pub(crate) iteration: usize,
    pub(crate) point: [f64; 2],
    pub(crate) model_cost: f64,
    pub(crate) corrected_cost: f64,
    pub(crate) experiment: CostBreakdown,
    pub(crate) flight: Flight,
    pub(crate) log: FlightLog,
    pub(crate) n_experiments: usize,
    pub(crate) n_simulations: usize,
    pub(crate) yaw_mode: Option<YawMode>,
}

/// The slow swing of azimuth and twist, which is what a lateral perturbation excites.
#[derive(Clone, Copy, Debug)]
pub(crate) struct YawMode {
    pub(crate) damping_ratio: f64,
    pub(crate) frequency_rad_s: f64,
}

/// States that lead in the yaw mode.
const LATERAL: [&str; 4] = ["azimuth", "twist", "azimuth_rate", "twist_rate"];

impl YawMode {
    /// The least damped oscillation in which the lateral states have more than half of the shares.
    fn of(setup: &Setup, point: &[f64]) -> Result<Option<Self>> {
        let flow = setup.bat.profile().flow().at(0.0);
        let closed = closed_loop_modes(&setup.bat.request(point, STAND_IN), &flow)?;
        let lateral = closed.modes.iter().filter(|m| m.share_of(&LATERAL).is_some_and(|share| share > 0.5));
        let oscillating = lateral.map(|m| &m.mode).filter(|mode| mode.eigenvalue.im > 0.0);
        let least = oscillating.min_by(|a, b| a.damping_ratio().total_cmp(&b.damping_ratio()));
        Ok(least
            .map(|mode| Self { damping_ratio: mode.damping_ratio(), frequency_rad_s: mode.natural_frequency_rad_s() }))
    }
}

impl Row {
    fn fly(setup: &Setup, report: &gradient::Report) -> Result<Self> {
        let numerical = &report.numerical;
        let point = [numerical.point[0], numerical.point[1]];
        let (flight, log) = setup
            .bat
            .logged(&point, STAND_IN, LOG_EVERY)
            .with_context(|| format!("the design of iteration {}", report.iteration))?;
        Ok(Self {
            iteration: report.iteration,
            point,
            model_cost: numerical.model_cost,
            corrected_cost: numerical.corrected_cost,
            experiment: setup.bat.breakdown(&point, &flight),
            flight,
            log,
            n_experiments: report.trials.len(),
            n_simulations: numerical.n_simulations,
            yaw_mode: YawMode::of(setup, &point)?,
        })
    }

    /// Square of an angle of the log in deg², sample by sample.
    pub(crate) fn squared_deg2(&self, angle: Angle) -> Vec<f64> {
        self.log.rows.iter().map(|row| angle(row).to_degrees().powi(2)).collect()
    }

    /// Its mean over the test.
    pub(crate) fn mean_squared_deg2(&self, angle: Angle) -> f64 {
        self.squared_deg2(angle).iter().sum::<f64>() / self.log.rows.len() as f64
    }

    /// Mean over the test of the ground that the tether sweeps, `pi L_t² sin² Phi`, in m².
    pub(crate) fn mean_footprint_m2(&self) -> f64 {
        let areas = self
            .log
            .rows
            .iter()
            .map(|row| footprint_m2((row.state[6] + row.state[7] + row.state[8]) / 3.0, row.state[0]));
        areas.sum::<f64>() / self.log.rows.len() as f64
    }
}

/// An angle of a flight log, in rad.
pub(crate) type Angle = fn(&LogRow) -> f64;

/// The errors of Figures 16 to 18, with the number of the figure.
pub(crate) const ERRORS: [(&str, u32, Angle); 3] = [
    ("yaw", 16, |row| row.heading_rad),
    ("roll", 17, |row| row.roll_error_rad),
    ("pitch", 18, |row| row.pitch_error_rad),
];

/// The rows of one variant.
#[derive(Clone, Debug)]
pub(crate) struct Rows {
    pub(crate) label: String,
    pub(crate) rows: Vec<Row>,
    pub(crate) campaign: Campaign,
}

impl Rows {
    pub(crate) fn fly(setup: &Setup, campaigns: Vec<Campaign>) -> Result<Vec<Self>> {
        setup
            .file
            .variant
            .iter()
            .zip(campaigns)
            .map(|(variant, campaign)| {
                let rows = campaign.reports.iter().map(|report| Row::fly(setup, report)).collect::<Result<_>>()?;
                Ok(Self { label: variant.label.clone(), rows, campaign })
            })
            .collect()
    }

    pub(crate) fn first(&self) -> &Row {
        &self.rows[0]
    }

    pub(crate) fn last(&self) -> &Row {
        &self.rows[self.rows.len() - 1]
    }

    /// Fall of the experimental cost from the first to the last row, in per cent.
    pub(crate) fn fall_pct(&self) -> f64 {
        fall_pct(self.first().experiment.total, self.last().experiment.total)
    }

    pub(crate) fn n_experiments(&self) -> usize {
        self.rows.iter().map(|row| row.n_experiments).sum()
    }
}

/// How much lower `last` is than `first`, in per cent of `first`.
pub(crate) fn fall_pct(first: f64, last: f64) -> f64 {
    100.0 * (1.0 - last / first)
}

/// How numbers stand in a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Digits {
    /// Few digits, for a person.
    Few,
    /// Every digit, for a program.
    All,
}

impl Digits {
    fn show(self, value: f64, few: usize) -> String {
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
        Column::new("Center of mass", "% chord"),
        Column::new("Pitch set point", "deg"),
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
    let mut table = Table::new(vec![
        Column::new("Iteration", "1"),
        Column::new("Row is", ""),
        Column::new("Center of mass, published", "% chord"),
        Column::new("ours", "% chord"),
        Column::new("Pitch set point, published", "deg"),
        Column::new("ours", "deg"),
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
            our(&|row| row.experiment.total, 3),
            their(&|row| -fall_pct(published[0].experiment_cost, row.experiment_cost), 1),
            our(&|row| -fall_pct(rows.first().experiment.total, row.experiment.total), 1),
        ]);
    }
    table
}

/// Every variant, row by row.
pub(crate) fn variant_table(all: &[Rows], digits: Digits) -> Table {
    let mut table = Table::new(vec![
        Column::new("Loop", ""),
        Column::new("Iteration", "1"),
        Column::new("Row is", ""),
        Column::new("Center of mass", "% chord"),
        Column::new("Pitch set point", "deg"),
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
                digits.show(row.experiment.total, 3),
                digits.show(-fall_pct(rows.first().experiment.total, row.experiment.total), 1),
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
        cells.extend(row.experiment.terms.iter().chain([&row.experiment.total]).map(|term| digits.show(*term, 3)));
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
        let extremes = &row.flight.extremes;
        let mean = row.mean_footprint_m2();
        table.push(vec![
            row.iteration.to_string(),
            digits.show(mean * 1e4, 1),
            digits.show(row.flight.trim_footprint_m2() * 1e4, 1),
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

/// One quantity of a seeded campaign per iteration.
pub(crate) type Reading = fn(&Setup, &gradient::Report) -> f64;

/// What is followed over the noise seeds.
pub(crate) const READINGS: [(&str, &str, Reading); 4] = [
    ("Center of mass", "% chord", |_, report| report.numerical.point[0]),
    ("Pitch set point", "deg", |_, report| report.numerical.point[1]),
    ("Corrected numerical cost", "s", |_, report| report.numerical.corrected_cost),
    ("Experimental cost, noise-free", "s", |setup, report| {
        setup.bat.cost(&report.numerical.point, STAND_IN).unwrap_or(f64::NAN)
    }),
];

/// `values[iteration][seed]`.
pub(crate) fn over_seeds(setup: &Setup, seeded: &Seeded, reading: Reading) -> Vec<Vec<f64>> {
    let longest = seeded.campaigns.iter().map(|(_, campaign)| campaign.reports.len()).max().unwrap_or(0);
    (0..longest)
        .map(|k| {
            seeded.campaigns.iter().filter_map(|(_, c)| c.reports.get(k)).map(|report| reading(setup, report)).collect()
        })
        .collect()
}

/// Falls of the experimental cost, noise taken off, from the first to the last iteration, seed by seed, in per cent.
pub(crate) fn falls_pct(setup: &Setup, seeded: &Seeded) -> Vec<f64> {
    let cost = READINGS[3].2;
    seeded
        .campaigns
        .iter()
        .filter_map(|(_, campaign)| {
            let (first, last) = (campaign.reports.first()?, campaign.reports.last()?);
            Some(fall_pct(cost(setup, first), cost(setup, last)))
        })
        .collect()
}

/// Median and spread over the seeds, in one cell each.
pub(crate) fn seed_table(setup: &Setup, all: &[Seeded]) -> Table {
    let mut columns = vec![Column::new("Loop", ""), Column::new("Iteration", "1"), Column::new("Row is", "")];
    columns.extend(READINGS.iter().map(|(name, unit, _)| Column::new(name, unit)));
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
    for (name, unit, _) in READINGS {
        let statistics = ["minimum", "lower quartile", "median", "upper quartile", "maximum"];
        columns.extend(statistics.map(|what| Column::new(&format!("{name}, {what}"), unit)));
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
fn seed_summaries(setup: &Setup, all: &[Seeded]) -> Vec<([String; 3], Vec<Summary>)> {
    let mut rows = Vec::new();
    for seeded in all {
        let readings = READINGS.map(|(_, _, reading)| over_seeds(setup, seeded, reading));
        for k in 0..readings[0].len() {
            let start = [seeded.label.clone(), (k + 1).to_string(), standing(k + 1).to_owned()];
            rows.push((start, readings.iter().filter_map(|reading| Summary::of(&reading[k])).collect()));
        }
    }
    rows
}
