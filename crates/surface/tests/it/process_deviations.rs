//! A simulation that is not quite known, against closed forms and against the factor that is learnt.

use std::sync::Arc;

use surface::process::{GaussianProcess, Hyperparameters, Places, Residual, SimulationUse, Sites, Structure};
use surface::{Data, Error};

use crate::check_close;

fn hyper(simulation: f64, noise: f64) -> Hyperparameters {
    let (lengths, assembly, additive) = (vec![0.6], 0.0, None);
    Hyperparameters { trend: 0.4, simulation, residual: 0.3, lengths, noise, assembly, additive }
}

fn simulation(x: f64) -> f64 {
    (3.0 * x).sin() + 0.3 * x
}

const MEASURED: [f64; 6] = [-0.9, -0.5, -0.1, 0.2, 0.2, 0.8];

fn sites(deviations: &[Vec<f64>]) -> Sites {
    let values = MEASURED.iter().enumerate().map(|(i, &x)| 2.0 + 1.3 * simulation(x) + 0.1 * (i % 3) as f64);
    let data = Data::new(1, MEASURED.to_vec(), values.collect()).expect("valid data");
    let simulated: Vec<f64> = MEASURED.map(simulation).to_vec();
    Sites::new(&data, Some(&simulated)).expect("valid data").with_deviations(deviations).expect("valid data")
}

fn places(points: &[f64], deviations: Vec<Vec<f64>>) -> Places {
    let places = Places::new(1, points).expect("valid data");
    let places = places.with_simulated(points.iter().map(|&x| simulation(x)).collect()).expect("valid data");
    places.with_deviations(deviations).expect("valid data")
}

/// To be off by what it says, less its mean, is to be multiplied by a factor that is not known.
#[test]
fn deviation_along_the_simulation_is_its_factor() {
    let points: Vec<f64> = (0..600).map(|i| -1.0 + i as f64 / 300.0).collect();
    // As places: the two measurements at 0.2 are one.
    let places_of_sites = [-0.9, -0.5, -0.1, 0.2, 0.8];
    let mean = places_of_sites.iter().map(|&x| simulation(x)).sum::<f64>() / 5.0;
    let factor = 0.35_f64;
    let along = |points: &[f64]| vec![points.iter().map(|&x| factor.sqrt() * (simulation(x) - mean)).collect()];
    for residual in [Residual::None, Residual::Smooth, Residual::Rough] {
        let of = |simulation| Structure { simulation, residual };
        let scaled =
            GaussianProcess::new(Arc::new(sites(&[])), of(SimulationUse::Scaled), hyper(factor, 0.02)).unwrap();
        let with = Arc::new(sites(&along(&MEASURED)));
        let off = GaussianProcess::new(with, of(SimulationUse::Subtracted), hyper(9.0, 0.02)).unwrap();
        check_close(off.log_likelihood(), scaled.log_likelihood(), 1e-11, "likelihood");
        let (here, there) = (places(&points, Vec::new()), places(&points, along(&points)));
        let (expected, found) = (
            scaled.marginals(&here).expect("places of the process"),
            off.marginals(&there).expect("places of the process"),
        );
        for place in 0..points.len() {
            check_close(found.means[place], expected.means[place], 1e-11, "mean");
            check_close(found.variances[place], expected.variances[place], 1e-11, "variance");
        }
        let some: Vec<usize> = (0..600).step_by(97).collect();
        let others = there.select(&some[..3]).followed_by(&there.select(&some[3..])).expect("as many factors");
        let (expected, found) = (
            scaled.joint(&here.select(&some)).expect("places of the process"),
            off.joint(&others).expect("places of the process"),
        );
        let contrast = off.contrast(&others).expect("places of the process");
        for row in 0..some.len() {
            check_close(contrast.means[row], expected.means()[row] - expected.means()[0], 1e-11, "difference");
            for column in 0..some.len() {
                check_close(found.covariances(row)[column], expected.covariances(row)[column], 1e-11, "covariance");
            }
        }
    }
}

/// By hand, from one measurement without a trend: the constant has the variance 4, and a deviation its own square.
#[test]
fn one_measurement_tells_of_a_deviation_what_it_must() {
    let data = Data::new(1, vec![0.5], vec![1.7]).unwrap();
    let hyper = Hyperparameters { trend: 0.0, ..hyper(0.0, 0.1) };
    let structure = Structure { simulation: SimulationUse::Subtracted, residual: Residual::None };
    let (here, there) = ([0.8, -0.3], [-1.1, 0.6]);
    let of = |deviations: [f64; 2]| deviations.map(|deviation| vec![deviation]).to_vec();
    let sites =
        Sites::new(&data, Some(&[0.4])).unwrap().in_units(0.0, 1.0).unwrap().with_deviations(&of(here)).unwrap();
    let process = GaussianProcess::new(Arc::new(sites), structure, hyper).unwrap();
    let place = Places::new(1, &[-0.2]).unwrap().with_simulated(vec![0.9]).unwrap().with_deviations(of(there)).unwrap();
    let dot = |a: [f64; 2], b: [f64; 2]| 4.0 + a[0] * b[0] + a[1] * b[1];
    let own = dot(here, here) + 0.1;
    let found = process.marginals(&place).expect("places of the process");
    // Simulated responses count from their mean at the measurements, 0.4.
    check_close(found.means[0], 0.5 + dot(here, there) / own * 1.7, 1e-14, "mean");
    check_close(found.variances[0], dot(there, there) - dot(here, there).powi(2) / own, 1e-14, "variance");
}

/// What is as unknown everywhere as the residual varies, and as smooth, is one.
#[test]
fn unknown_part_of_the_simulation_is_a_residual_of_the_length_one() {
    let points: Vec<f64> = (0..150).map(|i| -1.0 + i as f64 / 75.0).collect();
    let hyper = Hyperparameters { lengths: vec![1.0], ..hyper(0.2, 0.02) };
    let of = |residual| Structure { simulation: SimulationUse::Scaled, residual };
    let scale = sites(&[]);
    let values: Vec<f64> =
        MEASURED.iter().enumerate().map(|(i, &x)| 2.0 + 1.3 * simulation(x) + 0.1 * (i % 3) as f64).collect();
    let mean = values.iter().sum::<f64>() / 6.0;
    let unit = (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / 6.0).sqrt();
    let unknown = |n: usize| vec![unit * 0.3_f64.sqrt(); n];
    let plain = GaussianProcess::new(Arc::new(scale.clone()), of(Residual::Smooth), hyper.clone()).unwrap();
    let sites = Arc::new(scale.with_unknown(&unknown(6)).unwrap());
    let found = GaussianProcess::new(sites, of(Residual::None), hyper).unwrap();
    check_close(found.log_likelihood(), plain.log_likelihood(), 1e-10, "likelihood");
    let here = places(&points, Vec::new());
    let there = here.clone().with_unknown(unknown(150)).unwrap();
    let (expected, with) = (
        plain.marginals(&here).expect("places of the process"),
        found.marginals(&there).expect("places of the process"),
    );
    for place in 0..points.len() {
        check_close(with.means[place], expected.means[place], 1e-10, "mean");
        check_close(with.variances[place], expected.variances[place], 1e-10, "variance");
    }
    let some: Vec<usize> = (0..150).step_by(31).collect();
    // One of them all of which is known, the others in two halves.
    let known = here.select(&[7]);
    let halves = there.select(&some[..2]).followed_by(&there.select(&some[2..]));
    let all = halves.and_then(|halves| known.followed_by(&halves)).expect("as many factors");
    let joint = found.joint(&all).expect("places of the process");
    let expected = plain.joint(&here.select(&some)).expect("places of the process");
    for row in 0..some.len() {
        for column in 0..some.len() {
            let covariance = joint.covariances(row + 1)[column + 1];
            check_close(covariance, expected.covariances(row)[column], 1e-10, "covariance");
        }
    }
    check_close(
        joint.variance(0),
        found.joint(&known).expect("places of the process").variance(0),
        1e-12,
        "of which all is known",
    );
}

/// Who makes nothing of the simulation does not care what it is off by.
#[test]
fn deviations_of_what_is_ignored_do_not_matter() {
    let structure = Structure { simulation: SimulationUse::Ignored, residual: Residual::Smooth };
    let off = vec![vec![0.7, -0.2, 1.0, 0.4, 0.4, -0.9]];
    let of = |deviations: &[Vec<f64>]| {
        let process = GaussianProcess::new(Arc::new(sites(deviations)), structure, hyper(0.2, 0.02)).unwrap();
        process.marginals(&places(&MEASURED, deviations.to_vec())).expect("places of the process")
    };
    assert_eq!(of(&off), of(&[]));
}

#[test]
fn places_are_moved_to_the_edge_of_the_box_at_most() {
    let places = Places::new(2, &[0.1, 0.2, -0.9, 0.8]).unwrap().with_simulated(vec![1.0, 2.0]).unwrap();
    let moved = places.moved(&[-0.3, 0.25]);
    assert_eq!(
        moved,
        Places::new(2, &[0.1 - 0.3, 0.2 + 0.25, -1.0, 1.0]).unwrap(),
        "what is simulated there is not known"
    );
}

#[test]
fn deviations_that_cannot_be_are_told() {
    let length = |found| Error::Length { name: "deviations of simulated responses", expected: 2, found };
    let simulated = Places::new(1, &[0.1, 0.4]).unwrap().with_simulated(vec![1.0, 2.0]).unwrap();
    assert_eq!(simulated.clone().with_deviations(vec![vec![1.0, 2.0], vec![1.0]]), Err(length(1)));
    let error = simulated.clone().with_deviations(vec![vec![1.0, f64::NAN]]);
    assert!(matches!(error, Err(Error::Value { point: 1, .. })), "{error:?}");
    let error = Places::new(1, &[0.1, 0.4]).unwrap().with_deviations(vec![vec![1.0, 2.0]]);
    assert!(matches!(error, Err(Error::Length { expected: 0, found: 2, .. })), "nothing is simulated: {error:?}");
    let data = Data::new(1, vec![0.2, 0.2, 0.5], vec![1.0, 1.1, 2.0]).unwrap();
    let sites = Sites::new(&data, Some(&[0.0, 0.0, 1.0])).unwrap();
    let error = sites.clone().with_deviations(&[vec![1.0, 1.0]]);
    assert!(matches!(error, Err(Error::Length { expected: 3, found: 2, .. })), "one a measurement: {error:?}");
    assert_eq!(sites.clone().with_deviations(&[vec![1.0, 1.0, 3.0]]).unwrap().places().deviations(), [[1.0, 3.0]]);
    let error = Places::new(1, &[0.1, 0.4]).unwrap().with_unknown(vec![1.0, 2.0]);
    assert!(matches!(error, Err(Error::Length { expected: 0, found: 2, .. })), "nothing is simulated: {error:?}");
    let error = simulated.clone().with_unknown(vec![0.0, -1.0]);
    assert!(matches!(error, Err(Error::Value { point: 1, .. })), "{error:?}");
    assert!(simulated.with_unknown(vec![0.0; 2]).unwrap().unknown().is_empty(), "all is known");
    let error = sites.clone().with_unknown(&[1.0, 1.0]);
    assert!(matches!(error, Err(Error::Length { expected: 3, found: 2, .. })), "one a measurement: {error:?}");
    assert_eq!(sites.clone().with_unknown(&[1.0, 1.0, 3.0]).unwrap().places().unknown(), [1.0, 3.0]);
    // Of a slope next to it nothing is known.
    let off = vec![vec![0.7, -0.2, 1.0, 0.4, 0.4, -0.9]];
    let of = |simulation| Structure { simulation, residual: Residual::Smooth };
    let place = places(&[0.3], vec![vec![0.5]]);
    for (simulation, is_refused) in [(SimulationUse::Scaled, true), (SimulationUse::Ignored, false)] {
        let process = GaussianProcess::new(Arc::new(self::sites(&off)), of(simulation), hyper(0.2, 0.02)).unwrap();
        assert_eq!(process.gradient(&place, Some(&[0.0])).is_err(), is_refused, "{simulation:?}");
    }
}
