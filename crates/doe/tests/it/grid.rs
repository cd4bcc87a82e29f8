//! Levels and grids, against hand counts.

use doe::{Error, Parameter, Region};

fn stepped(name: &str, lower: f64, upper: f64, count: u32) -> Parameter {
    let parameter = Parameter::continuous(name, "", lower, upper).unwrap();
    parameter.with_levels(count).unwrap()
}

#[test]
fn levels_are_the_decimal_numbers_one_expects() {
    // Adding 0.1 eighteen times to 8 misses 9.8, and dividing by 0.1 counts one level too few.
    let pitch = stepped("pitch", 8.0, 9.8, 19);
    let expected = [8.0, 8.1, 8.2, 8.3, 8.4, 8.5, 8.6, 8.7, 8.8, 8.9, 9.0, 9.1, 9.2, 9.3, 9.4, 9.5, 9.6, 9.7, 9.8];
    for (index, value) in (0..).zip(expected) {
        let level = pitch.level(index).unwrap();
        assert!((level - value).abs() <= 2e-15, "{level} is not {value}");
        assert_eq!(pitch.nearest_level(level), Ok(index));
    }
}

#[test]
fn of_two_equally_near_levels_the_lower_is_taken() {
    let parameter = stepped("p", 0.0, 4.0, 5);
    assert_eq!(parameter.nearest_level(1.5), Ok(1));
    assert_eq!(parameter.nearest_level(3.5), Ok(3));
    assert_eq!(parameter.nearest_level(1.5000001), Ok(2));
}

#[test]
fn a_grid_visits_every_combination_once_in_order() {
    let region = Region::new(vec![stepped("a", 0.0, 1.0, 2), stepped("b", 0.0, 2.0, 3)]).unwrap();
    let points: Vec<Vec<f64>> = region.grid().unwrap().collect();
    let expected = [[0.0, 0.0], [0.0, 1.0], [0.0, 2.0], [1.0, 0.0], [1.0, 1.0], [1.0, 2.0]];
    assert_eq!(points, expected);
}

#[test]
fn a_grid_too_large_to_store_is_still_iterated() {
    let parameters = (0..8).map(|j| stepped(&format!("p{j}"), -1.0, 1.0, 200)).collect();
    let region = Region::new(parameters).unwrap();
    let mut grid = region.grid().unwrap();
    assert_eq!(grid.n_points(), 200_u64.pow(8));
    assert_eq!(grid.next(), Some(vec![-1.0; 8]));
    let last = grid.n_points() - 1;
    assert_eq!(grid.point(last), Ok(vec![1.0; 8]));
    assert_eq!(grid.level_indices(last - 200), Ok(vec![199, 199, 199, 199, 199, 199, 198, 199]));
    assert_eq!(grid.nth(198), Some([[-1.0; 7].as_slice(), &[1.0]].concat()), "skips in one step");
}

#[test]
fn a_grid_counts_what_is_left_and_ends() {
    let region = Region::new(vec![stepped("a", 0.0, 1.0, 4)]).unwrap();
    let mut grid = region.grid().unwrap();
    assert_eq!(grid.size_hint(), (4, Some(4)));
    assert!(grid.nth(2).is_some(), "the third");
    assert_eq!(grid.size_hint(), (1, Some(1)));
    assert!(grid.next().is_some(), "the fourth");
    assert_eq!((grid.next(), grid.next(), grid.nth(7)), (None, None, None));
    assert_eq!(grid.point(4), Err(Error::NoSuchGridPoint { index: 4, n_points: 4 }));
}

#[test]
fn a_continuous_parameter_or_too_many_points_have_no_grid() {
    let free = Parameter::continuous("free", "", 0.0, 1.0).unwrap();
    let region = Region::new(vec![stepped("a", 0.0, 1.0, 4), free]).unwrap();
    assert_eq!(region.grid().unwrap_err(), Error::Continuous { parameter: "free".to_owned() });
    let huge = (0..3).map(|j| stepped(&format!("p{j}"), 0.0, 1.0, u32::MAX)).collect();
    let region = Region::new(huge).unwrap();
    assert_eq!(region.grid().unwrap_err(), Error::GridTooLarge { n_parameters: 3 });
}
