//! Asking for experiments, and telling what became of them.

use std::fmt;

use design_space::Cell;
use serde::{Deserialize, Serialize};

use crate::made::{check_actual, check_earlier};
use crate::pooled::campaign::{Earlier, Loop, Record, Trial};
use crate::pooled::reason::Pick;
use crate::pooled::simulated::{Responses, Simulate, Simulated};
use crate::pooled::turn::Next;
use crate::{Error, Outcome, TrialId};

/// What there is to do next.
#[derive(Debug, Clone, PartialEq)]
pub enum Ask {
    /// Run these, in any order, and tell the outcome of each. Either list may be empty, not both.
    Run {
        /// The experiments.
        trials: Vec<Trial>,
        /// Cells to simulate, where simulations are dear.
        simulations: Vec<Cell>,
    },
    /// Nothing: the campaign has ended.
    Stopped(StopReason),
}

/// Why a campaign has ended.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StopReason {
    /// All batches were run.
    BatchLimit,
    /// No design is better than the recommended one by more than another batch is worth, says what the campaign
    /// [stops by](crate::pooled::Settings::stop_by).
    NotWorthIt,
}

impl fmt::Display for StopReason {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str(match self {
            Self::BatchLimit => "the limit on the batches was reached",
            Self::NotWorthIt => "another batch is not worth it",
        })
    }
}

impl Loop {
    /// What to run now: what is outstanding, or else a new batch.
    ///
    /// `simulate` is for a cheap simulation and is called wherever the loop likes, each cell once; none where there is no simulation
    /// at all: experiments alone tell then. Where simulations are dear
    /// ([`Settings::simulations`](crate::pooled::Settings::simulations)) it is not called: their cells are handed out with the
    /// trials, the first ones ahead of them.
    ///
    /// # Errors
    ///
    /// [`Error::Surface`] if the responses cannot be fitted, [`Error::EveryDesignRefused`]. The state is then as before.
    pub fn ask(&mut self, simulate: Option<&mut dyn Simulate>) -> Result<Ask, Error> {
        let trials = self.outstanding();
        if trials.is_empty() && self.due.is_empty() {
            return self.ask_more(simulate);
        }
        Ok(Ask::Run { trials, simulations: self.due.clone() })
    }

    /// A new batch, whether or not there are outstanding trials: those count as if they had given what is expected of them.
    /// Hands out all that is outstanding, the new trials last.
    ///
    /// # Errors
    ///
    /// Those of [`ask`](Self::ask).
    pub fn ask_more(&mut self, simulate: Option<&mut dyn Simulate>) -> Result<Ask, Error> {
        if self.batch() >= self.settings.max_batches {
            return Ok(Ask::Stopped(StopReason::BatchLimit));
        }
        match self.turn(simulate)? {
            Next::NotWorthIt => return Ok(Ask::Stopped(StopReason::NotWorthIt)),
            Next::Simulations(cells) => self.due = sorted(cells),
            Next::Batch { experiments, simulations } => {
                self.due.extend(simulations);
                self.due = sorted(std::mem::take(&mut self.due));
                let trials = self.hand_out(&Pick::cells(&experiments))?;
                let reasons = experiments.iter().map(|pick| pick.reason);
                self.reasons.extend(trials.iter().map(|trial| trial.id).zip(reasons));
            }
        }
        Ok(Ask::Run { trials: self.outstanding(), simulations: self.due.clone() })
    }

    /// Asks and tells until the campaign ends, with experiments and simulations that answer at once.
    ///
    /// An experiment gives its cost, or [`Responses`] where there are
    /// [constraints](crate::pooled::Settings::constraints), or else the reason why it gave none:
    ///
    /// ```
    /// use design_space::{Cell, Parameter, Region};
    /// use infuse::pooled::{Constraint, Loop, Responses, Settings, Trial};
    ///
    /// let region = Region::new(vec![Parameter::continuous("force", "N", 0.0, 10.0)?.with_levels(21)?])?;
    /// let mut settings = Settings::new(5);
    /// settings.max_batches = 2;
    /// settings.constraints = vec![Constraint::at_most("travel", 6.0)];
    /// let mut campaign = Loop::new(&region, settings)?;
    /// // The more force the better, but each newton moves it by a millimeter.
    /// let mut simulation = |_: Cell, p: &[f64]| Ok(10.0 - p[0]);
    /// let mut rig = |trial: &Trial| {
    ///     let force = trial.point[0];
    ///     Ok(Responses { cost: 10.0 - 0.9 * force, constrained: vec![Some(force)] })
    /// };
    /// campaign.run(&mut simulation, &mut rig)?;
    /// let found = campaign.assess(Some(&mut simulation))?.expect("there are responses");
    /// assert!((5.0..=6.0).contains(&found.recommended.point[0]), "{:?}", found.recommended);
    /// # Ok::<(), infuse::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Those of [`ask`](Self::ask), [`tell_constrained`](Self::tell_constrained) and [`tell`](Self::tell): more constrained responses
    /// than constraints, among others. The trial at fault is then outstanding.
    pub fn run<R: Into<Responses>>(
        &mut self,
        simulate: &mut dyn Simulate,
        experiment: &mut impl FnMut(&Trial) -> Result<R, String>,
    ) -> Result<StopReason, Error> {
        self.go_on(Some(simulate), experiment)
    }

    /// The same where there is no simulation: experiments alone tell.
    ///
    /// # Errors
    ///
    /// Those of [`run`](Self::run), and [`Error::SettingCount`] if the settings ask for simulations.
    pub fn run_without_simulation<R: Into<Responses>>(
        &mut self,
        experiment: &mut impl FnMut(&Trial) -> Result<R, String>,
    ) -> Result<StopReason, Error> {
        if let Some(value) = self.settings.simulations {
            return Err(Error::SettingCount { name: "simulations", value, expected: "none where nothing simulates" });
        }
        self.go_on(None, experiment)
    }

    fn go_on<R: Into<Responses>>(
        &mut self,
        mut simulate: Option<&mut dyn Simulate>,
        experiment: &mut impl FnMut(&Trial) -> Result<R, String>,
    ) -> Result<StopReason, Error> {
        loop {
            let asked = match &mut simulate {
                Some(simulate) => self.ask(Some(&mut **simulate))?,
                None => self.ask(None)?,
            };
            let (trials, simulations) = match asked {
                Ask::Stopped(reason) => return Ok(reason),
                Ask::Run { trials, simulations } => (trials, simulations),
            };
            if let Some(simulate) = &mut simulate {
                self.simulated.run(&self.designs, &simulations, &mut **simulate)?;
                self.due.retain(|&due| !self.simulated.contains(due));
            }
            for trial in trials {
                self.tell_responses(trial.id, experiment(&trial).map(Into::into))?;
            }
        }
    }

    /// All that an experiment gave; what was told of the constrained responses before stays where it gave none of them.
    fn tell_responses(&mut self, id: TrialId, responses: Result<Responses, String>) -> Result<(), Error> {
        let constrained = responses.as_ref().map_or(&[][..], |responses| &responses.constrained);
        if !constrained.is_empty() {
            self.tell_constrained(id, constrained)?;
        }
        self.tell(id, responses.map(|responses| responses.cost).into())
    }

    /// New trials at these cells, as one more batch: for experiments that the experimenter wants.
    ///
    /// # Errors
    ///
    /// [`Error::DesignSpace`] for a cell that does not exist; the state is then as before.
    pub fn hand_out(&mut self, cells: &[Cell]) -> Result<Vec<Trial>, Error> {
        let points = cells.iter().map(|&cell| self.designs.grid().point(cell)).collect::<Result<Vec<_>, _>>()?;
        let (batch, first) = (self.batch() + 1, self.records.len() as u64 + 1);
        let ids = (first..).map(TrialId::new);
        let trials: Vec<Trial> =
            ids.zip(cells.iter().zip(points)).map(|(id, (&cell, point))| Trial { id, batch, cell, point }).collect();
        self.records.extend(trials.iter().map(|trial| Record { trial: trial.clone(), actual: None, outcome: None }));
        Ok(trials)
    }

    /// The outcome of an outstanding trial, at the settings asked for.
    ///
    /// # Errors
    ///
    /// [`Error::UnknownTrial`], [`Error::SecondOutcome`], [`Error::NonFiniteOutcome`]. The state is then as before.
    pub fn tell(&mut self, id: TrialId, outcome: Outcome) -> Result<(), Error> {
        self.record(id, None, outcome, false)
    }

    /// The outcome of an outstanding trial at other settings than those asked for: all parameters, natural. They may be off the
    /// grid, and outside of the region by up to half a parameter's width.
    ///
    /// # Errors
    ///
    /// Those of [`tell`](Self::tell), [`Error::DesignSpace`] for a wrong number of settings, [`Error::ActualSettingOf`].
    pub fn tell_at(&mut self, id: TrialId, actual: &[f64], outcome: Outcome) -> Result<(), Error> {
        self.record(id, Some(actual.to_vec()), outcome, false)
    }

    /// Another outcome for a trial that had one: it was misread.
    ///
    /// # Errors
    ///
    /// Those of [`tell_at`](Self::tell_at), but for [`Error::SecondOutcome`].
    pub fn correct(&mut self, id: TrialId, actual: Option<&[f64]>, outcome: Outcome) -> Result<(), Error> {
        self.record(id, actual.map(<[f64]>::to_vec), outcome, true)
    }

    /// What a simulation gave, handed out or not: its cost, or [`Responses`] where there are
    /// [constraints](crate::pooled::Settings::constraints), or else the reason why it gave none. A cost that is no number, or beyond
    /// 1e100, counts as a failure.
    ///
    /// # Errors
    ///
    /// [`Error::DesignSpace`] for a cell that does not exist, [`Error::TooManyConstrained`] for more values than constraints.
    pub fn tell_simulation<R: Into<Responses>>(&mut self, cell: Cell, said: Result<R, String>) -> Result<(), Error> {
        self.designs.grid().digits(cell)?;
        let responses = said.ok().map(Into::into);
        if let Some(responses) = &responses {
            self.check_constrained(&responses.constrained)?;
        }
        self.simulated.insert(cell, responses);
        self.due.retain(|&due| due != cell);
        Ok(())
    }

    /// The constrained responses of a trial, in the order of the [constraints](crate::pooled::Settings::constraints), none where
    /// one was not measured. Before or after its [outcome](Self::tell), and as often as there is something to put right.
    ///
    /// # Errors
    ///
    /// [`Error::UnknownTrial`], [`Error::TooManyConstrained`] for more values than constraints, [`Error::ConstrainedValue`]. The state
    /// is then as before.
    pub fn tell_constrained(&mut self, id: TrialId, values: &[Option<f64>]) -> Result<(), Error> {
        if !self.records.iter().any(|record| record.trial.id == id) {
            return Err(Error::UnknownTrial { id });
        }
        self.check_constrained(values)?;
        let unusable = |value: &f64| value.is_nan() || value.abs() > surface::Data::LARGEST;
        for (constraint, value) in self.settings.constraints.iter().zip(values) {
            if let Some(value) = value.filter(unusable) {
                return Err(Error::ConstrainedValue { id, constraint: constraint.name.clone(), value });
            }
        }
        self.constrained.insert(id, values.to_vec());
        Ok(())
    }

    /// A design that nobody can build, whatever was measured there: it is neither asked for nor recommended, and its neighbors
    /// are suspected. Trials of it that are outstanding stay.
    ///
    /// # Errors
    ///
    /// [`Error::DesignSpace`] for a cell that does not exist.
    pub fn refuse(&mut self, cell: Cell) -> Result<(), Error> {
        self.designs.grid().digits(cell)?;
        self.refused.insert(cell);
        Ok(())
    }

    /// Forgets every simulation: the simulator was changed.
    pub fn forget_simulations(&mut self) {
        self.simulated = Simulated::default();
        self.due.clear();
    }

    /// An experiment made outside of the campaign, at these natural settings: it counts as much as any other.
    ///
    /// # Errors
    ///
    /// [`Error::DesignSpace`] for a wrong number of settings, [`Error::EarlierSetting`] for one more than half a parameter's
    /// width outside of its bounds, [`Error::Setting`] for a response that is not finite or beyond 1e100,
    /// [`Error::TooManyConstrained`] for more constrained responses than constraints.
    pub fn add_earlier(
        &mut self,
        point: &[f64],
        responses: impl Into<Responses>,
        source: impl Into<String>,
    ) -> Result<(), Error> {
        check_earlier(point, self.region())?;
        let Responses { cost, constrained } = responses.into();
        self.check_constrained(&constrained)?;
        let values = constrained.iter().flatten().chain([&cost]);
        if let Some(&value) = values.into_iter().find(|value| value.is_nan() || value.abs() > surface::Data::LARGEST) {
            let expected = "a response of at most 1e100 in magnitude";
            return Err(Error::Setting { name: "response", value, expected });
        }
        let (point, outcome) = (point.to_vec(), Outcome::Value(cost));
        self.earlier.push(Earlier { point, outcome, constrained, source: source.into() });
        Ok(())
    }

    /// An experiment made outside of the campaign that gave no response: it tells where others may fail.
    ///
    /// # Errors
    ///
    /// [`Error::DesignSpace`] for a wrong number of settings, [`Error::EarlierSetting`] for one more than half a parameter's
    /// width outside of its bounds.
    pub fn add_earlier_failure(
        &mut self,
        point: &[f64],
        reason: impl Into<String>,
        source: impl Into<String>,
    ) -> Result<(), Error> {
        check_earlier(point, self.region())?;
        let outcome = Outcome::Failed { reason: reason.into() };
        let (point, constrained) = (point.to_vec(), Vec::new());
        self.earlier.push(Earlier { point, outcome, constrained, source: source.into() });
        Ok(())
    }

    /// Takes back the [earlier](Self::add_earlier) experiments from this source. How many there were.
    pub fn withdraw_earlier(&mut self, source: &str) -> usize {
        let before = self.earlier.len();
        self.earlier.retain(|earlier| earlier.source != source);
        before - self.earlier.len()
    }

    fn check_constrained(&self, values: &[Option<f64>]) -> Result<(), Error> {
        let (most, found) = (self.settings.constraints.len(), values.len());
        if found <= most { Ok(()) } else { Err(Error::TooManyConstrained { found, most }) }
    }

    fn record(&mut self, id: TrialId, actual: Option<Vec<f64>>, outcome: Outcome, again: bool) -> Result<(), Error> {
        let position =
            self.records.iter().position(|record| record.trial.id == id).ok_or(Error::UnknownTrial { id })?;
        if self.records[position].outcome.is_some() != again {
            return Err(if again { Error::NothingToCorrect { id } } else { Error::SecondOutcome { id } });
        }
        if let Some(value) = outcome.cost().filter(|value| value.is_nan() || value.abs() > surface::Data::LARGEST) {
            return Err(Error::NonFiniteOutcome { id, value });
        }
        if let Some(actual) = &actual {
            check_actual(id, actual, self.region())?;
        }
        let record = &mut self.records[position];
        (record.actual, record.outcome) = (actual, Some(outcome));
        Ok(())
    }
}

/// These cells, each once.
fn sorted(mut cells: Vec<Cell>) -> Vec<Cell> {
    cells.sort_unstable();
    cells.dedup();
    cells
}
