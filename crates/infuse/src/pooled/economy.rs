//! What the runs of a batch cost: a run, and another plant where one is needed.

use std::collections::BTreeSet;

use design_space::Cell;

use crate::pooled::designs::Designs;
use crate::pooled::plants::{Plant, Plants};

/// The plants of a batch so far, and what another costs.
#[derive(Debug, Clone)]
pub(crate) struct Economy<'a> {
    of: Option<(&'a Plants, &'a Designs)>,
    /// Built already, or to be.
    built: Vec<Plant>,
    /// Only these may be picked, if not all.
    only: Option<BTreeSet<Plant>>,
}

impl<'a> Economy<'a> {
    /// Every run is set up anew, if there are no plants.
    pub(crate) fn of(plants: Option<&'a Plants>, designs: &'a Designs) -> Self {
        Self { of: plants.map(|plants| (plants, designs)), built: Vec::new(), only: None }
    }

    /// Only these plants.
    pub(crate) fn confined_to(mut self, plants: &[Plant]) -> Self {
        self.built = plants.to_vec();
        self.only = Some(plants.iter().cloned().collect());
        self
    }

    /// What is learnt at a cell counts this much: 1 over the cost of the run with its plant, 0 if it may not be picked.
    pub(crate) fn weight(&self, cell: Cell) -> f64 {
        let Some((plants, designs)) = self.of else { return 1.0 };
        let plant = plants.of(designs, cell);
        let is_new = !self.built.contains(&plant);
        let is_full = plants.most.is_some_and(|most| self.built.len() >= most);
        if self.only.as_ref().is_some_and(|only| !only.contains(&plant)) || (is_new && is_full) {
            return 0.0;
        }
        1.0 / (1.0 + if is_new { plants.addition(&self.built, &plant) } else { 0.0 })
    }

    /// Whether a cell may be picked at all.
    pub(crate) fn allows(&self, cell: Cell) -> bool {
        self.of.is_none() || self.weight(cell) > 0.0
    }

    /// The cell is part of the batch.
    pub(crate) fn take(&mut self, cell: Cell) {
        if let Some((plants, designs)) = self.of {
            let plant = plants.of(designs, cell);
            if !self.built.contains(&plant) {
                self.built.push(plant);
            }
        }
    }

    /// The plants of the batch, in the order in which they came.
    pub(crate) fn built(&self) -> &[Plant] {
        &self.built
    }
}

#[cfg(test)]
mod tests {
    use design_space::{Parameter, Region};
    use rand::SeedableRng as _;

    use super::*;

    /// Three plants by the first parameter; of two a batch, a change costs half an experiment.
    #[test]
    fn what_may_not_be_built_may_not_be_picked() {
        let number = |name: &str| Parameter::continuous(name, "1", 0.0, 1.0).unwrap().with_levels(3).unwrap();
        let region = Region::new(vec![number("x"), number("y")]).unwrap();
        let designs = Designs::of(&region, &[], &mut rand_chacha::ChaCha8Rng::seed_from_u64(1)).unwrap();
        let cell = |x: u64, y: u64| Cell::new(designs.combinations().index(&[x, y]));
        let mut plants = Plants::of_cost(vec![0], vec![0.5]);
        plants.most = Some(2);
        let mut economy = Economy::of(Some(&plants), &designs);
        assert!((economy.weight(cell(0, 0)) - 1.0 / 1.5).abs() < 1e-15, "the first plant has to be built");
        economy.take(cell(0, 0));
        economy.take(cell(0, 1));
        assert!((economy.weight(cell(0, 2)) - 1.0).abs() < 1e-15, "it is there");
        assert!(economy.allows(cell(1, 0)) && economy.allows(cell(2, 2)), "one more may be built");
        economy.take(cell(2, 2));
        assert_eq!(economy.built(), [vec![0], vec![2]]);
        assert!(!economy.allows(cell(1, 0)), "two are all");
        assert!(economy.allows(cell(0, 2)) && economy.allows(cell(2, 0)), "of those any design");
        let only = Economy::of(Some(&plants), &designs).confined_to(&[vec![1]]);
        assert!(only.allows(cell(1, 2)) && !only.allows(cell(0, 2)), "only the one");
        assert!(Economy::of(None, &designs).allows(cell(1, 0)), "without plants all");
    }
}
