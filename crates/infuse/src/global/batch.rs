//! The G-optimal designs of a batch: Section 5.1 over what is left of the gridded space.

use std::borrow::Cow;
use std::collections::BTreeSet;

use design_space::{Cell, Model, Term};
use doe::{Criterion, Design, Effort, Problem, Replicates, SplitSettings, confounded_terms, search, split};
use serde::{Deserialize, Serialize};

use crate::Error;
use crate::global::candidates::Candidates;
use crate::global::cells::Cells;
use crate::global::greedy::greedy;
use crate::global::retained::RetainedSet;
use crate::global::settings::Settings;
use crate::global::trial::TrialUse;

/// What a batch was designed over, and how good it is.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Batch {
    /// Cells that the designs were chosen from, and over which their variance was looked at: all retained
    /// cells up to [`Settings::candidate_limit`], a part of them beyond.
    pub n_candidates: u64,
    /// Terms of the regressor that these cells cannot tell apart, left out in this batch.
    pub dropped_terms: Vec<DroppedTerm>,
    /// Whether all terms were left out, each vanishing or equal to others that vanish: a constant is then estimated
    /// in their place.
    #[serde(default)]
    pub constant_instead: bool,
    /// G-efficiency of the experiments for the terms that are left, over the candidates, per cent.
    pub experiment_efficiency: f64,
    /// G-efficiency of the simulations, likewise.
    pub simulation_efficiency: f64,
}

/// A term that equals a combination of earlier terms wherever an experiment may be made.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DroppedTerm {
    /// Its index in the regressor of the settings.
    pub term: usize,
    /// Its name, of the parameters' names.
    pub name: String,
    /// Names and coefficients of the terms it equals, in coded coordinates; empty if it vanishes.
    pub equals: Vec<(String, f64)>,
}

impl Batch {
    /// The regressor of this batch.
    pub(crate) fn model(&self, settings: &Settings) -> Result<Model, Error> {
        regressor(settings, &self.dropped_terms)
    }
}

/// The model of the settings without these terms; a constant if none is left.
fn regressor(settings: &Settings, dropped: &[DroppedTerm]) -> Result<Model, Error> {
    let (model, k) = (&settings.model, settings.model.n_factors());
    if dropped.len() == model.n_terms() {
        return Ok(Model::new(k, vec![Term::new(vec![0; k])])?);
    }
    let terms: Vec<usize> = dropped.iter().map(|dropped| dropped.term).collect();
    Ok(model.without_terms(&terms)?)
}

/// Which of a batch's designs is searched for.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Purpose {
    Candidates,
    Experiments,
    Simulations,
}

/// What is left to design in: candidates, and the regressor they support.
#[derive(Debug)]
pub(crate) struct DesignSpace<'a> {
    cells: &'a Cells,
    settings: &'a Settings,
    batch: usize,
    candidates: Candidates,
    model: Model,
    dropped: Vec<DroppedTerm>,
}

impl<'a> DesignSpace<'a> {
    pub(crate) fn of(
        retained: &RetainedSet,
        cells: &'a Cells,
        settings: &'a Settings,
        batch: usize,
    ) -> Result<Self, Error> {
        let seed = seed(settings.seed, batch, Purpose::Candidates);
        let candidates = Candidates::of(retained, cells, settings.candidate_limit(), seed)?;
        let names: Vec<&str> = cells.region().parameters().iter().map(design_space::Parameter::name).collect();
        let names = settings.model.term_names(&names);
        let named = |confounding: doe::Confounding| DroppedTerm {
            term: confounding.term,
            name: names[confounding.term].clone(),
            equals: confounding.equals.iter().map(|&(term, coefficient)| (names[term].clone(), coefficient)).collect(),
        };
        let confounded = confounded_terms(&settings.model, &candidates.space)?;
        let dropped: Vec<DroppedTerm> = confounded.into_iter().map(named).collect();
        let model = regressor(settings, &dropped)?;
        Ok(Self { cells, settings, batch, candidates, model, dropped })
    }

    /// Cells of a design with the smallest maximum of the prediction variance, the repaired (29), none of them among
    /// those to avoid as long as the others support the model.
    ///
    /// Distinct while there are more candidates than runs. Otherwise every candidate is run equally often, and some,
    /// evenly spaced, once more. If the search finds nothing, the design is built run by run.
    pub(crate) fn design(&self, n_runs: usize, purpose: Purpose, avoided: &BTreeSet<Cell>) -> Result<Vec<Cell>, Error> {
        let candidates = self.candidates_but(avoided)?;
        let Candidates { cells, space } = candidates.as_ref();
        if cells.len() <= n_runs {
            let n = cells.len();
            let (rounds, rest) = (n_runs / n, n_runs % n);
            let again = (0..rest).map(|number| cells[number * n / rest]);
            return Ok(cells.iter().copied().cycle().take(rounds * n).chain(again).collect());
        }
        let mut problem = Problem::new(self.model.clone(), space.clone(), n_runs, Criterion::G)?;
        if let Purpose::Experiments = purpose
            && self.settings.replicates > 0
        {
            problem = problem.with_replicates(Replicates::Planned(self.settings.replicates))?;
        }
        let mut settings = doe::Settings::default();
        settings.seed = seed(self.settings.seed, self.batch, purpose);
        settings.starts = self.settings.design_starts;
        settings.effort = Effort::Quick;
        let none = match search(&problem, &settings) {
            Ok(found) => return Ok(found.candidates.into_iter().map(|candidate| cells[candidate]).collect()),
            Err(none @ doe::Error::NoDesign { .. }) => none,
            Err(error) => return Err(error.into()),
        };
        let runs = space.candidates().and_then(|points| greedy(&self.model, points, n_runs)).ok_or(none)?;
        Ok(runs.into_iter().map(|run| cells[run]).collect())
    }

    /// How many candidates there are without these.
    pub(crate) fn n_candidates_but(&self, avoided: &BTreeSet<Cell>) -> usize {
        self.candidates.cells.iter().filter(|cell| !avoided.contains(cell)).count()
    }

    /// The candidates without these, or all if the rest does not support the model.
    fn candidates_but(&self, avoided: &BTreeSet<Cell>) -> Result<Cow<'_, Candidates>, Error> {
        let others = self.candidates.cells.iter().copied().filter(|cell| !avoided.contains(cell));
        let others: Vec<Cell> = others.collect();
        if others.is_empty() || others.len() == self.candidates.cells.len() {
            return Ok(Cow::Borrowed(&self.candidates));
        }
        let others = Candidates::of_cells(others, self.cells)?;
        let supports = confounded_terms(&self.model, &others.space)?.is_empty();
        Ok(if supports { Cow::Owned(others) } else { Cow::Borrowed(&self.candidates) })
    }

    /// What the experiments at these cells are used for, in their order.
    pub(crate) fn uses(&self, experiments: &[Cell]) -> Result<Vec<TrialUse>, Error> {
        let mut how = SplitSettings::default();
        how.method = self.settings.split;
        let halves = split(&self.model, &self.candidates.space, &self.as_design(experiments)?, &how)?;
        let mut uses = vec![TrialUse::Validation; experiments.len()];
        for run in halves.training {
            uses[run] = TrialUse::Training;
        }
        Ok(uses)
    }

    pub(crate) fn batch(&self, experiments: &[Cell], simulations: &[Cell]) -> Result<Batch, Error> {
        Ok(Batch {
            n_candidates: self.candidates.cells.len() as u64,
            dropped_terms: self.dropped.clone(),
            constant_instead: self.dropped.len() == self.settings.model.n_terms(),
            experiment_efficiency: self.efficiency(experiments)?,
            simulation_efficiency: self.efficiency(simulations)?,
        })
    }

    fn efficiency(&self, runs: &[Cell]) -> Result<f64, Error> {
        let efficiency = Criterion::G.efficiency(&self.model, &self.candidates.space, &self.as_design(runs)?)?;
        Ok(efficiency.percent)
    }

    fn as_design(&self, runs: &[Cell]) -> Result<Design, Error> {
        let coded = runs.iter().map(|&cell| self.cells.coded(cell));
        Ok(Design::from_runs(&coded.collect::<Result<Vec<_>, _>>()?)?)
    }
}

/// One stream of random numbers per batch and purpose.
fn seed(seed: u64, batch: usize, purpose: Purpose) -> u64 {
    let stream = 3 * batch as u64 + purpose as u64;
    seed ^ stream.wrapping_mul(0x9E37_79B9_7F4A_7C15)
}

#[cfg(test)]
mod tests {
    use super::*;
    use design_space::{Parameter, Region};

    #[test]
    fn candidates_but_some_are_all_others() {
        let parameter = Parameter::continuous("p", "m", 0.0, 1.0).unwrap().with_levels(7).unwrap();
        let cells = Cells::of(&Region::new(vec![parameter]).unwrap()).unwrap();
        let settings = Settings::new(Model::quadratic(1).unwrap(), 4, 4);
        let retained = RetainedSet::full(7).without(&BTreeSet::from([Cell::new(6)]));
        let space = DesignSpace::of(&retained, &cells, &settings, 1).unwrap();
        assert_eq!(space.n_candidates_but(&BTreeSet::new()), 6);
        // The last of these is not left anyway.
        assert_eq!(space.n_candidates_but(&[0, 3, 6].map(Cell::new).into()), 4);
    }
}
