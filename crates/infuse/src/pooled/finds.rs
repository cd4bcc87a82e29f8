//! Finds: designs that were measured to be far better than runs elsewhere say, as a narrow well would show itself that nobody knew of.

use std::collections::{BTreeMap, BTreeSet};

use design_space::Cell;
use rand_chacha::ChaCha8Rng;

use crate::Error;
use crate::pooled::coverage::apart;
use crate::pooled::designs::Designs;
use crate::pooled::knowledge::Knowledge;
use crate::pooled::measurements::Reading;
use crate::pooled::outliers::Outlier;
use crate::pooled::reason::{Pick, Reason};
use crate::pooled::settings::Settings;

/// One run of a batch in so many is made around a find, at least one.
const ONE_IN: usize = 4;
/// Coded, of a width of two. Runs around a find are made within so much, and no nearer than half of it.
const AROUND: f64 = 0.25;
/// An ordinary run within so much shows what lies on its side of a find.
pub(super) const SHOWN: f64 = 0.3;
/// Of what the readings differ by, how deep a well may be of which no more than the rim was met.
const RIM: f64 = 0.5;
/// Cells that are thought of.
const DRAWN: usize = 300;

/// What was found, and has not been looked around yet.
#[derive(Debug, Clone, Default)]
pub(crate) struct Finds {
    /// The best first.
    pub(super) cells: Vec<Cell>,
    /// Those of them to which runs near by are similar, each with what runs elsewhere expect there.
    pub(super) pockets: BTreeMap<Cell, f64>,
    pub(super) runs: Vec<Reading>,
}

/// What a find may hide.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Open {
    pub(crate) find: Cell,
    /// How far below a mean the well may reach of which it is a part.
    pub(crate) reach: f64,
}

impl Finds {
    /// Of readings that the others do not expect, those that are better than that and may be recommended; none where the response is
    /// known to have no narrow well.
    pub(crate) fn of(
        readings: &[Reading],
        unexpected: &[Outlier],
        settings: &Settings,
        may_be_recommended: impl Fn(Cell) -> bool,
    ) -> Self {
        let better = |reading: &&Reading| {
            unexpected.iter().any(|outlier| outlier.reading == reading.number && outlier.deviations < 0.0)
        };
        let cells: BTreeSet<Cell> = match settings.smooth {
            true => BTreeSet::new(),
            false => readings.iter().filter(better).map(|reading| reading.cell).collect(),
        };
        let cells = cells.into_iter().filter(|&cell| may_be_recommended(cell)).collect();
        let mut finds = Self { cells, pockets: BTreeMap::new(), runs: readings.to_vec() };
        finds.sort();
        finds
    }

    /// The best first.
    pub(super) fn sort(&mut self) {
        let runs = &self.runs;
        self.cells.sort_by(|&a, &b| mean_at(runs, a).total_cmp(&mean_at(runs, b)));
    }

    /// The best of them that has sides of which nothing is known, and where to look there.
    fn around(
        &self,
        designs: &Designs,
        taken: &[Cell],
        count: usize,
        rng: &mut ChaCha8Rng,
    ) -> Result<Option<(Cell, Vec<Cell>)>, Error> {
        for &find in &self.cells {
            let cells = self.around_one(find, designs, taken, count, rng)?;
            if !cells.is_empty() {
                return Ok(Some((find, cells)));
            }
        }
        Ok(None)
    }

    /// Where to look around one of them: designs near to it, each on a side where no ordinary run is, nor another of them.
    pub(super) fn around_one(
        &self,
        find: Cell,
        designs: &Designs,
        taken: &[Cell],
        count: usize,
        rng: &mut ChaCha8Rng,
    ) -> Result<Vec<Cell>, Error> {
        let here = designs.coded_of(find)?;
        let ordinary = self.runs.iter().filter(|run| !self.cells.contains(&run.cell));
        let mut runs: Vec<Vec<f64>> = ordinary.map(|run| run.coded.clone()).collect();
        let free = runs.iter().map(|run| apart(&here, run)).fold(f64::INFINITY, f64::min);
        if free == f64::INFINITY {
            return Ok(Vec::new());
        }
        for &cell in taken.iter().filter(|&&cell| cell != find) {
            runs.push(designs.coded_of(cell)?);
        }
        let mut shown: Vec<Vec<f64>> =
            runs.iter().filter(|run| apart(&here, run) <= SHOWN).map(|run| side(&here, run)).collect();
        let mut near = self.near(find, designs, taken, free, rng)?;
        // As many evenly spread sides as there are numbers, and one more, leave none farther from all of them.
        let n_numbers = designs.region().parameters().iter().filter(|one| one.choices().is_none()).count();
        let most = 1.0 / (n_numbers as f64 + 1.0);
        let mut picks = Vec::with_capacity(count);
        while picks.len() < count {
            // The side that is farthest from all that were shown, and there the loneliest.
            let worth = |coded: &Vec<f64>| {
                let there = side(&here, coded);
                let nearest = shown.iter().map(|shown| cosine(shown, &there)).fold(-1.0, f64::max);
                (nearest, runs.iter().map(|run| apart(run, coded)).fold(f64::INFINITY, f64::min))
            };
            let worths: Vec<(f64, f64)> = near.iter().map(|(_, coded)| worth(coded)).collect();
            let order = |&a: &usize, &b: &usize| {
                worths[b].0.total_cmp(&worths[a].0).then(worths[a].1.total_cmp(&worths[b].1)).then(b.cmp(&a))
            };
            let Some(best) = (0..near.len()).filter(|&at| worths[at].0 <= most).max_by(order) else { break };
            let (cell, coded) = near.remove(best);
            picks.push(cell);
            shown.push(side(&here, &coded));
            runs.push(coded);
        }
        Ok(picks)
    }

    /// Designs near to a find that were not run; where the levels are too coarse for that, those that are as near as the nearest run.
    fn near(
        &self,
        find: Cell,
        designs: &Designs,
        taken: &[Cell],
        free: f64,
        rng: &mut ChaCha8Rng,
    ) -> Result<Vec<(Cell, Vec<f64>)>, Error> {
        let here = designs.coded_of(find)?;
        let mut cells: BTreeSet<Cell> = (0..DRAWN).map(|_| designs.near(find, 0.5 * AROUND, rng)).collect();
        cells.extend(designs.star(find, 0.0));
        let is_new = |cell: &Cell| !taken.contains(cell) && self.runs.iter().all(|run| run.cell != *cell);
        let new = cells.into_iter().filter(|cell| is_new(cell) && designs.allows(*cell));
        let new = new.map(|cell| Ok((cell, designs.coded_of(cell)?))).collect::<Result<Vec<_>, Error>>()?;
        let within = |low: f64, high: f64| {
            let is_within = |coded: &[f64]| (low..=high).contains(&apart(&here, coded));
            new.iter().filter(|(_, coded)| is_within(coded)).cloned().collect::<Vec<_>>()
        };
        let is_fine = new.iter().any(|(_, coded)| apart(&here, coded) <= AROUND);
        Ok(if is_fine { within(0.5 * AROUND, AROUND) } else { within(0.0, free) })
    }

    /// Some of the picks of a batch are made around a find instead: the last ones of the commonest reason.
    pub(crate) fn look_around(
        &self,
        designs: &Designs,
        picks: &mut [Pick],
        pending: &[Cell],
        may_be_picked: impl Fn(Cell) -> bool,
        rng: &mut ChaCha8Rng,
    ) -> Result<(), Error> {
        let taken: Vec<Cell> = pending.iter().copied().chain(Pick::cells(picks)).collect();
        let count = (picks.len() / ONE_IN).max(1);
        let cells = self.around(designs, &taken, count, rng)?.map_or_else(Vec::new, |(_, cells)| cells);
        let n_of = |is_of: fn(Reason) -> bool| picks.iter().filter(|pick| is_of(pick.reason)).count();
        let covers: fn(Reason) -> bool = |reason| reason == Reason::Coverage;
        let is_commonest = if n_of(Reason::is_gain) >= n_of(covers) { Reason::is_gain } else { covers };
        let common = picks.iter_mut().rev().filter(|pick| is_commonest(pick.reason));
        for (pick, cell) in common.zip(cells.into_iter().filter(|&cell| may_be_picked(cell))) {
            *pick = Pick { cell, reason: Reason::Around };
        }
        Ok(())
    }

    /// The best of them that was not looked around, and how far below this mean the well may reach of which it is a part: twice as deep
    /// as it was seen to be, or as deep as half of what the readings differ by, as it may have been met at its rim.
    pub(crate) fn open(
        &self,
        knowledge: &mut Knowledge<'_, '_>,
        settings: &Settings,
        mean: f64,
        rng: &mut ChaCha8Rng,
    ) -> Result<Option<Open>, Error> {
        let open = self.around(knowledge.designs, &[], 1, rng)?;
        let find = open.and_then(|(find, _)| self.runs.iter().find(|run| run.cell == find));
        let Some(find) = find else { return Ok(None) };
        let found = mean_at(&self.runs, find.cell);
        let expected = match self.pockets.get(&find.cell) {
            Some(&expected) => expected,
            None => {
                let is_found = |run: &Reading| self.cells.contains(&run.cell);
                knowledge.seen_from(&self.runs, is_found, find, settings)?.mean
            }
        };
        let depth = (expected - found).max(RIM * Reading::range(&self.runs));
        Ok(Some(Open { find: find.cell, reach: (mean - (found - depth)).max(0.0) }))
    }
}

/// The direction from one place to another.
fn side(from: &[f64], to: &[f64]) -> Vec<f64> {
    let length = apart(from, to);
    from.iter().zip(to).map(|(from, to)| (to - from) / length).collect()
}

/// Of the angle between two directions.
fn cosine(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// What was measured at a cell.
pub(super) fn mean_at(readings: &[Reading], cell: Cell) -> f64 {
    let here = readings.iter().filter(|reading| reading.cell == cell).map(|reading| reading.response);
    here.clone().sum::<f64>() / here.count() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pooled::scene::Scene;
    use crate::pooled::streams::{Purpose, stream};

    fn finds(scene: &Scene, unexpected: &[(usize, f64)]) -> Finds {
        let outlier = |&(reading, deviations)| Outlier { reading, deviations, set_aside: false };
        let unexpected: Vec<Outlier> = unexpected.iter().map(outlier).collect();
        Finds::of(&scene.readings, &unexpected, &scene.settings, |cell| scene.designs.allows(cell))
    }

    /// A bowl of 21 × 21 designs that was run here and there, and one reading more.
    fn bowl(at: [u64; 2], below: f64) -> Scene {
        let mut scene = Scene::new(&[21, 21]);
        let height = |[x, y]: [u64; 2]| (0.1 * x as f64 - 1.0).powi(2) + (0.1 * y as f64 - 1.0).powi(2);
        for run in [[0, 0], [0, 20], [20, 0], [20, 20], [10, 10], [4, 12], [12, 4], [15, 9], [9, 1], [1, 7], [11, 18]] {
            scene.read(&run, height(run));
        }
        scene.read(&at, height(at) - below);
        scene
    }

    #[test]
    fn finds_are_what_was_measured_better_than_expected_the_best_first() {
        let mut scene = bowl([16, 15], 0.5);
        let [one, other] = [scene.readings[11].cell, scene.readings[3].cell];
        let all = [(3, -5.0), (4, 9.0), (11, -6.0)];
        assert_eq!(finds(&scene, &all).cells, [one, other], "0.11 and 2");
        scene.read(&[16, 15], 9.0);
        assert_eq!(finds(&scene, &all).cells, [other, one], "2 and 4.555 in the mean");
        let unexpected = [Outlier { reading: 11, deviations: -6.0, set_aside: false }];
        assert!(Finds::of(&scene.readings, &unexpected, &scene.settings, |_| false).cells.is_empty());
        scene.settings.smooth = true;
        assert!(finds(&scene, &all).cells.is_empty(), "there is no well");
    }

    /// Of four runs on a circle two are at right angles to both others, and so on in three numbers; a fifth side is none.
    #[test]
    fn around_a_find_each_run_is_made_on_another_side() {
        for n in [1, 2, 3] {
            let mut scene = Scene::new(&vec![41; n]);
            for corner in [0, 40] {
                scene.read(&vec![corner; n], 1.0);
            }
            scene.read(&vec![20; n], -1.0);
            let found = finds(&scene, &[(2, -6.0)]);
            let here = scene.designs.coded_of(scene.readings[2].cell).unwrap();
            for batch in 0..10 {
                let mut rng = stream(1, Purpose::Finds, batch);
                let (find, cells) = found.around(&scene.designs, &[], 99, &mut rng).unwrap().unwrap();
                assert_eq!(find, scene.readings[2].cell);
                let coded: Vec<Vec<f64>> = cells.iter().map(|&cell| scene.designs.coded_of(cell).unwrap()).collect();
                assert!((n + 1..=2 * n).contains(&cells.len()), "{n} numbers: {coded:?}");
                let sides: Vec<Vec<f64>> = coded.iter().map(|coded| side(&here, coded)).collect();
                for (at, coded) in coded.iter().enumerate() {
                    assert!((0.5 * AROUND..=AROUND).contains(&apart(&here, coded)), "{coded:?}");
                    let nearest = sides[..at].iter().map(|other| cosine(other, &sides[at])).fold(-1.0, f64::max);
                    assert!(nearest <= 1.0 / (n as f64 + 1.0) + 1e-12, "{nearest} of {sides:?}");
                }
                // What is pending counts as run: one side less.
                let (_, rest) = found.around(&scene.designs, &cells[..1], 99, &mut rng).unwrap().unwrap();
                assert!(rest.iter().all(|cell| *cell != cells[0]) && rest.len() < 2 * n, "{rest:?}");
                assert!(found.around(&scene.designs, &cells, 99, &mut rng).unwrap().is_none(), "all were shown");
            }
        }
    }

    #[test]
    fn where_the_levels_are_coarse_the_nearest_are_looked_at_and_then_no_more() {
        let mut scene = Scene::new(&[5, 5]);
        for (x, y) in [(0, 0), (4, 0), (0, 4), (4, 4), (2, 2), (2, 3)] {
            scene.read(&[x, y], 1.0);
        }
        let mut rng = stream(1, Purpose::Finds, 1);
        let mut around = |scene: &Scene| {
            let around = finds(scene, &[(4, -9.0)]).around(&scene.designs, &[], 9, &mut rng).unwrap();
            around.map_or_else(BTreeSet::new, |(_, cells)| BTreeSet::from_iter(cells))
        };
        let nearest = [[1, 2], [2, 1], [3, 2]].map(|digits| scene.cell(&digits));
        assert_eq!(around(&scene), BTreeSet::from(nearest), "as far away as the next run");
        for (x, y) in [(1, 2), (2, 1), (3, 2)] {
            scene.read(&[x, y], 1.0);
        }
        assert_eq!(around(&scene), BTreeSet::new());
    }

    /// One ordinary run beside a find shows one side of it. When all are shown, the next best find is looked around.
    #[test]
    fn a_find_is_looked_around_until_all_its_sides_were_shown() {
        let mut scene = Scene::new(&[41, 41]);
        for (x, y) in [(0, 0), (40, 0), (0, 40), (40, 40), (20, 20), (30, 10)] {
            scene.read(&[x, y], 1.0 + 1e-3 * x as f64);
        }
        let first = [scene.readings[4].cell, scene.readings[5].cell];
        for (number, (x, y)) in [(24, 20), (18, 24), (18, 16)].into_iter().enumerate() {
            let found = finds(&scene, &[(4, -9.0), (5, -9.0)]);
            let mut rng = stream(1, Purpose::Finds, 1);
            let (find, cells) = found.around(&scene.designs, &[], 1, &mut rng).unwrap().unwrap();
            assert_eq!((find, cells.len()), (first[0], 1), "{number} sides were shown");
            scene.read(&[x, y], 1.0);
        }
        let found = finds(&scene, &[(4, -9.0), (5, -9.0)]);
        let (find, _) = found.around(&scene.designs, &[], 1, &mut stream(1, Purpose::Finds, 1)).unwrap().unwrap();
        assert_eq!(find, first[1]);
    }

    #[test]
    fn the_last_picks_of_the_commonest_reason_are_made_around_the_find() {
        let scene = bowl([16, 15], 0.5);
        let found = finds(&scene, &[(11, -6.0)]);
        let (g, c, a) = (Reason::Gain, Reason::Coverage, Reason::Again);
        for (reasons, moved) in [
            (vec![a, g, g, g, g, Reason::Doubt, c, c], vec![3, 4]),
            (vec![a, g, g, g, g, g, g, g, g, Reason::Doubt, c, c], vec![6, 7, 8]),
            (vec![a, g, c, c, c, c, Reason::Doubt, c], vec![5, 7]),
            (vec![g, g, c, c], vec![1]),
            (vec![g, c, g], vec![2]),
            (vec![a], vec![]),
        ] {
            let cell = scene.cell(&[5, 5]);
            let before: Vec<Pick> = reasons.iter().map(|&reason| Pick { cell, reason }).collect();
            let look = |may_be_picked: bool| {
                let mut picks = before.clone();
                let mut rng = stream(1, Purpose::Finds, 1);
                found.look_around(&scene.designs, &mut picks, &[], |_| may_be_picked, &mut rng).unwrap();
                picks
            };
            let picks = look(true);
            let changed: Vec<usize> = (0..picks.len()).filter(|&at| picks[at] != before[at]).collect();
            assert_eq!(changed, moved, "{reasons:?}");
            assert!(moved.iter().all(|&at| picks[at].reason == Reason::Around));
            assert_eq!(look(false), before, "another plant would be needed");
        }
    }

    /// The bowl is at 0.61 where −0.89 was found; so it may go down to −2.39. Where 0.56 was found, and readings differ by 2, to −0.44.
    #[test]
    fn a_well_may_be_twice_as_deep_as_it_was_seen_to_be_or_half_of_what_readings_differ_by() {
        let reach = |scene: &mut Scene, deviations: f64, mean: f64| {
            let (found, settings) = (finds(scene, &[(11, deviations)]), scene.settings.clone());
            let mut rng = stream(1, Purpose::Finds, 1);
            let open = found.open(&mut scene.knowledge(None), &settings, mean, &mut rng).unwrap();
            open.map_or(0.0, |open| open.reach)
        };
        for (below, mean, expected) in
            [(1.5, 0.0, 2.39), (1.5, -2.0, 0.39), (1.5, -3.0, 0.0), (0.05, 0.0, 0.44), (0.05, 0.2, 0.64)]
        {
            let mut scene = bowl([16, 15], below);
            let found = reach(&mut scene, -6.0, mean);
            assert!((found - expected).abs() < 0.03, "{found} below {mean}, found {below}");
            assert!(reach(&mut scene, 6.0, mean) <= 0.0, "it is above");
        }
    }
}
