//! Grids by tables of their axes.

use doe::Model;
use proptest::prelude::*;
use surface::{Confounded, Data, GridPoints, Kind, LANES, PointSource as _, Surface};

use crate::{any_data, check_exact, inverse_distance, kinds, squared_exponential};

fn estimates(surface: &dyn Surface, grid: &GridPoints, first: u64, n: usize, n_threads: usize) -> Vec<f64> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().expect("a pool of threads");
    let mut estimates = vec![f64::NAN; n];
    pool.install(|| surface.predict_range(grid, first, &mut estimates)).expect("within the grid");
    estimates
}

fn one_by_one(surface: &dyn Surface, grid: &GridPoints) -> Vec<f64> {
    (0..grid.n_points()).map(|index| surface.predict(&grid.point(index).expect("a point"))).collect()
}

/// The same to rounding, relative to a size; what is not finite in both is the same.
#[track_caller]
fn check_same(found: &[f64], expected: &[f64], size: f64, what: &str) {
    assert_eq!(found.len(), expected.len(), "{what}: lengths");
    for (index, (a, b)) in found.iter().zip(expected).enumerate() {
        let is_same = (a - b).abs() <= 1e-12 * size || (!a.is_finite() && !b.is_finite());
        assert!(is_same, "{what}, point {index}: {a:?}, one by one {b:?}");
    }
}

/// Runs along the last axis that are shorter and longer than a block, begin and end within one, and at any first point.
#[test]
fn a_block_holds_the_points_of_the_grid_one_after_the_other() {
    for lengths in [vec![3, 2], vec![2, 7], vec![3, 2, 11], vec![29]] {
        let levels = lengths.iter().map(|&n| (0..n).map(f64::from).collect()).collect::<Vec<Vec<f64>>>();
        let grid = GridPoints::new(levels).expect("a grid");
        for first in 0..grid.n_points() {
            let n_filled = LANES.min((grid.n_points() - first) as usize);
            let mut block = vec![[f64::NAN; LANES]; lengths.len()];
            grid.fill(first, n_filled, &mut block);
            for lane in 0..n_filled {
                let found: Vec<f64> = block.iter().map(|axis| axis[lane]).collect();
                assert_eq!(Some(found), grid.point(first + lane as u64), "{lengths:?} from {first}, lane {lane}");
            }
        }
    }
}

/// Axes of any length, some levels of which are coordinates of data.
fn any_grid() -> impl Strategy<Value = Vec<Vec<(f64, Option<prop::sample::Index>)>>> {
    let level = (-1.5..1.5_f64, prop::option::of(any::<prop::sample::Index>()));
    prop::collection::vec(prop::collection::vec(level, 1..14), 3)
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, cases: 60, ..ProptestConfig::default() })]

    #[test]
    fn tables_give_what_the_surface_gives_point_by_point(
        data in any_data(3, 12, 40), axes in any_grid(),
        stretch in prop_oneof![4 => Just(1.0), 1 => Just(1e-90), 1 => Just(40.0), 1 => Just(1e12), 1 => Just(1e25), 1 => Just(1e160)],
    ) {
        prop_assume!(data.n_used() >= 10);
        let level = |axis: usize, (x, of): &(f64, Option<prop::sample::Index>)| match of {
            Some(index) => data.coordinates()[3 * index.index(data.n_points()) + axis],
            None => stretch * x,
        };
        let levels = axes.iter().enumerate().map(|(axis, of)| of.iter().map(|one| level(axis, one)).collect()).collect();
        let grid = GridPoints::new(levels).expect("a grid");
        let mut all = kinds(3);
        let model = Model::quadratic(3).expect("a model");
        all.push(Kind::Regression { model: model.clone(), confounded: Confounded::Drop });
        for kind in all {
            let surface = kind.fit(&data).expect("points in general position");
            let n = grid.n_points() as usize;
            let whole = estimates(&*surface, &grid, 0, n, 2);
            // Powers of large numbers have large errors.
            let size = if matches!(kind, Kind::Regression { .. }) { 1e6 * stretch.max(1.0).powi(2) } else { 5.0 };
            check_same(&whole, &one_by_one(&*surface, &grid), size, &format!("{kind:?}"));
        }
    }

    #[test]
    fn an_estimate_hangs_on_its_point_alone(
        data in any_data(3, 12, 40), axes in any_grid(), from in 0.0..1.0_f64, share in 0.0..1.0_f64,
    ) {
        prop_assume!(data.n_used() >= 8);
        let levels = axes.iter().map(|of| of.iter().map(|(x, _)| *x).collect()).collect();
        let grid = GridPoints::new(levels).expect("a grid");
        let n = grid.n_points();
        let first = (from * n as f64) as u64;
        let wanted = (share * (n - first) as f64) as usize;
        for kind in kinds(3) {
            let surface = kind.fit(&data).expect("points in general position");
            let whole = estimates(&*surface, &grid, 0, n as usize, 1);
            let part = estimates(&*surface, &grid, first, wanted, 3);
            for (found, expected) in part.iter().zip(&whole[first as usize..]) {
                prop_assert_eq!(found.to_bits(), expected.to_bits(), "{:?}", kind);
            }
        }
    }
}

#[test]
fn a_datum_on_the_grid_is_met_exactly() {
    let data = Data::new(2, vec![-1.0, -1.0, 0.0, 0.5, 1.0, 1.0], vec![2.0, 3.0, 5.0]).expect("valid data");
    let grid = GridPoints::new(vec![vec![-1.0, 0.0, 1.0], vec![-1.0, 0.5, 1.0]]).expect("a grid");
    let found = estimates(&inverse_distance(&data, 2.0), &grid, 0, 9, 1);
    for (index, value) in [(0, 2.0), (4, 3.0), (8, 5.0)] {
        check_exact(found[index], value, "at a datum");
    }
}

#[test]
fn far_from_all_data_the_nearest_counts_on_a_grid_too() {
    // All exponentials vanish at distances of 30 lengths and more, and have nearly vanished at 18.
    let data = Data::new(2, vec![0.0, 0.0, 1.0, 0.0], vec![2.0, 7.0]).expect("valid data");
    let surface = squared_exponential(&data, 1.0);
    let grid = GridPoints::new(vec![vec![-1e6, -40.0, -18.0, 0.2, 19.0, 41.0, 1e6], vec![0.0, 30.0]]).expect("a grid");
    let found = estimates(&surface, &grid, 0, 14, 1);
    for (index, value) in [(0, 2.0), (2, 2.0), (4, 2.0), (8, 7.0), (10, 7.0), (12, 7.0)] {
        assert!((found[index] - value).abs() < 1e-12, "point {index}: {}", found[index]);
    }
    check_same(&found, &one_by_one(&surface, &grid), 7.0, "all");
}

#[test]
fn levels_that_are_not_finite_give_estimates_that_are_not() {
    let data = Data::new(2, vec![0.0, 0.0, 1.0, 0.0, 0.0, 1.0], vec![2.0, 7.0, 3.0]).expect("valid data");
    let grid = GridPoints::new(vec![vec![0.5, f64::NAN, f64::INFINITY], vec![0.5, f64::NEG_INFINITY]]).expect("a grid");
    for kind in kinds(2) {
        let surface = kind.fit(&data).expect("three points");
        let found = estimates(&*surface, &grid, 0, 6, 1);
        assert!(found[0].is_finite(), "{kind:?}: {found:?}");
        assert!(found[1..].iter().all(|estimate| !estimate.is_finite()), "{kind:?}: {found:?}");
    }
}

#[test]
fn a_grid_too_large_for_tables_is_gone_through_point_by_point() {
    let data = Data::new(1, vec![-1.0, 0.3, 1.0], vec![2.0, 7.0, 3.0]).expect("valid data");
    let levels: Vec<f64> = (0..3_000_000).map(|i| f64::from(i) / 1.5e6 - 1.0).collect();
    let (small, large) = (levels.iter().step_by(1000).copied().collect(), levels);
    let [small, large] = [small, large].map(|levels| GridPoints::new(vec![levels]).expect("a grid"));
    let surface = inverse_distance(&data, 2.0);
    assert!(surface.over_grid(&small).is_some() && surface.over_grid(&large).is_none());
    assert!(inverse_distance(&data, 3.0).over_grid(&small).is_none(), "powers of distances do not add");
    let coarse = surface.minimum_over(&small).expect("one factor").expect("numbers");
    let fine = surface.minimum_over(&large).expect("one factor").expect("numbers");
    assert_eq!((coarse.index, fine.index), (0, 0), "the lowest datum is the first level of both");
    check_exact(fine.value, 2.0, "its value");
}
