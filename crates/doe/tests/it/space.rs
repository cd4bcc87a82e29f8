//! Spaces, their moments and their points, against counting.

use doe::{Axis, Error, Forbidden, Model, Parameter, Region, Space, confounded_terms, moment_matrix};
use proptest::prelude::*;

fn corner(from: f64) -> Forbidden {
    Forbidden::new(vec![Some([from, 1.0]), Some([from, 1.0])]).unwrap()
}

#[test]
fn a_forbidden_corner_takes_its_face_with_it() {
    let cube = Space::cube(2).unwrap().forbid(vec![corner(0.5)]).unwrap();
    assert!(!cube.contains(&[1.0, 1.0]) && !cube.contains(&[0.6, 0.9]));
    assert!(cube.contains(&[0.5, 1.0]), "its inner edge is allowed on a continuous axis");
    let grid = Space::grid(&[5, 5]).unwrap().forbid(vec![corner(0.5)]).unwrap();
    assert!(!grid.contains(&[0.5, 1.0]), "but not on levels");
    assert_eq!(grid.n_points(), Some(25 - 4));
    assert!(!grid.contains(&[0.1, 0.0]), "no level");
}

#[test]
fn moments_of_the_cube_are_those_of_the_uniform_distribution() {
    let moments = moment_matrix(&Model::quadratic(1).unwrap(), &Space::cube(1).unwrap()).unwrap();
    let expected = [1.0, 0.0, 1.0 / 3.0, 0.0, 1.0 / 3.0, 0.0, 1.0 / 3.0, 0.0, 0.2];
    assert!(moments.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-15), "{moments:?}");
}

#[test]
fn moments_without_a_quarter_are_three_quarters_of_the_square() {
    let space = Space::cube(2).unwrap().forbid(vec![corner(0.0)]).unwrap();
    let moments = moment_matrix(&Model::linear(2).unwrap(), &space).unwrap();
    // E x = (0 · 4 − 1/2 · 1) / 3, E xy = (0 · 4 − 1/4 · 1) / 3.
    for (at, expected) in [(0, 1.0), (1, -1.0 / 6.0), (2, -1.0 / 6.0), (5, -1.0 / 12.0), (4, 1.0 / 3.0)] {
        assert!((moments[at] - expected).abs() < 1e-15, "{at}: {} is not {expected}", moments[at]);
    }
}

proptest! {
    #[test]
    fn a_grid_has_the_moments_of_the_list_of_its_points(
        n in 2..6_u32,
        m in 2..6_u32,
        (a, b) in (-1.2..0.9_f64, 0.0..1.5_f64),
        (c, d) in (-1.2..0.9_f64, 0.0..1.5_f64),
    ) {
        let forbidden = Forbidden::new(vec![Some([a, a + b]), Some([c, c + d])]).unwrap();
        let grid = Space::grid(&[n, m]).unwrap();
        let level = |i: u32, n: u32| 2.0 * f64::from(i) / f64::from(n - 1) - 1.0;
        let points = (0..n).flat_map(|i| (0..m).flat_map(move |j| [level(i, n), level(j, m)])).collect();
        let list = Space::list(2, points).unwrap().forbid(vec![forbidden.clone()]);
        let model = Model::quadratic(2).unwrap();
        match (grid.forbid(vec![forbidden]), list) {
            (Ok(grid), Ok(list)) => {
                prop_assert_eq!(grid.n_points(), list.n_points());
                let pairs = moment_matrix(&model, &grid).unwrap().into_iter().zip(moment_matrix(&model, &list).unwrap());
                for (one, other) in pairs {
                    prop_assert!((one - other).abs() < 1e-12);
                }
            }
            (Err(Error::ForbidsNoPoint { .. }), Err(Error::ForbidsNoPoint { .. })) => (),
            (Err(one), Err(other)) => prop_assert_eq!(one, other),
            // Between two levels a box could not forbid anything, of a list some points of it may be gone.
            (Err(Error::ForbidsNoPoint { factor, .. }), Ok(list)) => {
                let (count, [lower, upper]) = ([n, m][factor], [[a, a + b], [c, c + d]][factor]);
                prop_assert!((0..count).all(|i| !(lower..=upper).contains(&level(i, count))));
                prop_assert_eq!(list.n_points(), Some(u64::from(n * m)));
            }
            (one, other) => prop_assert!(false, "{one:?} and {other:?}"),
        }
    }
}

#[test]
fn a_space_names_the_terms_it_confounds() {
    // On the diagonal both factors are one, and on two levels squares are constant.
    let diagonal = Space::list(2, vec![-1.0, -1.0, 0.0, 0.0, 0.5, 0.5, 1.0, 1.0]).unwrap();
    let confounded = confounded_terms(&Model::linear(2).unwrap(), &diagonal).unwrap();
    assert_eq!(confounded.len(), 1);
    assert_eq!(confounded[0].to_string(), "`x2` = `x1`");
    let square = Space::grid(&[2, 2]).unwrap();
    let model = Model::quadratic(2).unwrap();
    let dropped: Vec<usize> = confounded_terms(&model, &square).unwrap().iter().map(|c| c.term).collect();
    assert_eq!(dropped, [4, 5]);
    let left = model.without_terms(&dropped).unwrap();
    assert!(confounded_terms(&left, &square).unwrap().is_empty());
}

/// A single point of many thousands tells two terms apart, and without it nothing does: a sample of the list is not asked to say that
/// terms are the same.
#[test]
fn a_single_point_of_a_long_list_is_not_overlooked() {
    let line = (0..20_000).flat_map(|i| [f64::from(i) / 1e4 - 1.0; 2]);
    let all_but_one = Space::list(2, line.clone().collect::<Vec<f64>>()).unwrap();
    let confounded = confounded_terms(&Model::linear(2).unwrap(), &all_but_one).unwrap();
    assert_eq!(confounded.iter().map(ToString::to_string).collect::<Vec<_>>(), ["`x2` = `x1`"]);
    let all = Space::list(2, line.chain([0.5, -0.5]).collect::<Vec<f64>>()).unwrap();
    assert_eq!(confounded_terms(&Model::linear(2).unwrap(), &all).unwrap(), []);
}

#[test]
fn refuses_spaces_that_are_none() {
    let check = |space: Result<Space, Error>, message: &str| assert_eq!(space.unwrap_err().to_string(), message);
    check(Space::cube(0), "factors: 0, expected 1 to 12");
    check(
        Space::grid(&[3, 1]),
        "an axis has 1 level, expected at least 2: leave a factor that cannot vary out of the model",
    );
    check(
        Space::of_axes(vec![Axis::Levels(vec![0.5, 0.5])]),
        "the levels of factor 1 are not finite, rising by more than 1e-6 and within -1 to 1",
    );
    check(
        Space::of_axes(vec![Axis::Levels(vec![0.5, f64::NAN])]),
        "the levels of factor 1 are not finite, rising by more than 1e-6 and within -1 to 1",
    );
    check(
        Space::list(2, vec![0.0, 0.0, 1.0, 1.0, 0.0, -0.0]),
        "candidates 1 and 3 are the same run, expected candidates more than 1e-6 apart in some coordinate",
    );
    check(
        Space::list(1, vec![0.0, 1.5]),
        "coordinate 1 of candidate 2 is 1.5, expected coded coordinates from -1 to 1",
    );
    check(Space::list(2, vec![f64::NAN, 0.0]), "coordinate 1 of point 1 is NaN, expected a finite number");
    check(Space::list(2, vec![]), "candidates: 0, expected at least 1");
    let all = Forbidden::new(vec![Some([-1.0, 1.0]), None]).unwrap();
    check(
        Space::cube(2).unwrap().forbid(vec![all.clone()]),
        "nothing of the space is left once the forbidden boxes are gone",
    );
    check(
        Space::grid(&[2, 2]).unwrap().forbid(vec![all.clone()]),
        "nothing of the space is left once the forbidden boxes are gone",
    );
    check(Space::cube(3).unwrap().forbid(vec![all]), "a forbidden box has 2 factors, expected 3");
    assert_eq!(Forbidden::new(vec![None, None]), Err(Error::ForbidsEverything));
    let error = Forbidden::new(vec![Some([0.5, f64::NAN])]).unwrap_err();
    assert_eq!(error.to_string(), "factor 1: the forbidden range 0.5 to NaN is not a range, expected lower <= upper");
}

proptest! {
    /// Nothing could be searched over them: runs that must differ cannot be both.
    #[test]
    fn candidates_are_refused_where_two_of_them_are_the_same_run_and_nowhere_else(
        n_factors in 1..4_usize,
        numbers in prop::collection::vec(-900_000..900_000_i32, 60),
        place in 0..20_usize,
        by in prop::sample::select(vec![0.0, 1e-10, -1e-10, 1e-8, 9.9e-7, -9.9e-7, 1.1e-6, -1.1e-6]),
    ) {
        let mut points: Vec<f64> = numbers.iter().map(|&x| f64::from(x) / 1e6).collect();
        points.truncate(20 * n_factors);
        let (n_points, axis) = (points.len() / n_factors, place % n_factors);
        let first = place % n_points;
        let mut near = points[first * n_factors..][..n_factors].to_vec();
        near[axis] += by;
        points.extend(near);
        let all: Vec<&[f64]> = points.chunks_exact(n_factors).collect();
        let same = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(x, y)| (x - y).abs() <= 1e-6);
        let is_given = |i: usize, j: usize| i < j && same(all[i], all[j]);
        match Space::list(n_factors, points.clone()) {
            Ok(_) => {
                prop_assert!(by.abs() > 1e-6);
                prop_assert!(!(0..all.len()).any(|j| (0..j).any(|i| is_given(i, j))), "{points:?}");
            }
            Err(Error::DuplicateCandidate { first, second }) => prop_assert!(is_given(first, second), "{first}, {second}"),
            Err(other) => prop_assert!(false, "{other}"),
        }
    }
}

#[test]
fn levels_that_make_the_same_run_are_refused() {
    let levels = |by: f64| Space::of_axes(vec![Axis::Levels(vec![-1.0, 0.0, by, 1.0])]);
    assert_eq!(levels(9e-7).unwrap_err(), Error::LevelsNotRising { factor: 0 });
    assert!(levels(1.1e-6).is_ok());
}

/// Only one of two ranges of one parameter could hold, and the other would be allowed in silence.
#[test]
fn a_parameter_comes_once_in_a_forbidden_box() {
    let region = Region::new(vec![Parameter::continuous("mass", "kg", 1.0, 3.0).unwrap()]).unwrap();
    let error = Forbidden::in_region(&region, &[("mass", 1.0, 1.5), ("mass", 2.5, 3.0)]).unwrap_err();
    assert!(error.to_string().contains("parameter `mass` of a forbidden box comes twice"), "{error}");
}

/// A unit that slipped must not plan the runs that were to be excluded.
#[test]
fn a_forbidden_range_outside_the_bounds_is_refused_because_it_forbids_nothing() {
    let temperature = Parameter::continuous("temperature", "°C", 10.0, 20.0).unwrap();
    let region = Region::new(vec![temperature]).unwrap();
    let error = Forbidden::in_region(&region, &[("temperature", 283.0, 285.0)]).unwrap_err();
    assert_eq!(
        error.to_string(),
        "parameter `temperature`: the forbidden range 283.0 to 285.0 lies outside its bounds 10.0 to 20.0 °C, so that it \
         forbids nothing"
    );
    for (lower, upper) in [(20.0, 25.0), (5.0, 10.0), (f64::NEG_INFINITY, 12.0)] {
        assert!(Forbidden::in_region(&region, &[("temperature", lower, upper)]).is_ok(), "{lower} to {upper} meets it");
    }
}

/// Between two levels there is nothing to forbid.
#[test]
fn a_forbidden_range_between_two_levels_is_refused_with_those_next_to_it() {
    let mass = Parameter::continuous("mass", "kg", 1.0, 3.0).unwrap().with_levels(5).unwrap();
    let region = Region::new(vec![mass, Parameter::continuous("pitch", "deg", 10.0, 22.0).unwrap()]).unwrap();
    let of = |lower: f64, upper: f64| Forbidden::in_region(&region, &[("mass", lower, upper)]);
    assert_eq!(
        of(2.1, 2.4).unwrap_err().to_string(),
        "parameter `mass`: the forbidden range 2.1 to 2.4 holds none of its levels, so that it forbids nothing; the nearest \
         are 2.0 and 2.5 kg"
    );
    for (lower, upper) in [(1.1, 1.4), (1.6, 1.6), (2.51, 2.99)] {
        assert!(matches!(of(lower, upper), Err(Error::ForbidsNoLevel { .. })), "{lower} to {upper}");
    }
    for (lower, upper) in [(2.5, 2.5), (2.4, 2.6), (0.0, 1.0), (2.9, 7.0), (2.500_000_000_1, 2.7), (1.6, 2.3)] {
        let space = Space::of_region(&region).unwrap().forbid(vec![of(lower, upper).unwrap()]).unwrap();
        let coded: Vec<f64> = (0..5).map(|i| f64::from(i) / 2.0 - 1.0).collect();
        assert!(coded.iter().any(|&x| !space.contains(&[x, 0.0])), "{lower} to {upper} forbids a level");
    }
}

#[test]
fn a_forbidden_box_that_could_forbid_nothing_is_named() {
    let levels = || Axis::equally_spaced(3).unwrap();
    let mixed = || Space::of_axes(vec![Axis::Continuous, levels()]).unwrap();
    let list = || Space::list(2, vec![-1.0, -1.0, 0.5, 1.0, 1.0, 0.0]).unwrap();
    let boxes = |ranges: [Option<[f64; 2]>; 2]| {
        let corner = Forbidden::new(vec![Some([0.9, 1.0]), Some([0.9, 1.0])]).unwrap();
        vec![corner, Forbidden::new(ranges.to_vec()).unwrap()]
    };
    let said = |space: Space, ranges: [Option<[f64; 2]>; 2]| match space.forbid(boxes(ranges)) {
        Ok(space) => panic!("{ranges:?} is taken by the {}", space.over()),
        Err(error) => error.to_string(),
    };
    for space in [mixed(), list(), Space::cube(2).unwrap(), Space::grid(&[3, 3]).unwrap()] {
        for (ranges, text) in [([1.5, 2.0], "1.5 to 2.0"), ([-30.0, -1.1], "-30.0 to -1.1")] {
            assert_eq!(
                said(space.clone(), [None, Some(ranges)]),
                format!(
                    "forbidden box 2: the range {text} of factor 2 forbids nothing, expected coded coordinates that meet -1 to 1"
                )
            );
        }
    }
    assert_eq!(
        said(mixed(), [Some([-1.0, 0.0]), Some([0.1, 0.9])]),
        "forbidden box 2: the range 0.1 to 0.9 of factor 2 forbids nothing, expected one of its levels, as 0.0 or 1.0"
    );
    for range in [[0.2, 0.2], [-1.0, -1.0], [1.0, 3.0]] {
        let said = said(mixed(), [Some(range), None]);
        assert!(said.ends_with("within the bounds: the ends themselves are not forbidden"), "{range:?}: {said}");
    }
    // Of a list what a box held may be gone.
    assert_eq!(list().forbid(boxes([Some([-0.2, 0.2]), None])).unwrap().n_points(), Some(3));
    assert!(mixed().forbid(boxes([Some([0.2, 0.3]), Some([-0.1, 0.1])])).is_ok());
}

#[test]
fn an_absurd_number_of_levels_is_refused() {
    let error = Space::grid(&[3, 1_000_000_000]).unwrap_err();
    assert_eq!(
        error.to_string(),
        "1000000000 levels, expected at most 1000000: a finer axis is better taken as continuous"
    );
}
