//! One test per way of being wrong; every message names the parameter, the value and the range.

use design_space::{Error, Grid, Parameter, Region};

fn pitch() -> Parameter {
    Parameter::continuous("pitch", "deg", 10.0, 22.0).unwrap()
}

#[track_caller]
fn check<T: std::fmt::Debug>(result: Result<T, Error>, message: &str) {
    assert_eq!(result.unwrap_err().to_string(), message);
}

#[test]
fn rejects_bounds_that_span_nothing() {
    let make = |lower, upper| Parameter::continuous("pitch", "deg", lower, upper);
    check(
        make(22.0, 10.0),
        "parameter `pitch`: the lower bound 22.0 is above the upper bound 10.0, expected lower < upper",
    );
    check(make(10.0, 10.0), "parameter `pitch`: both bounds are 10.0, expected lower < upper");
    check(make(0.0, -0.0), "parameter `pitch`: both bounds are 0.0, expected lower < upper");
}

#[test]
fn rejects_bounds_that_are_no_numbers() {
    let tail = "expected a finite number of magnitude at most 1e290";
    for (value, text) in [(f64::NAN, "NaN"), (f64::INFINITY, "inf"), (f64::NEG_INFINITY, "-inf")] {
        check(
            Parameter::continuous("pitch", "deg", value, 1.0),
            &format!("parameter `pitch`: the lower bound is {text}, {tail}"),
        );
        check(
            Parameter::continuous("pitch", "deg", 1.0, value),
            &format!("parameter `pitch`: the upper bound is {text}, {tail}"),
        );
    }
    assert!(Parameter::continuous("wide", "", -1e290, 1e290).is_ok(), "the largest bounds");
    assert!(Parameter::continuous("wide", "", 0.0, 1.1e290).is_err(), "beyond them");
}

#[test]
fn rejects_levels_that_are_none() {
    let tail = "expected at least 2, or continuous levels";
    check(pitch().with_levels(1), &format!("parameter `pitch`: number of levels 1, {tail}"));
    check(pitch().with_levels(0), &format!("parameter `pitch`: number of levels 0, {tail}"));
    let narrow = Parameter::continuous("narrow", "", 1.0, 1.0 + 1e-14).unwrap();
    assert!(narrow.clone().with_levels(2).is_ok(), "the two bounds differ");
    check(
        narrow.with_levels(40),
        "parameter `narrow`: 40 levels from 1.0 to 1.00000000000001 cannot be told apart in double precision",
    );
}

#[test]
fn rejects_names_that_do_not_name() {
    check(
        Parameter::continuous("  ", "deg", 10.0, 22.0),
        "a parameter has an empty name (unit \"deg\", bounds 10.0 to 22.0)",
    );
    let mass = Parameter::continuous("mass", "kg", 0.0, 1.0).unwrap();
    check(
        Region::new(vec![pitch(), mass, pitch()]),
        "the name `pitch` stands for parameters number 1 and 3 of the list, expected unique names",
    );
    check(Region::new(vec![]), "a region has no parameters, expected at least one");
}

#[test]
fn rejects_points_of_another_dimension() {
    let mass = Parameter::continuous("mass", "kg", 0.0, 1.0).unwrap();
    let region = Region::new(vec![mass, pitch()]).unwrap();
    let message = "coordinates of a point: 1, expected 2 (mass, pitch)";
    check(region.coded(&[1.0]), message);
    check(region.natural(&[1.0]), message);
    check(region.contains(&[1.0]), message);
    check(region.check(&[1.0]), message);
    check(region.clamp(&[1.0]), message);
    check(region.snap(&[1.0]), message);
    let many = region.check(&[0.5, 16.0, 1.0]).unwrap_err();
    assert_eq!(many.to_string(), "coordinates of a point: 3, expected 2 (mass, pitch)", "too many as well");
    assert!(many.hint().is_some_and(|hint| hint.contains("decimal comma")), "beside the message");
    assert_eq!(region.check(&[1.0]).unwrap_err().hint(), None);
}

#[test]
fn never_moves_a_value_into_the_bounds_unasked() {
    let outside = "parameter `pitch`: the value is 23.0, expected 10.0 to 22.0 deg";
    let nan = "parameter `pitch`: the value is NaN, expected 10.0 to 22.0 deg";
    let stepped = pitch().with_levels(13).unwrap();
    for parameter in [pitch(), stepped.clone()] {
        check(parameter.check(23.0), outside);
        check(parameter.snap(23.0), outside);
        check(parameter.check(f64::NAN), nan);
        check(parameter.snap(f64::NAN), nan);
        check(parameter.clamp(f64::NAN), nan);
        assert_eq!(parameter.clamp(23.0), Ok(22.0));
        assert_eq!(parameter.clamp(f64::NEG_INFINITY), Ok(10.0));
        assert!(!parameter.contains(f64::NAN), "not anywhere");
    }
    check(stepped.nearest_level(23.0), outside);
    check(Region::new(vec![stepped]).unwrap().snap(&[23.0]), outside);
}

#[test]
fn rejects_levels_there_are_not() {
    check(pitch().level(0), "parameter `pitch` is continuous, expected a count of levels");
    check(pitch().nearest_level(11.0), "parameter `pitch` is continuous, expected a count of levels");
    check(pitch().with_levels(13).unwrap().level(13), "parameter `pitch`: level index 13, expected 0 to 12");
}

/// Wherever a setting comes in: 1.4 is neither `film` nor `wood`.
#[test]
fn a_choice_takes_no_number_between_two() {
    let hull = Parameter::categorical("hull", ["foam", "film", "wood"]).unwrap();
    let message = "parameter `hull`: the value is 1.4, expected the place of a choice: 0 (foam), 1 (film) or 2 (wood)";
    check(hull.check(1.4), message);
    check(hull.snap(1.4), message);
    check(hull.nearest_level(1.4), message);
    assert!(!hull.contains(1.4), "between two choices");
    let region = Region::new(vec![pitch().with_levels(13).unwrap(), hull.clone()]).unwrap();
    let grid = Grid::of(&region).unwrap();
    check(region.check(&[10.0, 1.4]), message);
    check(region.snap(&[10.0, 1.4]), message);
    check(grid.nearest(&[10.0, 1.4]), message);
    assert_eq!(region.contains(&[10.0, 1.4]), Ok(false));
    for place in 0..3_u32 {
        let value = f64::from(place);
        assert_eq!(hull.check(value), Ok(value), "a choice");
        assert_eq!(hull.nearest_level(value), Ok(place), "a choice");
        assert!(hull.contains(value + 1e-10 * (1.0 - value)), "but for rounding, choice {place}");
    }
    // What lies outside, and what is no number, are refused as they are of a number.
    check(hull.check(3.0), "parameter `hull`: the value is 3.0, expected 0.0 to 2.0 ");
    check(hull.check(-0.5), "parameter `hull`: the value is -0.5, expected 0.0 to 2.0 ");
    check(hull.check(f64::NAN), "parameter `hull`: the value is NaN, expected 0.0 to 2.0 ");
    // Who asks for the nearest gets a place, of two equally near the lower.
    let nearest =
        [(-7.0, 0.0), (0.3, 0.0), (0.5, 0.0), (0.6, 1.0), (1.0, 1.0), (1.4, 1.0), (1.5, 1.0), (1.6, 2.0), (9.0, 2.0)];
    for (value, place) in nearest {
        let moved = hull.clamp(value).unwrap();
        assert_eq!(moved.to_bits(), f64::to_bits(place), "{value} to {moved}");
    }
    assert_eq!(grid.digits(grid.nearest_clamped(&[10.0, 1.4]).unwrap()), Ok(vec![0, 1]));
}

#[test]
fn of_many_choices_a_message_names_the_first_and_the_last() {
    let names = (0..1000).map(|place| format!("c{place}"));
    let hull = Parameter::categorical("hull", names).unwrap();
    check(
        hull.check(0.5),
        "parameter `hull`: the value is 0.5, expected the place of a choice: 0 (c0), 1 (c1), 2 (c2), 3 (c3), 4 (c4), \
         5 (c5), 6 (c6), 7 (c7), and so on, or 999 (c999)",
    );
}
