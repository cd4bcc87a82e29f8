//! What the wrong choices cost: the loop and its rivals on one rig, over the grid that is flown in whole.

use anyhow::{Context as _, Result};
use design_space::Cell;
use doe::Model;
use infuse::{
    correction::{Law, Rule},
    global::{self, SurfaceKind, SurfaceKinds},
};
use rayon::prelude::*;

use super::alone::Alone;
use super::leak::{self, Timing};
use crate::gridded::{Designs, FlownGrid, Regressor, StandInRig};
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
    /// Share of the cells that were left at the end, in the mean: a blind draw of as many keeps the best so often.
    pub(crate) left: Option<f64>,
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
    cell: Cell,
    keeps_best: Option<bool>,
    left: Option<f64>,
}

/// One seed of one choice.
type RunSeed<'a> = Box<dyn Fn(&StandInRig<'_>) -> Result<End> + Sync + 'a>;

/// A choice by name, what is done in a sentence, and how.
type Way<'a> = (&'static str, String, RunSeed<'a>);

/// How many choices there are, for whoever waits.
pub(crate) const N_CHOICES: usize = 9;

/// All ways of choosing, with every seed; `base` are the settings of the loop as it is.
pub(crate) fn choices(
    rig: &StandInRig<'_>,
    [model, truth]: [&FlownGrid; 2],
    base: &global::Settings,
    seeds: &[u64],
    designs: &Designs,
    finished: impl Fn() + Sync,
) -> Result<Vec<Choice>> {
    let best = truth.lowest()?;
    let ways = Ways { base, designs, numerical: model.lowest()?.0, best: best.0 };
    let alone = Alone::design(rig, base)?;
    let products = Regressor::Quadratic.model(rig.space.region().n_parameters())?;
    for model in [&base.model, &products] {
        rig.prepare(&ways.with(|settings| settings.model = model.clone()), designs)?;
    }
    let all = ways.all(&alone, &products);
    let run = |number: usize| {
        let ((label, _, run), seed) = (&all[number / seeds.len()], seeds[number % seeds.len()]);
        let end = run(&StandInRig { seed, ..*rig }).with_context(|| format!("{label}, seed {seed}"));
        finished();
        end
    };
    // All side by side: a choice whose last seeds take long does not keep the others waiting.
    let ends = (0..all.len() * seeds.len()).into_par_iter().map(run).collect::<Result<Vec<End>>>()?;
    let choice = |(way, ends): (Way<'_>, &[End])| Choice::of(way, ends, truth, best.1);
    Ok(all.into_iter().zip(ends.chunks(seeds.len())).map(choice).collect())
}

impl Choice {
    /// Where all seeds of a way ended, beside the lowest true cost.
    fn of((label, how, _): Way<'_>, ends: &[End], truth: &FlownGrid, best_cost: f64) -> Self {
        let regret = |end: &End| truth.cost(end.cell).as_ref().map_or(f64::INFINITY, |cost| cost - best_cost);
        let kept: Option<Vec<bool>> = ends.iter().map(|end| end.keeps_best).collect();
        let lost = kept.map(|kept| kept.iter().filter(|kept| !**kept).count());
        let left: Option<Vec<f64>> = ends.iter().map(|end| end.left).collect();
        let left = left.map(|left| left.iter().sum::<f64>() / left.len() as f64);
        Self { label, how, regrets: ends.iter().map(regret).collect(), lost, left }
    }
}

/// What the ways of choosing are made from.
#[derive(Clone, Copy)]
struct Ways<'a> {
    /// The settings of the loop as it is.
    base: &'a global::Settings,
    designs: &'a Designs,
    /// The lowest cell of the numerical model.
    numerical: Cell,
    /// The truly best cell.
    best: Cell,
}

impl<'a> Ways<'a> {
    fn all(self, alone: &'a Alone, products: &Model) -> [Way<'a>; N_CHOICES] {
        let [inverse_distance, squared_exponential] = self.other_surfaces();
        [
            self.as_it_is(),
            self.with_products(products),
            self.without_infusion(),
            self.without_a_model(alone),
            self.in_the_loop(),
            self.as_printed(),
            self.leaking(),
            inverse_distance,
            squared_exponential,
        ]
    }

    /// The settings of the loop with a change.
    fn with(self, change: impl FnOnce(&mut global::Settings)) -> global::Settings {
        let mut settings = self.base.clone();
        change(&mut settings);
        settings
    }

    /// The loop with a change of its settings.
    fn looped(self, change: impl FnOnce(&mut global::Settings)) -> RunSeed<'a> {
        let settings = self.with(change);
        Box::new(move |rig| self.end(&rig.run(&settings, self.designs, |_| {})?))
    }

    fn end(self, campaign: &global::Loop) -> Result<End> {
        let last = campaign.reports().last().context("a campaign without an iteration")?;
        let keeps_best = Some(campaign.retained().contains(self.best));
        let left = Some(campaign.retained().share());
        Ok(End { cell: last.screening.optimum_cell, keeps_best, left })
    }

    fn as_it_is(self) -> Way<'a> {
        let how = "Regressor, weights, law and test of this study.";
        ("the loop as it is", how.to_owned(), self.looped(|_| ()))
    }

    fn with_products(self, products: &Model) -> Way<'a> {
        let how =
            "The same with the full quadratic, which can say that the optimum of one parameter depends on another.";
        ("products in the regressor", how.to_owned(), self.looped(|settings| settings.model = products.clone()))
    }

    fn without_infusion(self) -> Way<'a> {
        let how = "The optimum of the numerical model is built; no experiment is made.";
        (
            "no infusion",
            how.to_owned(),
            Box::new(move |_| Ok(End { cell: self.numerical, keeps_best: None, left: None })),
        )
    }

    fn without_a_model(self, alone: &'a Alone) -> Way<'a> {
        let how = format!(
            "No model: as many experiments as the loop makes in all, {}, in one G-optimal batch over the whole space, one \
             regression on them, its lowest cell.",
            alone.n_experiments()
        );
        let run = |rig: &StandInRig<'_>| Ok(End { cell: alone.lowest(rig)?, keeps_best: None, left: None });
        ("experiments only, one batch", how, Box::new(run))
    }

    fn in_the_loop(self) -> Way<'a> {
        let how = "The loop with all but no weight on the simulations: each combined surface rests on the training half of one \
                   batch.";
        let run = self.looped(|settings| settings.simulation_weight = NO_WEIGHT * settings.experiment_weight);
        ("experiments only, in the loop", how.to_owned(), run)
    }

    fn as_printed(self) -> Way<'a> {
        let how = "Corrections are summed that are sums already, against a simulation that is not corrected.";
        let run = self.looped(|settings| settings.correction = Rule::new(Law::AsPrinted36, settings.correction.gain));
        ("(36) as printed", how.to_owned(), run)
    }

    fn leaking(self) -> Way<'a> {
        let how = "The correction acts in its own iteration (5.4 read literally): S is estimated from experiments that are in \
                   the surface. The library refuses it; here it is smuggled in through the simulation.";
        let run =
            move |rig: &StandInRig<'_>| self.end(&leak::run(rig, self.base, self.designs, Timing::SameIteration)?);
        ("correction leak", how.to_owned(), Box::new(run))
    }

    fn other_surfaces(self) -> [Way<'a>; 2] {
        let run = |kind: SurfaceKind| {
            let kinds = SurfaceKinds { experiment: kind, simulation: kind, combined: kind };
            self.looped(|settings| settings.surfaces = kinds)
        };
        let distance = "All three surfaces are (32), (33).";
        let exponential =
            "All three surfaces are (34) with its sign repaired, the scale chosen by leaving out one place at a time.";
        [
            ("inverse-distance surfaces", distance.to_owned(), run(SurfaceKind::InverseDistance { power: 2.0 })),
            (
                "squared-exponential surfaces",
                exponential.to_owned(),
                run(SurfaceKind::SquaredExponential { scale: None }),
            ),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seeds_are_compared_one_by_one() {
        let choice = |regrets: &[f64]| Choice {
            label: "",
            how: String::new(),
            regrets: regrets.to_vec(),
            lost: None,
            left: None,
        };
        let (one, other) = (choice(&[1.0, 2.0, 3.0]), choice(&[1.0, 3.0, 2.0]));
        assert_eq!([one.beats(&other), other.beats(&one), one.beats(&one)], [1, 1, 0], "a tie beats nothing");
        assert!((one.median() - 2.0).abs() < 1e-12 && (one.worst() - 3.0).abs() < 1e-12, "{one:?}");
    }
}
