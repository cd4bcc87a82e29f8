//! The last closed batch, and the lines and planes through its best design.

use anyhow::Result;
use infuse::{
    Outcome,
    global::{self, BatchSurfaces, TracedSurface, TrialUse},
};

use page::Axis;

use crate::dissertation::campaign::Campaign;
use crate::problem::Response;

#[derive(Debug)]
pub(super) struct Last<'a> {
    pub(super) campaign: &'a Campaign,
    pub(super) report: &'a global::Report,
    pub(super) surfaces: &'a BatchSurfaces,
    /// What entered its surfaces or was compared with them, and what failed.
    pub(super) runs: Vec<Run>,
}

/// An experiment of the batch, or an earlier one that counted in it.
#[derive(Debug)]
pub(super) struct Run {
    /// As they were made, natural.
    pub(super) settings: Vec<f64>,
    /// None if it failed.
    pub(super) cost: Option<f64>,
    pub(super) origin: Origin,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Origin {
    Training,
    Validation,
    Imported,
}

impl<'a> Last<'a> {
    /// None before a batch is closed.
    pub(super) fn of(campaign: &'a Campaign) -> Result<Option<Self>> {
        let now = &campaign.now;
        let Some((report, surfaces)) = now.reports().last().zip(now.surfaces().last()) else {
            return Ok(None);
        };
        let mut runs: Vec<Run> = Vec::new();
        for record in &report.trials {
            let origin = match record.trial.used_for {
                TrialUse::Training => Origin::Training,
                TrialUse::Validation => Origin::Validation,
            };
            let cost = record.outcome.as_ref().and_then(Outcome::cost);
            runs.push(Run { settings: record.settings().to_vec(), cost, origin });
        }
        if let Some(retained) = now.retained_at(report.number) {
            for earlier in now.earlier().iter().filter(|earlier| earlier.since <= report.number) {
                let cell = now.grid().nearest_clamped(&earlier.point)?;
                if retained.contains(cell) {
                    let settings = earlier.point.clone();
                    runs.push(Run { settings, cost: Some(earlier.cost), origin: Origin::Imported });
                }
            }
        }
        Ok(Some(Self { campaign, report, surfaces, runs }))
    }

    pub(super) fn response(&self) -> &Response {
        &self.campaign.problem.response
    }

    pub(super) fn parameters(&self) -> &[design_space::Parameter] {
        self.campaign.problem.region.parameters()
    }

    /// An axis of the settings of a parameter.
    pub(super) fn axis(&self, parameter: usize) -> Axis {
        let parameter = &self.parameters()[parameter];
        Axis::new(parameter.name(), parameter.unit())
    }

    /// An axis of the response.
    pub(super) fn response_axis(&self) -> Axis {
        Axis::new(&self.response().name, &self.response().unit)
    }

    /// The best design with these parameters changed.
    pub(super) fn moved(&self, changes: &[(usize, f64)]) -> Vec<f64> {
        let mut point = self.report.screening.optimum.clone();
        for &(parameter, value) in changes {
            point[parameter] = value;
        }
        point
    }

    /// A surface at a natural point, as it would be measured.
    pub(super) fn value(&self, surface: &TracedSurface, point: &[f64]) -> Result<f64> {
        Ok(self.response().of_cost(surface.surface().predict(&self.campaign.problem.region.coded(point)?)))
    }
}
