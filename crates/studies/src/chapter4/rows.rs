//! The rows of the study: each reported design flown in full.

use super::file::Setup;
use super::loops::Campaign;
use crate::bat::STAND_IN;
use crate::logged::{Logged, Reading};
use anyhow::{Context as _, Result};
use infuse::gradient;
use water_channel::{LogRow, closed_loop_modes};

/// One iteration of one variant, its design flown in the stand-in.
#[derive(Clone, Debug)]
pub(crate) struct Row {
    pub(crate) iteration: usize,
    pub(crate) point: [f64; 2],
    pub(crate) model_cost: f64,
    pub(crate) corrected_cost: f64,
    pub(crate) logged: Logged,
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
        let logged = setup.bat.logged(&point, STAND_IN);
        let logged = logged.with_context(|| format!("the design of iteration {}", report.iteration))?;
        Ok(Self {
            iteration: report.iteration,
            point,
            model_cost: numerical.model_cost,
            corrected_cost: numerical.corrected_cost,
            logged,
            n_experiments: report.trials.len(),
            n_simulations: numerical.n_simulations,
            yaw_mode: YawMode::of(setup, &point)?,
        })
    }

    /// What it costs in the stand-in.
    pub(crate) fn cost(&self) -> f64 {
        self.logged.cost.total
    }

    /// Square of an angle of the log in deg², sample by sample.
    pub(crate) fn squared_deg2(&self, angle: Reading) -> Vec<f64> {
        self.logged.values(|row| angle(row).to_degrees().powi(2))
    }

    /// Its mean over the test.
    pub(crate) fn mean_squared_deg2(&self, angle: Reading) -> f64 {
        self.logged.mean(|row| angle(row).to_degrees().powi(2))
    }

    /// Mean over the test of the ground that the tether sweeps, `pi L_t² sin² Phi`, in m².
    pub(crate) fn mean_footprint_m2(&self) -> f64 {
        self.logged.mean(LogRow::footprint_m2)
    }
}

/// The errors of Figures 16 to 18 in rad, with the number of the figure.
pub(crate) const ERRORS: [(&str, u32, Reading); 3] = [
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
        fall_pct(self.first().cost(), self.last().cost())
    }

    pub(crate) fn n_experiments(&self) -> usize {
        self.rows.iter().map(|row| row.n_experiments).sum()
    }
}

/// How much lower `last` is than `first`, in per cent of `first`.
pub(crate) fn fall_pct(first: f64, last: f64) -> f64 {
    100.0 * (1.0 - last / first)
}
