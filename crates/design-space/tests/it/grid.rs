//! Levels and grids, against hand counts.

use design_space::{Cell, Error, Grid, Parameter, Region};

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
    let grid = Grid::of(&region).unwrap();
    let points: Vec<Vec<f64>> = grid.cells().map(|cell| grid.point(cell).unwrap()).collect();
    let expected = [[0.0, 0.0], [0.0, 1.0], [0.0, 2.0], [1.0, 0.0], [1.0, 1.0], [1.0, 2.0]];
    assert_eq!(points, expected);
}

#[test]
fn a_grid_too_large_to_store_still_has_its_cells() {
    let parameters = (0..8).map(|j| stepped(&format!("p{j}"), -1.0, 1.0, 200)).collect();
    let grid = Grid::of(&Region::new(parameters).unwrap()).unwrap();
    assert_eq!(grid.n_cells(), 200_u64.pow(8));
    assert_eq!(grid.point(Cell::new(0)), Ok(vec![-1.0; 8]));
    assert_eq!(grid.coded(Cell::new(199)), Ok([[-1.0; 7].as_slice(), &[1.0]].concat()));
    let last = grid.n_cells() - 1;
    assert_eq!(grid.point(Cell::new(last)), Ok(vec![1.0; 8]));
    assert_eq!(grid.digits(Cell::new(last - 200)), Ok(vec![199, 199, 199, 199, 199, 199, 198, 199]));
    assert_eq!(grid.of_digits(&[199, 199, 199, 199, 199, 199, 198, 199]), Ok(Cell::new(last - 200)));
}

#[test]
fn a_grid_refuses_cells_and_digits_that_it_does_not_have() {
    let grid = Grid::of(&Region::new(vec![stepped("a", 0.0, 1.0, 4)]).unwrap()).unwrap();
    let none = Error::NoSuchCell { index: 4, n_cells: 4 };
    assert_eq!(grid.point(Cell::new(4)), Err(none.clone()));
    assert_eq!(grid.coded(Cell::new(4)), Err(none.clone()));
    assert_eq!(grid.digits(Cell::new(4)), Err(none.clone()));
    assert_eq!(grid.neighbors(Cell::new(4)), Err(none));
    assert_eq!(grid.of_digits(&[4]), Err(Error::NoSuchLevel { parameter: "a".to_owned(), index: 4, last: 3 }));
    assert!(matches!(grid.of_digits(&[1, 1]), Err(Error::WrongDimension { expected: 1, found: 2, .. })));
    assert!(matches!(grid.nearest(&[1.5]), Err(Error::OutOfBounds { .. })));
    assert_eq!(grid.nearest_clamped(&[1.5]), Ok(Cell::new(3)), "from outside to the nearest bound");
    assert!(matches!(grid.nearest_clamped(&[f64::NAN]), Err(Error::NotANumber { .. })));
}

#[test]
fn neighbors_differ_by_one_level_of_one_parameter() {
    let region = Region::new(vec![stepped("a", 0.0, 1.0, 2), stepped("b", 0.0, 2.0, 3)]).unwrap();
    let grid = Grid::of(&region).unwrap();
    let of = |cell| grid.neighbors(Cell::new(cell)).unwrap().into_iter().map(Cell::index).collect::<Vec<_>>();
    assert_eq!(of(0), [3, 1]);
    assert_eq!(of(4), [1, 3, 5]);
}

#[test]
fn a_continuous_parameter_or_too_many_cells_have_no_grid() {
    let free = Parameter::continuous("free", "", 0.0, 1.0).unwrap();
    let region = Region::new(vec![stepped("a", 0.0, 1.0, 4), free]).unwrap();
    assert_eq!(Grid::of(&region).unwrap_err(), Error::Continuous { parameter: "free".to_owned() });
    let huge = (0..3).map(|j| stepped(&format!("p{j}"), 0.0, 1.0, u32::MAX)).collect();
    let region = Region::new(huge).unwrap();
    assert_eq!(Grid::of(&region).unwrap_err(), Error::GridTooLarge { n_parameters: 3 });
}
