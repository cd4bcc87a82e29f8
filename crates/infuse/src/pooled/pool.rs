//! The cells among which the next experiments, and the best design, are looked for.

use std::collections::BTreeSet;

use design_space::Cell;
use rand::RngExt;
use surface::process::{Marginals, Places};

use crate::Error;
use crate::pooled::held::Chances;
use crate::pooled::knowledge::Knowledge;
use crate::pooled::streams::{Purpose, stream};

/// Grids of up to this many cells are their own pool.
const SMALL: u64 = 600;
const RANDOM: usize = 2500;
const LOWEST_SIMULATED: usize = 400;
const STARTS: usize = 6;
const AROUND: usize = 40;
/// How far around, as a share of the ranges.
const FARTHEST: f64 = 0.3;
/// The same of the best that were found so, where a simulation is run everywhere: the surface is then as finely featured as that is.
const FARTHEST_AGAIN: f64 = 0.1;
const PROMISING: usize = 375;
/// So many of the promising ones are the sceptic's: where the simulation misleads, what it calls bad is never promising to who
/// believes it.
const DOUBTED: usize = 100;
const OTHERS: usize = 125;

/// Cells with their places, and what the surface says of each.
#[derive(Debug, Clone)]
pub(crate) struct Pool {
    pub(crate) cells: Vec<Cell>,
    pub(crate) places: Places,
    pub(crate) marginals: Marginals,
    pub(crate) chances: Chances,
    /// Those of a large grid that were drawn evenly.
    pub(crate) random: Vec<Cell>,
}

impl Pool {
    fn of(knowledge: &mut Knowledge<'_, '_>, cells: Vec<Cell>) -> Result<Self, Error> {
        let places = knowledge.places(&cells)?;
        let marginals = knowledge.marginals(&places)?;
        let chances = knowledge.chances(&cells, &places)?;
        Ok(Self { cells, places, marginals, chances, random: Vec::new() })
    }

    fn select(&self, rows: &[usize]) -> Self {
        let pick = |values: &[f64]| rows.iter().map(|&row| values[row]).collect();
        Self {
            cells: rows.iter().map(|&row| self.cells[row]).collect(),
            places: self.places.select(rows),
            marginals: Marginals { means: pick(&self.marginals.means), variances: pick(&self.marginals.variances) },
            chances: self.chances.select(rows),
            random: Vec::new(),
        }
    }

    /// Rows that may come to be recommended, by growing mean − z standard deviations; all rows if none may.
    pub(crate) fn by_lower_bound(&self, z: f64) -> Vec<usize> {
        self.by_lower_bound_of(&self.marginals, z)
    }

    /// The same for what another surface says of the cells.
    pub(crate) fn by_lower_bound_of(&self, marginals: &Marginals, z: f64) -> Vec<usize> {
        let bound = |row: usize| marginals.means[row] - z * marginals.variances[row].sqrt();
        let mut rows: Vec<usize> = (0..self.cells.len()).filter(|&row| self.chances.possible[row]).collect();
        if rows.is_empty() {
            rows = (0..self.cells.len()).collect();
        }
        rows.sort_by(|&a, &b| bound(a).total_cmp(&bound(b)).then(a.cmp(&b)));
        rows
    }

    /// The first rows of this order.
    pub(crate) fn first(&self, order: &[usize], count: usize) -> Self {
        self.select(&order[..count.min(order.len())])
    }

    /// The cells that may matter: all of a small grid, otherwise random ones, tested ones, those that the simulation likes, and
    /// those around the lowest found by descent.
    pub(crate) fn gather(knowledge: &mut Knowledge<'_, '_>, seed: u64, batch: usize) -> Result<Self, Error> {
        if knowledge.designs.n_cells() <= SMALL {
            let cells = knowledge.designs.cells().collect();
            return Self::of(knowledge, cells);
        }
        let mut rng = stream(seed, Purpose::Pool, batch);
        let designs = knowledge.designs;
        let random: Vec<Cell> = (0..RANDOM).map(|_| designs.random(&mut rng)).collect();
        let mut cells: BTreeSet<Cell> = random.iter().copied().collect();
        cells.extend(knowledge.lowest_simulated(LOWEST_SIMULATED));
        cells.extend(&knowledge.measured);
        cells.retain(|&cell| designs.allows(cell));
        let coarse = Self::of(knowledge, cells.iter().copied().collect())?;
        let mut pool = coarse;
        let again = knowledge.is_simulated_everywhere().then_some(FARTHEST_AGAIN);
        for farthest in [FARTHEST].into_iter().chain(again) {
            let mut starts: Vec<Cell> = pool.first(&pool.by_lower_bound(0.0), STARTS).cells;
            starts.extend(pool.first(&pool.by_lower_bound(2.0), STARTS).cells);
            let mut around = BTreeSet::new();
            for start in starts {
                for _ in 0..AROUND {
                    let share = farthest * rng.random::<f64>().powi(2);
                    around.insert(designs.near(start, share, &mut rng));
                }
            }
            let around: Vec<Cell> = around.into_iter().filter(|&cell| cells.insert(cell)).collect();
            let finer = Self::of(knowledge, around)?;
            pool = pool.followed_by(finer)?;
        }
        Ok(Self { random, ..pool })
    }

    fn followed_by(self, other: Self) -> Result<Self, Error> {
        let cells: Vec<Cell> = self.cells.iter().chain(&other.cells).copied().collect();
        let chain = |a: &[f64], b: &[f64]| a.iter().chain(b).copied().collect::<Vec<f64>>();
        let marginals = Marginals {
            means: chain(&self.marginals.means, &other.marginals.means),
            variances: chain(&self.marginals.variances, &other.marginals.variances),
        };
        let (places, chances) = (self.places.followed_by(&other.places)?, self.chances.followed_by(other.chances));
        Ok(Self { cells, places, marginals, chances, random: Vec::new() })
    }

    /// The same with other cells, too.
    pub(crate) fn with(self, knowledge: &mut Knowledge<'_, '_>, cells: &[Cell]) -> Result<Self, Error> {
        let known: BTreeSet<Cell> = self.cells.iter().copied().collect();
        let new: Vec<Cell> = cells.iter().copied().filter(|cell| !known.contains(cell)).collect();
        if new.is_empty() {
            return Ok(self);
        }
        let more = Self::of(knowledge, new)?;
        self.followed_by(more)
    }

    /// The part of it on which joint distributions are affordable: the promising cells, those that the sceptic finds promising, if
    /// there is one, and others at random.
    pub(crate) fn reduced(&self, sceptic: Option<&Marginals>, seed: u64, batch: usize) -> Self {
        let order = self.by_lower_bound(2.0);
        if self.cells.len() <= SMALL as usize {
            return self.clone();
        }
        // Of a large pool few may be possible; the others would make it slow and are not thought of.
        if order.len() <= SMALL as usize {
            return self.select(&order);
        }
        let n_doubted = sceptic.map_or(0, |_| DOUBTED);
        let mut rows = order[..PROMISING - n_doubted].to_vec();
        let mut chosen: BTreeSet<usize> = rows.iter().copied().collect();
        let doubted = sceptic.map(|marginals| self.by_lower_bound_of(marginals, 2.0)).unwrap_or_default();
        rows.extend(doubted.into_iter().filter(|&row| chosen.insert(row)).take(n_doubted));
        let mut left: Vec<usize> = order.into_iter().filter(|row| !chosen.contains(row)).collect();
        let mut rng = stream(seed, Purpose::Pool, batch);
        rng.set_word_pos(1 << 32);
        for _ in 0..OTHERS.min(left.len()) {
            let index = rng.random_range(0..left.len());
            rows.push(left.swap_remove(index));
        }
        self.select(&rows)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pooled::scene::Scene;

    /// 30 levels of two numbers, a valley along the diagonal.
    fn valley() -> Scene {
        let mut scene = Scene::new(&[30, 30]);
        for (x, y) in [(0, 0), (29, 29), (3, 21), (22, 8), (15, 14), (9, 2), (12, 27)] {
            let (a, b) = (x as f64 / 29.0, y as f64 / 29.0);
            scene.read(&[x, y], 4.0 * (a - b).powi(2) + 0.1 * a);
        }
        scene
    }

    #[test]
    fn a_cell_is_in_a_pool_once() {
        let mut scene = valley();
        let mut knowledge = scene.knowledge(None);
        let pool = Pool::gather(&mut knowledge, 1, 0).unwrap();
        let distinct: BTreeSet<Cell> = pool.cells.iter().copied().collect();
        assert_eq!(distinct.len(), pool.cells.len());
        assert!(pool.cells.len() <= 900 && pool.cells.len() > SMALL as usize, "{}", pool.cells.len());
        assert_eq!(pool.marginals.means.len(), pool.cells.len());
    }

    /// Joint distributions are affordable on 500 cells: the 375 most promising, and others.
    #[test]
    fn a_large_pool_is_reduced_to_what_is_promising_and_others() {
        let mut scene = valley();
        let mut knowledge = scene.knowledge(None);
        let pool = Pool::gather(&mut knowledge, 1, 0).unwrap();
        let reduced = pool.reduced(None, 1, 0);
        assert_eq!(reduced.cells.len(), PROMISING + OTHERS);
        let promising: Vec<Cell> = pool.by_lower_bound(2.0)[..PROMISING].iter().map(|&row| pool.cells[row]).collect();
        assert_eq!(reduced.cells[..PROMISING], promising);
        let few = pool.first(&pool.by_lower_bound(2.0), SMALL as usize);
        assert_eq!(few.reduced(None, 1, 0).cells, few.cells, "so many are affordable");
    }
}
