//! Finds: designs that were measured to be far better than all others say, as a narrow well would show itself that nobody knew of.

use std::collections::BTreeSet;

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

/// So many runs of a batch are made around a find, and of a small batch one in so many.
const AROUND: usize = 2;
const ONE_IN: usize = 4;
/// They keep within so much of the distance to the nearest run that nobody wonders at: a well that it missed is no wider.
const REACH: f64 = 0.6;
/// Coded, of a width of two. A find to which an ordinary run is nearer has been looked around.
const EXPLORED: f64 = 0.1;
/// Cells that are thought of.
const DRAWN: usize = 300;

/// What was found, and has not been looked around yet.
#[derive(Debug, Clone, Default)]
pub(crate) struct Finds {
    /// The best first.
    cells: Vec<Cell>,
    runs: Vec<Reading>,
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
        let mut cells: Vec<Cell> = cells.into_iter().filter(|&cell| may_be_recommended(cell)).collect();
        let runs = readings.to_vec();
        cells.sort_by(|&a, &b| mean_at(&runs, a).total_cmp(&mean_at(&runs, b)));
        Self { cells, runs }
    }

    /// Where to look around the best of them: designs that are far from all runs, and near to it.
    fn around(
        &self,
        designs: &Designs,
        taken: &[Cell],
        count: usize,
        rng: &mut ChaCha8Rng,
    ) -> Result<Vec<Cell>, Error> {
        let Some(&find) = self.cells.first() else { return Ok(Vec::new()) };
        let here = designs.coded_of(find)?;
        let ordinary = self.runs.iter().filter(|run| !self.cells.contains(&run.cell));
        let free = ordinary.map(|run| apart(&here, &run.coded)).fold(f64::INFINITY, f64::min);
        if !(EXPLORED..f64::INFINITY).contains(&free) {
            return Ok(Vec::new());
        }
        let mut cells: BTreeSet<Cell> = (0..DRAWN).map(|_| designs.near(find, 0.5 * REACH * free, rng)).collect();
        cells.extend(designs.star(find, 0.0));
        let mut runs: Vec<Vec<f64>> = self.runs.iter().map(|run| run.coded.clone()).collect();
        for &cell in taken {
            runs.push(designs.coded_of(cell)?);
        }
        let is_new = |cell: &Cell| !taken.contains(cell) && self.runs.iter().all(|run| run.cell != *cell);
        let mut near = Vec::new();
        for cell in cells.into_iter().filter(|cell| is_new(cell) && designs.allows(*cell)) {
            let coded = designs.coded_of(cell)?;
            let distance = apart(&here, &coded);
            if distance <= free {
                near.push((cell, coded, distance));
            }
        }
        let mut picks = Vec::with_capacity(count);
        while picks.len() < count && !near.is_empty() {
            // Of those within reach the loneliest, and where the levels are too coarse for that the nearest.
            let worth = |(_, coded, distance): &(Cell, Vec<f64>, f64)| match *distance <= REACH * free {
                true => (true, runs.iter().map(|run| apart(run, coded)).fold(f64::INFINITY, f64::min)),
                false => (false, -distance),
            };
            let worths: Vec<(bool, f64)> = near.iter().map(worth).collect();
            let order = |&a: &usize, &b: &usize| {
                worths[a].0.cmp(&worths[b].0).then(worths[a].1.total_cmp(&worths[b].1)).then(b.cmp(&a))
            };
            let best = (0..near.len()).max_by(order).unwrap_or(0);
            let (cell, coded, _) = near.remove(best);
            picks.push(cell);
            runs.push(coded);
        }
        Ok(picks)
    }

    /// Some of the picks of a batch are made around the best find instead: the last ones of the commonest reason.
    pub(crate) fn look_around(
        &self,
        designs: &Designs,
        picks: &mut [Pick],
        pending: &[Cell],
        may_be_picked: impl Fn(Cell) -> bool,
        rng: &mut ChaCha8Rng,
    ) -> Result<(), Error> {
        let taken: Vec<Cell> = pending.iter().copied().chain(Pick::cells(picks)).collect();
        let count = AROUND.min((picks.len() / ONE_IN).max(1));
        let cells = self.around(designs, &taken, count, rng)?;
        let n_of = |reason: Reason| picks.iter().filter(|pick| pick.reason == reason).count();
        let commonest = if n_of(Reason::Gain) >= n_of(Reason::Coverage) { Reason::Gain } else { Reason::Coverage };
        let common = picks.iter_mut().rev().filter(|pick| pick.reason == commonest);
        for (pick, cell) in common.zip(cells.into_iter().filter(|&cell| may_be_picked(cell))) {
            *pick = Pick { cell, reason: Reason::Around };
        }
        Ok(())
    }

    /// How far below this mean the well may reach of which the best of them is a part: twice as deep as it was seen to be. Zero where
    /// there is none that was not looked around.
    pub(crate) fn may_reach(
        &self,
        knowledge: &mut Knowledge<'_, '_>,
        settings: &Settings,
        mean: f64,
        rng: &mut ChaCha8Rng,
    ) -> Result<f64, Error> {
        let find = self.cells.first().and_then(|&find| self.runs.iter().find(|run| run.cell == find));
        let (Some(find), false) = (find, self.around(knowledge.designs, &[], 1, rng)?.is_empty()) else {
            return Ok(0.0);
        };
        let found = mean_at(&self.runs, find.cell);
        let is_found = |run: &Reading| self.cells.contains(&run.cell);
        let expected = knowledge.seen_from(&self.runs, is_found, find, settings)?.mean;
        Ok((mean - (found - (expected - found))).max(0.0))
    }
}

/// What was measured at a cell.
fn mean_at(readings: &[Reading], cell: Cell) -> f64 {
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

    /// The nearest ordinary run is [11, 18], at 5.83 steps of a tenth.
    #[test]
    fn around_a_find_is_nearer_to_it_than_any_ordinary_run() {
        let scene = bowl([16, 15], 0.5);
        let (found, free) = (finds(&scene, &[(11, -6.0)]), 0.1 * 34.0_f64.sqrt());
        let here = scene.designs.coded_of(scene.readings[11].cell).unwrap();
        for batch in 0..20 {
            let mut rng = stream(1, Purpose::Finds, batch);
            let cells = found.around(&scene.designs, &[], 3, &mut rng).unwrap();
            let coded: Vec<Vec<f64>> = cells.iter().map(|&cell| scene.designs.coded_of(cell).unwrap()).collect();
            assert_eq!(cells.len(), 3);
            for (at, place) in coded.iter().enumerate() {
                let distance = apart(&here, place);
                assert!(distance > 0.0 && distance <= REACH * free + 1e-12, "{distance}");
                // Each is far from the find and from those before it.
                let nearest = coded[..at].iter().map(|other| apart(place, other)).fold(distance, f64::min);
                assert!(nearest > 0.5 * REACH * free, "{nearest} from {coded:?}");
            }
            let again = found.around(&scene.designs, &cells, 1, &mut rng).unwrap();
            assert!(!cells.contains(&again[0]), "what is pending is not picked again");
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
            let cells = finds(scene, &[(4, -9.0)]).around(&scene.designs, &[], 9, &mut rng).unwrap();
            BTreeSet::from_iter(cells)
        };
        let nearest = [[1, 2], [2, 1], [3, 2]].map(|digits| scene.cell(&digits));
        assert_eq!(around(&scene), BTreeSet::from(nearest), "as far away as the next run");
        for (x, y) in [(1, 2), (2, 1), (3, 2)] {
            scene.read(&[x, y], 1.0);
        }
        assert_eq!(around(&scene), BTreeSet::new());
    }

    /// A tenth of half the width away there is nothing that a well could hide.
    #[test]
    fn what_was_looked_around_is_not_looked_around_again() {
        for (step, is_explored) in [(1, true), (2, false)] {
            let mut scene = Scene::new(&[41, 41]);
            for (x, y) in [(0, 0), (40, 0), (0, 40), (40, 40), (20, 20), (20 + step, 20)] {
                scene.read(&[x, y], 1.0);
            }
            let found = finds(&scene, &[(4, -9.0)]);
            let cells = found.around(&scene.designs, &[], 2, &mut stream(1, Purpose::Finds, 1)).unwrap();
            assert_eq!(cells.is_empty(), is_explored, "{step} steps of a twentieth");
        }
    }

    #[test]
    fn the_last_picks_of_the_commonest_reason_are_made_around_the_find() {
        let scene = bowl([16, 15], 0.5);
        let found = finds(&scene, &[(11, -6.0)]);
        let (g, c, a) = (Reason::Gain, Reason::Coverage, Reason::Again);
        for (reasons, moved) in [
            (vec![a, g, g, g, g, Reason::Doubt, c, c], vec![3, 4]),
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

    /// The bowl is at 0.61 where 0.11 was found; so it may go down to −0.39.
    #[test]
    fn a_well_may_be_twice_as_deep_as_it_was_seen_to_be() {
        let mut scene = bowl([16, 15], 0.5);
        let (found, settings) = (finds(&scene, &[(11, -6.0)]), scene.settings.clone());
        let reach = |found: &Finds, scene: &mut Scene, mean: f64| {
            let mut rng = stream(1, Purpose::Finds, 1);
            found.may_reach(&mut scene.knowledge(None), &settings, mean, &mut rng).unwrap()
        };
        for (mean, expected) in [(0.0, 0.39), (0.2, 0.59), (-0.3, 0.09), (-0.5, 0.0)] {
            let found = reach(&found, &mut scene, mean);
            assert!((found - expected).abs() < 0.02, "{found} below {mean}");
        }
        assert!(reach(&finds(&scene, &[(11, 6.0)]), &mut scene, 0.0) <= 0.0, "it is above");
        // Two steps from an ordinary run something may be hidden; another find is none.
        for (run, response) in [([16, 17], 0.85), ([16, 16], 0.2)] {
            scene.read(&run, response);
            let found = finds(&scene, &[(11, -6.0), (13, -6.0)]);
            assert!(reach(&found, &mut scene, 0.0) > 0.3, "{run:?}");
        }
    }
}
