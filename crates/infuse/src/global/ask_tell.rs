//! The loop of Figures 4 and 19: design, experiment and simulate, fit, correct, test, reduce, repeat.

use std::collections::BTreeSet;

use design_space::Region;
use serde::{Deserialize, Serialize};
use surface::Surface;

use crate::checks::check_not_negative;
use crate::convergence::{Norm, RegretCertificate, coded_cell_measure};
use crate::global::Settings;
use crate::global::batch::{DesignSpace, Purpose};
use crate::global::cells::Cells;
use crate::global::changes::SurfaceChanges;
use crate::global::earlier::EarlierExperiment;
use crate::global::iteration::{OpenIteration, simulated, simulation_record, trials};
use crate::global::observations::Observations;
use crate::global::plan::Plan;
use crate::global::report::{Report, StopReason};
use crate::global::retained::RetainedSet;
use crate::global::screening::{Dropped, Screening, Spread, threshold, z};
use crate::global::state::State;
use crate::global::surfaces::{IterationSurfaces, correction};
use crate::global::traced::TracedSurface;
use crate::global::trial::{Trial, TrialUse};
use crate::{Error, Outcome, TrialId};

/// What there is to do next.
#[derive(Debug, Clone, PartialEq)]
pub enum Ask {
    /// Run these experiments, in any order, and tell the outcome of each.
    Trials(Vec<Trial>),
    /// Nothing: the campaign has ended.
    Stopped(StopReason),
}

/// Experimentally infused optimization over a gridded design space: the loop of Chapters 5 and 6, as ask
/// and tell.
///
/// The value is the whole state. It serializes with serde, a few hundred bytes per run and nothing per cell: what is
/// left of the grid is found again when it is read, provided the format keeps doubles exactly (`serde_json` does so only
/// with its feature `float_roundtrip`). On the machine that wrote it the campaign then goes on bit for bit. Elsewhere
/// factorizations may round differently: what was chosen and told must agree exactly, what was computed from it to
/// 1e-9, and the next designs may be others. The simulation is not part of it: give the same one to every
/// [`ask`](Self::ask).
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(try_from = "State", into = "State")]
pub struct Loop {
    pub(crate) cells: Cells,
    pub(crate) settings: Settings,
    pub(crate) retained: RetainedSet,
    pub(crate) history: Vec<Report>,
    pub(crate) surfaces: Vec<IterationSurfaces>,
    pub(crate) open: Option<OpenIteration>,
    /// Where simulations failed in calls of `ask` that opened no iteration.
    pub(crate) failed_cells: BTreeSet<u64>,
    /// In the order in which they were added.
    pub(crate) earlier: Vec<EarlierExperiment>,
}

/// One turn of Figure 19.
impl Loop {
    /// The upper half of the figure: G-optimal experiments and simulations over what is left.
    fn begin(&self, simulation: &mut impl FnMut(&[f64]) -> Result<f64, String>) -> Result<OpenIteration, Error> {
        // 5.1: both designs (29) for the terms that what is left supports.
        let space = self.design_space()?;
        let plan = self.plan_in(&space)?;
        // 5.2: simulations now, experiments by whoever has the rig.
        self.open_in(&space, &plan, simulation)
    }

    fn design_space(&self) -> Result<DesignSpace<'_>, Error> {
        DesignSpace::of(&self.retained, &self.cells, &self.settings, self.iteration())
    }

    fn plan_in(&self, space: &DesignSpace) -> Result<Plan, Error> {
        let settings = &self.settings;
        Ok(Plan {
            experiments: space.design(settings.n_experiments, Purpose::Experiments, &BTreeSet::new())?,
            simulations: space.design(settings.n_simulations, Purpose::Simulations, &self.failed_cells)?,
        })
    }

    /// Training and validation, the simulations, and the trials.
    fn open_in(
        &self,
        space: &DesignSpace,
        plan: &Plan,
        simulation: &mut impl FnMut(&[f64]) -> Result<f64, String>,
    ) -> Result<OpenIteration, Error> {
        let Plan { experiments, simulations } = plan;
        let uses = space.uses(experiments)?;
        let batch = space.batch(experiments, simulations)?;
        let record = |&cell: &u64| simulation_record(cell, &self.cells, simulation);
        let simulations = simulations.iter().map(record).collect::<Result<_, _>>()?;
        let trials = trials(experiments, &uses, &self.cells, self.iteration(), self.n_asked())?;
        Ok(OpenIteration { batch, simulations, trials })
    }

    /// The lower half: surfaces, correction, combined surface, optimum, z-test, reduction.
    pub(crate) fn finish(&self, open: OpenIteration) -> Result<Closed, Error> {
        let (cells, settings, k) = (&self.cells, &self.settings, self.cells.n_factors());
        let model = open.batch.model(settings)?;
        let training = open.experiments(TrialUse::Training, cells.region())?;
        let earlier = self.earlier_observations()?;
        let n_earlier = earlier.n_points();
        let training = training.followed_by(&earlier)?;
        let validation = open.experiments(TrialUse::Validation, cells.region())?;
        let simulations = open.simulations(cells)?;

        // 5.3, 1: all experiments, those made before the campaign too. 2: the simulations as they are.
        let all = training.clone().followed_by(&validation)?;
        let experiment = TracedSurface::fit(&settings.surfaces.experiment.with_model(&model), &all);
        let simulation = TracedSurface::fit(&settings.surfaces.simulation.with_model(&model), &simulations)?;

        // (35) at the onset of this iteration, with the correction of the one before: see 7.1.
        let corrected = simulations.corrected_by(&self.correction()?)?;

        // 5.3, 3: training experiments and corrected simulations, weighted as in (31).
        let weighted = training.weighted(settings.experiment_weight);
        let weighted = weighted.followed_by(&corrected.weighted(settings.simulation_weight))?;
        let combined = TracedSurface::fit(&settings.surfaces.combined.with_model(&model), &weighted)?;

        // (36) by the law of the settings, for the next iteration; without enough experiments it stays as it was.
        let (experiment, not_corrected) = match experiment {
            Ok(experiment) => (Some(experiment), None),
            Err(Error::Surface(error)) if is_lack_of_data(&error) => (None, Some(error.to_string())),
            Err(error) => return Err(error),
        };
        let correction = self.correction_with(experiment.as_ref(), &simulation)?;
        let numerical = TracedSurface::combination(k, [(1.0, &simulation), (1.0, &correction)])?;
        let surfaces = IterationSurfaces { experiment, simulation, combined, correction, numerical };
        let changes = SurfaceChanges::between(self.surfaces.last(), &surfaces, &self.retained, cells)?;

        // 5.5: the optimum, S of (40), and the test (37) to (39) of every cell against it.
        let spread = Spread::of(&surfaces.combined, &validation, settings.fallback)?;
        let (screening, retained) = self.screen(&surfaces, spread)?;
        let OpenIteration { batch, simulations, trials } = open;
        let iteration = self.iteration();
        let report = Report { iteration, batch, simulations, trials, n_earlier, screening, not_corrected, changes };
        Ok(Closed { report, surfaces, retained })
    }

    /// The optimum of the combined surface, and the cells that are not worse beyond doubt.
    fn screen(&self, surfaces: &IterationSurfaces, spread: Spread) -> Result<(Screening, RetainedSet), Error> {
        let points = self.cells.points();
        let minimum = |name, surface: &TracedSurface| {
            let minimum = self.retained.minimum(points, surface.surface());
            minimum.ok_or(Error::NoMinimum { surface: name, iteration: self.iteration() })
        };
        let optimum = minimum("combined", &surfaces.combined)?;
        let simulated = minimum("simulation", &surfaces.simulation)?;
        let n_before = self.retained.n_retained();
        let mut screening = Screening {
            optimum_cell: optimum.index,
            optimum: self.cells.natural(optimum.index)?,
            optimum_value: optimum.value,
            simulation_optimum_cell: simulated.index,
            simulation_optimum: self.cells.natural(simulated.index)?,
            spread,
            tested: self.iteration() >= self.settings.first_screening,
            threshold: threshold(self.settings.confidence),
            n_before,
            n_after: n_before,
        };
        let retained = reduced(&self.retained, &self.cells, &screening, &surfaces.combined);
        screening.n_after = retained.n_retained();
        Ok((screening, retained))
    }
}

/// M_i+1: the cells of M_i that the test of an iteration keeps.
fn reduced(before: &RetainedSet, cells: &Cells, screening: &Screening, combined: &TracedSurface) -> RetainedSet {
    let mut after = before.clone();
    if screening.tested_spread().is_some() {
        after.retain(cells.points(), combined.surface(), |value| screening.keeps(value));
    }
    after
}

/// Whether a fit failed because there were too few data, or too few different ones.
fn is_lack_of_data(error: &surface::Error) -> bool {
    use surface::Error::{Confounded, Count, IllConditioned, TooFewPoints, TooFewSites};
    matches!(error, Count { .. } | TooFewPoints { .. } | Confounded { .. } | IllConditioned { .. } | TooFewSites { .. })
}

/// What the lower half of an iteration gives.
#[derive(Debug)]
pub(crate) struct Closed {
    pub(crate) report: Report,
    pub(crate) surfaces: IterationSurfaces,
    pub(crate) retained: RetainedSet,
}

/// Asking, telling and looking.
impl Loop {
    /// A campaign that has not begun, over every combination of the levels of this region.
    ///
    /// # Errors
    ///
    /// [`Error::Region`] for a parameter without levels, [`Error::TooManyCells`], and those of
    /// [`Settings::validate`].
    pub fn new(region: &Region, settings: Settings) -> Result<Self, Error> {
        settings.validate(region)?;
        let cells = Cells::of(region)?;
        let retained = RetainedSet::full(cells.n_cells());
        let (history, surfaces) = (Vec::new(), Vec::new());
        let (failed_cells, earlier) = (BTreeSet::new(), Vec::new());
        Ok(Self { cells, settings, retained, history, surfaces, open: None, failed_cells, earlier })
    }

    /// The experiments to run now.
    ///
    /// While trials are outstanding it returns those not yet told, and the simulation is not called.
    /// Otherwise it opens the next iteration: both designs are searched for, the simulations are run, and
    /// the experiments are handed out, N_E of them.
    ///
    /// `simulation` maps a natural point to a cost or to the reason why there is none; failures are
    /// survived and reported, as long as those that succeed determine the surface.
    ///
    /// # Errors
    ///
    /// [`Error::EverySimulationFailed`], [`Error::TooFewSimulations`]. The state is then as before, but for a note of
    /// the cells that failed: the next call simulates elsewhere, until the other cells no longer support the model,
    /// and then begins anew. So whatever was wrong with the simulation, mend it and ask again, or just ask again.
    pub fn ask(&mut self, simulation: &mut impl FnMut(&[f64]) -> Result<f64, String>) -> Result<Ask, Error> {
        if let Some(reason) = self.stop() {
            return Ok(Ask::Stopped(reason));
        }
        if self.open.is_none() {
            let open = self.begin(simulation)?;
            self.hand_out(open)?;
        }
        Ok(Ask::Trials(self.outstanding()))
    }

    /// The cells that the next iteration experiments and simulates on: the first half of [`ask`](Self::ask), for
    /// callers who run many simulations at once, or who write the designs down before they begin. Nothing while trials
    /// are outstanding, and after the end.
    ///
    /// # Errors
    ///
    /// [`Error::Region`] if the searches find no design.
    pub fn plan(&self) -> Result<Option<Plan>, Error> {
        if self.open.is_some() || self.stop().is_some() {
            return Ok(None);
        }
        self.plan_in(&self.design_space()?).map(Some)
    }

    /// Opens the next iteration with these designs: the second half of [`ask`](Self::ask). `simulation` is called once per
    /// simulation of the plan, in its order, and may look up what has been run before.
    ///
    /// The designs need not be those of [`plan`](Self::plan): any cells that are left will do, in the numbers of the
    /// settings. So a campaign is followed again from its notes without searching.
    ///
    /// # Errors
    ///
    /// [`Error::Plan`], and those of [`ask`](Self::ask), with the same consequence.
    pub fn open(
        &mut self,
        plan: &Plan,
        simulation: &mut impl FnMut(&[f64]) -> Result<f64, String>,
    ) -> Result<Vec<Trial>, Error> {
        let wrong = |expected| Error::Plan { iteration: self.iteration(), expected };
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

    fn hand_out(&mut self, open: OpenIteration) -> Result<(), Error> {
        if let Err(error) = self.check_simulations(&open) {
            self.avoid(open.failed_cells());
            return Err(error);
        }
        self.failed_cells.clear();
        self.open = Some(open);
        Ok(())
    }

    /// An experiment made outside the campaign, at these natural settings. From the iteration that is open or comes
    /// next it counts as one more training experiment of every iteration at whose onset the nearest cell is left;
    /// it never validates. Designs do not know of it.
    ///
    /// # Errors
    ///
    /// [`Error::Region`] for a wrong number of settings, [`Error::EarlierSetting`] for one more than half a parameter's
    /// width outside its bounds, [`Error::Setting`] for a cost that is not finite.
    pub fn add_earlier(&mut self, point: &[f64], cost: f64, source: impl Into<String>) -> Result<(), Error> {
        let since = self.iteration();
        let earlier = EarlierExperiment { point: point.to_vec(), cost, source: source.into(), since, until: None };
        earlier.check(self.cells.region())?;
        self.earlier.push(earlier);
        Ok(())
    }

    /// Stops using the [earlier](Self::add_earlier) experiments from this source, from the iteration that is open or comes next
    /// on. Iterations that rest on them stand. How many were in use.
    pub fn withdraw_earlier(&mut self, source: &str) -> usize {
        let iteration = self.iteration();
        let mut n_withdrawn = 0;
        for earlier in self.earlier.iter_mut().filter(|earlier| earlier.source == source && earlier.until.is_none()) {
            earlier.until = Some(iteration);
            n_withdrawn += 1;
        }
        n_withdrawn
    }

    /// The experiments made outside the campaign.
    #[must_use]
    pub fn earlier(&self) -> &[EarlierExperiment] {
        &self.earlier
    }

    /// Those of them that count in the iteration that is open or comes next.
    fn earlier_observations(&self) -> Result<Observations, Error> {
        let mut observations = Observations::none(self.cells.n_factors());
        for earlier in self.earlier.iter().filter(|earlier| earlier.counts_in(self.iteration())) {
            let inside = self.region().clamp(&earlier.point)?;
            if self.is_retained(self.cells.nearest(&inside)?) {
                observations.add_simulation(&self.region().coded(&earlier.point)?, earlier.cost)?;
            }
        }
        Ok(observations)
    }

    /// The outcome of an outstanding trial, at the settings asked for.
    ///
    /// The last outcome of an iteration closes it: surfaces are fitted, the correction is updated, cells are dropped,
    /// and the iteration appears in [`reports`](Self::reports). The order of telling does not matter.
    ///
    /// # Errors
    ///
    /// [`Error::UnknownTrial`], [`Error::AlreadyTold`], [`Error::NonFiniteOutcome`]; [`Error::Surface`] if a cost, or a
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
    /// Those of [`tell`](Self::tell), [`Error::Region`] for a wrong number of settings, and [`Error::ActualSettingOf`].
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

    /// The parameters and their levels.
    #[must_use]
    pub fn region(&self) -> &Region {
        self.cells.region()
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

    /// The surfaces of the closed iterations, first to last.
    #[must_use]
    pub fn surfaces(&self) -> &[IterationSurfaces] {
        &self.surfaces
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
        if self.open.is_some() { None } else { last.stop(&self.settings) }
    }

    /// What is left of the grid.
    #[must_use]
    pub fn retained(&self) -> &RetainedSet {
        &self.retained
    }

    /// M_i, what was left at the onset of iteration i from 1: recomputed from the surfaces of the iterations before.
    /// None beyond the iteration that is open or comes next.
    #[must_use]
    pub fn retained_at(&self, iteration: usize) -> Option<RetainedSet> {
        if !(1..=self.iteration()).contains(&iteration) {
            return None;
        }
        let closed = self.history.iter().zip(&self.surfaces).take(iteration - 1);
        let full = RetainedSet::full(self.cells.n_cells());
        Some(
            closed.fold(full, |left, (report, surfaces)| {
                reduced(&left, &self.cells, &report.screening, &surfaces.combined)
            }),
        )
    }

    /// Whether this cell is still in the running.
    #[must_use]
    pub fn is_retained(&self, cell: u64) -> bool {
        self.retained.contains(cell)
    }

    /// A norm (42) of a surface over M_i, i from 1, cells measured in coordinates coded to the original box. Nothing is
    /// stored per cell, and the number of threads changes no bit.
    ///
    /// # Errors
    ///
    /// [`Error::SettingCount`] for an iteration beyond the one that is open or comes next, [`Error::WrongLength`] for a
    /// surface with another number of factors, [`Error::Entry`] with the first cell at which it is not finite,
    /// [`Error::Setting`] if the norm itself is too large for a double.
    pub fn norm_over(&self, iteration: usize, surface: &dyn Surface, norm: Norm) -> Result<f64, Error> {
        let k = self.cells.n_factors();
        crate::problem::check_length("surface", k, surface.n_factors())?;
        let expected = "1 to that of the iteration that is open or comes next";
        let absent = Error::SettingCount { name: "iteration", value: iteration, expected };
        let cell = coded_cell_measure(k, usize::try_from(self.cells.n_cells()).unwrap_or(usize::MAX))?;
        let region = self.retained_at(iteration).ok_or(absent)?;
        region.norm(self.cells.points(), surface, norm, cell)
    }

    /// What `eps` promises of the optimum p̂* of the last closed iteration, with the corrected model Ĵnum of that
    /// iteration, over what it left: eps must bound |Ĵnum − J_true| there, in the sup norm. None before the
    /// first iteration is closed.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] for an `eps` that is negative, NaN or infinite.
    pub fn certificate(&self, eps: f64) -> Result<Option<RegretCertificate>, Error> {
        let Some((report, surfaces)) = self.history.last().zip(self.surfaces.last()) else {
            return Ok(None);
        };
        let (model, cell) = (surfaces.numerical.surface(), report.screening.optimum_cell);
        let least_other = self.retained.minimum_but(Some(cell), self.cells.points(), model);
        let least_other = least_other.map_or(f64::INFINITY, |least| least.value);
        RegretCertificate::of_cell_among(model.predict(&self.cells.coded(cell)?), least_other, eps).map(Some)
    }

    /// The cells left that may still be the best of them, if `eps` bounds |Ĵnum − J_true| as for the
    /// [`certificate`](Self::certificate): how many, and which. None before the first iteration is closed.
    ///
    /// # Errors
    ///
    /// As [`certificate`](Self::certificate).
    pub fn possible_optima(&self, eps: f64) -> Result<Option<RetainedSet>, Error> {
        check_not_negative("eps", eps)?;
        let (points, mut possible) = (self.cells.points(), self.retained.clone());
        let Some(model) = self.surfaces.last().map(|surfaces| surfaces.numerical.surface()) else {
            return Ok(None);
        };
        if let Some(least) = possible.minimum(points, model) {
            possible.retain(points, model, |value| value.is_nan() || value - least.value <= 2.0 * eps);
        }
        Ok(Some(possible))
    }

    /// When and why a cell was dropped, from the surfaces of that iteration; none if it was not, or is no cell.
    #[must_use]
    pub fn why_dropped(&self, cell: u64) -> Option<Dropped> {
        let point = self.cells.coded(cell).ok()?;
        self.history.iter().zip(&self.surfaces).find_map(|(report, surfaces)| {
            let screening = &report.screening;
            let (spread, value) = (screening.tested_spread()?, surfaces.combined.surface().predict(&point));
            let (optimum_value, iteration) = (screening.optimum_value, report.iteration);
            let z = z(value, optimum_value, spread);
            let z0 = screening.threshold;
            (!screening.keeps(value)).then_some(Dropped { iteration, value, optimum_value, spread, z, z0 })
        })
    }

    /// Settings of a cell, natural.
    ///
    /// # Errors
    ///
    /// [`Error::Region`] for a cell outside the grid.
    pub fn point(&self, cell: u64) -> Result<Vec<f64>, Error> {
        self.cells.natural(cell)
    }

    /// Settings of a cell, coded to the original box: where to evaluate [`surfaces`](Self::surfaces).
    ///
    /// # Errors
    ///
    /// [`Error::UnknownCell`].
    pub fn coded(&self, cell: u64) -> Result<Vec<f64>, Error> {
        self.cells.coded(cell)
    }

    /// The cell nearest to a natural point.
    ///
    /// # Errors
    ///
    /// [`Error::Region`] for a point outside the region.
    pub fn cell(&self, point: &[f64]) -> Result<u64, Error> {
        self.cells.nearest(point)
    }

    /// Number of the iteration that is open or comes next, from 1.
    pub(crate) fn iteration(&self) -> usize {
        self.history.len() + 1
    }

    /// How many trials the closed iterations handed out.
    pub(crate) fn n_asked(&self) -> u64 {
        self.history.iter().map(|report| report.trials.len() as u64).sum()
    }

    /// The correction learned so far: Ĵcor of the last closed iteration.
    fn correction(&self) -> Result<TracedSurface, Error> {
        match self.surfaces.last() {
            Some(surfaces) => Ok(surfaces.correction.clone()),
            None => TracedSurface::combination(self.cells.n_factors(), []),
        }
    }

    /// The correction after one more iteration; unchanged without its experiments.
    fn correction_with(
        &self,
        experiment: Option<&TracedSurface>,
        simulation: &TracedSurface,
    ) -> Result<TracedSurface, Error> {
        let Some(experiment) = experiment else {
            return self.correction();
        };
        let past = self.surfaces.iter().filter_map(|past| Some((past.experiment.as_ref()?, &past.simulation)));
        let (experiments, simulations): (Vec<_>, Vec<_>) = past.chain([(experiment, simulation)]).unzip();
        correction(self.settings.correction, self.cells.n_factors(), &experiments, &simulations)
    }

    /// Notes cells for the next design to avoid. A noted cell among them says that it could not be avoided.
    fn avoid(&mut self, failed: BTreeSet<u64>) {
        if !self.failed_cells.is_disjoint(&failed) {
            self.failed_cells.clear();
        }
        self.failed_cells.extend(failed);
    }

    /// Whether the simulations that succeeded determine their surface.
    pub(crate) fn check_simulations(&self, open: &OpenIteration) -> Result<(), Error> {
        let n_simulations = open.simulations.len();
        let failures = || {
            let failed = |record: &crate::global::SimulationRecord| match &record.outcome {
                Outcome::Failed { reason } => Some((record.point.clone(), reason.clone())),
                Outcome::Value(_) => None,
            };
            open.simulations.iter().filter_map(failed)
        };
        let n_failed = failures().count();
        if n_failed == n_simulations {
            let (first_point, first_reason) = failures().next().unwrap_or_default();
            return Err(Error::EverySimulationFailed { n_simulations, first_point, first_reason });
        }
        let kind = self.settings.surfaces.simulation.with_model(&open.batch.model(&self.settings)?);
        match TracedSurface::fit(&kind, &simulated(&open.simulations, &self.cells)?) {
            Err(Error::Surface(reason)) if n_failed > 0 => {
                Err(Error::TooFewSimulations { n_failed, n_simulations, reason })
            }
            result => result.map(|_| ()),
        }
    }

    fn record(&mut self, id: TrialId, actual: Option<Vec<f64>>, outcome: Outcome) -> Result<(), Error> {
        let n_asked = self.n_asked();
        let absent =
            if (1..=n_asked).contains(&id.number()) { Error::AlreadyTold { id } } else { Error::UnknownTrial { id } };
        let Some(mut open) = self.open.clone() else {
            return Err(absent);
        };
        let mut records = open.trials.iter_mut();
        let Some(record) = records.find(|record| record.trial.id == id) else {
            return Err(absent);
        };
        record.tell(actual, outcome, self.cells.region())?;
        if open.is_complete() {
            let closed = self.finish(open)?;
            self.close(closed);
        } else {
            self.open = Some(open);
        }
        Ok(())
    }

    pub(crate) fn close(&mut self, closed: Closed) {
        let Closed { report, surfaces, retained } = closed;
        self.history.push(report);
        self.surfaces.push(surfaces);
        self.retained = retained;
        self.open = None;
    }
}

/// Everything else follows from these.
impl PartialEq for Loop {
    fn eq(&self, other: &Self) -> bool {
        self.region() == other.region()
            && self.settings == other.settings
            && self.history == other.history
            && self.open == other.open
            && self.failed_cells == other.failed_cells
            && self.earlier == other.earlier
    }
}
