//! What is kept, as it is read: cases of a study on a plant in a world, with their campaigns.

use super::file::Setup;
use super::row::{Fact, Method, Row, Study, World};
use super::store::{Done, Store};

/// Plants with what is kept of campaigns on them.
#[derive(Debug)]
pub(super) struct Kept {
    pub(super) setup: Setup,
    pub(super) store: Store,
}

/// The plants of the ensemble, and those from farther away.
#[derive(Debug)]
pub(super) struct Ensembles {
    pub(super) near: Kept,
    pub(super) beyond: Kept,
}

/// A study on a plant in a world.
#[derive(Clone, Debug)]
pub(super) struct Case<'a> {
    pub(super) study: Study,
    pub(super) world: World,
    pub(super) plant: u64,
    pub(super) rows: Vec<&'a Row>,
    pub(super) facts: Vec<&'a Fact>,
}

/// All cases, by study, world and plant.
pub(super) fn cases(done: &[Done]) -> Vec<Case<'_>> {
    let mut cases: Vec<Case<'_>> = Vec::new();
    for Done { unit, found } in done {
        for row in &found.rows {
            case_of(&mut cases, row.study, row.world, unit.1).rows.push(row);
        }
        for fact in &found.facts {
            case_of(&mut cases, fact.study, fact.world, unit.1).facts.push(fact);
        }
    }
    cases.sort_by_key(|case| (case.study, case.world, case.plant));
    cases
}

fn case_of<'a, 'b>(cases: &'b mut Vec<Case<'a>>, study: Study, world: World, plant: u64) -> &'b mut Case<'a> {
    let same = |case: &Case<'_>| (case.study, case.world, case.plant) == (study, world, plant);
    let place = cases.iter().position(same).unwrap_or_else(|| {
        cases.push(Case { study, world, plant, rows: Vec::new(), facts: Vec::new() });
        cases.len() - 1
    });
    &mut cases[place]
}

impl<'a> Case<'a> {
    fn of(&self, method: Method) -> impl Iterator<Item = &'a Row> + '_ {
        self.rows.iter().copied().filter(move |row| row.method == method)
    }

    /// What the numerical model alone chooses.
    pub(super) fn numerical(&self) -> Option<&'a Row> {
        self.of(Method::Numerical).next()
    }

    pub(super) fn center(&self) -> Option<&'a Row> {
        self.of(Method::Center).next()
    }

    pub(super) fn random(&self) -> Vec<&'a Row> {
        self.of(Method::Random).collect()
    }

    /// The seeds with which a method came to an end.
    pub(super) fn seeds(&self, method: Method) -> Vec<u64> {
        let mut seeds: Vec<u64> = self.of(method).map(|row| row.seed).collect();
        seeds.sort_unstable();
        seeds.dedup();
        seeds
    }

    /// A campaign, step by step.
    pub(super) fn path(&self, method: Method, seed: u64) -> Vec<&'a Row> {
        let mut path: Vec<&Row> = self.of(method).filter(|row| row.seed == seed).collect();
        path.sort_by_key(|row| row.step);
        path
    }

    /// Where the campaigns of a method end; all designs of a method without campaigns.
    pub(super) fn ends(&self, method: Method) -> Vec<&'a Row> {
        self.seeds(method).into_iter().filter_map(|seed| self.path(method, seed).last().copied()).collect()
    }

    /// The lowest true cost that is known.
    pub(super) fn best(&self) -> f64 {
        self.rows.iter().map(|row| row.cost()).filter(|cost| cost.is_finite()).fold(f64::INFINITY, f64::min)
    }

    /// How much more than the best a design costs, as a share of the best; infinite where it cannot fly.
    pub(super) fn regret(&self, row: &Row) -> f64 {
        if row.cost().is_finite() { row.cost() / self.best() - 1.0 } else { f64::INFINITY }
    }

    /// Share of the designs that nobody chose that cost less than this one.
    pub(super) fn random_better(&self, row: &Row) -> f64 {
        let random = self.random();
        let better = random
            .iter()
            .filter(|other| other.cost() < row.cost() || (other.cost().is_finite() && !row.cost().is_finite()));
        better.count() as f64 / random.len().max(1) as f64
    }

    pub(super) fn fact(&self, name: &str) -> Option<f64> {
        self.facts.iter().find(|fact| fact.name == name).map(|fact| fact.value)
    }
}
