//! The pooled loop on the rig of this chapter, with the budget of the dissertation's loop.

use anyhow::{Context as _, Result, ensure};
use infuse::global;
use infuse::pooled::{Ask, Certificate, Loop, Settings};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::gridded::StandInRig;

/// What it recommends after a batch.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PooledStep {
    /// What the design truly costs.
    pub(crate) cost: f64,
    /// How much better another design may be.
    pub(crate) certificate: Certificate,
}

/// One campaign.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PooledCampaign {
    /// Batch by batch.
    pub(crate) steps: Vec<PooledStep>,
    pub(crate) n_experiments: usize,
    pub(crate) n_simulations: usize,
}

/// The campaigns of the pooled loop, and what is known without any loop.
#[derive(Debug)]
pub(crate) struct Pooled {
    pub(crate) campaigns: Vec<PooledCampaign>,
    /// What the center of the box truly costs.
    pub(crate) center_cost: f64,
}

impl Pooled {
    /// A campaign for each seed, of its noise and of its own draws, side by side; `finished` is called after each batch.
    pub(crate) fn of(
        rig: &StandInRig<'_>,
        budget: &global::Settings,
        seeds: &[u64],
        finished: impl Fn() + Sync,
    ) -> Result<Self> {
        let run = |&seed: &u64| {
            PooledCampaign::run(&StandInRig { seed, ..*rig }, budget, &finished)
                .with_context(|| format!("pooled loop, seed {seed}"))
        };
        let campaigns = seeds.par_iter().map(run).collect::<Result<_>>()?;
        let center = rig.space.nearest(&rig.space.region().center())?;
        let center_cost = rig.truth.cost(center).unwrap_or(f64::NAN);
        Ok(Self { campaigns, center_cost })
    }

    /// What was recommended after a batch from 1, by every campaign that got so far.
    pub(crate) fn after(&self, batch: usize) -> impl Iterator<Item = &PooledStep> {
        self.campaigns.iter().filter_map(move |campaign| campaign.steps.get(batch.checked_sub(1)?))
    }
}

impl PooledCampaign {
    /// Those of all batches but the first.
    pub(super) fn settings(budget: &global::Settings, seed: u64) -> Settings {
        let mut settings = Settings::new(budget.n_experiments);
        (settings.max_batches, settings.seed) = (budget.max_batches, seed);
        settings.simulations = Some(budget.n_simulations);
        // A stand-in reads the same in every batch, and the loop is told so.
        settings.blocks = Some(false);
        settings
    }

    /// As many experiments and simulations in each batch, and as many batches, as the other loop has; of the first batch's
    /// simulations those at its experiments are a part.
    fn run(rig: &StandInRig<'_>, budget: &global::Settings, finished: &impl Fn()) -> Result<Self> {
        let settings = Self::settings(budget, rig.seed);
        let mut first = settings.clone();
        first.simulations = Some(budget.n_simulations.saturating_sub(budget.n_experiments).max(2));
        let mut campaign = Loop::new(rig.space.region(), first)?;
        let mut steps = Vec::new();
        while let Ask::Run { trials, simulations } = campaign.ask(None)? {
            let costs = rig.model.costs(&simulations);
            for (cell, cost) in simulations.into_iter().zip(costs) {
                campaign.tell_simulation(cell, cost)?;
            }
            if trials.is_empty() {
                continue;
            }
            let experiments: Vec<_> = trials.iter().map(|trial| (trial.id, trial.cell)).collect();
            for ((id, _), outcome) in experiments.iter().zip(rig.measure_at(&experiments)?) {
                campaign.tell(*id, outcome)?;
            }
            let assessment = campaign.assess(None)?.context("no experiment gave a response")?;
            let cost = rig.truth.cost(assessment.recommended.cell).unwrap_or(f64::NAN);
            steps.push(PooledStep { cost, certificate: assessment.certificate });
            campaign.set_settings(settings.clone())?;
            finished();
        }
        ensure!(steps.len() == budget.max_batches, "it ended after {} batches", steps.len());
        let (n_experiments, n_simulations) = (campaign.records().len(), campaign.n_simulated());
        Ok(Self { steps, n_experiments, n_simulations })
    }
}

#[cfg(test)]
mod tests {
    use design_space::{Cell, Model};

    use super::*;
    use crate::costs::Cost;
    use crate::gridded::{CellCosts, Space};

    /// A bowl over the levels of two parameters; the lowest level of the first does not fly.
    #[derive(Debug)]
    struct Bowl {
        space: Space,
        lowest: [f64; 2],
    }

    impl CellCosts for Bowl {
        fn cost(&self, cell: Cell) -> Cost {
            let point = self.space.point(cell).map_err(|error| error.to_string())?;
            let (x, y) = (point[0] - self.lowest[0], point[1] - self.lowest[1]);
            if point[0] > 46.0 { Ok(1.0 + x * x + 0.1 * y * y) } else { Err("it does not fly".to_owned()) }
        }

        fn range(&self) -> f64 {
            10.0
        }
    }

    #[test]
    fn both_loops_have_one_budget_and_the_pooled_one_finds_the_bottom_of_a_bowl() {
        let [model, truth] = [[47.0, 3.0], [50.0, 8.0]]
            .map(|lowest| Bowl { space: Space::of_two([46.0, 52.0], [0.0, 12.0], 13), lowest });
        let rig = StandInRig { space: &model.space, model: &model, truth: &truth, noise: 0.001, seed: 3 };
        let mut budget = global::Settings::new(Model::additive_quadratic(2).expect("a model"), 8, 14);
        budget.max_batches = 3;
        let pooled = Pooled::of(&rig, &budget, &[1, 2], || ()).expect("two campaigns");
        for campaign in &pooled.campaigns {
            assert_eq!((campaign.n_experiments, campaign.steps.len()), (24, 3));
            assert!((30..=42).contains(&campaign.n_simulations), "{} simulations", campaign.n_simulations);
            let last = &campaign.steps[2];
            assert!(last.cost < 1.1 && last.cost - 1.0 <= last.certificate.bound, "{last:?}");
        }
        assert!((pooled.center_cost - 2.4).abs() < 1e-9, "{}", pooled.center_cost);
        assert_eq!(pooled.after(3).count(), 2);
        assert_eq!(pooled.after(0).count() + pooled.after(4).count(), 0);
    }
}
