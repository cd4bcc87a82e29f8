//! Structures and their covariances before anything was measured.

use std::collections::HashSet;

use surface::Error;
use surface::process::{Additive, Covariance, Hyperparameters, Places, SimulationUse, Structure};

use crate::check_close;

#[test]
fn nine_structures_are_all_there_are_and_the_first_three_ignore_the_simulation() {
    let different: HashSet<Structure> = Structure::ALL.into_iter().collect();
    assert_eq!(different.len(), 9, "three uses of the simulation with three residuals");
    for (position, structure) in Structure::ALL.into_iter().enumerate() {
        assert_eq!(structure.simulation == SimulationUse::Ignored, position < 3, "number {position}: {structure:?}");
    }
}

/// The variance of a place is its covariance with itself, and a constant adds 4 to every one of them.
#[test]
fn variances_are_covariances_with_oneself_and_the_constant_adds_four_to_all() {
    let places = Places::new(2, &[0.2, 0.1, -0.9, 0.8, 0.5, -0.3])
        .and_then(|places| places.with_simulated(vec![0.4, -1.0, 2.0]))
        .expect("valid places");
    let hyper = Hyperparameters {
        trend: 0.7,
        simulation: 0.3,
        residual: 1.1,
        lengths: vec![0.5, 1.5],
        noise: 0.2,
        assembly: 0.0,
        additive: Some(Additive { axes: vec![1], variance: 0.9, lengths: vec![0.6] }),
    };
    for structure in Structure::ALL {
        let with = Covariance::of(structure, &hyper).expect("lengths of two axes");
        let without = with.clone().without_constant();
        let [all, rest] = [&with, &without].map(|covariance| covariance.between(&places, &places).expect("two axes"));
        let [of_all, of_rest] = [&with, &without].map(|covariance| covariance.variances(&places).expect("two axes"));
        for (place, (of_all, of_rest)) in of_all.iter().zip(of_rest).enumerate() {
            let what = format!("{structure:?}, place {place}");
            check_close(*of_all, all[(place, place)], 1e-14, &what);
            check_close(of_rest, rest[(place, place)], 1e-14, &what);
            for other in 0..3 {
                check_close(all[(place, other)] - rest[(place, other)], 4.0, 1e-14, &what);
            }
        }
    }
}

/// One length for two axes left the second out, three were a panic, and so was an axis that is not there.
#[test]
fn hyperparameters_and_places_that_do_not_belong_together_are_refused() {
    let of_lengths = |lengths: Vec<f64>, additive| Hyperparameters {
        trend: 0.7,
        simulation: 0.3,
        residual: 1.1,
        lengths,
        noise: 0.2,
        assembly: 0.0,
        additive,
    };
    let structure = Structure::ALL[1];
    let two = Places::new(2, &[0.2, 0.1]).expect("a place");
    for n_lengths in [1, 3] {
        let hyper = of_lengths(vec![0.5; n_lengths], None);
        let covariance = Covariance::of(structure, &hyper).expect("hyperparameters of some axes");
        let others = Places::new(n_lengths, &vec![0.2; n_lengths]).expect("a place");
        let mismatch = |found| Error::FactorMismatch { what: "the places", expected: n_lengths, found };
        assert_eq!(covariance.variances(&two), Err(mismatch(2)));
        for (rows, columns) in [(&two, &two), (&others, &two), (&two, &others)] {
            let found = covariance.between(rows, columns).expect_err("another number of axes");
            assert_eq!(found, mismatch(2), "{n_lengths} lengths");
        }
    }
    let additive = |axes: Vec<usize>, n_lengths| Some(Additive { axes, variance: 0.9, lengths: vec![0.6; n_lengths] });
    let refused = |hyper: Hyperparameters| Covariance::of(structure, &hyper).expect_err("refused").to_string();
    assert!(refused(of_lengths(vec![0.5; 2], additive(vec![2], 1))).contains("`axis of the additive part` is 2.0"));
    assert_eq!(
        refused(of_lengths(vec![0.5; 2], additive(vec![1], 2))),
        "number of lengths of the additive part: 2, expected 1"
    );
    assert!(refused(of_lengths(vec![0.5, 0.0], None)).contains("`length` is 0.0"));
    assert!(refused(of_lengths(vec![], None)).contains("number of factors: 0"));
}

#[test]
fn places_of_another_number_of_factors_do_not_follow() {
    let one = Places::new(1, &[0.2, 0.1]).expect("two places");
    let two = Places::new(2, &[0.2, 0.1]).expect("a place");
    assert_eq!(
        two.followed_by(&one),
        Err(Error::FactorMismatch { what: "the places that follow", expected: 2, found: 1 })
    );
    assert_eq!(
        one.followed_by(&two).map(|both| both.n_places()),
        Err(Error::FactorMismatch { what: "the places that follow", expected: 1, found: 2 })
    );
}
