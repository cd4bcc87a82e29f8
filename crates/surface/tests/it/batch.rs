//! Many points at once.

use doe::Space;
use proptest::prelude::*;
use surface::{GridPoints, LANES, Minimum, PointSource, Surface};

use crate::{any_data, kinds};

fn pool(n_threads: usize) -> rayon::ThreadPool {
    rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().expect("a pool of threads")
}

fn bits(numbers: &[f64]) -> Vec<u64> {
    numbers.iter().map(|number| number.to_bits()).collect()
}

/// A surface that implements only what it must.
#[derive(Debug)]
struct Bowl;

impl Surface for Bowl {
    fn n_factors(&self) -> usize {
        2
    }

    fn predict(&self, point: &[f64]) -> f64 {
        (point[0] - 0.2).powi(2) + (point[1] + 0.4).powi(2)
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, cases: 20, ..ProptestConfig::default() })]

    #[test]
    fn batch_is_one_point_after_the_other_bit_for_bit(
        data in any_data(3, 12, 40), n_points in 0..5000_usize, stretch in prop_oneof![Just(1.0), Just(1e3), Just(1e160)],
    ) {
        prop_assume!(data.n_used() >= 8);
        // Some of the points are data.
        let mut points: Vec<f64> = (0..3 * n_points).map(|at| stretch * ((at as f64 * 0.618_033_988_749).fract() * 2.0 - 1.0)).collect();
        for (place, &x) in points.iter_mut().zip(data.coordinates()) {
            *place = x;
        }
        for kind in kinds(3) {
            let surface = kind.fit(&data).expect("points in general position");
            let expected: Vec<f64> = points.chunks_exact(3).map(|x| surface.predict(x)).collect();
            for n_threads in [1, 2, 3] {
                let mut estimates = vec![f64::NAN; n_points];
                pool(n_threads).install(|| surface.predict_into(&points, &mut estimates)).expect("lengths agree");
                prop_assert_eq!(bits(&estimates), bits(&expected), "{:?} with {} threads", kind, n_threads);
            }
        }
    }

    #[test]
    fn grid_by_index_is_the_list_of_its_points(counts in prop::collection::vec(1..7_usize, 1..5), first in 0.0..1.0_f64) {
        let axis = |n: &usize| (0..*n).map(|i| i as f64 + 0.1 * *n as f64).collect::<Vec<f64>>();
        let grid = GridPoints::new(counts.iter().map(axis).collect()).expect("a grid");
        let n = counts.iter().product::<usize>();
        prop_assert_eq!(grid.n_points(), n as u64);
        prop_assert_eq!(grid.point(n as u64), None);
        // Written out by nested loops: the last factor fastest.
        let mut rows = vec![Vec::new()];
        for n in &counts {
            rows = rows.iter().flat_map(|row: &Vec<f64>| axis(n).into_iter().map(|x| [&row[..], &[x]].concat())).collect();
        }
        let first = (first * n as f64) as usize;
        let n_filled = (n - first).min(LANES);
        let mut block = vec![[f64::NAN; LANES]; counts.len()];
        grid.fill(first as u64, n_filled, &mut block);
        for lane in 0..n_filled {
            let point: Vec<f64> = block.iter().map(|lanes| lanes[lane]).collect();
            prop_assert_eq!(&point, &rows[first + lane]);
            prop_assert_eq!(grid.point((first + lane) as u64), Some(point));
        }
    }
}

#[test]
fn order_of_a_grid_is_that_of_its_region() {
    let parameter =
        |name: &str, n| doe::Parameter::continuous(name, "-", -1.0, 1.0).and_then(|parameter| parameter.with_levels(n));
    let region = doe::Region::new(vec![parameter("a", 3).expect("valid"), parameter("b", 5).expect("valid")]);
    let region = region.expect("two parameters");
    let grid = GridPoints::of_space(&Space::of_region(&region).expect("a space")).expect("a grid");
    let cells = doe::Grid::of(&region).expect("levels");
    for (index, point) in cells.cells().map(|cell| cells.point(cell).expect("a cell")).enumerate() {
        let found = grid.point(index as u64).expect("as many points");
        assert!(found.iter().zip(&point).all(|(a, b)| (a - b).abs() < 1e-15), "{found:?}, expected {point:?}");
    }
}

#[test]
fn own_surfaces_need_two_functions_only() {
    let grid = GridPoints::of_space(&Space::grid(&[101, 101]).expect("a grid")).expect("a grid");
    let mut estimates = vec![0.0; 10_201];
    Bowl.predict_range(&grid, 0, &mut estimates).expect("as many as points");
    for (index, estimate) in estimates.iter().enumerate() {
        let point = grid.point(index as u64).expect("a point");
        assert_eq!(estimate.to_bits(), Bowl.predict(&point).to_bits());
    }
    // x = 0.2 is level 60 and y = -0.4 level 30.
    for n_threads in [1, 2] {
        let lowest = pool(n_threads).install(|| Bowl.minimum_over(&grid)).expect("two factors").expect("numbers");
        assert_eq!(lowest.index, 60 * 101 + 30);
        assert!(lowest.value < 1e-30, "{lowest:?}");
    }
}

#[test]
fn first_of_equal_minima_is_found() {
    #[derive(Debug)]
    struct Steps;
    impl Surface for Steps {
        fn n_factors(&self) -> usize {
            1
        }
        fn predict(&self, point: &[f64]) -> f64 {
            if point[0] < 100.0 { f64::NAN } else { -((point[0] / 1000.0).floor().min(3.0)) }
        }
    }
    let axis: Vec<f64> = (0..9000).map(f64::from).collect();
    let grid = GridPoints::new(vec![axis]).expect("a grid");
    assert_eq!(Steps.minimum_over(&grid), Ok(Some(Minimum { index: 3000, value: -3.0 })));
    let nowhere = GridPoints::new(vec![vec![0.0, 1.0]]).expect("a grid");
    assert_eq!(Steps.minimum_over(&nowhere), Ok(None));
}

#[test]
fn a_part_of_a_grid_is_the_part_of_the_whole() {
    let data = surface::Data::new(3, vec![0.1, 0.2, 0.3, -0.5, 0.5, 0.9], vec![1.0, 2.0]).expect("valid data");
    let surface = crate::inverse_distance(&data, 2.0);
    let grid = GridPoints::of_space(&Space::grid(&[24; 3]).expect("a grid")).expect("a grid");
    let mut whole = vec![0.0; 24 * 24 * 24];
    surface.predict_range(&grid, 0, &mut whole).expect("as many as points");
    let mut part = vec![0.0; 5001];
    surface.predict_range(&grid, 777, &mut part).expect("within the grid");
    assert_eq!(bits(&part), bits(&whole[777..][..5001]));
}
