//! The loop itself: optimize the corrected model, ask for experiments, correct, repeat.

use serde::{Deserialize, Serialize};

use crate::correction::Correction;
use crate::gradient::numerical::numerical_optimum;
use crate::gradient::state::State;
use crate::gradient::trial::sides;
use crate::gradient::{NumericalOptimum, Report, Settings, StopReason, Trial, TrialRecord, TrialRole};
use crate::{CodesignProblem, Error, Outcome, TrialId};

/// What there is to do next.
#[derive(Debug, Clone, PartialEq)]
pub enum Ask {
    /// Run these experiments, in any order, and tell the outcome of each.
    Trials(Vec<Trial>),
    /// Nothing: the campaign has ended.
    Stopped(StopReason),
}

/// The numerical half of an iteration and the trials that wait for a person.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct OpenIteration {
    pub(crate) numerical: NumericalOptimum,
    pub(crate) trials: Vec<TrialRecord>,
}

/// Experimentally infused optimization with local gradients: the loop of Chapter 3, as ask and tell.
///
/// The value is the whole state. It serializes with serde; a saved state resumes bit for bit,
/// trials outstanding included, provided the format keeps doubles exactly (`serde_json` does so only
/// with its feature `float_roundtrip`). The simulation is not part of it: give the same one to
/// every [`ask`](Self::ask).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "State", into = "State")]
pub struct Loop {
    pub(crate) problem: CodesignProblem,
    pub(crate) settings: Settings,
    pub(crate) history: Vec<Report>,
    pub(crate) open: Option<OpenIteration>,
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

    /// The experiments to run now.
    ///
    /// While trials are outstanding it returns those not yet told, and the simulation is not called.
    /// Otherwise it opens the next iteration: the simulation is optimized with the correction known so
    /// far, its gradient at the optimum is taken, and 2n + 1 trials are handed out in n parameters:
    /// the optimum and one step to each side in each parameter, fewer at a bound that must not be
    /// crossed.
    ///
    /// `simulation` maps a natural point to a cost or to the reason why there is none; failures are
    /// survived and reported.
    ///
    /// # Errors
    ///
    /// [`Error::EverySimulationFailed`], [`Error::OptimizerRefused`]; the state is then as before.
    pub fn ask(&mut self, simulation: &mut impl FnMut(&[f64]) -> Result<f64, String>) -> Result<Ask, Error> {
        if let Some(reason) = self.stop() {
            return Ok(Ask::Stopped(reason));
        }
        if self.open.is_none() {
            let last = self.history.last().map(|report| report.numerical.point.as_slice());
            let correction = self.correction();
            let numerical = numerical_optimum(&self.problem, &self.settings, last, &correction, simulation)?;
            let trials = self.design(&numerical.point);
            self.open = Some(OpenIteration { numerical, trials });
        }
        Ok(Ask::Trials(self.outstanding()))
    }

    /// The outcome of an outstanding trial, at the settings asked for.
    ///
    /// The last outcome of an iteration closes it: the correction is updated and the iteration
    /// appears in [`reports`](Self::reports). The order of telling does not matter.
    ///
    /// # Errors
    ///
    /// [`Error::UnknownTrial`], [`Error::AlreadyTold`], [`Error::NonFiniteOutcome`]; the state is then
    /// as before.
    pub fn tell(&mut self, id: TrialId, outcome: Outcome) -> Result<(), Error> {
        self.record(id, None, outcome)
    }

    /// The outcome of an outstanding side trial whose own parameter could not be set exactly as
    /// asked: `actual` is the setting made, in the parameter's unit. The difference then uses it.
    ///
    /// # Errors
    ///
    /// Those of [`tell`](Self::tell), and [`Error::ActualSetting`] if the trial is a center, or the
    /// setting is not finite or not on the trial's side of the center.
    pub fn tell_at(&mut self, id: TrialId, actual: f64, outcome: Outcome) -> Result<(), Error> {
        self.record(id, Some(actual), outcome)
    }

    /// Asks and tells until the campaign ends, with an experiment that answers at once.
    ///
    /// # Errors
    ///
    /// Those of [`ask`](Self::ask).
    pub fn run(
        &mut self,
        simulation: &mut impl FnMut(&[f64]) -> Result<f64, String>,
        experiment: &mut impl FnMut(&Trial) -> Result<f64, String>,
    ) -> Result<StopReason, Error> {
        loop {
            match self.ask(simulation)? {
                Ask::Stopped(reason) => return Ok(reason),
                Ask::Trials(trials) => {
                    for trial in trials {
                        self.tell(trial.id, experiment(&trial).into())?;
                    }
                }
            }
        }
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
    pub fn correction(&self) -> Correction {
        let last = self.history.last();
        last.map_or_else(|| Correction::zero(self.problem.n_parameters()), |report| report.correction.clone())
    }

    /// The optimum of the open iteration, while trials are outstanding.
    #[must_use]
    pub fn current_optimum(&self) -> Option<&NumericalOptimum> {
        self.open.as_ref().map(|open| &open.numerical)
    }

    /// The trials handed out and not yet told.
    #[must_use]
    pub fn outstanding(&self) -> Vec<Trial> {
        let trials = self.open.iter().flat_map(|open| &open.trials);
        let untold = trials.filter(|record| record.outcome.is_none());
        untold.map(|record| record.trial.clone()).collect()
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
    fn iteration(&self) -> usize {
        self.history.len() + 1
    }

    /// How many trials the closed iterations handed out.
    fn n_asked(&self) -> u64 {
        let counts = self.history.iter().map(|report| report.trials.len() as u64);
        counts.sum()
    }

    /// The trials of the next iteration around its optimum, numbered on from the last.
    pub(crate) fn design(&self, optimum: &[f64]) -> Vec<TrialRecord> {
        let (steps, policy) = (&self.settings.experiment_steps, self.settings.bound_policy);
        let center = (TrialRole::Center, optimum.to_vec());
        let around = sides(optimum, steps, self.problem.region(), policy);
        let points = std::iter::once(center).chain(around);
        let record = |(number, (role, point))| TrialRecord {
            trial: Trial { id: TrialId::new(number), iteration: self.iteration(), role, point },
            actual: None,
            outcome: None,
        };
        (self.n_asked() + 1..).zip(points).map(record).collect()
    }

    fn record(&mut self, id: TrialId, actual: Option<f64>, outcome: Outcome) -> Result<(), Error> {
        let n_asked = self.n_asked();
        let correction = self.correction();
        let iteration = self.iteration();
        let absent =
            if (1..=n_asked).contains(&id.number()) { Error::AlreadyTold { id } } else { Error::UnknownTrial { id } };
        let Some(open) = &mut self.open else {
            return Err(absent);
        };
        let mut records = open.trials.iter_mut();
        let Some(record) = records.find(|record| record.trial.id == id) else {
            return Err(absent);
        };
        record.tell(actual, outcome, &open.numerical.point)?;
        if open.trials.iter().all(|record| record.outcome.is_some())
            && let Some(OpenIteration { numerical, trials }) = self.open.take()
        {
            let settings = &self.settings;
            let report = Report::close(iteration, numerical, trials, &correction, settings);
            self.history.push(report);
        }
        Ok(())
    }
}
