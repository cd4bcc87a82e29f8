//! Campaigns of the global loop on flown cells, kept on disk iteration by iteration.

use std::fs;
use std::path::PathBuf;

use anyhow::{Context as _, Result};
use design_space::Cell;
use infuse::{Outcome, global};
use water_channel::BoundedNoise;

use super::key::{key, program};
use super::source::CellCosts;
use super::space::Space;
use crate::study::Cost;

/// A simulation and a surrogate experiment with noise, both on the cells of a space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SurrogateRig<'a> {
    pub(crate) space: &'a Space,
    pub(crate) model: &'a dyn CellCosts,
    pub(crate) truth: &'a dyn CellCosts,
    /// Largest error of an experiment, as a part of the range of the truth.
    pub(crate) noise: f64,
    pub(crate) seed: u64,
}

impl SurrogateRig<'_> {
    pub(crate) fn simulate(&self, cell: Cell) -> Cost {
        self.model.cost(usize::try_from(cell.index()).map_err(|error| error.to_string())?)
    }

    /// What these experiments read: the truth and an error, uniform and bounded, that depends on nothing but the number
    /// of the experiment and the seed.
    pub(crate) fn measure(&self, trials: &[global::Trial]) -> Result<Vec<Outcome>> {
        let noise = BoundedNoise::new(self.noise, self.seed)?;
        let range = self.truth.range();
        let cells = trials.iter().map(|trial| Ok(usize::try_from(trial.cell.index())?)).collect::<Result<Vec<_>>>()?;
        let costs = self.truth.costs(&cells);
        let read = |(trial, cost): (&global::Trial, Cost)| {
            cost.map(|cost| cost + range * noise.relative_error(trial.id.number())).into()
        };
        Ok(trials.iter().zip(costs).map(read).collect())
    }
}

/// Where campaigns are kept: one file each, named after everything that it follows from, the program included.
#[derive(Clone, Debug)]
pub(crate) struct Campaigns {
    directory: PathBuf,
}

impl Campaigns {
    pub(crate) fn new(directory: PathBuf) -> Self {
        Self { directory }
    }

    /// Runs a campaign to its end, or what is left of it since it was interrupted. `iterated` hears of every iteration,
    /// remembered ones included.
    pub(crate) fn run(
        &self,
        rig: &SurrogateRig<'_>,
        settings: &global::Settings,
        iterated: impl Fn(usize),
    ) -> Result<global::Loop> {
        self.run_from(rig, &global::Loop::new(rig.space.region(), settings.clone())?, iterated)
    }

    /// The same for a campaign that has perhaps begun: the first batch of runs is the same whatever the noise, and is
    /// designed and simulated once for all.
    pub(crate) fn run_from(
        &self,
        rig: &SurrogateRig<'_>,
        begun: &global::Loop,
        iterated: impl Fn(usize),
    ) -> Result<global::Loop> {
        let path = self.path(rig, begun.settings())?;
        let remembered = fs::read(&path).ok().and_then(|text| serde_json::from_slice::<global::Loop>(&text).ok());
        let mut campaign = remembered.unwrap_or_else(|| begun.clone());
        iterated(campaign.reports().len());
        while let global::Ask::Trials(trials) = campaign.ask(&mut |cell, _| rig.simulate(cell))? {
            for (trial, outcome) in trials.iter().zip(rig.measure(&trials)?) {
                campaign.tell(trial.id, outcome)?;
            }
            rig.model.keep()?;
            rig.truth.keep()?;
            self.save(&path, &campaign).with_context(|| path.display().to_string())?;
            iterated(1);
        }
        Ok(campaign)
    }

    fn path(&self, rig: &SurrogateRig<'_>, settings: &global::Settings) -> Result<PathBuf> {
        let settings = serde_json::to_string(settings)?;
        let region = serde_json::to_string(rig.space.region())?;
        let noise = format!("{} {}", rig.noise, rig.seed);
        let key = key([program()?, &settings, &region, rig.model.key(), rig.truth.key(), &noise]);
        Ok(self.directory.join(format!("{key}.json")))
    }

    /// Whoever is killed while writing leaves the file of the iteration before.
    fn save(&self, path: &PathBuf, campaign: &global::Loop) -> Result<()> {
        fs::create_dir_all(&self.directory)?;
        let unfinished = path.with_extension(format!("{}.tmp", std::process::id()));
        fs::write(&unfinished, serde_json::to_vec(campaign)?)?;
        Ok(fs::rename(&unfinished, path)?)
    }
}
