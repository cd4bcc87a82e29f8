//! Structures and their covariances before anything was measured.

use std::collections::HashSet;

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
        let with = Covariance::of(structure, &hyper);
        let without = with.clone().without_constant();
        let (all, rest) = (with.between(&places, &places), without.between(&places, &places));
        for (place, (of_all, of_rest)) in with.variances(&places).iter().zip(without.variances(&places)).enumerate() {
            let what = format!("{structure:?}, place {place}");
            check_close(*of_all, all[(place, place)], 1e-14, &what);
            check_close(of_rest, rest[(place, place)], 1e-14, &what);
            for other in 0..3 {
                check_close(all[(place, other)] - rest[(place, other)], 4.0, 1e-14, &what);
            }
        }
    }
}
