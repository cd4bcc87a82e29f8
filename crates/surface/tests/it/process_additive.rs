//! A part of the response that depends on some axes alone: closed forms, refusals, and what is learnt of drawn ones.

use std::sync::Arc;

use faer::Mat;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use surface::process::{
    Additive, AveragedProcess, Covariance, GaussianProcess, Hyperparameters, Places, Residual, SamplerSettings,
    SimulationUse, Sites, Structure,
};
use surface::{Data, Error};

use crate::check_close;

const fn structure(residual: Residual) -> Structure {
    Structure { simulation: SimulationUse::Ignored, residual }
}

fn hyper(additive: Option<Additive>) -> Hyperparameters {
    let lengths = vec![0.7, 1.3, 0.4];
    Hyperparameters { trend: 0.0, simulation: 0.0, residual: 0.6, lengths, noise: 0.1, assembly: 0.0, additive }
}

fn covariance(structure: Structure, hyper: &Hyperparameters, places: &Places) -> Mat<f64> {
    Covariance::of(structure, hyper).and_then(|covariance| covariance.between(places, places)).expect("three axes")
}

/// Matérn-5/2 of √5 d and Matérn-3/2 of √3 d, of the distance along the named axes alone; a constant has the variance 4.
#[test]
fn covariance_is_that_along_its_axes_beside_the_residual() {
    let points = [[0.3, -0.5, 0.9], [0.3, 0.8, -0.2], [-0.6, -0.5, 0.9]];
    let places = Places::new(3, &points.concat()).expect("valid places");
    let additive = Additive { axes: vec![2, 0], variance: 1.7, lengths: vec![0.5, 2.0] };
    let (own, with) = (hyper(None), hyper(Some(additive)));
    for (residual, matern) in [
        (
            Residual::Smooth,
            (|d: f64| (1.0 + 5f64.sqrt() * d + 5.0 * d * d / 3.0) * (-5f64.sqrt() * d).exp()) as fn(f64) -> f64,
        ),
        (Residual::Rough, |d: f64| (1.0 + 3f64.sqrt() * d) * (-3f64.sqrt() * d).exp()),
    ] {
        let of = |hyper: &Hyperparameters| covariance(structure(residual), hyper, &places);
        let (without, all) = (of(&own), of(&with));
        for (row, a) in points.iter().enumerate() {
            for (column, b) in points.iter().enumerate() {
                let distance = ((a[2] - b[2]) / 0.5).hypot((a[0] - b[0]) / 2.0);
                let expected = 1.7 * matern(distance);
                check_close(all[(row, column)] - without[(row, column)], expected, 1e-12, "the additive part");
            }
        }
    }
    // Of a polynomial it is the only part that is none, and smooth.
    let of_none = covariance(structure(Residual::None), &with, &places);
    check_close(
        of_none[(0, 2)],
        4.0 + 1.7 * (1.0 + 5f64.sqrt() * 0.45 + 5.0 * 0.45 * 0.45 / 3.0) * (-5f64.sqrt() * 0.45).exp(),
        1e-12,
        "of a polynomial",
    );
}

#[test]
fn axes_that_are_not_there_and_lengths_that_are_missing_are_refused_by_name() {
    let data = Data::new(3, vec![0.0; 3], vec![1.0]).expect("valid data");
    let sites = Sites::new(&data, None).expect("valid sites");
    for axes in [vec![3], vec![1, 1]] {
        let found = sites.clone().with_additive(axes.clone());
        assert!(matches!(found, Err(Error::Parameter { name: "axis of the additive part", .. })), "{axes:?} {found:?}");
        let wrong = hyper(Some(Additive { lengths: vec![1.0; axes.len()], axes, variance: 1.0 }));
        let found = GaussianProcess::new(Arc::new(sites.clone()), structure(Residual::Smooth), wrong);
        assert!(matches!(found, Err(Error::Parameter { name: "axis of the additive part", .. })));
    }
    let short = hyper(Some(Additive { axes: vec![0, 1], variance: 1.0, lengths: vec![1.0] }));
    let found = GaussianProcess::new(Arc::new(sites), structure(Residual::Smooth), short);
    assert!(matches!(found, Err(Error::Length { name: "lengths of the additive part", .. })));
}

/// Nine settings along the first axis, four runs each in assemblies of their own: a sine of three periods is no error of assemblies
/// where most were put together twice, and is found again at settings of the second axis that nobody ran.
#[test]
fn what_an_axis_does_alone_is_told_from_the_error_of_assemblies() {
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    let truth = |x: f64, z: f64| (9.0 * x).sin() + 0.4 * (z - 0.2 * x).powi(2);
    let (mut coordinates, mut values, mut assemblies) = (Vec::new(), Vec::new(), Vec::new());
    let settings = || (0..9).map(|level| -1.0 + 0.25 * f64::from(level));
    for (assembly, x) in settings().chain(settings().step_by(2)).enumerate() {
        for _ in 0..3 {
            let z = 2.0 * rng.random::<f64>() - 1.0;
            coordinates.extend([x, z]);
            values.push(truth(x, z) + 0.02 * (rng.random::<f64>() - 0.5));
            assemblies.push(assembly);
        }
    }
    let data = Data::new(2, coordinates, values).expect("valid data");
    let sites = Sites::in_assemblies(&data, None, &assemblies).expect("valid sites");
    let process = |sites: Sites| AveragedProcess::new(sites, &SamplerSettings::default()).expect("a process");
    let [without, with] = [process(sites.clone()), process(sites.with_additive(vec![0]).expect("an axis"))];
    let unseen: Vec<[f64; 2]> = settings().flat_map(|x| [[x, -0.97], [x, 0.03], [x, 0.97]]).collect();
    let places = Places::new(2, &unseen.concat()).expect("valid places");
    let error = |process: &AveragedProcess| {
        let squares = process
            .means(&places)
            .expect("places of the process")
            .into_iter()
            .zip(&unseen)
            .map(|(mean, at)| (mean - truth(at[0], at[1])).powi(2));
        (squares.sum::<f64>() / unseen.len() as f64).sqrt()
    };
    let (apart, together) = (error(&without), error(&with));
    assert!(together < 0.1 && together < 0.5 * apart, "{together} with it, {apart} without");
    assert!(with.assembly_deviation() < 0.15, "{}", with.assembly_deviation());
}
