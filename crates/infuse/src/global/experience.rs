//! What a careful campaign minds: where experiments taught it something, and where they only failed.

use std::collections::{BTreeMap, BTreeSet};

use design_space::Cell;

use crate::global::campaign::Loop;
use crate::global::report::Report;
use crate::global::settings::SurfaceKind;
use crate::global::surfaces::BatchSurfaces;
use crate::global::trial::{TrialRecord, TrialUse};
use crate::traced::TracedSurface;
use crate::{Error, TrialId};

/// Cells by what experiments gave there.
#[derive(Debug, Clone, Default)]
pub(crate) struct Experience {
    /// An experiment gave a response.
    pub(crate) taught: BTreeSet<Cell>,
    /// Experiments were made, and none gave a response.
    pub(crate) failed: BTreeSet<Cell>,
}

impl Experience {
    /// Every cell where an experiment was made.
    pub(crate) fn run(&self) -> BTreeSet<Cell> {
        self.taught.union(&self.failed).copied().collect()
    }

    fn add(&mut self, cell: Cell, gave_response: bool) {
        if gave_response {
            self.failed.remove(&cell);
            self.taught.insert(cell);
        } else if !self.taught.contains(&cell) {
            self.failed.insert(cell);
        }
    }
}

impl Loop {
    /// What the first so many closed batches, and the experiments from outside that count in the batch after them, tell.
    pub(super) fn experience_of(&self, closed: &[Report]) -> Result<Experience, Error> {
        let mut experience = Experience::default();
        for record in closed.iter().flat_map(|report| &report.trials) {
            experience.add(self.cell_of(record)?, record.cost().is_some());
        }
        for earlier in self.earlier.iter().filter(|earlier| earlier.counts_in(closed.len() + 1)) {
            experience.add(self.grid().nearest_clamped(&earlier.point)?, true);
        }
        Ok(experience)
    }

    /// The same with the outcomes of the batch after them.
    pub(super) fn experience_with(&self, closed: &[Report], batch: &[TrialRecord]) -> Result<Experience, Error> {
        let mut experience = self.experience_of(closed)?;
        for record in batch {
            experience.add(self.cell_of(record)?, record.cost().is_some());
        }
        Ok(experience)
    }

    /// The cell where an experiment was really made.
    pub(super) fn cell_of(&self, record: &TrialRecord) -> Result<Cell, Error> {
        match &record.actual {
            Some(actual) => Ok(self.grid().nearest_clamped(actual)?),
            None => Ok(record.trial.cell),
        }
    }

    /// The validation experiments of the batch after these that S comes from: all, in a careful campaign those at cells that
    /// taught its surface nothing.
    pub(super) fn unseen(&self, closed: &[Report], batch: &[TrialRecord]) -> Result<BTreeSet<TrialId>, Error> {
        let of = |wanted: TrialUse| batch.iter().filter(move |record| record.trial.used_for == wanted);
        if !self.settings.careful {
            return Ok(of(TrialUse::Validation).map(|record| record.trial.id).collect());
        }
        let mut taught = self.experience_of(closed)?.taught;
        for record in of(TrialUse::Training).filter(|record| record.cost().is_some()) {
            taught.insert(self.cell_of(record)?);
        }
        let mut unseen = BTreeSet::new();
        for record in of(TrialUse::Validation) {
            if !taught.contains(&self.cell_of(record)?) {
                unseen.insert(record.trial.id);
            }
        }
        Ok(unseen)
    }

    /// Whether the experiments of a batch show by how much the shape of its regressor is wrong: were made at more settings than
    /// it has terms. Taken for granted but in a careful campaign, and of surfaces without a regressor.
    pub(super) fn shows_misfit(&self, surfaces: &BatchSurfaces) -> bool {
        if !self.settings.careful || self.settings.surfaces.experiment != SurfaceKind::Regression {
            return true;
        }
        surfaces.experiment.as_ref().and_then(TracedSurface::regression).is_some_and(|fit| {
            let settings: BTreeSet<Vec<u64>> =
                fit.data().points().map(|point| point.iter().map(|x| (x + 0.0).to_bits()).collect()).collect();
            settings.len() > fit.model().n_terms()
        })
    }
}

/// The same number of validation experiments, at cells that were not run before as far as there are such, all runs of a cell
/// together; of equals those that validated anyway.
pub(crate) fn validate_where_new(experiments: &[Cell], uses: &[TrialUse], run: &BTreeSet<Cell>) -> Vec<TrialUse> {
    let is_validation = |index: &usize| uses[*index] == TrialUse::Validation;
    let n_validation = (0..uses.len()).filter(is_validation).count();
    let mut runs_of: BTreeMap<Cell, Vec<usize>> = BTreeMap::new();
    for (index, &cell) in experiments.iter().enumerate() {
        runs_of.entry(cell).or_default().push(index);
    }
    let mut new: Vec<&Vec<usize>> =
        runs_of.iter().filter(|(cell, _)| !run.contains(cell)).map(|(_, runs)| runs).collect();
    // Whole cells that validated, single runs that did not, then the rest.
    new.sort_by_key(|runs| {
        let validated = runs.iter().filter(|run| is_validation(run)).count();
        (validated < runs.len(), runs.len() - validated, runs[0])
    });
    let mut chosen = BTreeSet::new();
    for runs in new {
        if chosen.len() + runs.len() <= n_validation {
            chosen.extend(runs.iter().copied());
        }
    }
    let (validated, trained): (Vec<usize>, Vec<usize>) =
        (0..uses.len()).filter(|index| !chosen.contains(index)).partition(is_validation);
    let missing = n_validation - chosen.len();
    chosen.extend(validated.into_iter().chain(trained).take(missing));
    let of = |index| if chosen.contains(&index) { TrialUse::Validation } else { TrialUse::Training };
    (0..uses.len()).map(of).collect()
}

/// How many validation experiments of a batch are at cells that teach nothing else.
pub(crate) fn n_new(experiments: &[Cell], uses: &[TrialUse], run: &BTreeSet<Cell>) -> usize {
    let of = |wanted: TrialUse| {
        experiments.iter().zip(uses).filter(move |(_, used)| **used == wanted).map(|(cell, _)| *cell)
    };
    let training: BTreeSet<Cell> = of(TrialUse::Training).collect();
    of(TrialUse::Validation).filter(|cell| !run.contains(cell) && !training.contains(cell)).count()
}
