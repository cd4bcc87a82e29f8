//! Asking for experiments and taking their outcomes.

use crate::gradient::campaign::Loop;
use crate::gradient::report::StopReason;
use crate::gradient::trial::{Trial, check_actual};
use crate::ledger::not_outstanding;
use crate::{Error, Outcome, TrialId};

/// What there is to do next.
#[derive(Debug, Clone, PartialEq)]
pub enum Ask {
    /// Run these experiments, in any order, and tell the outcome of each.
    Trials(Vec<Trial>),
    /// Nothing: the campaign has ended.
    Stopped(StopReason),
}

impl Loop {
    /// The experiments to run now.
    ///
    /// While trials are outstanding it returns those without an outcome, and the simulation is not called.
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
            self.open = Some(self.begin(simulation)?);
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
    /// [`Error::UnknownTrial`], [`Error::SecondOutcome`], [`Error::NonFiniteOutcome`]; the state is then
    /// as before.
    pub fn tell(&mut self, id: TrialId, outcome: Outcome) -> Result<(), Error> {
        self.record(id, None, outcome)
    }

    /// The outcome of an outstanding side trial whose own parameter could not be set exactly as
    /// asked: `actual` is the setting made, in the parameter's unit. The difference then uses it. It is one setting and not a point,
    /// because the two ends of a difference may differ in nothing else.
    ///
    /// # Errors
    ///
    /// Those of [`tell`](Self::tell), and [`Error::ActualSetting`] if the trial is a center, or the
    /// setting is not finite, not on the trial's side of the center, or farther outside of the bounds than half their width.
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

    fn record(&mut self, id: TrialId, actual: Option<f64>, outcome: Outcome) -> Result<(), Error> {
        let Some(open) = &mut self.open else {
            return Err(not_outstanding(id, self.n_asked()));
        };
        let (optimum, region) = (&open.numerical.point, self.problem.region());
        open.trials.record(id, actual, outcome, |trial, actual| check_actual(trial, *actual, optimum, region))?;
        if let Some(complete) = self.open.take_if(|open| open.trials.is_complete()) {
            let report = self.finish(complete);
            self.history.push(report);
        }
        Ok(())
    }
}
