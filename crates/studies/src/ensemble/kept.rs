//! What is kept, as it is read: cases of a study on a plant in a world, with their campaigns.

use super::file::Setup;
use super::row::{DESIGNS, Fact, Method, Row, Study, World};
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

/// All cases, by study, world and plant; designs of experiments belong to none.
pub(super) fn cases(done: &[Done]) -> Vec<Case<'_>> {
    let mut cases: Vec<Case<'_>> = Vec::new();
    for Done { unit, found } in done.iter().filter(|done| done.unit.0 != DESIGNS) {
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

/// Facts of the searches for designs of experiments, which know no plant.
pub(super) fn searches(done: &[Done]) -> Vec<&Fact> {
    done.iter().filter(|done| done.unit.0 == DESIGNS).flat_map(|done| &done.found.facts).collect()
}

/// A fact by its name.
pub(super) fn value_of(facts: &[&Fact], name: &str) -> Option<f64> {
    facts.iter().find(|fact| fact.name == name).map(|fact| fact.value)
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
        value_of(&self.facts, name)
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::{findings, page};
    use super::*;
    use crate::calibration::Origin;
    use crate::claims::Place;

    /// The searches are kept under the number 0, which may be that of a plant and need not be.
    #[test]
    fn designs_of_experiments_belong_to_no_plant_and_have_seeds_of_their_own() -> anyhow::Result<()> {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let setup = Setup::read_of(&root, Origin::Near)?;
        let store = Store::read(&root.join(Origin::Near.folder()), &setup.key)?;
        let judged = |done: &[Done]| {
            let all = page::judged(&setup, &cases(done), &searches(done));
            let of_designs = all.iter().filter(|both| both.claim.place == Place::Section("5.1".to_owned()));
            let words: Vec<_> = of_designs.flat_map(|both| both.judged.clone().map(|judged| judged.words())).collect();
            (words, findings::counts(&all).concat())
        };
        let five = |n: usize| Some(format!("{n} of 5 cases"));
        let (words, counts) = judged(&store.done);
        assert_eq!(words, [five(5), None, five(0), None]);
        assert!(counts.contains("of 46 claims"), "{counts}");

        let mut others = store.done.clone();
        others.retain(|done| done.unit.1 != 0 || done.unit.0 == DESIGNS);
        assert!(cases(&others).iter().all(|case| case.plant != 0), "no case without a plant");
        assert_eq!(judged(&others).0, words);
        assert!(judged(&others).1.contains("of 46 claims"));

        for done in &mut others {
            done.found.rows.retain(|row| row.seed <= 3);
        }
        assert_eq!(judged(&others).0, words, "five searches, whatever the campaigns have");
        Ok(())
    }
}
