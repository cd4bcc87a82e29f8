//! How narrow wells may be, as the simulation shows.

use std::collections::BTreeSet;

use design_space::Cell;

use crate::pooled::measurements::Reading;
use crate::pooled::pool::Pool;

/// So many times as wide a well of the response counts as narrow as that of the simulation.
const AS_NARROW: f64 = 1.5;

/// The share of all designs that the best well of the simulation takes: those that are nearer to its best than to its median. None where
/// there is no simulation or none that has a well; nor where the response, `expected` at the recommended design, has a well that is as
/// narrow, and as many designs were run in it as a quadratic has terms: it was not only met, but seen.
///
/// A simulation that has wells of one or two designs says that the response may have such wells, too, wherever: a few runs meet none, and
/// the surface is then sure of what lies between them.
pub(crate) fn narrow_well(pool: &Pool, readings: &[Reading], expected: f64, n_terms: usize) -> Option<f64> {
    let simulated = pool.places.simulated()?;
    let lowest = simulated.iter().copied().fold(f64::INFINITY, f64::min);
    let shown = Well::of(pool, simulated, lowest)?.share;
    let is_seen = Well::of(pool, &pool.marginals.means, expected).is_some_and(|own| {
        let within = readings.iter().filter(|reading| reading.response < own.rim).map(|reading| reading.cell);
        own.share <= AS_NARROW * shown && within.collect::<BTreeSet<Cell>>().len() >= n_terms
    });
    (!is_seen).then_some(shown)
}

/// All that is nearer to the lowest than to the median.
struct Well {
    /// Of all designs.
    share: f64,
    /// Half way to the median.
    rim: f64,
}

impl Well {
    /// Of what the designs of the pool that were drawn evenly have; none where half of them have the lowest.
    fn of(pool: &Pool, values: &[f64], lowest: f64) -> Option<Self> {
        let even: BTreeSet<Cell> = pool.random.iter().copied().collect();
        let is_even = |cell: &Cell| even.is_empty() || even.contains(cell);
        let all = pool.cells.iter().zip(values).filter(|(cell, _)| is_even(cell)).map(|(_, value)| *value);
        let mut all: Vec<f64> = all.collect();
        all.sort_by(f64::total_cmp);
        let median = *all.get(all.len() / 2)?;
        let rim = lowest + 0.5 * (median - lowest);
        let share = all.partition_point(|value| *value < rim).max(1) as f64 / all.len() as f64;
        (median > lowest).then_some(Self { share, rim })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pooled::scene::Scene;

    /// Of 21 × 21 designs, by a simulation that has so many of them in a well, nearly a quarter of a circle at the corner of a slope, of which
    /// so many were run, beside eight elsewhere.
    fn share(n: usize, n_run: usize) -> Option<f64> {
        let mut scene = Scene::new(&[21, 21]);
        let mut order: Vec<[u64; 2]> = (0..21).flat_map(|x| (0..21).map(move |y| [x, y])).collect();
        order.sort_by_key(|[x, y]| x * x + y * y);
        let well: BTreeSet<Cell> = order[..n].iter().map(|digits| scene.cell(digits)).collect();
        let height = |cell: Cell, point: &[f64]| match well.contains(&cell) {
            true => -3.0,
            false => 0.1 * point[0] + 0.1 * point[1],
        };
        let far = [[20, 20], [20, 0], [0, 20], [10, 10], [15, 5], [5, 15], [12, 18], [18, 12]];
        for run in far.iter().chain(&order[..n_run]) {
            let (cell, point) = (scene.cell(run), run.map(|digit| digit as f64 / 20.0));
            scene.read(run, height(cell, &point));
        }
        let (readings, n_terms) = (scene.readings.clone(), scene.designs.n_terms());
        let mut simulate = |cell: Cell, point: &[f64]| Ok::<f64, String>(height(cell, point));
        let mut knowledge = scene.knowledge(Some(&mut simulate));
        let pool = Pool::gather(&mut knowledge, 1, 0).unwrap();
        let lowest = pool.marginals.means.iter().copied().fold(f64::INFINITY, f64::min);
        narrow_well(&pool, &readings, lowest, n_terms)
    }

    #[test]
    fn the_well_of_the_simulation_is_as_narrow_as_it_is() {
        for n in [1, 4, 20, 60] {
            let found = share(n, 1).expect("it was met once");
            assert!((found - n as f64 / 441.0).abs() < 1e-12, "{found} of {n}");
        }
    }

    /// Once the response has such a well, too, and as many of its designs were run as a quadratic in two parameters has terms.
    #[test]
    fn a_well_as_narrow_that_was_looked_at_is_enough() {
        assert!(share(12, 5).is_some());
        assert_eq!(share(12, 6), None);
        assert!(share(4, 4).is_some(), "one of fewer designs cannot be");
    }

    #[test]
    fn a_simulation_that_says_the_same_of_all_designs_has_no_well_and_neither_has_none() {
        let mut scene = Scene::new(&[21, 21]);
        for run in [[0, 0], [20, 20], [0, 20], [20, 0], [10, 10]] {
            scene.read(&run, run[0] as f64);
        }
        let readings = scene.readings.clone();
        let mut simulate = |_: Cell, _: &[f64]| Ok::<f64, String>(1.0);
        let mut knowledge = scene.knowledge(Some(&mut simulate));
        let pool = Pool::gather(&mut knowledge, 1, 0).unwrap();
        assert_eq!(narrow_well(&pool, &readings, 0.0, 6), None);
        let mut knowledge = scene.knowledge(None);
        let pool = Pool::gather(&mut knowledge, 1, 0).unwrap();
        assert_eq!(narrow_well(&pool, &readings, 0.0, 6), None);
    }
}
