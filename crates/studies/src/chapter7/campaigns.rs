//! The loop with one regressor: once without noise, and once for each seed of it.

use anyhow::{Context as _, Result};
use design_space::Cell;
use infuse::global;
use rayon::prelude::*;

use crate::gridded::{Designs, StandInRig};

/// What an iteration found.
#[derive(Clone, Debug)]
pub(crate) struct Step {
    pub(crate) point: Vec<f64>,
    /// What the design truly costs.
    pub(crate) cost: f64,
    /// Per cent of the original cells left after the iteration.
    pub(crate) share: f64,
}

/// One campaign, iteration by iteration.
#[derive(Clone, Debug)]
pub(crate) struct Steps(pub(crate) Vec<Step>);

impl Steps {
    fn of(campaign: &global::Loop, rig: &StandInRig<'_>) -> Self {
        let reports = campaign.reports();
        let optima: Vec<Cell> = reports.iter().map(|report| report.screening.optimum_cell).collect();
        let costs = rig.truth.costs(&optima);
        let steps = reports.iter().zip(costs).map(|(report, cost)| {
            let screening = &report.screening;
            Step {
                point: screening.optimum.clone(),
                cost: cost.unwrap_or(f64::NAN),
                share: 100.0 * screening.n_after as f64 / rig.space.n_cells() as f64,
            }
        });
        Self(steps.collect())
    }

    /// Of the last iteration that was made.
    pub(crate) fn last(&self) -> Result<&Step> {
        self.0.last().context("a campaign without an iteration")
    }
}

/// All campaigns with one regressor.
#[derive(Debug)]
pub(crate) struct Runs {
    pub(crate) label: String,
    /// Without noise.
    pub(crate) quiet: Steps,
    pub(crate) quiet_campaign: global::Loop,
    /// One for each seed of noise.
    pub(crate) noisy: Vec<Steps>,
    /// In the same order.
    pub(crate) seeds: Vec<u64>,
}

impl Runs {
    /// Runs them side by side; `rig` has the noise, and `iterated` is called after each iteration.
    pub(crate) fn of(
        label: &str,
        rig: &StandInRig<'_>,
        settings: &global::Settings,
        seeds: &[u64],
        designs: &Designs,
        iterated: impl Fn(usize) + Sync,
    ) -> Result<Self> {
        rig.prepare(settings, designs)?;
        let run = |rig: StandInRig<'_>| -> Result<(Steps, global::Loop)> {
            let campaign = rig.run(settings, designs, &iterated)?;
            Ok((Steps::of(&campaign, &rig), campaign))
        };
        let noisy = || -> Result<Vec<Steps>> {
            seeds.par_iter().map(|seed| Ok(run(StandInRig { seed: *seed, ..*rig })?.0)).collect()
        };
        let (quiet, noisy) = rayon::join(|| run(StandInRig { noise: 0.0, seed: 0, ..*rig }), noisy);
        let (quiet, quiet_campaign) = quiet?;
        Ok(Self { label: label.to_owned(), quiet, quiet_campaign, noisy: noisy?, seeds: seeds.to_vec() })
    }

    /// The seed whose last design has the median true cost, the lower one of two, with its campaign: unlike a median taken
    /// column by column it is a design, and its rows are one path.
    pub(crate) fn median(&self) -> Option<(u64, &Steps)> {
        let ends = self.seeds.iter().copied().zip(&self.noisy);
        let mut ends: Vec<(f64, u64, &Steps)> =
            ends.filter_map(|(seed, steps)| Some((steps.0.last()?.cost, seed, steps))).collect();
        ends.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (_, seed, steps) = *ends.get(ends.len().checked_sub(1)? / 2)?;
        Some((seed, steps))
    }

    /// A reading of an iteration from 1, of every campaign with noise that got so far.
    pub(crate) fn over_seeds(&self, iteration: usize, reading: impl Fn(&Step) -> f64) -> Vec<f64> {
        let steps = self.noisy.iter().filter_map(|steps| steps.0.get(iteration.checked_sub(1)?));
        steps.map(reading).collect()
    }
}

#[cfg(test)]
mod tests {
    use design_space::Model;

    use super::*;
    use crate::gridded::Space;

    #[test]
    fn the_median_is_one_campaign() {
        let space = Space::of_two([46.0, 52.0], [46.0, 52.0], 7);
        let settings = global::Settings::new(Model::additive_quadratic(2).expect("a model"), 12, 24);
        let quiet_campaign = global::Loop::new(space.region(), settings).expect("a campaign");
        let steps = |cost: f64| Steps(vec![Step { point: Vec::new(), cost, share: 50.0 }]);
        let runs = |costs: &[f64]| Runs {
            label: String::new(),
            quiet: steps(0.0),
            quiet_campaign: quiet_campaign.clone(),
            noisy: costs.iter().map(|cost| steps(*cost)).collect(),
            seeds: (11..).take(costs.len()).collect(),
        };
        let seed = |costs: &[f64]| runs(costs).median().map(|(seed, _)| seed);
        assert_eq!(seed(&[3.0, 1.0, 2.0]), Some(13), "the middle one");
        assert_eq!(seed(&[4.0, 1.0, 3.0, 2.0]), Some(14), "the lower one of two");
        assert_eq!(seed(&[]), None);
    }
}
