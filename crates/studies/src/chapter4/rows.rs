//! The rows of the study: each reported design flown in full, and the tables made of them.

use super::file::Setup;
use super::loops::{Campaign, Seeded};
use crate::bat::STAND_IN;
use anyhow::{Context as _, Result};
use infuse::gradient;
use water_channel::{CostBreakdown, Flight, FlightLog, LogRow, closed_loop_modes, footprint_m2};

/// Samples per row of a flight log: 0.1 s.
pub(crate) const LOG_EVERY: usize = 4;

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
pub(crate) const LATERAL: [&str; 4] = ["azimuth", "twist", "azimuth_rate", "twist_rate"];

impl YawMode {
    /// The least damped oscillation in which the lateral states have more than half of the shares.
    pub(crate) fn of(setup: &Setup, point: &[f64]) -> Result<Option<Self>> {
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
    pub(crate) fn fly(setup: &Setup, report: &gradient::Report) -> Result<Self> {
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
