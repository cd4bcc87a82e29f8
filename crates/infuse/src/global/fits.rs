//! What a batch has measured and simulated, and the surfaces fitted to it: Section 5.3.

use std::collections::BTreeSet;

use design_space::Model;

use crate::global::cells::Cells;
use crate::global::open_batch::OpenBatch;
use crate::global::settings::Settings;
use crate::global::trial::TrialUse;
use crate::traced::{Observations, TracedSurface};
use crate::{Error, TrialId};

/// The data of a batch, with the regressor and the settings of its surfaces.
#[derive(Debug)]
pub(crate) struct BatchData<'a> {
    settings: &'a Settings,
    model: Model,
    /// Training experiments, then those made before the campaign.
    training: Observations,
    validation: Observations,
    /// What S comes from: the validation experiments, in a careful campaign those at new cells.
    pub(crate) unseen: Observations,
    simulations: Observations,
    pub(crate) n_earlier: usize,
}

impl<'a> BatchData<'a> {
    pub(crate) fn of(
        open: &OpenBatch,
        earlier: &Observations,
        unseen: &BTreeSet<TrialId>,
        cells: &Cells,
        settings: &'a Settings,
    ) -> Result<Self, Error> {
        Ok(Self {
            settings,
            model: open.batch.model(settings)?,
            training: open.experiments(TrialUse::Training, cells.region())?.followed_by(earlier)?,
            validation: open.experiments(TrialUse::Validation, cells.region())?,
            unseen: open.those(cells.region(), |trial| unseen.contains(&trial.id))?,
            simulations: open.simulations(cells)?,
            n_earlier: earlier.n_points(),
        })
    }

    /// 5.3, 1: Ĵexp of all experiments, those made before the campaign too.
    pub(crate) fn experiment_surface(&self) -> Result<TracedSurface, Error> {
        let all = self.training.clone().followed_by(&self.validation)?;
        TracedSurface::fit(&self.settings.surfaces.experiment.with_model(&self.model), &all)
    }

    /// 5.3, 2: Ĵsim of the simulations as they are.
    pub(crate) fn simulation_surface(&self) -> Result<TracedSurface, Error> {
        TracedSurface::fit(&self.settings.surfaces.simulation.with_model(&self.model), &self.simulations)
    }

    /// 5.3, 3: Ĵ of training experiments and simulations with this correction added, weighted as in (31).
    pub(crate) fn combined_surface(&self, correction: &TracedSurface) -> Result<TracedSurface, Error> {
        let settings = self.settings;
        let corrected = self.simulations.corrected_by(correction)?;
        let weighted = self.training.clone().weighted(settings.experiment_weight);
        let weighted = weighted.followed_by(&corrected.weighted(settings.simulation_weight))?;
        TracedSurface::fit(&settings.surfaces.combined.with_model(&self.model), &weighted)
    }
}

/// The surface, or why there are too few data for one, or too few different ones. Other errors stay errors.
pub(crate) fn unless_data_are_few(
    fitted: Result<TracedSurface, Error>,
) -> Result<(Option<TracedSurface>, Option<String>), Error> {
    match fitted {
        Ok(surface) => Ok((Some(surface), None)),
        Err(Error::Surface(error)) if is_lack_of_data(&error) => Ok((None, Some(error.to_string()))),
        Err(error) => Err(error),
    }
}

fn is_lack_of_data(error: &surface::Error) -> bool {
    use surface::Error::{Confounded, Count, IllConditioned, TooFewPoints, TooFewSites};
    matches!(error, Count { .. } | TooFewPoints { .. } | Confounded { .. } | IllConditioned { .. } | TooFewSites { .. })
}
