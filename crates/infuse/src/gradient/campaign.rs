//! A campaign of the gradient loop: its state, and what can be read from it.

use serde::{Deserialize, Serialize};

use crate::correction::Local;
use crate::gradient::numerical::NumericalOptimum;
use crate::gradient::report::{Report, StopReason};
use crate::gradient::settings::Settings;
use crate::gradient::trial::{Trial, Trials};
use crate::{CodesignProblem, Error};

/// The numerical half of an iteration and the trials that wait for a person.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct OpenIteration {
    pub(crate) numerical: NumericalOptimum,
    pub(crate) trials: Trials,
}

/// Experimentally infused optimization with local gradients: the loop of Chapter 3, as ask and tell.
///
/// The value is the whole state. It serializes with serde; a saved state resumes bit for bit,
/// trials outstanding included, provided the format keeps doubles exactly (`serde_json` does so only
/// with its feature `float_roundtrip`). The simulation is not part of it: give the same one to
/// every [`ask`](Self::ask).
#[derive(Debug, Clone, PartialEq)]
pub struct Loop {
    pub(super) problem: CodesignProblem,
    pub(super) settings: Settings,
    pub(super) history: Vec<Report>,
    pub(super) open: Option<OpenIteration>,
}

impl Loop {
    /// A campaign that has not begun.
    ///
    /// # Errors
    ///
    /// Those of [`Settings::validate`].
    pub fn new(problem: CodesignProblem, settings: Settings) -> Result<Self, Error> {
        settings.validate(&problem)?;
        Ok(Self { problem, settings, history: Vec::new(), open: None })
    }

    /// The problem the campaign is about.
    #[must_use]
    pub fn problem(&self) -> &CodesignProblem {
        &self.problem
    }

    /// The settings it was begun with.
    #[must_use]
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The closed iterations, first to last.
    #[must_use]
    pub fn reports(&self) -> &[Report] {
        &self.history
    }

    /// The correction learned so far.
    #[must_use]
    pub fn correction(&self) -> Local {
        let last = self.history.last();
        last.map_or_else(|| Local::zero(self.problem.n_parameters()), |report| report.correction.clone())
    }

    /// The optimum of the open iteration, while trials are outstanding.
    #[must_use]
    pub fn current_optimum(&self) -> Option<&NumericalOptimum> {
        self.open.as_ref().map(|open| &open.numerical)
    }

    /// The trials handed out whose outcomes are still waited for.
    #[must_use]
    pub fn outstanding(&self) -> Vec<Trial> {
        self.open.iter().flat_map(|open| open.trials.outstanding()).cloned().collect()
    }

    /// Why the campaign has ended; nothing while it goes on.
    #[must_use]
    pub fn stop(&self) -> Option<StopReason> {
        let last = self.history.last()?;
        if self.open.is_some() {
            None
        } else if !last.is_corrected.contains(&true) {
            Some(StopReason::NoInformation)
        } else if self.has_settled() {
            Some(StopReason::Converged)
        } else if self.history.len() >= self.settings.max_iterations {
            Some(StopReason::IterationLimit)
        } else {
            None
        }
    }

    /// Whether the campaign has ended because the optimum came to rest.
    #[must_use]
    pub fn is_converged(&self) -> bool {
        self.stop() == Some(StopReason::Converged)
    }

    /// Whether the last optimum lies where the one before did, and for a reason.
    fn has_settled(&self) -> bool {
        let [.., before, last] = self.history.as_slice() else {
            return false;
        };
        let parameters = self.problem.region().parameters().iter();
        let tolerances = self.settings.tolerances();
        let mut indexed = parameters.zip(tolerances).enumerate();
        indexed.all(|(index, (parameter, tolerance))| {
            let here = last.numerical.point[index];
            let gradient = last.experiment_gradient[index];
            let is_at_rest = if here <= parameter.lower() {
                gradient.is_some_and(|slope| slope >= 0.0)
            } else if here >= parameter.upper() {
                gradient.is_some_and(|slope| slope <= 0.0)
            } else {
                true
            };
            let step = (here - before.numerical.point[index]).abs();
            step <= tolerance && before.is_corrected[index] && is_at_rest
        })
    }

    /// Number of the iteration that is open or comes next, from 1.
    pub(super) fn iteration(&self) -> usize {
        self.history.len() + 1
    }

    /// How many trials the closed iterations handed out.
    pub(super) fn n_asked(&self) -> u64 {
        let counts = self.history.iter().map(|report| report.trials.len() as u64);
        counts.sum()
    }
}
