//! The loop itself: once flown directly for the rows that are reported, and once per noise seed on remembered flights.

use anyhow::{Context as _, Result};
use infuse::{Outcome, gradient};
use rayon::prelude::*;
use water_channel::BoundedNoise;

use super::file::{Setup, Variant};
use super::lattice::Lattice;
use crate::bat::{MODEL, STAND_IN};
use crate::costs::Cost;

/// A campaign that has ended.
#[derive(Clone, Debug)]
pub(crate) struct Campaign {
    pub(crate) reports: Vec<gradient::Report>,
    pub(crate) stop: gradient::StopReason,
}

/// Runs a variant with `simulate` as the model, with every batch of experiments flown side by side and read by `read`.
fn run(
    setup: &Setup,
    variant: &Variant,
    mut simulate: impl FnMut(&[f64]) -> Result<f64, String>,
    read: impl Fn(&gradient::Trial, Cost) -> Cost,
    iterated: impl Fn(),
) -> Result<Campaign> {
    let mut campaign = gradient::Loop::new(setup.problem.clone(), setup.loop_settings(variant))?;
    let stop = loop {
        match campaign.ask(&mut simulate).with_context(|| variant.label.clone())? {
            gradient::Ask::Stopped(stop) => break stop,
            gradient::Ask::Trials(trials) => {
                let points: Vec<Vec<f64>> = trials.iter().map(|trial| trial.point.clone()).collect();
                let costs = setup.bat.costs(&points, STAND_IN, |_| {});
                for (trial, cost) in trials.iter().zip(costs) {
                    campaign.tell(trial.id, Outcome::from(read(trial, cost)))?;
                }
                iterated();
            }
        }
    };
    Ok(Campaign { reports: campaign.reports().to_vec(), stop })
}

/// Every variant without noise, each simulation flown. Variants run side by side and share what they fly.
pub(crate) fn direct(setup: &Setup, iterated: impl Fn() + Sync) -> Result<Vec<Campaign>> {
    let fly = |variant: &Variant| run(setup, variant, |point| setup.bat.cost(point, MODEL), |_, cost| cost, &iterated);
    // The first iteration is the same for all: flown once, remembered by the others.
    let (first, rest) = setup.file.variant.split_first().context("no variant")?;
    let first = fly(first)?;
    let rest: Vec<Campaign> = rest.par_iter().map(fly).collect::<Result<_>>()?;
    Ok(std::iter::once(first).chain(rest).collect())
}

/// The campaigns of one variant, one per noise seed, on remembered simulations and flown experiments.
#[derive(Clone, Debug)]
pub(crate) struct Seeded {
    pub(crate) label: String,
    pub(crate) campaigns: Vec<(u64, Campaign)>,
}

/// Every variant with every noise seed.
pub(crate) fn seeded(setup: &Setup, model: &Lattice, finished: impl Fn() + Sync) -> Result<Vec<Seeded>> {
    let noise = &setup.file.noise;
    let seeds = noise.numbers(noise.seeds);
    let simulate = model.interpolant()?;
    setup
        .file
        .variant
        .iter()
        .filter(|variant| variant.with_noise)
        .map(|variant| {
            let campaigns = seeds
                .iter()
                .map(|seed| {
                    let noise = BoundedNoise::new(noise.share, *seed)?;
                    let read =
                        |trial: &gradient::Trial, cost: Cost| cost.map(|cost| noise.measured(cost, trial.id.number()));
                    let campaign = run(setup, variant, &simulate, read, || {})?;
                    finished();
                    Ok((*seed, campaign))
                })
                .collect::<Result<_>>()?;
            Ok(Seeded { label: variant.label.clone(), campaigns })
        })
        .collect()
}

/// The optimum of a cost by the loop's own nested optimizer: of the stand-in, which an engineer could not compute.
pub(crate) fn optimum(
    setup: &Setup,
    cost: impl FnMut(&[f64]) -> Result<f64, String>,
) -> Result<infuse::codesign::CodesignReport> {
    let mut cost = cost;
    let settings = setup.loop_settings(&setup.file.variant[0]);
    let start = setup.problem.region().center();
    Ok(infuse::codesign::codesign(&setup.problem, &settings.optimizer, &start, &mut cost)?)
}

#[cfg(test)]
mod tests {
    use infuse::gradient;

    use super::*;

    /// The study with a box in which many designs cannot fly, one step per sample and one iteration.
    fn reckless() -> Setup {
        let change = |text: String| {
            text.replace("upper = 51.25", "upper = 90.0")
                .replace("tolerance = 0.01", "tolerance = 0.1")
                .replace("iterations = 3", "iterations = 1")
        };
        crate::study_file::read_changed("chapter4.toml", Setup::of, change).expect("a study")
    }

    #[test]
    fn designs_that_cannot_fly_are_failed_trials_and_the_study_goes_on() {
        let setup = reckless();
        let read = |trial: &gradient::Trial, cost: Cost| match trial.role {
            gradient::TrialRole::Plus(0) => Err("the camera lost the body".to_owned()),
            _ => cost,
        };
        let simulate = |point: &[f64]| setup.bat.cost(point, MODEL);
        let campaign = run(&setup, &setup.file.variant[0], simulate, read, || {}).unwrap();
        let report = &campaign.reports[0];
        let reasons: Vec<&str> = report.numerical.failures.iter().map(|failure| failure.reason.as_str()).collect();
        assert!(!reasons.is_empty(), "a center of mass at 90 % of the chord flies");
        assert!(reasons.iter().all(|r| r.contains("slack") || r.contains("trim") || r.contains("left")), "{reasons:?}");
        assert!(report.numerical.corrected_cost < 5.0, "the optimum is still found: {report:?}");
        assert!(report.experiment_gradient.iter().all(Option::is_some), "one-sided where a trial failed: {report:?}");
    }
}
