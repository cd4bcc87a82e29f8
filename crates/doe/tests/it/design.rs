//! Designs, against hand counts.

use doe::{Design, Error, Parameter, Region};

#[test]
fn designs_keep_through_files() {
    let design = Design::new(2, vec![0.1, -1.0, 1.0 / 3.0, 1.0]).unwrap();
    let text = toml::to_string(&design).unwrap();
    assert_eq!(toml::from_str::<Design>(&text).unwrap(), design);
}

#[test]
fn designs_go_to_natural_units_and_back() {
    let pitch = Parameter::continuous("pitch", "deg", 10.0, 22.0).unwrap().with_levels(13).unwrap();
    let region = Region::new(vec![pitch]).unwrap();
    let natural = [[10.0], [13.0], [22.0]];
    let design = Design::from_natural(&region, &natural).unwrap();
    assert_eq!(design.coordinates(), [-1.0, -0.5, 1.0]);
    assert_eq!(design.natural(&region).unwrap(), natural);
    assert!(matches!(
        Design::from_natural(&region, &[[23.0]]),
        Err(Error::DesignSpace(doe::DesignSpaceError::OutOfBounds { .. }))
    ));
}

#[test]
fn refuses_designs_that_are_none() {
    assert!(matches!(Design::new(2, vec![]), Err(Error::Count { .. })));
    assert_eq!(Design::new(2, vec![1.0]), Err(Error::RaggedPoints { n_factors: 2, n_coordinates: 1 }));
    let error = Design::new(2, vec![0.0, 1.0, f64::NAN, 0.0]).unwrap_err();
    assert_eq!(error.to_string(), "coordinate 1 of point 2 is NaN, expected a finite number");
    assert!(Design::from_runs(&[vec![1.0, 2.0], vec![1.0]]).is_err(), "ragged");
}

#[test]
fn replicates_are_pairs_of_equal_runs() {
    let design = Design::from_runs(&[[0.0, 1.0], [1.0, 1.0], [0.0, 1.0 + 1e-9], [0.0, 1.0]]).unwrap();
    assert_eq!(design.replicates(1e-6), [(0, 2), (0, 3), (2, 3)]);
    assert_eq!(design.replicates(0.0), [(0, 3)]);
}
