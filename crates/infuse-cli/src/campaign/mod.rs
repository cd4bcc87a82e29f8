//! A campaign, whatever its method: what commands ask of it, and what all methods share.

mod changes;
mod experiments;
mod progress;
mod reading;
mod simulations;

use std::collections::BTreeSet;
use std::path::Path;
use std::time::Duration;

use anyhow::{Result, bail};
use design_space::{Cell, Grid};
use infuse::pooled::Trial;
use page::Finding;
use serde_json::Value;

use crate::journal::{Constrained, Event, Journal, Measured, Submitted, Writer};
use crate::problem::Problem;
pub(crate) use changes::changes;
pub(crate) use experiments::Experiments;
pub(crate) use progress::{Progress, busy};
pub(crate) use reading::Reading;
pub(crate) use simulations::{FailedSimulation, checked, failed_in_words, simulate_missing};

/// Where a campaign stands.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Stage {
    /// A batch is to be chosen, or its simulations are to be finished.
    Ready,
    /// Experiments are waited for.
    Pending,
    /// Nothing more is to be done.
    Ended {
        /// In words that follow "Ended: ".
        reason: String,
        /// Whether it has ended only because another batch is not worth it.
        may_go_on: bool,
    },
}

/// What had to be done before experiments could be handed out.
#[derive(Debug, Default)]
pub(crate) struct HandedOut {
    pub(crate) n_simulated: usize,
    pub(crate) notices: Vec<String>,
}

/// How a batch is asked for.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Wish {
    /// Even if it seems not worth it.
    pub(crate) anyway: bool,
    /// Even while experiments are waited for.
    pub(crate) more: bool,
}

/// What a campaign costs at most.
#[derive(Debug, Clone)]
pub(crate) struct Budget {
    /// Of the model, if the method has one.
    pub(crate) terms: Option<usize>,
    /// Per batch.
    pub(crate) experiments: usize,
    pub(crate) batches: usize,
    /// Batches that may still be asked for.
    pub(crate) n_left: usize,
    /// Per batch; nothing where every design is simulated before the first.
    pub(crate) simulations: Option<usize>,
    /// Designs run from which on the certificate holds nothing for a narrow well, if the method's does.
    pub(crate) without_reserve: Option<usize>,
    pub(crate) grid: Grid,
}

/// What the certificate holds for a narrow well.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Reserve {
    /// From so many designs run on it holds nothing.
    pub(crate) until: usize,
    /// As many count as run.
    pub(crate) so_far: f64,
    /// Batches that are left.
    pub(crate) n_left: usize,
}

/// An experiment from before the campaign.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Imported {
    pub(crate) point: Vec<f64>,
    pub(crate) result: Measured,
    /// Of the responses that have to stay within bounds.
    pub(crate) constrained: Constrained,
    pub(crate) source: String,
    /// What a person wrote beside it.
    pub(crate) note: String,
}

impl Imported {
    /// Whether another has its settings and results, too.
    pub(crate) fn is_alike(&self, other: &Self) -> bool {
        (&self.point, &self.result, &self.constrained) == (&other.point, &other.result, &other.constrained)
    }
}

/// What a command may ask of a campaign.
pub(crate) trait Campaign {
    fn folder(&self) -> &Path;
    fn problem(&self) -> &Problem;
    fn experiments(&self) -> &Experiments;
    /// What a person should know about the journal, said once.
    fn take_notices(&mut self) -> Vec<String>;
    /// Writes these events down, all or none, and lets them happen.
    fn record(&mut self, writer: &mut Writer, events: Vec<Event>) -> Result<()>;
    fn stage(&self) -> Result<Stage>;
    fn n_closed(&self) -> usize;
    /// Brings the campaign to the point where experiments are waited for, or to its end.
    fn hand_out(&mut self, writer: &mut Writer, wish: Wish) -> Result<HandedOut>;
    /// Why the experiments of a new batch were chosen.
    fn purpose(&self, batch: usize) -> Finding;
    /// What is allowed instead, if the result of this experiment may not be told or replaced any more.
    fn refusal(&self, trial: &Trial) -> Option<String>;
    /// What it costs at most.
    fn budget(&self) -> Result<Budget>;
    /// What the certificate holds for a narrow well, if the method's does.
    fn reserve(&self) -> Result<Option<Reserve>> {
        Ok(None)
    }
    /// How long it takes to choose a batch, tried on results made up; none where that is not tried.
    fn dry_pick(&self) -> Result<Option<Duration>> {
        Ok(None)
    }
    /// Runs that were handed to a queue.
    fn submitted(&self) -> &[Submitted];
    /// What the simulator, as it is now, gave so far, if it is a command.
    fn simulations_made(&self) -> Vec<Measured>;
    /// How many simulations the campaign waits for.
    fn waits_for_simulations(&self) -> Result<BTreeSet<Cell>>;
    /// The experiments from before the campaign that are in use.
    fn imported(&self) -> Vec<Imported>;
    /// Of the runs so far, imported ones too, their number and why the first gave no value, if none gave one.
    fn nothing_but_failures(&self) -> Option<(usize, String)> {
        let (imported, experiments) = (self.imported(), self.experiments());
        let of_imported = imported.iter().map(|one| &one.result);
        let own = experiments.readings.values().flat_map(|reading| reading.first.iter().chain(reading.again.values()));
        let results: Vec<&Measured> = of_imported.chain(own).collect();
        match results.first()? {
            Measured::Failed(reason) if results.iter().all(|result| result.value().is_none()) => {
                Some((results.len(), reason.clone()))
            }
            _ => None,
        }
    }
    /// From when on, and for what, those count that are imported now.
    fn use_of_imports(&self, n: usize) -> String;
    /// What the last closed batch taught, in short.
    fn lesson(&self) -> Result<Vec<Finding>>;
    /// The recommended design in one sentence, if there is one.
    fn recommendation(&self) -> Result<Option<(Finding, Vec<f64>)>>;
    /// One line about the batch that was closed last.
    fn closed(&self) -> Result<Option<Finding>>;
    /// What is known, in blocks with an empty line between them, beside what a machine is told.
    fn status(&self) -> Result<(Vec<Vec<Finding>>, Value)>;
    /// What is known of one design, given by its settings.
    fn why(&self, asked: &[f64]) -> Result<Finding>;
    /// One HTML page.
    fn page(&self, journal: &Journal) -> Result<String>;
    /// The pictures of the report that a person looks at beside the rig.
    fn pictures(&self) -> Result<String>;
    /// What is expected of a design, given by its settings.
    fn what_if(&self, _asked: &[f64]) -> Result<(Vec<Finding>, Value)> {
        bail!("`infuse what-if` needs `method` = \"pooled\"")
    }
    /// The same of designs all over the grid, as a table.
    fn what_if_over_the_grid(&self, _path: &Path) -> Result<(Vec<Finding>, Value)> {
        bail!("`infuse what-if` needs `method` = \"pooled\"")
    }
    /// Whether there is something to confirm.
    fn may_confirm(&self) -> bool {
        false
    }
    /// Whether the last batch was made to confirm.
    fn is_confirmed(&self) -> bool {
        false
    }
    /// Plans so many runs each of the designs that are to be compared.
    fn confirm(&mut self, _writer: &mut Writer, _runs: usize) -> Result<()> {
        bail!("`infuse confirm` needs `method` = \"pooled\"")
    }
}
