//! What the wrong choices cost: the loop and its rivals on one rig, over the grid that is flown in whole.

use anyhow::{Context as _, Result};
use design_space::Cell;
use doe::{Criterion, Effort, Problem};
use infuse::{
    Outcome, TrialId,
    correction::{Law, Rule},
    global::{self, Observations, SurfaceKind, SurfaceKinds, TracedSurface, TrialUse},
};
use rayon::prelude::*;
use surface::{Confounded, GridPoints, Kind};

use super::leak::{self, Timing};
use crate::gridded::{Designs, FlownGrid, Regressor, SurrogateRig};
use page::Summary;

/// How far below the experiments' weight the simulations' is when experiments are to stand alone.
const NO_WEIGHT: f64 = 1e-5;

/// One way of choosing, over all seeds.
#[derive(Clone, Debug)]
pub(crate) struct Choice {
    pub(crate) label: &'static str,
    /// What is done, in a sentence.
    pub(crate) how: String,
    /// True cost of the last design less the lowest of the grid, seed by seed.
    pub(crate) regrets: Vec<f64>,
    /// In how many campaigns the truly best cell was dropped; none where nothing is dropped.
    pub(crate) lost: Option<usize>,
}

impl Choice {
    pub(crate) fn median(&self) -> f64 {
        Summary::of(&self.regrets).map_or(f64::INFINITY, |summary| summary.median)
    }

    pub(crate) fn worst(&self) -> f64 {
        self.regrets.iter().copied().fold(f64::NEG_INFINITY, f64::max)
    }

    /// For how many seeds it ends truly lower than another with the same noise.
    pub(crate) fn beats(&self, other: &Self) -> usize {
        self.regrets.iter().zip(&other.regrets).filter(|(own, other)| own < other).count()
    }
}

/// What a choice ends with.
struct End {
    cell: usize,
    keeps_best: Option<bool>,
}

/// One seed of one choice.
type RunSeed<'a> = Box<dyn Fn(&SurrogateRig<'_>) -> Result<End> + Sync + 'a>;

/// A choice by name, what is done in a sentence, and how.
type Way<'a> = (&'static str, String, RunSeed<'a>);

/// All ways of choosing; `base` are the settings of the loop as it is.
pub(crate) fn choices(
    rig: &SurrogateRig<'_>,
    [model, truth]: [&FlownGrid; 2],
    base: &global::Settings,
    seeds: &[u64],
    designs: &Designs,
    finished: impl Fn() + Sync,
) -> Result<Vec<Choice>> {
    let (best_cell, best_cost) = truth.lowest()?;
    let end = |campaign: &global::Loop| -> Result<End> {
        let last = campaign.reports().last().context("a campaign without an iteration")?;
        let cell = usize::try_from(last.screening.optimum_cell.index())?;
        Ok(End { cell, keeps_best: Some(campaign.retained().contains(Cell::new(best_cell as u64))) })
    };
    let with = |change: &dyn Fn(&mut global::Settings)| {
        let mut settings = base.clone();
        change(&mut settings);
        settings
    };
    let looped =
        |settings: global::Settings| -> RunSeed<'_> { Box::new(move |rig| end(&rig.run(&settings, designs, |_| {})?)) };
    let surfaces = |kind: SurfaceKind| {
        looped(with(&|settings| {
            settings.surfaces = SurfaceKinds { experiment: kind, simulation: kind, combined: kind };
        }))
    };
    let alone = Alone::design(rig, base)?;
    let products = Regressor::Quadratic.model(rig.space.region().n_parameters())?;
    let all: Vec<Way<'_>> = vec![
        (
            "the loop as it is",
            "Regressor, weights, law and test of this study.".to_owned(),
            looped(base.clone()),
        ),
        (
            "products in the regressor",
            "The same with the full quadratic, which can say that the optimum of one parameter depends on another."
                .to_owned(),
            looped(with(&|settings| settings.model = products.clone())),
        ),
        (
            "no infusion",
            "The optimum of the numerical model is built; no experiment is made.".to_owned(),
            Box::new(|_| Ok(End { cell: model.lowest()?.0, keeps_best: None })),
        ),
        (
            "experiments only, one batch",
            format!(
                "No model: as many experiments as the loop makes in all, {}, in one G-optimal batch over the whole space, one \
                 regression on them, its lowest cell.",
                alone.trials.len()
            ),
            Box::new(|rig| Ok(End { cell: alone.lowest(rig)?, keeps_best: None })),
        ),
        (
            "experiments only, in the loop",
            "The loop with all but no weight on the simulations: each combined surface rests on the training half of one \
             batch."
                .to_owned(),
            looped(with(&|settings| settings.simulation_weight = NO_WEIGHT * settings.experiment_weight)),
        ),
        (
            "(36) as printed",
            "Corrections are summed that are sums already, against a simulation that is not corrected.".to_owned(),
            looped(with(&|settings| {
                settings.correction = Rule::new(Law::AsPrinted36, settings.correction.gain);
            })),
        ),
        (
            "correction leak",
            "The correction acts in its own iteration (5.4 read literally): S is estimated from experiments that are in \
             the surface. The library refuses it; here it is smuggled in through the simulation."
                .to_owned(),
            Box::new(|rig| end(&leak::run(rig, base, designs, Timing::SameIteration)?)),
        ),
        (
            "inverse-distance surfaces",
            "All three surfaces are (32), (33).".to_owned(),
            surfaces(SurfaceKind::InverseDistance { power: 2.0 }),
        ),
        (
            "squared-exponential surfaces",
            "All three surfaces are (34) with its sign repaired, the scale chosen by leaving out one place at a time."
                .to_owned(),
            surfaces(SurfaceKind::SquaredExponential { scale: None }),
        ),
    ];
    for model in [&base.model, &products] {
        rig.prepare(&with(&|settings| settings.model = model.clone()), designs)?;
    }
    let run = |number: usize| {
        let ((label, _, run), seed) = (&all[number / seeds.len()], seeds[number % seeds.len()]);
        let end = run(&SurrogateRig { seed, ..*rig }).with_context(|| format!("{label}, seed {seed}"));
        finished();
        end
    };
    // All side by side: a choice whose last seeds take long does not keep the others waiting.
    let ends = (0..all.len() * seeds.len()).into_par_iter().map(run).collect::<Result<Vec<End>>>()?;
    let regret = |end: &End| truth.cost(end.cell).as_ref().map_or(f64::INFINITY, |cost| cost - best_cost);
    let choice = |((label, how, _), ends): (Way<'_>, &[End])| {
        let kept: Option<Vec<bool>> = ends.iter().map(|end| end.keeps_best).collect();
        let lost = kept.map(|kept| kept.iter().filter(|kept| !**kept).count());
        Choice { label, how, regrets: ends.iter().map(regret).collect(), lost }
    };
    Ok(all.into_iter().zip(ends.chunks(seeds.len())).map(choice).collect())
}

/// How many choices there are, for whoever waits.
pub(crate) const N_CHOICES: usize = 9;

/// Experiments without a model: one batch and one surface.
#[derive(Debug)]
struct Alone {
    kind: Kind,
    trials: Vec<global::Trial>,
}

impl Alone {
    fn design(rig: &SurrogateRig<'_>, settings: &global::Settings) -> Result<Self> {
        let region = rig.space.region();
        let space = doe::Space::of_region(region)?;
        let n_runs = settings.max_iterations * settings.n_experiments;
        let problem = Problem::new(settings.model.clone(), space, n_runs, Criterion::G)?;
        let mut search = doe::Settings::default();
        search.seed = settings.seed;
        search.starts = settings.design_starts;
        search.effort = Effort::Quick;
        let found = doe::search(&problem, &search)?;
        let trials = found.design.runs().zip(1_u64..).map(|(run, number)| {
            let point = region.natural(run)?;
            Ok(global::Trial {
                id: TrialId::new(number),
                iteration: 1,
                used_for: TrialUse::Training,
                cell: Cell::new(rig.space.cell(&point)? as u64),
                point,
            })
        });
        let kind = Kind::Regression { model: settings.model.clone(), confounded: Confounded::Refuse };
        Ok(Self { kind, trials: trials.collect::<Result<_>>()? })
    }

    /// The cell where the regression on these experiments is lowest.
    fn lowest(&self, rig: &SurrogateRig<'_>) -> Result<usize> {
        let region = rig.space.region();
        let mut measured = Observations::none(region.n_parameters());
        for (trial, outcome) in self.trials.iter().zip(rig.measure(&self.trials)?) {
            if let Outcome::Value(cost) = outcome {
                measured.add_experiment(trial.id, &region.coded(&trial.point)?, cost)?;
            }
        }
        let surface = TracedSurface::fit(&self.kind, &measured)?;
        let points = GridPoints::of_space(&doe::Space::of_region(region)?)?;
        let lowest = surface.surface().minimum_over(&points)?.context("the regression is nowhere a number")?;
        Ok(usize::try_from(lowest.index)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seeds_are_compared_one_by_one() {
        let choice = |regrets: &[f64]| Choice { label: "", how: String::new(), regrets: regrets.to_vec(), lost: None };
        let (one, other) = (choice(&[1.0, 2.0, 3.0]), choice(&[1.0, 3.0, 2.0]));
        assert_eq!([one.beats(&other), other.beats(&one), one.beats(&one)], [1, 1, 0], "a tie beats nothing");
        assert!((one.median() - 2.0).abs() < 1e-12 && (one.worst() - 3.0).abs() < 1e-12, "{one:?}");
    }
}
