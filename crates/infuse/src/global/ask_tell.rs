//! Asking for experiments and taking their outcomes.

use std::collections::BTreeSet;

use design_space::Cell;

use crate::global::campaign::Loop;
use crate::global::earlier::EarlierExperiment;
use crate::global::open_batch::OpenBatch;
use crate::global::plan::Plan;
use crate::global::report::StopReason;
use crate::global::trial::Trial;
use crate::global::turn::Closed;
use crate::ledger::not_outstanding;
use crate::made::check_actual;
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
    /// Otherwise it opens the next batch: both designs are searched for, the simulations are run, and
    /// the experiments are handed out, N_E of them.
    ///
    /// `simulation` maps a cell and its natural point to a response or to the reason why there is none; failures are
    /// survived and reported, as long as those that succeed determine the surface.
    ///
    /// # Errors
    ///
    /// [`Error::EverySimulationFailed`], [`Error::TooFewSimulations`]. The state is then as before, but for a note of
    /// the cells that failed: the next call simulates elsewhere, until the other cells no longer support the model,
    /// and then begins anew. So whatever was wrong with the simulation, repair it and ask again, or just ask again.
    pub fn ask(&mut self, simulation: &mut impl FnMut(Cell, &[f64]) -> Result<f64, String>) -> Result<Ask, Error> {
        if let Some(reason) = self.stop() {
            return Ok(Ask::Stopped(reason));
        }
        if self.open.is_none() {
            let open = self.begin(simulation)?;
            self.hand_out(open)?;
        }
        Ok(Ask::Trials(self.outstanding()))
    }

    /// The cells that the next batch experiments and simulates on: the first half of [`ask`](Self::ask), for
    /// callers who run many simulations at once, or who write the designs down before they begin. Nothing while trials
    /// are outstanding, and after the end.
    ///
    /// # Errors
    ///
    /// [`Error::DesignSpace`] if the searches find no design.
    pub fn plan(&self) -> Result<Option<Plan>, Error> {
        if self.open.is_some() || self.stop().is_some() {
            return Ok(None);
        }
        self.plan_in(&self.design_space()?).map(Some)
    }

    /// Opens the next batch with these designs: the second half of [`ask`](Self::ask). `simulation` is called once per
    /// simulation of the plan, in its order, and may look up what has been run before.
    ///
    /// The designs need not be those of [`plan`](Self::plan): any cells that are left will do, in the numbers of the
    /// settings. So a campaign is followed again from its notes without searching, past the limit on the batches, too, which may
    /// have been lowered since.
    ///
    /// # Errors
    ///
    /// [`Error::Plan`], and those of [`ask`](Self::ask), with the same consequence.
    pub fn open(
        &mut self,
        plan: &Plan,
        simulation: &mut impl FnMut(Cell, &[f64]) -> Result<f64, String>,
    ) -> Result<Vec<Trial>, Error> {
        let wrong = |expected| Error::Plan { batch: self.batch(), expected };
        if self.open.is_some() {
            return Err(wrong("none while trials are outstanding"));
        }
        if self.history.last().is_some_and(|last| last.own_stop(&self.settings).is_some()) {
            return Err(wrong("none after the campaign has ended"));
        }
        if plan.experiments.len() != self.settings.n_experiments
            || plan.simulations.len() != self.settings.n_simulations
        {
            return Err(wrong("as many experiments and simulations as the settings say"));
        }
        if !plan.experiments.iter().chain(&plan.simulations).all(|&cell| self.is_retained(cell)) {
            return Err(wrong("cells that are left"));
        }
        let open = self.open_in(&self.design_space()?, plan, simulation)?;
        self.hand_out(open)?;
        Ok(self.outstanding())
    }

    /// The outcome of an outstanding trial, at the settings asked for.
    ///
    /// The last outcome of a batch closes it: surfaces are fitted, the correction is updated, cells are dropped,
    /// and the batch appears in [`reports`](Self::reports). The order of telling does not matter.
    ///
    /// # Errors
    ///
    /// [`Error::UnknownTrial`], [`Error::SecondOutcome`], [`Error::NonFiniteOutcome`]; [`Error::Surface`] if a response, or a
    /// corrected one, is too large to be fitted. The state is then as before.
    pub fn tell(&mut self, id: TrialId, outcome: Outcome) -> Result<(), Error> {
        self.record(id, None, outcome)
    }

    /// The outcome of an outstanding trial that could not be set exactly as asked: `actual` holds the settings made of
    /// all parameters, natural. The surfaces then use them; they may be off the grid, and outside the region by up
    /// to half a parameter's width.
    ///
    /// # Errors
    ///
    /// Those of [`tell`](Self::tell), [`Error::DesignSpace`] for a wrong number of settings, and [`Error::ActualSettingOf`].
    pub fn tell_at(&mut self, id: TrialId, actual: &[f64], outcome: Outcome) -> Result<(), Error> {
        self.record(id, Some(actual.to_vec()), outcome)
    }

    /// Asks and tells until the campaign ends, with an experiment that answers at once.
    ///
    /// # Errors
    ///
    /// Those of [`ask`](Self::ask) and [`tell`](Self::tell).
    pub fn run(
        &mut self,
        simulation: &mut impl FnMut(Cell, &[f64]) -> Result<f64, String>,
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

    /// An experiment made outside the campaign, at these natural settings. From the batch that is open or comes
    /// next it counts as one more training experiment of every batch at whose onset the nearest cell is left;
    /// it never validates. Designs do not know of it.
    ///
    /// # Errors
    ///
    /// [`Error::DesignSpace`] for a wrong number of settings, [`Error::EarlierSetting`] for one more than half a parameter's
    /// width outside its bounds, [`Error::Setting`] for a response that is not finite.
    pub fn add_earlier(&mut self, point: &[f64], cost: f64, source: impl Into<String>) -> Result<(), Error> {
        let since = self.batch();
        let earlier = EarlierExperiment { point: point.to_vec(), cost, source: source.into(), since, until: None };
        earlier.check(self.cells.region())?;
        self.earlier.push(earlier);
        Ok(())
    }

    /// Stops using the [earlier](Self::add_earlier) experiments from this source, from the batch that is open or comes next
    /// on. Batches that rest on them stand. How many were in use.
    pub fn withdraw_earlier(&mut self, source: &str) -> usize {
        let batch = self.batch();
        let mut n_withdrawn = 0;
        for earlier in self.earlier.iter_mut().filter(|earlier| earlier.source == source && earlier.until.is_none()) {
            earlier.until = Some(batch);
            n_withdrawn += 1;
        }
        n_withdrawn
    }

    fn hand_out(&mut self, open: OpenBatch) -> Result<(), Error> {
        if let Err(error) = open.check_simulations(&self.cells, &self.settings) {
            self.avoid(open.failed_cells());
            return Err(error);
        }
        self.failed_cells.clear();
        self.open = Some(open);
        Ok(())
    }

    /// Notes cells for the next design to avoid. A noted cell among them says that it could not be avoided.
    fn avoid(&mut self, failed: BTreeSet<Cell>) {
        if !self.failed_cells.is_disjoint(&failed) {
            self.failed_cells.clear();
        }
        self.failed_cells.extend(failed);
    }

    fn record(&mut self, id: TrialId, actual: Option<Vec<f64>>, outcome: Outcome) -> Result<(), Error> {
        let Some(mut open) = self.open.clone() else {
            return Err(not_outstanding(id, self.n_asked()));
        };
        open.trials.record(id, actual, outcome, |trial, actual| check_actual(trial.id, actual, self.region()))?;
        if open.trials.is_complete() {
            let closed = self.finish(open)?;
            self.close(closed);
        } else {
            self.open = Some(open);
        }
        Ok(())
    }

    pub(super) fn close(&mut self, closed: Closed) {
        let Closed { report, surfaces, retained } = closed;
        self.history.push(report);
        self.surfaces.push(surfaces);
        self.retained = retained;
        self.open = None;
    }
}
