//! Pockets: a few runs near to each other, all far better than runs elsewhere say. Each explains the others, so that none is an outlier,
//! and still nobody has seen the bottom.

use std::collections::BTreeSet;

use design_space::Cell;
use rand_chacha::ChaCha8Rng;

use crate::Error;
use crate::pooled::coverage::apart;
use crate::pooled::finds::{Finds, SHOWN, mean_at};
use crate::pooled::knowledge::Knowledge;
use crate::pooled::measurements::Reading;
use crate::pooled::outliers::STRIKING_TO_OTHERS;
use crate::pooled::settings::Settings;

/// Coded, of a width of two. Runs within so much of the best of a pocket are not asked what they expect there.
const POCKET: f64 = 0.5;
/// So many designs are looked at, the best first.
const LOOKED_AT: usize = 2;

impl Finds {
    /// The same with designs that are better than all within a pocket, have a run near by, and are far better than runs outside of it
    /// say; none where the response is known to have no narrow well.
    pub(crate) fn with_pockets(
        mut self,
        knowledge: &mut Knowledge<'_, '_>,
        settings: &Settings,
        may_be_recommended: impl Fn(Cell) -> bool,
        rng: &mut ChaCha8Rng,
    ) -> Result<Self, Error> {
        if settings.smooth {
            return Ok(self);
        }
        let mut lowest = self.lowest_with_neighbors(knowledge)?;
        lowest.retain(|&cell| may_be_recommended(cell));
        let mut n_looked_at = 0;
        for cell in lowest {
            if n_looked_at == LOOKED_AT {
                break;
            }
            let Some(one) = self.runs.iter().find(|run| run.cell == cell) else { continue };
            let is_elsewhere = |run: &Reading| apart(&run.coded, &one.coded) > POCKET;
            let n_elsewhere = self.runs.iter().filter(|run| is_elsewhere(run)).count();
            // What has been looked around is none, whatever the others say.
            if n_elsewhere < knowledge.designs.n_to_tell()
                || self.around_one(cell, knowledge.designs, &[], 1, rng)?.is_empty()
            {
                continue;
            }
            n_looked_at += 1;
            let best = Reading { response: mean_at(&self.runs, cell), ..one.clone() };
            let view = knowledge.seen_from(&self.runs, |run| !is_elsewhere(run), one, settings)?;
            if view.of(&best) < -STRIKING_TO_OTHERS {
                self.pockets.insert(cell, view.mean);
            }
        }
        self.cells.extend(self.pockets.keys());
        self.sort();
        Ok(self)
    }

    /// Designs with a neighbor that are no finds and better than all others within a pocket, the best first.
    fn lowest_with_neighbors(&self, knowledge: &Knowledge<'_, '_>) -> Result<Vec<Cell>, Error> {
        let cells: BTreeSet<Cell> = self.runs.iter().map(|run| run.cell).collect();
        let known =
            cells.into_iter().map(|cell| Ok((cell, knowledge.designs.coded_of(cell)?, mean_at(&self.runs, cell))));
        let known = known.collect::<Result<Vec<_>, Error>>()?;
        let mut lowest: Vec<(Cell, f64)> = Vec::new();
        for (cell, coded, mean) in &known {
            let others = || known.iter().filter(|(other, ..)| other != cell);
            // The first of equals.
            let is_behind = |other: Cell, height: f64| height.total_cmp(mean).then(other.cmp(cell)).is_gt();
            let is_lowest =
                others().all(|(other, there, height)| apart(there, coded) > POCKET || is_behind(*other, *height));
            let has_neighbor = others().any(|(_, there, _)| apart(there, coded) <= SHOWN);
            if is_lowest && has_neighbor && !self.cells.contains(cell) {
                lowest.push((*cell, *mean));
            }
        }
        lowest.sort_by(|a, b| a.1.total_cmp(&b.1));
        Ok(lowest.into_iter().map(|(cell, _)| cell).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pooled::scene::Scene;
    use crate::pooled::streams::{Purpose, stream};

    /// A bowl of 21 × 21 designs that was run here and there, with runs in a pit that is so much below it.
    fn bowl(pit: &[[u64; 2]], below: f64) -> Scene {
        let mut scene = Scene::new(&[21, 21]);
        scene.settings.noise = Some(0.0);
        let height = |[x, y]: [u64; 2]| (0.1 * x as f64 - 1.0).powi(2) + (0.1 * y as f64 - 1.0).powi(2);
        for run in [[0, 0], [0, 20], [20, 0], [20, 20], [10, 10], [4, 12], [12, 4], [15, 5], [9, 1], [1, 7], [11, 18]] {
            scene.read(&run, height(run));
        }
        pit.iter().for_each(|&run| scene.read(&run, height(run) - below));
        scene
    }

    fn finds(scene: &mut Scene, may_be_recommended: impl Fn(Cell) -> bool) -> Finds {
        let (readings, settings) = (scene.readings.clone(), scene.settings.clone());
        let finds = Finds::of(&readings, &[], &settings, |_| true);
        let mut rng = stream(1, Purpose::Finds, 1);
        finds.with_pockets(&mut scene.knowledge(None), &settings, may_be_recommended, &mut rng).unwrap()
    }

    #[test]
    fn the_best_of_runs_that_agree_is_a_find_where_runs_elsewhere_say_otherwise() {
        let pit = [[16, 15], [15, 16], [17, 16]];
        let best = |scene: &Scene, at: usize| scene.readings[at].cell;
        let mut scene = bowl(&pit, 0.5);
        let found = finds(&mut scene, |_| true);
        assert_eq!(found.cells, [best(&scene, 12)], "0.11 of 0.11, 0.11 and 0.35, the first of equals");
        assert!(found.pockets.keys().eq(&found.cells), "{:?}", found.pockets);
        assert!(finds(&mut scene, |_| false).cells.is_empty(), "it may not be recommended");
        scene.settings.smooth = true;
        assert!(finds(&mut scene, |_| true).cells.is_empty(), "there is no well");
        assert!(finds(&mut bowl(&pit, 0.0), |_| true).cells.is_empty(), "they are on the bowl");
        assert!(finds(&mut bowl(&pit, -0.5), |_| true).cells.is_empty(), "it is a hill");
    }

    /// What was looked around is looked at no more; and of several that were not, the two best.
    #[test]
    fn a_pocket_is_a_find_until_all_its_sides_were_shown() {
        let mut scene = bowl(&[[16, 15], [17, 16]], 0.5);
        let best = scene.readings[11].cell;
        for (x, y) in [(14, 15), (16, 13)] {
            assert_eq!(finds(&mut scene, |_| true).cells, [best], "not all sides were shown");
            scene.read(&[x, y], 0.3);
        }
        let found = finds(&mut scene, |_| true);
        assert!(found.cells.is_empty(), "{:?}", found.cells);
    }

    /// The bowl is at 0.61 where −0.89 was found; so it may go down to −2.39. Where 0.11 was found, and readings differ by 2, to −0.89.
    #[test]
    fn a_pocket_may_reach_as_deep_as_any_find() {
        for (below, mean, expected) in [(1.5, 0.0, 2.39), (1.5, -2.0, 0.39), (0.5, 0.0, 0.89), (0.5, -1.0, 0.0)] {
            let mut scene = bowl(&[[16, 15], [17, 16]], below);
            let (found, settings) = (finds(&mut scene, |_| true), scene.settings.clone());
            let mut rng = stream(1, Purpose::Finds, 1);
            let open = found.open(&mut scene.knowledge(None), &settings, mean, &mut rng).unwrap().unwrap();
            assert_eq!(open.find, scene.readings[11].cell);
            assert!((open.reach - expected).abs() < 0.03, "{} below {mean}, found {below}", open.reach);
        }
    }
}
