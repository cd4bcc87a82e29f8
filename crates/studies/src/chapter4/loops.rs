//! The loop itself: once flown directly for the rows that are reported, and once per noise seed on remembered flights.

use anyhow::{Context as _, Result};
use bat_dynamics::Fidelity;
use infuse::codesign::{CodesignReport, codesign};
use infuse::{Outcome, gradient};
use water_channel::BoundedNoise;

use super::file::{Setup, Variant};
use super::lattice::Lattice;
use crate::bat::{MODEL, STAND_IN};
use crate::costs::Cost;
use crate::together::{Search, together};

/// The numerical model, the stand-in, and what lies between them.
pub(crate) const PHYSICS: [(&str, Fidelity); 4] = [
    ("model", MODEL),
    ("stand-in", STAND_IN),
    ("model with stall only", Fidelity::STALLED),
    ("model with added mass only", Fidelity::ADDED_MASS),
];

/// A campaign that has ended.
#[derive(Clone, Debug)]
pub(crate) struct Campaign {
    pub(crate) reports: Vec<gradient::Report>,
    pub(crate) stop: gradient::StopReason,
}

/// Runs a variant with `simulate` as the model and `experiment` as the rig for a batch of designs, read by `read`.
fn run(
    setup: &Setup,
    variant: &Variant,
    mut simulate: impl FnMut(&[f64]) -> Cost,
    experiment: impl Fn(Vec<Vec<f64>>) -> Vec<Cost>,
    read: impl Fn(&gradient::Trial, Cost) -> Cost,
    iterated: impl Fn(),
) -> Result<Campaign> {
    let mut campaign = gradient::Loop::new(setup.problem.clone(), setup.loop_settings(variant))?;
    let stop = loop {
        match campaign.ask(&mut simulate).with_context(|| variant.label.clone())? {
            gradient::Ask::Stopped(stop) => break stop,
            gradient::Ask::Trials(trials) => {
                let costs = experiment(trials.iter().map(|trial| trial.point.clone()).collect());
                for (trial, cost) in trials.iter().zip(costs) {
                    campaign.tell(trial.id, Outcome::from(read(trial, cost)))?;
                }
                iterated();
            }
        }
    };
    Ok(Campaign { reports: campaign.reports().to_vec(), stop })
}

/// What is found without noise, each simulation flown.
pub(crate) struct Direct {
    /// Of each variant.
    pub(crate) campaigns: Vec<Campaign>,
    /// The optimum with each of [`PHYSICS`], by the loop's own nested optimizer. That of the stand-in an engineer could not compute.
    pub(crate) optima: Vec<CodesignReport>,
}

enum Found {
    Campaign(Campaign),
    Optimum(CodesignReport),
}

/// Designs to be flown, and in what.
type Asked = (Vec<Vec<f64>>, Fidelity);

/// Every variant, and the optimum with each piece of physics: searches side by side, that fly together and share what they fly.
pub(crate) fn direct(setup: &Setup, iterated: impl Fn() + Sync) -> Result<Direct> {
    let iterated = &iterated;
    let campaigns = setup.file.variant.iter().map(|variant| -> Search<'_, Asked, Vec<Cost>, Result<Found>> {
        Box::new(move |ask| {
            let simulate = |point: &[f64]| one(ask, point, MODEL);
            let experiment = |points| ask((points, STAND_IN));
            Ok(Found::Campaign(run(setup, variant, simulate, experiment, |_, cost| cost, iterated)?))
        })
    });
    let optima = PHYSICS.iter().map(|(_, fidelity)| -> Search<'_, Asked, Vec<Cost>, Result<Found>> {
        Box::new(move |ask| {
            let settings = setup.loop_settings(&setup.file.variant[0]);
            let start = setup.problem.region().center();
            let mut cost = |point: &[f64]| one(ask, point, *fidelity);
            Ok(Found::Optimum(codesign(&setup.problem, &settings.optimizer, &start, &mut cost)?))
        })
    });
    let mut direct = Direct { campaigns: Vec::new(), optima: Vec::new() };
    for found in together(campaigns.chain(optima).collect(), |asked| setup.bat.costs_in_each(&asked)) {
        match found? {
            Found::Campaign(campaign) => direct.campaigns.push(campaign),
            Found::Optimum(optimum) => direct.optima.push(optimum),
        }
    }
    Ok(direct)
}

/// The cost at one point.
fn one(ask: &dyn Fn(Asked) -> Vec<Cost>, point: &[f64], fidelity: Fidelity) -> Cost {
    let costs = ask((vec![point.to_vec()], fidelity));
    costs.into_iter().next().unwrap_or_else(|| Err("no flight".to_owned()))
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
                    let experiment = |points: Vec<Vec<f64>>| setup.bat.costs(&points, STAND_IN, |_| {});
                    let campaign = run(setup, variant, &simulate, experiment, read, || {})?;
                    finished();
                    Ok((*seed, campaign))
                })
                .collect::<Result<_>>()?;
            Ok(Seeded { label: variant.label.clone(), campaigns })
        })
        .collect()
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
        let experiment = |points: Vec<Vec<f64>>| setup.bat.costs(&points, STAND_IN, |_| {});
        let campaign = run(&setup, &setup.file.variant[0], simulate, experiment, read, || {}).unwrap();
        let report = &campaign.reports[0];
        let reasons: Vec<&str> = report.numerical.failures.iter().map(|failure| failure.reason.as_str()).collect();
        assert!(!reasons.is_empty(), "a center of mass at 90 % of the chord flies");
        assert!(reasons.iter().all(|r| r.contains("slack") || r.contains("trim") || r.contains("left")), "{reasons:?}");
        assert!(report.numerical.corrected_cost < 5.0, "the optimum is still found: {report:?}");
        assert!(report.experiment_gradient.iter().all(Option::is_some), "one-sided where a trial failed: {report:?}");
    }
}
