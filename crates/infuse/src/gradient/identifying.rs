//! The loop of Chapter 3 on a model with unknowns: what was measured finds them, corrects the response, or does both.

use serde::{Deserialize, Serialize};

use crate::correction::{Local, Slopes};
use crate::gradient::ask_tell::Ask;
use crate::gradient::campaign::Loop;
use crate::gradient::numerical::slopes;
use crate::gradient::report::{Report, StopReason};
use crate::gradient::settings::Settings;
use crate::gradient::trial::Trial;
use crate::identification::{self, Answer, Identification, Measurements, Unknowns, identify};
use crate::{CodesignProblem, Error, Outcome, TrialId};

/// How experiments are digested: the two mechanisms of Section 3.5, and their combination. In files `response_correction`,
/// `identification`, `both`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mechanism {
    /// By a correction of the response, (27): the loop that [`Loop`] is, bit for bit.
    ResponseCorrection,
    /// By identification of the unknowns: the next optimum is that of the model with what was found.
    Identification,
    /// By both: (27) corrects what the identified model still misses.
    Both,
}

impl Mechanism {
    pub(super) fn identifies(self) -> bool {
        self != Self::ResponseCorrection
    }
}

/// A model with unknown numbers.
pub trait UncertainModel {
    /// The cost J at a design with these values of the unknowns, or why there is none.
    ///
    /// # Errors
    ///
    /// The reason, in the model's own words; it is survived and reported.
    fn cost(&mut self, unknowns: &[f64], design: &[f64]) -> Result<f64, String>;

    /// What an experiment would read, for every vector of unknowns at every design: `answers[unknowns][design]`, each with the
    /// responses in the order of [`Reading::responses`].
    fn responses(&mut self, unknowns: &[Vec<f64>], designs: &[Vec<f64>]) -> Vec<Vec<Answer>>;
}

/// What an experiment read.
#[derive(Debug, Clone, PartialEq)]
pub struct Reading {
    /// The cost J, of which slopes are taken.
    pub cost: f64,
    /// What unknowns are identified from, in the order of their names.
    pub responses: Vec<f64>,
    /// Standard deviation of each response, in its unit.
    pub standard_deviations: Vec<f64>,
}

/// One closed iteration.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Turn {
    /// The unknowns of the model that was optimized.
    pub unknowns: Vec<f64>,
    /// The fit that found them; none in the first iteration, and none where nothing is identified.
    pub identification: Option<Identification>,
    /// The correction with which that model was optimized.
    pub carried: Local,
    /// What the iteration did. Its own `correction` adds to the carried one what it measured.
    pub report: Report,
}

/// The loop of Chapter 3 on a model with unknowns, as ask and tell.
///
/// A turn:
///
/// 1. Fit the unknowns θ to all that was measured so far ([`identify`]), from where they were believed to be.
/// 2. Learn the correction anew: (27) from the first iteration to the last, each with the slopes that were measured then and
///    those of the model *as it is now*, at the optimum of then.
/// 3. Optimize J(θ, p) + J_cor(p), experiment at the optimum and beside it.
///
/// [`Mechanism::Identification`] leaves out 2, [`Mechanism::ResponseCorrection`] leaves out 1 and has nothing to learn anew.
///
/// # Why the correction is learned anew
///
/// (27) adds up differences between the slopes of experiments and of the model. When θ changes, the model itself takes over a part
/// of what was corrected; with the old correction on top, that part would count twice. So a correction is believed only against
/// the model that it was taken from: J_cor starts at zero with every new θ and goes through all iterations again. If the truth is in the
/// model's family and found, all differences are zero, and so is J_cor; if θ does not change, J_cor is what it was, bit for
/// bit; if θ absorbs half of a difference, J_cor holds the other half.
///
/// The value is the whole state, and serializes as [`Loop`] does: the model is not part of it.
///
/// Source: Section 3.5. The rule of step 2 is ours: the dissertation names the combination and does not say how.
#[derive(Debug, Clone, PartialEq)]
pub struct IdentifyingLoop {
    pub(super) inner: Loop,
    pub(super) mechanism: Mechanism,
    pub(super) unknowns: Unknowns,
    pub(super) fit: identification::Settings,
    pub(super) measurements: Measurements,
    /// Of the open iteration, or the one that comes next if nothing new was measured.
    pub(super) now: Now,
    pub(super) turns: Vec<Turn>,
}

/// The model that is optimized.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Now {
    pub(super) unknowns: Vec<f64>,
    pub(super) identification: Option<Identification>,
    pub(super) carried: Local,
}

impl IdentifyingLoop {
    /// A campaign that has not begun, on `unknowns` that are found from `responses` by name.
    ///
    /// # Errors
    ///
    /// Those of [`Settings::validate`], [`identification::Settings::validate`] and [`Measurements::new`].
    pub fn new(
        problem: CodesignProblem,
        mut settings: Settings,
        mechanism: Mechanism,
        unknowns: Unknowns,
        responses: Vec<String>,
        fit: identification::Settings,
    ) -> Result<Self, Error> {
        settings.validate(&problem)?;
        fit.validate()?;
        if mechanism == Mechanism::Identification {
            // Slopes are still taken, and none is believed.
            settings.trust.fill(0.0);
        }
        let carried = Local::zero(problem.n_parameters());
        let now = Now { unknowns: unknowns.start().to_vec(), identification: None, carried };
        let inner = Loop { problem, settings, history: Vec::new(), open: None };
        let measurements = Measurements::new(responses)?;
        Ok(Self { inner, mechanism, unknowns, fit, measurements, now, turns: Vec::new() })
    }

    /// The experiments to run now, as [`Loop::ask`] gives them. Where none are outstanding, the turn begins here: the unknowns, the
    /// correction, the optimum.
    ///
    /// # Errors
    ///
    /// Those of [`Loop::ask`] and of [`identify`]; the campaign can be asked again.
    pub fn ask(&mut self, model: &mut impl UncertainModel) -> Result<Ask, Error> {
        let begins = self.inner.open.is_none() && self.inner.stop().is_none();
        if begins && self.mechanism.identifies() && !self.turns.is_empty() {
            // What was measured says which plant it is,
            let found = self.identified(model)?;
            self.now.unknowns = found.values();
            self.now.identification = Some(found);
            // and what the model of that plant still misses is corrected, from the first iteration on.
            let Now { unknowns, .. } = &self.now;
            self.inner.relearn(&mut |design| model.cost(unknowns, design));
        }
        // The optimum of that model, corrected, and experiments at it and beside it.
        if begins {
            self.now.carried = self.inner.correction();
        }
        let Now { unknowns, .. } = &self.now;
        self.inner.ask(&mut |design| model.cost(unknowns, design))
    }

    /// What an outstanding trial read, or why it read nothing. The last one closes the iteration.
    ///
    /// # Errors
    ///
    /// Those of [`Loop::tell`] and of [`Measurements::push`]; the state is then as before.
    pub fn tell(&mut self, id: TrialId, reading: Result<Reading, String>) -> Result<(), Error> {
        let mut measurements = self.measurements.clone();
        let outstanding = self.inner.outstanding();
        match (&reading, outstanding.iter().find(|trial| trial.id == id)) {
            (Ok(read), Some(trial)) => {
                measurements.push(&trial.point, &read.responses, &read.standard_deviations)?;
            }
            _ => measurements.push_failed(),
        }
        let outcome = match reading {
            Ok(read) => Outcome::Value(read.cost),
            Err(reason) => Outcome::Failed { reason },
        };
        self.inner.tell(id, outcome)?;
        self.measurements = measurements;
        if let Some(report) = self.inner.history.get(self.turns.len()) {
            let Now { unknowns, identification, carried } = self.now.clone();
            self.turns.push(Turn { unknowns, identification, carried, report: report.clone() });
        }
        Ok(())
    }

    /// Asks and tells until the campaign ends, with experiments that answer at once, a batch at a time and in its order. A reading whose cost
    /// is no number counts as one that failed.
    ///
    /// # Errors
    ///
    /// Those of [`ask`](Self::ask) and [`tell`](Self::tell); [`Error::WrongCount`] for another number of readings than trials.
    pub fn run(
        &mut self,
        model: &mut impl UncertainModel,
        experiments: &mut impl FnMut(&[Trial]) -> Vec<Result<Reading, String>>,
    ) -> Result<StopReason, Error> {
        loop {
            match self.ask(model)? {
                Ask::Stopped(reason) => return Ok(reason),
                Ask::Trials(trials) => {
                    let readings = experiments(&trials);
                    crate::checks::check_count("readings", trials.len(), readings.len(), "trial")?;
                    for (trial, reading) in trials.iter().zip(readings) {
                        self.tell(trial.id, usable(reading))?;
                    }
                }
            }
        }
    }

    /// The unknowns by all that was measured so far, whatever the mechanism.
    ///
    /// # Errors
    ///
    /// Those of [`identify`].
    pub fn identified(&self, model: &mut impl UncertainModel) -> Result<Identification, Error> {
        let mut responses = |unknowns: &[Vec<f64>], designs: &[Vec<f64>]| model.responses(unknowns, designs);
        identify(&self.unknowns, &self.measurements, &self.fit, &mut responses)
    }

    /// The closed iterations, first to last.
    #[must_use]
    pub fn turns(&self) -> &[Turn] {
        &self.turns
    }

    /// All that was measured so far.
    #[must_use]
    pub fn measurements(&self) -> &Measurements {
        &self.measurements
    }

    /// Why the campaign has ended; nothing while it goes on.
    #[must_use]
    pub fn stop(&self) -> Option<StopReason> {
        self.inner.stop()
    }
}

impl Loop {
    /// (27) from the first iteration to the last with another simulation: the slopes of the experiments stay, those of the model
    /// are taken anew at the same optima.
    fn relearn(&mut self, simulation: &mut dyn FnMut(&[f64]) -> Result<f64, String>) {
        let mut simulate = |point: &[f64]| simulation(point).ok().filter(|cost| cost.is_finite());
        let mut correction = Local::zero(self.problem.n_parameters());
        for report in &mut self.history {
            let optimum = &report.numerical.point;
            let slopes = match simulate(optimum) {
                Some(center) => slopes(self.problem.region(), &self.settings, optimum, center, &mut simulate),
                None => vec![None; optimum.len()],
            };
            let corrected = slopes.into_iter().zip(correction.slope());
            let model: Vec<_> = corrected.map(|(slope, own)| slope.map(|slope| slope + own)).collect();
            let at = Slopes { optimum, experiment: &report.experiment_gradient, model: &model };
            correction = correction.updated(self.settings.correction_form, &self.settings.trust, at).0;
            report.correction = correction.clone();
        }
    }
}

/// A reading with a cost, or the reason why there is none.
fn usable(reading: Result<Reading, String>) -> Result<Reading, String> {
    let reading = reading?;
    match Outcome::from(Ok(reading.cost)) {
        Outcome::Value(_) => Ok(reading),
        Outcome::Failed { reason } => Err(reason),
    }
}
