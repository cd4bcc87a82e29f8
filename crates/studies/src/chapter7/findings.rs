//! What a run of Chapter 7 found.

use infuse::global;

use super::campaigns::Runs;
use super::file::{Case, Setup};
use super::flights::BeforeAfter;
use super::optima::Optimum;
use super::pooled::Pooled;
use super::wrong::Choice;
use crate::gridded::FlownGrid;

/// Everything that was found in one of the two studies.
#[derive(Debug)]
pub(crate) struct Found {
    /// Costs over the grid that is flown in whole.
    pub(crate) model: FlownGrid,
    pub(crate) truth: FlownGrid,
    /// The optimum of the numerical model: row 0.
    pub(crate) numerical: Optimum,
    /// What the numerical optimum truly costs.
    pub(crate) numerical_true_cost: f64,
    /// The best design of the stand-in, which no engineer could compute.
    pub(crate) best: Optimum,
    /// In the order of the file's variants.
    pub(crate) runs: Vec<Runs>,
    pub(crate) choices: Vec<Choice>,
    pub(crate) flights: BeforeAfter,
    pub(crate) pooled: Pooled,
}

impl Found {
    /// The runs of the first variant.
    pub(crate) fn main(&self) -> &Runs {
        &self.runs[0]
    }
}

/// Everything that a run found.
#[derive(Debug)]
pub(crate) struct Findings {
    pub(crate) setup: Setup,
    /// In the order of the cases.
    pub(crate) found: Vec<Found>,
    pub(crate) seconds: f64,
}

impl Findings {
    /// The largest error of an experiment in a study, in s.
    pub(crate) fn noise_s(&self, found: &Found) -> f64 {
        self.setup.file.noise.share * found.truth.range()
    }

    pub(crate) fn cases(&self) -> impl Iterator<Item = (&Case, &Found)> {
        self.setup.cases.iter().zip(&self.found)
    }
}

/// What is left of the space after an iteration from 1, and before it.
pub(crate) fn shares(campaign: &global::Loop, iteration: usize) -> Option<f64> {
    Some(100.0 * campaign.retained_at(iteration)?.share())
}
