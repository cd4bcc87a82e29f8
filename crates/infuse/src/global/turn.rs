//! One turn of Figures 4 and 19.

use std::collections::BTreeSet;

use design_space::Cell;

use crate::Error;
use crate::correction::{corrected_model, correction};
use crate::global::batch::{DesignSpace, Purpose};
use crate::global::campaign::Loop;
use crate::global::changes::SurfaceChanges;
use crate::global::experience::{n_new, validate_where_new};
use crate::global::fits::{BatchData, unless_data_are_few};
use crate::global::open_batch::{OpenBatch, Simulation, simulated, trials};
use crate::global::plan::Plan;
use crate::global::report::Report;
use crate::global::retained::RetainedSet;
use crate::global::screening::{Screening, threshold};
use crate::global::spread::Spread;
use crate::global::surfaces::BatchSurfaces;
use crate::global::trial::TrialUse;
use crate::traced::{Observations, TracedSurface};

/// What the lower half of a turn gives.
#[derive(Debug)]
pub(crate) struct Closed {
    pub(crate) report: Report,
    pub(crate) surfaces: BatchSurfaces,
    pub(crate) retained: RetainedSet,
}

/// The turn.
impl Loop {
    /// The upper half of the figure, up to the experiments: they wait for whoever has the rig.
    pub(super) fn begin(&self, simulation: &mut Simulation<'_>) -> Result<OpenBatch, Error> {
        // 5.1: G-optimal experiments and simulations (29) over the cells that are left.
        let space = self.design_space()?;
        let plan = self.plan_in(&space)?;
        // 5.2: the simulations.
        self.open_in(&space, &plan, simulation)
    }

    /// The lower half, with the outcomes of all experiments.
    pub(super) fn finish(&self, open: OpenBatch) -> Result<Closed, Error> {
        let unseen = self.unseen(&self.history, open.trials.records())?;
        let data = BatchData::of(&open, &self.earlier_observations()?, &unseen, &self.cells, self.settings())?;
        // 5.3: surfaces (30) to (34) of the experiments, of the simulations, and of both combined,
        // the simulations corrected (35) by what the batches before have taught: see 7.1.
        let experiment = data.experiment_surface();
        let simulation = data.simulation_surface()?;
        let combined = data.combined_surface(&self.correction()?)?;
        // 5.4: the correction (36), by the law of the settings, and the corrected model (35), for the next batch.
        let (experiment, not_corrected) = unless_data_are_few(experiment)?;
        let correction = self.correction_with(experiment.as_ref(), &simulation)?;
        let numerical = corrected_model(&simulation, &correction)?;
        let surfaces = BatchSurfaces { experiment, simulation, combined, correction, numerical };
        let changes = SurfaceChanges::between(self.surfaces.last(), &surfaces, &self.retained, &self.cells)?;
        // 5.5: the optimum, the quality of fit S (40), and the test (37) to (39) of every cell against the optimum:
        // what is worse beyond doubt is dropped.
        let spread = Spread::of(&surfaces.combined, &data.unseen, self.settings().fallback)?;
        let left = self.without_failed(&self.retained, &self.history, open.trials.records())?;
        let (screening, retained) = self.screen(&left, &surfaces, spread)?;
        let report = Report {
            number: self.batch(),
            batch: open.batch,
            simulations: open.simulations,
            trials: open.trials.into_records(),
            n_earlier: data.n_earlier,
            screening,
            not_corrected,
            changes,
        };
        Ok(Closed { report, surfaces, retained })
    }
}

/// Its steps.
impl Loop {
    pub(super) fn design_space(&self) -> Result<DesignSpace<'_>, Error> {
        DesignSpace::of(&self.retained, &self.cells, &self.settings, self.batch())
    }

    pub(super) fn plan_in(&self, space: &DesignSpace) -> Result<Plan, Error> {
        let settings = &self.settings;
        let experiments = space.design(settings.n_experiments, Purpose::Experiments, &BTreeSet::new())?;
        Ok(Plan {
            experiments: self.with_new_cells(space, experiments)?,
            simulations: space.design(settings.n_simulations, Purpose::Simulations, &self.failed_cells)?,
        })
    }

    /// These experiments. In a careful campaign, if they have too few new cells to validate with, a design of cells that were
    /// not run, as long as enough of those are left.
    fn with_new_cells(&self, space: &DesignSpace, experiments: Vec<Cell>) -> Result<Vec<Cell>, Error> {
        let settings = &self.settings;
        if !settings.careful {
            return Ok(experiments);
        }
        let run = self.experience_of(&self.history)?.run();
        if run.is_empty() {
            return Ok(experiments);
        }
        let new = |experiments: &[Cell]| Ok::<_, Error>(n_new(experiments, &self.uses(space, experiments)?, &run));
        let uses = space.uses(&experiments)?;
        let n_validation = uses.iter().filter(|&&used| used == TrialUse::Validation).count();
        let distinct = settings.n_experiments - settings.replicates;
        if new(&experiments)? >= n_validation || space.n_candidates_but(&run) < distinct {
            return Ok(experiments);
        }
        let others = space.design(settings.n_experiments, Purpose::Experiments, &run)?;
        Ok(if new(&others)? > new(&experiments)? { others } else { experiments })
    }

    /// What the experiments at these cells are used for, in their order.
    pub(super) fn uses(&self, space: &DesignSpace, experiments: &[Cell]) -> Result<Vec<TrialUse>, Error> {
        let uses = space.uses(experiments)?;
        if !self.settings.careful {
            return Ok(uses);
        }
        Ok(validate_where_new(experiments, &uses, &self.experience_of(&self.history)?.run()))
    }

    /// Training and validation, the simulations, and the trials.
    pub(super) fn open_in(
        &self,
        space: &DesignSpace,
        plan: &Plan,
        simulation: &mut Simulation<'_>,
    ) -> Result<OpenBatch, Error> {
        let Plan { experiments, simulations } = plan;
        let uses = self.uses(space, experiments)?;
        let batch = space.batch(experiments, simulations)?;
        let simulated = simulations.iter().map(|&cell| simulated(cell, &self.cells, simulation));
        let simulations = simulated.collect::<Result<_, _>>()?;
        let trials = trials(experiments, &uses, &self.cells, self.batch(), self.n_asked())?;
        Ok(OpenBatch { batch, simulations, trials })
    }

    /// The experiments made outside the campaign that count in the batch that is open or comes next.
    fn earlier_observations(&self) -> Result<Observations, Error> {
        let mut observations = Observations::none(self.cells.n_factors());
        for earlier in self.earlier.iter().filter(|earlier| earlier.counts_in(self.batch())) {
            if self.retained.contains(self.grid().nearest_clamped(&earlier.point)?) {
                observations.add_simulation(&self.region().coded(&earlier.point)?, earlier.cost)?;
            }
        }
        Ok(observations)
    }

    /// The correction learned so far: Ĵcor of the last closed batch.
    fn correction(&self) -> Result<TracedSurface, Error> {
        match self.surfaces.last() {
            Some(surfaces) => Ok(surfaces.correction.clone()),
            None => TracedSurface::combination(self.cells.n_factors(), []),
        }
    }

    /// The correction after one more batch; unchanged without its experiments. A batch whose experiments could not be
    /// fitted is no step of it.
    fn correction_with(
        &self,
        experiment: Option<&TracedSurface>,
        simulation: &TracedSurface,
    ) -> Result<TracedSurface, Error> {
        let Some(experiment) = experiment else {
            return self.correction();
        };
        let past = self.surfaces.iter().filter_map(|past| Some((past.experiment.as_ref()?, &past.simulation)));
        correction(self.settings.correction, self.cells.n_factors(), past.chain([(experiment, simulation)]))
    }

    /// The optimum of the combined surface among these cells, and those of them that are not worse beyond doubt.
    fn screen(
        &self,
        left: &RetainedSet,
        surfaces: &BatchSurfaces,
        spread: Spread,
    ) -> Result<(Screening, RetainedSet), Error> {
        let points = self.cells.points();
        let minimum = |name, cells: &RetainedSet, surface: &TracedSurface| {
            let minimum = cells.minimum(points, surface.surface());
            minimum.ok_or(Error::NoMinimum { surface: name, batch: self.batch() })
        };
        let optimum = minimum("combined", left, &surfaces.combined)?;
        let simulated = minimum("simulation", &self.retained, &surfaces.simulation)?;
        let n_before = self.retained.n_retained();
        let mut screening = Screening {
            optimum_cell: optimum.cell,
            optimum: self.cells.natural(optimum.cell)?,
            optimum_value: optimum.value,
            simulation_optimum_cell: simulated.cell,
            simulation_optimum: self.cells.natural(simulated.cell)?,
            spread,
            tested: self.batch() >= self.settings.first_screening && self.shows_misfit(surfaces),
            threshold: threshold(self.settings.confidence),
            n_before,
            n_after: n_before,
        };
        let retained = screening.reduced(left, points, &surfaces.combined);
        screening.n_after = retained.n_retained();
        Ok((screening, retained))
    }
}
