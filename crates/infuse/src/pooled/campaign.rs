//! A campaign of the pooled loop: what it holds, and what can be read of it.

use std::collections::{BTreeMap, BTreeSet};

use design_space::{Cell, Grid, Region};
use serde::{Deserialize, Serialize};

use crate::pooled::certificate::designs_without_reserve;
use crate::pooled::designs::Designs;
use crate::pooled::reason::Reason;
use crate::pooled::settings::Settings;
use crate::pooled::simulated::Simulated;
use crate::pooled::streams::{Purpose, stream};
use crate::{Error, Outcome, TrialId};

/// An experiment to run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Trial {
    /// Number under which its outcome is reported.
    pub id: TrialId,
    /// Batch it belongs to, from 1.
    pub batch: usize,
    /// The cell.
    pub cell: Cell,
    /// Settings, natural coordinates.
    pub point: Vec<f64>,
}

/// A trial with what is known of it; `actual` holds the settings really made, natural.
pub type Record = crate::Record<Trial, Vec<f64>>;

/// An experiment that was made outside of the campaign.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Earlier {
    /// Its settings, natural; not necessarily on the grid.
    pub point: Vec<f64>,
    /// The response that it gave, or why it gave none.
    pub outcome: Outcome,
    /// Its constrained responses, in the order of the constraints, as far as they were measured.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub constrained: Vec<Option<f64>>,
    /// Where it comes from, in the experimenter's own words.
    pub source: String,
}

/// Optimization by experiments, with all of them and the simulation in one surface.
///
/// All that it says follows from the readings, the simulated responses and the settings, in whatever order they came; nothing
/// is forgotten and nothing dropped for good.
#[derive(Debug, Clone)]
pub struct Loop {
    pub(super) designs: Designs,
    pub(super) settings: Settings,
    pub(super) records: Vec<Record>,
    pub(super) earlier: Vec<Earlier>,
    pub(super) simulated: Simulated,
    /// Why each trial was asked for that the loop chose.
    pub(super) reasons: BTreeMap<TrialId, Reason>,
    /// Cells to simulate before the next batch.
    pub(super) due: Vec<Cell>,
    /// The constrained responses of trials, as far as they were measured.
    pub(super) constrained: BTreeMap<TrialId, Vec<Option<f64>>>,
    /// Designs that nobody can build.
    pub(super) refused: BTreeSet<Cell>,
}

impl Loop {
    /// A campaign that has not begun, over this region.
    ///
    /// # Errors
    ///
    /// [`Error::DesignSpace`] for 2⁶⁴ designs or more, by levels alone, [`Error::NoDesignAllowed`], [`Error::Surface`] for more factors than a
    /// surface can have, and those of [`Settings::validate`].
    pub fn new(region: &Region, settings: Settings) -> Result<Self, Error> {
        settings.validate(region)?;
        let mut rng = stream(settings.seed, Purpose::Designs, 0);
        let designs = Designs::of(region, &settings.linear_constraints, &mut rng)?;
        // The surface has a limit, which is said before anything is run.
        designs.places(&[])?;
        Ok(Self {
            designs,
            settings,
            records: Vec::new(),
            earlier: Vec::new(),
            simulated: Simulated::default(),
            reasons: BTreeMap::new(),
            due: Vec::new(),
            constrained: BTreeMap::new(),
            refused: BTreeSet::new(),
        })
    }

    /// The settings.
    #[must_use]
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Goes on with other settings from the next batch on.
    ///
    /// # Errors
    ///
    /// Those of [`Settings::validate`], [`Error::NoDesignAllowed`]; the settings are then as before.
    pub fn set_settings(&mut self, settings: Settings) -> Result<(), Error> {
        settings.validate(self.region())?;
        if settings.linear_constraints != self.settings.linear_constraints {
            let mut rng = stream(settings.seed, Purpose::Designs, 0);
            self.designs.keep_to(&settings.linear_constraints, &mut rng)?;
        }
        if settings.simulations.is_none() {
            self.due.clear();
        }
        self.settings = settings;
        Ok(())
    }

    /// The parameters.
    #[must_use]
    pub fn region(&self) -> &Region {
        self.designs.region()
    }

    /// The designs: every combination of levels, a continuous parameter having 1001 of them, or as many fewer as it takes to
    /// count the designs.
    #[must_use]
    pub fn grid(&self) -> &Grid {
        self.designs.grid()
    }

    /// From so many designs run on, a repeat counting half, the certificate holds nothing in reserve for a narrow well; none if it never
    /// does, because the response is [known](Settings::smooth) to have none or there are
    /// no more designs than a quadratic has terms.
    #[must_use]
    pub fn designs_without_reserve(&self) -> Option<usize> {
        let enough = || designs_without_reserve(self.region().n_parameters(), self.designs.n_allowed());
        (!self.settings.smooth && !self.designs.are_few()).then(enough)
    }

    /// Every trial so far, with its outcome if there is one.
    #[must_use]
    pub fn records(&self) -> &[Record] {
        &self.records
    }

    /// The experiments made outside of the campaign.
    #[must_use]
    pub fn earlier(&self) -> &[Earlier] {
        &self.earlier
    }

    /// Number of cells that were simulated.
    #[must_use]
    pub fn n_simulated(&self) -> usize {
        self.simulated.len()
    }

    /// Cells to simulate before the next batch, where simulations are dear; ascending.
    #[must_use]
    pub fn due(&self) -> &[Cell] {
        &self.due
    }

    /// The trials without an outcome.
    #[must_use]
    pub fn outstanding(&self) -> Vec<Trial> {
        self.records.iter().filter(|record| record.outcome.is_none()).map(|record| record.trial.clone()).collect()
    }

    /// Number of the last batch, 0 before the first.
    #[must_use]
    pub fn batch(&self) -> usize {
        self.records.last().map_or(0, |record| record.trial.batch)
    }

    /// Number of the last batch of which something was told: what is drawn at random follows from it, so that a batch that is but
    /// planned changes nothing of what is said.
    pub(super) fn told_batch(&self) -> usize {
        self.records.iter().rfind(|record| record.outcome.is_some()).map_or(0, |record| record.trial.batch)
    }

    /// Why the loop asked for a trial; none for one that the experimenter wanted, or that was handed out by its cell.
    #[must_use]
    pub fn reason(&self, id: TrialId) -> Option<Reason> {
        self.reasons.get(&id).copied()
    }

    /// The constrained responses of a trial, in the order of the constraints, as far as they were measured.
    #[must_use]
    pub fn constrained(&self, id: TrialId) -> &[Option<f64>] {
        self.constrained.get(&id).map_or(&[], Vec::as_slice)
    }

    /// Whether a constrained response was measured or simulated anywhere.
    #[must_use]
    pub fn has_constrained(&self) -> bool {
        let is_there = |values: &[Option<f64>]| !values.is_empty();
        self.constrained.values().any(|values| is_there(values))
            || self.earlier.iter().any(|earlier| is_there(&earlier.constrained))
            || self.simulated.all().any(|(_, responses)| responses.is_some_and(|one| is_there(&one.constrained)))
    }

    /// Whether a cell keeps to the linear constraints, and was not refused.
    #[must_use]
    pub fn allows(&self, cell: Cell) -> bool {
        self.designs.allows(cell) && !self.refused.contains(&cell)
    }
}
