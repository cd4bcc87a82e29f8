//! Campaigns of the dissertation's loop on flown cells.

use anyhow::Result;
use design_space::Cell;
use infuse::{
    Outcome, TrialId,
    global::{self, Plan},
};
use water_channel::BoundedNoise;

use super::cell_costs::CellCosts;
use super::designs::Designs;
use super::space::Space;
use crate::costs::Cost;

/// A simulation and an experiment of the stand-in with noise, both on the cells of a space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StandInRig<'a> {
    pub(crate) space: &'a Space,
    pub(crate) model: &'a dyn CellCosts,
    pub(crate) truth: &'a dyn CellCosts,
    /// Largest error of an experiment, as a part of the range of the truth.
    pub(crate) noise: f64,
    pub(crate) seed: u64,
}

impl StandInRig<'_> {
    pub(crate) fn simulate(&self, cell: Cell) -> Cost {
        self.model.cost(cell)
    }

    /// What these experiments read: the truth and an error, uniform and bounded, that depends on nothing but the number
    /// of the experiment and the seed.
    pub(crate) fn measure(&self, trials: &[global::Trial]) -> Result<Vec<Outcome>> {
        self.measure_at(&trials.iter().map(|trial| (trial.id, trial.cell)).collect::<Vec<_>>())
    }

    /// The same for experiments of any loop: their numbers and cells.
    pub(crate) fn measure_at(&self, experiments: &[(TrialId, Cell)]) -> Result<Vec<Outcome>> {
        let noise = BoundedNoise::new(self.noise, self.seed)?;
        let range = self.truth.range();
        let cells: Vec<Cell> = experiments.iter().map(|(_, cell)| *cell).collect();
        let costs = self.truth.costs(&cells);
        let read = |((id, _), cost): (&(TrialId, Cell), Cost)| {
            cost.map(|cost| cost + range * noise.relative_error(id.number())).into()
        };
        Ok(experiments.iter().zip(costs).map(read).collect())
    }
}

/// Campaigns.
impl StandInRig<'_> {
    /// Designs and flies the first batch, which is the same whatever the noise: campaigns that then run side by side find
    /// it.
    pub(crate) fn prepare(&self, settings: &global::Settings, designs: &Designs) -> Result<()> {
        let campaign = global::Loop::new(self.space.region(), settings.clone())?;
        if let Some(Plan { experiments, simulations }) = designs.next(&campaign)? {
            self.model.costs(&simulations);
            self.truth.costs(&experiments);
        }
        Ok(())
    }

    /// Runs a campaign to its end; `iterated` is called after each iteration.
    pub(crate) fn run(
        &self,
        settings: &global::Settings,
        designs: &Designs,
        iterated: impl Fn(usize),
    ) -> Result<global::Loop> {
        let mut campaign = global::Loop::new(self.space.region(), settings.clone())?;
        while let Some(plan) = designs.next(&campaign)? {
            // All at once, so that those that nobody knows fly side by side.
            self.model.costs(&plan.simulations);
            let trials = campaign.open(&plan, &mut |cell, _| self.simulate(cell))?;
            for (trial, outcome) in trials.iter().zip(self.measure(&trials)?) {
                campaign.tell(trial.id, outcome)?;
            }
            iterated(1);
        }
        Ok(campaign)
    }
}
