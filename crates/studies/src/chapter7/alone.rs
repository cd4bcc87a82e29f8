//! Experiments without a model: as many as the loop makes, in one batch, and one regression on them.

use anyhow::{Context as _, Result};
use design_space::Cell;
use doe::{Criterion, Effort, Problem};
use infuse::{
    Outcome, TrialId,
    global::{self, Observations, TracedSurface, TrialUse},
};
use surface::{Confounded, GridPoints, Kind};

use crate::gridded::StandInRig;

/// Experiments without a model: one batch and one surface.
#[derive(Debug)]
pub(super) struct Alone {
    kind: Kind,
    trials: Vec<global::Trial>,
}

impl Alone {
    pub(super) fn design(rig: &StandInRig<'_>, settings: &global::Settings) -> Result<Self> {
        let region = rig.space.region();
        let space = doe::Space::of_region(region)?;
        let n_runs = settings.max_batches * settings.n_experiments;
        let problem = Problem::new(settings.model.clone(), space, n_runs, Criterion::G)?;
        let mut search = doe::Settings::default();
        search.seed = settings.seed;
        search.starts = settings.design_starts;
        search.effort = Effort::Quick;
        let found = doe::search(&problem, &search)?;
        let trials = found.cells.into_iter().zip(1_u64..).map(|(cell, number)| {
            let (id, used_for) = (TrialId::new(number), TrialUse::Training);
            Ok(global::Trial { id, batch: 1, used_for, cell, point: rig.space.point(cell)? })
        });
        let kind = Kind::Regression { model: settings.model.clone(), confounded: Confounded::Refuse };
        Ok(Self { kind, trials: trials.collect::<Result<_>>()? })
    }

    pub(super) fn n_experiments(&self) -> usize {
        self.trials.len()
    }

    /// The cell where the regression on these experiments is lowest.
    pub(super) fn lowest(&self, rig: &StandInRig<'_>) -> Result<Cell> {
        let region = rig.space.region();
        let mut measured = Observations::none(region.n_parameters());
        for (trial, outcome) in self.trials.iter().zip(rig.measure(&self.trials)?) {
            if let Outcome::Value(cost) = outcome {
                measured.add_experiment(trial.id, &rig.space.coded(trial.cell)?, cost)?;
            }
        }
        let surface = TracedSurface::fit(&self.kind, &measured)?;
        let points = GridPoints::of_space(&doe::Space::of_region(region)?)?;
        let lowest = surface.surface().minimum_over(&points)?.context("the regression is nowhere a number")?;
        Ok(Cell::new(lowest.index))
    }
}
